# Installs into WORK/stage, checks the layout, builds the project in SOURCE against it and runs it.
# WAY: config (find_package finds OptiXConfig.cmake), module (a find module as in many projects),
# config76 and module76 (the same for OptiX 7.6).
# CUDA: the source of cuda.h, Sunstone's own headers or the toolkit.
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/../rules/links.cmake)

function(run)
    execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE out ERROR_VARIABLE out)
    if(NOT result EQUAL 0)
        message(FATAL_ERROR "failed (${result}): ${ARGN}\n${out}")
    endif()
    set(output "${out}" PARENT_SCOPE)
endfunction()

set(stage ${WORK}/stage)
file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${stage} --component sdk)
foreach(file IN ITEMS optix7/include/optix.h optix7/include/internal/optix_7_device_impl.h
        optix7.6/include/optix.h optix7.6/include/internal/optix_7_device_impl.h
        include/sunstone/cuda/cuda.h lib/cmake/OptiX/OptiXConfig.cmake
        lib/cmake/OptiX/OptiXConfigVersion.cmake)
    if(NOT EXISTS ${stage}/${file})
        message(FATAL_ERROR "${file} is not installed")
    endif()
endforeach()
set(doc ${stage}/share/doc/sunstone)
file(GLOB_RECURSE pages ${doc}/*.md)
if(NOT ${doc}/README.md IN_LIST pages OR NOT ${doc}/docs/gpu.md IN_LIST pages)
    message(FATAL_ERROR "the documentation is not installed")
endif()
sunstone_check_links(links ${doc} ${pages})
if(links)
    list(JOIN links "\n" links)
    message(FATAL_ERROR "${links}")
endif()
# A private copy of the tree under another name: nothing may depend on where it was installed.
file(RENAME ${stage} ${WORK}/moved)
set(stage ${WORK}/moved)

set(expected 7804) # OPTIX_ERROR_LIBRARY_NOT_FOUND
if(EXISTS ${BUILD}/lib/libnvoptix.so.1)
    run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${stage} --component runtime)
    set(expected 0)
endif()

set(version 7.4.0)
if(CUDA STREQUAL "toolkit")
    find_path(cuda_headers cuda.h PATHS $ENV{CUDA_PATH}/include /usr/local/cuda/include NO_CACHE)
    if(NOT cuda_headers)
        message("[SKIP] no CUDA toolkit on this machine")
        return()
    endif()
else()
    set(cuda_headers ${stage}/include/sunstone/cuda)
endif()
if(WAY MATCHES "config")
    set(wanted 7.4)
    if(WAY STREQUAL "config76")
        set(wanted 7.6)
        set(version 7.6.0)
    endif()
    set(find -DCMAKE_PREFIX_PATH=${stage} -DOptiX_CUDA_HEADERS=${CUDA} -DUSE_MODULE=OFF
        -DWANTED_VERSION=${wanted})
else()
    set(sdk optix7)
    if(WAY STREQUAL "module76")
        set(sdk optix7.6)
        set(version 7.6.0)
    endif()
    set(find -DOptiX_INSTALL_DIR=${stage}/${sdk} -DCUDA_INCLUDE_DIR=${cuda_headers} -DUSE_MODULE=ON)
endif()
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${CXX}
    -DEXPECTED_VERSION=${version} ${find})
run(${CMAKE_COMMAND} --build ${WORK}/build)

foreach(program IN ITEMS consumer consumer_short_name)
    run(${CMAKE_COMMAND} -E env LD_LIBRARY_PATH=${stage}/lib ${WORK}/build/${program})
    if(NOT output MATCHES "^optixInit: ${expected} ")
        message(FATAL_ERROR "${program} says: ${output}expected result ${expected}")
    endif()
    message("${program}: ${output}")
endforeach()
