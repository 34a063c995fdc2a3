# Packages: the target `packages` makes sunstone_<version>_<architecture>.deb, which installs to /opt/sunstone
# with a link /usr/bin/sunstone. In a portable build (scripts/portable) it makes sunstone-<version>-<system>.tar.gz.
# Also the samples, their sources and model, and what builds them (installed/CMakeLists.txt).
if(SUNSTONE_BUILD_SAMPLES)
    get_property(samples GLOBAL PROPERTY SUNSTONE_SAMPLES)
    foreach(sample IN LISTS samples)
        install(TARGETS ${sample} RUNTIME DESTINATION lib/sunstone/samples COMPONENT samples)
        set_target_properties(${sample} PROPERTIES INSTALL_RPATH "$ORIGIN/../..;$ORIGIN/../cuda")
        target_link_options(${sample} PRIVATE -Wl,--disable-new-dtags)
    endforeach()
endif()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/samples DESTINATION share/sunstone COMPONENT samples)
install(FILES ${PROJECT_SOURCE_DIR}/cmake/installed/CMakeLists.txt DESTINATION share/sunstone COMPONENT samples)
install(FILES ${PROJECT_SOURCE_DIR}/assets/demo.glb ${PROJECT_SOURCE_DIR}/assets/demo.LICENSE
    ${PROJECT_SOURCE_DIR}/assets/README.md DESTINATION share/sunstone/assets COMPONENT samples)
install(FILES ${PROJECT_SOURCE_DIR}/cmake/samples.cmake ${PROJECT_SOURCE_DIR}/cmake/device_code.cmake
    DESTINATION share/sunstone/cmake COMPONENT samples)
set(links ${PROJECT_BINARY_DIR}/package/samples)
file(MAKE_DIRECTORY ${links})
file(CREATE_LINK ../../../optix7/include ${links}/optix7 SYMBOLIC)
file(CREATE_LINK ../../../optix7.6/include ${links}/optix76 SYMBOLIC)
file(CREATE_LINK ../../../optix6/include ${links}/optix6 SYMBOLIC)
file(CREATE_LINK ../../../include/sunstone/cuda ${links}/cuda SYMBOLIC)
install(FILES ${links}/optix7 ${links}/optix76 ${links}/optix6 ${links}/cuda DESTINATION share/sunstone/include
    COMPONENT samples)

# The command uses its own libraries: DT_RPATH, unlike DT_RUNPATH, comes before LD_LIBRARY_PATH. It also applies to
# libraries that libsunstone opens, unless that library has a DT_RUNPATH.
foreach(target IN ITEMS sunstone sunstone_tool)
    if(TARGET ${target})
        target_link_options(${target} PRIVATE -Wl,--disable-new-dtags)
    endif()
endforeach()

set(CPACK_GENERATOR DEB)
if(SUNSTONE_PORTABLE)
    set(CPACK_GENERATOR TGZ)
    install(DIRECTORY ${CMAKE_SYSROOT}/licenses DESTINATION share/doc/sunstone COMPONENT runtime)
endif()
set(CPACK_PACKAGE_NAME sunstone)
set(CPACK_PACKAGE_VENDOR "Sunstone")
set(CPACK_PACKAGE_CONTACT "Sunstone developers <sunstone@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "OptiX and CUDA programs on any CPU and on CUDA GPUs")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /opt/sunstone)
set(CPACK_SET_DESTDIR OFF)
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/lib ${PROJECT_BINARY_DIR}/lib/cuda)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS clang-19)
set(CPACK_ARCHIVE_THREADS 0)
set(CPACK_PROJECT_CONFIG_FILE ${PROJECT_SOURCE_DIR}/cmake/package_layout.cmake)
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/cmake/package_files.cmake)
# The target `packages` builds the installed files and no tests.
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)
include(CPack)

set(packaged "")
foreach(target IN ITEMS sunstone nvoptix optix6 optixu optix_prime sunstone_rays sunstone_python sunstone_cuda
        cudart_shared cudart_shared_other cudart_static sunstone_redirect nvrtc12 nvrtc13 sunstone_tool sunstone_nvcc
        sunstone_fatbin sunstone_link_stub ${samples})
    if(TARGET ${target})
        list(APPEND packaged ${target})
    endif()
endforeach()
add_custom_target(packages COMMAND ${CMAKE_CPACK_COMMAND} --config ${PROJECT_BINARY_DIR}/CPackConfig.cmake
    DEPENDS ${packaged} WORKING_DIRECTORY ${PROJECT_BINARY_DIR} USES_TERMINAL VERBATIM)
