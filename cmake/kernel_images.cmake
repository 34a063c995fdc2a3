# Machine code of the library's own kernels, compiled by ptxas if it is found (tools/kernel_images).
# sunstone_kernels(FILE ids) names a PTX file of kernels and their ids, in which @ stands for the
# kernel's name; sunstone_kernel_images(outvar) makes the archive of all files named so far.
find_library(SUNSTONE_ZSTD NAMES libzstd.a zstd REQUIRED)
find_program(SUNSTONE_PTXAS NAMES ptxas HINTS /usr/local/cuda/bin)
# Code for 8.0 runs on 8.6 to 8.9, code for 10.0 on 10.3, code for 12.0 on 12.1.
set(SUNSTONE_KERNEL_CAPABILITIES 70,75,80,90,100,120)
define_property(GLOBAL PROPERTY SUNSTONE_KERNEL_FILES BRIEF_DOCS "files, each followed by the form of its ids")

function(sunstone_kernels file ids)
    set_property(GLOBAL APPEND PROPERTY SUNSTONE_KERNEL_FILES ${file} ${ids})
endfunction()

function(sunstone_kernel_images outvar)
    add_executable(sunstone_kernel_images ${PROJECT_SOURCE_DIR}/tools/kernel_images/main.cpp
        ${PROJECT_SOURCE_DIR}/src/engine/gpu/code/machine_code.cpp
        ${PROJECT_SOURCE_DIR}/src/engine/gpu/code/ready_kernels.cpp)
    target_link_libraries(sunstone_kernel_images PRIVATE sunstone_compiler sunstone_ptx
        sunstone_texture sunstone_devlib sunstone_bvh sunstone_device_cuda sunstone_base
        ${SUNSTONE_LLVM_LIBS} TBB::tbb ${SUNSTONE_ZSTD} ${CMAKE_DL_LIBS})
    target_link_options(sunstone_kernel_images PRIVATE -B/usr/lib/llvm-19/bin -fuse-ld=lld
        -Wl,--gc-sections)
    get_property(words GLOBAL PROPERTY SUNSTONE_KERNEL_FILES)
    set(ptxas "${SUNSTONE_PTXAS}")
    if(NOT ptxas)
        set(ptxas none)
    endif()
    set(files ${words})
    list(FILTER files INCLUDE REGEX "\\.ptx$")
    set(output ${CMAKE_CURRENT_BINARY_DIR}/kernel_images.bin)
    add_custom_command(OUTPUT ${output}
        COMMAND sunstone_kernel_images ${output} ${ptxas} ${SUNSTONE_KERNEL_CAPABILITIES} ${words}
        DEPENDS sunstone_kernel_images ${files} COMMENT "ptxas: the library's own kernels" VERBATIM)
    set(${outvar} ${output} PARENT_SCOPE)
endfunction()
