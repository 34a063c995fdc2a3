// SPDX-License-Identifier: Apache-2.0
// Settings and attributes of contexts, devices, buffers and the library, with the sizes and values
// that the manual excludes.
#include "support.h"

#include "optix_cuda_interop.h"

#include <array>
#include <cstdlib>

namespace sunstone::api6 {
namespace {

class Attributes : public Classic {
protected:
    template <class T>
    T get(RTcontextattribute attribute) {
        T value{};
        ok(rtContextGetAttribute(context_, attribute, sizeof value, &value));
        fails(RT_ERROR_INVALID_VALUE,
              rtContextGetAttribute(context_, attribute, sizeof value + 1, &value), "size");
        fails(RT_ERROR_INVALID_VALUE,
              rtContextGetAttribute(context_, attribute, sizeof value, nullptr));
        return value;
    }
    template <class T>
    RTresult set(RTcontextattribute attribute, T value) {
        fails(RT_ERROR_INVALID_VALUE,
              rtContextSetAttribute(context_, attribute, sizeof value, nullptr));
        return rtContextSetAttribute(context_, attribute, sizeof value, &value);
    }
};

TEST_F(Attributes, OfContexts) {
    EXPECT_GT(get<int>(RT_CONTEXT_ATTRIBUTE_MAX_TEXTURE_COUNT), 0);
    fails(RT_ERROR_INVALID_VALUE, set(RT_CONTEXT_ATTRIBUTE_MAX_TEXTURE_COUNT, 1), "cannot be set");
    EXPECT_GT(get<int>(RT_CONTEXT_ATTRIBUTE_CPU_NUM_THREADS), 0);
    fails(RT_ERROR_INVALID_VALUE, set(RT_CONTEXT_ATTRIBUTE_CPU_NUM_THREADS, 0), "threads");
    ok(set(RT_CONTEXT_ATTRIBUTE_CPU_NUM_THREADS, 1));
    EXPECT_EQ(get<int>(RT_CONTEXT_ATTRIBUTE_CPU_NUM_THREADS), 1);
    EXPECT_EQ(get<int>(RT_CONTEXT_ATTRIBUTE_PREFER_FAST_RECOMPILES), 0);
    EXPECT_EQ(get<int>(RT_CONTEXT_ATTRIBUTE_FORCE_INLINE_USER_FUNCTIONS), 1);
    for (const RTcontextattribute each : {RT_CONTEXT_ATTRIBUTE_PREFER_FAST_RECOMPILES,
                                          RT_CONTEXT_ATTRIBUTE_FORCE_INLINE_USER_FUNCTIONS}) {
        ok(set(each, 1));
        EXPECT_EQ(get<int>(each), 1);
        fails(RT_ERROR_INVALID_VALUE, set(each, char(1)), "size");
    }
    EXPECT_EQ(get<int>(RT_CONTEXT_ATTRIBUTE_GPU_PAGING_ACTIVE), 0);
    const RTsize before = get<RTsize>(RT_CONTEXT_ATTRIBUTE_USED_HOST_MEMORY);
    buffer(RT_BUFFER_INPUT, RT_FORMAT_FLOAT4, 1000);
    EXPECT_EQ(get<RTsize>(RT_CONTEXT_ATTRIBUTE_USED_HOST_MEMORY), before + 16000);
    EXPECT_GT(get<RTsize>(RT_CONTEXT_ATTRIBUTE_AVAILABLE_DEVICE_MEMORY), 0u);
    RTsize bytes = 0;
    fails(RT_ERROR_INVALID_VALUE,
          rtContextGetAttribute(
              context_, RTcontextattribute(RT_CONTEXT_ATTRIBUTE_AVAILABLE_DEVICE_MEMORY + 77),
              sizeof bytes, &bytes));
    fails(RT_ERROR_INVALID_VALUE, set(RTcontextattribute(0x777), 1));
    fails(RT_ERROR_INVALID_VALUE,
          rtContextGetAttribute(context_, RTcontextattribute(0x777), sizeof bytes, &bytes));
}

// The manual's size is that of a pointer; applications pass the text itself, too.
TEST_F(Attributes, LocationOfTheDiskCache) {
    const auto kLocation = RT_CONTEXT_ATTRIBUTE_DISK_CACHE_LOCATION;
    if (std::getenv("OPTIX_CACHE_MAXSIZE"))
        GTEST_SKIP() << "the cache may be off";
    const bool isFixed = std::getenv("OPTIX_CACHE_PATH"); // which takes precedence
    const auto location = [&] {
        const char* text = nullptr;
        ok(rtContextGetAttribute(context_, kLocation, sizeof text, &text));
        return std::string(text ? text : "");
    };
    const std::string first = ::testing::TempDir() + "cache_by_pointer",
                      second = ::testing::TempDir() + "c";
    const std::string before = location();
    ok(set(kLocation, first.c_str()));
    EXPECT_EQ(location(), isFixed ? before : first);
    ok(rtContextSetAttribute(context_, kLocation, sizeof(char*), second.c_str()));
    EXPECT_EQ(location(), isFixed ? before : second);
    ok(set(kLocation, before.c_str()));
    if (isFixed)
        return;
    fails(RT_ERROR_INVALID_VALUE, set(kLocation, ""), "empty");
    fails(RT_ERROR_INVALID_VALUE,
          rtContextSetAttribute(context_, kLocation, sizeof(char*),
                                reinterpret_cast<const void*>(uintptr_t(64))),
          "not readable");
}

TEST_F(Attributes, OfTheDiskCache) {
    using Limits = std::array<RTsize, 2>;
    get<char>(RT_CONTEXT_ATTRIBUTE_DISK_CACHE_ENABLED);
    EXPECT_NE(get<const char*>(RT_CONTEXT_ATTRIBUTE_DISK_CACHE_LOCATION), nullptr);
    const auto kLimits = RT_CONTEXT_ATTRIBUTE_DISK_CACHE_MEMORY_LIMITS;
    if (std::getenv("OPTIX_CACHE_MAXSIZE"))
        GTEST_SKIP() << "the variable sets the limits";
    const Limits known = get<Limits>(kLimits);
    for (const Limits& good : {Limits{0, 0}, Limits{0, 5000}, Limits{1 << 20, 1 << 21}}) {
        ok(set(kLimits, good));
        EXPECT_EQ(get<Limits>(kLimits), good);
    }
    for (const Limits& bad : {Limits{5, 0}, Limits{5, 5}, Limits{6, 5}})
        fails(RT_ERROR_INVALID_VALUE, set(kLimits, bad), "mark");
    EXPECT_EQ(get<Limits>(kLimits), (Limits{1 << 20, 1 << 21}));
    ok(set(kLimits, known));
}

TEST_F(Attributes, SettingsOfContexts) {
    RTsize bytes = 0;
    ok(rtContextSetStackSize(context_, 3000));
    ok(rtContextGetStackSize(context_, &bytes));
    EXPECT_EQ(bytes, 3000u);
    unsigned number = 0;
    ok(rtContextSetMaxTraceDepth(context_, 31));
    ok(rtContextGetMaxTraceDepth(context_, &number));
    EXPECT_EQ(number, 31u);
    ok(rtContextSetPrintBufferSize(context_, 100));
    ok(rtContextGetPrintBufferSize(context_, &bytes));
    EXPECT_EQ(bytes, 100u);
    int flag = 5;
    ok(rtContextGetPrintEnabled(context_, &flag));
    EXPECT_EQ(flag, 0);
    ok(rtContextSetPrintEnabled(context_, 7));
    ok(rtContextGetPrintEnabled(context_, &flag));
    EXPECT_EQ(flag, 1);
    int x = 0, z = 0;
    ok(rtContextSetPrintLaunchIndex(context_, 3, -1, 5));
    ok(rtContextGetPrintLaunchIndex(context_, &x, nullptr, &z));
    EXPECT_EQ(x, 3);
    EXPECT_EQ(z, 5);
    ok(rtContextSetTimeoutCallback(context_, nullptr, 0));
    ok(rtContextCompile(context_));
    ok(rtContextStopProgressive(context_));
    ok(rtContextLaunch1D(context_, 0, 0) == RT_ERROR_INVALID_CONTEXT ? RT_SUCCESS
                                                                     : RT_ERROR_UNKNOWN);
    fails(RT_ERROR_INVALID_VALUE, rtContextSetPrintBufferSize(context_, 200), "launched");
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch3D(context_, 0, 1u << 31, 1, 3));
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch1D(context_, 7, 1), "7 of 1");
}

TEST_F(Attributes, ExceptionsAreSwitchedOneByOneAndTogether) {
    const auto enabled = [&](RTexception exception) {
        int value = -1;
        ok(rtContextGetExceptionEnabled(context_, exception, &value));
        return value;
    };
    const RTexception all[] = {RT_EXCEPTION_PAYLOAD_ACCESS_OUT_OF_BOUNDS,
                               RT_EXCEPTION_USER_EXCEPTION_CODE_OUT_OF_BOUNDS,
                               RT_EXCEPTION_TRACE_DEPTH_EXCEEDED,
                               RT_EXCEPTION_PROGRAM_ID_INVALID,
                               RT_EXCEPTION_TEXTURE_ID_INVALID,
                               RT_EXCEPTION_BUFFER_ID_INVALID,
                               RT_EXCEPTION_INDEX_OUT_OF_BOUNDS,
                               RT_EXCEPTION_BUFFER_INDEX_OUT_OF_BOUNDS,
                               RT_EXCEPTION_INVALID_RAY,
                               RT_EXCEPTION_INTERNAL_ERROR,
                               RT_EXCEPTION_USER};
    EXPECT_EQ(enabled(RT_EXCEPTION_STACK_OVERFLOW), 1);
    for (const RTexception each : all) {
        EXPECT_EQ(enabled(each), 0) << each;
        ok(rtContextSetExceptionEnabled(context_, each, 2));
        EXPECT_EQ(enabled(each), 1) << each;
        EXPECT_EQ(enabled(RT_EXCEPTION_ALL), each == RT_EXCEPTION_USER);
    }
    ok(rtContextSetExceptionEnabled(context_, RT_EXCEPTION_ALL, 0));
    EXPECT_EQ(enabled(RT_EXCEPTION_STACK_OVERFLOW), 0);
    EXPECT_EQ(enabled(RT_EXCEPTION_USER), 0);
    for (const int bad : {0, RT_EXCEPTION_USER + 1, int(RT_EXCEPTION_USER_MAX), 0x3EA})
        fails(RT_ERROR_INVALID_VALUE, rtContextSetExceptionEnabled(context_, RTexception(bad), 1));
}

TEST_F(Attributes, EntryPointsAndRayTypes) {
    RTprogram entry = program("write_scoped"), found = entry;
    RTprogram callable = program("multiply"), parameters = program("square_hit");
    unsigned count = 0;
    ok(rtContextSetEntryPointCount(context_, 3));
    ok(rtContextGetEntryPointCount(context_, &count));
    EXPECT_EQ(count, 3u);
    ok(rtContextGetRayGenerationProgram(context_, 2, &found));
    EXPECT_EQ(found, nullptr);
    for (const auto& [set, get] :
         {std::pair(&rtContextSetRayGenerationProgram, &rtContextGetRayGenerationProgram),
          std::pair(&rtContextSetExceptionProgram, &rtContextGetExceptionProgram)}) {
        ok(set(context_, 2, entry));
        ok(get(context_, 2, &found));
        EXPECT_EQ(found, entry);
        fails(RT_ERROR_INVALID_VALUE, set(context_, 3, entry), "3 of 3");
        fails(RT_ERROR_INVALID_VALUE, get(context_, 3, &found));
        fails(RT_ERROR_TYPE_MISMATCH, set(context_, 2, callable));
        fails(RT_ERROR_TYPE_MISMATCH, set(context_, 2, parameters));
    }
    ok(rtContextGetRayTypeCount(context_, &count));
    EXPECT_EQ(count, 2u);
    ok(rtContextSetMissProgram(context_, 1, entry));
    ok(rtContextGetMissProgram(context_, 1, &found));
    EXPECT_EQ(found, entry);
    fails(RT_ERROR_INVALID_VALUE, rtContextSetMissProgram(context_, 2, entry), "2 of 2");
    fails(RT_ERROR_INVALID_VALUE, rtContextGetMissProgram(context_, 2, &found));
    fails(RT_ERROR_TYPE_MISMATCH, rtContextSetMissProgram(context_, 1, callable));
    ok(rtContextSetRayTypeCount(context_, 1));
    ok(rtContextSetRayTypeCount(context_, 2));
    ok(rtContextGetMissProgram(context_, 1, &found));
    EXPECT_EQ(found, nullptr) << "a slot that was dropped";
}

TEST_F(Attributes, OfDevices) {
    unsigned count = 0;
    ok(rtDeviceGetDeviceCount(&count));
    ASSERT_GT(count, 0u);
    int number[8] = {};
    for (const RTdeviceattribute each :
         {RT_DEVICE_ATTRIBUTE_MAX_THREADS_PER_BLOCK, RT_DEVICE_ATTRIBUTE_CLOCK_RATE,
          RT_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT, RT_DEVICE_ATTRIBUTE_EXECUTION_TIMEOUT_ENABLED,
          RT_DEVICE_ATTRIBUTE_MAX_HARDWARE_TEXTURE_COUNT, RT_DEVICE_ATTRIBUTE_TCC_DRIVER,
          RT_DEVICE_ATTRIBUTE_CUDA_DEVICE_ORDINAL}) {
        ok(rtDeviceGetAttribute(0, each, sizeof(int), number));
        EXPECT_EQ(rtDeviceGetAttribute(0, each, 2, number), RT_ERROR_INVALID_VALUE) << each;
        EXPECT_EQ(rtDeviceGetAttribute(0, each, sizeof(int), nullptr), RT_ERROR_INVALID_VALUE);
        EXPECT_EQ(rtDeviceGetAttribute(int(count), each, sizeof(int), number),
                  RT_ERROR_INVALID_VALUE);
        EXPECT_EQ(rtDeviceGetAttribute(-1, each, sizeof(int), number), RT_ERROR_INVALID_VALUE);
    }
    ok(rtDeviceGetAttribute(0, RT_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY, 2 * sizeof(int), number));
    EXPECT_GE(number[0], 5);
    RTsize memory = 0;
    ok(rtDeviceGetAttribute(0, RT_DEVICE_ATTRIBUTE_TOTAL_MEMORY, sizeof memory, &memory));
    EXPECT_GT(memory, 0u);
    char text[40], start[4];
    ok(rtDeviceGetAttribute(0, RT_DEVICE_ATTRIBUTE_NAME, sizeof text, text));
    ok(rtDeviceGetAttribute(0, RT_DEVICE_ATTRIBUTE_NAME, sizeof start, start));
    EXPECT_EQ(std::string(start), std::string(text).substr(0, 3));
    ok(rtDeviceGetAttribute(0, RT_DEVICE_ATTRIBUTE_PCI_BUS_ID, sizeof text, text));
    EXPECT_LE(std::strlen(text), 13u);
    ok(rtDeviceGetAttribute(0, RT_DEVICE_ATTRIBUTE_COMPATIBLE_DEVICES, 2 * sizeof(int), number));
    EXPECT_GE(number[0], 1);
    EXPECT_EQ(rtDeviceGetAttribute(0, RTdeviceattribute(99), 4, number), RT_ERROR_INVALID_VALUE);
}

TEST_F(Attributes, OfTheLibrary) {
    unsigned version = 0;
    ok(rtGetVersion(&version));
    EXPECT_EQ(version, 60000u);
    int rtx = -1;
    ok(rtGlobalGetAttribute(RT_GLOBAL_ATTRIBUTE_ENABLE_RTX, sizeof rtx, &rtx));
    EXPECT_EQ(rtx, 0);
    for (const int value : {1, 0}) {
        ok(rtGlobalSetAttribute(RT_GLOBAL_ATTRIBUTE_ENABLE_RTX, sizeof value, &value));
        ok(rtGlobalGetAttribute(RT_GLOBAL_ATTRIBUTE_ENABLE_RTX, sizeof rtx, &rtx));
        EXPECT_EQ(rtx, value);
    }
    EXPECT_EQ(rtGlobalSetAttribute(RT_GLOBAL_ATTRIBUTE_ENABLE_RTX, 1, &rtx),
              RT_ERROR_INVALID_VALUE);
    EXPECT_EQ(rtGlobalGetAttribute(RT_GLOBAL_ATTRIBUTE_ENABLE_RTX, 1, &rtx),
              RT_ERROR_INVALID_VALUE);
    const auto unknown = RTglobalattribute(0x77);
    EXPECT_EQ(rtGlobalSetAttribute(unknown, 4, &rtx), RT_ERROR_INVALID_GLOBAL_ATTRIBUTE);
    EXPECT_EQ(rtGlobalGetAttribute(unknown, 4, &rtx), RT_ERROR_INVALID_GLOBAL_ATTRIBUTE);
    EXPECT_EQ(rtGlobalSetAttribute(RT_GLOBAL_ATTRIBUTE_DISPLAY_DRIVER_VERSION_MAJOR, 4, &rtx),
              RT_ERROR_INVALID_GLOBAL_ATTRIBUTE);
}

TEST_F(Attributes, DevicesOfContexts) {
    unsigned count = 0;
    ok(rtContextGetDeviceCount(context_, &count));
    EXPECT_EQ(count, 1u);
    int device = -1;
    ok(rtContextGetDevices(context_, &device));
    EXPECT_EQ(device, 0);
    const int twice[] = {0, 0}, beyond[] = {99};
    EXPECT_EQ(rtContextSetDevices(context_, 0, twice), RT_ERROR_INVALID_VALUE);
    EXPECT_EQ(rtContextSetDevices(context_, 2, twice), RT_ERROR_INVALID_VALUE);
    EXPECT_EQ(rtContextSetDevices(context_, 1, beyond), RT_ERROR_INVALID_DEVICE);
    EXPECT_EQ(rtContextSetDevices(context_, 1, nullptr), RT_ERROR_INVALID_VALUE);
    ok(rtContextSetDevices(context_, 1, twice));
}

TEST_F(Attributes, UsageReportsHaveTheLevelsOfTheManual) {
    const auto callback = [](int, const char*, const char*, void*) {};
    fails(RT_ERROR_INVALID_VALUE, rtContextSetUsageReportCallback(context_, callback, 4, nullptr));
    fails(RT_ERROR_INVALID_VALUE, rtContextSetUsageReportCallback(context_, callback, -1, nullptr));
    fails(RT_ERROR_INVALID_VALUE, rtContextSetUsageReportCallback(context_, nullptr, 1, nullptr));
    ok(rtContextSetUsageReportCallback(context_, nullptr, 0, nullptr));
    ok(rtContextSetUsageReportCallback(context_, callback, 3, nullptr));
}

// ---- buffers, samplers ------------------------------------------------------------------------

TEST_F(Attributes, BuffersOfProgramsMustBeComplete) {
    RTbuffer made = nullptr;
    ok(rtBufferCreate(context_, RT_BUFFER_OUTPUT, &made));
    ok(rtVariableSetObject(variable("result"), made));
    ok(rtVariableSet1f(variable("scoped"), 3));
    setEntry("write_scoped");
    const auto isRefused = [&](const char* what) {
        const std::string text = std::string("\"result\" of program \"write_scoped\" has ") + what;
        fails(RT_ERROR_INVALID_CONTEXT, rtContextValidate(context_), text);
        fails(RT_ERROR_INVALID_CONTEXT, rtContextLaunch1D(context_, 0, 1), text);
    };
    isRefused("no format");
    ok(rtBufferSetFormat(made, RT_FORMAT_USER));
    isRefused("the format RT_FORMAT_USER and no element size");
    ok(rtBufferSetElementSize(made, 4));
    isRefused("no size");
    ok(rtBufferSetSize1D(made, 0));
    ok(rtContextLaunch1D(context_, 0, 1));
}

TEST_F(Attributes, FormatsAndSizesOfBuffers) {
    RTbuffer made = nullptr;
    ok(rtBufferCreate(context_, RT_BUFFER_INPUT, &made));
    fails(RT_ERROR_INVALID_CONTEXT, rtBufferValidate(made), "format");
    fails(RT_ERROR_INVALID_VALUE, rtBufferSetFormat(made, RT_FORMAT_UNKNOWN));
    fails(RT_ERROR_INVALID_VALUE, rtBufferSetFormat(made, RTformat(0x999)));
    fails(RT_ERROR_TYPE_MISMATCH, rtBufferSetElementSize(made, 8), "RT_FORMAT_USER");
    ok(rtBufferSetFormat(made, RT_FORMAT_USER));
    fails(RT_ERROR_INVALID_VALUE, rtBufferSetElementSize(made, 0));
    ok(rtBufferSetElementSize(made, 24));
    RTsize size[3] = {};
    ok(rtBufferGetElementSize(made, size));
    EXPECT_EQ(size[0], 24u);
    RTformat format{};
    ok(rtBufferGetFormat(made, &format));
    EXPECT_EQ(format, RT_FORMAT_USER);
    fails(RT_ERROR_INVALID_CONTEXT, rtBufferValidate(made), "size");
    const RTsize sizes[] = {8, 4, 2};
    ok(rtBufferSetSizev(made, 3, sizes));
    fails(RT_ERROR_INVALID_VALUE, rtBufferSetSizev(made, 0, sizes));
    fails(RT_ERROR_INVALID_VALUE, rtBufferSetSizev(made, 4, sizes));
    fails(RT_ERROR_INVALID_VALUE, rtBufferSetSize2D(made, 0, 1));
    fails(RT_ERROR_MEMORY_ALLOCATION_FAILED, rtBufferSetSize3D(made, 1 << 30, 1 << 30, 1 << 30));
    unsigned number = 0;
    ok(rtBufferGetDimensionality(made, &number));
    EXPECT_EQ(number, 3u);
    ok(rtBufferGetSize3D(made, size, size + 1, size + 2));
    EXPECT_EQ(size[2], 2u);
    ok(rtBufferGetSize2D(made, size, size + 1));
    EXPECT_EQ(size[1], 4u);
    ok(rtBufferGetSize1D(made, size));
    EXPECT_EQ(size[0], 8u);
    ok(rtBufferGetSizev(made, 3, size));
    EXPECT_EQ(size[1], 4u);
    fails(RT_ERROR_INVALID_VALUE, rtBufferGetSizev(made, 4, size));
    fails(RT_ERROR_INVALID_VALUE, rtBufferSetMipLevelCount(made, 5));
    fails(RT_ERROR_INVALID_VALUE, rtBufferSetMipLevelCount(made, 0));
    ok(rtBufferSetMipLevelCount(made, 4));
    ok(rtBufferGetMipLevelCount(made, &number));
    EXPECT_EQ(number, 4u);
    ok(rtBufferGetMipLevelSize3D(made, 1, size, size + 1, size + 2));
    EXPECT_EQ(size[0], 4u);
    EXPECT_EQ(size[2], 1u);
    ok(rtBufferGetMipLevelSize2D(made, 3, size, size + 1));
    EXPECT_EQ(size[0], 1u);
    fails(RT_ERROR_INVALID_VALUE, rtBufferGetMipLevelSize1D(made, 4, size), "level = 4");
    ok(rtBufferValidate(made));
    RTcontext owner = nullptr;
    ok(rtBufferGetContext(made, &owner));
    EXPECT_EQ(owner, context_);
    ok(rtBufferDestroy(made));
    fails(RT_ERROR_INVALID_VALUE, rtBufferValidate(made));
}

TEST_F(Attributes, DescriptionsOfBuffers) {
    const unsigned in = RT_BUFFER_INPUT, out = RT_BUFFER_OUTPUT, both = RT_BUFFER_INPUT_OUTPUT;
    const unsigned stream = RT_BUFFER_PROGRESSIVE_STREAM;
    RTbuffer made = nullptr;
    for (const unsigned good :
         {in, out, both | RT_BUFFER_GPU_LOCAL, in | RT_BUFFER_COPY_ON_DIRTY,
          in | RT_BUFFER_DISCARD_HOST_MEMORY, in | RT_BUFFER_LAYERED, in | RT_BUFFER_CUBEMAP})
        ok(rtBufferCreate(context_, good, &made));
    for (const unsigned bad : {0u, in | RT_BUFFER_GPU_LOCAL, out | RT_BUFFER_DISCARD_HOST_MEMORY,
                               stream | RT_BUFFER_LAYERED, in | 0x1000u}) {
        fails(RT_ERROR_INVALID_VALUE, rtBufferCreate(context_, bad, &made));
        EXPECT_EQ(made, nullptr);
    }
}

TEST_F(Attributes, MappedBuffersRefuseChanges) {
    RTbuffer made = buffer(RT_BUFFER_INPUT_OUTPUT, RT_FORMAT_FLOAT, 4);
    void *data = nullptr, *again = nullptr;
    fails(RT_ERROR_INVALID_VALUE, rtBufferUnmap(made), "not mapped");
    fails(RT_ERROR_INVALID_VALUE, rtBufferMapEx(made, 77, 0, nullptr, &data), "77");
    fails(RT_ERROR_INVALID_VALUE, rtBufferMapEx(made, RT_BUFFER_MAP_READ, 1, nullptr, &data));
    fails(RT_ERROR_INVALID_VALUE, rtBufferMapEx(made, RT_BUFFER_MAP_READ, 0, &data, &data));
    ok(rtBufferMapEx(made, RT_BUFFER_MAP_READ, 0, nullptr, &data));
    fails(RT_ERROR_ALREADY_MAPPED, rtBufferMap(made, &again));
    fails(RT_ERROR_ALREADY_MAPPED, rtBufferSetSize1D(made, 5));
    fails(RT_ERROR_ALREADY_MAPPED, rtBufferSetFormat(made, RT_FORMAT_INT));
    setEntry("write_scoped");
    fails(RT_ERROR_ALREADY_MAPPED, rtContextLaunch1D(context_, 0, 1), "mapped");
    fails(RT_ERROR_INVALID_VALUE, rtBufferUnmapEx(made, 1));
    ok(rtBufferUnmapEx(made, 0));
    ok(rtBufferMarkDirty(made));
    fails(RT_ERROR_INVALID_VALUE, rtBufferMarkDirty(nullptr));
    fails(RT_ERROR_INVALID_VALUE, rtBufferGetDevicePointer(made, 9, &data), "9");
    ok(rtBufferGetDevicePointer(made, 0, &data));
    EXPECT_NE(data, nullptr);
    fails(RT_ERROR_INVALID_VALUE, rtBufferSetDevicePointer(made, 9, data));
}

// A product of sizes that wraps around would be a small size.
TEST_F(Attributes, SizesOfBuffersAfterTheirFormatFitIntoMemory) {
    RTbuffer made = nullptr;
    ok(rtBufferCreate(context_, RT_BUFFER_INPUT, &made));
    constexpr RTsize kElement = 274177, kElements = 67280421310721; // their product is 2^64 + 1
    ok(rtBufferSetSize1D(made, kElements));
    ok(rtBufferSetFormat(made, RT_FORMAT_USER));
    fails(RT_ERROR_MEMORY_ALLOCATION_FAILED, rtBufferSetElementSize(made, kElement), "274177");
    fails(RT_ERROR_MEMORY_ALLOCATION_FAILED, rtBufferSetFormat(made, RT_FORMAT_FLOAT4));
    ok(rtBufferSetSize1D(made, 2));
    ok(rtBufferSetElementSize(made, kElement));
    fails(RT_ERROR_MEMORY_ALLOCATION_FAILED, rtBufferSetSize1D(made, kElements));
    void* data = nullptr;
    ok(rtBufferMap(made, &data));
    ok(rtBufferUnmap(made));

    fails(RT_ERROR_MEMORY_ALLOCATION_FAILED, rtBufferSetSize1D(made, RTsize(1) << 27));
    fails(RT_ERROR_MEMORY_ALLOCATION_FAILED, rtBufferMap(made, &data));
}

TEST_F(Attributes, LevelsOfBuffersFitTheirSize) {
    RTbuffer made = nullptr;
    ok(rtBufferCreate(context_, RT_BUFFER_INPUT, &made));
    ok(rtBufferSetFormat(made, RT_FORMAT_FLOAT));
    fails(RT_ERROR_INVALID_VALUE, rtBufferSetMipLevelCount(made, ~0u), "levels");
    ok(rtBufferSetMipLevelCount(made, 40)); // more than any texture has
    ok(rtBufferSetSize2D(made, 0, 0));
    ok(rtBufferValidate(made));
    ok(rtBufferSetSize2D(made, 4, 4));
    fails(RT_ERROR_INVALID_VALUE, rtBufferValidate(made), "levels = 40");
    RTtexturesampler sampler = nullptr;
    ok(rtTextureSamplerCreate(context_, &sampler));
    ok(rtTextureSamplerSetBuffer(sampler, 0, 0, made));
    ok(rtTextureSamplerSetFilteringModes(sampler, RT_FILTER_LINEAR, RT_FILTER_LINEAR,
                                         RT_FILTER_LINEAR));
    fails(RT_ERROR_INVALID_VALUE, rtTextureSamplerValidate(sampler), "levels");
    int id = 0;
    ok(rtTextureSamplerGetId(sampler, &id));
    setEntry("write_scoped");
    ok(rtVariableSet1f(variable("scoped"), 3));
    fails(RT_ERROR_INVALID_VALUE, rtContextLaunch1D(context_, 0, 1), "levels");
    ok(rtBufferSetMipLevelCount(made, 3));
    ok(rtTextureSamplerValidate(sampler));
}

TEST_F(Attributes, OfTextureSamplers) {
    RTtexturesampler made = nullptr;
    ok(rtTextureSamplerCreate(context_, &made));
    for (unsigned dimension = 0; dimension < 3; ++dimension)
        for (const RTwrapmode mode :
             {RT_WRAP_REPEAT, RT_WRAP_CLAMP_TO_EDGE, RT_WRAP_MIRROR, RT_WRAP_CLAMP_TO_BORDER}) {
            RTwrapmode found{};
            ok(rtTextureSamplerSetWrapMode(made, dimension, mode));
            ok(rtTextureSamplerGetWrapMode(made, dimension, &found));
            EXPECT_EQ(found, mode);
        }
    RTwrapmode wrap{};
    fails(RT_ERROR_INVALID_VALUE, rtTextureSamplerSetWrapMode(made, 3, RT_WRAP_REPEAT));
    fails(RT_ERROR_INVALID_VALUE, rtTextureSamplerGetWrapMode(made, 3, &wrap));
    fails(RT_ERROR_INVALID_VALUE, rtTextureSamplerSetWrapMode(made, 0, RTwrapmode(4)));
    RTfiltermode filters[3] = {};
    ok(rtTextureSamplerSetFilteringModes(made, RT_FILTER_LINEAR, RT_FILTER_NEAREST,
                                         RT_FILTER_NONE));
    fails(RT_ERROR_INVALID_VALUE, rtTextureSamplerSetFilteringModes(
                                      made, RT_FILTER_NONE, RT_FILTER_NEAREST, RT_FILTER_NONE));
    ok(rtTextureSamplerGetFilteringModes(made, filters, filters + 1, filters + 2));
    EXPECT_EQ(filters[0], RT_FILTER_LINEAR);
    EXPECT_EQ(filters[1], RT_FILTER_NEAREST);
    EXPECT_EQ(filters[2], RT_FILTER_NONE);
    float value = 0, other = 0;
    for (const auto& [given, kept] :
         {std::pair(0.5f, 1.0f), std::pair(4.0f, 4.0f), std::pair(99.0f, 16.0f)}) {
        ok(rtTextureSamplerSetMaxAnisotropy(made, given));
        ok(rtTextureSamplerGetMaxAnisotropy(made, &value));
        EXPECT_EQ(value, kept);
    }
    ok(rtTextureSamplerSetMipLevelBias(made, -2));
    ok(rtTextureSamplerGetMipLevelBias(made, &value));
    EXPECT_EQ(value, -2);
    ok(rtTextureSamplerSetMipLevelClamp(made, 1, 3));
    ok(rtTextureSamplerGetMipLevelClamp(made, &value, &other));
    EXPECT_EQ(value, 1);
    EXPECT_EQ(other, 3);
    RTtexturereadmode read{};
    ok(rtTextureSamplerSetReadMode(made, RT_TEXTURE_READ_NORMALIZED_FLOAT_SRGB));
    fails(RT_ERROR_INVALID_VALUE, rtTextureSamplerSetReadMode(made, RTtexturereadmode(4)));
    ok(rtTextureSamplerGetReadMode(made, &read));
    EXPECT_EQ(read, RT_TEXTURE_READ_NORMALIZED_FLOAT_SRGB);
    RTtextureindexmode indexing{};
    ok(rtTextureSamplerSetIndexingMode(made, RT_TEXTURE_INDEX_ARRAY_INDEX));
    fails(RT_ERROR_INVALID_VALUE, rtTextureSamplerSetIndexingMode(made, RTtextureindexmode(2)));
    ok(rtTextureSamplerGetIndexingMode(made, &indexing));
    EXPECT_EQ(indexing, RT_TEXTURE_INDEX_ARRAY_INDEX);
    RTbuffer texels = buffer(RT_BUFFER_INPUT, RT_FORMAT_LONG_LONG, 4), found = nullptr;
    ok(rtTextureSamplerSetBuffer(made, 0, 0, texels));
    fails(RT_ERROR_INVALID_VALUE, rtTextureSamplerSetBuffer(made, 1, 0, texels));
    fails(RT_ERROR_INVALID_VALUE, rtTextureSamplerGetBuffer(made, 0, 1, &found));
    ok(rtTextureSamplerGetBuffer(made, 0, 0, &found));
    EXPECT_EQ(found, texels);
    fails(RT_ERROR_INVALID_CONTEXT, rtTextureSamplerValidate(made), "format");
    unsigned count = 0;
    ok(rtTextureSamplerSetMipLevelCount(made, 1));
    ok(rtTextureSamplerGetMipLevelCount(made, &count));
    EXPECT_EQ(count, 1u);
    fails(RT_ERROR_INVALID_VALUE, rtTextureSamplerSetArraySize(made, 2));
    ok(rtTextureSamplerGetArraySize(made, &count));
    EXPECT_EQ(count, 1u);
    RTcontext owner = nullptr;
    ok(rtTextureSamplerGetContext(made, &owner));
    ok(rtTextureSamplerDestroy(made));
    fails(RT_ERROR_INVALID_VALUE, rtTextureSamplerValidate(made));
}

TEST_F(Attributes, OfVariables) {
    RTvariable made = variable("some_float3");
    RTobjecttype type{};
    RTsize size = 7;
    ok(rtVariableGetType(made, &type));
    EXPECT_EQ(type, RT_OBJECTTYPE_UNKNOWN);
    ok(rtVariableSet3f(made, 1, 2, 3));
    ok(rtVariableGetType(made, &type));
    EXPECT_EQ(type, RT_OBJECTTYPE_FLOAT3);
    ok(rtVariableGetSize(made, &size));
    EXPECT_EQ(size, 12u);
    const char* text = nullptr;
    ok(rtVariableGetName(made, &text));
    EXPECT_STREQ(text, "some_float3");
    program("write_values");
    ok(rtVariableGetAnnotation(made, &text));
    EXPECT_NE(std::string(text).find("three"), std::string::npos) << text;
    fails(RT_ERROR_TYPE_MISMATCH, rtVariableSet3i(made, 1, 2, 3), "some_float3");
    fails(RT_ERROR_TYPE_MISMATCH, rtVariableSetObject(made, result_));
    float x = 0, y = 0, z = 0;
    fails(RT_ERROR_TYPE_MISMATCH, rtVariableGet2f(made, &x, &y));
    ok(rtVariableGet3f(made, &x, &y, &z));
    EXPECT_EQ(y, 2);
    RTvariable object = variable("result");
    RTobject found = nullptr;
    ok(rtVariableGetObject(object, &found));
    EXPECT_EQ(found, result_);
    fails(RT_ERROR_TYPE_MISMATCH, rtVariableGetObject(made, &found));
    RTvariable user = variable("some_user");
    const int data[4] = {1, 2, 3, 4};
    int copy[4] = {};
    ok(rtVariableSetUserData(user, sizeof data, data));
    ok(rtVariableGetUserData(user, sizeof copy, copy));
    EXPECT_EQ(copy[3], 4);
    EXPECT_NE(rtVariableGetUserData(user, 3, copy), RT_SUCCESS);
    EXPECT_NE(rtVariableSetUserData(user, 0, data), RT_SUCCESS);
    RTcontext owner = nullptr;
    ok(rtVariableGetContext(made, &owner));
    EXPECT_EQ(owner, context_);
}

} // namespace
} // namespace sunstone::api6
