# Toolchain file: CMake's language CUDA with clang and Sunstone's headers and libraries.
#   cmake --toolchain <prefix>/cuda/clang.cmake ...
set(CMAKE_CUDA_COMPILER "$ENV{SUNSTONE_CLANG}" CACHE FILEPATH "clang++ of version 19 or later")
if(NOT CMAKE_CUDA_COMPILER)
    find_program(SUNSTONE_CUDA_CLANG NAMES clang++-19 clang++-20 clang++-21 clang++ REQUIRED)
    set(CMAKE_CUDA_COMPILER "${SUNSTONE_CUDA_CLANG}" CACHE FILEPATH "clang++ of version 19 or later" FORCE)
endif()
set(CUDAToolkit_ROOT "${CMAKE_CURRENT_LIST_DIR}" CACHE PATH "Toolkit-shaped folder of Sunstone")
string(CONCAT CMAKE_CUDA_FLAGS_INIT "-nocudainc -nocudalib -Wno-unknown-cuda-version --no-cuda-version-check -Wno-unused-command-line-argument "
    # As in src/api/nvrtc/options.cpp.
    "-fno-strict-aliasing -Xclang -no-enable-noundef-analysis -fno-strict-return -fno-strict-float-cast-overflow "
    "--cuda-path=${CMAKE_CURRENT_LIST_DIR} -I${CMAKE_CURRENT_LIST_DIR}/include "
    "-include ${CMAKE_CURRENT_LIST_DIR}/include/cuda_runtime.h")
foreach(kind IN ITEMS EXE SHARED MODULE) # for cudadevrt, which CMake links
    set(CMAKE_${kind}_LINKER_FLAGS_INIT "-L${CMAKE_CURRENT_LIST_DIR}/device")
endforeach()
# CMake reads the flags of its first test only from the environment.
set(ENV{CUDAFLAGS} "${CMAKE_CUDA_FLAGS_INIT}")
set(CMAKE_CUDA_FLAGS_INIT "")
