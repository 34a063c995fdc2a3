set pagination off
set confirm off
set breakpoint pending on
set width 0
break inlined.cu:12
run
backtrace 3
print result
up
print kept
print first
up
print index
delete
break inlined.cu:33
continue
print to
print this->added
delete
continue
