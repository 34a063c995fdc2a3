// SPDX-License-Identifier: Apache-2.0
// Features of CUDA contexts: streams, the current device, memory that does not belong to the
// device.
#include "fixture.h"

#include "cuda.h"

#include <dlfcn.h>

namespace prime_test {
namespace {

class PrimeCuda : public PrimeTest {
protected:
    void SetUp() override { open(RTP_CONTEXT_TYPE_CUDA); }
};

TEST_F(PrimeCuda, CreationMakesTheDeviceCurrent) {
    CUcontext current = nullptr;
    ASSERT_EQ(cuCtxGetCurrent(&current), CUDA_SUCCESS);
    EXPECT_NE(current, nullptr);
}

// Rays that earlier work of the stream writes, hits that later work reads.
TEST_F(PrimeCuda, QueriesRunInStreamOrder) {
    const Mesh mesh = soup(300, 0.3f, 1);
    const RTPmodel model = makeModel(mesh, RTP_BUFFER_TYPE_CUDA_LINEAR);
    const std::vector<Ray> rays = randomRays(4000, 2);
    Buffer<Ray> in(RTP_BUFFER_TYPE_CUDA_LINEAR, std::vector<Ray>(rays.size()));
    Buffer<Hit> out(RTP_BUFFER_TYPE_CUDA_LINEAR, std::vector<Hit>(rays.size()));
    const Desc rayDesc(context, RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX,
                       RTP_BUFFER_TYPE_CUDA_LINEAR, in);
    const Desc hitDesc(context, RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V,
                       RTP_BUFFER_TYPE_CUDA_LINEAR, out);
    CUstream stream = nullptr;
    ASSERT_EQ(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING), CUDA_SUCCESS);
    RTPquery query = nullptr;
    ASSERT_RTP(rtpQueryCreate(model, RTP_QUERY_TYPE_CLOSEST, &query));
    ASSERT_RTP(rtpQuerySetRays(query, rayDesc));
    ASSERT_RTP(rtpQuerySetHits(query, hitDesc));
    ASSERT_RTP(rtpQuerySetCudaStream(query, stream));
    std::vector<Hit> hits(rays.size());
    ASSERT_EQ(cuMemcpyHtoDAsync(CUdeviceptr(in.address()), rays.data(), in.bytes(), stream),
              CUDA_SUCCESS);
    ASSERT_RTP(rtpQueryExecute(query, RTP_QUERY_HINT_ASYNC));
    ASSERT_EQ(cuMemcpyDtoHAsync(hits.data(), CUdeviceptr(out.address()), out.bytes(), stream),
              CUDA_SUCCESS);
    ASSERT_EQ(cuStreamSynchronize(stream), CUDA_SUCCESS);
    EXPECT_EQ(wrongHits(mesh, rays, hits), 0u);
    ASSERT_RTP(rtpQueryFinish(query));
    // Back to the default stream.
    ASSERT_RTP(rtpQuerySetCudaStream(query, nullptr));
    ASSERT_RTP(rtpQueryExecute(query, 0));
    EXPECT_EQ(cuStreamDestroy(stream), CUDA_SUCCESS);
}

TEST_F(PrimeCuda, StreamsThatAreNone) {
    const RTPmodel model = makeModel(soup(3, 0.3f, 1));
    RTPquery query = nullptr;
    ASSERT_RTP(rtpQueryCreate(model, RTP_QUERY_TYPE_CLOSEST, &query));
    EXPECT_EQ(rtpQuerySetCudaStream(query, reinterpret_cast<cudaStream_t>(uintptr_t(0x123450))),
              RTP_ERROR_INVALID_VALUE);
    EXPECT_NE(lastError().find("live CUDA stream"), std::string::npos);
    // Drivers of GPUs read the memory of streams that have been destroyed.
    if (!dlsym(RTLD_DEFAULT, "sunstone_cuda_is_cpu_device"))
        return;
    // A stream that is destroyed after it was set.
    CUstream stream = nullptr;
    ASSERT_EQ(cuStreamCreate(&stream, 0), CUDA_SUCCESS);
    ASSERT_RTP(rtpQuerySetCudaStream(query, stream));
    ASSERT_EQ(cuStreamDestroy(stream), CUDA_SUCCESS);
    Buffer<Ray> in(RTP_BUFFER_TYPE_HOST, randomRays(2, 1));
    Buffer<Hit> out(RTP_BUFFER_TYPE_HOST, std::vector<Hit>(2));
    const Desc rayDesc(context, RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX,
                       RTP_BUFFER_TYPE_HOST, in);
    const Desc hitDesc(context, RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V, RTP_BUFFER_TYPE_HOST,
                       out);
    ASSERT_RTP(rtpQuerySetRays(query, rayDesc));
    ASSERT_RTP(rtpQuerySetHits(query, hitDesc));
    EXPECT_NE(rtpQueryExecute(query, 0), RTP_SUCCESS);
}

TEST_F(PrimeCuda, CapturedStreamsAreRefused) {
    const RTPmodel model = makeModel(soup(3, 0.3f, 1));
    Buffer<Ray> in(RTP_BUFFER_TYPE_HOST, randomRays(2, 1));
    Buffer<Hit> out(RTP_BUFFER_TYPE_HOST, std::vector<Hit>(2));
    const Desc rayDesc(context, RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX,
                       RTP_BUFFER_TYPE_HOST, in);
    const Desc hitDesc(context, RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V, RTP_BUFFER_TYPE_HOST,
                       out);
    CUstream stream = nullptr;
    ASSERT_EQ(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING), CUDA_SUCCESS);
    RTPquery query = nullptr;
    ASSERT_RTP(rtpQueryCreate(model, RTP_QUERY_TYPE_CLOSEST, &query));
    ASSERT_RTP(rtpQuerySetRays(query, rayDesc));
    ASSERT_RTP(rtpQuerySetHits(query, hitDesc));
    ASSERT_RTP(rtpQuerySetCudaStream(query, stream));
    ASSERT_EQ(cuStreamBeginCapture(stream, CU_STREAM_CAPTURE_MODE_THREAD_LOCAL), CUDA_SUCCESS);
    EXPECT_EQ(rtpQueryExecute(query, 0), RTP_ERROR_INVALID_OPERATION);
    EXPECT_EQ(rtpQueryExecute(query, RTP_QUERY_HINT_ASYNC), RTP_ERROR_INVALID_OPERATION);
    CUgraph graph = nullptr;
    EXPECT_EQ(cuStreamEndCapture(stream, &graph), CUDA_SUCCESS);
    cuGraphDestroy(graph);
    EXPECT_RTP(rtpQueryExecute(query, 0));
    cuStreamDestroy(stream);
}

// Host memory where device memory belongs, and ranges beyond an allocation.
TEST_F(PrimeCuda, MemoryThatIsNotTheDevices) {
    const RTPmodel model = makeModel(soup(3, 0.3f, 1));
    std::vector<Ray> rays = randomRays(8, 1);
    Buffer<Hit> out(RTP_BUFFER_TYPE_CUDA_LINEAR, std::vector<Hit>(8, Hit{7, 7, 7, 7, 7}));
    const Desc wrong(context, RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX,
                     RTP_BUFFER_TYPE_CUDA_LINEAR, rays.data(), rays.size());
    const Desc hitDesc(context, RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V,
                       RTP_BUFFER_TYPE_CUDA_LINEAR, out);
    RTPquery query = nullptr;
    ASSERT_RTP(rtpQueryCreate(model, RTP_QUERY_TYPE_CLOSEST, &query));
    ASSERT_RTP(rtpQuerySetRays(query, wrong));
    ASSERT_RTP(rtpQuerySetHits(query, hitDesc));
    EXPECT_EQ(rtpQueryExecute(query, 0), RTP_ERROR_INVALID_VALUE);
    EXPECT_NE(lastError().find("no address of CUDA memory"), std::string::npos) << lastError();
    EXPECT_EQ(out.read()[0].t, 7);
    // Beyond the end of the allocation: rays, then hits.
    constexpr size_t kMany = 1 << 20;
    Buffer<Ray> in(RTP_BUFFER_TYPE_CUDA_LINEAR, rays);
    const Desc tooMany(context, RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX,
                       RTP_BUFFER_TYPE_CUDA_LINEAR, in.address(), kMany);
    const Desc bits(context, RTP_BUFFER_FORMAT_HIT_BITMASK, RTP_BUFFER_TYPE_CUDA_LINEAR,
                    out.address(), kMany);
    ASSERT_RTP(rtpQuerySetRays(query, tooMany));
    ASSERT_RTP(rtpQuerySetHits(query, bits));
    EXPECT_EQ(rtpQueryExecute(query, 0), RTP_ERROR_INVALID_VALUE);
    EXPECT_NE(lastError().find("within one allocation"), std::string::npos) << lastError();
    const Desc vertices(context, RTP_BUFFER_FORMAT_VERTEX_FLOAT3, RTP_BUFFER_TYPE_CUDA_LINEAR,
                        in.address(), 3 * kMany);
    RTPmodel other = nullptr;
    ASSERT_RTP(rtpModelCreate(context, &other));
    ASSERT_RTP(rtpModelSetTriangles(other, nullptr, vertices));
    EXPECT_EQ(rtpModelUpdate(other, 0), RTP_ERROR_INVALID_VALUE);
    EXPECT_EQ(out.read()[0].t, 7);
}

// Page-locked memory of the host works as host memory and as memory that the device reaches.
TEST_F(PrimeCuda, PageLockedBuffers) {
    const Mesh mesh = soup(200, 0.3f, 1);
    const RTPmodel model = makeModel(mesh);
    std::vector<Ray> rays = randomRays(512, 3);
    ASSERT_RTP(rtpHostBufferLock(rays.data(), rays.size() * sizeof(Ray)));
    EXPECT_EQ(wrongHits(mesh, rays, trace(model, rays)), 0u);
    ASSERT_RTP(rtpHostBufferUnlock(rays.data()));
}

// A model of the CPU for a context of CUDA, where both share their format.
TEST_F(PrimeCuda, CopiesBetweenTypesOfContexts) {
    const Mesh mesh = soup(200, 0.3f, 1);
    const std::vector<Ray> rays = randomRays(400, 3);
    RTPcontext cpu = nullptr;
    ASSERT_RTP(rtpContextCreate(RTP_CONTEXT_TYPE_CPU, &cpu));
    std::swap(context, cpu);
    const RTPmodel source = makeModel(mesh);
    std::swap(context, cpu);
    RTPmodel copy = nullptr;
    ASSERT_RTP(rtpModelCreate(context, &copy));
    const RTPresult result = rtpModelCopy(copy, source);
    if (result == RTP_SUCCESS) {
        EXPECT_EQ(wrongHits(mesh, rays, trace(copy, rays)), 0u);
    } else {
        EXPECT_EQ(result, RTP_ERROR_NOT_SUPPORTED);
        EXPECT_NE(lastError().find("CPU"), std::string::npos);
    }
    EXPECT_RTP(rtpContextDestroy(cpu));
}

TEST_F(PrimeCuda, CpuContextsBesideCuda) {
    RTPcontext cpu = nullptr;
    ASSERT_RTP(rtpContextCreate(RTP_CONTEXT_TYPE_CPU, &cpu));
    std::swap(context, cpu);
    const Mesh mesh = soup(200, 0.3f, 1);
    const std::vector<Ray> rays = randomRays(400, 3);
    const RTPmodel model = makeModel(mesh);
    EXPECT_EQ(wrongHits(mesh, rays, trace(model, rays)), 0u);
    RTPquery query = nullptr;
    ASSERT_RTP(rtpQueryCreate(model, RTP_QUERY_TYPE_CLOSEST, &query));
    EXPECT_EQ(rtpQuerySetCudaStream(query, nullptr), RTP_ERROR_INVALID_VALUE);
    std::swap(context, cpu);
    EXPECT_RTP(rtpContextDestroy(cpu));
}

} // namespace
} // namespace prime_test
