# CPack runs this on the files of a package before it packs them: adds the link /usr/bin/sunstone to a Debian package.
cmake_minimum_required(VERSION 3.25)
if(CPACK_GENERATOR STREQUAL "DEB")
    set(root ${CPACK_TEMPORARY_INSTALL_DIRECTORY})
    file(MAKE_DIRECTORY ${root}/usr/bin)
    file(CREATE_LINK ${CPACK_PACKAGING_INSTALL_PREFIX}/bin/sunstone ${root}/usr/bin/sunstone SYMBOLIC)
endif()
