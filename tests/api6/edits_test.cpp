// SPDX-License-Identifier: Apache-2.0
// Scenes that an application edits between launches: corrected errors disappear, and changes take
// effect.
#include "rays.h"

#include "cuda.h"
#include "optix_cuda_interop.h"

#include <dlfcn.h>

#include <type_traits>

namespace sunstone::api6 {
namespace {

class Edits : public Rays {
protected:
    RTprogram edit(const char* name) {
        RTprogram made = nullptr;
        ok(rtProgramCreateFromPTXString(context_, ptx("traps.ptx").c_str(), name, &made));
        return made;
    }
    void enter(const char* name) { ok(rtContextSetRayGenerationProgram(context_, 0, edit(name))); }
    RTtexturesampler sampler(RTbuffer source) {
        RTtexturesampler made = nullptr;
        ok(rtTextureSamplerCreate(context_, &made));
        ok(rtTextureSamplerSetFilteringModes(made, RT_FILTER_NEAREST, RT_FILTER_NEAREST,
                                             RT_FILTER_NONE));
        ok(rtTextureSamplerSetIndexingMode(made, RT_TEXTURE_INDEX_ARRAY_INDEX));
        ok(rtTextureSamplerSetReadMode(made, RT_TEXTURE_READ_ELEMENT_TYPE));
        ok(rtTextureSamplerSetBuffer(made, 0, 0, source));
        return made;
    }
};

TEST_F(Edits, BoundsProgramsCallOthers) {
    ok(rtVariableSetObject(variable("size_bound"), edit("half_of")));
    int id = 0;
    ok(rtProgramGetId(edit("half_of"), &id));
    ok(rtVariableSet1i(variable("size_id"), id));
    ok(rtVariableSet1f(variable("number"), 0));
    for (const char* bounds : {"bounds_by_bound", "bounds_by_id"}) {
        RTgeometry geometry = squares(1);
        ok(rtGeometrySetBoundingBoxProgram(geometry, edit(bounds)));
        setEntry("shoot");
        EXPECT_EQ(shoot(group({instance(geometry, {material("hit_mark")})}))[0],
                  shoot(group({instance(squares(1), {material("hit_mark")})}))[0])
            << bounds;
    }
}

TEST_F(Edits, ProgramsThatCannotBeCompiledAreForgotten) {
    RTgeometrygroup top = group({instance(squares(1), {material("hit_mark")})});
    const float expected = shoot(top)[0];
    for (int round = 0; round < 3; ++round) {
        RTprogram broken = edit("calls_missing");
        ok(rtContextSetRayGenerationProgram(context_, 0, broken));
        fails(RT_ERROR_INVALID_SOURCE, rtContextLaunch1D(context_, 0, 1), "missing_function");
        setEntry("shoot");
        if (round == 1)
            ok(rtProgramDestroy(broken));
        EXPECT_EQ(shoot(top)[0], expected) << round;
    }
}

// New elements may get the address of the former ones.
TEST_F(Edits, TexturesFollowTheSizeOfTheirBuffer) {
    enter("read_texture_id");
    RTbuffer source = nullptr;
    ok(rtBufferCreate(context_, RT_BUFFER_INPUT, &source));
    ok(rtBufferSetFormat(source, RT_FORMAT_FLOAT));
    ok(rtBufferSetSize2D(source, 2, 32));
    RTtexturesampler made = sampler(source);
    int id = 0;
    ok(rtTextureSamplerGetId(made, &id));
    ok(rtVariableSet1i(variable("texture_id"), id));
    for (const unsigned width : {2u, 32u, 4u, 16u, 2u, 8u}) {
        ok(rtBufferSetSize2D(source, width, 64 / width));
        std::vector<float> texels(64);
        for (unsigned i = 0; i < 64; ++i)
            texels[i] = float(i % width + 100 * (i / width));
        fill(source, texels);
        ok(rtContextLaunch1D(context_, 0, 1));
        EXPECT_EQ(results()[0], 101) << width;
    }
}

// Programs set the size of a buffer for each frame.
TEST_F(Edits, BuffersOfTheSameSizeKeepTheirContents) {
    RTbuffer buffer = nullptr;
    ok(rtBufferCreate(context_, RT_BUFFER_INPUT_OUTPUT, &buffer));
    ok(rtBufferSetFormat(buffer, RT_FORMAT_UNSIGNED_INT));
    const auto first = [&] {
        void* mapped = nullptr;
        ok(rtBufferMap(buffer, &mapped));
        auto* const value = static_cast<unsigned*>(mapped);
        const unsigned before = *value;
        *value = 7;
        ok(rtBufferUnmap(buffer));
        return before;
    };
    ok(rtBufferSetSize2D(buffer, 4, 3));
    EXPECT_EQ(first(), 0u);
    ok(rtBufferSetSize2D(buffer, 4, 3));
    EXPECT_EQ(first(), 7u);
    ok(rtBufferSetSize2D(buffer, 3, 4));
    EXPECT_EQ(first(), 0u);
    ok(rtBufferSetSize1D(buffer, 3));
    EXPECT_EQ(first(), 0u);
}

// On the CPU. A buffer takes memory when it is used.
TEST_F(Edits, LargeBuffersTakeNoMemoryBeforeTheyAreUsed) {
    if (runsOnGpu())
        GTEST_SKIP() << "the driver decides";
    const auto residentPages = [] {
        size_t all = 0, resident = 0;
        std::ifstream("/proc/self/statm") >> all >> resident;
        return resident;
    };
    RTbuffer buffer = nullptr;
    ok(rtBufferCreate(context_, RT_BUFFER_INPUT_OUTPUT, &buffer));
    ok(rtBufferSetFormat(buffer, RT_FORMAT_FLOAT));
    const size_t before = residentPages();
    ok(rtBufferSetSize1D(buffer, size_t(64) << 20));
    void* mapped = nullptr;
    ok(rtBufferMap(buffer, &mapped));
    EXPECT_EQ(static_cast<const float*>(mapped)[size_t(48) << 20], 0);
    ok(rtBufferUnmap(buffer));
    EXPECT_LT(residentPages(), before + (size_t(16) << 20) / 4096) << "of 256 MiB";
    ok(rtBufferSetSize1D(buffer, size_t(1) << 20));
    fails(RT_ERROR_MEMORY_ALLOCATION_FAILED, rtBufferSetSize1D(buffer, size_t(1) << 38),
          "no memory");
}

TEST_F(Edits, InvalidTextureIdsAreExceptions) {
    enter("read_texture_id");
    ok(rtContextSetExceptionProgram(context_, 0, edit("note_code")));
    ok(rtContextSetExceptionEnabled(context_, RT_EXCEPTION_TEXTURE_ID_INVALID, 1));
    RTtexturesampler made = sampler(filled(RT_FORMAT_FLOAT, std::vector<float>(64, 7)));
    RTbuffer source = nullptr;
    ok(rtTextureSamplerGetBuffer(made, 0, 0, &source));
    ok(rtBufferSetSize2D(source, 8, 8));
    fill(source, std::vector<float>(64, 7));
    int id = 0;
    ok(rtTextureSamplerGetId(made, &id));
    const auto read = [&](int number) {
        fill(result_, std::vector<float>(64));
        ok(rtVariableSet1i(variable("texture_id"), number));
        ok(rtContextLaunch1D(context_, 0, 1));
        return results();
    };
    EXPECT_EQ(read(id)[0], 7);
    for (const int wrong : {0, id + 1, id + 1000, -1}) {
        const std::vector<float> seen = read(wrong);
        EXPECT_EQ(seen[1], 1) << wrong;
        EXPECT_EQ(seen[2], float(RT_EXCEPTION_TEXTURE_ID_INVALID)) << wrong;
    }
    ok(rtContextSetExceptionEnabled(context_, RT_EXCEPTION_TEXTURE_ID_INVALID, 0));
    EXPECT_EQ(read(id + 1)[1], 2) << "without the exception it reads zeros";
}

// The CUDA driver takes the addresses of buffers.
TEST_F(Edits, CudaCallsChangeBuffers) {
    void* library = dlopen("libcuda.so.1", RTLD_NOW); // that of the machine, in front of the CPU's
    if (!library || !runsOnGpu())
        library = dlopen(SUNSTONE_TEST_CUDA, RTLD_NOW);
    ASSERT_TRUE(library) << dlerror();
    const auto find = [&](auto& function, const char* name) {
        function =
            reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(library, name));
        ASSERT_TRUE(function) << name;
    };
    decltype(&cuInit) init;
    decltype(&cuDevicePrimaryCtxRetain) retain;
    decltype(&cuCtxSetCurrent) setCurrent;
    decltype(&cuMemsetD32) set;
    decltype(&cuMemcpyHtoD) copyIn;
    decltype(&cuMemcpyDtoH) copyOut;
    find(init, "cuInit");
    find(retain, "cuDevicePrimaryCtxRetain");
    find(setCurrent, "cuCtxSetCurrent");
    find(set, "cuMemsetD32_v2");
    find(copyIn, "cuMemcpyHtoD_v2");
    find(copyOut, "cuMemcpyDtoH_v2");
    CUcontext cuda = nullptr;
    ASSERT_EQ(init(0), CUDA_SUCCESS);
    ASSERT_EQ(retain(&cuda, 0), CUDA_SUCCESS);
    ASSERT_EQ(setCurrent(cuda), CUDA_SUCCESS);
    void* pointer = nullptr;
    ok(rtBufferGetDevicePointer(result_, 0, &pointer));
    const CUdeviceptr address = CUdeviceptr(pointer);
    float some[3] = {2, 3, 5}, seen[4] = {};
    EXPECT_EQ(set(address, 0, 64), CUDA_SUCCESS);
    EXPECT_EQ(copyIn(address + 4, some, sizeof some), CUDA_SUCCESS);
    EXPECT_EQ(copyOut(seen, address, sizeof seen), CUDA_SUCCESS);
    EXPECT_EQ(seen[0], 0);
    EXPECT_EQ(seen[3], 5);
    EXPECT_EQ(results()[2], 3);
    if (!runsOnGpu()) // there buffers share larger pieces
        EXPECT_EQ(set(address, 0, 1 << 16), CUDA_ERROR_INVALID_VALUE) << "beyond its end";
}

TEST_F(Edits, IdsOfDestroyedObjectsAreGivenAgain) {
    int last = 0;
    for (int i = 0; i < 5000; ++i) {
        int id = 0;
        RTbuffer made = buffer(RT_BUFFER_INPUT, RT_FORMAT_FLOAT, 1), found = nullptr;
        ok(rtBufferGetId(made, &id));
        ok(rtContextGetBufferFromId(context_, id, &found));
        EXPECT_EQ(found, made);
        EXPECT_NE(id, last) << "the last one stays invalid";
        EXPECT_LT(id, 2500);
        ok(rtBufferDestroy(made));
        EXPECT_EQ(rtContextGetBufferFromId(context_, id, &found), RT_ERROR_INVALID_VALUE);
        last = id;
    }
}

TEST_F(Edits, MasksOfTheGroupWhereRaysStart) {
    RTgroup root = groupOf({group({instance(squares(1), {material("hit_mark")})})});
    const float hit = shoot(root)[0];
    for (const RTvisibilitymask mask : {213u, 255u, 1u, 2u, 255u}) {
        ok(rtGroupSetVisibilityMask(root, mask));
        EXPECT_EQ(shoot(root)[0], hit) << mask;
    }
    ok(rtGroupSetVisibilityMask(root, 0));
    EXPECT_NE(shoot(root)[0], hit);
    ok(rtGroupSetVisibilityMask(root, 255));
    EXPECT_EQ(shoot(root)[0], hit);
}

} // namespace
} // namespace sunstone::api6
