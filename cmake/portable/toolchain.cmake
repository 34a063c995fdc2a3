# Toolchain of scripts/portable: clang-19 with the sysroot that cmake/portable/sysroot makes. The preset `portable`
# uses it. The programs run on the build machine too, so that a build is not a cross-compilation.
get_filename_component(sysroot ${CMAKE_CURRENT_LIST_DIR}/../../build/portable/sysroot ABSOLUTE)
set(CMAKE_SYSROOT ${sysroot} CACHE PATH "folder of the sysroot")
set(CMAKE_C_COMPILER clang-19)
set(CMAKE_CXX_COMPILER clang++-19)
# As for a glibc from 2.34 on, whose libc.so.6 contains the thread functions: libstdc++ calls them directly.
set(CMAKE_CXX_FLAGS_INIT -D_GLIBCXX_GTHREAD_USE_WEAK=0)
# The sysroot has libstdc++ as an archive alone. libgcc_s is shared, because the frames that an exception leaves must
# all use one unwinder.
foreach(kind IN ITEMS EXE SHARED MODULE)
    set(CMAKE_${kind}_LINKER_FLAGS_INIT "-fuse-ld=lld -Wl,--as-needed -Wl,--exclude-libs,ALL")
endforeach()
set(CMAKE_FIND_ROOT_PATH ${CMAKE_SYSROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
