# Building samples: sunstone_embed(target symbol file) builds a text file into a target as a
# function `std::string_view symbol()`; sunstone_sample(name [OPTIX76] [sources...] DEVICE file.cu
# [LINK libraries...]) builds an application against the public headers (OptiX 7.4, or 7.6 with
# OPTIX76) and our CUDA run-time library.

function(sunstone_embed target symbol file)
    set(EMBED_SYMBOL ${symbol})
    set(EMBED_FILE ${file})
    get_filename_component(EMBED_FILE_NAME ${file} NAME)
    set(source ${CMAKE_CURRENT_BINARY_DIR}/${symbol}.cpp)
    configure_file(${PROJECT_SOURCE_DIR}/samples/common/embedded_text.cpp.in ${source} @ONLY)
    # The assembler reads the text, because compilers do not track such an include.
    set_source_files_properties(${source} PROPERTIES OBJECT_DEPENDS ${file})
    target_sources(${target} PRIVATE ${source})
endfunction()

# Sanitizers for code that does not link sunstone_options.
function(sunstone_sanitize target)
    if(SUNSTONE_SANITIZE)
        target_compile_options(${target} PRIVATE -fsanitize=${SUNSTONE_SANITIZE}
            -fno-omit-frame-pointer -fno-sanitize-recover=undefined -fno-sanitize=vptr,function)
        target_link_options(${target} PRIVATE -fsanitize=${SUNSTONE_SANITIZE})
    endif()
endfunction()

function(sunstone_sample name)
    cmake_parse_arguments(SAMPLE "OPTIX76" "DEVICE" "LINK" ${ARGN})
    set(common sample_common)
    if(SAMPLE_OPTIX76)
        set(common sample_common76)
    endif()
    add_executable(sample_${name} ${SAMPLE_UNPARSED_ARGUMENTS})
    target_link_libraries(sample_${name} PRIVATE ${SAMPLE_LINK} ${common})
    if(SAMPLE_DEVICE)
        get_filename_component(base ${SAMPLE_DEVICE} NAME_WE)
        sunstone_ptx(ptx ${SAMPLE_DEVICE} INCLUDES ${PROJECT_SOURCE_DIR}/samples/common)
        sunstone_embed(sample_${name} ${base}_ptx ${ptx})
    endif()
    sunstone_sanitize(sample_${name})
    add_dependencies(sample_${name} nvoptix sunstone_cuda) # loaded when it runs
    set_property(GLOBAL APPEND PROPERTY SUNSTONE_SAMPLES sample_${name})
    set_target_properties(sample_${name} PROPERTIES OUTPUT_NAME ${name}
        RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
endfunction()

# A sample of the classic API: sunstone_sample6(name sources... DEVICE device_files...). The program is
# classic_<name>.
function(sunstone_sample6 name)
    cmake_parse_arguments(SAMPLE "" "" "DEVICE" ${ARGN})
    add_executable(sample_classic_${name} ${SAMPLE_UNPARSED_ARGUMENTS})
    target_link_libraries(sample_classic_${name} PRIVATE sample_common6)
    foreach(file IN LISTS SAMPLE_DEVICE)
        get_filename_component(base ${file} NAME_WE)
        sunstone_ptx(ptx ${file} OPTIX6)
        sunstone_embed(sample_classic_${name} ${base}_ptx ${ptx})
    endforeach()
    sunstone_sanitize(sample_classic_${name})
    set_target_properties(sample_classic_${name} PROPERTIES OUTPUT_NAME classic_${name}
        RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
    if(NOT TARGET classic_samples)
        add_custom_target(classic_samples)
    endif()
    add_dependencies(classic_samples sample_classic_${name})
    set_property(GLOBAL APPEND PROPERTY SUNSTONE_SAMPLES sample_classic_${name})
endfunction()
