# optix_embed_device_code(<target> <source.cu> [CLASSIC] [NAME <symbol>] [INCLUDES <folder>...] [OPTIONS <option>...])
# compiles device code to PTX with OptiX_NVCC, by default Sunstone's nvcc, and embeds the text in the target, which
# gets a header <symbol>.h:
#   extern "C" const char <symbol>[];          // ends with a NUL
#   extern "C" const unsigned long <symbol>_size; // without the NUL
# CLASSIC: the source uses the classic API, for programs that link OptiX::Classic.
# The symbol is <name of the source>_ptx unless NAME is given. Several targets may embed one source. The PTX is for
# compute_75, the lowest target of NVIDIA's nvcc 13, unless OPTIONS has -arch or -gencode.
# optix_compile_ptx(<variable> <source.cu> ...) has the same arguments and sets the variable to the file of the PTX:
# <name>.ptx in the build folder. A build of all targets compiles the file. <variable>_TARGET is the target that
# compiles it, for add_dependencies().
function(optix_add_ptx_rule ptx name source classic includes options)
    set(folders "-I${OptiX_INCLUDE_DIR}")
    if(classic)
        set(folders "-I${OptiX_CLASSIC_INCLUDE_DIR}")
        list(PREPEND options -rdc=true) # keeps programs that only variables name, such as callables
    endif()
    foreach(folder IN LISTS includes)
        get_filename_component(folder "${folder}" ABSOLUTE)
        list(APPEND folders "-I${folder}")
    endforeach()
    if(NOT "${options}" MATCHES "(^|;)(-arch|--gpu-architecture|-gencode|--generate-code)(=|;|$)")
        list(PREPEND options -arch=compute_75)
    endif()
    add_custom_command(OUTPUT "${ptx}"
        COMMAND "${OptiX_NVCC}" -ptx ${folders} ${options} -o "${ptx}" "${source}"
        COMMAND "${OptiX_NVCC}" -M ${folders} ${options} -MT "${ptx}" -o "${ptx}.d" "${source}"
        DEPENDS "${source}" DEPFILE "${ptx}.d" COMMENT "device code ${name}" VERBATIM)
endfunction()

function(optix_compile_ptx variable source)
    cmake_parse_arguments(PTX "CLASSIC" "NAME" "INCLUDES;OPTIONS" ${ARGN})
    get_filename_component(source "${source}" ABSOLUTE)
    get_filename_component(name "${source}" NAME_WE)
    if(PTX_NAME)
        set(name "${PTX_NAME}")
    endif()
    set(ptx "${CMAKE_CURRENT_BINARY_DIR}/${name}.ptx")
    optix_add_ptx_rule("${ptx}" "${name}" "${source}" "${PTX_CLASSIC}" "${PTX_INCLUDES}" "${PTX_OPTIONS}")
    # Folders of a project may have sources of equal names.
    string(SHA1 hash "${ptx}")
    string(SUBSTRING "${hash}" 0 8 hash)
    string(MAKE_C_IDENTIFIER "${name}_${hash}" made)
    add_custom_target(optix_ptx_${made} ALL DEPENDS "${ptx}")
    set(${variable} "${ptx}" PARENT_SCOPE)
    set(${variable}_TARGET optix_ptx_${made} PARENT_SCOPE)
endfunction()

function(optix_embed_device_code target source)
    cmake_parse_arguments(EMBED "CLASSIC" "NAME" "INCLUDES;OPTIONS" ${ARGN})
    get_filename_component(symbol "${source}" NAME_WE)
    set(symbol "${symbol}_ptx")
    if(EMBED_NAME)
        set(symbol "${EMBED_NAME}")
    endif()
    get_filename_component(source "${source}" ABSOLUTE)
    set(folder "${CMAKE_CURRENT_BINARY_DIR}/optix_device_code/${target}")
    file(MAKE_DIRECTORY "${folder}")
    set(ptx "${folder}/${symbol}.ptx")
    optix_add_ptx_rule("${ptx}" "${symbol}" "${source}" "${EMBED_CLASSIC}" "${EMBED_INCLUDES}"
        "${EMBED_OPTIONS}")
    file(CONFIGURE OUTPUT "${folder}/${symbol}.h" @ONLY CONTENT
"#pragma once
#ifdef __cplusplus
extern \"C\" {
#endif
extern const char @symbol@[];
extern const unsigned long @symbol@_size;
#ifdef __cplusplus
}
#endif
")
    # The assembler reads the text, so it may be of any length.
    get_property(languages GLOBAL PROPERTY ENABLED_LANGUAGES)
    set(ending c)
    if(NOT "C" IN_LIST languages)
        set(ending cpp)
    endif()
    file(CONFIGURE OUTPUT "${folder}/${symbol}.${ending}" @ONLY CONTENT
"__asm__(\".pushsection .rodata\\n.globl @symbol@\\n.type @symbol@, @object\\n.balign 8\\n@symbol@:\\n\"
        \".incbin \\\"@ptx@\\\"\\n.byte 0\\n@symbol@_end:\\n.size @symbol@, @symbol@_end - @symbol@\\n\"
        \".globl @symbol@_size\\n.type @symbol@_size, @object\\n.size @symbol@_size, 8\\n.balign 8\\n@symbol@_size:\\n\"
        \".quad @symbol@_end - @symbol@ - 1\\n.popsection\\n\");
")
    set_source_files_properties("${folder}/${symbol}.${ending}" PROPERTIES OBJECT_DEPENDS "${ptx}"
        SKIP_UNITY_BUILD_INCLUSION ON)
    target_sources(${target} PRIVATE "${folder}/${symbol}.${ending}" "${ptx}")
    set_property(SOURCE "${ptx}" PROPERTY HEADER_FILE_ONLY ON)
    target_include_directories(${target} PRIVATE "${folder}")
endfunction()
