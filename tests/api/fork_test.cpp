// SPDX-License-Identifier: Apache-2.0
// After fork() in a process with a device context, every function fails at once in the child,
// because the child lacks the threads of the parent's objects.
#include "../main/forked_child.h"
#include "scene.h"

#include <cstdio>
#include <cstdlib>
#include <dlfcn.h>
#include <functional>

namespace tests::api {
namespace {

// Calls the functions of a table with zeros as arguments; returns the number of wrong results.
int callAll(void* const* table, size_t slots) {
    using Function = OptixResult (*)(void*, void*, void*, void*, void*, void*, void*, void*, void*,
                                     void*, void*, void*, void*, void*);
    int others = 0;
    for (size_t slot = 2; slot < slots; ++slot) { // the first two describe codes
        if (slot == 31 || slot == 32)
            continue; // reserved: no functions
        const OptixResult result = reinterpret_cast<Function>(table[slot])(
            nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr,
            nullptr, nullptr, nullptr, nullptr, nullptr);
        if (result != OPTIX_ERROR_CUDA_NOT_INITIALIZED) {
            std::fprintf(stderr, "slot %zu: %d\n", slot, int(result));
            ++others;
        }
    }
    return others;
}

using Fork = ApiTest;

TEST_F(Fork, EveryFunctionFailsInAChild) {
    constexpr int kAbi74 = 55;
    constexpr size_t kSlots = 43;
    void* const library = dlopen("libnvoptix.so.1", RTLD_NOW);
    ASSERT_NE(nullptr, library) << dlerror();
    const auto query =
        reinterpret_cast<OptixQueryFunctionTable_t*>(dlsym(library, "optixQueryFunctionTable"));
    ASSERT_NE(nullptr, query);
    void* table[kSlots] = {};
    ASSERT_EQ(OPTIX_SUCCESS, query(kAbi74, 0, nullptr, nullptr, table, sizeof(table)));
    const TriangleMesh mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2});
    EXPECT_NE(0u, buildAccel(context_, log_, {mesh.input}).handle);
    EXPECT_EQ(0, inChild([&] { return callAll(table, kSlots); }));
    EXPECT_NE(0u, buildAccel(context_, log_, {mesh.input}).handle) << "the parent goes on";
    dlclose(library);
}

TEST_F(Fork, ObjectsOfTheParentAreRefused) {
    const OptixDeviceContext context = context_;
    EXPECT_EQ(0, inChild([&] {
                  unsigned depth = 0;
                  OptixDeviceContext made = nullptr;
                  const OptixDeviceContextOptions options{};
                  const OptixResult results[] = {
                      optixDeviceContextCreate(nullptr, &options, &made),
                      optixDeviceContextGetProperty(context,
                                                    OPTIX_DEVICE_PROPERTY_LIMIT_MAX_TRACE_DEPTH,
                                                    &depth, sizeof(depth)),
                      optixDeviceContextDestroy(context)};
                  int others = 0;
                  for (const OptixResult result : results)
                      others += result != OPTIX_ERROR_CUDA_NOT_INITIALIZED;
                  return others;
              }));
    unsigned depth = 0;
    EXPECT_OK(optixDeviceContextGetProperty(context_, OPTIX_DEVICE_PROPERTY_LIMIT_MAX_TRACE_DEPTH,
                                            &depth, sizeof(depth)));
}

} // namespace
} // namespace tests::api
