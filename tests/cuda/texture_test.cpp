// SPDX-License-Identifier: Apache-2.0
// Arrays, textures and surfaces of the driver API: errors of wrong arguments, and copies.
#include <cuda.h>

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

namespace {

class Textures : public ::testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
        ASSERT_EQ(cuDevicePrimaryCtxRetain(&context_, 0), CUDA_SUCCESS);
        ASSERT_EQ(cuCtxSetCurrent(context_), CUDA_SUCCESS);
    }
    void TearDown() override { cuDevicePrimaryCtxRelease(0); }

    static CUarray makeArray(CUDA_ARRAY3D_DESCRIPTOR d) {
        CUarray array = nullptr;
        EXPECT_EQ(cuArray3DCreate(&array, &d), CUDA_SUCCESS);
        return array;
    }
    static CUDA_RESOURCE_DESC resourceOf(CUarray array) {
        CUDA_RESOURCE_DESC r = {};
        r.res.array.hArray = array;
        return r;
    }

    CUcontext context_ = nullptr;
};

TEST_F(Textures, ArraysThatCannotBe) {
    using D = CUDA_ARRAY3D_DESCRIPTOR;
    CUarray array = nullptr;
    for (const D& d : {D{0, 4, 0, CU_AD_FORMAT_FLOAT, 1, 0}, D{4, 4, 0, CU_AD_FORMAT_FLOAT, 3, 0},
                       D{4, 4, 0, CUarray_format(77), 1, 0}, D{4, 0, 4, CU_AD_FORMAT_FLOAT, 1, 0},
                       D{4, 4, 5, CU_AD_FORMAT_FLOAT, 1, CUDA_ARRAY3D_CUBEMAP},
                       D{4, 5, 6, CU_AD_FORMAT_FLOAT, 1, CUDA_ARRAY3D_CUBEMAP},
                       D{4, 4, 0, CU_AD_FORMAT_FLOAT, 1, CUDA_ARRAY3D_LAYERED},
                       D{4, 4, 0, CU_AD_FORMAT_FLOAT, 1, 0x8000},
                       D{size_t(1) << 40, 4, 0, CU_AD_FORMAT_FLOAT, 1, 0}})
        EXPECT_EQ(cuArray3DCreate(&array, &d), CUDA_ERROR_INVALID_VALUE);
    const D good = {4, 4, 0, CU_AD_FORMAT_FLOAT, 1, 0};
    EXPECT_EQ(cuArray3DCreate(nullptr, &good), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuArray3DCreate(&array, nullptr), CUDA_ERROR_INVALID_VALUE);
    const D sparse = {4, 4, 0, CU_AD_FORMAT_FLOAT, 1, CUDA_ARRAY3D_SPARSE};
    EXPECT_EQ(cuArray3DCreate(&array, &sparse), CUDA_ERROR_NOT_SUPPORTED);
    EXPECT_EQ(cuArrayDestroy(reinterpret_cast<CUarray>(0x1234)), CUDA_ERROR_INVALID_HANDLE);
    EXPECT_EQ(cuArrayDestroy(nullptr), CUDA_ERROR_INVALID_HANDLE);
    array = makeArray(good);
    EXPECT_EQ(cuArrayDestroy(array), CUDA_SUCCESS);
    EXPECT_EQ(cuArrayDestroy(array), CUDA_ERROR_INVALID_HANDLE);
}

TEST_F(Textures, CopiesStayInside) {
    const CUarray array = makeArray({4, 3, 2, CU_AD_FORMAT_UNSIGNED_INT16, 2, 0});
    std::vector<uint16_t> in(48), out(48);
    for (size_t i = 0; i < in.size(); ++i)
        in[i] = uint16_t(i * 7);
    CUDA_MEMCPY3D copy = {};
    copy.srcMemoryType = CU_MEMORYTYPE_HOST;
    copy.srcHost = in.data();
    copy.dstMemoryType = CU_MEMORYTYPE_ARRAY;
    copy.dstArray = array;
    copy.WidthInBytes = 16;
    copy.Height = 3;
    copy.Depth = 2;
    EXPECT_EQ(cuMemcpy3D(&copy), CUDA_SUCCESS);
    for (const auto field :
         {&CUDA_MEMCPY3D::dstXInBytes, &CUDA_MEMCPY3D::dstY, &CUDA_MEMCPY3D::dstZ}) {
        CUDA_MEMCPY3D outside = copy;
        for (const size_t offset : {size_t(1), ~size_t(0)}) {
            outside.*field = offset;
            EXPECT_EQ(cuMemcpy3D(&outside), CUDA_ERROR_INVALID_VALUE);
        }
    }
    CUDA_MEMCPY3D back = {};
    back.srcMemoryType = CU_MEMORYTYPE_ARRAY;
    back.srcArray = array;
    back.dstMemoryType = CU_MEMORYTYPE_HOST;
    back.dstHost = out.data();
    back.WidthInBytes = 16;
    back.Height = 3;
    back.Depth = 2;
    EXPECT_EQ(cuMemcpy3D(&back), CUDA_SUCCESS);
    EXPECT_EQ(in, out);
    back.srcArray = reinterpret_cast<CUarray>(&back);
    EXPECT_EQ(cuMemcpy3D(&back), CUDA_ERROR_INVALID_HANDLE);
    EXPECT_EQ(cuArrayDestroy(array), CUDA_SUCCESS);
}

TEST_F(Textures, RowsOfArraysAreCopied) {
    const CUarray a = makeArray({16, 0, 0, CU_AD_FORMAT_UNSIGNED_INT32, 1, 0});
    const CUarray b = makeArray({16, 0, 0, CU_AD_FORMAT_UNSIGNED_INT32, 1, 0});
    CUdeviceptr device = 0;
    CUstream stream = nullptr;
    ASSERT_EQ(cuMemAlloc(&device, 64), CUDA_SUCCESS);
    ASSERT_EQ(cuStreamCreate(&stream, 0), CUDA_SUCCESS);
    uint32_t in[16], out[16] = {}, zeros[16] = {};
    for (uint32_t i = 0; i < 16; ++i)
        in[i] = i * 0x01010101u;
    // Host to a, a to device, device to b three elements on, b to a, a to host.
    EXPECT_EQ(cuMemcpyHtoA(a, 0, in, 64), CUDA_SUCCESS);
    EXPECT_EQ(cuMemcpyAtoD(device, a, 16, 40), CUDA_SUCCESS);
    EXPECT_EQ(cuMemcpyHtoA(b, 0, zeros, 64), CUDA_SUCCESS);
    EXPECT_EQ(cuMemcpyDtoA(b, 12, device, 40), CUDA_SUCCESS);
    EXPECT_EQ(cuMemcpyAtoA(a, 8, b, 12, 40), CUDA_SUCCESS);
    EXPECT_EQ(cuMemcpyAtoH(out, a, 4, 48), CUDA_SUCCESS);
    EXPECT_EQ(out[0], in[1]);
    for (int i = 0; i < 10; ++i)
        EXPECT_EQ(out[i + 1], in[i + 4]) << i;
    EXPECT_EQ(out[11], in[12]);
    EXPECT_EQ(out[12], 0u);
    // In stream order.
    EXPECT_EQ(cuMemcpyHtoAAsync(b, 4, in, 60, stream), CUDA_SUCCESS);
    EXPECT_EQ(cuMemcpyAtoHAsync(out, b, 0, 64, stream), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamSynchronize(stream), CUDA_SUCCESS);
    EXPECT_EQ(out[0], 0u);
    EXPECT_EQ(std::memcmp(out + 1, in, 60), 0);
    // Ranges beyond the array or the allocation, and invalid objects.
    EXPECT_EQ(cuMemcpyHtoA(a, 4, in, 64), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyHtoA(a, ~size_t(3), in, 64), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyAtoD(device + 4, a, 0, 64), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyDtoA(a, 0, reinterpret_cast<CUdeviceptr>(in), 4), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyAtoH(nullptr, a, 0, 4), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyAtoA(a, 0, nullptr, 0, 4), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMemcpyAtoHAsync(out, reinterpret_cast<CUarray>(in), 0, 4, stream),
              CUDA_ERROR_INVALID_HANDLE);
    EXPECT_EQ(cuMemcpyHtoA(a, 0, in, 0), CUDA_SUCCESS);
    EXPECT_EQ(cuStreamDestroy(stream), CUDA_SUCCESS);
    EXPECT_EQ(cuMemFree(device), CUDA_SUCCESS);
    EXPECT_EQ(cuArrayDestroy(a), CUDA_SUCCESS);
    EXPECT_EQ(cuArrayDestroy(b), CUDA_SUCCESS);
}

TEST_F(Textures, ObjectsThatCannotBe) {
    const CUarray floats = makeArray({4, 4, 0, CU_AD_FORMAT_FLOAT, 1, 0});
    const CUarray ints = makeArray({4, 4, 0, CU_AD_FORMAT_UNSIGNED_INT32, 1, 0});
    CUDA_RESOURCE_DESC r = resourceOf(floats);
    CUDA_TEXTURE_DESC d = {};
    CUtexObject texture = 0;
    EXPECT_EQ(cuTexObjectCreate(nullptr, &r, &d, nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuTexObjectCreate(&texture, nullptr, &d, nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuTexObjectCreate(&texture, &r, nullptr, nullptr), CUDA_ERROR_INVALID_VALUE);
    d.flags = 0x1000;
    EXPECT_EQ(cuTexObjectCreate(&texture, &r, &d, nullptr), CUDA_ERROR_INVALID_VALUE);
    d.flags = 0;
    d.addressMode[1] = CUaddress_mode(9);
    EXPECT_EQ(cuTexObjectCreate(&texture, &r, &d, nullptr), CUDA_ERROR_INVALID_VALUE);
    d.addressMode[1] = CU_TR_ADDRESS_MODE_CLAMP;
    d.filterMode = CU_TR_FILTER_MODE_LINEAR;
    r = resourceOf(ints); // no filter between integers
    EXPECT_EQ(cuTexObjectCreate(&texture, &r, &d, nullptr), CUDA_ERROR_INVALID_VALUE);
    r = resourceOf(nullptr);
    EXPECT_EQ(cuTexObjectCreate(&texture, &r, &d, nullptr), CUDA_ERROR_INVALID_HANDLE);
    r.resType = CUresourcetype(7);
    EXPECT_EQ(cuTexObjectCreate(&texture, &r, &d, nullptr), CUDA_ERROR_INVALID_VALUE);
    r = {};
    r.resType = CU_RESOURCE_TYPE_LINEAR;
    r.res.linear = {0x1000, CU_AD_FORMAT_FLOAT, 1, 64};
    d.filterMode = CU_TR_FILTER_MODE_POINT;
    EXPECT_EQ(cuTexObjectCreate(&texture, &r, &d, nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuTexObjectDestroy(0), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuTexObjectDestroy(12345), CUDA_ERROR_INVALID_VALUE);
    CUsurfObject surface = 0;
    r = resourceOf(floats); // not made for surfaces
    EXPECT_EQ(cuSurfObjectCreate(&surface, &r), CUDA_ERROR_INVALID_VALUE);

    EXPECT_EQ(cuTexObjectCreate(&texture, &r, &d, nullptr), CUDA_SUCCESS);
    CUDA_RESOURCE_DESC seen = {};
    EXPECT_EQ(cuTexObjectGetResourceDesc(&seen, texture), CUDA_SUCCESS);
    EXPECT_EQ(seen.res.array.hArray, floats);
    EXPECT_EQ(cuSurfObjectDestroy(texture), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuArrayDestroy(floats), CUDA_SUCCESS); // before its texture
    EXPECT_EQ(cuTexObjectDestroy(texture), CUDA_SUCCESS);
    EXPECT_EQ(cuTexObjectDestroy(texture), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuArrayDestroy(ints), CUDA_SUCCESS);
}

TEST_F(Textures, MipmappedArrays) {
    const CUDA_ARRAY3D_DESCRIPTOR d = {16, 8, 0, CU_AD_FORMAT_HALF, 4, 0};
    CUmipmappedArray mipmap = nullptr;
    EXPECT_EQ(cuMipmappedArrayCreate(&mipmap, &d, 99), CUDA_SUCCESS);
    CUarray level = nullptr;
    EXPECT_EQ(cuMipmappedArrayGetLevel(&level, mipmap, 5), CUDA_ERROR_INVALID_VALUE);
    ASSERT_EQ(cuMipmappedArrayGetLevel(&level, mipmap, 4), CUDA_SUCCESS);
    CUDA_ARRAY3D_DESCRIPTOR smallest = {};
    EXPECT_EQ(cuArray3DGetDescriptor(&smallest, level), CUDA_SUCCESS);
    EXPECT_EQ(smallest.Width, 1u);
    EXPECT_EQ(smallest.Height, 1u);
    EXPECT_EQ(cuArrayDestroy(level), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuMipmappedArrayDestroy(mipmap), CUDA_SUCCESS);
    EXPECT_EQ(cuMipmappedArrayDestroy(mipmap), CUDA_ERROR_INVALID_HANDLE);
    EXPECT_EQ(cuArray3DGetDescriptor(&smallest, level), CUDA_ERROR_INVALID_HANDLE);
}

// Reads element (x, y) of a texture, by texel numbers and as floats.
constexpr const char* kReader = R"(
.version 7.0
.target sm_75
.address_size 64
.visible .entry readTexel(.param .u64 texture, .param .u64 out, .param .f32 x, .param .f32 y,
                          .param .u32 layer) {
    .reg .u64 %rd<3>;
    .reg .f32 %f<7>;
    .reg .u32 %r<2>;
    .reg .pred %p<2>;
    ld.param.u64 %rd1, [texture];
    ld.param.u64 %rd2, [out];
    ld.param.f32 %f1, [x];
    ld.param.f32 %f2, [y];
    ld.param.u32 %r1, [layer];
    setp.ne.u32 %p1, %r1, 99;
    @%p1 bra LAYERED;
    tex.2d.v4.f32.f32 {%f3, %f4, %f5, %f6}, [%rd1, {%f1, %f2}];
    bra STORE;
LAYERED:
    tex.a2d.v4.f32.f32 {%f3, %f4, %f5, %f6}, [%rd1, {%r1, %f1, %f2, %f2}];
STORE:
    st.global.v4.f32 [%rd2], {%f3, %f4, %f5, %f6};
    ret;
}
)";

class Views : public Textures {
protected:
    void SetUp() override {
        Textures::SetUp();
        ASSERT_EQ(cuModuleLoadData(&module_, kReader), CUDA_SUCCESS);
        ASSERT_EQ(cuModuleGetFunction(&reader_, module_, "readTexel"), CUDA_SUCCESS);
        ASSERT_EQ(cuMemAllocManaged(&out_, 16, CU_MEM_ATTACH_GLOBAL), CUDA_SUCCESS);
    }
    void TearDown() override {
        EXPECT_EQ(cuMemFree(out_), CUDA_SUCCESS);
        EXPECT_EQ(cuModuleUnload(module_), CUDA_SUCCESS);
        Textures::TearDown();
    }
    // Layer 99: not layered.
    std::vector<float> read(CUtexObject texture, float x, float y, unsigned layer = 99) {
        void* params[] = {&texture, &out_, &x, &y, &layer};
        EXPECT_EQ(cuLaunchKernel(reader_, 1, 1, 1, 1, 1, 1, 0, nullptr, params, nullptr),
                  CUDA_SUCCESS);
        EXPECT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
        const auto* values = reinterpret_cast<const float*>(out_);
        return {values, values + 4};
    }
    CUmodule module_ = nullptr;
    CUfunction reader_ = nullptr;
    CUdeviceptr out_ = 0;
};

// The form of compressed textures before arrays could have blocks.
TEST_F(Views, BlocksInIntegers) {
    const CUarray array = makeArray({2, 1, 0, CU_AD_FORMAT_UNSIGNED_INT32, 2, 0});
    // BC1: two colours of 5, 6 and 5 bits, then two bits a texel. Red; then green, blue below.
    const uint32_t blocks[] = {0xF800F800u, 0, 0x001F07E0u, 0x55550000u};
    CUDA_MEMCPY2D copy = {};
    copy.srcMemoryType = CU_MEMORYTYPE_HOST;
    copy.srcHost = blocks;
    copy.srcPitch = copy.WidthInBytes = 16;
    copy.Height = 1;
    copy.dstMemoryType = CU_MEMORYTYPE_ARRAY;
    copy.dstArray = array;
    ASSERT_EQ(cuMemcpy2D(&copy), CUDA_SUCCESS);
    const CUDA_RESOURCE_DESC r = resourceOf(array);
    CUDA_TEXTURE_DESC d = {};
    CUDA_RESOURCE_VIEW_DESC view = {};
    view.format = CU_RES_VIEW_FORMAT_UNSIGNED_BC1;
    view.width = 8;
    view.height = 4;
    CUtexObject texture = 0;
    ASSERT_EQ(cuTexObjectCreate(&texture, &r, &d, &view), CUDA_SUCCESS);
    using Texel = std::vector<float>;
    EXPECT_EQ(read(texture, 0.5f, 0.5f), (Texel{1, 0, 0, 1}));
    EXPECT_EQ(read(texture, 3.5f, 3.5f), (Texel{1, 0, 0, 1}));
    EXPECT_EQ(read(texture, 4.5f, 1.5f), (Texel{0, 1, 0, 1}));
    EXPECT_EQ(read(texture, 7.5f, 2.5f), (Texel{0, 0, 1, 1}));
    CUDA_RESOURCE_VIEW_DESC seen = {};
    ASSERT_EQ(cuTexObjectGetResourceViewDesc(&seen, texture), CUDA_SUCCESS);
    EXPECT_EQ(seen.format, CU_RES_VIEW_FORMAT_UNSIGNED_BC1);
    EXPECT_EQ(seen.width, 8u);
    EXPECT_EQ(cuTexObjectDestroy(texture), CUDA_SUCCESS);

    view.width = 2; // in texels, not in blocks
    EXPECT_EQ(cuTexObjectCreate(&texture, &r, &d, &view), CUDA_ERROR_INVALID_VALUE);
    view.width = 8;
    view.format = CU_RES_VIEW_FORMAT_UNSIGNED_BC3; // blocks of 16 bytes
    EXPECT_EQ(cuTexObjectCreate(&texture, &r, &d, &view), CUDA_ERROR_INVALID_VALUE);
    view.format = CUresourceViewFormat(35);
    EXPECT_EQ(cuTexObjectCreate(&texture, &r, &d, &view), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuArrayDestroy(array), CUDA_SUCCESS);
}

TEST_F(Views, OtherFormatsAndLayers) {
    const CUarray array =
        makeArray({1, 1, 4, CU_AD_FORMAT_UNSIGNED_INT32, 1, CUDA_ARRAY3D_LAYERED});
    const float values[] = {1.5f, 2.5f, 3.5f, 4.5f};
    CUDA_MEMCPY3D copy = {};
    copy.srcMemoryType = CU_MEMORYTYPE_HOST;
    copy.srcHost = values;
    copy.dstMemoryType = CU_MEMORYTYPE_ARRAY;
    copy.dstArray = array;
    copy.WidthInBytes = 4;
    copy.Height = 1;
    copy.Depth = 4;
    ASSERT_EQ(cuMemcpy3D(&copy), CUDA_SUCCESS);
    const CUDA_RESOURCE_DESC r = resourceOf(array);
    CUDA_TEXTURE_DESC d = {};
    CUDA_RESOURCE_VIEW_DESC view = {};
    view.format = CU_RES_VIEW_FORMAT_FLOAT_1X32;
    view.width = view.height = 1;
    view.firstLayer = 1;
    view.lastLayer = 2;
    CUtexObject texture = 0;
    ASSERT_EQ(cuTexObjectCreate(&texture, &r, &d, &view), CUDA_SUCCESS);
    EXPECT_EQ(read(texture, 0.5f, 0.5f, 0)[0], 2.5f);
    EXPECT_EQ(read(texture, 0.5f, 0.5f, 1)[0], 3.5f);
    EXPECT_EQ(read(texture, 0.5f, 0.5f, 5)[0], 3.5f); // the last one of the view
    EXPECT_EQ(cuTexObjectDestroy(texture), CUDA_SUCCESS);
    view.lastLayer = 4;
    EXPECT_EQ(cuTexObjectCreate(&texture, &r, &d, &view), CUDA_ERROR_INVALID_VALUE);
    view.lastLayer = ~0u;
    EXPECT_EQ(cuTexObjectCreate(&texture, &r, &d, &view), CUDA_ERROR_INVALID_VALUE);
    view.lastLayer = 0;
    EXPECT_EQ(cuTexObjectCreate(&texture, &r, &d, &view), CUDA_ERROR_INVALID_VALUE);
    view.lastLayer = 2;
    view.format = CU_RES_VIEW_FORMAT_FLOAT_1X16;
    EXPECT_EQ(cuTexObjectCreate(&texture, &r, &d, &view), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuArrayDestroy(array), CUDA_SUCCESS);
}

TEST_F(Views, NeedArrays) {
    CUDA_RESOURCE_DESC r = {};
    r.resType = CU_RESOURCE_TYPE_LINEAR;
    r.res.linear = {out_, CU_AD_FORMAT_UNSIGNED_INT32, 2, 16};
    CUDA_TEXTURE_DESC d = {};
    CUDA_RESOURCE_VIEW_DESC view = {};
    view.format = CU_RES_VIEW_FORMAT_UNSIGNED_BC1;
    view.width = 8;
    view.height = 4;
    CUtexObject texture = 0;
    EXPECT_EQ(cuTexObjectCreate(&texture, &r, &d, &view), CUDA_ERROR_INVALID_VALUE);
    view = {};
    EXPECT_EQ(cuTexObjectCreate(&texture, &r, &d, &view), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuTexObjectCreate(&texture, &r, &d, nullptr), CUDA_SUCCESS);
    EXPECT_EQ(cuTexObjectDestroy(texture), CUDA_SUCCESS);
}

} // namespace
