# ctest's run of one program: a small picture on the CPU device, and one through the back end for GPUs,
# which must agree.
#   cmake -DPROGRAM=bench_programs -DNAME=gbuffer -DFOLDER=scratch -P check.cmake
file(REMOVE_RECURSE ${FOLDER})
file(MAKE_DIRECTORY ${FOLDER})
foreach(label cpu gpu)
    if(label STREQUAL gpu)
        set(ENV{SUNSTONE_GPU_BACK_END} cpu-device)
    endif()
    execute_process(COMMAND ${PROGRAM} --program ${NAME} --scale 0.0005 --width 48 --height 32 --repeats 1
        --label ${label} --out ${FOLDER} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
execute_process(COMMAND ${PROGRAM} --report ${FOLDER} --reference cpu --label gpu
    OUTPUT_VARIABLE table RESULT_VARIABLE result)
if(NOT result EQUAL 0 OR NOT table MATCHES "\\| ${NAME} \\|[^\n]* mean [0-9.e-]+, pixels")
    message(FATAL_ERROR "the pictures differ:\n${table}")
endif()
