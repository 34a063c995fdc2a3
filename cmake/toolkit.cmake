# <build>/toolkit and <prefix>/cuda have the shape of a CUDA toolkit, so that build systems find ours
# with CUDAToolkit_ROOT, CUDACXX or PATH:
#   bin/nvcc                      our front end; ptxas and fatbinary are what clang calls, bin2c
#                                 what build files call to embed PTX
#   include, lib64                links to the folders of headers and libraries
#   device                        an archive without members in place of the device runtime
#   nvvm/libdevice, version.json  what CMake and clang look for
#   clang.cmake                   toolchain file: enable_language(CUDA) with clang itself
set(toolkit ${PROJECT_BINARY_DIR}/toolkit)
file(MAKE_DIRECTORY ${toolkit}/bin ${toolkit}/nvvm/libdevice ${PROJECT_BINARY_DIR}/lib/cuda)
file(CONFIGURE OUTPUT ${toolkit}/nvvm/libdevice/README CONTENT
    "Device mathematics is in the headers: no library of device code is linked.\n")
file(CONFIGURE OUTPUT ${toolkit}/version.json CONTENT
    "{\"cuda\": {\"name\": \"Sunstone\", \"version\": \"13.0.0\"}}\n")
configure_file(${PROJECT_SOURCE_DIR}/cmake/cuda/clang.cmake ${toolkit}/clang.cmake COPYONLY)
# Drivers contain the toolkit's device runtime, but linkers require its archive. The archive is in
# its own folder, because beside libcudart it would hide the archive of NVIDIA's nvcc.
file(CONFIGURE OUTPUT ${toolkit}/device/libcudadevrt.a CONTENT "!<arch>\n")

# Links of the build tree.
file(CREATE_LINK ${PROJECT_SOURCE_DIR}/include/cuda ${toolkit}/include SYMBOLIC)
file(CREATE_LINK ../lib/cuda ${toolkit}/lib64 SYMBOLIC)
foreach(tool IN ITEMS sunstone_fatbin sunstone_link_stub)
    file(CREATE_LINK ../../bin/${tool} ${toolkit}/bin/${tool} SYMBOLIC)
endforeach()
foreach(name IN ITEMS bin2c ptxas fatbinary nvlink)
    file(CREATE_LINK nvcc ${toolkit}/bin/${name} SYMBOLIC)
endforeach()

# Links of an installation.
set(links ${PROJECT_BINARY_DIR}/package/toolkit)
file(MAKE_DIRECTORY ${links})
file(CREATE_LINK ../include/sunstone/cuda ${links}/include SYMBOLIC)
file(CREATE_LINK ../lib/sunstone/cuda ${links}/lib64 SYMBOLIC)
install(FILES ${toolkit}/device/libcudadevrt.a DESTINATION cuda/device COMPONENT sdk)
install(FILES ${links}/include ${links}/lib64 ${toolkit}/version.json ${toolkit}/clang.cmake
    DESTINATION cuda COMPONENT sdk)
install(FILES ${toolkit}/nvvm/libdevice/README DESTINATION cuda/nvvm/libdevice COMPONENT sdk)
install(FILES ${toolkit}/bin/bin2c ${toolkit}/bin/ptxas ${toolkit}/bin/fatbinary ${toolkit}/bin/nvlink
    DESTINATION cuda/bin COMPONENT tools)
