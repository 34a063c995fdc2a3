// SPDX-License-Identifier: Apache-2.0
// Loads the library and prints the outcome.
#include <optix.h>

#include <optix_function_table_definition.h>
#include <optix_stubs.h>

#include <cstdio>

int main() {
    const OptixResult result = optixInit();
    std::printf("optixInit: %d %s, API version %d\n", static_cast<int>(result),
                optixGetErrorName(result), OPTIX_VERSION);
    return 0;
}
