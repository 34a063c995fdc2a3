# Flags of the files that are compiled once per instruction set; bvh/walk/kernels.h chooses the set
# at run time. All other files are plain x86-64.
function(sunstone_isa_flags)
    set(avx2 -mavx2;-mfma;-mbmi;-mbmi2;-mlzcnt;-mpopcnt)
    set(avx512 ${avx2};-mavx512f;-mavx512vl;-mavx512dq;-mavx512bw;-mprefer-vector-width=256)
    file(GLOB_RECURSE avx2_files ${CMAKE_CURRENT_SOURCE_DIR}/*_avx2.cpp)
    file(GLOB_RECURSE avx512_files ${CMAKE_CURRENT_SOURCE_DIR}/*_avx512.cpp)
    set_source_files_properties(${avx2_files} PROPERTIES COMPILE_OPTIONS "${avx2}")
    set_source_files_properties(${avx512_files} PROPERTIES COMPILE_OPTIONS "${avx512}")
endfunction()
