# CPack runs this on the files of a package before it packs them. DEB: adds the link /usr/bin/sunstone. TGZ:
# adds the libraries of the system that Sunstone's need, in lib/sunstone/system, where run paths lead. That
# folder is on no path of applications, whose own libraries may be newer. The C and C++ libraries stay those of
# the system: a process can have only one of each.
cmake_minimum_required(VERSION 3.25)
set(root ${CPACK_TEMPORARY_INSTALL_DIRECTORY})
if(CPACK_GENERATOR STREQUAL "DEB")
    file(MAKE_DIRECTORY ${root}/usr/bin)
    file(CREATE_LINK ${CPACK_PACKAGING_INSTALL_PREFIX}/bin/sunstone ${root}/usr/bin/sunstone SYMBOLIC)
    return()
endif()

set(top ${root}${CPACK_PACKAGING_INSTALL_PREFIX})
file(GLOB libraries ${top}/lib/libsunstone.so.0 ${top}/lib/sunstone/cuda/*.so.1*)
file(GLOB programs ${top}/bin/sunstone ${top}/lib/sunstone/samples/*)
if(NOT libraries OR NOT programs)
    message(FATAL_ERROR "${top} has no libraries of Sunstone")
endif()
file(GET_RUNTIME_DEPENDENCIES EXECUTABLES ${programs} LIBRARIES ${libraries}
    RESOLVED_DEPENDENCIES_VAR needed UNRESOLVED_DEPENDENCIES_VAR missing
    DIRECTORIES ${top}/lib ${top}/lib/sunstone/cuda
    PRE_EXCLUDE_REGEXES "^ld-linux" "^lib(c|m|dl|pthread|rt|util|resolv|stdc\\+\\+|gcc_s)\\.so"
    POST_EXCLUDE_REGEXES "^${top}/" "/sunstone/cuda/" "libsunstone")
if(missing)
    message(FATAL_ERROR "libraries that the archive needs are missing: ${missing}")
endif()
foreach(library IN LISTS needed)
    file(INSTALL ${library} DESTINATION ${top}/lib/sunstone/system FOLLOW_SYMLINK_CHAIN)
endforeach()
