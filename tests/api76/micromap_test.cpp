// SPDX-License-Identifier: Apache-2.0
// Opacity micromaps through the API (OptiX 7.6, optixOpacityMicromapArray...): violations of every
// rule about arguments, one at a time; relocation, compaction and updates of arrays and structures;
// and traversal. The combinations of states and flags are tested in ../reference and src/devlib.
#include "device/probe.h"
#include "rig.h"
#include "scene.h"

#include <functional>

namespace tests::api {
namespace {

constexpr const char* kArrayUsage = "optixOpacityMicromapArrayComputeMemoryUsage";
constexpr const char* kArrayBuild = "optixOpacityMicromapArrayBuild";
constexpr const char* kArrayInfo = "optixOpacityMicromapArrayGetRelocationInfo";
constexpr const char* kArrayRelocate = "optixOpacityMicromapArrayRelocate";
constexpr const char* kUsage = "optixAccelComputeMemoryUsage";
constexpr const char* kBuild = "optixAccelBuild";
constexpr const char* kRelocate = "optixAccelRelocate";
constexpr OptixTraversableHandle kNoHandle = 0x1234;

// An array of `count` micromaps of level 1: micro-triangle k of map i is opaque if bit k of i is
// set. Description, states and buffers are open to tests.
struct Array {
    explicit Array(unsigned count = 16) {
        std::vector<unsigned char> bytes;
        std::vector<OptixOpacityMicromapDesc> descs;
        for (unsigned i = 0; i < count; ++i) {
            OptixOpacityMicromapDesc desc{};
            desc.byteOffset = i;
            desc.subdivisionLevel = 1;
            desc.format = OPTIX_OPACITY_MICROMAP_FORMAT_2_STATE;
            descs.push_back(desc);
            bytes.push_back((unsigned char)(i & 15));
        }
        states = Buffer(bytes);
        descriptions = Buffer(descs);
        histogram = {{count, 1, OPTIX_OPACITY_MICROMAP_FORMAT_2_STATE}};
        input.flags = OPTIX_OPACITY_MICROMAP_FLAG_NONE;
        input.inputBuffer = states.address();
        input.perMicromapDescBuffer = descriptions.address();
        input.numMicromapHistogramEntries = 1;
        input.micromapHistogramEntries = histogram.data();
    }
    void allocate(OptixDeviceContext context) {
        OptixMicromapBufferSizes sizes{};
        ASSERT_EQ(OPTIX_SUCCESS,
                  optixOpacityMicromapArrayComputeMemoryUsage(context, &input, &sizes));
        output = Buffer(sizes.outputSizeInBytes);
        temp = Buffer(sizes.tempSizeInBytes);
        buffers = {output.address(), output.size(), temp.address(), temp.size()};
    }
    OptixResult build(OptixDeviceContext context) {
        allocate(context);
        const OptixResult result =
            optixOpacityMicromapArrayBuild(context, nullptr, &input, &buffers);
        waitForDevice();
        return result;
    }

    Buffer states, descriptions, output, temp;
    std::vector<OptixOpacityMicromapHistogramEntry> histogram;
    OptixOpacityMicromapArrayBuildInput input{};
    OptixMicromapBuffers buffers{};
};

// Right triangles with legs of length 1 in the plane z = 0 at x = 0, 2, 4 ...
std::unique_ptr<TriangleMesh> row(unsigned count) {
    std::vector<Vec3> points;
    std::vector<uint32_t> corners;
    for (unsigned i = 0; i < count; ++i) {
        const float x = 2.0f * float(i);
        points.insert(points.end(), {{x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0}});
        corners.insert(corners.end(), {3 * i, 3 * i + 1, 3 * i + 2});
    }
    return std::make_unique<TriangleMesh>(points, corners);
}

void useLinear(OptixBuildInput& input, const Array& array) {
    auto& m = input.triangleArray.opacityMicromap;
    m.indexingMode = OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_LINEAR;
    m.opacityMicromapArray = array.output.address();
}
void useIndices(OptixBuildInput& input, const Array& array, const Buffer& indices) {
    auto& m = input.triangleArray.opacityMicromap;
    m.indexingMode = OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_INDEXED;
    m.opacityMicromapArray = array.output.address();
    m.indexBuffer = indices.address();
    m.indexSizeInBytes = 4;
}

// The error of queued work: the next call on the stream returns it, once.
OptixResult failureOfStream(OptixDeviceContext context) {
    waitForDevice();
    Array array(1);
    return array.build(context);
}

// ---- arguments ----

class MicromapArguments : public ApiTest {
protected:
    void SetUp() override {
        ApiTest::SetUp();
        ASSERT_OK(array_.build(context_));
        mesh_ = row(2);
    }

    // An input that both functions of an array must refuse.
    void expectBad(const char* mention,
                   const std::function<void(OptixOpacityMicromapArrayBuildInput&)>& change) {
        OptixOpacityMicromapArrayBuildInput input = array_.input;
        change(input);
        OptixMicromapBufferSizes sizes{7, 7};
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kArrayUsage, mention,
                        optixOpacityMicromapArrayComputeMemoryUsage(context_, &input, &sizes));
        EXPECT_EQ(sizes.outputSizeInBytes, 7u);
        EXPECT_EQ(sizes.tempSizeInBytes, 7u);
        expectBadBuild(mention, input, array_.buffers);
    }
    // An input that only the build checks.
    void expectBadBuffer(const char* mention,
                         const std::function<void(OptixOpacityMicromapArrayBuildInput&,
                                                  OptixMicromapBuffers&)>& change) {
        OptixOpacityMicromapArrayBuildInput input = array_.input;
        OptixMicromapBuffers buffers = array_.buffers;
        change(input, buffers);
        expectBadBuild(mention, input, buffers);
    }
    void expectBadBuild(const char* mention, const OptixOpacityMicromapArrayBuildInput& input,
                        const OptixMicromapBuffers& buffers) {
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kArrayBuild, mention,
                        optixOpacityMicromapArrayBuild(context_, nullptr, &input, &buffers));
    }

    OptixResult usage(const OptixBuildInput& input, unsigned flags = 0) {
        OptixAccelBuildOptions options = buildOptions(flags);
        OptixAccelBufferSizes sizes{};
        return optixAccelComputeMemoryUsage(context_, &options, &input, 1, &sizes);
    }
    OptixResult build(const OptixBuildInput& input, unsigned flags = 0) {
        OptixAccelBuildOptions options = buildOptions(flags);
        temp_ = Buffer(1 << 16);
        output_ = Buffer(1 << 16);
        handle_ = kNoHandle;
        return optixAccelBuild(context_, nullptr, &options, &input, 1, temp_.address(),
                               temp_.size(), output_.address(), output_.size(), &handle_, nullptr,
                               0);
    }
    void expectBadInput(const char* mention,
                        const std::function<void(OptixBuildInputOpacityMicromap&)>& change,
                        bool buffersOnly = false) {
        OptixBuildInput input = mesh_->input;
        useLinear(input, array_);
        change(input.triangleArray.opacityMicromap);
        if (buffersOnly)
            EXPECT_OK(usage(input));
        else
            EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kUsage, mention, usage(input));
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kBuild, mention, build(input));
        EXPECT_EQ(kNoHandle, handle_);
    }

    Array array_;
    std::unique_ptr<TriangleMesh> mesh_;
    Buffer temp_, output_;
    OptixTraversableHandle handle_ = 0;
};

TEST_F(MicromapArguments, OfArrays) {
    using Input = OptixOpacityMicromapArrayBuildInput;
    const auto withEntry = [&](OptixOpacityMicromapHistogramEntry entry) {
        array_.histogram[0] = entry;
        return [](Input&) {};
    };
    const OptixOpacityMicromapHistogramEntry good = array_.histogram[0];
    expectBad("flags = 4", [](Input& in) { in.flags = 4; });
    expectBad("micromapHistogramEntries", [](Input& in) { in.micromapHistogramEntries = nullptr; });
    expectBad("subdivisionLevel = 13", withEntry({1, 13, OPTIX_OPACITY_MICROMAP_FORMAT_2_STATE}));
    expectBad("subdivisionLevel", withEntry({1, ~0u, OPTIX_OPACITY_MICROMAP_FORMAT_2_STATE}));
    expectBad("format = 0", withEntry({1, 1, OPTIX_OPACITY_MICROMAP_FORMAT_NONE}));
    expectBad("format = 3", withEntry({1, 1, OptixOpacityMicromapFormat(3)}));
    expectBad("limits", withEntry({~0u, 12, OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE}));
    array_.histogram[0] = good;
    for (unsigned stride : {4u, 7u, 12u})
        expectBadBuffer("perMicromapDescStrideInBytes", [&](Input& in, OptixMicromapBuffers&) {
            in.perMicromapDescStrideInBytes = stride;
        });
    using Buffers = OptixMicromapBuffers;
    expectBadBuffer("inputBuffer", [](Input& in, Buffers&) { in.inputBuffer = 0; });
    expectBadBuffer("inputBuffer", [](Input& in, Buffers&) {
        in.inputBuffer += OPTIX_OPACITY_MICROMAP_ARRAY_BUFFER_BYTE_ALIGNMENT / 2;
    });
    expectBadBuffer("inputBuffer", [](Input& in, Buffers&) { in.inputBuffer = 128; });
    expectBadBuffer("perMicromapDescBuffer",
                    [](Input& in, Buffers&) { in.perMicromapDescBuffer = 0; });
    expectBadBuffer("perMicromapDescBuffer", [](Input& in, Buffers&) {
        in.perMicromapDescBuffer += OPTIX_OPACITY_MICROMAP_DESC_BUFFER_BYTE_ALIGNMENT / 2;
    });
    expectBadBuffer("perMicromapDescBuffer",
                    [](Input& in, Buffers&) { in.perMicromapDescBuffer = 0x4141414141414140; });
    expectBadBuffer("output", [](Input&, Buffers& b) { b.output = 0; });
    expectBadBuffer("output", [](Input&, Buffers& b) { b.output += 64; });
    expectBadBuffer("outputSizeInBytes", [](Input&, Buffers& b) { --b.outputSizeInBytes; });
    expectBadBuffer("temp", [](Input&, Buffers& b) { b.temp = 0; });
    expectBadBuffer("temp", [](Input&, Buffers& b) { b.temp += 64; });
    expectBadBuffer("tempSizeInBytes", [](Input&, Buffers& b) { --b.tempSizeInBytes; });

    OptixMicromapBufferSizes sizes{};
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kArrayUsage, "buildInput is null",
                    optixOpacityMicromapArrayComputeMemoryUsage(context_, nullptr, &sizes));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kArrayUsage, "bufferSizes is null",
                    optixOpacityMicromapArrayComputeMemoryUsage(context_, &array_.input, nullptr));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kArrayBuild, "buildInput is null",
                    optixOpacityMicromapArrayBuild(context_, nullptr, nullptr, &array_.buffers));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kArrayBuild, "buffers is null",
                    optixOpacityMicromapArrayBuild(context_, nullptr, &array_.input, nullptr));
    for (void* garbage : garbageHandles()) {
        const auto context = static_cast<OptixDeviceContext>(garbage);
        EXPECT_NE(OPTIX_SUCCESS,
                  optixOpacityMicromapArrayComputeMemoryUsage(context, &array_.input, &sizes));
        EXPECT_NE(OPTIX_SUCCESS,
                  optixOpacityMicromapArrayBuild(context, nullptr, &array_.input, &array_.buffers));
    }
}

// Harmless violations of rules: a warning, and an error in validation mode.
TEST_F(MicromapArguments, HarmlessFaults) {
    const Buffer indices(64);
    for (const bool validation : {false, true}) {
        OptixDeviceContextOptions options{};
        options.logCallbackFunction = LogRecord::callback;
        options.logCallbackData = &log_;
        options.logCallbackLevel = 4;
        if (validation)
            options.validationMode = OPTIX_DEVICE_CONTEXT_VALIDATION_MODE_ALL;
        ASSERT_OK(optixDeviceContextDestroy(context_));
        ASSERT_OK(optixDeviceContextCreate(nullptr, &options, &context_));
        const OptixResult expected = validation ? OPTIX_ERROR_INVALID_VALUE : OPTIX_SUCCESS;
        const auto tolerated = [&](const char* function, const char* mention, OptixResult result) {
            waitForDevice();
            EXPECT_EQ(expected, result) << log_.all();
            bool found = false;
            for (const LogLine& line : log_.lines())
                found |= line.level == (validation ? 2u : 3u) &&
                         line.text.find(function) != std::string::npos &&
                         line.text.find(mention) != std::string::npos;
            EXPECT_TRUE(found) << function << ": " << log_.all();
            log_.clear();
        };
        OptixOpacityMicromapArrayBuildInput input = array_.input;
        input.flags = OptixOpacityMicromapFlags(OPTIX_OPACITY_MICROMAP_FLAG_PREFER_FAST_TRACE |
                                                OPTIX_OPACITY_MICROMAP_FLAG_PREFER_FAST_BUILD);
        OptixMicromapBufferSizes sizes{};
        tolerated(kArrayUsage, "flags = 3",
                  optixOpacityMicromapArrayComputeMemoryUsage(context_, &input, &sizes));
        tolerated(kArrayBuild, "flags = 3",
                  optixOpacityMicromapArrayBuild(context_, nullptr, &input, &array_.buffers));
        OptixBuildInput linear = mesh_->input;
        useLinear(linear, array_);
        linear.triangleArray.opacityMicromap.indexBuffer = indices.address();
        tolerated(kBuild, "indexBuffer is set", build(linear));
        EXPECT_EQ(validation, handle_ == kNoHandle);
    }
}

TEST_F(MicromapArguments, SizesNeedNoBuffersAndGrow) {
    OptixOpacityMicromapHistogramEntry entries[2] = {{0, 0, OPTIX_OPACITY_MICROMAP_FORMAT_2_STATE},
                                                     {3, 4, OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE}};
    OptixOpacityMicromapArrayBuildInput input{};
    input.numMicromapHistogramEntries = 2;
    input.micromapHistogramEntries = entries;
    size_t before = 0;
    for (unsigned level = 0; level <= OPTIX_OPACITY_MICROMAP_MAX_SUBDIVISION_LEVEL; ++level) {
        entries[0] = {100, level, OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE};
        OptixMicromapBufferSizes sizes{};
        EXPECT_OK(optixOpacityMicromapArrayComputeMemoryUsage(context_, &input, &sizes));
        EXPECT_GE(sizes.outputSizeInBytes, before);
        EXPECT_GE(sizes.outputSizeInBytes, 100 * (size_t(2) << 2 * level) / 8);
        EXPECT_EQ(sizes.outputSizeInBytes % 128, 0u);
        before = sizes.outputSizeInBytes;
    }
    input.numMicromapHistogramEntries = 0;
    OptixMicromapBufferSizes sizes{};
    EXPECT_OK(optixOpacityMicromapArrayComputeMemoryUsage(context_, &input, &sizes));
    Buffer output(sizes.outputSizeInBytes), temp(sizes.tempSizeInBytes);
    const OptixMicromapBuffers buffers{output.address(), output.size(), temp.address(),
                                       temp.size()};
    EXPECT_OK(optixOpacityMicromapArrayBuild(context_, nullptr, &input, &buffers));
    waitForDevice(); // the buffers end here
}

// Errors in the contents of buffers are detected in stream order.
TEST_F(MicromapArguments, ContentsThatDoNotFitFailTheQueuedBuild) {
    const auto desc = [&](OptixOpacityMicromapDesc value) {
        Array bad;
        bad.descriptions.as<OptixOpacityMicromapDesc>()[3] = value;
        log_.clear();
        EXPECT_EQ(OPTIX_SUCCESS, bad.build(context_));
        EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, failureOfStream(context_));
        OptixRelocationInfo info;
        EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE,
                  optixOpacityMicromapArrayGetRelocationInfo(context_, bad.output.address(), &info))
            << "an array in spite of a broken description";
    };
    for (OptixOpacityMicromapDesc bad :
         {OptixOpacityMicromapDesc{0, 2, 1}, OptixOpacityMicromapDesc{0, 1, 2},
          OptixOpacityMicromapDesc{0, 65535, 65535}}) {
        desc(bad);
        EXPECT_TRUE(log_.hasError("micromap 3", "histogram")) << log_.all();
    }
    desc({0xFFFFFF00u, 1, 1});
    EXPECT_TRUE(log_.hasError("inputBuffer", "not device memory")) << log_.all();
}

TEST_F(MicromapArguments, OfBuildInputs) {
    using Micromap = OptixBuildInputOpacityMicromap;
    const Buffer indices(std::vector<int32_t>{0, 1});
    const auto indexed = [&](Micromap& m) {
        m.indexingMode = OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_INDEXED;
        m.indexBuffer = indices.address();
        m.indexSizeInBytes = 4;
    };
    expectBadInput("indexingMode",
                   [](Micromap& m) { m.indexingMode = OptixOpacityMicromapArrayIndexingMode(3); });
    expectBadInput("indexingMode",
                   [](Micromap& m) { m.indexingMode = OptixOpacityMicromapArrayIndexingMode(-1); });
    for (unsigned size : {0u, 1u, 3u, 8u})
        expectBadInput("indexSizeInBytes", [&](Micromap& m) {
            indexed(m);
            m.indexSizeInBytes = size;
        });
    for (unsigned stride : {2u, 6u})
        expectBadInput("indexStrideInBytes", [&](Micromap& m) {
            indexed(m);
            m.indexStrideInBytes = stride;
        });
    const OptixOpacityMicromapUsageCount counts[2] = {
        {1, 13, OPTIX_OPACITY_MICROMAP_FORMAT_2_STATE}, {1, 1, OptixOpacityMicromapFormat(7)}};
    expectBadInput("micromapUsageCounts is null",
                   [](Micromap& m) { m.numMicromapUsageCounts = 1; });
    expectBadInput("micromapUsageCounts[0].subdivisionLevel = 13", [&](Micromap& m) {
        m.numMicromapUsageCounts = 1;
        m.micromapUsageCounts = counts;
    });
    expectBadInput("micromapUsageCounts[0].format = 7", [&](Micromap& m) {
        m.numMicromapUsageCounts = 1;
        m.micromapUsageCounts = counts + 1;
    });
    expectBadInput(
        "opacityMicromapArray is 0", [](Micromap& m) { m.opacityMicromapArray = 0; }, true);
    expectBadInput(
        "opacityMicromapArray", [](Micromap& m) { m.opacityMicromapArray += 64; }, true);
    expectBadInput(
        "opacityMicromapArray", [](Micromap& m) { m.opacityMicromapArray = 0x4141414141414100; },
        true);
    expectBadInput(
        "opacityMicromapArray is set",
        [](Micromap& m) { m.indexingMode = OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_NONE; },
        true);
    expectBadInput(
        "indexBuffer",
        [&](Micromap& m) {
            indexed(m);
            m.indexBuffer = 0;
        },
        true);
    expectBadInput(
        "indexBuffer",
        [&](Micromap& m) {
            indexed(m);
            m.indexBuffer += 2;
        },
        true);
    expectBadInput(
        "indexBuffer",
        [&](Micromap& m) {
            indexed(m);
            m.indexBuffer = 0x4141414141414140;
        },
        true);
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kBuild, "buildFlags", build(mesh_->input, 1u << 8));
    const OptixBuildInput& plain = mesh_->input;
    EXPECT_OK(build(plain, OPTIX_BUILD_FLAG_ALLOW_OPACITY_MICROMAP_UPDATE |
                               OPTIX_BUILD_FLAG_ALLOW_DISABLE_OPACITY_MICROMAPS));
    waitForDevice();
}

// Memory without an array, or whose array was overwritten, is an error of the queued build.
TEST_F(MicromapArguments, ArraysThatAreNoneFailTheQueuedBuild) {
    OptixBuildInput input = mesh_->input;
    useLinear(input, array_);
    array_.output.fill(0);
    EXPECT_OK(build(input));
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, failureOfStream(context_));
    EXPECT_TRUE(log_.hasError("no opacity micromap array", "build input 0")) << log_.all();
}

TEST_F(MicromapArguments, ContextsThatAreNone) {
    std::vector<void*> handles = garbageHandles();
    handles.push_back(nullptr);
    for (void* handle : handles) {
        const auto bad = static_cast<OptixDeviceContext>(handle);
        constexpr OptixResult kRefused = OPTIX_ERROR_INVALID_DEVICE_CONTEXT;
        const CUdeviceptr array = array_.output.address();
        OptixMicromapBufferSizes sizes{};
        OptixRelocationInfo info{};
        int fits = 7;
        OptixTraversableHandle traversable = kNoHandle;
        EXPECT_EQ(kRefused,
                  optixOpacityMicromapArrayComputeMemoryUsage(bad, &array_.input, &sizes));
        EXPECT_EQ(kRefused, optixOpacityMicromapArrayBuild(bad, nullptr, &array_.input,
                                                           &array_.buffers));
        EXPECT_EQ(kRefused, optixOpacityMicromapArrayGetRelocationInfo(bad, array, &info));
        EXPECT_EQ(kRefused, optixOpacityMicromapArrayRelocate(bad, nullptr, &info, array,
                                                              array_.output.size()));
        EXPECT_EQ(kRefused, optixCheckRelocationCompatibility(bad, &info, &fits));
        EXPECT_EQ(kRefused, optixAccelRelocate(bad, nullptr, &info, nullptr, 0, array,
                                               array_.output.size(), &traversable));
        EXPECT_EQ(7, fits);
        EXPECT_EQ(kNoHandle, traversable);
    }
}

TEST_F(MicromapArguments, OfRelocations) {
    OptixRelocationInfo info{};
    const CUdeviceptr array = array_.output.address();
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kArrayInfo, "info is null",
                    optixOpacityMicromapArrayGetRelocationInfo(context_, array, nullptr));
    for (CUdeviceptr bad : {CUdeviceptr(0), array + 128, CUdeviceptr(0x4141414141414100), array + 1,
                            CUdeviceptr(-128)})
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kArrayInfo, "opacityMicromapArray",
                        optixOpacityMicromapArrayGetRelocationInfo(context_, bad, &info));
    ASSERT_OK(optixOpacityMicromapArrayGetRelocationInfo(context_, array, &info));
    int compatible = 0;
    EXPECT_OK(optixCheckRelocationCompatibility(context_, &info, &compatible));
    EXPECT_EQ(compatible, 1);

    const size_t size = array_.output.size();
    const auto relocate = [&](const OptixRelocationInfo* i, CUdeviceptr target, size_t bytes) {
        return optixOpacityMicromapArrayRelocate(context_, nullptr, i, target, bytes);
    };
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kArrayRelocate, "info is null",
                    relocate(nullptr, array, size));
    OptixRelocationInfo broken = info;
    broken.info[2] += 128;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kArrayRelocate, "info",
                    relocate(&broken, array, size));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kArrayRelocate, "SizeInBytes",
                    relocate(&info, array, size - 1));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kArrayRelocate, "targetOpacityMicromapArray",
                    relocate(&info, array + 64, size));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kArrayRelocate, "targetOpacityMicromapArray",
                    relocate(&info, 0, size));
    log_.clear();

    // The relocation infos of arrays and of structures are not interchangeable.
    OptixBuildInput input = mesh_->input;
    useLinear(input, array_);
    const Accel gas = buildAccel(context_, log_, {input});
    OptixRelocationInfo gasInfo{};
    ASSERT_OK(optixAccelGetRelocationInfo(context_, gas.handle, &gasInfo));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kArrayRelocate, "info",
                    relocate(&gasInfo, array, size));
    OptixTraversableHandle handle = kNoHandle;
    const auto relocateGas = [&](const OptixRelocationInfo& i, const OptixRelocateInput* inputs,
                                 size_t count) {
        return optixAccelRelocate(context_, nullptr, &i, inputs, count, gas.memory.address(),
                                  gas.memory.size(), &handle);
    };
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kRelocate, "info", relocateGas(info, nullptr, 0));
    OptixRelocateInput inputs[2] = {};
    for (OptixRelocateInput& r : inputs) {
        r.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
        r.triangleArray.numSbtRecords = 1;
    }
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kRelocate, "numRelocateInputs",
                    relocateGas(gasInfo, inputs, 2));
    inputs[0].triangleArray.opacityMicromap.opacityMicromapArray = array + 64;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kRelocate, "relocateInputs[0]",
                    relocateGas(gasInfo, inputs, 1));
    inputs[0].triangleArray.opacityMicromap.opacityMicromapArray = 0x4141414141414100;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kRelocate, "relocateInputs[0]",
                    relocateGas(gasInfo, inputs, 1));
    EXPECT_EQ(handle, kNoHandle);
    // Of another size: detected when the stream reaches it.
    Array small(2);
    ASSERT_OK(small.build(context_));
    inputs[0].triangleArray.opacityMicromap.opacityMicromapArray = small.output.address();
    EXPECT_OK(relocateGas(gasInfo, inputs, 1));
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, failureOfStream(context_));
    EXPECT_TRUE(log_.hasError("no copy", "build input 0")) << log_.all();
}

// ---- hits of rays ----

class MicromapTraversal : public DeviceTest {
protected:
    void makeRig(bool allow = true) {
        OptixPipelineCompileOptions options = compileOptions(4);
        options.allowOpacityMicromaps = allow;
        options.usesMotionBlur = 1;
        rig_ = rig("probe", options);
        rig_->raygenRecord(rig_->raygen("__raygen__probe"));
        rig_->missRecord(rig_->miss("__miss__probe"), ProbeData{1, 0, nullptr, 0, 0});
        rig_->hitRecord(rig_->hit("__closesthit__probe", "__anyhit__probe"),
                        ProbeData{1000, kProbeAccept, nullptr, 0, 0});
        rig_->link();
    }

    // The number in the micromap of each triangle of a row, found by rays; -1 if any-hit ran.
    std::vector<int> numbers(OptixTraversableHandle handle, unsigned count) {
        return numbersAt(handle, count, 0, 0);
    }
    // As numbers(), at a time at which the row is `y` higher.
    std::vector<int> numbersAt(OptixTraversableHandle handle, unsigned count, float time, float y) {
        const float inside[4][2] = {{0.1f, 0.1f}, {0.3f, 0.3f}, {0.8f, 0.1f}, {0.1f, 0.8f}};
        std::vector<ProbeRay> rays;
        for (unsigned i = 0; i < 4 * count; ++i) {
            ProbeRay ray{};
            ray.origin[0] = inside[i % 4][0] + 2.0f * float(i / 4);
            ray.origin[1] = inside[i % 4][1] + y;
            ray.time = time;
            ray.origin[2] = 1;
            ray.direction[2] = -1;
            ray.tmax = 1e16f;
            ray.mask = 255;
            ray.sbtStride = 1;
            ray.handle = handle;
            rays.push_back(ray);
        }
        const Buffer rayMemory(rays), results(rays.size() * sizeof(ProbeResult));
        rig_->run(ProbeParams{rayMemory.as<const ProbeRay>(), results.as<ProbeResult>()},
                  unsigned(rays.size()));
        std::vector<int> found;
        for (unsigned i = 0; i < count; ++i) {
            int number = 0;
            for (unsigned k = 0; k < 4; ++k) {
                const ProbeResult& r = results.as<const ProbeResult>()[4 * i + k];
                EXPECT_EQ(r.closestHits + r.misses, 1u);
                if (r.closestHits)
                    number |= 1 << k;
                if (r.anyHits)
                    number = -16;
                if (r.closestHits && r.closestHit.primitive != i)
                    ADD_FAILURE() << "triangle " << i << " hit as " << r.closestHit.primitive;
            }
            found.push_back(number < 0 ? -1 : number);
        }
        return found;
    }

    std::unique_ptr<Rig> rig_;
};

using Numbers = std::vector<int>;

TEST_P(MicromapTraversal, PipelinesWithoutTheOptionDoNotLook) {
    Array array;
    ASSERT_OK(array.build(context_));
    const auto mesh = row(4);
    OptixBuildInput input = mesh->input;
    useLinear(input, array);
    const Accel gas = buildAccel(context_, log_, {input});
    makeRig(false);
    EXPECT_EQ(numbers(gas.handle, 4), (Numbers{-1, -1, -1, -1}));
    makeRig(true);
    EXPECT_EQ(numbers(gas.handle, 4), (Numbers{0, 1, 2, 3}));
}

// After the inputs of an array are freed, the array is moved, and the structure is compacted,
// updated and moved, its vertices can still be queried.
TEST_P(MicromapTraversal, SurvivesEverythingThatCanBeDone) {
    makeRig();
    auto first = std::make_unique<Array>();
    ASSERT_OK(first->build(context_));
    first->states = Buffer();
    first->descriptions = Buffer();
    first->temp = Buffer();
    const auto mesh = row(6);
    auto indices = std::make_unique<Buffer>(std::vector<int32_t>{5, 4, -1, -2, 15, 7});
    OptixBuildInput input = mesh->input;
    useIndices(input, *first, *indices);
    const unsigned flags = OPTIX_BUILD_FLAG_ALLOW_UPDATE | OPTIX_BUILD_FLAG_ALLOW_COMPACTION |
                           OPTIX_BUILD_FLAG_ALLOW_OPACITY_MICROMAP_UPDATE |
                           OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS;
    const Buffer compactedSize(8);
    const Accel built = buildAccel(context_, log_, {input}, flags,
                                   {{compactedSize.address(), OPTIX_PROPERTY_TYPE_COMPACTED_SIZE}});
    indices.reset();
    EXPECT_EQ(numbers(built.handle, 6), (Numbers{5, 4, 0, 15, 15, 7}));

    // Compaction.
    const Buffer compacted(*compactedSize.as<uint64_t>());
    OptixTraversableHandle handle = 0;
    ASSERT_OK(optixAccelCompact(context_, nullptr, built.handle, compacted.address(),
                                compacted.size(), &handle));
    waitForDevice();
    built.memory.fill(0xEE);
    EXPECT_EQ(numbers(handle, 6), (Numbers{5, 4, 0, 15, 15, 7}));

    // Other indices by an update of the compacted structure.
    const Buffer others(std::vector<int32_t>{1, 2, 3, 4, -2, -1});
    useIndices(input, *first, others);
    OptixAccelBuildOptions options = buildOptions(flags);
    options.operation = OPTIX_BUILD_OPERATION_UPDATE;
    const Buffer temp(1024);
    OptixTraversableHandle updated = 0;
    ASSERT_OK(optixAccelBuild(context_, nullptr, &options, &input, 1, temp.address(), temp.size(),
                              compacted.address(), compacted.size(), &updated, nullptr, 0));
    EXPECT_EQ(updated, handle);
    EXPECT_EQ(numbers(handle, 6), (Numbers{1, 2, 3, 4, 15, 0}));

    // Both move; the old array is freed.
    OptixRelocationInfo arrayInfo{}, gasInfo{};
    ASSERT_OK(
        optixOpacityMicromapArrayGetRelocationInfo(context_, first->output.address(), &arrayInfo));
    ASSERT_OK(optixAccelGetRelocationInfo(context_, handle, &gasInfo));
    const Buffer movedArray(first->output.size()), moved(compacted.size());
    std::memcpy(movedArray.as<void>(), first->output.as<void>(), movedArray.size());
    std::memcpy(moved.as<void>(), compacted.as<void>(), moved.size());
    first.reset();
    compacted.fill(0xEE);
    ASSERT_OK(optixOpacityMicromapArrayRelocate(context_, nullptr, &arrayInfo, movedArray.address(),
                                                movedArray.size()));
    OptixRelocateInput relocated{};
    relocated.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    relocated.triangleArray.numSbtRecords = 1;
    relocated.triangleArray.opacityMicromap.opacityMicromapArray = movedArray.address();
    ASSERT_OK(optixAccelRelocate(context_, nullptr, &gasInfo, &relocated, 1, moved.address(),
                                 moved.size(), &handle));
    EXPECT_EQ(numbers(handle, 6), (Numbers{1, 2, 3, 4, 15, 0}));

    // No replacement: the references stay.
    relocated.triangleArray.opacityMicromap.opacityMicromapArray = 0;
    ASSERT_OK(optixAccelRelocate(context_, nullptr, &gasInfo, &relocated, 1, moved.address(),
                                 moved.size(), &handle));
    ASSERT_OK(optixAccelRelocate(context_, nullptr, &gasInfo, nullptr, 0, moved.address(),
                                 moved.size(), &handle));
    EXPECT_EQ(numbers(handle, 6), (Numbers{1, 2, 3, 4, 15, 0}));
}

// Triangles with motion keys have micromaps too: a row that moves up, through compaction, an update
// that turns the motion round and changes the micromaps, and relocation.
TEST_P(MicromapTraversal, MovesWithTheTriangles) {
    makeRig();
    Array array;
    ASSERT_OK(array.build(context_));
    const auto mesh = row(6), above = row(6);
    for (size_t i = 0; i < above->points.size(); ++i)
        above->vertices.as<Vec3>()[i].y += 4;
    CUdeviceptr keys[2] = {mesh->vertexAddress, above->vertexAddress};
    const Buffer indices(std::vector<int32_t>{5, 4, -1, -2, 15, 7});
    OptixBuildInput input = mesh->input;
    input.triangleArray.vertexBuffers = keys;
    useIndices(input, array, indices);
    const unsigned flags = OPTIX_BUILD_FLAG_ALLOW_UPDATE | OPTIX_BUILD_FLAG_ALLOW_COMPACTION |
                           OPTIX_BUILD_FLAG_ALLOW_OPACITY_MICROMAP_UPDATE;
    OptixAccelBuildOptions options = buildOptions(flags);
    options.motionOptions = {2, 0, 0, 1};
    OptixAccelBufferSizes sizes{};
    ASSERT_OK(optixAccelComputeMemoryUsage(context_, &options, &input, 1, &sizes));
    const Buffer temp(sizes.tempSizeInBytes), output(sizes.outputSizeInBytes), compactedSize(8);
    const OptixAccelEmitDesc emit{compactedSize.address(), OPTIX_PROPERTY_TYPE_COMPACTED_SIZE};
    OptixTraversableHandle handle = 0;
    ASSERT_OK(optixAccelBuild(context_, nullptr, &options, &input, 1, temp.address(), temp.size(),
                              output.address(), output.size(), &handle, &emit, 1));
    waitForDevice();
    const auto expect = [&](const Numbers& numbers, float begin, float end) {
        for (float time : {0.0f, 0.25f, 0.7f, 1.0f})
            EXPECT_EQ(numbersAt(handle, 6, time, begin + (end - begin) * time), numbers)
                << "time " << time;
        EXPECT_EQ(numbersAt(handle, 6, 0.5f, begin), Numbers(6)); // freed at its old place
    };
    expect({5, 4, 0, 15, 15, 7}, 0, 4);

    const Buffer compacted(*compactedSize.as<uint64_t>());
    ASSERT_OK(optixAccelCompact(context_, nullptr, handle, compacted.address(), compacted.size(),
                                &handle));
    waitForDevice();
    output.fill(0xEE);
    expect({5, 4, 0, 15, 15, 7}, 0, 4);

    std::swap(keys[0], keys[1]);
    const Buffer others(std::vector<int32_t>{1, 2, 3, 4, -2, -1});
    useIndices(input, array, others);
    options.operation = OPTIX_BUILD_OPERATION_UPDATE;
    ASSERT_OK(optixAccelBuild(context_, nullptr, &options, &input, 1, temp.address(), temp.size(),
                              compacted.address(), compacted.size(), &handle, nullptr, 0));
    expect({1, 2, 3, 4, 15, 0}, 4, 0);

    OptixRelocationInfo info{};
    ASSERT_OK(optixAccelGetRelocationInfo(context_, handle, &info));
    Array other;
    ASSERT_OK(other.build(context_));
    const Buffer moved(compacted.size());
    std::memcpy(moved.as<void>(), compacted.as<void>(), moved.size());
    compacted.fill(0xEE);
    array.output.fill(0xEE);
    OptixRelocateInput relocated{};
    relocated.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    relocated.triangleArray.numSbtRecords = 1;
    relocated.triangleArray.opacityMicromap.opacityMicromapArray = other.output.address();
    ASSERT_OK(optixAccelRelocate(context_, nullptr, &info, &relocated, 1, moved.address(),
                                 moved.size(), &handle));
    expect({1, 2, 3, 4, 15, 0}, 4, 0);
}

// Without the flag an update keeps the micromaps, and logs that if others are given.
TEST_P(MicromapTraversal, UpdatesChangeMicromapsOnlyIfAllowed) {
    makeRig();
    Array first, second;
    ASSERT_OK(first.build(context_));
    ASSERT_OK(second.build(context_));
    const auto mesh = row(2);
    OptixBuildInput input = mesh->input;
    useLinear(input, first);
    const Accel gas = buildAccel(context_, log_, {input}, OPTIX_BUILD_FLAG_ALLOW_UPDATE);
    OptixAccelBuildOptions options = buildOptions(OPTIX_BUILD_FLAG_ALLOW_UPDATE);
    options.operation = OPTIX_BUILD_OPERATION_UPDATE;
    const Buffer temp(1024);
    OptixTraversableHandle handle = gas.handle;
    const auto update = [&] {
        return optixAccelBuild(context_, nullptr, &options, &input, 1, temp.address(), temp.size(),
                               gas.memory.address(), gas.memory.size(), &handle, nullptr, 0);
    };
    EXPECT_OK(update());
    EXPECT_EQ(numbers(gas.handle, 2), (Numbers{0, 1}));
    useLinear(input, second);
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kBuild, "ALLOW_OPACITY_MICROMAP_UPDATE", update());
    input.triangleArray.opacityMicromap = {};
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kBuild, "indexing mode", update());
    log_.clear();
    EXPECT_EQ(numbers(gas.handle, 2), (Numbers{0, 1}));
}

// Instance flags decide whether and how micromaps apply; -1 if any-hit ran.
TEST_P(MicromapTraversal, InstancesHaveFlagsForThem) {
    makeRig();
    Array array;
    ASSERT_OK(array.build(context_));
    const auto mesh = row(4);
    const Buffer indices(
        std::vector<int32_t>{OPTIX_OPACITY_MICROMAP_PREDEFINED_INDEX_FULLY_TRANSPARENT,
                             OPTIX_OPACITY_MICROMAP_PREDEFINED_INDEX_FULLY_OPAQUE,
                             OPTIX_OPACITY_MICROMAP_PREDEFINED_INDEX_FULLY_UNKNOWN_TRANSPARENT,
                             OPTIX_OPACITY_MICROMAP_PREDEFINED_INDEX_FULLY_UNKNOWN_OPAQUE});
    OptixBuildInput input = mesh->input;
    useIndices(input, array, indices);
    const Accel gas =
        buildAccel(context_, log_, {input}, OPTIX_BUILD_FLAG_ALLOW_DISABLE_OPACITY_MICROMAPS);
    const auto with = [&](unsigned flags) {
        const InstanceList list({instanceOf(gas.handle, identity(), 0, 0, 255, flags)});
        const Accel ias = buildAccel(context_, log_, {list.input});
        return numbers(ias.handle, 4);
    };
    EXPECT_EQ(with(OPTIX_INSTANCE_FLAG_NONE), (Numbers{0, 15, -1, -1}));
    EXPECT_EQ(with(OPTIX_INSTANCE_FLAG_FORCE_OPACITY_MICROMAP_2_STATE), (Numbers{0, 15, 0, 15}));
    EXPECT_EQ(with(OPTIX_INSTANCE_FLAG_DISABLE_OPACITY_MICROMAPS), (Numbers{-1, -1, -1, -1}));
    EXPECT_EQ(with(OPTIX_INSTANCE_FLAG_DISABLE_ANYHIT), (Numbers{0, 15, 15, 15}));
}

// Several build inputs, some of them with micromaps, each with a separate array.
TEST_P(MicromapTraversal, BuildInputsHaveTheirOwn) {
    makeRig();
    Array first, second;
    for (unsigned i = 0; i < 16; ++i)
        second.states.as<unsigned char>()[i] = (unsigned char)(15 - i);
    ASSERT_OK(first.build(context_));
    ASSERT_OK(second.build(context_));
    const auto mesh = row(6);
    std::vector<OptixBuildInput> inputs(3, mesh->input);
    for (unsigned i = 0; i < 3; ++i) {
        inputs[i].triangleArray.numIndexTriplets = 2;
        inputs[i].triangleArray.indexBuffer += i * 24;
        inputs[i].triangleArray.primitiveIndexOffset = 2 * i;
    }
    useLinear(inputs[0], first);
    inputs[0].triangleArray.opacityMicromap.indexOffset = 8;
    useLinear(inputs[2], second);
    Rig& rig = *rig_;
    for (int i = 0; i < 2; ++i) // a record for each build input
        rig.hitRecord(2, ProbeData{1000, kProbeAccept, nullptr, 0, 0});
    const Accel gas = buildAccel(context_, log_, inputs);
    EXPECT_EQ(numbers(gas.handle, 6), (Numbers{8, 9, -1, -1, 15, 14}));
}

INSTANTIATE_DEVICE_TEST(MicromapTraversal);

} // namespace
} // namespace tests::api
