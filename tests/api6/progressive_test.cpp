// SPDX-License-Identifier: Apache-2.0
// Progressive launches and stream buffers: pictures, calls that end a launch, errors.
#include "support.h"

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <thread>

namespace sunstone::api6 {
namespace {

using Bytes = std::vector<std::array<unsigned char, 4>>;

class Progressive : public Classic {
protected:
    static constexpr unsigned kWidth = 3, kHeight = 2;

    void SetUp() override {
        Classic::SetUp();
        source_ = flat(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT4, kWidth, kHeight);
        stream_ = flat(RT_BUFFER_PROGRESSIVE_STREAM, RT_FORMAT_UNSIGNED_BYTE4, kWidth, kHeight);
        ok(rtBufferBindProgressiveStream(stream_, source_));
        ok(rtVariableSetObject(variable("picture"), source_));
        ok(rtVariableSet1f(variable("scoped"), 0.25f));
        setEntry("write_subframe");
    }
    RTbuffer flat(unsigned type, RTformat format, RTsize width, RTsize height) {
        RTbuffer made = nullptr;
        ok(rtBufferCreate(context_, type, &made));
        ok(rtBufferSetFormat(made, format));
        ok(rtBufferSetSize2D(made, width, height));
        return made;
    }
    RTresult start(unsigned subframes) {
        return rtContextLaunchProgressive2D(context_, 0, kWidth, kHeight, subframes);
    }
    // Waits until the stream has at least so many subframes; returns their number.
    unsigned waitFor(unsigned subframes) {
        const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
        unsigned count = 0;
        while (count < subframes && std::chrono::steady_clock::now() < end) {
            int ready = 0;
            if (rtBufferGetProgressiveUpdateReady(stream_, &ready, &count, nullptr) != RT_SUCCESS)
                break;
            if (!ready)
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        return count;
    }
    Bytes pixels(RTbuffer stream) {
        void* data = nullptr;
        ok(rtBufferMap(stream, &data));
        Bytes bytes(kWidth * kHeight);
        std::memcpy(bytes.data(), data, 4 * bytes.size());
        ok(rtBufferUnmap(stream));
        return bytes;
    }
    bool isRunning() {
        int running = -1;
        ok(rtContextGetRunningState(context_, &running));
        EXPECT_TRUE(running == 0 || running == 1);
        return running == 1;
    }
    bool isReady() {
        int ready = -1;
        ok(rtBufferGetProgressiveUpdateReady(stream_, &ready, nullptr, nullptr));
        EXPECT_TRUE(ready == 0 || ready == 1);
        return ready == 1;
    }

    RTbuffer source_ = nullptr, stream_ = nullptr;
};

unsigned char toneMapped(double value, double gamma = 1.0) {
    const double clamped = std::fmin(std::fmax(value, 0.0), 1.0);
    return static_cast<unsigned char>(std::lround(255.0 * std::pow(clamped, 1.0 / gamma)));
}

TEST_F(Progressive, StreamsShowTheMeanOfAllSubframes) {
    ok(start(4));
    EXPECT_EQ(waitFor(4), 4u);
    const Bytes bytes = pixels(stream_);
    for (unsigned y = 0; y < kHeight; ++y)
        for (unsigned x = 0; x < kWidth; ++x) {
            const auto& pixel = bytes[x + kWidth * y];
            EXPECT_EQ(pixel[0], toneMapped(0.5));
            EXPECT_EQ(pixel[1], toneMapped(0.375)) << "rtSubframeIndex counts from 0";
            EXPECT_EQ(pixel[2], toneMapped(0.25 + x + 0.5 * y));
            EXPECT_EQ(pixel[3], 255);
        }
}

TEST_F(Progressive, SourcesMayHaveThreeComponents) {
    RTbuffer small = flat(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT3, kWidth, kHeight);
    ok(rtVariableSetObject(variable("small_picture"), small));
    ok(rtBufferBindProgressiveStream(stream_, small));
    setEntry("write_small_subframe");
    ok(start(4));
    EXPECT_EQ(waitFor(4), 4u);
    const Bytes bytes = pixels(stream_);
    EXPECT_EQ(bytes[0][0], toneMapped(0.5));
    EXPECT_EQ(bytes[0][1], toneMapped(0.375));
    EXPECT_EQ(bytes[kWidth][2], toneMapped(0.75));
}

TEST_F(Progressive, GammaIsOfTheStream) {
    RTbuffer other = flat(RT_BUFFER_PROGRESSIVE_STREAM, RT_FORMAT_UNSIGNED_BYTE4, kWidth, kHeight);
    ok(rtBufferBindProgressiveStream(other, source_));
    const float gamma = 2.2f;
    ok(rtBufferSetAttribute(other, RT_BUFFER_ATTRIBUTE_STREAM_GAMMA, sizeof gamma, &gamma));
    for (const float value : {1e-7f, 0.0004f, 0.001f, 0.003f, 0.01f, 0.04f, 0.2f, 0.6f, 0.99f}) {
        ok(rtVariableSet1f(variable("scoped"), value));
        ok(start(1));
        EXPECT_EQ(waitFor(1), 1u);
        EXPECT_EQ(pixels(other)[0][2], toneMapped(value, 2.2f)) << value;
        EXPECT_EQ(pixels(stream_)[0][2], toneMapped(value)) << value;
    }
}

TEST_F(Progressive, ColoursOutsideAreClampedAndNoNumberIsBlack) {
    const float values[] = {-3.0f, std::numeric_limits<float>::infinity(),
                            std::numeric_limits<float>::quiet_NaN()};
    const unsigned char wanted[] = {0, 255, 0};
    for (unsigned i = 0; i < 3; ++i) {
        ok(rtVariableSet1f(variable("scoped"), values[i]));
        ok(start(1));
        EXPECT_EQ(waitFor(1), 1u);
        EXPECT_EQ(pixels(stream_)[0][2], wanted[i]) << values[i];
    }
}

TEST_F(Progressive, UpdatesAreReportedOnce) {
    ok(start(3));
    EXPECT_EQ(waitFor(3), 3u);
    int ready = -1;
    unsigned subframes = 99, limit = 98;
    ok(rtBufferGetProgressiveUpdateReady(stream_, &ready, &subframes, &limit));
    EXPECT_EQ(ready, 0);
    EXPECT_EQ(subframes, 99u) << "written only with an update";
    EXPECT_EQ(limit, 98u);
    ok(rtVariableSet1f(variable("scoped"), 0.3f));
    ok(start(1));
    while (!ready)
        ok(rtBufferGetProgressiveUpdateReady(stream_, &ready, &subframes, &limit));
    EXPECT_EQ(subframes, 1u);
    EXPECT_EQ(limit, 1u);
}

TEST_F(Progressive, LaunchesGoOnWhileTheirPicturesAreLookedAt) {
    ok(start(0));
    unsigned last = 0;
    for (int i = 0; i < 4; ++i) {
        const unsigned now = waitFor(last + 1);
        EXPECT_GT(now, last);
        last = now;
        pixels(stream_);
        ok(start(0)); // the same launch
        EXPECT_TRUE(isRunning());
    }
}

TEST_F(Progressive, OtherCallsEndALaunch) {
    using Call = std::function<RTresult()>;
    unsigned count = 0;
    RTsize width = 0;
    void* data = nullptr;
    const char* text = nullptr;
    const float gamma = 1;
    RTvariable scoped = variable("scoped");
    const std::vector<std::pair<const char*, Call>> calls = {
        {"variable", [&] { return rtVariableSet1f(scoped, 0.4f); }},
        {"getter", [&] { return rtBufferGetSize1D(stream_, &width); }},
        {"map", [&] { return rtBufferMap(source_, &data); }},
        {"unmap", [&] { return rtBufferUnmap(source_); }},
        {"count", [&] { return rtContextGetEntryPointCount(context_, &count); }},
        {"launch", [&] { return rtContextLaunch2D(context_, 0, kWidth, kHeight); }},
        {"bind", [&] { return rtBufferBindProgressiveStream(stream_, source_); }},
        {"attribute",
         [&] {
             return rtBufferSetAttribute(stream_, RT_BUFFER_ATTRIBUTE_STREAM_GAMMA, sizeof gamma,
                                         &gamma);
         }},
        {"text",
         [&] {
             rtContextGetErrorString(context_, RT_SUCCESS, &text);
             return RT_SUCCESS;
         }},
        {"stop", [&] { return rtContextStopProgressive(context_); }},
    };
    for (const auto& [name, call] : calls) {
        if (std::string(name) == "unmap")
            ok(call()); // of the call before, as no launch starts while the source is mapped
        ok(start(0));
        EXPECT_TRUE(isRunning()) << name;
        if (std::string(name) == "unmap") {
            EXPECT_EQ(call(), RT_ERROR_INVALID_VALUE); // a call that fails is one, too
        } else {
            ok(call());
        }
        if (std::string(name) != "text")
            EXPECT_FALSE(isRunning()) << name;
        isReady(); // what was in flight
        EXPECT_FALSE(isReady()) << name;
    }
}

TEST_F(Progressive, ALaunchThatEndsHasAtLeastOneSubframe) {
    for (int i = 0; i < 20; ++i) {
        ok(start(0));
        ok(rtVariableSet1f(variable("scoped"), 0.1f));
        EXPECT_GE(waitFor(1), 1u);
    }
}

TEST_F(Progressive, NothingArrivesAfterAStop) {
    for (int i = 0; i < 10; ++i) {
        ok(start(0));
        std::this_thread::sleep_for(std::chrono::milliseconds(3));
        ok(rtContextStopProgressive(context_));
        EXPECT_FALSE(isReady());
        EXPECT_FALSE(isRunning());
    }
    ok(rtContextStopProgressive(context_)); // without a launch
}

TEST_F(Progressive, ResizedStreamsHaveNoPicture) {
    ok(start(3));
    EXPECT_EQ(waitFor(2), 3u); // of which the test takes no later picture
    ok(start(2));
    ok(rtBufferSetSize2D(stream_, kHeight, kWidth));
    EXPECT_FALSE(isReady());
    ok(rtBufferSetSize2D(stream_, kWidth, kHeight));
    ok(start(1));
    EXPECT_EQ(waitFor(1), 1u);
    EXPECT_EQ(pixels(stream_)[0][3], 255);
}

TEST_F(Progressive, ALaunchThatIsDoneIsNotMadeAgain) {
    ok(start(2));
    EXPECT_EQ(waitFor(2), 2u);
    ok(start(2));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_FALSE(isReady());
    EXPECT_FALSE(isRunning());
}

TEST_F(Progressive, OtherParametersStartAnew) {
    ok(start(3));
    EXPECT_EQ(waitFor(3), 3u);
    ok(start(1));
    EXPECT_EQ(waitFor(1), 1u);
    EXPECT_EQ(pixels(stream_)[0][0], 255) << "the first subframe alone";
}

TEST_F(Progressive, MappedPicturesStayAsTheyAre) {
    ok(start(0));
    EXPECT_GE(waitFor(1), 1u);
    void* data = nullptr;
    ok(rtBufferMapEx(stream_, RT_BUFFER_MAP_READ, 0, nullptr, &data));
    Bytes before(kWidth * kHeight), after = before;
    std::memcpy(before.data(), data, 4 * before.size());
    EXPECT_GE(waitFor(2), 2u);
    std::memcpy(after.data(), data, 4 * after.size());
    EXPECT_EQ(before, after);
    fails(RT_ERROR_ALREADY_MAPPED, rtBufferMap(stream_, &data));
    ok(rtBufferUnmapEx(stream_, 0));
}

TEST_F(Progressive, OnlyMappedStreamsLetALaunchStart) {
    void* data = nullptr;
    ok(rtBufferMap(stream_, &data));
    ok(start(2));
    EXPECT_EQ(waitFor(2), 2u);
    ok(rtBufferUnmap(stream_));
    ok(rtBufferMap(source_, &data));
    fails(RT_ERROR_ALREADY_MAPPED, start(2), "is mapped");
    ok(rtBufferUnmap(source_));
    ok(start(2));
}

TEST_F(Progressive, OrdinaryLaunchesHaveTheSubframeZero) {
    ok(start(5));
    EXPECT_EQ(waitFor(5), 5u);
    EXPECT_EQ(launch("write_subframe_index")[0], 0);
}

TEST_F(Progressive, LaunchesOfSizeZeroCompileAlone) {
    ok(rtBufferSetSize2D(source_, 0, 0));
    ok(rtBufferSetSize2D(stream_, 0, 0));
    ok(rtContextLaunchProgressive2D(context_, 0, 0, 0, 0));
    EXPECT_FALSE(isRunning());
    EXPECT_FALSE(isReady());
}

TEST_F(Progressive, StreamsWithoutASourceShowNothing) {
    RTbuffer other = flat(RT_BUFFER_PROGRESSIVE_STREAM, RT_FORMAT_UNSIGNED_BYTE4, kWidth, kHeight);
    ok(start(1));
    EXPECT_EQ(waitFor(1), 1u);
    int ready = -1;
    ok(rtBufferGetProgressiveUpdateReady(other, &ready, nullptr, nullptr));
    EXPECT_EQ(ready, 0);
    EXPECT_EQ(pixels(other)[0], (std::array<unsigned char, 4>{}));
}

TEST_F(Progressive, ObjectsMayBeDestroyedWhileALaunchRuns) {
    ok(start(0));
    ok(rtBufferDestroy(stream_));
    ok(start(0));
    ok(rtBufferDestroy(source_));
    fails(RT_ERROR_VARIABLE_NOT_FOUND, start(0), "picture");
    int ready = 0;
    EXPECT_EQ(rtBufferGetProgressiveUpdateReady(stream_, &ready, nullptr, nullptr),
              RT_ERROR_INVALID_VALUE);
    EXPECT_EQ(rtBufferBindProgressiveStream(stream_, source_), RT_ERROR_INVALID_VALUE);
    source_ = flat(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT4, kWidth, kHeight);
    ok(rtVariableSetObject(variable("picture"), source_));
    ok(start(0));
    ok(rtContextDestroy(context_));
    EXPECT_EQ(start(0), RT_ERROR_INVALID_CONTEXT);
    EXPECT_EQ(rtContextStopProgressive(context_), RT_ERROR_INVALID_CONTEXT);
}

TEST_F(Progressive, FaultsOfTheSceneAreThoseOfLaunches) {
    RTvariable scoped = variable("scoped");
    ok(rtContextRemoveVariable(context_, scoped));
    fails(RT_ERROR_VARIABLE_NOT_FOUND, start(1), "\"scoped\"");
    EXPECT_EQ(rtContextDestroy(context_), RT_SUCCESS) << "the launch did not begin";
    context_ = nullptr;
    Classic::SetUp();
    fails(RT_ERROR_INVALID_CONTEXT, start(1), "no ray generation program");
}

TEST_F(Progressive, ArgumentsOfLaunches) {
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunchProgressive2D(context_, 1, kWidth, kHeight, 1),
          "entryPointIndex");
    fails(RT_ERROR_INVALID_VALUE,
          rtContextLaunchProgressive2D(context_, 0, RTsize(1) << 32, kHeight, 1), "too many");
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunchProgressive2D(context_, 0, kWidth, 7, 1),
          "3 by 7");
    ok(rtBufferSetSize2D(stream_, kWidth + 1, kHeight));
    fails(RT_ERROR_INVALID_VALUE, start(1), "the stream buffer has 2 dimensions and 4 by 2");
    ok(rtBufferSetSize1D(stream_, kWidth));
    fails(RT_ERROR_INVALID_VALUE, start(1), "the stream buffer has 1 dimensions");
    ok(rtBufferSetSize2D(stream_, kWidth, kHeight));
    ok(rtBufferSetFormat(source_, RT_FORMAT_FLOAT2));
    fails(RT_ERROR_INVALID_VALUE, start(1), "RT_FORMAT_FLOAT4");
    ok(rtBufferSetFormat(source_, RT_FORMAT_FLOAT4));
    ok(start(1));
    EXPECT_EQ(waitFor(1), 1u);
    int local = 0;
    for (void* garbage : {static_cast<void*>(nullptr), static_cast<void*>(&local),
                          static_cast<void*>(stream_), reinterpret_cast<void*>(0x1234)}) {
        const auto context = static_cast<RTcontext>(garbage);
        EXPECT_EQ(rtContextLaunchProgressive2D(context, 0, 1, 1, 1), RT_ERROR_INVALID_CONTEXT);
        EXPECT_EQ(rtContextStopProgressive(context), RT_ERROR_INVALID_CONTEXT);
        EXPECT_EQ(rtContextGetRunningState(context, &local), RT_ERROR_INVALID_VALUE);
    }
    fails(RT_ERROR_INVALID_VALUE, rtContextGetRunningState(context_, nullptr), "running is null");
}

TEST_F(Progressive, ArgumentsOfBindAndPoll) {
    int ready = 7;
    fails(RT_ERROR_INVALID_VALUE,
          rtBufferGetProgressiveUpdateReady(source_, &ready, nullptr, nullptr),
          "RT_BUFFER_PROGRESSIVE_STREAM");
    fails(RT_ERROR_INVALID_VALUE,
          rtBufferGetProgressiveUpdateReady(stream_, nullptr, nullptr, nullptr), "ready is null");
    fails(RT_ERROR_INVALID_VALUE, rtBufferBindProgressiveStream(source_, source_), "stream");
    fails(RT_ERROR_INVALID_VALUE, rtBufferBindProgressiveStream(stream_, stream_),
          "RT_BUFFER_OUTPUT");
    fails(RT_ERROR_INVALID_VALUE, rtBufferBindProgressiveStream(stream_, nullptr),
          "source is null");
    fails(RT_ERROR_INVALID_VALUE,
          rtBufferBindProgressiveStream(
              stream_, flat(RT_BUFFER_INPUT_OUTPUT, RT_FORMAT_FLOAT4, kWidth, kHeight)),
          "RT_BUFFER_OUTPUT");
    fails(RT_ERROR_INVALID_VALUE,
          rtBufferBindProgressiveStream(
              stream_, flat(RT_BUFFER_OUTPUT, RT_FORMAT_UNSIGNED_BYTE4, kWidth, kHeight)),
          "is RT_FORMAT_UNSIGNED_BYTE4, neither RT_FORMAT_FLOAT3");
    fails(
        RT_ERROR_INVALID_VALUE,
        rtBufferBindProgressiveStream(
            flat(RT_BUFFER_PROGRESSIVE_STREAM, RT_FORMAT_UNSIGNED_BYTE3, kWidth, kHeight), source_),
        "RT_FORMAT_UNSIGNED_BYTE4");
    RTcontext foreign = nullptr;
    ok(rtContextCreate(&foreign));
    RTbuffer theirs = nullptr;
    ok(rtBufferCreate(foreign, RT_BUFFER_OUTPUT, &theirs));
    ok(rtBufferSetFormat(theirs, RT_FORMAT_FLOAT4));
    fails(RT_ERROR_INVALID_VALUE, rtBufferBindProgressiveStream(stream_, theirs),
          "another context");
    ok(rtContextDestroy(foreign));
    for (void* garbage : {static_cast<void*>(nullptr), static_cast<void*>(&ready),
                          static_cast<void*>(context_), reinterpret_cast<void*>(0x1234)}) {
        const auto buffer = static_cast<RTbuffer>(garbage);
        EXPECT_EQ(rtBufferBindProgressiveStream(buffer, source_), RT_ERROR_INVALID_VALUE);
        EXPECT_EQ(rtBufferBindProgressiveStream(stream_, buffer), RT_ERROR_INVALID_VALUE);
        EXPECT_EQ(rtBufferGetProgressiveUpdateReady(buffer, &ready, nullptr, nullptr),
                  RT_ERROR_INVALID_VALUE);
    }
}

TEST_F(Progressive, StreamsTakeNoFlags) {
    RTbuffer made = nullptr;
    for (const unsigned flag : {RT_BUFFER_GPU_LOCAL, RT_BUFFER_LAYERED, RT_BUFFER_CUBEMAP,
                                RT_BUFFER_COPY_ON_DIRTY, RT_BUFFER_DISCARD_HOST_MEMORY})
        fails(RT_ERROR_INVALID_VALUE,
              rtBufferCreate(context_, unsigned(RT_BUFFER_PROGRESSIVE_STREAM) | flag, &made));
}

TEST_F(Progressive, AttributesOfStreams) {
    const auto set = [&](RTbufferattribute attribute, RTsize size, const void* p) {
        return rtBufferSetAttribute(stream_, attribute, size, p);
    };
    const auto get = [&](RTbufferattribute attribute, RTsize size, void* p) {
        return rtBufferGetAttribute(stream_, attribute, size, p);
    };
    char text[16] = {};
    int number = 0;
    float gamma = 0;
    ok(get(RT_BUFFER_ATTRIBUTE_STREAM_FORMAT, sizeof text, text));
    EXPECT_STREQ(text, "auto");
    ok(get(RT_BUFFER_ATTRIBUTE_STREAM_BITRATE, sizeof number, &number));
    EXPECT_EQ(number, 5000000);
    ok(get(RT_BUFFER_ATTRIBUTE_STREAM_FPS, sizeof number, &number));
    EXPECT_EQ(number, 30);
    ok(get(RT_BUFFER_ATTRIBUTE_STREAM_GAMMA, sizeof gamma, &gamma));
    EXPECT_EQ(gamma, 1.0f);

    ok(set(RT_BUFFER_ATTRIBUTE_STREAM_FORMAT, 3, "pngX")); // without a terminator
    ok(get(RT_BUFFER_ATTRIBUTE_STREAM_FORMAT, 4, text));
    EXPECT_STREQ(text, "png");
    fails(RT_ERROR_INVALID_VALUE, get(RT_BUFFER_ATTRIBUTE_STREAM_FORMAT, 3, text), "4 bytes");
    fails(RT_ERROR_INVALID_VALUE, set(RT_BUFFER_ATTRIBUTE_STREAM_FORMAT, 0, "png"), "size = 0");
    fails(RT_ERROR_INVALID_VALUE, set(RT_BUFFER_ATTRIBUTE_STREAM_FORMAT, ~RTsize(0), "png"));
    for (const RTbufferattribute attribute :
         {RT_BUFFER_ATTRIBUTE_STREAM_BITRATE, RT_BUFFER_ATTRIBUTE_STREAM_FPS}) {
        number = 12;
        ok(set(attribute, sizeof number, &number));
        number = 0;
        fails(RT_ERROR_INVALID_VALUE, set(attribute, sizeof number, &number), "not above 0");
        ok(get(attribute, sizeof number, &number));
        EXPECT_EQ(number, 12) << "as before the call that failed";
        fails(RT_ERROR_INVALID_VALUE, set(attribute, 8, &number), "size = 8");
        fails(RT_ERROR_INVALID_VALUE, get(attribute, 8, &number), "size = 8");
    }
    for (const float bad : {0.0f, -1.0f, std::numeric_limits<float>::infinity(),
                            std::numeric_limits<float>::quiet_NaN()})
        fails(RT_ERROR_INVALID_VALUE, set(RT_BUFFER_ATTRIBUTE_STREAM_GAMMA, sizeof bad, &bad),
              "not above 0");
    fails(RT_ERROR_INVALID_VALUE, set(RTbufferattribute(77), 4, &number), "attrib = 77");
    fails(RT_ERROR_INVALID_VALUE, get(RTbufferattribute(77), 4, &number), "attrib = 77");
    fails(RT_ERROR_INVALID_VALUE, set(RT_BUFFER_ATTRIBUTE_STREAM_FPS, 4, nullptr), "p is null");
    fails(RT_ERROR_INVALID_VALUE, get(RT_BUFFER_ATTRIBUTE_STREAM_FPS, 4, nullptr), "p is null");
    fails(RT_ERROR_INVALID_VALUE,
          rtBufferSetAttribute(source_, RT_BUFFER_ATTRIBUTE_STREAM_FPS, 4, &number),
          "RT_BUFFER_PROGRESSIVE_STREAM");
    fails(RT_ERROR_INVALID_VALUE,
          rtBufferGetAttribute(source_, RT_BUFFER_ATTRIBUTE_STREAM_FPS, 4, &number));
    EXPECT_EQ(rtBufferSetAttribute(nullptr, RT_BUFFER_ATTRIBUTE_STREAM_FPS, 4, &number),
              RT_ERROR_INVALID_VALUE);
    EXPECT_EQ(rtBufferGetAttribute(nullptr, RT_BUFFER_ATTRIBUTE_STREAM_FPS, 4, &number),
              RT_ERROR_INVALID_VALUE);
    ok(rtBufferDestroy(stream_));
    EXPECT_EQ(rtBufferGetAttribute(stream_, RT_BUFFER_ATTRIBUTE_STREAM_FPS, 4, &number),
              RT_ERROR_INVALID_VALUE);
}

TEST_F(Progressive, ThreadsMayLookWhileOthersChangeTheScene) {
    std::atomic<bool> ends{false};
    std::thread viewer([&] {
        while (!ends) {
            int ready = 0;
            rtBufferGetProgressiveUpdateReady(stream_, &ready, nullptr, nullptr);
            void* data = nullptr;
            if (ready && rtBufferMap(stream_, &data) == RT_SUCCESS)
                rtBufferUnmap(stream_);
        }
    });
    RTvariable scoped = variable("scoped");
    for (int i = 0; i < 50; ++i) {
        ok(rtVariableSet1f(scoped, 0.01f * float(i)));
        ok(start(0));
    }
    ends = true;
    viewer.join();
    ok(rtContextStopProgressive(context_));
    ok(rtVariableSet1f(scoped, 0.9f));
    ok(start(2));
    EXPECT_EQ(waitFor(2), 2u);
    EXPECT_EQ(pixels(stream_)[0][2], toneMapped(0.9f));
}

// The result of a call that waits for the context while another thread destroys it. The destroying
// thread holds the context's lock until the subframe ends.
template <class Call>
RTresult resultDuringDestruction(RTcontext context, const Call& call) {
    std::atomic<bool> begins{false};
    std::thread destroyer([&] {
        begins = true;
        EXPECT_EQ(rtContextDestroy(context), RT_SUCCESS);
    });
    while (!begins)
        std::this_thread::yield();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const RTresult result = call();
    destroyer.join();
    return result;
}

TEST_F(Progressive, CallsThatWaitForADestroyedContextAreRefused) {
    constexpr RTsize kSide = 2048; // a subframe takes much longer than a thread to start
    for (const bool isOfContext : {true, false}) {
        ok(rtBufferSetSize2D(source_, kSide, kSide));
        ok(rtBufferSetSize2D(stream_, kSide, kSide));
        RTvariable scoped = variable("scoped");
        ok(rtContextLaunchProgressive2D(context_, 0, kSide, kSide, 0));
        EXPECT_EQ(waitFor(1), 1u);
        const auto call = [&] {
            return isOfContext ? rtContextValidate(context_) : rtVariableSet1f(scoped, 0.5f);
        };
        EXPECT_EQ(resultDuringDestruction(context_, call),
                  isOfContext ? RT_ERROR_INVALID_CONTEXT : RT_ERROR_INVALID_VALUE);
        SetUp();
    }
}

} // namespace
} // namespace sunstone::api6
