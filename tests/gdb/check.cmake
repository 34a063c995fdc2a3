# Runs the host under gdb with its commands and compares gdb's output with the expected text.
# -DGDB= -DHOST= -DPTX= -DCOMMANDS= -DEXPECTED=
execute_process(COMMAND ${CMAKE_COMMAND} -E env OPTIX_CACHE_MAXSIZE=0 DEBUGINFOD_URLS=
    ${GDB} -nx -batch -x ${COMMANDS} --args ${HOST} ${PTX}
    OUTPUT_VARIABLE output ERROR_VARIABLE errors TIMEOUT 100)
if(errors MATCHES "ptrace: Operation not permitted")
    message("SKIPPED: gdb may not trace processes here")
    return()
endif()
include(${EXPECTED})
set(missing "")
foreach(text IN LISTS expected)
    if(NOT output MATCHES "${text}")
        list(APPEND missing "${text}")
    endif()
endforeach()
if(missing)
    message(FATAL_ERROR "gdb did not say: ${missing}\n--- output\n${output}\n--- errors\n${errors}")
endif()
