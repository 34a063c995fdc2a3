set pagination off
set confirm off
set breakpoint pending on
set width 0
break kernel.cu:14
run
print sum
print i
print term
print count
break kernel.cu:6
continue
print value
print result
backtrace 2
delete
break kernel.cu:16
continue
print sum
delete
continue
