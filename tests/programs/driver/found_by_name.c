// SPDX-License-Identifier: Apache-2.0
// A C program built without CUDA's headers: it opens the driver by name, asks it for each function,
// and declares what it needs itself, as bindings of other languages do.
#include <dlfcn.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef int (*Function)();

static const char* const kNames[] = {
    "cuInit",           "cuDeviceGetCount", "cuDeviceGetName",     "cuDevicePrimaryCtxRetain",
    "cuCtxSetCurrent",  "cuMemAlloc",       "cuMemsetD32",         "cuMemcpyDtoH",
    "cuMemFree",        "cuModuleLoadData", "cuModuleGetFunction", "cuLaunchKernel",
    "cuCtxSynchronize", "cuGetErrorString"};
enum {
    Init,
    Count,
    Name,
    Retain,
    Set,
    Alloc,
    Fill,
    Copy,
    Free,
    Load,
    Get,
    Launch,
    Wait,
    Text,
    All
};

static const char kModule[] =
    ".version 6.0\n.target sm_50\n.address_size 64\n"
    ".entry add(.param .u64 p){.reg .b64 %a;.reg .b32 %x,%t;.reg .b64 %o;"
    "ld.param.u64 %a,[p];mov.u32 %t,%tid.x;mul.wide.u32 %o,%t,4;add.u64 %a,%a,%o;"
    "ld.global.u32 %x,[%a];add.u32 %x,%x,%t;st.global.u32 [%a],%x;ret;}";

int main(void) {
    void* library = dlopen("libcuda.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        printf("%s\n", dlerror());
        return 1;
    }
    int (*find)(const char*, void**, int, uint64_t, int*) =
        (int (*)(const char*, void**, int, uint64_t, int*))dlsym(library, "cuGetProcAddress_v2");
    Function f[All];
    for (int i = 0; i < All; ++i) {
        int status = -1;
        void* address = NULL;
        if (find(kNames[i], &address, 12000, 0, &status) != 0 || status != 0 || !address) {
            printf("%s: not found, %d\n", kNames[i], status);
            return 1;
        }
        f[i] = (Function)address;
    }
    int count = 0, results[64];
    char name[100];
    void *context, *module, *kernel;
    uint64_t memory;
    int failures = ((int (*)(unsigned))f[Init])(0);
    failures += ((int (*)(int*))f[Count])(&count);
    failures += ((int (*)(char*, int, int))f[Name])(name, 100, 0);
    failures += ((int (*)(void**, int))f[Retain])(&context, 0);
    failures += ((int (*)(void*))f[Set])(context);
    failures += ((int (*)(uint64_t*, size_t))f[Alloc])(&memory, sizeof(results));
    failures += ((int (*)(uint64_t, unsigned, size_t))f[Fill])(memory, 1000, 64);
    failures += ((int (*)(void**, const void*))f[Load])(&module, kModule);
    failures += ((int (*)(void**, void*, const char*))f[Get])(&kernel, module, "add");
    // Arguments in one buffer, as some bindings pass them.
    size_t size = sizeof(memory);
    void* extra[] = {(void*)1, &memory, (void*)2, &size, (void*)0};
    failures += ((int (*)(void*, unsigned, unsigned, unsigned, unsigned, unsigned, unsigned,
                          unsigned, void*, void**, void**))f[Launch])(kernel, 1, 1, 1, 64, 1, 1, 0,
                                                                      NULL, NULL, extra);
    failures += ((int (*)(void))f[Wait])();
    failures += ((int (*)(void*, uint64_t, size_t))f[Copy])(results, memory, sizeof(results));
    failures += ((int (*)(uint64_t))f[Free])(memory);
    const char* text = NULL;
    failures += ((int (*)(int, const char**))f[Text])(2, &text);
    for (int i = 0; i < 64; ++i)
        failures += results[i] != 1000 + i;
    printf("%d device, %s\n", count, strlen(name) > 0 && text ? "named" : "nameless");
    printf(failures ? "wrong\n" : "ok\n");
    return failures != 0;
}
