# Output of gdb for commands.gdb.
set(expected
    # first stop: in the loop, before the sum changes
    "Breakpoint 1, [^\n]*__raygen__debug[^\n]*device.cu:23"
    "23[^\n]*sum \\+= term"
    "\\$1 = 100"
    "\\$2 = {1.5, 2.5, 4}"
    "\\$3 = {first = 7, second = -2.5}"
    "\\$4 = 101"
    "\\$5 = 100\n" # of the launch parameters
    # in the function that is called, second round
    "Breakpoint 2, [^\n]*twice[^\n]*value=1[^\n]*device.cu:12"
    "\\$6 = 1\n"
    "\\$7 = 2\n"
    "\\$8 = 100\n"
    "#0 +[^\n]*twice[^\n]*device.cu:12"
    "#1 +[^\n]*__raygen__debug[^\n]*device.cu:22"
    # behind the loop
    "\\$9 = 113"
    "\\$10 = 120"
    "\\$11 = 0\n"
    "result 233"
    "term = 0")
