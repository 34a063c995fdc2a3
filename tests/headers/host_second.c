/* SPDX-License-Identifier: Apache-2.0
   The second source file of a C application. */
#include <optix_stubs.h>

#include <optix_stack_size.h>

int main(void) {
    OptixStackSizes sizes = {0, 0, 0, 0, 0, 0, 0};
    return optixUtilComputeStackSizes(&sizes, 1, 1, 1, NULL, NULL, NULL) == OPTIX_SUCCESS &&
                   optixPipelineDestroy(NULL) == OPTIX_ERROR_INVALID_OPERATION
               ? 0
               : 1;
}
