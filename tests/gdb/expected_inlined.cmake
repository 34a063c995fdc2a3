# Output of gdb for inlined.gdb where the PTX has DWARF sections with inlined functions: frames and
# their variables.
set(expected
    "Breakpoint 1, [^\n]*square[^\n]*inlined.cu:12"
    "#0 [^\n]*square[^\n]*inlined.cu:12"
    "#1 [^\n]*outer[^\n]*inlined.cu:18"
    "#2 [^\n]*__raygen__debug[^\n]*inlined.cu:40"
    "\\$1 = 9\n"
    "\\$2 = 3\n"
    "\\$3 = 0\n"
    "\\$4 = 0\n"
    "Breakpoint 2, [^\n]*operator\\(\\)[^\n]*inlined.cu:33"
    "\\$5 = 107\n"
    "\\$6 = 5\n"
    "result 112")
