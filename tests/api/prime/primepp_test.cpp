// SPDX-License-Identifier: Apache-2.0
// The classes of Prime++.
#include "fixture.h"

#include "optix_prime/optix_primepp.h"

namespace prime_test {
namespace {

using namespace optix::prime;

TEST(PrimePlusPlus, TrianglesAndInstances) {
    Context context = Context::create(RTP_CONTEXT_TYPE_CPU);
    context->setCpuThreads(2);
    const ::prime_test::Mesh mesh = soup(200, 0.3f, 1);
    std::vector<Ray> rays = randomRays(300, 2);
    std::vector<Hit> hits(rays.size());
    Model flat = context->createModel(), indexed = context->createModel(),
          top = context->createModel(), copy = context->createModel();
    flat->setTriangles(mesh.triangles.size(), RTP_BUFFER_TYPE_HOST, mesh.vertices.data());
    indexed->setTriangles(mesh.triangles.size(), RTP_BUFFER_TYPE_HOST, mesh.triangles.data(),
                          mesh.vertices.size(), RTP_BUFFER_TYPE_HOST, mesh.vertices.data(),
                          sizeof(Float3));
    indexed->setBuilderParameter(RTP_BUILDER_PARAM_USE_CALLER_TRIANGLES, 0);
    flat->update(RTP_MODEL_HINT_NONE);
    indexed->update(RTP_MODEL_HINT_ASYNC);
    indexed->finish();
    EXPECT_EQ(indexed->isFinished(), 1);
    copy->copy(flat);
    const RTPmodel list[1] = {indexed->getRTPmodel()};
    const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    top->setInstances(1, RTP_BUFFER_TYPE_HOST, list, RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x3,
                      RTP_BUFFER_TYPE_HOST, identity);
    top->update(0);
    for (const Model& model : {flat, indexed, top, copy}) {
        Query query = model->createQuery(RTP_QUERY_TYPE_CLOSEST);
        query->setRays(rays.size(), RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX,
                       RTP_BUFFER_TYPE_HOST, rays.data());
        query->setHits(hits.size(), RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V, RTP_BUFFER_TYPE_HOST,
                       hits.data());
        query->execute(RTP_QUERY_HINT_ASYNC);
        query->finish();
        EXPECT_EQ(query->isFinished(), 1);
        EXPECT_EQ(query->getContext().get(), context.get());
        EXPECT_EQ(wrongHits(mesh, rays, hits), 0u);
    }
}

TEST(PrimePlusPlus, HandlesOwnTheirObjects) {
    RTPmodel model = nullptr;
    RTPquery query = nullptr;
    RTPcontext context = nullptr;
    {
        Query last;
        {
            Context first = Context::create(RTP_CONTEXT_TYPE_CPU);
            context = first->getRTPcontext();
            Model itsModel = first->createModel();
            model = itsModel->getRTPmodel();
            last = itsModel->createQuery(RTP_QUERY_TYPE_ANY);
            query = last->getRTPquery();
            const Query other = last;
            last = other;
            EXPECT_TRUE(last.isValid());
        }
        int finished = 0;
        EXPECT_RTP(rtpQueryGetFinished(query, &finished)) << "the query keeps model and context";
        EXPECT_RTP(rtpModelGetFinished(model, &finished));
    }
    EXPECT_EQ(rtpModelFinish(model), RTP_ERROR_INVALID_HANDLE);
    EXPECT_EQ(rtpContextDestroy(context), RTP_ERROR_INVALID_CONTEXT);
}

TEST(PrimePlusPlus, ErrorsAreExceptions) {
    Context context = Context::create(RTP_CONTEXT_TYPE_CPU);
    Model model = context->createModel();
    try {
        model->update(0);
        FAIL() << "no exception";
    } catch (const Exception& error) {
        EXPECT_EQ(error.getErrorCode(), RTP_ERROR_INVALID_OPERATION);
        EXPECT_EQ(error.getErrorString(), context->getLastErrorMessage());
        EXPECT_NE(std::string(error.what()).find("rtpModelUpdate"), std::string::npos);
    }
    EXPECT_THROW(Context::create(RTPcontexttype(3)), Exception);
    EXPECT_THROW(context->setCudaDeviceNumbers(std::vector<unsigned>{0}), Exception);
    EXPECT_THROW(context->setCudaDeviceNumbers(0, nullptr), Exception);
    float data[9] = {};
    BufferDesc desc =
        context->createBufferDesc(RTP_BUFFER_FORMAT_VERTEX_FLOAT3, RTP_BUFFER_TYPE_HOST, data);
    EXPECT_THROW(desc->setRange(2, 1), Exception);
    EXPECT_THROW(desc->setStride(3), Exception);
    EXPECT_THROW(desc->setCudaDeviceNumber(0), Exception);
    EXPECT_EQ(desc->getContext().get(), context.get());
    desc->setRange(0, 3);
    model->setTriangles(desc);
    EXPECT_THROW(model->setTriangles(desc, desc), Exception);
    EXPECT_THROW(model->setInstances(desc, desc), Exception);
    EXPECT_THROW(model->createQuery(RTP_QUERY_TYPE_ANY)->setCudaStream(nullptr), Exception);
    EXPECT_EQ(Exception::makeException(RTP_ERROR_UNKNOWN).getErrorString(), "Unknown error");
    EXPECT_NE(getVersionString().find("6.0.0"), std::string::npos);
}

} // namespace
} // namespace prime_test
