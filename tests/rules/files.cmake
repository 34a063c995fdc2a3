# Every source file carries the SPDX line and stays under 1,000 lines. One file may be longer:
# run-time compilers get headers by the names of OptiX, so it cannot be split.
set(failures 0)
file(GLOB_RECURSE sources
    ${SOURCE_DIR}/src/*.h ${SOURCE_DIR}/src/*.cpp ${SOURCE_DIR}/src/*.cu ${SOURCE_DIR}/include/*.h ${SOURCE_DIR}/samples/*.h
    ${SOURCE_DIR}/samples/*.cpp ${SOURCE_DIR}/samples/*.cu ${SOURCE_DIR}/tools/*.h ${SOURCE_DIR}/tools/*.cpp
    ${SOURCE_DIR}/bench/*.h ${SOURCE_DIR}/bench/*.cpp ${SOURCE_DIR}/bench/*.cu ${SOURCE_DIR}/tests/*.cpp
    ${SOURCE_DIR}/tests/*.h ${SOURCE_DIR}/tests/*.cu)
foreach(file ${sources})
    file(STRINGS ${file} first LIMIT_COUNT 1)
    if(NOT first MATCHES "SPDX-License-Identifier: Apache-2.0")
        message("${file}: the first line is not the SPDX line")
        math(EXPR failures "${failures} + 1")
    endif()
    file(READ ${file} text)
    string(REGEX MATCHALL "\n" newlines "${text}")
    list(LENGTH newlines length)
    if(length GREATER 1000 AND NOT file MATCHES "/include/optix7/optix_7_types.h$")
        message("${file}: ${length} lines are more than 1,000")
        math(EXPR failures "${failures} + 1")
    endif()
endforeach()
if(failures)
    message(FATAL_ERROR "${failures} files break the rules")
endif()
