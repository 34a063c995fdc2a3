# A find module as many projects carry: looks for <dir>/include/optix.h and reads the version from
# the line that defines it.
set(OptiX_INSTALL_DIR "" CACHE PATH "Folder of the OptiX SDK")
find_path(OptiX_INCLUDE_DIR NAMES optix.h PATHS ${OptiX_INSTALL_DIR}/include NO_DEFAULT_PATH)
if(OptiX_INCLUDE_DIR)
    file(STRINGS ${OptiX_INCLUDE_DIR}/optix.h line REGEX "^#define[ \t]+OPTIX_VERSION[ \t]+[0-9]+")
    string(REGEX MATCH "[0-9]+$" number "${line}")
    math(EXPR major "${number} / 10000")
    math(EXPR minor "(${number} % 10000) / 100")
    math(EXPR micro "${number} % 100")
    set(OptiX_VERSION ${major}.${minor}.${micro})
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OptiX REQUIRED_VARS OptiX_INCLUDE_DIR VERSION_VAR OptiX_VERSION)
