# Output of gdb for inlined_lines.gdb where .loc directives alone name inlined functions.
set(expected
    "Breakpoint 1, [^\n]*square[^\n]*inlined.cu:12"
    "#0 [^\n]*square[^\n]*inlined.cu:12"
    "#1 [^\n]*outer[^\n]*inlined.cu:18"
    "#2 [^\n]*__raygen__debug[^\n]*inlined.cu:40"
    "result 112")
