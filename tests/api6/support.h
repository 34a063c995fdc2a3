// SPDX-License-Identifier: Apache-2.0
// Code that the tests of the classic API share: a context with the programs of programs.cu, a
// result buffer, and short forms of calls. An unexpected failure of a call fails the test with the
// library's text.
#pragma once

#include "optix.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

namespace sunstone::api6 {

// The text of a file of programs.
inline const std::string& ptx(const std::string& file = "programs.ptx") {
    static auto* texts = new std::map<std::string, std::string>;
    std::string& text = (*texts)[file];
    if (text.empty()) {
        const char* folder = std::getenv("SUNSTONE_TEST_PTX"); // where the build folder is not
        std::ifstream stream((folder ? folder : SUNSTONE_TEST_PTX_FOLDER) + ("/" + file));
        text.assign(std::istreambuf_iterator<char>(stream), {});
    }
    return text;
}

class Classic : public ::testing::Test {
protected:
    void SetUp() override {
        ok(rtContextCreate(&context_));
        ok(rtContextSetEntryPointCount(context_, 1));
        ok(rtContextSetRayTypeCount(context_, 2));
        result_ = buffer(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT, 64);
        ok(rtVariableSetObject(variable("result"), result_));
    }
    void TearDown() override { rtContextDestroy(context_); }

    std::string textOf(RTresult code) {
        const char* text = nullptr;
        rtContextGetErrorString(context_, code, &text);
        return text ? text : "";
    }
    void ok(RTresult code) { ASSERT_EQ(RT_SUCCESS, code) << textOf(code); }
    // Checks that the call failed with this result, and that the text contains the word.
    void fails(RTresult wanted, RTresult code, const std::string& word = "") {
        EXPECT_EQ(wanted, code) << textOf(code);
        EXPECT_NE(textOf(code).find(word), std::string::npos) << textOf(code);
    }

    bool runsOnGpu() {
        char name[64] = "";
        ok(rtDeviceGetAttribute(0, RT_DEVICE_ATTRIBUTE_NAME, sizeof name, name));
        return std::string(name) != "Sunstone CPU";
    }

    RTprogram program(const char* name) {
        RTprogram made = nullptr;
        ok(rtProgramCreateFromPTXString(context_, ptx().c_str(), name, &made));
        return made;
    }
    // A variable of the context, declared at the first call.
    RTvariable variable(const char* name) {
        RTvariable found = nullptr;
        ok(rtContextQueryVariable(context_, name, &found));
        if (!found)
            ok(rtContextDeclareVariable(context_, name, &found));
        return found;
    }
    RTbuffer buffer(unsigned type, RTformat format, size_t count) {
        RTbuffer made = nullptr;
        ok(rtBufferCreate(context_, type, &made));
        ok(rtBufferSetFormat(made, format));
        ok(rtBufferSetSize1D(made, count));
        return made;
    }
    template <class T>
    RTbuffer filled(RTformat format, const std::vector<T>& items) {
        RTbuffer made = buffer(RT_BUFFER_INPUT_OUTPUT, format, items.size());
        fill(made, items);
        return made;
    }
    template <class T>
    void fill(RTbuffer target, const std::vector<T>& items) {
        void* data = nullptr;
        ok(rtBufferMap(target, &data));
        std::memcpy(data, items.data(), items.size() * sizeof(T));
        ok(rtBufferUnmap(target));
    }
    std::vector<float> results() {
        void* data = nullptr;
        rtBufferMap(result_, &data);
        std::vector<float> values(64);
        std::memcpy(values.data(), data, 64 * sizeof(float));
        rtBufferUnmap(result_);
        return values;
    }
    void setEntry(const char* name) {
        ok(rtContextSetRayGenerationProgram(context_, 0, program(name)));
    }
    std::vector<float> launch(const char* name, unsigned width = 1) {
        setEntry(name);
        ok(rtContextLaunch1D(context_, 0, width));
        return results();
    }

    RTcontext context_ = nullptr;
    RTbuffer result_ = nullptr;
};

} // namespace sunstone::api6
