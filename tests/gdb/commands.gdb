set pagination off
set confirm off
set breakpoint pending on
set width 0
break device.cu:23
run
info locals
print sum
print weights
print pair
next
print sum
print params.bias
break device.cu:12
continue
print value
print result
print params.bias
backtrace 2
delete
break device.cu:26
continue
print sum
print pair.first
print *params.out
delete
continue
