// SPDX-License-Identifier: Apache-2.0
// The second source file of an application: several files may use the stubs. It also defines the
// internal-header macro itself, which the headers must leave unchanged.
#define __OPTIX_INCLUDE_INTERNAL_HEADERS__
#include <optix_stubs.h>

#include <optix_stack_size.h>
#ifndef __OPTIX_INCLUDE_INTERNAL_HEADERS__
#error "the headers removed a definition that is not theirs"
#endif

int main() {
    OptixStackSizes sizes = {};
    return optixUtilComputeStackSizes(&sizes, 1, 1, 1, nullptr, nullptr, nullptr) ==
                       OPTIX_SUCCESS &&
                   optixPipelineDestroy(nullptr) == OPTIX_ERROR_INVALID_OPERATION
               ? 0
               : 1;
}
