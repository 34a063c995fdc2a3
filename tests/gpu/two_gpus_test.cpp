// SPDX-License-Identifier: Apache-2.0
// Contexts of the classic API that change their device: the CPU device acts as two GPUs.
#include "device/cuda/driver.h"

#include "optix.h"
#include "optix_cuda_interop.h"

#include <gtest/gtest.h>

#include <dlfcn.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace sunstone::api6 {
namespace {

using device::cuda::Driver;
using device::cuda::driverForTests;

// The driver is chosen before its first use.
[[maybe_unused]] const bool isGpu = [] {
    setenv("SUNSTONE_GPU_BACK_END", "cpu-device", 1);
    return dlopen("libcuda.so.1", RTLD_NOW) !=
           nullptr; // in the folder of this program's search path
}();

decltype(Driver::deviceGet) realDeviceGet = nullptr;

// The second GPU is the first under another number.
CUresult twoDevices(int* count) {
    *count = 2;
    return CUDA_SUCCESS;
}
CUresult eitherDevice(CUdevice* device, int ordinal) {
    return ordinal < 2 ? realDeviceGet(device, 0) : CUDA_ERROR_INVALID_DEVICE;
}

// Allocations of this size or more fail while the flag is set.
constexpr size_t kLarge = 8 << 20;
bool isFull = false;
decltype(Driver::memAllocManaged) realAlloc = nullptr;
CUresult limitedAlloc(CUdeviceptr* memory, size_t bytes, unsigned flags) {
    return isFull && bytes >= kLarge ? CUDA_ERROR_OUT_OF_MEMORY : realAlloc(memory, bytes, flags);
}

class TwoGpus : public ::testing::Test {
protected:
    static void SetUpTestSuite() {
        Driver& driver = driverForTests();
        realDeviceGet = driver.deviceGet;
        driver.deviceGet = eitherDevice;
        driver.deviceGetCount = twoDevices;
        realAlloc = driver.memAllocManaged;
        driver.memAllocManaged = limitedAlloc;
    }
    void SetUp() override {
        ok(rtContextCreate(&context_));
        ok(rtContextSetEntryPointCount(context_, 1));
        ok(rtContextSetRayTypeCount(context_, 1));
        result_ = floats(RT_BUFFER_INPUT_OUTPUT, "result", std::vector<float>(64));
    }
    void TearDown() override { rtContextDestroy(context_); }

    void ok(RTresult code) {
        const char* text = "";
        rtContextGetErrorString(context_, code, &text);
        ASSERT_EQ(code, RT_SUCCESS) << text;
    }
    void refuses(RTresult wanted, RTresult code, const char* word) {
        const char* text = "";
        rtContextGetErrorString(context_, code, &text);
        EXPECT_EQ(code, wanted) << text;
        EXPECT_NE(std::string(text).find(word), std::string::npos) << text;
    }
    void useDevice(int device) {
        int found = -1;
        ok(rtContextSetDevices(context_, 1, &device));
        ok(rtContextGetDevices(context_, &found));
        EXPECT_EQ(found, device);
    }
    RTprogram program(const char* name) {
        static const auto* text = [] {
            std::ifstream file(SUNSTONE_TEST_PTX);
            return new std::string(std::istreambuf_iterator<char>(file), {});
        }();
        RTprogram made = nullptr;
        ok(rtProgramCreateFromPTXString(context_, text->c_str(), name, &made));
        return made;
    }
    RTvariable variable(const char* name) {
        RTvariable found = nullptr;
        ok(rtContextQueryVariable(context_, name, &found));
        if (!found)
            ok(rtContextDeclareVariable(context_, name, &found));
        return found;
    }
    RTbuffer floats(unsigned type, const char* name, const std::vector<float>& values) {
        RTbuffer made = nullptr;
        ok(rtBufferCreate(context_, type, &made));
        ok(rtBufferSetFormat(made, RT_FORMAT_FLOAT));
        ok(rtBufferSetSize1D(made, values.size()));
        fill(made, values);
        if (name)
            ok(rtVariableSetObject(variable(name), made));
        return made;
    }
    void fill(RTbuffer buffer, const std::vector<float>& values) {
        void* data = nullptr;
        ok(rtBufferMap(buffer, &data));
        std::memcpy(data, values.data(), values.size() * sizeof(float));
        ok(rtBufferUnmap(buffer));
    }
    std::vector<float> launch(const char* name) {
        ok(rtContextSetRayGenerationProgram(context_, 0, program(name)));
        ok(rtContextLaunch1D(context_, 0, 1));
        return contents(result_);
    }
    std::vector<float> contents(RTbuffer buffer) {
        void* data = nullptr;
        RTsize size = 0;
        ok(rtBufferGetSize1D(buffer, &size));
        ok(rtBufferMap(buffer, &data));
        std::vector<float> values(static_cast<float*>(data), static_cast<float*>(data) + size);
        ok(rtBufferUnmap(buffer));
        return values;
    }

    // The target of the rays of "shoot", at z = 5.
    void makeTriangle() {
        RTgeometrytriangles mesh = nullptr;
        ok(rtGeometryTrianglesCreate(context_, &mesh));
        ok(rtGeometryTrianglesSetPrimitiveCount(mesh, 1));
        RTbuffer corners = floats(RT_BUFFER_INPUT, nullptr, {0, 0, 5, 1, 0, 5, 0, 1, 5});
        ok(rtGeometryTrianglesSetVertices(mesh, 3, corners, 0, 12, RT_FORMAT_FLOAT3));
        RTmaterial paint = nullptr;
        ok(rtMaterialCreate(context_, &paint));
        ok(rtMaterialSetClosestHitProgram(paint, 0, program("hit_distance_only")));
        RTgeometryinstance instance = nullptr;
        ok(rtGeometryInstanceCreate(context_, &instance));
        ok(rtGeometryInstanceSetGeometryTriangles(instance, mesh));
        ok(rtGeometryInstanceSetMaterialCount(instance, 1));
        ok(rtGeometryInstanceSetMaterial(instance, 0, paint));
        RTgeometrygroup leaf = nullptr;
        ok(rtGeometryGroupCreate(context_, &leaf));
        ok(rtGeometryGroupSetChildCount(leaf, 1));
        ok(rtGeometryGroupSetChild(leaf, 0, instance));
        ok(rtGeometryGroupSetAcceleration(leaf, acceleration()));
        RTgroup top = nullptr;
        ok(rtGroupCreate(context_, &top));
        ok(rtGroupSetChildCount(top, 1));
        ok(rtGroupSetChild(top, 0, leaf));
        ok(rtGroupSetAcceleration(top, acceleration()));
        ok(rtVariableSetObject(variable("top_object"), top));
        ok(rtVariableSet1f(variable("step"), 0));
        for (const char* name : {"ray_type", "flags"})
            ok(rtVariableSet1ui(variable(name), 0));
    }
    RTacceleration acceleration() {
        RTacceleration made = nullptr;
        ok(rtAccelerationCreate(context_, &made));
        ok(rtAccelerationSetBuilder(made, "Trbvh"));
        return made;
    }

    RTcontext context_ = nullptr;
    RTbuffer result_ = nullptr;
};

TEST_F(TwoGpus, AreCounted) {
    unsigned count = 0;
    ok(rtDeviceGetDeviceCount(&count));
    EXPECT_EQ(count, 2u);
    int compatible[3] = {};
    const RTdeviceattribute list = RT_DEVICE_ATTRIBUTE_COMPATIBLE_DEVICES;
    EXPECT_EQ(rtDeviceGetAttribute(1, list, 2 * sizeof(int), compatible), RT_ERROR_INVALID_VALUE);
    ok(rtDeviceGetAttribute(1, list, sizeof compatible, compatible));
    EXPECT_EQ(compatible[0], 2);
    EXPECT_EQ(compatible[1] + 10 * compatible[2], 10);
    const int third = 2;
    refuses(RT_ERROR_INVALID_DEVICE, rtContextSetDevices(context_, 1, &third), "devices[0] = 2");
}

TEST_F(TwoGpus, ContextsChangeBeforeAndAfterTheyHaveObjects) {
    useDevice(1);
    ok(rtVariableSet1f(variable("scoped"), 3));
    EXPECT_EQ(launch("write_scoped")[0], 3);
    useDevice(0);
    EXPECT_EQ(contents(result_)[0], 3) << "the elements move along";
    ok(rtVariableSet1f(variable("scoped"), 4));
    EXPECT_EQ(launch("write_scoped")[0], 4);
    useDevice(1);
    EXPECT_EQ(launch("write_scoped")[0], 4);
}

TEST_F(TwoGpus, TexturesAndTheGraphMoveAlong) {
    RTtexturesampler sampler = nullptr;
    ok(rtTextureSamplerCreate(context_, &sampler));
    RTbuffer texels = floats(RT_BUFFER_INPUT, nullptr, {7});
    ok(rtBufferSetSize2D(texels, 1, 1));
    fill(texels, {7});
    ok(rtTextureSamplerSetBuffer(sampler, 0, 0, texels));
    int id = 0;
    ok(rtTextureSamplerGetId(sampler, &id));
    ok(rtVariableSet1i(variable("texture_id"), id));
    ok(rtVariableSet1i(variable("texel_kind"), 0));
    makeTriangle();
    for (const int device : {0, 1, 0}) {
        useDevice(device);
        fill(result_, std::vector<float>(64));
        EXPECT_EQ(launch("sample_texel")[0], 7);
        EXPECT_EQ(launch("shoot")[3], 5) << "the distance of the triangle";
    }
}

TEST_F(TwoGpus, BuffersThatTheApplicationHoldsStay) {
    void* data = nullptr;
    const int second = 1;
    ok(rtBufferMap(result_, &data));
    refuses(RT_ERROR_ALREADY_MAPPED, rtContextSetDevices(context_, 1, &second), "mapped");
    ok(rtBufferUnmap(result_));
    ok(rtBufferGetDevicePointer(result_, 0, &data));
    refuses(RT_ERROR_INVALID_VALUE, rtContextSetDevices(context_, 1, &second), "device pointer");
    int device = -1;
    ok(rtContextGetDevices(context_, &device));
    EXPECT_EQ(device, 0);
    ok(rtBufferDestroy(result_));
    useDevice(1);
}

TEST_F(TwoGpus, ContextsStayWhereObjectsDoNotFitElsewhere) {
    RTbuffer large = floats(RT_BUFFER_INPUT, nullptr, std::vector<float>(kLarge / 2, 9));
    ok(rtVariableSet1f(variable("scoped"), 3));
    EXPECT_EQ(launch("write_scoped")[0], 3);
    const int second = 1;
    isFull = true;
    refuses(RT_ERROR_MEMORY_ALLOCATION_FAILED, rtContextSetDevices(context_, 1, &second), "Memory");
    isFull = false;
    int device = -1;
    ok(rtContextGetDevices(context_, &device));
    EXPECT_EQ(device, 0);
    EXPECT_EQ(contents(result_)[0], 3);
    EXPECT_EQ(contents(large).back(), 9);
    ok(rtVariableSet1f(variable("scoped"), 4));
    EXPECT_EQ(launch("write_scoped")[0], 4);
    useDevice(1);
    EXPECT_EQ(contents(large).back(), 9);
}

} // namespace
} // namespace sunstone::api6
