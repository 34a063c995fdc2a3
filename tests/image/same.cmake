# Runs COMMAND with rays alone and in batches (SUNSTONE_RAYS); both pictures must have the same bytes.
foreach(way alone batches)
    execute_process(COMMAND ${CMAKE_COMMAND} -E env SUNSTONE_RAYS=${way} ${COMMAND} -o ${OUTPUT}_${way}.png
        RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
    if(NOT result EQUAL 0)
        message(FATAL_ERROR "${way}: ${result}\n${output}")
    endif()
    file(SHA256 ${OUTPUT}_${way}.png ${way})
endforeach()
if(NOT alone STREQUAL batches)
    message(FATAL_ERROR "${OUTPUT}_alone.png and ${OUTPUT}_batches.png differ")
endif()
