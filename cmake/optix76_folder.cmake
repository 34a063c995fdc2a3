# The OptiX 7.6 headers as a self-contained folder: for installations, and for run-time compilers
# that get headers by name. In the source tree include/optix76 reads the text of include/optix7;
# here the text is copied with the line of the version number changed.
set(SUNSTONE_OPTIX76_FOLDER ${PROJECT_BINARY_DIR}/optix76/include)
set(optix7_root ${PROJECT_SOURCE_DIR}/include/optix7)
set(optix76_root ${PROJECT_SOURCE_DIR}/include/optix76)

# sunstone_copy_changed(from to old new): fails if the old text is not there.
function(sunstone_copy_changed from to old new)
    file(READ ${from} text)
    string(FIND "${text}" "${old}" place)
    if(place EQUAL -1)
        message(FATAL_ERROR "${from} lacks the text: ${old}")
    endif()
    string(REPLACE "${old}" "${new}" text "${text}")
    file(WRITE ${to} "${text}")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${from})
endfunction()

file(REMOVE_RECURSE ${SUNSTONE_OPTIX76_FOLDER})
file(GLOB_RECURSE headers RELATIVE ${optix7_root} CONFIGURE_DEPENDS ${optix7_root}/*.h)
foreach(header IN LISTS headers)
    configure_file(${optix7_root}/${header} ${SUNSTONE_OPTIX76_FOLDER}/${header} COPYONLY)
endforeach()
sunstone_copy_changed(${optix7_root}/optix_7_types.h ${SUNSTONE_OPTIX76_FOLDER}/optix_7_types.h
    "#define SUNSTONE_OPTIX_API 70400" "#define SUNSTONE_OPTIX_API 70600")
sunstone_copy_changed(${optix76_root}/optix.h ${SUNSTONE_OPTIX76_FOLDER}/optix.h
    "#include \"internal/optix_76_api.h\"\n\n" "")
# Headers that OptiX 7.4 lacks.
foreach(header IN ITEMS optix_micromap.h internal/optix_7_micromap_impl.h)
    configure_file(${optix76_root}/${header} ${SUNSTONE_OPTIX76_FOLDER}/${header} COPYONLY)
endforeach()
