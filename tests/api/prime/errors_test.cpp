// SPDX-License-Identifier: Apache-2.0
// Every function of OptiX Prime with wrong arguments: the code, the last error message, and that
// nothing is written. Handles that are null, garbage, of another kind, destroyed.
#include "fixture.h"

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <thread>

namespace prime_test {
namespace {

class PrimeErrors : public PrimeSetupTest {
protected:
    static constexpr auto kRays = RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX;
    static constexpr auto kHits = RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V;

    void SetUp() override {
        PrimeSetupTest::SetUp();
        ASSERT_RTP(rtpModelCreate(context, &model));
        ASSERT_RTP(rtpBufferDescCreate(context, RTP_BUFFER_FORMAT_VERTEX_FLOAT3,
                                       RTP_BUFFER_TYPE_HOST, data, &desc));
        ASSERT_RTP(rtpQueryCreate(model, RTP_QUERY_TYPE_ANY, &query));
    }
    // The call fails with the code, and the message names the function and contains the text.
    void expectError(RTPresult result, RTPresult expected, const char* text) {
        EXPECT_EQ(result, expected);
        EXPECT_NE(lastError().find(text), std::string::npos) << lastError();
    }

    float data[64] = {};
    RTPmodel model = nullptr;
    RTPbufferdesc desc = nullptr;
    RTPquery query = nullptr;
};

TEST_P(PrimeErrors, ContextCreate) {
    RTPcontext other = nullptr;
    EXPECT_EQ(rtpContextCreate(RTP_CONTEXT_TYPE_CPU, nullptr), RTP_ERROR_INVALID_VALUE);
    EXPECT_EQ(rtpContextCreate(RTPcontexttype(0x102), &other), RTP_ERROR_INVALID_VALUE);
    EXPECT_EQ(rtpContextCreate(RTPcontexttype(0), &other), RTP_ERROR_INVALID_VALUE);
    EXPECT_EQ(other, nullptr);
}

TEST_P(PrimeErrors, ContextThreads) {
    if (GetParam().context == RTP_CONTEXT_TYPE_CPU) {
        EXPECT_RTP(rtpContextSetCpuThreads(context, 1));
        EXPECT_RTP(rtpContextSetCpuThreads(context, 1000));
        EXPECT_RTP(rtpContextSetCpuThreads(context, 0));
        const unsigned number = 0;
        expectError(rtpContextSetCudaDeviceNumbers(context, 1, &number), RTP_ERROR_INVALID_VALUE,
                    "RTP_CONTEXT_TYPE_CUDA");
    } else {
        expectError(rtpContextSetCpuThreads(context, 1), RTP_ERROR_INVALID_VALUE,
                    "RTP_CONTEXT_TYPE_CPU");
        const unsigned numbers[2] = {0, 77};
        EXPECT_RTP(rtpContextSetCudaDeviceNumbers(context, 0, nullptr));
        EXPECT_RTP(rtpContextSetCudaDeviceNumbers(context, 1, numbers));
        expectError(rtpContextSetCudaDeviceNumbers(context, 1, nullptr), RTP_ERROR_INVALID_VALUE,
                    "deviceNumbers is null");
        expectError(rtpContextSetCudaDeviceNumbers(context, 2, numbers), RTP_ERROR_INVALID_VALUE,
                    "deviceNumbers[1] = 77");
    }
}

TEST_P(PrimeErrors, LastErrorString) {
    EXPECT_EQ(lastError(), "");
    EXPECT_EQ(rtpContextGetLastErrorString(context, nullptr), RTP_ERROR_INVALID_VALUE);
    const char* text = nullptr;
    EXPECT_EQ(rtpContextGetLastErrorString(nullptr, &text), RTP_ERROR_INVALID_VALUE);
    EXPECT_EQ(text, nullptr);
    expectError(rtpModelUpdate(model, 0), RTP_ERROR_INVALID_OPERATION, "rtpModelUpdate: ");
    // Errors of other threads are there, too.
    std::thread([&] { rtpQueryExecute(query, 0); }).join();
    EXPECT_NE(lastError().find("rtpQueryExecute: "), std::string::npos);
}

TEST_P(PrimeErrors, BufferDescCreate) {
    RTPbufferdesc other = nullptr;
    const auto create = [&](RTPbufferformat format, RTPbuffertype type, void* buffer,
                            RTPbufferdesc* to) {
        return rtpBufferDescCreate(context, format, type, buffer, to);
    };
    const auto kVertices = RTP_BUFFER_FORMAT_VERTEX_FLOAT3;
    expectError(create(kVertices, RTP_BUFFER_TYPE_HOST, data, nullptr), RTP_ERROR_INVALID_VALUE,
                "desc is null");
    expectError(create(RTPbufferformat(0x499), RTP_BUFFER_TYPE_HOST, data, &other),
                RTP_ERROR_INVALID_VALUE, "format = 0x499");
    expectError(create(kVertices, RTPbuffertype(0x202), data, &other), RTP_ERROR_INVALID_VALUE,
                "type = 0x202");
    expectError(create(kVertices, RTP_BUFFER_TYPE_HOST, reinterpret_cast<char*>(data) + 1, &other),
                RTP_ERROR_INVALID_VALUE, "aligned");
    EXPECT_EQ(rtpBufferDescCreate(nullptr, kVertices, RTP_BUFFER_TYPE_HOST, data, &other),
              RTP_ERROR_INVALID_VALUE);
    EXPECT_EQ(other, nullptr);
    RTPcontext of = nullptr;
    EXPECT_RTP(rtpBufferDescGetContext(desc, &of));
    EXPECT_EQ(of, context);
    expectError(rtpBufferDescGetContext(desc, nullptr), RTP_ERROR_INVALID_VALUE, "context is null");
}

TEST_P(PrimeErrors, BufferDescRange) {
    EXPECT_RTP(rtpBufferDescSetRange(desc, 3, 3));
    expectError(rtpBufferDescSetRange(desc, 4, 3), RTP_ERROR_INVALID_VALUE, "begin = 4");
    expectError(rtpBufferDescSetRange(desc, 0, ~RTPsize(0)), RTP_ERROR_INVALID_VALUE, "end = ");
    EXPECT_EQ(rtpBufferDescSetRange(nullptr, 0, 1), RTP_ERROR_INVALID_VALUE);
}

TEST_P(PrimeErrors, BufferDescStride) {
    EXPECT_RTP(rtpBufferDescSetStride(desc, 0));
    EXPECT_RTP(rtpBufferDescSetStride(desc, 12));
    EXPECT_RTP(rtpBufferDescSetStride(desc, 100));
    EXPECT_RTP(rtpBufferDescSetRange(desc, 0, RTPsize(1) << 40));
    expectError(rtpBufferDescSetStride(desc, 1u << 24), RTP_ERROR_INVALID_VALUE, "end = ");
    expectError(rtpBufferDescSetStride(desc, 8), RTP_ERROR_INVALID_VALUE, "less than the 12");
    expectError(rtpBufferDescSetStride(desc, 13), RTP_ERROR_INVALID_VALUE, "multiple of 4");
    for (const RTPbufferformat format :
         {RTP_BUFFER_FORMAT_INDICES_INT3, kRays, kHits, RTP_BUFFER_FORMAT_HIT_BITMASK,
          RTP_BUFFER_FORMAT_INSTANCE_MODEL}) {
        const Desc other(context, format, RTP_BUFFER_TYPE_HOST, data, 1);
        expectError(rtpBufferDescSetStride(other, 64), RTP_ERROR_INVALID_VALUE, "contiguous");
        EXPECT_RTP(rtpBufferDescSetStride(other, 0));
    }
    const Desc transforms(context, RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x3, RTP_BUFFER_TYPE_HOST, data,
                          1);
    EXPECT_RTP(rtpBufferDescSetStride(transforms, 64));
    expectError(rtpBufferDescSetStride(transforms, 60), RTP_ERROR_INVALID_VALUE, "multiple of 16");
    expectError(rtpBufferDescSetStride(transforms, 32), RTP_ERROR_INVALID_VALUE,
                "less than the 48");
}

TEST_P(PrimeErrors, BufferDescDevice) {
    expectError(rtpBufferDescSetCudaDeviceNumber(desc, 0), RTP_ERROR_INVALID_VALUE,
                "RTP_BUFFER_TYPE_CUDA_LINEAR");
    if (GetParam().context == RTP_CONTEXT_TYPE_CPU) {
        RTPbufferdesc other = nullptr;
        expectError(rtpBufferDescCreate(context, kRays, RTP_BUFFER_TYPE_CUDA_LINEAR, data, &other),
                    RTP_ERROR_NOT_SUPPORTED, "no CUDA driver");
        return;
    }
    const Desc device(context, kRays, RTP_BUFFER_TYPE_CUDA_LINEAR, data, 1);
    EXPECT_RTP(rtpBufferDescSetCudaDeviceNumber(device, 0));
    expectError(rtpBufferDescSetCudaDeviceNumber(device, 55), RTP_ERROR_INVALID_VALUE,
                "deviceNumber = 55");
}

TEST_P(PrimeErrors, ModelSetTriangles) {
    const Desc vertices(context, RTP_BUFFER_FORMAT_VERTEX_FLOAT3, RTP_BUFFER_TYPE_HOST, data, 9);
    const Desc indices(context, RTP_BUFFER_FORMAT_INDICES_INT3, RTP_BUFFER_TYPE_HOST, data, 3);
    expectError(rtpModelSetTriangles(model, nullptr, nullptr), RTP_ERROR_INVALID_VALUE,
                "vertices is null");
    expectError(rtpModelSetTriangles(model, nullptr, desc), RTP_ERROR_INVALID_VALUE,
                "rtpBufferDescSetRange");
    expectError(rtpModelSetTriangles(model, vertices, vertices), RTP_ERROR_INVALID_VALUE,
                "RTP_BUFFER_FORMAT_INDICES_INT3");
    expectError(rtpModelSetTriangles(model, indices, indices), RTP_ERROR_INVALID_VALUE,
                "RTP_BUFFER_FORMAT_VERTEX_FLOAT3");
    EXPECT_EQ(rtpModelSetTriangles(nullptr, indices, vertices), RTP_ERROR_INVALID_VALUE);
    EXPECT_RTP(rtpModelSetTriangles(model, indices, vertices));
}

TEST_P(PrimeErrors, ObjectsOfAnotherContext) {
    RTPcontext other = nullptr;
    ASSERT_RTP(rtpContextCreate(RTP_CONTEXT_TYPE_CPU, &other));
    {
        const Desc vertices(other, RTP_BUFFER_FORMAT_VERTEX_FLOAT3, RTP_BUFFER_TYPE_HOST, data, 9);
        const Desc rays(other, kRays, RTP_BUFFER_TYPE_HOST, data, 1);
        const Desc hits(other, kHits, RTP_BUFFER_TYPE_HOST, data, 1);
        expectError(rtpModelSetTriangles(model, nullptr, vertices), RTP_ERROR_INVALID_VALUE,
                    "another context");
        expectError(rtpQuerySetRays(query, rays), RTP_ERROR_INVALID_VALUE, "another context");
        expectError(rtpQuerySetHits(query, hits), RTP_ERROR_INVALID_VALUE, "another context");
        RTPmodel foreign = nullptr;
        ASSERT_RTP(rtpModelCreate(other, &foreign));
        const Desc instances(context, RTP_BUFFER_FORMAT_INSTANCE_MODEL, RTP_BUFFER_TYPE_HOST,
                             &foreign, 1);
        const Desc transforms(context, RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x4, RTP_BUFFER_TYPE_HOST,
                              data, 1);
        ASSERT_RTP(rtpModelSetInstances(model, instances, transforms));
        expectError(rtpModelUpdate(model, 0), RTP_ERROR_INVALID_VALUE,
                    "instances[0] belongs to another context");
    }
    EXPECT_RTP(rtpContextDestroy(other));
}

TEST_P(PrimeErrors, ModelSetInstances) {
    RTPmodel list[2] = {model, nullptr};
    const Desc instances(context, RTP_BUFFER_FORMAT_INSTANCE_MODEL, RTP_BUFFER_TYPE_HOST, list, 1);
    const Desc two(context, RTP_BUFFER_FORMAT_INSTANCE_MODEL, RTP_BUFFER_TYPE_HOST, list, 2);
    const Desc transforms(context, RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x3, RTP_BUFFER_TYPE_HOST, data,
                          1);
    expectError(rtpModelSetInstances(model, nullptr, transforms), RTP_ERROR_INVALID_VALUE,
                "instances is null");
    expectError(rtpModelSetInstances(model, instances, nullptr), RTP_ERROR_INVALID_VALUE,
                "transforms is null");
    expectError(rtpModelSetInstances(model, transforms, transforms), RTP_ERROR_INVALID_VALUE,
                "RTP_BUFFER_FORMAT_INSTANCE_MODEL");
    expectError(rtpModelSetInstances(model, instances, instances), RTP_ERROR_INVALID_VALUE,
                "RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x4");
    RTPmodel top = nullptr;
    ASSERT_RTP(rtpModelCreate(context, &top));
    ASSERT_RTP(rtpModelSetInstances(top, two, transforms));
    expectError(rtpModelUpdate(top, 0), RTP_ERROR_INVALID_VALUE, "range of 2");
    ASSERT_RTP(rtpModelSetInstances(top, instances, transforms));
    expectError(rtpModelUpdate(top, 0), RTP_ERROR_INVALID_OPERATION, "has not been updated");
    const float triangle[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    std::memcpy(data, triangle, sizeof(triangle));
    const Desc vertices(context, RTP_BUFFER_FORMAT_VERTEX_FLOAT3, RTP_BUFFER_TYPE_HOST, data, 3);
    ASSERT_RTP(rtpModelSetTriangles(model, nullptr, vertices));
    ASSERT_RTP(rtpModelUpdate(model, 0));
    float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const Desc one(context, RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x3, RTP_BUFFER_TYPE_HOST, identity,
                   1);
    ASSERT_RTP(rtpModelSetInstances(top, instances, one));
    EXPECT_RTP(rtpModelUpdate(top, 0));
    expectError(rtpModelUpdate(top, RTP_MODEL_HINT_MASK_UPDATE), RTP_ERROR_INVALID_VALUE,
                "models of triangles");
    // Neither instances of instances nor copies of them.
    RTPmodel topmost = nullptr;
    ASSERT_RTP(rtpModelCreate(context, &topmost));
    list[0] = top;
    ASSERT_RTP(rtpModelSetInstances(topmost, instances, one));
    expectError(rtpModelUpdate(topmost, 0), RTP_ERROR_INVALID_VALUE, "cannot be instanced");
    expectError(rtpModelCopy(topmost, top), RTP_ERROR_INVALID_VALUE, "only triangles");
    list[0] = reinterpret_cast<RTPmodel>(uintptr_t(0x1234560));
    expectError(rtpModelUpdate(topmost, 0), RTP_ERROR_INVALID_HANDLE, "instances[0]");
    list[0] = nullptr;
    expectError(rtpModelUpdate(topmost, 0), RTP_ERROR_INVALID_VALUE, "instances[0] is null");
    // Models of one list have equal parameters.
    RTPmodel caller = nullptr;
    const int yes = 1;
    ASSERT_RTP(rtpModelCreate(context, &caller));
    ASSERT_RTP(rtpModelSetBuilderParameter(caller, RTP_BUILDER_PARAM_USE_CALLER_TRIANGLES,
                                           sizeof(yes), &yes));
    ASSERT_RTP(rtpModelSetTriangles(caller, nullptr, vertices));
    ASSERT_RTP(rtpModelUpdate(caller, 0));
    list[0] = model;
    list[1] = caller;
    float both[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const Desc pair(context, RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x3, RTP_BUFFER_TYPE_HOST, both, 2);
    ASSERT_RTP(rtpModelSetInstances(topmost, two, pair));
    expectError(rtpModelUpdate(topmost, 0), RTP_ERROR_INVALID_VALUE, "USE_CALLER_TRIANGLES");
}

TEST_P(PrimeErrors, ModelUpdate) {
    expectError(rtpModelUpdate(model, 0), RTP_ERROR_INVALID_OPERATION, "rtpModelSetTriangles");
    for (const unsigned hints : {1u, 2u, 0x2008u, 0x4001u, ~0u})
        expectError(rtpModelUpdate(model, hints), RTP_ERROR_INVALID_VALUE, "hints = ");
    const Desc vertices(context, RTP_BUFFER_FORMAT_VERTEX_FLOAT3, RTP_BUFFER_TYPE_HOST, data, 4);
    ASSERT_RTP(rtpModelSetTriangles(model, nullptr, vertices));
    expectError(rtpModelUpdate(model, 0), RTP_ERROR_INVALID_VALUE, "every three");
    expectError(rtpModelUpdate(model, RTP_MODEL_HINT_USER_TRIANGLES_AFTER_COPY_SET),
                RTP_ERROR_INVALID_VALUE, "every three");
    ASSERT_RTP(rtpBufferDescSetRange(vertices, 0, 6));
    ASSERT_RTP(rtpModelSetTriangles(model, nullptr, vertices));
    expectError(rtpModelUpdate(model, RTP_MODEL_HINT_MASK_UPDATE), RTP_ERROR_INVALID_OPERATION,
                "RTP_MODEL_HINT_MASK_UPDATE");
    expectError(rtpModelUpdate(model, RTP_MODEL_HINT_USER_TRIANGLES_AFTER_COPY_SET),
                RTP_ERROR_INVALID_OPERATION, "no copy");
    ASSERT_RTP(rtpModelUpdate(model, 0));
    expectError(rtpModelUpdate(model, RTP_MODEL_HINT_MASK_UPDATE), RTP_ERROR_INVALID_VALUE,
                "INDICES_INT3_MASK_INT");
    const Desc masks(context, RTP_BUFFER_FORMAT_INDICES_INT3_MASK_INT, RTP_BUFFER_TYPE_HOST, data,
                     5);
    ASSERT_RTP(rtpModelSetTriangles(model, masks, vertices));
    expectError(rtpModelUpdate(model, RTP_MODEL_HINT_MASK_UPDATE), RTP_ERROR_INVALID_VALUE,
                "2 triangles, the new masks are 5");
}

TEST_P(PrimeErrors, ModelFunctions) {
    RTPcontext of = nullptr;
    EXPECT_RTP(rtpModelGetContext(model, &of));
    EXPECT_EQ(of, context);
    expectError(rtpModelGetContext(model, nullptr), RTP_ERROR_INVALID_VALUE, "context is null");
    expectError(rtpModelGetFinished(model, nullptr), RTP_ERROR_INVALID_VALUE, "isFinished is null");
    expectError(rtpModelCreate(context, nullptr), RTP_ERROR_INVALID_VALUE, "model is null");
    EXPECT_EQ(rtpModelCreate(nullptr, &model), RTP_ERROR_INVALID_VALUE);
    EXPECT_RTP(rtpModelFinish(model));
    RTPmodel other = nullptr;
    ASSERT_RTP(rtpModelCreate(context, &other));
    expectError(rtpModelCopy(model, other), RTP_ERROR_INVALID_OPERATION, "has not been updated");
    expectError(rtpModelCopy(model, model), RTP_ERROR_INVALID_VALUE, "the same");
    expectError(rtpModelCopy(model, nullptr), RTP_ERROR_INVALID_VALUE, "srcModel is null");
}

TEST_P(PrimeErrors, BuilderParameters) {
    const auto set = [&](RTPbuilderparam param, RTPsize size, const void* ptr) {
        return rtpModelSetBuilderParameter(model, param, size, ptr);
    };
    int value = 1;
    RTPsize chunk = ~RTPsize(0);
    EXPECT_RTP(set(RTP_BUILDER_PARAM_USE_CALLER_TRIANGLES, sizeof(int), &value));
    EXPECT_RTP(set(RTP_BUILDER_PARAM_CHUNK_SIZE, sizeof(RTPsize), &chunk));
    expectError(set(RTP_BUILDER_PARAM_USE_CALLER_TRIANGLES, 8, &chunk), RTP_ERROR_INVALID_VALUE,
                "size = 8");
    EXPECT_RTP(set(RTP_BUILDER_PARAM_CHUNK_SIZE, sizeof(int), &value));
    expectError(set(RTP_BUILDER_PARAM_CHUNK_SIZE, 2, &value), RTP_ERROR_INVALID_VALUE, "size = 2");
    expectError(set(RTP_BUILDER_PARAM_CHUNK_SIZE, 8, nullptr), RTP_ERROR_INVALID_VALUE,
                "ptr is null");
    expectError(set(RTPbuilderparam(0x802), 4, &value), RTP_ERROR_INVALID_VALUE, "0x802");
    value = 2;
    expectError(set(RTP_BUILDER_PARAM_USE_CALLER_TRIANGLES, sizeof(int), &value),
                RTP_ERROR_INVALID_VALUE, "neither 0 nor 1");
}

TEST_P(PrimeErrors, QueryFunctions) {
    RTPquery other = nullptr;
    expectError(rtpQueryCreate(model, RTPquerytype(0x1002), &other), RTP_ERROR_INVALID_VALUE,
                "queryType = 0x1002");
    expectError(rtpQueryCreate(model, RTP_QUERY_TYPE_ANY, nullptr), RTP_ERROR_INVALID_VALUE,
                "query is null");
    EXPECT_EQ(rtpQueryCreate(nullptr, RTP_QUERY_TYPE_ANY, &other), RTP_ERROR_INVALID_VALUE);
    RTPcontext of = nullptr;
    EXPECT_RTP(rtpQueryGetContext(query, &of));
    EXPECT_EQ(of, context);
    expectError(rtpQueryGetContext(query, nullptr), RTP_ERROR_INVALID_VALUE, "context is null");
    expectError(rtpQueryGetFinished(query, nullptr), RTP_ERROR_INVALID_VALUE, "isFinished is null");
    const Desc rays(context, kRays, RTP_BUFFER_TYPE_HOST, data, 1);
    const Desc hits(context, kHits, RTP_BUFFER_TYPE_HOST, data, 1);
    expectError(rtpQuerySetRays(query, hits), RTP_ERROR_INVALID_VALUE, "rays has format");
    expectError(rtpQuerySetHits(query, rays), RTP_ERROR_INVALID_VALUE, "hits has format");
    expectError(rtpQuerySetRays(query, nullptr), RTP_ERROR_INVALID_VALUE, "rays is null");
    expectError(rtpQuerySetHits(query, nullptr), RTP_ERROR_INVALID_VALUE, "hits is null");
    expectError(rtpQuerySetRays(query, reinterpret_cast<RTPbufferdesc>(model)),
                RTP_ERROR_INVALID_HANDLE, "rays = ");
}

TEST_P(PrimeErrors, QueryExecute) {
    Ray ray = {{0, 0, 0}, 0, {0, 0, 1}, 1};
    Hit hits[2] = {{7, 7, 7, 7, 7}, {7, 7, 7, 7, 7}};
    const Desc rayDesc(context, kRays, RTP_BUFFER_TYPE_HOST, &ray, 1);
    const Desc hitDesc(context, kHits, RTP_BUFFER_TYPE_HOST, hits, 2);
    expectError(rtpQueryExecute(query, 0), RTP_ERROR_INVALID_OPERATION, "rtpQuerySetRays");
    ASSERT_RTP(rtpQuerySetRays(query, rayDesc));
    expectError(rtpQueryExecute(query, 0), RTP_ERROR_INVALID_OPERATION, "rtpQuerySetHits");
    ASSERT_RTP(rtpQuerySetHits(query, hitDesc));
    expectError(rtpQueryExecute(query, 0), RTP_ERROR_INVALID_VALUE,
                "rays has a range of 1 elements, hits of 2");
    ASSERT_RTP(rtpBufferDescSetRange(hitDesc, 0, 1));
    expectError(rtpQueryExecute(query, 0), RTP_ERROR_INVALID_VALUE, "hits of 2"); // of a copy
    ASSERT_RTP(rtpQuerySetHits(query, hitDesc));
    expectError(rtpQueryExecute(query, 0), RTP_ERROR_INVALID_OPERATION, "rtpModelUpdate");
    for (const unsigned hints : {1u, 4u, 0x4004u, 0x2001u, ~0u})
        expectError(rtpQueryExecute(query, hints), RTP_ERROR_INVALID_VALUE, "hints = ");
    EXPECT_EQ(hits[0].t, 7);
}

// Memory that does not exist, ends within the range, or cannot be written.
TEST_P(PrimeErrors, MemoryOfBuffers) {
    const size_t page = 4096;
    auto* const pages = static_cast<char*>(
        mmap(nullptr, 2 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    ASSERT_NE(pages, MAP_FAILED);
    ASSERT_EQ(mprotect(pages + page, page, PROT_NONE), 0);
    const size_t rays = page / sizeof(Ray);
    std::vector<Hit> hits(rays + 1, Hit{7, 7, 7, 7, 7});
    const RTPmodel good = makeModel(soup(3, 0.3f, 1));
    RTPquery q = nullptr;
    ASSERT_RTP(rtpQueryCreate(good, RTP_QUERY_TYPE_CLOSEST, &q));
    const Desc rayDesc(context, kRays, RTP_BUFFER_TYPE_HOST, pages, rays + 1);
    const Desc hitDesc(context, kHits, RTP_BUFFER_TYPE_HOST, hits.data(), rays + 1);
    ASSERT_RTP(rtpQuerySetRays(q, rayDesc));
    ASSERT_RTP(rtpQuerySetHits(q, hitDesc));
    expectError(rtpQueryExecute(q, 0), RTP_ERROR_INVALID_VALUE, "rays: the range");
    EXPECT_EQ(hits[0].t, 7);
    ASSERT_RTP(rtpBufferDescSetRange(rayDesc, 0, 1));
    ASSERT_RTP(rtpQuerySetRays(q, rayDesc));
    const Desc outside(context, RTP_BUFFER_FORMAT_HIT_T, RTP_BUFFER_TYPE_HOST, pages + page, 1);
    ASSERT_RTP(rtpQuerySetHits(q, outside));
    expectError(rtpQueryExecute(q, 0), RTP_ERROR_INVALID_VALUE, "hits: the range");
    ASSERT_EQ(mprotect(pages + page, page, PROT_READ), 0);
    expectError(rtpQueryExecute(q, 0), RTP_ERROR_INVALID_VALUE, "hits: the range");
    // Null is the address of empty arrays only.
    const Desc null(context, RTP_BUFFER_FORMAT_HIT_T, RTP_BUFFER_TYPE_HOST, nullptr, 1);
    ASSERT_RTP(rtpQuerySetHits(q, null));
    expectError(rtpQueryExecute(q, 0), RTP_ERROR_INVALID_VALUE, "hits: the range");
    ASSERT_RTP(rtpBufferDescSetRange(null, 3, 4));
    ASSERT_RTP(rtpQuerySetHits(q, null));
    expectError(rtpQueryExecute(q, 0), RTP_ERROR_INVALID_VALUE, "hits: the range");
    // Vertices and indices, and instances.
    ASSERT_EQ(mprotect(pages + page, page, PROT_NONE), 0);
    const Desc vertices(context, RTP_BUFFER_FORMAT_VERTEX_FLOAT3, RTP_BUFFER_TYPE_HOST, pages,
                        3 * page);
    ASSERT_RTP(rtpModelSetTriangles(model, nullptr, vertices));
    expectError(rtpModelUpdate(model, 0), RTP_ERROR_INVALID_VALUE, "vertices: the range");
    const Desc few(context, RTP_BUFFER_FORMAT_VERTEX_FLOAT3, RTP_BUFFER_TYPE_HOST, pages, 3);
    const Desc indices(context, RTP_BUFFER_FORMAT_INDICES_INT3, RTP_BUFFER_TYPE_HOST, pages + page,
                       1);
    ASSERT_RTP(rtpModelSetTriangles(model, indices, few));
    expectError(rtpModelUpdate(model, RTP_MODEL_HINT_ASYNC), RTP_ERROR_INVALID_VALUE,
                "indices: the range");
    const Desc list(context, RTP_BUFFER_FORMAT_INSTANCE_MODEL, RTP_BUFFER_TYPE_HOST, pages + page,
                    1);
    const Desc transforms(context, RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x4, RTP_BUFFER_TYPE_HOST, data,
                          1);
    ASSERT_RTP(rtpModelSetInstances(model, list, transforms));
    expectError(rtpModelUpdate(model, 0), RTP_ERROR_INVALID_VALUE, "instances: the range");
    munmap(pages, 2 * page);
}

TEST_P(PrimeErrors, HandlesOfAllKinds) {
    const Desc vertices(context, RTP_BUFFER_FORMAT_VERTEX_FLOAT3, RTP_BUFFER_TYPE_HOST, data, 3);
    int finished = 0;
    RTPcontext of = nullptr;
    const char* text = nullptr;
    for (const uintptr_t garbage : {uintptr_t(1), uintptr_t(0xDEADBEEF), uintptr_t(data),
                                    uintptr_t(vertices.operator RTPbufferdesc())}) {
        const auto c = reinterpret_cast<RTPcontext>(garbage);
        EXPECT_EQ(rtpContextDestroy(c), RTP_ERROR_INVALID_CONTEXT);
        EXPECT_EQ(rtpContextSetCpuThreads(c, 1), RTP_ERROR_INVALID_CONTEXT);
        EXPECT_EQ(rtpContextSetCudaDeviceNumbers(c, 0, nullptr), RTP_ERROR_INVALID_CONTEXT);
        EXPECT_EQ(rtpContextGetLastErrorString(c, &text), RTP_ERROR_INVALID_CONTEXT);
        RTPmodel newModel = nullptr;
        EXPECT_EQ(rtpModelCreate(c, &newModel), RTP_ERROR_INVALID_CONTEXT);
        const auto m = reinterpret_cast<RTPmodel>(garbage);
        EXPECT_EQ(rtpModelDestroy(m), RTP_ERROR_INVALID_HANDLE);
        EXPECT_EQ(rtpModelUpdate(m, 0), RTP_ERROR_INVALID_HANDLE);
        EXPECT_EQ(rtpModelFinish(m), RTP_ERROR_INVALID_HANDLE);
        EXPECT_EQ(rtpModelGetFinished(m, &finished), RTP_ERROR_INVALID_HANDLE);
        EXPECT_EQ(rtpModelGetContext(m, &of), RTP_ERROR_INVALID_HANDLE);
        EXPECT_EQ(rtpModelCopy(m, model), RTP_ERROR_INVALID_HANDLE);
        EXPECT_EQ(rtpModelCopy(model, m), RTP_ERROR_INVALID_HANDLE);
        EXPECT_EQ(rtpModelSetTriangles(m, nullptr, vertices), RTP_ERROR_INVALID_HANDLE);
        EXPECT_EQ(rtpModelSetInstances(m, vertices, vertices), RTP_ERROR_INVALID_HANDLE);
        EXPECT_EQ(rtpModelSetBuilderParameter(m, RTP_BUILDER_PARAM_CHUNK_SIZE, 8, data),
                  RTP_ERROR_INVALID_HANDLE);
        RTPquery newQuery = nullptr;
        EXPECT_EQ(rtpQueryCreate(m, RTP_QUERY_TYPE_ANY, &newQuery), RTP_ERROR_INVALID_HANDLE);
        const auto q = reinterpret_cast<RTPquery>(garbage);
        EXPECT_EQ(rtpQueryDestroy(q), RTP_ERROR_INVALID_HANDLE);
        EXPECT_EQ(rtpQueryExecute(q, 0), RTP_ERROR_INVALID_HANDLE);
        EXPECT_EQ(rtpQueryFinish(q), RTP_ERROR_INVALID_HANDLE);
        EXPECT_EQ(rtpQueryGetFinished(q, &finished), RTP_ERROR_INVALID_HANDLE);
        EXPECT_EQ(rtpQueryGetContext(q, &of), RTP_ERROR_INVALID_HANDLE);
        EXPECT_EQ(rtpQuerySetRays(q, vertices), RTP_ERROR_INVALID_HANDLE);
        EXPECT_EQ(rtpQuerySetHits(q, vertices), RTP_ERROR_INVALID_HANDLE);
        EXPECT_EQ(rtpQuerySetCudaStream(q, nullptr), RTP_ERROR_INVALID_HANDLE);
    }
    const auto d = reinterpret_cast<RTPbufferdesc>(model);
    EXPECT_EQ(rtpBufferDescDestroy(d), RTP_ERROR_INVALID_HANDLE);
    EXPECT_EQ(rtpBufferDescSetRange(d, 0, 1), RTP_ERROR_INVALID_HANDLE);
    EXPECT_EQ(rtpBufferDescSetStride(d, 0), RTP_ERROR_INVALID_HANDLE);
    EXPECT_EQ(rtpBufferDescSetCudaDeviceNumber(d, 0), RTP_ERROR_INVALID_HANDLE);
    EXPECT_EQ(rtpBufferDescGetContext(d, &of), RTP_ERROR_INVALID_HANDLE);
    EXPECT_EQ(of, nullptr);
}

TEST_P(PrimeErrors, UseAfterDestruction) {
    EXPECT_RTP(rtpBufferDescDestroy(desc));
    EXPECT_EQ(rtpBufferDescDestroy(desc), RTP_ERROR_INVALID_HANDLE);
    EXPECT_EQ(rtpModelSetTriangles(model, nullptr, desc), RTP_ERROR_INVALID_HANDLE);
    EXPECT_RTP(rtpModelDestroy(model));
    expectError(rtpModelUpdate(model, 0), RTP_ERROR_INVALID_HANDLE, "rtpModelUpdate: model = ");
    expectError(rtpQueryFinish(query), RTP_ERROR_INVALID_HANDLE, "is not a live query");
    expectError(rtpQueryFinish(nullptr), RTP_ERROR_INVALID_VALUE, "query is null");
    expectError(rtpModelCreate(context, nullptr), RTP_ERROR_INVALID_VALUE, "rtpModelCreate: ");
    RTPmodel another = nullptr;
    RTPquery its = nullptr;
    ASSERT_RTP(rtpModelCreate(context, &another));
    ASSERT_RTP(rtpQueryCreate(another, RTP_QUERY_TYPE_ANY, &its));
    RTPbufferdesc late = nullptr;
    ASSERT_RTP(rtpBufferDescCreate(context, kRays, RTP_BUFFER_TYPE_HOST, data, &late));
    EXPECT_RTP(rtpContextDestroy(context));
    EXPECT_EQ(rtpContextDestroy(context), RTP_ERROR_INVALID_CONTEXT);
    EXPECT_EQ(rtpModelUpdate(another, 0), RTP_ERROR_INVALID_HANDLE);
    EXPECT_EQ(rtpQueryExecute(its, 0), RTP_ERROR_INVALID_HANDLE);
    EXPECT_EQ(rtpBufferDescDestroy(late), RTP_ERROR_INVALID_HANDLE);
    context = nullptr;
}

// Destruction waits for the work.
TEST_P(PrimeErrors, DestructionDuringWork) {
    const std::vector<Ray> rays = randomRays(20000, 1);
    Buffer<Ray> in(memory(), rays);
    Buffer<Hit> out(memory(), std::vector<Hit>(rays.size()));
    for (int i = 0; i < 6; ++i) {
        const RTPmodel its = makeModel(soup(500, 0.2f, 1));
        const Desc rayDesc(context, kRays, memory(), in);
        const Desc hitDesc(context, kHits, memory(), out);
        RTPquery q = nullptr;
        ASSERT_RTP(rtpQueryCreate(its, RTP_QUERY_TYPE_CLOSEST, &q));
        ASSERT_RTP(rtpQuerySetRays(q, rayDesc));
        ASSERT_RTP(rtpQuerySetHits(q, hitDesc));
        ASSERT_RTP(rtpQueryExecute(q, RTP_QUERY_HINT_ASYNC));
        if (i % 3 == 0) {
            EXPECT_RTP(rtpQueryDestroy(q));
        } else if (i % 3 == 1) {
            EXPECT_RTP(rtpModelDestroy(its));
        } else {
            EXPECT_RTP(rtpContextDestroy(context));
            ASSERT_RTP(rtpContextCreate(GetParam().context, &context));
        }
        EXPECT_NE(out.read()[rays.size() - 1].t, 0);
        std::fill(out.values().begin(), out.values().end(), Hit{});
        out.upload();
    }
}

INSTANTIATE_TEST_SUITE_P(All, PrimeErrors, testing::ValuesIn(setups()), nameOf);

TEST(PrimeMisc, Versions) {
    unsigned version = 0;
    EXPECT_RTP(rtpGetVersion(&version));
    EXPECT_EQ(version, 60000u);
    EXPECT_EQ(rtpGetVersion(nullptr), RTP_ERROR_INVALID_VALUE);
    const char* text = nullptr;
    EXPECT_RTP(rtpGetVersionString(&text));
    EXPECT_NE(std::string(text).find("6.0.0"), std::string::npos);
    EXPECT_EQ(rtpGetVersionString(nullptr), RTP_ERROR_INVALID_VALUE);
}

TEST(PrimeMisc, ErrorStrings) {
    std::vector<std::string> texts;
    for (int code : {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 999, 123456}) {
        const char* text = nullptr;
        EXPECT_RTP(rtpGetErrorString(RTPresult(code), &text));
        ASSERT_NE(text, nullptr);
        for (const std::string& other : texts)
            EXPECT_NE(other, text);
        texts.push_back(text);
    }
    EXPECT_EQ(rtpGetErrorString(RTP_SUCCESS, nullptr), RTP_ERROR_INVALID_VALUE);
}

TEST(PrimeMisc, HostBuffers) {
    std::vector<char> memory(100000);
    EXPECT_EQ(rtpHostBufferLock(nullptr, 4), RTP_ERROR_INVALID_VALUE);
    EXPECT_EQ(rtpHostBufferLock(memory.data(), 0), RTP_ERROR_INVALID_VALUE);
    EXPECT_EQ(rtpHostBufferLock(reinterpret_cast<void*>(0x10), 4), RTP_ERROR_INVALID_VALUE);
    EXPECT_EQ(rtpHostBufferUnlock(memory.data()), RTP_ERROR_INVALID_VALUE);
    EXPECT_EQ(rtpHostBufferUnlock(nullptr), RTP_ERROR_INVALID_VALUE);
    EXPECT_RTP(rtpHostBufferLock(memory.data(), memory.size()));
    EXPECT_EQ(rtpHostBufferLock(memory.data(), memory.size()), RTP_ERROR_INVALID_VALUE);
    EXPECT_RTP(rtpHostBufferUnlock(memory.data()));
    EXPECT_EQ(rtpHostBufferUnlock(memory.data()), RTP_ERROR_INVALID_VALUE);
}

// Several threads use one context, and several contexts.
TEST(PrimeMisc, ForkedChildrenSayWhyTheyFail) {
    RTPcontext context = nullptr;
    ASSERT_RTP(rtpContextCreate(RTP_CONTEXT_TYPE_CPU, &context));
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        RTPmodel model = nullptr;
        const char* text = nullptr;
        const bool fails = rtpModelCreate(context, &model) == RTP_ERROR_INVALID_OPERATION;
        const bool says = rtpContextGetLastErrorString(context, &text) == RTP_SUCCESS && text &&
                          std::strstr(text, "fork");
        _exit(fails && says ? 0 : 1);
    }
    int status = -1;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0);
    ASSERT_RTP(rtpContextDestroy(context));
}

TEST(PrimeMisc, Threads) {
    std::vector<std::thread> threads;
    RTPcontext shared = nullptr;
    ASSERT_RTP(rtpContextCreate(RTP_CONTEXT_TYPE_CPU, &shared));
    const Mesh mesh = soup(200, 0.3f, 1);
    for (int i = 0; i < 4; ++i)
        threads.emplace_back([&, i] {
            RTPcontext own = shared;
            if (i % 2)
                EXPECT_RTP(rtpContextCreate(RTP_CONTEXT_TYPE_CPU, &own));
            std::vector<Ray> rays = randomRays(300, unsigned(i));
            std::vector<Hit> hits(rays.size());
            std::vector<Float3> vertices = mesh.vertices;
            const Desc vertexDesc(own, RTP_BUFFER_FORMAT_VERTEX_FLOAT3, RTP_BUFFER_TYPE_HOST,
                                  vertices.data(), vertices.size());
            const Desc rayDesc(own, RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX,
                               RTP_BUFFER_TYPE_HOST, rays.data(), rays.size());
            const Desc hitDesc(own, RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V, RTP_BUFFER_TYPE_HOST,
                               hits.data(), hits.size());
            for (int round = 0; round < 10; ++round) {
                RTPmodel model = nullptr;
                RTPquery query = nullptr;
                EXPECT_RTP(rtpModelCreate(own, &model));
                EXPECT_RTP(rtpModelSetTriangles(model, nullptr, vertexDesc));
                EXPECT_RTP(rtpModelUpdate(model, RTP_MODEL_HINT_ASYNC));
                EXPECT_RTP(rtpQueryCreate(model, RTP_QUERY_TYPE_CLOSEST, &query));
                EXPECT_RTP(rtpQuerySetRays(query, rayDesc));
                EXPECT_RTP(rtpQuerySetHits(query, hitDesc));
                EXPECT_RTP(rtpQueryExecute(query, round % 2 ? RTP_QUERY_HINT_ASYNC : 0));
                EXPECT_RTP(rtpQueryFinish(query));
                EXPECT_RTP(rtpModelDestroy(model));
            }
            EXPECT_EQ(wrongHits(mesh, rays, hits), 0u);
            if (i % 2)
                EXPECT_RTP(rtpContextDestroy(own));
        });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_RTP(rtpContextDestroy(shared));
}

// While other threads use a context and its objects, its settings change and objects are destroyed:
// calls succeed or return an error.
TEST(PrimeMisc, ThreadsChangeWhatOthersUse) {
    RTPcontext context = nullptr;
    ASSERT_RTP(rtpContextCreate(RTP_CONTEXT_TYPE_CPU, &context));
    std::vector<Float3> vertices = soup(1, 0.3f, 1).vertices;
    const Desc vertexDesc(context, RTP_BUFFER_FORMAT_VERTEX_FLOAT3, RTP_BUFFER_TYPE_HOST,
                          vertices.data(), vertices.size());
    std::vector<Ray> rays = randomRays(1, 1);
    std::vector<Hit> hits(rays.size());
    const Desc rayDesc(context, RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX,
                       RTP_BUFFER_TYPE_HOST, rays.data(), rays.size());
    const Desc hitDesc(context, RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V, RTP_BUFFER_TYPE_HOST,
                       hits.data(), hits.size());
    std::atomic<RTPmodel> model = nullptr;
    std::atomic<RTPquery> query = nullptr;
    std::atomic<bool> ends = false;
    // One thread alone, because two would write the same hits.
    std::thread user([&] {
        while (!ends) {
            rtpModelUpdate(model, RTP_MODEL_HINT_ASYNC);
            rtpQueryExecute(query, RTP_QUERY_HINT_ASYNC);
            rtpQueryExecute(query, 0);
        }
    });
    for (int round = 0; round < 2000; ++round) {
        RTPmodel newModel = nullptr;
        RTPquery newQuery = nullptr;
        EXPECT_RTP(rtpModelCreate(context, &newModel));
        EXPECT_RTP(rtpModelSetTriangles(newModel, nullptr, vertexDesc));
        EXPECT_RTP(rtpModelUpdate(newModel, 0));
        EXPECT_RTP(rtpQueryCreate(newModel, RTP_QUERY_TYPE_CLOSEST, &newQuery));
        EXPECT_RTP(rtpQuerySetRays(newQuery, rayDesc));
        EXPECT_RTP(rtpQuerySetHits(newQuery, hitDesc));
        model = newModel;
        query = newQuery;
        EXPECT_RTP(rtpContextSetCpuThreads(context, 1));
        EXPECT_RTP(rtpContextSetCpuThreads(context, 0));
        if (round % 2)
            EXPECT_RTP(rtpQueryDestroy(newQuery));
        EXPECT_RTP(rtpModelDestroy(newModel));
    }
    ends = true;
    user.join();
    EXPECT_RTP(rtpContextDestroy(context));
}

#ifndef PRIME_TEST_CUDA
// Without a CUDA driver library, CPU contexts work and CUDA contexts are refused.
TEST(PrimeMisc, NoCudaDriver) {
    RTPcontext context = nullptr;
    EXPECT_EQ(rtpContextCreate(RTP_CONTEXT_TYPE_CUDA, &context), RTP_ERROR_OBJECT_CREATION_FAILED);
    EXPECT_EQ(context, nullptr);
}
#endif

} // namespace
} // namespace prime_test
