# Device code to PTX. sunstone_ptx(<outvar> <file.cu> [NVCC] [OPTIX6] [INCLUDES dir...] [OPTIONS opt...])
# compiles one CUDA source to PTX with clang-19 and the project's own headers, so that no toolkit is
# needed; NVCC selects nvcc instead (only if SUNSTONE_NVCC is found); OPTIX6 the headers of the
# classic API.
find_program(SUNSTONE_DEVICE_CLANG NAMES clang++-19 REQUIRED)
find_program(SUNSTONE_NVCC NAMES nvcc HINTS /usr/local/cuda/bin)

set(SUNSTONE_DEVICE_FLAGS
    -x cuda --cuda-device-only -nocudainc -nocudalib --cuda-gpu-arch=sm_60 -std=c++17 -O3
    -Xclang -target-feature -Xclang +ptx65 -Xclang -fcuda-allow-variadic-functions
    --cuda-path=/nonexistent # a toolkit that is installed changes the version of PTX
    -I${PROJECT_SOURCE_DIR}/include/cuda -I${PROJECT_SOURCE_DIR}/include/optix7
    -include ${PROJECT_SOURCE_DIR}/include/cuda/cuda_runtime.h)

function(sunstone_ptx outvar source)
    cmake_parse_arguments(PTX "NVCC;OPTIX6" "SUFFIX" "INCLUDES;OPTIONS" ${ARGN})
    get_filename_component(source ${source} ABSOLUTE)
    get_filename_component(base ${source} NAME_WE)
    set(includes "")
    set(flags ${SUNSTONE_DEVICE_FLAGS})
    set(optix_include -I${PROJECT_SOURCE_DIR}/include/optix7)
    if(PTX_OPTIX6)
        list(REMOVE_ITEM flags ${optix_include})
        set(optix_include -I${PROJECT_SOURCE_DIR}/include/optix6)
        list(APPEND flags ${optix_include})
    endif()
    foreach(dir ${PTX_INCLUDES})
        list(APPEND includes -I${dir})
    endforeach()
    if(PTX_NVCC)
        set(output ${CMAKE_CURRENT_BINARY_DIR}/${base}${PTX_SUFFIX}.nvcc.ptx)
        add_custom_command(OUTPUT ${output}
            COMMAND ${SUNSTONE_NVCC} -ptx -rdc=true -O3 -std=c++17 -arch=compute_75 --use_fast_math
                ${optix_include} ${includes} ${PTX_OPTIONS} -o ${output} ${source}
            DEPENDS ${source} COMMENT "nvcc ${base}.cu" VERBATIM)
    else()
        set(output ${CMAKE_CURRENT_BINARY_DIR}/${base}${PTX_SUFFIX}.ptx)
        add_custom_command(OUTPUT ${output}
            COMMAND ${SUNSTONE_DEVICE_CLANG} ${flags} ${includes} ${PTX_OPTIONS}
                -MD -MF ${output}.d -S -o ${output} ${source}
            DEPENDS ${source} DEPFILE ${output}.d COMMENT "clang (device) ${base}.cu" VERBATIM)
    endif()
    set(${outvar} ${output} PARENT_SCOPE)
endfunction()
