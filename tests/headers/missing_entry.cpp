// SPDX-License-Identifier: Apache-2.0
// optixInit finds a library without the entry point, or no library. ctest selects the case by
// LD_LIBRARY_PATH; the argument is the expected result.
#include <optix_function_table_definition.h>
#include <optix_stubs.h>

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) {
    if (argc != 2)
        return 2;
    const int expected = std::atoi(argv[1]);
    void* installed = dlopen("libnvoptix.so.1", RTLD_NOW);
    if (expected == OPTIX_ERROR_LIBRARY_NOT_FOUND && installed) {
        std::puts("[SKIP] this machine has a libnvoptix.so.1 on its default path");
        return 77;
    }
    const OptixResult result = optixInit();
    std::printf("%s\n", optixGetErrorName(result));
    return result == expected && !g_optixFunctionTable.optixLaunch ? 0 : 1;
}
