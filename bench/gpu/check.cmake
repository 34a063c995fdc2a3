# ctest's run of bench_gpu on the CPU device: two runs on small scenes, where the second must find
# the hits of the first, and the table.
#   cmake -DPROGRAM=bench_gpu -DFOLDER=scratch -P check.cmake
file(REMOVE_RECURSE ${FOLDER})
file(MAKE_DIRECTORY ${FOLDER})
foreach(label reference sunstone)
    execute_process(COMMAND ${PROGRAM} --scale 0.002 --width 64 --height 64 --repeats 1
        --hits ${FOLDER}/hits --label ${label} --json ${FOLDER}/${label}.json
        COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
endforeach()
execute_process(COMMAND ${PROGRAM} --scene compile-cold --label sunstone
    --json ${FOLDER}/compile.json COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
foreach(scene first-build-cold first-motion-cold first-build-cached)
    execute_process(COMMAND ${PROGRAM} --scene ${scene} --label sunstone --cache ${FOLDER}/cache
        --json ${FOLDER}/${scene}.json COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
endforeach()
execute_process(COMMAND ${PROGRAM} --report "${FOLDER}/reference.json ${FOLDER}/sunstone.json"
    OUTPUT_VARIABLE table RESULT_VARIABLE missed) # it has not to be faster than itself
if(NOT missed MATCHES "^[01]$" OR NOT table MATCHES "hits differ[^\n]*: none")
    message(FATAL_ERROR "two runs on one library differ:\n${table}")
endif()
foreach(row "1 M custom spheres . diffuse" "leaves 1 M, any-hit . shadow"
        "100 k instances . primary" "path tracer 1 M . frame" "recursion 1 M . frame"
        "terrain 2 M . compacted, random"
        "moving triangles 1 M . AO" "100 k moving instances . diffuse")
    string(REPLACE " . " " \\| " row "${row}")
    if(NOT table MATCHES "${row}")
        message(FATAL_ERROR "no row '${row}' in:\n${table}")
    endif()
endforeach()
execute_process(COMMAND ${PROGRAM} --report ${FOLDER}/hits.path_tracer RESULT_VARIABLE result
    ERROR_VARIABLE text)
if(NOT result EQUAL 1 OR NOT text MATCHES "no file of bench_gpu")
    message(FATAL_ERROR "a file of another form: ${result} ${text}")
endif()
