set pagination off
set confirm off
set breakpoint pending on
set width 0
break debug.cu:23
run
info locals
print sum
print weights
print pair
next
print sum
break debug.cu:12
continue
print value
print result
backtrace 2
delete
break debug.cu:26
continue
print sum
print pair.first
delete
continue
