# `sunstone warm` on what counts as a GPU: the first run fills the cache, the second adds nothing.
#   cmake -DPROGRAM=sunstone -DFOLDER=scratch -P warm.cmake
file(REMOVE_RECURSE ${FOLDER})
file(MAKE_DIRECTORY ${FOLDER})
set(ENV{OPTIX_CACHE_PATH} ${FOLDER})
set(ENV{OPTIX_CACHE_MAXSIZE} 1073741824)
foreach(round first second)
    execute_process(COMMAND ${PROGRAM} warm OUTPUT_VARIABLE out COMMAND_ERROR_IS_FATAL ANY)
    if(NOT out MATCHES "compute capability [0-9]+.[0-9]+.: ready after ([0-9.]+) s")
        message(FATAL_ERROR "${round}: ${out}")
    endif()
    file(GLOB files ${FOLDER}/*)
    set(bytes_${round} 0)
    foreach(file IN LISTS files)
        file(SIZE ${file} size)
        math(EXPR bytes_${round} "${bytes_${round}} + ${size}")
    endforeach()
endforeach()
# The stand-in's machine code is the text: megabytes, once.
math(EXPR most "${bytes_first} + 65536") # files of the database beside the entries
if(bytes_first LESS 1000000 OR bytes_second GREATER ${most})
    message(FATAL_ERROR "the cache has ${bytes_first} bytes, then ${bytes_second}")
endif()
