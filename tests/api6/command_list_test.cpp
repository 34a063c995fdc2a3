// SPDX-License-Identifier: Apache-2.0
// Command lists (section 5.19): their life, the order of commands, errors.
#include "post_support.h"

namespace sunstone::api6 {
namespace {

class CommandList : public Post {};

// Neither is a live object of the class.
const auto kGarbage = reinterpret_cast<RTcommandlist>(uintptr_t(0x1234));

TEST_F(CommandList, RunsLaunchesAndStagesInOrder) {
    RTbuffer source = image(8, 4), result = image(8, 4);
    ok(rtVariableSetObject(variable("image"), source));
    ok(rtVariableSet1f(variable("scoped"), 2.0f));
    ok(rtContextSetEntryPointCount(context_, 2));
    ok(rtContextSetRayGenerationProgram(context_, 0, program("paint_image")));
    ok(rtContextSetRayGenerationProgram(context_, 1, program("halve_image")));
    RTpostprocessingstage tones = toneMapper(source, result);
    set(tones, "gamma", 1.0f);
    RTcommandlist commands = list();
    ok(rtCommandListAppendLaunch2D(commands, 0, 8, 4));
    ok(rtCommandListAppendLaunch2D(commands, 1, 8, 2)); // the first rows alone
    ok(rtCommandListAppendPostprocessingStage(commands, tones, 8, 4));
    ok(rtCommandListAppendLaunch2D(commands, 1, 8, 4)); // after the stage
    ok(rtCommandListFinalize(commands));
    for (const float blue : {2.0f, 0.5f}) { // a list may run again, with other values
        ok(rtVariableSet1f(variable("scoped"), blue));
        ok(rtCommandListExecute(commands));
        const std::vector<float> made = floats(result), left = floats(source);
        for (unsigned y = 0; y < 4; ++y)
            for (unsigned x = 0; x < 8; ++x) {
                const float* pixel = &made[4 * (y * 8 + x)];
                const float part = y < 2 ? 0.5f : 1.0f;
                EXPECT_FLOAT_EQ(pixel[0], float(x + 1) / 8 * part);
                EXPECT_FLOAT_EQ(pixel[1], float(y + 1) / 4 * part);
                EXPECT_FLOAT_EQ(pixel[2], std::min(blue * part, 1.0f));
                EXPECT_EQ(pixel[3], 0.25f * part) << "alpha";
                EXPECT_EQ(left[4 * (y * 8 + x) + 2], blue * part * 0.5f);
            }
    }
}

TEST_F(CommandList, IsFinalizedOnceBeforeItRuns) {
    RTcommandlist commands = list();
    RTpostprocessingstage tones = toneMapper(image(2, 2), image(2, 2));
    fails(RT_ERROR_INVALID_VALUE, rtCommandListExecute(commands), "not been finalized");
    ok(rtCommandListAppendPostprocessingStage(commands, tones, 0, 0));
    ok(rtCommandListFinalize(commands));
    fails(RT_ERROR_INVALID_VALUE, rtCommandListFinalize(commands), "finalized before");
    fails(RT_ERROR_INVALID_VALUE, rtCommandListAppendLaunch2D(commands, 0, 1, 1), "finalized");
    fails(RT_ERROR_INVALID_VALUE, rtCommandListAppendPostprocessingStage(commands, tones, 1, 1),
          "finalized");
    ok(rtCommandListExecute(commands));
    ok(rtCommandListExecute(listOf({})));
}

TEST_F(CommandList, RefusesHandlesThatAreNone) {
    RTcommandlist commands = nullptr;
    RTpostprocessingstage tones = stage("TonemapperSimple");
    fails(RT_ERROR_INVALID_VALUE, rtCommandListCreate(context_, nullptr), "list is null");
    EXPECT_EQ(RT_ERROR_INVALID_CONTEXT, rtCommandListCreate(nullptr, &commands));
    EXPECT_EQ(RT_ERROR_INVALID_CONTEXT,
              rtCommandListCreate(reinterpret_cast<RTcontext>(tones), &commands));
    for (const RTcommandlist none :
         {RTcommandlist(), kGarbage, reinterpret_cast<RTcommandlist>(tones)}) {
        EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtCommandListDestroy(none));
        EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtCommandListAppendLaunch2D(none, 0, 1, 1));
        EXPECT_EQ(RT_ERROR_INVALID_VALUE,
                  rtCommandListAppendPostprocessingStage(none, tones, 1, 1));
        EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtCommandListFinalize(none));
        EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtCommandListExecute(none));
        RTcontext context = context_;
        EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtCommandListGetContext(none, &context));
        EXPECT_EQ(context, nullptr);
    }
    commands = list();
    RTcontext context = nullptr;
    ok(rtCommandListGetContext(commands, &context));
    EXPECT_EQ(context, context_);
    ok(rtCommandListGetContext(commands, nullptr));
    for (const RTpostprocessingstage none :
         {RTpostprocessingstage(), reinterpret_cast<RTpostprocessingstage>(kGarbage),
          reinterpret_cast<RTpostprocessingstage>(commands)})
        EXPECT_EQ(RT_ERROR_INVALID_VALUE,
                  rtCommandListAppendPostprocessingStage(commands, none, 1, 1));
    ok(rtCommandListDestroy(commands));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtCommandListDestroy(commands));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE, rtCommandListExecute(commands));
    RTcontext owner = nullptr;
    ok(rtPostProcessingStageGetContext(tones, &owner)); // stages stay
}

TEST_F(CommandList, TakesStagesOfItsOwnContextAlone) {
    RTcontext other = nullptr;
    RTpostprocessingstage foreign = nullptr;
    ok(rtContextCreate(&other));
    ok(rtPostProcessingStageCreateBuiltin(other, "TonemapperSimple", &foreign));
    RTcommandlist commands = list();
    fails(RT_ERROR_INVALID_VALUE, rtCommandListAppendPostprocessingStage(commands, foreign, 1, 1),
          "another context");
    ok(rtContextDestroy(other));
    EXPECT_EQ(RT_ERROR_INVALID_VALUE,
              rtCommandListAppendPostprocessingStage(commands, foreign, 1, 1));
}

TEST_F(CommandList, DiesWithItsStages) {
    RTpostprocessingstage first = toneMapper(image(2, 2), image(2, 2));
    RTpostprocessingstage second = toneMapper(image(2, 2), image(2, 2));
    RTcommandlist both = listOf({first, second, first}), one = listOf({first}), open = list();
    ok(rtCommandListAppendPostprocessingStage(open, second, 1, 1));
    ok(rtCommandListExecute(both));
    ok(rtPostProcessingStageDestroy(second));
    fails(RT_ERROR_INVALID_VALUE, rtCommandListExecute(both), "command 1 has been destroyed");
    fails(RT_ERROR_INVALID_VALUE, rtCommandListFinalize(open), "destroyed");
    ok(rtCommandListExecute(one));
    ok(rtCommandListDestroy(both));
}

TEST_F(CommandList, LaunchesFailAsTheyDoAlone) {
    ok(rtContextSetRayGenerationProgram(context_, 0, program("paint_image")));
    const auto failsWith = [&](RTresult result, unsigned entry, RTsize width, const char* word) {
        RTcommandlist commands = list();
        ok(rtCommandListAppendLaunch2D(commands, entry, width, 2));
        ok(rtCommandListFinalize(commands));
        fails(result, rtCommandListExecute(commands), word);
    };
    failsWith(RT_ERROR_VARIABLE_NOT_FOUND, 0, 2, "\"image\"");
    failsWith(RT_ERROR_INVALID_VALUE, 7, 2, "entryPointIndex = 7");
    failsWith(RT_ERROR_INVALID_VALUE, 0, RTsize(1) << 40, "too many indices");
    RTbuffer mapped = image(2, 2);
    void* data = nullptr;
    ok(rtBufferMap(mapped, &data));
    failsWith(RT_ERROR_ALREADY_MAPPED, 0, 2, "is mapped");
    ok(rtBufferUnmap(mapped));
    ok(rtVariableSet1f(variable("scoped"), 1));
    ok(rtVariableSetObject(variable("image"), mapped));
    RTcommandlist commands = list();
    ok(rtCommandListAppendLaunch2D(commands, 0, 2, 2));
    ok(rtCommandListFinalize(commands));
    ok(rtCommandListExecute(commands));
    EXPECT_EQ(floats(mapped)[0], 0.5f);
    fails(RT_ERROR_INVALID_VALUE, rtContextSetPrintBufferSize(context_, 1 << 20), "launched");
}

TEST_F(CommandList, ItsEndLeavesTheSceneAlone) {
    ok(rtVariableSet1f(variable("scoped"), 1));
    ok(rtVariableSetObject(variable("image"), image(2, 2)));
    ok(rtContextSetRayGenerationProgram(context_, 0, program("paint_image")));
    for (int i = 0; i < 100; ++i) { // a renderer may make a list for each frame
        RTcommandlist commands = list();
        ok(rtCommandListAppendLaunch2D(commands, 0, 2, 2));
        ok(rtCommandListFinalize(commands));
        ok(rtCommandListExecute(commands));
        ok(rtCommandListDestroy(commands));
    }
}

} // namespace
} // namespace sunstone::api6
