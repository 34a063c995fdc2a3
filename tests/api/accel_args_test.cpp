// SPDX-License-Identifier: Apache-2.0
// Arguments of optixAccelComputeMemoryUsage, -Build and -Compact (OptiX 7.4, sections 3.10, 5.2 to
// 5.10): violates every rule about them, one at a time.
#include "device_memory.h"
#include "rig.h"
#include "scene.h"

#include <functional>
#include <sys/mman.h>

namespace tests::api {
namespace {

constexpr const char* kUsage = "optixAccelComputeMemoryUsage";
constexpr const char* kBuild = "optixAccelBuild";
constexpr const char* kCompact = "optixAccelCompact";

class AccelArguments : public ApiTest {
protected:
    void SetUp() override {
        ApiTest::SetUp();
        mesh_ = std::make_unique<TriangleMesh>(
            std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}},
            std::vector<uint32_t>{0, 1, 2, 2, 1, 3});
        boxes_ = std::make_unique<CustomBoxes>(
            std::vector<OptixAabb>{{0, 0, 0, 1, 1, 1}, {2, 2, 2, 3, 3, 3}});
        gas_ = buildAccel(context_, log_, {mesh_->input});
        instances_ = std::make_unique<InstanceList>(
            std::vector<OptixInstance>{instanceOf(gas_.handle, identity())});
    }

    OptixResult usage(const OptixBuildInput& input, unsigned flags = 0) {
        OptixAccelBuildOptions options = buildOptions(flags);
        return optixAccelComputeMemoryUsage(context_, &options, &input, 1, &sizes_);
    }
    OptixResult build(const OptixBuildInput& input, unsigned flags = 0) {
        OptixAccelBuildOptions options = buildOptions(flags);
        temp_ = Buffer(1 << 16);
        output_ = Buffer(1 << 16);
        handle_ = kNoHandle;
        return optixAccelBuild(context_, nullptr, &options, &input, 1, temp_.address(), temp_.size(),
                               output_.address(), output_.size(), &handle_, nullptr, 0);
    }

    // expectBad: a change of a build input that both functions must refuse; the second form: a
    // change of buffers, which only the build checks.
    void expectBad(const OptixBuildInput& good, const char* mention,
                   const std::function<void(OptixBuildInput&)>& change) {
        OptixBuildInput input = good;
        change(input);
        OptixAccelBufferSizes before = sizes_;
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kUsage, mention, usage(input));
        EXPECT_EQ(0, std::memcmp(&before, &sizes_, sizeof(before)));
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kBuild, mention, build(input));
        EXPECT_EQ(kNoHandle, handle_);
    }
    void expectBadBuffer(const OptixBuildInput& good, const char* mention,
                         const std::function<void(OptixBuildInput&)>& change) {
        OptixBuildInput input = good;
        change(input);
        EXPECT_OK(usage(input)) << "sizes do not depend on buffers";
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kBuild, mention, build(input));
        EXPECT_EQ(kNoHandle, handle_);
    }
    void expectGood(const OptixBuildInput& good,
                    const std::function<void(OptixBuildInput&)>& change) {
        OptixBuildInput input = good;
        change(input);
        log_.clear();
        EXPECT_OK(usage(input));
        EXPECT_OK(build(input));
        waitForDevice();
        EXPECT_NE(kNoHandle, handle_);
        EXPECT_FALSE(log_.hasError("", "")) << log_.all();
    }

    static constexpr OptixTraversableHandle kNoHandle = 0x1111;
    std::unique_ptr<TriangleMesh> mesh_;
    std::unique_ptr<CustomBoxes> boxes_;
    std::unique_ptr<InstanceList> instances_;
    Accel gas_;
    OptixAccelBufferSizes sizes_{1, 2, 3};
    Buffer temp_, output_;
    OptixTraversableHandle handle_ = 0;
};

using Input = OptixBuildInput;

TEST_F(AccelArguments, GoodInputs) {
    expectGood(mesh_->input, [](Input&) {});
    expectGood(boxes_->input, [](Input&) {});
    expectGood(instances_->input, [](Input&) {});
}

TEST_F(AccelArguments, NullPointers) {
    OptixAccelBuildOptions options = buildOptions();
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kUsage, "accelOptions",
                    optixAccelComputeMemoryUsage(context_, nullptr, &mesh_->input, 1, &sizes_));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kUsage, "buildInputs",
                    optixAccelComputeMemoryUsage(context_, &options, nullptr, 1, &sizes_));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kUsage, "bufferSizes",
                    optixAccelComputeMemoryUsage(context_, &options, &mesh_->input, 1, nullptr));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kUsage, "numBuildInputs",
                    optixAccelComputeMemoryUsage(context_, &options, &mesh_->input, 0, &sizes_));
    Buffer temp(1 << 16), output(1 << 16);
    auto buildWith = [&](const OptixAccelBuildOptions* o, const OptixBuildInput* inputs,
                         unsigned count, OptixTraversableHandle* handle) {
        return optixAccelBuild(context_, nullptr, o, inputs, count, temp.address(), temp.size(),
                               output.address(), output.size(), handle, nullptr, 0);
    };
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kBuild, "accelOptions",
                    buildWith(nullptr, &mesh_->input, 1, &handle_));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kBuild, "buildInputs",
                    buildWith(&options, nullptr, 1, &handle_));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kBuild, "numBuildInputs",
                    buildWith(&options, &mesh_->input, 0, &handle_));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kBuild, "outputHandle",
                    buildWith(&options, &mesh_->input, 1, nullptr));
}

TEST_F(AccelArguments, BuildFlags) {
    for (unsigned flags : {0u, 1u, 2u, 4u, 8u, 16u, 32u, 55u, 59u}) {
        EXPECT_OK(usage(mesh_->input, flags)) << flags;
        EXPECT_OK(build(mesh_->input, flags)) << flags;
        waitForDevice();
    }
    for (unsigned flags : {64u, 128u, 0x80000000u, ~0u}) {
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kUsage, "buildFlags",
                        usage(mesh_->input, flags));
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kBuild, "buildFlags",
                        build(mesh_->input, flags));
    }
}

TEST_F(AccelArguments, OperationsAndMotion) {
    OptixAccelBuildOptions options = buildOptions();
    for (unsigned operation : {0u, 1u, 0x2160u, 0x2163u, ~0u}) {
        std::memcpy(&options.operation, &operation, sizeof(operation));
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kUsage, "operation",
                        optixAccelComputeMemoryUsage(context_, &options, &mesh_->input, 1, &sizes_));
    }
    options = buildOptions();
    for (unsigned short keys : {0, 1}) { // the rest is ignored without motion
        options.motionOptions = {keys, 0xFFFF, 5.0f, -5.0f};
        EXPECT_OK(optixAccelComputeMemoryUsage(context_, &options, &mesh_->input, 1, &sizes_));
    }
    options = buildOptions(OPTIX_BUILD_FLAG_ALLOW_UPDATE);
    options.operation = OPTIX_BUILD_OPERATION_UPDATE;
    Buffer temp(1 << 16), output(1 << 16);
    log_.clear();
    EXPECT_NE(OPTIX_SUCCESS,
              optixAccelBuild(context_, nullptr, &options, &mesh_->input, 1, temp.address(),
                              temp.size(), output.address(), output.size(), &handle_, nullptr, 0))
        << "there is nothing to update";
    EXPECT_TRUE(log_.hasError(kBuild, "update") || log_.hasError(kBuild, "UPDATE")) << log_.all();
}

TEST_F(AccelArguments, InputTypes) {
    for (unsigned type : {0u, 0x2140u, 0x2146u, 0x21C1u, ~0u})
        expectBad(mesh_->input, "type",
                  [&](Input& i) { std::memcpy(&i.type, &type, sizeof(type)); });
    OptixAccelBuildOptions options = buildOptions();
    OptixBuildInput mixed[] = {mesh_->input, boxes_->input};
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kUsage, "buildInputs[1]",
                    optixAccelComputeMemoryUsage(context_, &options, mixed, 2, &sizes_));
    OptixBuildInput two[] = {instances_->input, instances_->input};
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kUsage, "numBuildInputs",
                    optixAccelComputeMemoryUsage(context_, &options, two, 2, &sizes_));
}

// ---- Triangles -----------------------------------------------------------------------------------

TEST_F(AccelArguments, VertexFormats) {
    for (unsigned format : {0x2121u, 0x2122u, 0x2123u, 0x2124u, 0x2125u, 0x2126u})
        expectGood(mesh_->input, [&](Input& i) {
            i.triangleArray.vertexFormat = OptixVertexFormat(format);
        });
    for (unsigned format : {0u, 1u, 0x2120u, 0x2127u, ~0u})
        expectBad(mesh_->input, "vertexFormat", [&](Input& i) {
            std::memcpy(&i.triangleArray.vertexFormat, &format, sizeof(format));
        });
}

TEST_F(AccelArguments, VertexStrides) {
    for (unsigned stride : {0u, 12u})
        expectGood(mesh_->input,
                   [&](Input& i) { i.triangleArray.vertexStrideInBytes = stride; });
    for (unsigned stride : {1u, 4u, 8u, 11u, 13u, 14u, 15u, 0xFFFFFFFFu})
        expectBad(mesh_->input, "vertexStrideInBytes",
                  [&](Input& i) { i.triangleArray.vertexStrideInBytes = stride; });
    for (unsigned stride : {5u, 7u})
        expectBad(mesh_->input, "vertexStrideInBytes", [&](Input& i) {
            i.triangleArray.vertexFormat = OPTIX_VERTEX_FORMAT_HALF2;
            i.triangleArray.vertexStrideInBytes = stride;
        });
    expectGood(mesh_->input, [](Input& i) {
        i.triangleArray.vertexFormat = OPTIX_VERTEX_FORMAT_SNORM16_3;
        i.triangleArray.vertexStrideInBytes = 10;
    });
}

TEST_F(AccelArguments, VertexBuffers) {
    expectBadBuffer(mesh_->input, "vertexBuffers",
                    [](Input& i) { i.triangleArray.vertexBuffers = nullptr; });
    CUdeviceptr null = 0, odd = mesh_->vertexAddress + 2, odder = mesh_->vertexAddress + 1;
    expectBadBuffer(mesh_->input, "vertexBuffers",
                    [&](Input& i) { i.triangleArray.vertexBuffers = &null; });
    expectBadBuffer(mesh_->input, "vertexBuffers",
                    [&](Input& i) { i.triangleArray.vertexBuffers = &odd; });
    expectGood(mesh_->input, [&](Input& i) {
        i.triangleArray.vertexFormat = OPTIX_VERTEX_FORMAT_HALF3; // 2-byte alignment will do
        i.triangleArray.vertexBuffers = &odd;
    });
    expectBadBuffer(mesh_->input, "vertexBuffers", [&](Input& i) {
        i.triangleArray.vertexFormat = OPTIX_VERTEX_FORMAT_HALF3;
        i.triangleArray.vertexBuffers = &odder;
    });
    CUdeviceptr wild = 0x40; // no memory there
    expectBadBuffer(mesh_->input, "vertexBuffers",
                    [&](Input& i) { i.triangleArray.vertexBuffers = &wild; });
}

TEST_F(AccelArguments, Indices) {
    for (unsigned format : {1u, 0x2101u, 0x2104u, ~0u})
        expectBad(mesh_->input, "indexFormat", [&](Input& i) {
            std::memcpy(&i.triangleArray.indexFormat, &format, sizeof(format));
        });
    expectGood(mesh_->input, [](Input& i) {
        i.triangleArray.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_SHORT3;
    });
    for (unsigned stride : {1u, 4u, 11u, 13u, 14u})
        expectBad(mesh_->input, "indexStrideInBytes",
                  [&](Input& i) { i.triangleArray.indexStrideInBytes = stride; });
    expectBadBuffer(mesh_->input, "indexBuffer", [](Input& i) { i.triangleArray.indexBuffer = 0; });
    for (unsigned shift : {1u, 2u, 3u})
        expectBadBuffer(mesh_->input, "indexBuffer",
                        [&](Input& i) { i.triangleArray.indexBuffer += shift; });
    expectBadBuffer(mesh_->input, "indexBuffer", [](Input& i) {
        i.triangleArray.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_SHORT3;
        i.triangleArray.indexBuffer += 1;
    });
    // Without indices, buffer and count must be null and 0.
    auto soup = [](Input& i) {
        i.triangleArray.indexFormat = OPTIX_INDICES_FORMAT_NONE;
        i.triangleArray.indexBuffer = 0;
        i.triangleArray.numIndexTriplets = 0;
        i.triangleArray.numVertices = 3;
    };
    expectGood(mesh_->input, soup);
    expectBad(mesh_->input, "numIndexTriplets", [&](Input& i) {
        soup(i);
        i.triangleArray.numIndexTriplets = 1;
    });
    expectBadBuffer(mesh_->input, "indexBuffer", [&](Input& i) {
        soup(i);
        i.triangleArray.indexBuffer = 64;
    });
}

TEST_F(AccelArguments, PreTransform) {
    Buffer matrix(std::vector<float>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
    Buffer wide(64 + 48);
    auto set = [](Input& i, unsigned format, CUdeviceptr address) {
        std::memcpy(&i.triangleArray.transformFormat, &format, sizeof(format));
        i.triangleArray.preTransform = address;
    };
    expectGood(mesh_->input,
               [&](Input& i) { set(i, OPTIX_TRANSFORM_FORMAT_MATRIX_FLOAT12, matrix.address()); });
    for (unsigned format : {1u, 0x21E0u, 0x21E2u, ~0u})
        expectBad(mesh_->input, "transformFormat",
                  [&](Input& i) { set(i, format, matrix.address()); });
    expectBadBuffer(mesh_->input, "preTransform", [&](Input& i) {
        set(i, OPTIX_TRANSFORM_FORMAT_MATRIX_FLOAT12, 0);
    });
    expectBadBuffer(mesh_->input, "preTransform", [&](Input& i) {
        set(i, OPTIX_TRANSFORM_FORMAT_NONE, matrix.address());
    });
    for (unsigned shift : {1u, 4u, 8u})
        expectBadBuffer(mesh_->input, "preTransform", [&](Input& i) {
            set(i, OPTIX_TRANSFORM_FORMAT_MATRIX_FLOAT12, wide.address() + shift);
        });
}

// ---- Common to triangles and custom primitives --------------------------------------------------

// Both kinds of input have these members under the same names.
template <class Change>
void forBoth(const OptixBuildInput& triangles, const OptixBuildInput& customs, Change change) {
    change(triangles, [](Input& i) -> OptixBuildInputTriangleArray& { return i.triangleArray; });
    change(customs,
           [](Input& i) -> OptixBuildInputCustomPrimitiveArray& { return i.customPrimitiveArray; });
}

TEST_F(AccelArguments, SbtRecords) {
    forBoth(mesh_->input, boxes_->input, [&](const Input& good, auto array) {
        for (unsigned count : {0u, (1u << 24) + 1, ~0u})
            expectBad(good, "numSbtRecords", [&](Input& i) { array(i).numSbtRecords = count; });
        expectBad(good, "flags", [&](Input& i) { array(i).flags = nullptr; });
        std::vector<unsigned> flags(5, 0);
        expectGood(good, [&](Input& i) {
            array(i).flags = flags.data();
            array(i).numSbtRecords = 5;
        });
        flags = {0, 1, 2, 3, 0};
        expectGood(good, [&](Input& i) {
            array(i).flags = flags.data();
            array(i).numSbtRecords = 5;
        });
        for (unsigned bad : {4u, 8u, 0x80000000u}) {
            flags[4] = bad;
            expectBad(good, "flags[4]", [&](Input& i) {
                array(i).flags = flags.data();
                array(i).numSbtRecords = 5;
            });
        }
    });
}

TEST_F(AccelArguments, SbtIndexBuffers) {
    Buffer offsets(64);
    forBoth(mesh_->input, boxes_->input, [&](const Input& good, auto array) {
        for (unsigned size : {1u, 2u, 4u})
            for (unsigned stride : {0u, size, 2 * size, 8u})
                expectGood(good, [&](Input& i) {
                    array(i).sbtIndexOffsetBuffer = offsets.address();
                    array(i).sbtIndexOffsetSizeInBytes = size;
                    array(i).sbtIndexOffsetStrideInBytes = stride;
                });
        for (unsigned size : {3u, 5u, 8u, ~0u})
            expectBad(good, "sbtIndexOffsetSizeInBytes", [&](Input& i) {
                array(i).sbtIndexOffsetBuffer = offsets.address();
                array(i).sbtIndexOffsetSizeInBytes = size;
            });
        expectBadBuffer(good, "sbtIndexOffset", [&](Input& i) {
            array(i).sbtIndexOffsetBuffer = offsets.address();
            array(i).sbtIndexOffsetSizeInBytes = 0;
        });
        for (unsigned stride : {1u, 2u, 3u, 5u, 6u})
            expectBad(good, "sbtIndexOffsetStrideInBytes", [&](Input& i) {
                array(i).sbtIndexOffsetBuffer = offsets.address();
                array(i).sbtIndexOffsetSizeInBytes = 4;
                array(i).sbtIndexOffsetStrideInBytes = stride;
            });
        for (unsigned shift : {1u, 2u})
            expectBadBuffer(good, "sbtIndexOffsetBuffer", [&](Input& i) {
                array(i).sbtIndexOffsetBuffer = offsets.address() + shift;
                array(i).sbtIndexOffsetSizeInBytes = 4;
            });
    });
}

TEST_F(AccelArguments, PrimitiveIndexOffsets) {
    forBoth(mesh_->input, boxes_->input, [&](const Input& good, auto array) {
        expectGood(good, [&](Input& i) { array(i).primitiveIndexOffset = 0xFFFFFFFFu - 2; });
        for (unsigned offset : {0xFFFFFFFFu, 0xFFFFFFFEu})
            expectBad(good, "primitiveIndexOffset",
                      [&](Input& i) { array(i).primitiveIndexOffset = offset; });
    });
}

TEST_F(AccelArguments, TooManyPrimitives) {
    expectBad(mesh_->input, "buildInputs[0].numIndexTriplets = 536870913",
              [](Input& i) { i.triangleArray.numIndexTriplets = (1u << 29) + 1; });
    expectBad(boxes_->input, "buildInputs[0].numPrimitives = 4294967295",
              [](Input& i) { i.customPrimitiveArray.numPrimitives = ~0u; });
    expectBad(instances_->input, "numInstances",
              [](Input& i) { i.instanceArray.numInstances = (1u << 28) + 1; });
    // Together too many.
    OptixBuildInput inputs[] = {mesh_->input, mesh_->input};
    inputs[0].triangleArray.numIndexTriplets = 1u << 28;
    inputs[1].triangleArray.numIndexTriplets = (1u << 28) + 1;
    OptixAccelBuildOptions options = buildOptions();
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kUsage, "primitives",
                    optixAccelComputeMemoryUsage(context_, &options, inputs, 2, &sizes_));
}

// ---- Custom primitives and instances -------------------------------------------------------------

TEST_F(AccelArguments, Boxes) {
    for (unsigned stride : {1u, 4u, 8u, 16u, 25u, 28u, 0xFFFFFFFFu})
        expectBad(boxes_->input, "strideInBytes",
                  [&](Input& i) { i.customPrimitiveArray.strideInBytes = stride; });
    expectGood(boxes_->input, [](Input& i) { i.customPrimitiveArray.strideInBytes = 24; });
    expectGood(boxes_->input, [](Input& i) {
        i.customPrimitiveArray.strideInBytes = 32;
        i.customPrimitiveArray.numPrimitives = 1;
    });
    expectBadBuffer(boxes_->input, "aabbBuffers",
                    [](Input& i) { i.customPrimitiveArray.aabbBuffers = nullptr; });
    CUdeviceptr null = 0;
    expectBadBuffer(boxes_->input, "aabbBuffers",
                    [&](Input& i) { i.customPrimitiveArray.aabbBuffers = &null; });
    for (unsigned shift : {1u, 4u}) {
        CUdeviceptr odd = boxes_->address + shift;
        expectBadBuffer(boxes_->input, "aabbBuffers",
                        [&](Input& i) { i.customPrimitiveArray.aabbBuffers = &odd; });
    }
}

TEST_F(AccelArguments, InstanceBuffers) {
    expectBadBuffer(instances_->input, "instances",
                    [](Input& i) { i.instanceArray.instances = 0; });
    for (unsigned shift : {1u, 4u, 8u})
        expectBadBuffer(instances_->input, "instances",
                        [&](Input& i) { i.instanceArray.instances += shift; });
    CUdeviceptr pointer = instances_->memory.address();
    Buffer pointers(16);
    std::memcpy(pointers.as<void>(), &pointer, 8);
    auto byPointer = [&](Input& i) {
        i.type = OPTIX_BUILD_INPUT_TYPE_INSTANCE_POINTERS;
        i.instanceArray.instances = pointers.address();
    };
    expectGood(instances_->input, byPointer);
    for (unsigned shift : {1u, 4u})
        expectBadBuffer(instances_->input, "instances", [&](Input& i) {
            byPointer(i);
            i.instanceArray.instances += shift;
        });
}

// ---- Buffers of the build ------------------------------------------------------------------------

TEST_F(AccelArguments, TempAndOutput) {
    for (const OptixBuildInput& input : {mesh_->input, boxes_->input, instances_->input}) {
        OptixAccelBuildOptions options = buildOptions();
        ASSERT_OK(usage(input));
        ASSERT_GT(sizes_.outputSizeInBytes, 0u);
        size_t temp = sizes_.tempSizeInBytes, output = sizes_.outputSizeInBytes;
        Buffer t(temp + 256), o(output + 256);
        auto call = [&](CUdeviceptr tempBuffer, size_t tempSize, CUdeviceptr outputBuffer,
                        size_t outputSize) {
            handle_ = kNoHandle;
            return optixAccelBuild(context_, nullptr, &options, &input, 1, tempBuffer, tempSize,
                                   outputBuffer, outputSize, &handle_, nullptr, 0);
        };
        EXPECT_OK(call(t.address(), temp, o.address(), output)) << "exactly the computed sizes";
        waitForDevice();
        auto bad = OPTIX_ERROR_INVALID_VALUE;
        EXPECT_REJECTED(bad, kBuild, "outputBuffer", call(t.address(), temp, 0, output));
        for (unsigned shift : {1u, 16u, 64u})
            EXPECT_REJECTED(bad, kBuild, "outputBuffer",
                            call(t.address(), temp, o.address() + shift, output));
        EXPECT_REJECTED(bad, kBuild, "outputBuffer", call(t.address(), temp, o.address(), output - 1));
        EXPECT_REJECTED(bad, kBuild, "outputBuffer", call(t.address(), temp, o.address(), 0));
        EXPECT_REJECTED(bad, kBuild, "outputBuffer", call(t.address(), temp, 128, output));
        EXPECT_REJECTED(bad, kBuild, "outputBuffer",
                        call(t.address(), temp, o.address(), size_t(1) << 60));
        if (temp != 0) {
            EXPECT_REJECTED(bad, kBuild, "tempBuffer", call(0, temp, o.address(), output));
            EXPECT_REJECTED(bad, kBuild, "tempBuffer",
                            call(t.address(), temp - 1, o.address(), output));
            EXPECT_REJECTED(bad, kBuild, "tempBuffer",
                            call(t.address() + 64, temp, o.address(), output));
        }
        EXPECT_EQ(kNoHandle, handle_);
    }
}

TEST_F(AccelArguments, EmittedProperties) {
    Buffer result(64);
    OptixAccelBuildOptions options = buildOptions(OPTIX_BUILD_FLAG_ALLOW_COMPACTION);
    Buffer temp(1 << 16), output(1 << 16);
    auto call = [&](const OptixAccelEmitDesc* emit, unsigned count) {
        return optixAccelBuild(context_, nullptr, &options, &mesh_->input, 1, temp.address(),
                               temp.size(), output.address(), output.size(), &handle_, emit, count);
    };
    OptixAccelEmitDesc size{result.address(), OPTIX_PROPERTY_TYPE_COMPACTED_SIZE};
    OptixAccelEmitDesc box{result.address() + 8, OPTIX_PROPERTY_TYPE_AABBS};
    OptixAccelEmitDesc both[] = {size, box};
    EXPECT_OK(call(both, 2));
    EXPECT_OK(call(nullptr, 0));
    EXPECT_OK(call(both, 0));
    waitForDevice();
    auto bad = OPTIX_ERROR_INVALID_VALUE;
    EXPECT_REJECTED(bad, kBuild, "emittedProperties", call(nullptr, 1));
    for (unsigned type : {0u, 0x2180u, 0x2183u, ~0u}) {
        OptixAccelEmitDesc unknown = size;
        std::memcpy(&unknown.type, &type, sizeof(type));
        EXPECT_REJECTED(bad, kBuild, "type", call(&unknown, 1));
    }
    for (CUdeviceptr address : {CUdeviceptr(0), result.address() + 4, result.address() + 1}) {
        OptixAccelEmitDesc wrong{address, OPTIX_PROPERTY_TYPE_COMPACTED_SIZE};
        EXPECT_REJECTED(bad, kBuild, "result", call(&wrong, 1));
    }
    for (CUdeviceptr address : {CUdeviceptr(0), result.address() + 2}) {
        OptixAccelEmitDesc wrong{address, OPTIX_PROPERTY_TYPE_AABBS};
        EXPECT_REJECTED(bad, kBuild, "result", call(&wrong, 1));
    }
    options.buildFlags = 0; // a compacted size needs ALLOW_COMPACTION
    EXPECT_REJECTED(bad, kBuild, "COMPACTED_SIZE", call(&size, 1));
    EXPECT_OK(call(&box, 1));
    waitForDevice();
}

// ---- Compaction ----------------------------------------------------------------------------------

TEST_F(AccelArguments, Compaction) {
    Buffer size(8);
    Accel source = buildAccel(context_, log_, {mesh_->input}, OPTIX_BUILD_FLAG_ALLOW_COMPACTION,
                              {{size.address(), OPTIX_PROPERTY_TYPE_COMPACTED_SIZE}});
    size_t compacted = *size.as<uint64_t>();
    Buffer target(compacted + 256);
    OptixTraversableHandle handle = kNoHandle;
    auto call = [&](OptixTraversableHandle input, CUdeviceptr output, size_t bytes) {
        return optixAccelCompact(context_, nullptr, input, output, bytes, &handle);
    };
    auto bad = OPTIX_ERROR_INVALID_VALUE;
    EXPECT_REJECTED(bad, kCompact, "outputHandle",
                    optixAccelCompact(context_, nullptr, source.handle, target.address(),
                                      target.size(), nullptr));
    EXPECT_REJECTED(bad, kCompact, "inputHandle", call(0, target.address(), compacted));
    for (OptixTraversableHandle garbage :
         {OptixTraversableHandle(1), OptixTraversableHandle(0x1000), ~OptixTraversableHandle(0),
          OptixTraversableHandle(target.address()), source.handle + 128, source.handle ^ 3,
          OptixTraversableHandle(0xDEADBEEFDEADBE81ull)})
        EXPECT_REJECTED(bad, kCompact, "inputHandle", call(garbage, target.address(), compacted));
    EXPECT_REJECTED(bad, kCompact, "outputBuffer", call(source.handle, 0, compacted));
    for (unsigned shift : {1u, 64u})
        EXPECT_REJECTED(bad, kCompact, "outputBuffer",
                        call(source.handle, target.address() + shift, compacted));
    for (size_t bytes : {size_t(0), size_t(1), compacted - 1})
        EXPECT_REJECTED(bad, kCompact, "outputBufferSizeInBytes",
                        call(source.handle, target.address(), bytes));
    EXPECT_REJECTED(bad, kCompact, "overlap",
                    call(source.handle, source.memory.address(), source.memory.size()));
    EXPECT_EQ(kNoHandle, handle);
    EXPECT_OK(call(source.handle, target.address(), compacted));
    waitForDevice();
}

// ---- Headers
// -------------------------------------------------------------------------------------

// A copy of a structure whose first 128 bytes, a part of the header, are readable, and the rest
// not.
class CutStructure {
public:
    explicit CutStructure(const Buffer& whole) {
        pages_ =
            mmap(nullptr, 2 * kPage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        EXPECT_NE(MAP_FAILED, pages_);
        std::memcpy(begin(), whole.as<char>(), kBytes);
        EXPECT_EQ(0, mprotect(static_cast<char*>(pages_) + kPage, kPage, PROT_NONE));
    }
    ~CutStructure() { munmap(pages_, 2 * kPage); }
    CutStructure(const CutStructure&) = delete;
    CutStructure& operator=(const CutStructure&) = delete;
    char* begin() const { return static_cast<char*>(pages_) + kPage - kBytes; }
    CUdeviceptr address() const { return CUdeviceptr(begin()); }

    static constexpr size_t kBytes = 128;

private:
    static constexpr size_t kPage = 4096;
    void* pages_ = nullptr;
};

TEST_F(AccelArguments, PartsOfHeaders) {
    if (onGpu())
        GTEST_SKIP() << "device memory is no memory of the process";
    Accel source = buildAccel(context_, log_, {mesh_->input},
                              OPTIX_BUILD_FLAG_ALLOW_COMPACTION | OPTIX_BUILD_FLAG_ALLOW_UPDATE);
    const CutStructure cut(source.memory);
    const OptixTraversableHandle handle = cut.address() | (source.handle & 63);
    const auto bad = OPTIX_ERROR_INVALID_VALUE;
    OptixAccelRelocationInfo info{};
    EXPECT_REJECTED(bad, "optixAccelGetRelocationInfo", "no acceleration structure",
                    optixAccelGetRelocationInfo(context_, handle, &info));
    Buffer target(1 << 16);
    OptixTraversableHandle moved = kNoHandle;
    EXPECT_REJECTED(
        bad, kCompact, "no acceleration structure",
        optixAccelCompact(context_, nullptr, handle, target.address(), target.size(), &moved));
    OptixAccelBuildOptions options =
        buildOptions(OPTIX_BUILD_FLAG_ALLOW_COMPACTION | OPTIX_BUILD_FLAG_ALLOW_UPDATE);
    options.operation = OPTIX_BUILD_OPERATION_UPDATE;
    EXPECT_REJECTED(bad, kBuild, "outputBufferSizeInBytes",
                    optixAccelBuild(context_, nullptr, &options, &mesh_->input, 1, target.address(),
                                    target.size(), cut.address(), CutStructure::kBytes, &moved,
                                    nullptr, 0));
}

} // namespace
} // namespace tests::api
