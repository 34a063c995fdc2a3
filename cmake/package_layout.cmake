# CPack reads this for each kind of package: archives begin with the folder of the package's name.
if(CPACK_GENERATOR STREQUAL "TGZ")
    set(CPACK_PACKAGING_INSTALL_PREFIX "")
endif()
