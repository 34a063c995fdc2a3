// SPDX-License-Identifier: Apache-2.0
// Stages and command lists by OptiXpp.
#include "support.h"

#include "optixu/optixpp_namespace.h"

#include <cmath>

namespace sunstone::api6 {
namespace {

class PostWrapper : public ::testing::Test {
protected:
    ~PostWrapper() override { context_->destroy(); }

    optix::Buffer image(unsigned width, unsigned height) {
        return context_->createBuffer(RT_BUFFER_INPUT_OUTPUT, RT_FORMAT_FLOAT4, width, height);
    }
    // The code of the exception that a body throws; RT_SUCCESS if it throws none.
    template <class Body>
    static RTresult thrownBy(const Body& body) {
        try {
            body();
        } catch (const optix::Exception& exception) {
            return exception.getErrorCode();
        }
        return RT_SUCCESS;
    }

    optix::Context context_ = optix::Context::create();
};

TEST_F(PostWrapper, RunsAListOfALaunchAndAStage) {
    optix::Buffer source = image(4, 2), result = image(4, 2);
    context_->setEntryPointCount(1);
    context_->setRayGenerationProgram(0,
                                      context_->createProgramFromPTXString(ptx(), "paint_image"));
    context_["image"]->set(source);
    context_["scoped"]->setFloat(0.25f);
    optix::PostprocessingStage tones =
        context_->createBuiltinPostProcessingStage("TonemapperSimple");
    tones->declareVariable("input_buffer")->set(source);
    tones->queryVariable("output_buffer")->set(result);
    tones["exposure"]->setFloat(0.5f);
    optix::CommandList list = context_->createCommandList();
    list->appendLaunch(0, 4, 2);
    list->appendPostprocessingStage(tones, 4, 2);
    list->finalize();
    list->execute();
    const float* made = static_cast<const float*>(result->map());
    EXPECT_NEAR(made[2], std::pow(0.125, 1 / 2.2), 1e-6);
    EXPECT_EQ(made[3], 0.25f);
    result->unmap();
    EXPECT_EQ(list->getContext()->get(), context_->get());
    EXPECT_EQ(tones->getContext()->get(), context_->get());
    EXPECT_EQ(tones->getVariableCount(), 4u);
    EXPECT_EQ(tones->getVariable(3)->getName(), "gamma");
    list->validate();
    tones->validate();
    list->destroy();
    tones->destroy();
}

TEST_F(PostWrapper, ThrowsWhatTheCallsReturn) {
    EXPECT_EQ(RT_ERROR_INVALID_VALUE,
              thrownBy([&] { context_->createBuiltinPostProcessingStage("none"); }));
    optix::PostprocessingStage tones =
        context_->createBuiltinPostProcessingStage("TonemapperSimple");
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, thrownBy([&] { tones->declareVariable("none"); }));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, thrownBy([&] { tones->getVariable(4); }));
    optix::CommandList list = context_->createCommandList();
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, thrownBy([&] { list->execute(); }));
    list->appendPostprocessingStage(tones, 1, 1);
    list->finalize();
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, thrownBy([&] { list->finalize(); }));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, thrownBy([&] { list->appendLaunch(0, 1, 1); }));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, thrownBy([&] { list->execute(); })) << "no buffers";
    EXPECT_NE(RT_SUCCESS, thrownBy([&] { context_->createBufferFromGLBO(RT_BUFFER_INPUT, 1); }));
}

} // namespace
} // namespace sunstone::api6
