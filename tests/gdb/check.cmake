# Runs the host under gdb with commands.gdb and looks for what gdb must have said.
# -DGDB= -DHOST= -DPTX= -DCOMMANDS=
execute_process(COMMAND ${CMAKE_COMMAND} -E env OPTIX_CACHE_MAXSIZE=0 DEBUGINFOD_URLS=
    ${GDB} -nx -batch -x ${COMMANDS} --args ${HOST} ${PTX}
    OUTPUT_VARIABLE output ERROR_VARIABLE errors TIMEOUT 100)
if(errors MATCHES "ptrace: Operation not permitted")
    message("SKIPPED: gdb may not trace processes here")
    return()
endif()
set(missing "")
foreach(expected IN ITEMS
    # first stop: in the loop, before the sum changes
    "Breakpoint 1, [^\n]*__raygen__debug[^\n]*device.cu:23"
    "23[^\n]*sum \\+= term"
    "\\$1 = 100"
    "\\$2 = {1.5, 2.5, 4}"
    "\\$3 = {first = 7, second = -2.5}"
    "\\$4 = 101"
    # in the function that is called, second round
    "Breakpoint 2, [^\n]*twice[^\n]*value=1[^\n]*device.cu:12"
    "\\$5 = 1\n"
    "\\$6 = 2\n"
    "#0 +[^\n]*twice[^\n]*device.cu:12"
    "#1 +[^\n]*__raygen__debug[^\n]*device.cu:22"
    # behind the loop
    "\\$7 = 113"
    "\\$8 = 120"
    "result 233"
    "term = 0")
    if(NOT output MATCHES "${expected}")
        list(APPEND missing "${expected}")
    endif()
endforeach()
if(missing)
    message(FATAL_ERROR "gdb did not say: ${missing}\n--- output\n${output}\n--- errors\n${errors}")
endif()
