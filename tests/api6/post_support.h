// SPDX-License-Identifier: Apache-2.0
// Images, stages and command lists for tests.
#pragma once

#include "support.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace sunstone::api6 {

class Post : public Classic {
protected:
    RTbuffer image(unsigned width, unsigned height, RTformat format = RT_FORMAT_FLOAT4,
                   unsigned type = RT_BUFFER_INPUT_OUTPUT) {
        RTbuffer made = nullptr;
        ok(rtBufferCreate(context_, type, &made));
        ok(rtBufferSetFormat(made, format));
        ok(rtBufferSetSize2D(made, width, height));
        return made;
    }
    std::vector<float> floats(RTbuffer buffer) {
        RTsize width = 0, height = 0, bytes = 0;
        void* data = nullptr;
        ok(rtBufferGetSize2D(buffer, &width, &height));
        ok(rtBufferGetElementSize(buffer, &bytes));
        ok(rtBufferMapEx(buffer, RT_BUFFER_MAP_READ, 0, nullptr, &data));
        std::vector<float> values(width * height * bytes / sizeof(float));
        std::memcpy(values.data(), data, values.size() * sizeof(float));
        ok(rtBufferUnmap(buffer));
        return values;
    }
    RTpostprocessingstage stage(const char* name) {
        RTpostprocessingstage made = nullptr;
        ok(rtPostProcessingStageCreateBuiltin(context_, name, &made));
        return made;
    }
    RTvariable of(RTpostprocessingstage stage, const char* name) {
        RTvariable found = nullptr;
        ok(rtPostProcessingStageQueryVariable(stage, name, &found));
        EXPECT_NE(found, nullptr) << name;
        return found;
    }
    void set(RTpostprocessingstage stage, const char* name, RTbuffer buffer) {
        ok(rtVariableSetObject(of(stage, name), buffer));
    }
    void set(RTpostprocessingstage stage, const char* name, float value) {
        ok(rtVariableSet1f(of(stage, name), value));
    }
    RTpostprocessingstage toneMapper(RTbuffer input, RTbuffer output) {
        RTpostprocessingstage made = stage("TonemapperSimple");
        set(made, "input_buffer", input);
        set(made, "output_buffer", output);
        return made;
    }
    RTpostprocessingstage denoiser(RTbuffer input, RTbuffer output) {
        RTpostprocessingstage made = stage("DLDenoiser");
        set(made, "input_buffer", input);
        set(made, "output_buffer", output);
        return made;
    }
    RTcommandlist list() {
        RTcommandlist made = nullptr;
        ok(rtCommandListCreate(context_, &made));
        return made;
    }
    // A finalized list of stages.
    RTcommandlist listOf(std::initializer_list<RTpostprocessingstage> stages) {
        RTcommandlist made = list();
        for (const RTpostprocessingstage stage : stages)
            ok(rtCommandListAppendPostprocessingStage(made, stage, 1, 1));
        ok(rtCommandListFinalize(made));
        return made;
    }
    void run(RTpostprocessingstage stage) {
        RTcommandlist made = listOf({stage});
        ok(rtCommandListExecute(made));
        ok(rtCommandListDestroy(made));
    }
};

// Two colours side by side, and noise.
inline std::vector<float> noisyEdge(unsigned width, unsigned height, float noise,
                                    float scale = 1.0f, unsigned seed = 1) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> value(-noise, noise);
    std::vector<float> pixels;
    for (unsigned i = 0; i < width * height; ++i) {
        const float level = i % width < width / 2 ? 0.25f : 0.75f;
        for (int c = 0; c < 3; ++c)
            pixels.push_back(scale * std::max(0.0f, level + value(random)));
        pixels.push_back(0.5f);
    }
    return pixels;
}

inline double meanError(const std::vector<float>& a, const std::vector<float>& b) {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i)
        sum += std::fabs(double(a[i]) - double(b[i]));
    return sum / double(a.size());
}

} // namespace sunstone::api6
