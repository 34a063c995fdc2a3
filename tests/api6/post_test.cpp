// SPDX-License-Identifier: Apache-2.0
// Post-processing stages (section 5.19): their variables, results and errors.
#include "post_support.h"

namespace sunstone::api6 {
namespace {

class Stage : public Post {};
class ToneMapperStage : public Post {};
class DenoiserStage : public Post {};
class PredictorStage : public Post {};

const auto kGarbage = reinterpret_cast<RTpostprocessingstage>(uintptr_t(0x1234));

TEST_F(Stage, HasANameThatIsBuiltIn) {
    RTpostprocessingstage made = kGarbage;
    fails(RT_ERROR_INVALID_VALUE, rtPostProcessingStageCreateBuiltin(context_, "Sharpen", &made),
          "\"Sharpen\" is none of the stages TonemapperSimple, DLDenoiser, DLSSIMPredictor");
    EXPECT_EQ(made, nullptr);
    fails(RT_ERROR_INVALID_VALUE, rtPostProcessingStageCreateBuiltin(context_, nullptr, &made),
          "builtinName is null");
    fails(RT_ERROR_INVALID_VALUE,
          rtPostProcessingStageCreateBuiltin(context_, "DLDenoiser", nullptr), "stage is null");
    EXPECT_EQ(RT_ERROR_INVALID_CONTEXT,
              rtPostProcessingStageCreateBuiltin(nullptr, "DLDenoiser", &made));
}

TEST_F(Stage, HasPredefinedVariables) {
    const struct {
        const char* name;
        std::vector<std::string> variables;
    } stages[] = {{"TonemapperSimple", {"input_buffer", "output_buffer", "exposure", "gamma"}},
                  {"DLDenoiser",
                   {"input_buffer", "output_buffer", "input_albedo_buffer", "input_normal_buffer",
                    "blend", "hdr", "maxmem", "overlap", "training_data_buffer"}},
                  {"DLSSIMPredictor",
                   {"input_buffer", "output_buffer", "input_albedo_buffer", "input_normal_buffer",
                    "hdr", "training_data_buffer"}}};
    for (const auto& wanted : stages) {
        RTpostprocessingstage made = stage(wanted.name);
        unsigned count = 0;
        ok(rtPostProcessingStageGetVariableCount(made, &count));
        ASSERT_EQ(count, wanted.variables.size());
        for (unsigned i = 0; i < count; ++i) {
            RTvariable variable = nullptr;
            const char* name = nullptr;
            RTobjecttype type = RT_OBJECTTYPE_INT;
            ok(rtPostProcessingStageGetVariable(made, i, &variable));
            ok(rtVariableGetName(variable, &name));
            EXPECT_EQ(wanted.variables[i], name);
            ok(rtVariableGetType(variable, &type));
            EXPECT_EQ(type, RT_OBJECTTYPE_UNKNOWN);
            EXPECT_EQ(of(made, name), variable);
        }
        RTvariable variable = of(made, "input_buffer");
        fails(RT_ERROR_INVALID_VALUE, rtPostProcessingStageGetVariable(made, count, &variable),
              "of " + std::to_string(count) + " variables");
        EXPECT_EQ(variable, nullptr);
    }
}

TEST_F(Stage, VariablesAreQueriedOrDeclaredOnce) {
    RTpostprocessingstage made = stage("TonemapperSimple");
    RTvariable queried = of(made, "exposure"), declared = nullptr, again = queried;
    ok(rtPostProcessingStageDeclareVariable(made, "exposure", &declared));
    EXPECT_EQ(declared, queried);
    fails(RT_ERROR_VARIABLE_REDECLARED,
          rtPostProcessingStageDeclareVariable(made, "exposure", &again), "\"exposure\"");
    EXPECT_EQ(again, nullptr);
    again = queried;
    fails(RT_ERROR_INVALID_VALUE, rtPostProcessingStageDeclareVariable(made, "contrast", &again),
          "\"contrast\" is no variable");
    EXPECT_EQ(again, nullptr);
    again = queried;
    ok(rtPostProcessingStageQueryVariable(made, "contrast", &again));
    EXPECT_EQ(again, nullptr);
    ok(rtVariableSet1f(declared, 2));
    EXPECT_EQ(RT_ERROR_TYPE_MISMATCH, rtVariableSet1i(queried, 2));
}

TEST_F(Stage, RefusesHandlesAndPointersThatAreNone) {
    RTvariable variable = nullptr;
    RTcontext context = nullptr;
    unsigned count = 0;
    for (const RTpostprocessingstage none :
         {RTpostprocessingstage(), kGarbage, reinterpret_cast<RTpostprocessingstage>(list())}) {
        EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtPostProcessingStageDestroy(none));
        EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtPostProcessingStageGetContext(none, &context));
        EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtPostProcessingStageGetVariableCount(none, &count));
        EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtPostProcessingStageGetVariable(none, 0, &variable));
        EXPECT_EQ(RT_ERROR_INVALID_VALUE,
                  rtPostProcessingStageQueryVariable(none, "gamma", &variable));
        EXPECT_EQ(RT_ERROR_INVALID_VALUE,
                  rtPostProcessingStageDeclareVariable(none, "gamma", &variable));
    }
    RTpostprocessingstage made = stage("TonemapperSimple");
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtPostProcessingStageGetContext(made, nullptr));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtPostProcessingStageGetVariableCount(made, nullptr));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtPostProcessingStageGetVariable(made, 0, nullptr));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtPostProcessingStageQueryVariable(made, "gamma", nullptr));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtPostProcessingStageQueryVariable(made, nullptr, &variable));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtPostProcessingStageDeclareVariable(made, "gamma", nullptr));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE,
              rtPostProcessingStageDeclareVariable(made, nullptr, &variable));
    ok(rtPostProcessingStageGetContext(made, &context));
    EXPECT_EQ(context, context_);
}

TEST_F(Stage, TakesItsVariablesAlongWhenDestroyed) {
    RTpostprocessingstage made = stage("DLDenoiser");
    RTvariable blend = of(made, "blend");
    unsigned count = 0;
    ok(rtPostProcessingStageDestroy(made));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtPostProcessingStageDestroy(made));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtPostProcessingStageGetVariableCount(made, &count));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtVariableSet1f(blend, 0.5f));
}

TEST_F(Stage, ChecksItsBuffersWhenItRuns) {
    RTpostprocessingstage tones = stage("TonemapperSimple");
    RTcommandlist commands = listOf({tones});
    const auto failsWith = [&](RTresult result, const char* word) {
        fails(result, rtCommandListExecute(commands), word);
    };
    failsWith(RT_ERROR_INVALID_VALUE,
              "\"input_buffer\" of stage \"TonemapperSimple\" has no value");
    RTbuffer input = nullptr;
    ok(rtBufferCreate(context_, RT_BUFFER_INPUT_OUTPUT, &input));
    set(tones, "input_buffer", input);
    failsWith(RT_ERROR_INVALID_CONTEXT, "no format");
    ok(rtBufferSetFormat(input, RT_FORMAT_UNSIGNED_BYTE4));
    ok(rtBufferSetSize2D(input, 3, 2));
    failsWith(RT_ERROR_INVALID_VALUE, "FLOAT3, FLOAT4, HALF3 or HALF4");
    ok(rtBufferSetFormat(input, RT_FORMAT_FLOAT3));
    ok(rtBufferSetSize1D(input, 6));
    failsWith(RT_ERROR_INVALID_VALUE, "1 dimensions");
    ok(rtBufferSetSize2D(input, 3, 2));
    failsWith(RT_ERROR_INVALID_VALUE, "\"output_buffer\"");
    RTbuffer output = image(2, 2);
    set(tones, "output_buffer", output);
    failsWith(RT_ERROR_INVALID_VALUE, "2 x 2 elements, but 3 x 2 are needed");
    ok(rtBufferSetSize2D(output, 3, 2));
    void* data = nullptr;
    ok(rtBufferMap(output, &data));
    failsWith(RT_ERROR_ALREADY_MAPPED, "\"output_buffer\"");
    ok(rtBufferUnmap(output));
    ok(rtCommandListExecute(commands));
    ok(rtBufferDestroy(output));
    failsWith(RT_ERROR_INVALID_VALUE, "destroyed buffer");
    RTtexturesampler sampler = nullptr;
    ok(rtTextureSamplerCreate(context_, &sampler));
    RTpostprocessingstage other = stage("TonemapperSimple");
    ok(rtVariableSetObject(of(other, "input_buffer"), sampler));
    fails(RT_ERROR_TYPE_MISMATCH, rtCommandListExecute(listOf({other})),
          "needs a buffer, not a texture sampler");
    RTpostprocessingstage third = stage("TonemapperSimple");
    set(third, "input_buffer", 1.0f);
    fails(RT_ERROR_TYPE_MISMATCH, rtCommandListExecute(listOf({third})), "not data");
}

TEST_F(Stage, OfEmptyBuffersDoesNothing) {
    RTbuffer input = image(0, 0), output = image(0, 0);
    run(toneMapper(input, output));
    run(denoiser(input, output));
}

// ---- The tone mapper ---------------------------------------------------------------------------

TEST_F(ToneMapperStage, ExposesAndRaises) {
    RTbuffer input = image(2, 2), output = image(2, 2);
    const std::vector<float> given = {0.5f,  0.25f, 4.0f,  0.1f, 0.0f, 1.0f,     0.7f, 0.2f,
                                      -1.0f, NAN,   0.01f, 5.0f, 2.0f, INFINITY, 0.3f, 1.0f};
    fill(input, given);
    RTpostprocessingstage tones = toneMapper(input, output);
    const auto expectTones = [&](double exposure, double gamma) {
        run(tones);
        const std::vector<float> made = floats(output);
        for (size_t i = 0; i < given.size(); ++i) {
            const double exposed = std::min(double(given[i]) * exposure, 1.0);
            const double wanted = exposed > 0 ? std::pow(exposed, 1 / gamma) : 0.0;
            EXPECT_NEAR(made[i], i % 4 == 3 ? double(given[i]) : wanted, 1e-6) << i;
        }
    };
    expectTones(1.0, 2.2); // the defaults
    set(tones, "exposure", 0.5f);
    ok(rtVariableSet1i(of(tones, "gamma"), 3)); // numbers of any type
    expectTones(0.5, 3.0);
    ok(rtVariableSet1i(of(tones, "gamma"), 1));
    expectTones(0.5, 1.0);
}

TEST_F(ToneMapperStage, TakesThreeComponentsHalvesAndItsOwnInput) {
    RTbuffer input = image(3, 1, RT_FORMAT_FLOAT3), output = image(3, 1, RT_FORMAT_FLOAT4);
    fill<float>(input, {0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f, 0.7f, 0.8f, 0.9f});
    RTpostprocessingstage tones = toneMapper(input, output);
    set(tones, "gamma", 1.0f);
    run(tones);
    const std::vector<float> made = floats(output);
    EXPECT_FLOAT_EQ(made[4], 0.4f);
    EXPECT_EQ(made[7], 1.0f) << "alpha of an image without";
    RTbuffer halves = image(2, 1, RT_FORMAT_HALF3);
    fill<uint16_t>(halves, {0x3800, 0x3400, 0x3000, 0, 0x3c00, 0x4000}); // 1/2 1/4 1/8 0 1 2
    tones = toneMapper(halves, halves);
    set(tones, "gamma", 1.0f);
    set(tones, "exposure", 2.0f);
    run(tones);
    void* data = nullptr;
    ok(rtBufferMap(halves, &data));
    const std::vector<uint16_t> now(static_cast<uint16_t*>(data), static_cast<uint16_t*>(data) + 6);
    ok(rtBufferUnmap(halves));
    EXPECT_EQ(now, (std::vector<uint16_t>{0x3c00, 0x3800, 0x3400, 0, 0x3c00, 0x3c00}));
}

TEST_F(ToneMapperStage, RefusesNumbersThatAreNone) {
    RTbuffer picture = image(2, 2);
    for (const float value : {-1.0f, float(NAN), float(INFINITY)})
        for (const char* name : {"exposure", "gamma"}) {
            RTpostprocessingstage tones = toneMapper(picture, picture);
            set(tones, name, value);
            fails(RT_ERROR_INVALID_VALUE, rtCommandListExecute(listOf({tones})), name);
        }
    RTpostprocessingstage tones = toneMapper(picture, picture);
    set(tones, "gamma", 0.0f);
    fails(RT_ERROR_INVALID_VALUE, rtCommandListExecute(listOf({tones})), "gamma");
    tones = toneMapper(picture, picture);
    ok(rtVariableSet2f(of(tones, "exposure"), 1, 1));
    fails(RT_ERROR_TYPE_MISMATCH, rtCommandListExecute(listOf({tones})), "needs a float");
}

// ---- The denoiser ------------------------------------------------------------------------------

constexpr unsigned kWidth = 96, kHeight = 64;

TEST_F(DenoiserStage, TakesNoiseAwayAndKeepsAlpha) {
    RTbuffer input = image(kWidth, kHeight), output = image(kWidth, kHeight);
    const std::vector<float> noisy = noisyEdge(kWidth, kHeight, 0.2f),
                             clean = noisyEdge(kWidth, kHeight, 0);
    fill(input, noisy);
    run(denoiser(input, output));
    const std::vector<float> made = floats(output);
    EXPECT_LT(meanError(made, clean), 0.3 * meanError(noisy, clean));
    EXPECT_EQ(made[3], 0.5f);
}

TEST_F(DenoiserStage, BlendsTheInputIn) {
    RTbuffer input = image(kWidth, kHeight), output = image(kWidth, kHeight);
    const std::vector<float> noisy = noisyEdge(kWidth, kHeight, 0.1f);
    fill(input, noisy);
    RTpostprocessingstage made = denoiser(input, output);
    run(made);
    const std::vector<float> denoised = floats(output);
    set(made, "blend", 1.0f);
    run(made);
    EXPECT_LT(meanError(floats(output), noisy), 1e-6);
    set(made, "blend", 0.5f);
    run(made);
    std::vector<float> half = noisy;
    for (size_t i = 0; i < half.size(); ++i)
        half[i] = 0.5f * (noisy[i] + denoised[i]);
    EXPECT_LT(meanError(floats(output), half), 1e-6);
    set(made, "blend", 1.5f);
    fails(RT_ERROR_INVALID_VALUE, rtCommandListExecute(listOf({made})), "blend");
}

// Unlimited colours: the result does not depend on the brightness of the whole picture.
TEST_F(DenoiserStage, FollowsTheBrightnessOfHighRange) {
    RTbuffer input = image(kWidth, kHeight), output = image(kWidth, kHeight);
    RTpostprocessingstage made = denoiser(input, output);
    ok(rtVariableSet1ui(of(made, "hdr"), 1));
    double errors[2];
    for (int i = 0; i < 2; ++i) {
        const float scale = i == 0 ? 1.0f : 4096.0f;
        fill(input, noisyEdge(kWidth, kHeight, 0.2f, scale));
        run(made);
        errors[i] = meanError(floats(output), noisyEdge(kWidth, kHeight, 0, scale)) / double(scale);
    }
    EXPECT_LT(errors[0], 0.03);
    EXPECT_NEAR(errors[0], errors[1], 1e-3);
    for (const float bad : {0.0f, 1e35f}) { // black; brighter than the filter can scale
        fill(input, noisyEdge(kWidth, kHeight, 0.2f, bad));
        run(made);
    }
}

TEST_F(DenoiserStage, GuidesKeepWhatTheyShow) {
    RTbuffer input = image(kWidth, kHeight), output = image(kWidth, kHeight),
             albedo = image(kWidth, kHeight, RT_FORMAT_FLOAT3),
             normal = image(kWidth, kHeight, RT_FORMAT_FLOAT4);
    // A fine pattern that the albedo shows, below strong noise.
    std::vector<float> colors = noisyEdge(kWidth, kHeight, 0.25f), truth, guide,
                       normals(4 * kWidth * kHeight);
    for (unsigned i = 0; i < kWidth * kHeight; ++i) {
        const float tone = (i % kWidth / 3 + i / kWidth / 3) % 2 ? 0.8f : 0.3f;
        for (int c = 0; c < 3; ++c) {
            guide.push_back(tone);
            colors[4 * i + c] *= tone;
            truth.push_back((i % kWidth < kWidth / 2 ? 0.25f : 0.75f) * tone);
        }
        truth.push_back(0.5f);
        normals[4 * i + 2] = 1.0f;
    }
    fill(input, colors);
    fill(albedo, guide);
    fill(normal, normals);
    RTpostprocessingstage made = denoiser(input, output);
    ok(rtVariableSet1ui(of(made, "hdr"), 1));
    run(made);
    const double plain = meanError(floats(output), truth);
    set(made, "input_normal_buffer", normal);
    fails(RT_ERROR_INVALID_VALUE, rtCommandListExecute(listOf({made})), "\"input_albedo_buffer\"");
    set(made, "input_albedo_buffer", albedo);
    run(made);
    EXPECT_LT(meanError(floats(output), truth), 0.7 * plain);
    set(made, "input_albedo_buffer", image(kWidth, kHeight + 1));
    fails(RT_ERROR_INVALID_VALUE, rtCommandListExecute(listOf({made})),
          "\"input_albedo_buffer\" of stage \"DLDenoiser\" has a buffer of 96 x 65 elements");
}

TEST_F(DenoiserStage, TilesGiveWhatTheWholeGives) {
    constexpr unsigned kLong = 420, kShort = 300;
    RTbuffer input = image(kLong, kShort), output = image(kLong, kShort);
    fill(input, noisyEdge(kLong, kShort, 0.2f));
    RTpostprocessingstage made = denoiser(input, output);
    ok(rtVariableSet1ui(of(made, "hdr"), 1));
    run(made);
    const std::vector<float> whole = floats(output);
    fill(output, std::vector<float>(whole.size()));
    ok(rtVariableSet1ui(of(made, "overlap"), 64));
    set(made, "maxmem", 6e6f); // bytes; the whole takes twice as much
    run(made);
    EXPECT_EQ(floats(output), whole);
    set(made, "output_buffer", input); // in place
    run(made);
    EXPECT_EQ(floats(input), whole);
    set(made, "input_albedo_buffer", output); // as a guide, and as the result
    set(made, "output_buffer", output);
    const auto guided = [&](float limit) {
        fill(output, noisyEdge(kLong, kShort, 0));
        set(made, "maxmem", limit);
        run(made);
        return floats(output);
    };
    EXPECT_EQ(guided(6e6f), guided(0.0f));
    set(made, "maxmem", 1000.0f);
    fails(RT_ERROR_MEMORY_ALLOCATION_FAILED, rtCommandListExecute(listOf({made})),
          "= 1000 bytes, but the smallest tile needs");
    RTpostprocessingstage other = denoiser(input, output);
    ok(rtVariableSet1ui(of(other, "maxmem"), ~0u));
    run(other);
}

TEST_F(DenoiserStage, ReportsTrainingDataOnce) {
    std::vector<std::string> reports;
    ok(rtContextSetUsageReportCallback(
        context_,
        [](int, const char* tag, const char* text, void* data) {
            static_cast<std::vector<std::string>*>(data)->push_back(std::string(tag) + " " + text);
        },
        1, &reports));
    RTbuffer input = image(8, 8);
    RTpostprocessingstage made = denoiser(input, input);
    set(made, "training_data_buffer", filled<uint8_t>(RT_FORMAT_UNSIGNED_BYTE, {1, 2, 3}));
    run(made);
    run(made);
    ASSERT_EQ(reports.size(), 1u);
    EXPECT_NE(reports[0].find("training data is not used"), std::string::npos) << reports[0];
}

TEST_F(DenoiserStage, RunsAtOtherSizes) {
    RTbuffer input = image(4, 4), output = image(4, 4);
    RTpostprocessingstage made = denoiser(input, output);
    RTcommandlist commands = listOf({made});
    for (const unsigned side : {1u, 70u, 3u}) {
        ok(rtBufferSetSize2D(input, side, side));
        ok(rtBufferSetSize2D(output, side, side));
        fill(input, noisyEdge(side, side, 0));
        ok(rtCommandListExecute(commands));
        EXPECT_NEAR(floats(output)[0], floats(input)[0], 0.02f) << side;
    }
}

// ---- The predictor -----------------------------------------------------------------------------

TEST_F(PredictorStage, FindsTheNoisyPart) {
    RTbuffer input = image(70, 33), output = image(5, 3, RT_FORMAT_FLOAT3);
    std::vector<float> pixels = noisyEdge(70, 33, 0.25f);
    const std::vector<float> clean = noisyEdge(70, 33, 0);
    for (size_t i = 0; i < pixels.size(); ++i)
        if (i / 4 % 70 >= 35) // no noise on the right
            pixels[i] = clean[i];
    fill(input, pixels);
    RTpostprocessingstage made = stage("DLSSIMPredictor");
    set(made, "input_buffer", input);
    set(made, "output_buffer", output);
    run(made);
    std::vector<float> blocks = floats(output);
    ASSERT_EQ(blocks.size(), 5u * 3 * 3);
    for (int y = 0; y < 3; ++y) {
        EXPECT_LT(blocks[3 * (5 * y)], 0.6f);
        EXPECT_GT(blocks[3 * (5 * y + 4)], 0.95f);
        EXPECT_EQ(blocks[3 * (5 * y)], blocks[3 * (5 * y) + 2]);
    }
    ok(rtVariableSet1ui(of(made, "hdr"), 1));
    run(made);
    blocks = floats(output);
    EXPECT_LT(blocks[0], blocks[12]);
    set(made, "output_buffer", image(4, 3));
    fails(RT_ERROR_INVALID_VALUE, rtCommandListExecute(listOf({made})), "5 x 3 are needed");
}

} // namespace
} // namespace sunstone::api6
