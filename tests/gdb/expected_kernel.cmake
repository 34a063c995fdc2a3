# Output of gdb for kernel.gdb.
set(expected
    # first stop: in the loop, before the sum changes
    "Breakpoint 1, [^\n]*accumulate[^\n]*kernel.cu:14"
    "14[^\n]*sum \\+= term"
    "\\$1 = 100"
    "\\$2 = 0\n"
    "\\$3 = 1\n"
    "\\$4 = 3\n"
    # in the function that is called, second round
    "Breakpoint 2, [^\n]*doubled[^\n]*value=1[^\n]*kernel.cu:6"
    "\\$5 = 1\n"
    "\\$6 = 2\n"
    "#0 +[^\n]*doubled[^\n]*kernel.cu:6"
    "#1 +[^\n]*accumulate[^\n]*kernel.cu:13"
    # behind the loop
    "\\$7 = 109"
    "result 109")
