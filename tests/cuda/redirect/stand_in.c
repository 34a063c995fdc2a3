// SPDX-License-Identifier: Apache-2.0
// Stands in for the toolkit's static runtime where there is no toolkit: functions of the same names
// that ask the driver for an undocumented table, then end the program. FORMS: 12 or 11 has the
// functions that later runtimes removed. EXPORTED: a library that stands between program and
// runtime.
#include <dlfcn.h>
#include <stdio.h>
#include <unistd.h>

static int fail(const char* name) {
    void* driver = dlopen("libcuda.so.1", RTLD_NOW);
    int (*table)(const void**, const void*) = 0;
    if (driver)
        *(void**)&table = dlsym(driver, "cuGetExportTable");
    const void* unused = 0;
    printf("the stand-in's %s ran: %d\n", name, table ? table(&unused, "0123456789abcdef") : -1);
    fflush(stdout);
    _exit(3);
}

#ifdef EXPORTED
#define FUNCTION(name)                                                                             \
    __attribute__((visibility("default"))) int name(void) {                                        \
        return 4242;                                                                               \
    }
#else
#define FUNCTION(name)                                                                             \
    __attribute__((visibility("hidden"))) int name(void) {                                         \
        return fail(#name);                                                                        \
    }
#endif

FUNCTION(__cudaRegisterFatBinary)
FUNCTION(__cudaRegisterFatBinaryEnd)
FUNCTION(__cudaUnregisterFatBinary)
FUNCTION(__cudaRegisterFunction)
FUNCTION(__cudaRegisterVar)
FUNCTION(__cudaPushCallConfiguration)
FUNCTION(__cudaPopCallConfiguration)
FUNCTION(cudaFree)
FUNCTION(cudaGetDeviceCount)
FUNCTION(cudaLaunch)
FUNCTION(cudaLaunchKernel)
FUNCTION(cudaSetupArgument)
FUNCTION(cudaConfigureCall)
FUNCTION(cudaMalloc)
FUNCTION(cudaMemcpy)
FUNCTION(cudaMemset)
FUNCTION(cudaRuntimeGetVersion)
#if FORMS == 12
FUNCTION(cudaGetDeviceProperties_v2)
#elif FORMS == 11
FUNCTION(cudaBindTexture)
#endif
