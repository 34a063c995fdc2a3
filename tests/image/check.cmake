# Runs a program that renders an image and compares it with the reference:
# cmake -DCOMMAND=program;arguments -DOUTPUT=out.png -DREFERENCE=ref.png -DCOMPARE=compare_png
#       -DMAX=number -DMEAN=number -P check.cmake
file(REMOVE ${OUTPUT})
execute_process(COMMAND ${COMMAND} RESULT_VARIABLE result)
if(NOT result EQUAL 0)
    message(FATAL_ERROR "${COMMAND} ended with ${result}")
endif()
execute_process(COMMAND ${COMPARE} ${OUTPUT} ${REFERENCE} ${MAX} ${MEAN} RESULT_VARIABLE result)
if(NOT result EQUAL 0)
    message(FATAL_ERROR "${OUTPUT} is not ${REFERENCE}")
endif()
