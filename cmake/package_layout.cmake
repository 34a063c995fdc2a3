# CPack reads this for each kind of package. Archives have a top folder with the package's name.
if(CPACK_GENERATOR STREQUAL "TGZ")
    set(CPACK_PACKAGING_INSTALL_PREFIX "")
endif()
