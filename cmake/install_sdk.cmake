# The layout of `cmake --install`. Common find modules look for <dir>/include/optix.h, hence a tree
# in the shape of an SDK beside the ordinary one:
#   <prefix>/optix7/include          OptiX 7.4 headers; also in <prefix>/include, so that a find module
#                                    may get the prefix itself as the folder of the SDK
#   <prefix>/optix7.6/include        OptiX 7.6 headers
#   <prefix>/optix6/include          headers of the classic 6.0 API and of OptiX Prime
#   <prefix>/optix6/lib64            <prefix>/lib, for find modules of classic programs
#   <prefix>/include/sunstone/rays.h ray queries without programs
#   <prefix>/include/sunstone/cuda   CUDA headers for machines without a toolkit
#   <prefix>/lib                     libsunstone, libnvoptix.so.1, liboptix.so.6.0.0, liboptixu.so.6.0.0,
#                                    liboptix_prime.so.6.0.0
#   <prefix>/lib/sunstone/cuda       libcuda.so.1, libcudart, libnvrtc: in a separate folder, so that they
#                                    never hide a real driver; `sunstone run` sets the path;
#                                    libsunstone_redirect.so, the audit library of `sunstone run`
#   <prefix>/cuda                    a folder in the shape of a CUDA toolkit (toolkit.cmake)
#   <prefix>/lib/cmake/OptiX         OptiXConfig.cmake: OptiX::OptiX, OptiX::Classic, OptiX::Prime, ...
#   <prefix>/share/doc/sunstone      README.md and the pages that it links to, in the same folders
# Components: sdk (headers and package files, needs no build), runtime, cuda, tools; mpi by itself.
include(CMakePackageConfigHelpers)

install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/optix7/ DESTINATION optix7/include
    COMPONENT sdk FILES_MATCHING PATTERN "*.h")
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/optix7/ DESTINATION include
    COMPONENT sdk FILES_MATCHING PATTERN "*.h")
install(DIRECTORY ${SUNSTONE_OPTIX76_FOLDER}/ DESTINATION optix7.6/include
    COMPONENT sdk FILES_MATCHING PATTERN "*.h")
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/optix6/ DESTINATION optix6/include
    COMPONENT sdk FILES_MATCHING PATTERN "*.h")
file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/package/optix6)
file(CREATE_LINK ../lib ${PROJECT_BINARY_DIR}/package/optix6/lib64 SYMBOLIC)
install(FILES ${PROJECT_BINARY_DIR}/package/optix6/lib64 DESTINATION optix6 COMPONENT sdk)
install(FILES ${PROJECT_SOURCE_DIR}/include/rays/sunstone/rays.h DESTINATION include/sunstone
    COMPONENT sdk)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/cuda/ DESTINATION include/sunstone/cuda
    COMPONENT sdk FILES_MATCHING PATTERN "*.h" PATTERN "*.hpp" PATTERN "*.inl")
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md
    ${PROJECT_SOURCE_DIR}/CONTRIBUTING.md DESTINATION share/doc/sunstone COMPONENT sdk)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs DESTINATION share/doc/sunstone
    COMPONENT sdk FILES_MATCHING PATTERN "*.md")
install(FILES ${PROJECT_SOURCE_DIR}/include/cuda/README.md
    DESTINATION share/doc/sunstone/include/cuda COMPONENT sdk)

# Versions are those of the API in optix.h, because programs call find_package(OptiX 7.4).
function(sunstone_optix_version result header)
    file(STRINGS ${header} line REGEX "^#define OPTIX_VERSION [0-9]+$")
    string(REGEX REPLACE "^.* " "" number "${line}")
    math(EXPR major "${number} / 10000")
    math(EXPR minor "${number} % 10000 / 100")
    math(EXPR micro "${number} % 100")
    set(${result} ${major}.${minor}.${micro} PARENT_SCOPE)
endfunction()
sunstone_optix_version(SUNSTONE_OPTIX_VERSION ${PROJECT_SOURCE_DIR}/include/optix7/optix.h)
sunstone_optix_version(SUNSTONE_OPTIX76_VERSION ${SUNSTONE_OPTIX76_FOLDER}/optix.h)
string(REGEX MATCH "^[0-9]+" optix_major "${SUNSTONE_OPTIX_VERSION}")
set(SUNSTONE_OPTIX_VERSIONS "${SUNSTONE_OPTIX_VERSION} ${SUNSTONE_OPTIX76_VERSION}") # rising

set(optix_headers optix7/include)
set(optix76_headers optix7.6/include)
set(optix6_headers optix6/include)
set(optix_libraries lib)
set(optix_rays_headers include)
set(optix_cuda_headers include/sunstone/cuda)
set(optix_nvcc cuda/bin/nvcc)
set(package_folder lib/cmake/OptiX)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/OptiXConfig.cmake.in
    ${PROJECT_BINARY_DIR}/package/OptiXConfig.cmake INSTALL_DESTINATION ${package_folder}
    PATH_VARS optix_headers optix76_headers optix6_headers optix_rays_headers optix_libraries optix_cuda_headers
        optix_nvcc)
configure_file(${PROJECT_SOURCE_DIR}/cmake/OptiXConfigVersion.cmake.in
    ${PROJECT_BINARY_DIR}/package/OptiXConfigVersion.cmake @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/package/OptiXConfig.cmake
    ${PROJECT_BINARY_DIR}/package/OptiXConfigVersion.cmake
    ${PROJECT_SOURCE_DIR}/cmake/OptiXDeviceCode.cmake
    DESTINATION ${package_folder} COMPONENT sdk)

# pkg-config: paths relative to the files, so that an installation may be moved.
set(pkg_config_optix "OptiX 7.4 headers;${SUNSTONE_OPTIX_VERSION};-I\${prefix}/optix7/include -I\${prefix}/include/sunstone/cuda;-ldl")
set(pkg_config_optix76 "OptiX 7.6 headers;${SUNSTONE_OPTIX76_VERSION};-I\${prefix}/optix7.6/include -I\${prefix}/include/sunstone/cuda;-ldl")
set(pkg_config_optix6 "the classic OptiX API;6.0.0;-I\${prefix}/optix6/include -I\${prefix}/include/sunstone/cuda;-L\${prefix}/lib -loptix -loptixu")
set(pkg_config_optix_prime "OptiX Prime;6.0.0;-I\${prefix}/optix6/include -I\${prefix}/include/sunstone/cuda;-L\${prefix}/lib -loptix_prime")
set(pkg_config_sunstone_rays "ray queries without programs;${PROJECT_VERSION};-I\${prefix}/include;-L\${prefix}/lib -lsunstone_rays")
set(pkg_config_cuda "CUDA driver API of the CPU;13.0;-I\${prefix}/include/sunstone/cuda;-L\${libdir} -lcuda")
set(pkg_config_cudart "CUDA runtime API;13.0;-I\${prefix}/include/sunstone/cuda;-L\${libdir} -lcudart")
set(pkg_config_nvrtc "Run-time compilation of CUDA C++;13.0;-I\${prefix}/include/sunstone/cuda;-L\${libdir} -lnvrtc")
foreach(package IN ITEMS optix optix76 optix6 optix_prime sunstone_rays cuda cudart nvrtc)
    list(GET pkg_config_${package} 0 about)
    list(GET pkg_config_${package} 1 version)
    list(GET pkg_config_${package} 2 flags)
    list(GET pkg_config_${package} 3 libraries)
    file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/package/${package}.pc @ONLY CONTENT
"prefix=\${pcfiledir}/../..
libdir=\${prefix}/lib/sunstone/cuda

Name: ${package}
Description: ${about} (Sunstone)
Version: ${version}
Cflags: ${flags}
Libs: ${libraries}
")
    install(FILES ${PROJECT_BINARY_DIR}/package/${package}.pc DESTINATION lib/pkgconfig COMPONENT sdk)
endforeach()

# sunstone_install(component folder path-from-folder-to-lib targets...): the targets that exist.
function(sunstone_install component folder to_lib)
    foreach(target IN LISTS ARGN)
        if(TARGET ${target})
            install(TARGETS ${target}
                RUNTIME DESTINATION ${folder} COMPONENT ${component}
                LIBRARY DESTINATION ${folder} COMPONENT ${component}
                ARCHIVE DESTINATION ${folder} COMPONENT ${component})
            set_target_properties(${target} PROPERTIES INSTALL_RPATH "$ORIGIN;$ORIGIN/${to_lib}")
        endif()
    endforeach()
endfunction()
sunstone_install(runtime lib . sunstone nvoptix optix6 optixu optix_prime sunstone_rays)
# The plug-in depends on the MPI of the build machine, and packages must not, so it is installed
# separately: `cmake --install BUILD --component mpi`.
if(TARGET sunstone_mpi)
    install(TARGETS sunstone_mpi LIBRARY DESTINATION lib COMPONENT mpi EXCLUDE_FROM_ALL)
endif()
sunstone_install(runtime lib/python .. sunstone_python)
foreach(alias IN LISTS SUNSTONE_PRIME_ALIASES)
    install(FILES ${PROJECT_BINARY_DIR}/lib/liboptix_prime.so.${alias} DESTINATION lib
        COMPONENT runtime)
endforeach()
foreach(alias IN LISTS SUNSTONE_OPTIX6_ALIASES)
    install(FILES ${PROJECT_BINARY_DIR}/lib/liboptix.so.${alias} DESTINATION lib COMPONENT runtime)
endforeach()
foreach(alias IN LISTS SUNSTONE_OPTIXU_ALIASES)
    install(FILES ${PROJECT_BINARY_DIR}/lib/liboptixu.so.${alias} DESTINATION lib
        COMPONENT runtime)
endforeach()
sunstone_install(cuda lib/sunstone/cuda ../.. sunstone_cuda cudart_shared cudart_shared_other cudart_static
    sunstone_redirect nvrtc12 nvrtc13)
sunstone_install(tools bin "../lib;$ORIGIN/../lib/sunstone/cuda" sunstone_tool)
sunstone_install(tools cuda/bin ../../lib sunstone_nvcc sunstone_fatbin sunstone_link_stub)
