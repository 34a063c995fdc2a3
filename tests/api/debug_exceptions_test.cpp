// SPDX-License-Identifier: Apache-2.0
// Exceptions of the library: every mistake of debug_exceptions.h runs the exception program with
// its code and details, ends only its launch index, is harmless without the flags, and fails a
// launch in validation mode.
#include "device/debug_exceptions.h"
#include "device_memory.h"
#include "rig.h"
#include "scene.h"

#include <cmath>
#include <functional>
#include <limits>

namespace tests::api {
namespace {

constexpr unsigned kAllFlags = OPTIX_EXCEPTION_FLAG_STACK_OVERFLOW |
                               OPTIX_EXCEPTION_FLAG_TRACE_DEPTH | OPTIX_EXCEPTION_FLAG_USER |
                               OPTIX_EXCEPTION_FLAG_DEBUG;

class DebugExceptions : public DeviceTest {
protected:
    // A triangle, an instance of it, both with and without random access; a box.
    struct Scene {
        Scene(OptixDeviceContext context, const LogRecord& log)
            : mesh({{-50, -50, 1}, {50, -50, 1}, {0, 80, 1}}, {0, 1, 2}),
              boxes({{-1, -1, 0, 1, 1, 2}}),
              gas(buildAccel(context, log, {mesh.input}, OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS)),
              plainGas(buildAccel(context, log, {mesh.input})),
              customs(buildAccel(context, log, {boxes.input})),
              list({instanceOf(gas.handle, identity(), 5)}),
              ias(buildAccel(context, log, {list.input},
                             OPTIX_BUILD_FLAG_ALLOW_RANDOM_INSTANCE_ACCESS)),
              plainIas(buildAccel(context, log, {list.input})) {}
        TriangleMesh mesh;
        CustomBoxes boxes;
        Accel gas, plainGas, customs;
        InstanceList list;
        Accel ias, plainIas;
    };

    void prepare(unsigned flags, bool exceptionProgram = true,
                 const char* raygen = "__raygen__mistakes") {
        OptixPipelineCompileOptions options = compileOptions(1);
        options.exceptionFlags = flags;
        adjust(options);
        rig_ = rig("debug_exceptions", options);
        Rig& r = *rig_;
        r.raygenRecord(r.raygen(raygen));
        r.missRecord(r.miss("__miss__mistakes"));
        r.hitRecord(r.hit("__closesthit__mistakes"));
        r.hitRecord(r.hit("__closesthit__mistakes", nullptr, "__intersection__mistakes"));
        r.callableRecord(r.callables("__direct_callable__two"));
        r.callableRecord(r.callables("__direct_callable__again"));
        r.callableRecord(r.callables(nullptr, "__continuation_callable__sum"));
        if (exceptionProgram) {
            OptixProgramGroupDesc desc{};
            desc.kind = OPTIX_PROGRAM_GROUP_KIND_EXCEPTION;
            desc.exception.module = r.module();
            desc.exception.entryFunctionName = "__exception__mistakes";
            const size_t group = r.add(desc);
            record_ = Buffer(OPTIX_SBT_RECORD_HEADER_SIZE);
            require(optixSbtRecordPackHeader(r.group(group), record_.as<void>()), "pack", log_);
        }
        r.link(1); // before there are graphs: GPUs then have code for two levels, until more exist
        scene_ = std::make_unique<Scene>(context_, log_);
    }
    virtual void adjust(OptixPipelineCompileOptions&) {}

    OptixResult launch(unsigned mistake, unsigned indices) {
        results_ = Buffer(indices * sizeof(DebugResult));
        params_ = Buffer(sizeof(DebugParams));
        *params_.as<DebugParams>() = {results_.as<DebugResult>(),
                                      traced_ ? traced_ : scene_->ias.handle,
                                      scene_->gas.handle,         scene_->plainIas.handle,
                                      scene_->plainGas.handle,    scene_->customs.handle,
                                      mistake};
        OptixShaderBindingTable sbt = rig_->table();
        sbt.exceptionRecord = record_.address();
        change_(sbt);
        const OptixResult result = optixLaunch(rig_->pipeline(), nullptr, params_.address(),
                                               sizeof(DebugParams), &sbt, indices, 1, 1);
        waitForDevice();
        return result;
    }
    // The stream keeps a failure until its next call.
    void expectFailedLaunch() {
        EXPECT_EQ(OPTIX_ERROR_LAUNCH_FAILURE, launch(kFine, 1));
        EXPECT_TRUE(log_.hasError("stack overflow", "launch index (0, 0, 0)")) << log_.all();
    }
    const DebugResult& result(unsigned i) const { return results_.as<DebugResult>()[i]; }

    std::unique_ptr<Scene> scene_;
    std::unique_ptr<Rig> rig_;
    Buffer record_, results_, params_;
    std::function<void(OptixShaderBindingTable&)> change_ = [](OptixShaderBindingTable&) {};
    OptixTraversableHandle traced_ = 0; // instead of the scene's instance structure
};

int codeOf(unsigned mistake) {
    switch (mistake) {
    case kDeepTrace: return OPTIX_EXCEPTION_CODE_TRACE_DEPTH_EXCEEDED;
    case kBadTraversable: return OPTIX_EXCEPTION_CODE_TRAVERSAL_INVALID_TRAVERSABLE;
    case kBadMiss: return OPTIX_EXCEPTION_CODE_TRAVERSAL_INVALID_MISS_SBT;
    case kBadHit: return OPTIX_EXCEPTION_CODE_TRAVERSAL_INVALID_HIT_SBT;
    case kBadRay: return OPTIX_EXCEPTION_CODE_INVALID_RAY;
    case kWrongParameters: return OPTIX_EXCEPTION_CODE_CALLABLE_PARAMETER_MISMATCH;
    case kCallableOutOfRange: return OPTIX_EXCEPTION_CODE_CALLABLE_INVALID_SBT;
    case kNoDirect: return OPTIX_EXCEPTION_CODE_CALLABLE_NO_DC_SBT_RECORD;
    case kNoContinuation: return OPTIX_EXCEPTION_CODE_CALLABLE_NO_CC_SBT_RECORD;
    case kListIndex:
    case kAnyHitFlags:
    case kFaceFlags:
    case kThrowCode:
    case kBadGasForVertices: return OPTIX_EXCEPTION_CODE_INVALID_VALUE_ARGUMENT_0;
    case kBadPrimitive:
    case kBadInstance:
    case kReportKind: return OPTIX_EXCEPTION_CODE_INVALID_VALUE_ARGUMENT_1;
    case kBadSbtGasIndex: return OPTIX_EXCEPTION_CODE_INVALID_VALUE_ARGUMENT_2;
    case kNoVertexAccess:
    case kNoInstanceAccess: return OPTIX_EXCEPTION_CODE_UNSUPPORTED_DATA_ACCESS;
    case kDeepCallables:
    case kDeepRecursion: return OPTIX_EXCEPTION_CODE_STACK_OVERFLOW;
    default: return 1000;
    }
}

TEST_P(DebugExceptions, EveryMistakeHasItsCodeAndDetails) {
    prepare(kAllFlags);
    constexpr unsigned kIndices = 20 * kMistakes;
    ASSERT_OK(launch(kMistakes, kIndices));
    for (unsigned i = 0; i < kIndices; ++i) {
        const unsigned mistake = i % kMistakes;
        SCOPED_TRACE(mistake);
        const DebugResult& r = result(i);
        ASSERT_EQ(codeOf(mistake), r.code);
        ASSERT_EQ(mistake == kFine ? 1u : 0u, r.reached);
        if (mistake == kFine) {
            ASSERT_EQ(100u, r.detail);
            continue;
        }
        // All details that the code lacks are zero.
        ASSERT_EQ(0u, r.detail);
        ASSERT_EQ(mistake == kBadTraversable ? scene_->gas.handle + 48 : 0, r.traversable);
        const int offsets[] = {0, 0, 0, 7, 200, 0, 0, 77, 2, 0};
        ASSERT_EQ(mistake <= kNoContinuation ? offsets[mistake] : 0, r.sbtOffset);
        ASSERT_EQ(mistake == kWrongParameters ? "__direct_callable__two" : std::string(), r.name);
        ASSERT_EQ(mistake == kWrongParameters ? 2u : 0u, r.expected);
        ASSERT_EQ(mistake == kWrongParameters ? 4u : 0u, r.passed);
        ASSERT_EQ(mistake == kBadHit ? 1u : 0u, mistake == kBadHit ? r.listSize : 0u);
        if (mistake == kBadHit)
            ASSERT_EQ(unsigned(OPTIX_TRANSFORM_TYPE_INSTANCE), r.listType);
        if (mistake == kBadRay) {
            ASSERT_EQ(-1.0f, r.ray[2]);
            ASSERT_TRUE(std::isinf(r.ray[5]));
            ASSERT_EQ(10.0f, r.ray[7]);
        } else {
            ASSERT_EQ(0.0f, r.ray[2]);
        }
        const bool hasLine = mistake == kBadRay || mistake == kWrongParameters ||
                             mistake == kAnyHitFlags || mistake == kFaceFlags ||
                             mistake == kThrowCode;
        ASSERT_EQ(hasLine, std::string(r.line).find("debug_exceptions.cu:") != std::string::npos)
            << r.line;
        if (!hasLine)
            ASSERT_STREQ("", r.line);
    }
}

// What the log says about mistakes that keep programs from running; else an empty text.
std::string remarkOf(unsigned mistake) {
    switch (mistake) {
    case kDeepTrace:
        return "optixTrace was called below maxTraceDepth = 1 of";
    case kBadMiss:
        return "a miss needs miss record 7, but missRecordCount is 1;";
    case kBadHit:
        return "a hit needs hit group record 200, but hitgroupRecordCount is 2;";
    case kCallableOutOfRange:
        return "optixDirectCall needs callables record 77, but callablesRecordCount is 3;";
    case kNoDirect:
        return "optixDirectCall needs callables record 2, whose header optixSbtRecordPackHeader "
               "packed for no group with a direct callable of this pipeline;";
    case kNoContinuation:
        return "optixContinuationCall needs callables record 0, whose header "
               "optixSbtRecordPackHeader packed for no group with a continuation callable";
    default:
        return {};
    }
}

// Undefined by the manual; must not crash, and the launch continues.
TEST_P(DebugExceptions, WithoutFlagsMistakesAreHarmless) {
    prepare(OPTIX_EXCEPTION_FLAG_NONE);
    for (unsigned mistake = 0; mistake < kMistakes; ++mistake) {
        if (mistake == kDeepCallables || mistake == kDeepRecursion)
            continue;
        SCOPED_TRACE(mistake);
        log_.clear();
        ASSERT_EQ(OPTIX_SUCCESS, launch(mistake, 40)) << log_.all();
        for (unsigned i = 0; i < 40; ++i) {
            if (mistake == kThrowCode) { // never taken for a code of the library
                ASSERT_GE(result(i).code, 0);
                continue;
            }
            ASSERT_EQ(1u, result(i).reached);
            ASSERT_EQ(1000, result(i).code);
        }
        const std::string remark = remarkOf(mistake);
        ASSERT_EQ(!remark.empty(), log_.hasError("", remark)) << log_.all();
    }
}

// Endless recursion without the flag fails the launch.
TEST_P(DebugExceptions, WithoutFlagsOverflowsFailTheLaunch) {
    prepare(OPTIX_EXCEPTION_FLAG_NONE);
    for (unsigned mistake : {unsigned(kDeepCallables), unsigned(kDeepRecursion)}) {
        SCOPED_TRACE(mistake);
        log_.clear();
        ASSERT_EQ(OPTIX_SUCCESS, launch(mistake, 40));
        expectFailedLaunch();
    }
}

// Handles of all kinds: an exception with any target.
TEST_P(DebugExceptions, HandlesOfNothing) {
    prepare(kAllFlags);
    Buffer noise(4096, 128);
    noise.fill(0x5A);
    std::vector<OptixTraversableHandle> handles = {
        0x1001, 0x7fff12345681, ~OptixTraversableHandle(63) | 2, noise.address() | 1,
        noise.address() | 2, scene_->gas.handle + 128, scene_->gas.handle + 1,
        scene_->ias.handle - 1, 1, 2, 3};
    if (onGpu()) // elsewhere freed memory is not tracked
        handles.push_back(buildAccel(context_, log_, {scene_->mesh.input}).handle);
    for (OptixTraversableHandle handle : handles) {
        SCOPED_TRACE(handle);
        traced_ = handle;
        ASSERT_OK(launch(kFine, 40));
        ASSERT_EQ(OPTIX_EXCEPTION_CODE_TRAVERSAL_INVALID_TRAVERSABLE, result(0).code);
        ASSERT_EQ(handle, result(39).traversable);
    }
    traced_ = 0;
    ASSERT_OK(launch(kFine, 40));
    ASSERT_EQ(1000, result(0).code);
}

// Records within the table without a header of a group of that kind, or with a header of another
// pipeline's group.
TEST_P(DebugExceptions, RecordsOfNothing) {
    prepare(kAllFlags);
    Buffer zeros(1024, 16), foreign(1024, 16);
    zeros.fill(0);
    const size_t groups[] = {rig_->hit("__closesthit__mistakes"), rig_->miss("__miss__mistakes")};
    for (int kind = 0; kind < 2; ++kind) // records of 32 bytes
        for (int i = 0; i < 16; ++i)
            require(optixSbtRecordPackHeader(rig_->group(groups[kind]),
                                             foreign.as<char>() + 512 * kind + 32 * i),
                    "pack", log_);
    const CUdeviceptr hits[] = {zeros.address(), foreign.address(), foreign.address() + 512};
    const CUdeviceptr misses[] = {zeros.address(), foreign.address() + 512, foreign.address()};
    for (int i = 0; i < 3; ++i) {
        SCOPED_TRACE(i);
        change_ = [&](OptixShaderBindingTable& sbt) { sbt.hitgroupRecordBase = hits[i]; };
        ASSERT_OK(launch(kFine, 40));
        ASSERT_EQ(OPTIX_EXCEPTION_CODE_TRAVERSAL_INVALID_HIT_SBT, result(39).code);
        ASSERT_EQ(0u, result(39).sbtOffset);
        change_ = [&](OptixShaderBindingTable& sbt) {
            sbt.missRecordBase = misses[i];
            sbt.missRecordStrideInBytes = 32;
            sbt.missRecordCount = 8;
        };
        ASSERT_OK(launch(kBadMiss, 40));
        ASSERT_EQ(OPTIX_EXCEPTION_CODE_TRAVERSAL_INVALID_MISS_SBT, result(39).code);
        ASSERT_EQ(7u, result(39).sbtOffset);
    }
}

// The same without exceptions.
TEST_P(DebugExceptions, RecordsOfNothingAreLogged) {
    prepare(OPTIX_EXCEPTION_FLAG_NONE);
    Buffer zeros(1024, 16);
    zeros.fill(0);
    const auto expect = [&](unsigned mistake, const char* text) {
        log_.clear();
        ASSERT_OK(launch(mistake, 40));
        EXPECT_EQ(1000, result(39).code);
        EXPECT_TRUE(log_.hasError("", text)) << log_.all();
    };
    change_ = [&](OptixShaderBindingTable& sbt) { sbt.hitgroupRecordBase = zeros.address(); };
    expect(kFine, "a hit needs hit group record 0, whose header optixSbtRecordPackHeader packed "
                  "for no hit group of this pipeline; no program ran for it");
    change_ = [&](OptixShaderBindingTable& sbt) {
        sbt.missRecordBase = zeros.address();
        sbt.missRecordStrideInBytes = 32;
        sbt.missRecordCount = 8;
    };
    expect(kBadMiss, "a miss needs miss record 7, whose header optixSbtRecordPackHeader packed for "
                     "no miss group of this pipeline; no program ran for it");
}

// The first groups of two contexts would have equal numbers if both were counted from one.
TEST_P(DebugExceptions, RecordsOfAnotherContext) {
    OptixDeviceContext second = context_;
    ASSERT_OK(optixDeviceContextCreate(nullptr, nullptr, &context_));
    OptixPipelineCompileOptions options = compileOptions(1);
    options.exceptionFlags = kAllFlags;
    std::unique_ptr<Rig> other = rig("debug_exceptions", options);
    const size_t groups[] = {other->hit("__closesthit__mistakes"), other->miss("__miss__mistakes")};
    Buffer foreign(1024, 16);
    for (int kind = 0; kind < 2; ++kind)
        for (int i = 0; i < 16; ++i)
            require(optixSbtRecordPackHeader(other->group(groups[kind]),
                                             foreign.as<char>() + 512 * kind + 32 * i),
                    "pack", log_);
    std::swap(context_, second);
    prepare(kAllFlags);
    change_ = [&](OptixShaderBindingTable& sbt) {
        sbt.hitgroupRecordBase = foreign.address();
        sbt.missRecordBase = foreign.address() + 512;
        sbt.missRecordStrideInBytes = 32;
        sbt.missRecordCount = 8;
    };
    ASSERT_OK(launch(kFine, 40));
    EXPECT_EQ(OPTIX_EXCEPTION_CODE_TRAVERSAL_INVALID_HIT_SBT, result(39).code);
    ASSERT_OK(launch(kBadMiss, 40));
    EXPECT_EQ(OPTIX_EXCEPTION_CODE_TRAVERSAL_INVALID_MISS_SBT, result(39).code);
    other.reset();
    ASSERT_OK(optixDeviceContextDestroy(second));
}

TEST_P(DebugExceptions, LargeFramesOverflowTheStack) {
    prepare(kAllFlags, true, "__raygen__large");
    ASSERT_OK(launch(kLargeFrames, 40));
    for (unsigned i = 0; i < 40; ++i) {
        ASSERT_EQ(OPTIX_EXCEPTION_CODE_STACK_OVERFLOW, result(i).code);
        ASSERT_EQ(0u, result(i).reached);
    }
    prepare(OPTIX_EXCEPTION_FLAG_NONE, true, "__raygen__large");
    log_.clear();
    ASSERT_OK(launch(kLargeFrames, 40));
    expectFailedLaunch();
}

// The log names the first index that ended so; no call fails.
TEST_P(DebugExceptions, WithoutExceptionProgram) {
    prepare(kAllFlags, false);
    log_.clear();
    ASSERT_OK(launch(kBadMiss, 300));
    EXPECT_FALSE(log_.hasError("", "")) << log_.all();
    EXPECT_NE(std::string::npos, log_.all().find("no miss program group of the pipeline at the "
                                                 "SBT index (exception -6), index 7, at launch index (0, 0, 0)"))
        << log_.all();
    EXPECT_EQ(0u, result(0).reached);
}

TEST_P(DebugExceptions, ValidationModeFailsTheLaunch) {
    OptixDeviceContextOptions contextOptions{};
    contextOptions.logCallbackFunction = LogRecord::callback;
    contextOptions.logCallbackData = &log_;
    contextOptions.logCallbackLevel = 4;
    contextOptions.validationMode = OPTIX_DEVICE_CONTEXT_VALIDATION_MODE_ALL;
    OptixDeviceContext plain = context_;
    ASSERT_OK(optixDeviceContextCreate(nullptr, &contextOptions, &context_));
    prepare(OPTIX_EXCEPTION_FLAG_NONE);
    for (unsigned mistake = 0; mistake < kMistakes; ++mistake) {
        SCOPED_TRACE(mistake);
        log_.clear();
        const OptixResult result = launch(mistake, 4);
        if (mistake == kFine) {
            EXPECT_EQ(OPTIX_SUCCESS, result) << log_.all();
            continue;
        }
        EXPECT_EQ(OPTIX_ERROR_VALIDATION_FAILURE, result);
        EXPECT_TRUE(log_.hasError("exception " + std::to_string(codeOf(mistake)),
                                  "at launch index (0, 0, 0)"))
            << log_.all();
    }
    EXPECT_EQ(OPTIX_SUCCESS, launch(kFine, 4)) << "a failed launch leaves nothing behind";
    rig_.reset();
    ASSERT_OK(optixDeviceContextDestroy(context_));
    context_ = plain;
}

class GraphExceptions : public DebugExceptions {
protected:
    void adjust(OptixPipelineCompileOptions& options) override {
        options.traversableGraphFlags = graph_;
        options.usesPrimitiveTypeFlags = primitives_;
    }
    unsigned graph_ = 0, primitives_ = 0;
};

TEST_P(GraphExceptions, UnsupportedPrimitiveTypeWithLine) {
    primitives_ = OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM;
    prepare(kAllFlags);
    ASSERT_OK(launch(kFine, 1));
    EXPECT_EQ(OPTIX_EXCEPTION_CODE_UNSUPPORTED_PRIMITIVE_TYPE, result(0).code);
    EXPECT_NE(std::string::npos, std::string(result(0).line).find("debug_exceptions.cu:"));
}

TEST_P(GraphExceptions, SingleGasNotAllowed) {
    graph_ = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
    prepare(kAllFlags);
    ASSERT_OK(launch(kReportKind, 1)); // traces a geometry structure
    EXPECT_EQ(OPTIX_EXCEPTION_CODE_UNSUPPORTED_SINGLE_LEVEL_GAS, result(0).code);
    EXPECT_EQ(scene_->customs.handle, result(0).traversable);
    EXPECT_EQ(0u, result(0).listSize);
    ASSERT_OK(launch(kFine, 1));
    EXPECT_EQ(1000, result(0).code);
}

TEST_P(GraphExceptions, InstancingNotAllowed) {
    graph_ = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS;
    prepare(kAllFlags);
    ASSERT_OK(launch(kFine, 1)); // traces an instance structure
    EXPECT_EQ(OPTIX_EXCEPTION_CODE_TRAVERSAL_INVALID_TRAVERSABLE, result(0).code);
    EXPECT_EQ(scene_->ias.handle, result(0).traversable);
}

// Such offsets are legal, but implementations interpret them differently.
TEST_P(DebugExceptions, SbtOffsetsAbove15AreRemarkedUpon) {
    prepare(OPTIX_EXCEPTION_FLAG_DEBUG);
    log_.clear();
    ASSERT_OK(launch(kFine, 4));
    EXPECT_EQ(std::string::npos, log_.all().find("above 15")) << log_.all();
    ASSERT_OK(launch(kBadHit, 4)); // offset 200
    EXPECT_NE(std::string::npos, log_.all().find("SBT offset or stride above 15")) << log_.all();
}

// The manual leaves this undefined without exceptions; Sunstone still finds deeper structures.
TEST_P(GraphExceptions, DeeperThanDeclaredWithoutExceptions) {
    prepare(OPTIX_EXCEPTION_FLAG_NONE);
    constexpr const char* kLine = "more than the 1 levels of maxTraversableGraphDepth";
    ASSERT_OK(optixPipelineSetStackSize(rig_->pipeline(), 0, 0, 0, 1));
    log_.clear();
    ASSERT_OK(launch(kFine, 40));
    EXPECT_EQ(1u, result(0).reached);
    EXPECT_EQ(100u, result(0).detail) << "the triangle under the instance is hit";
    EXPECT_NE(std::string::npos, log_.all().find(kLine)) << log_.all();
    ASSERT_OK(optixPipelineSetStackSize(rig_->pipeline(), 0, 0, 0, 2));
    log_.clear();
    ASSERT_OK(launch(kFine, 40));
    EXPECT_EQ(100u, result(0).detail);
    EXPECT_EQ(std::string::npos, log_.all().find("levels of")) << log_.all();
}

// The graph has two traversables on its path.
TEST_P(GraphExceptions, TraversalDepth) {
    for (unsigned flag : {unsigned(OPTIX_EXCEPTION_FLAG_TRACE_DEPTH),
                          unsigned(OPTIX_EXCEPTION_FLAG_DEBUG)}) {
        prepare(flag);
        ASSERT_OK(optixPipelineSetStackSize(rig_->pipeline(), 0, 0, 0, 1));
        ASSERT_OK(launch(kFine, 1));
        EXPECT_EQ(OPTIX_EXCEPTION_CODE_TRAVERSAL_DEPTH_EXCEEDED, result(0).code);
        ASSERT_OK(optixPipelineSetStackSize(rig_->pipeline(), 0, 0, 0, 2));
        ASSERT_OK(launch(kFine, 1));
        EXPECT_EQ(1000, result(0).code);
        rig_.reset();
    }
}

// Graphs of two and three traversables: instances of instances, and a transform before both.
class GraphDepths : public GraphExceptions {
protected:
    // After prepare().
    void build() {
        above_ = std::make_unique<InstanceList>(
            std::vector<OptixInstance>{instanceOf(scene_->ias.handle, identity(), 9)});
        two_ = std::make_unique<Accel>(buildAccel(context_, log_, {above_->input}));
        shallow_ = transformOf(0, scene_->gas.handle);
        deep_ = transformOf(1, scene_->ias.handle);
    }
    void declare(unsigned depth) {
        ASSERT_OK(optixPipelineSetStackSize(rig_->pipeline(), 0, 0, 0, depth));
    }
    // Launches with the handle; whether the triangle was hit.
    bool hits(OptixTraversableHandle handle) {
        traced_ = handle;
        log_.clear();
        EXPECT_OK(launch(kFine, 40));
        EXPECT_EQ(1u, result(0).reached);
        return result(0).detail == 100;
    }
    bool isRemarkedUpon() const {
        return log_.all().find("levels of maxTraversableGraphDepth") != std::string::npos;
    }
    std::unique_ptr<InstanceList> above_;
    std::unique_ptr<Accel> two_;
    OptixTraversableHandle shallow_ = 0, deep_ = 0;

private:
    OptixTraversableHandle transformOf(size_t place, OptixTraversableHandle child) {
        const uint64_t at = transforms_.address() + place * kStride;
        auto& transform = *reinterpret_cast<OptixStaticTransform*>(at);
        transform = {};
        transform.child = child;
        for (int i = 0; i < 12; ++i)
            transform.transform[i] = transform.invTransform[i] = i % 5 == 0 ? 1.0f : 0.0f;
        OptixTraversableHandle handle = 0;
        EXPECT_OK(optixConvertPointerToTraversableHandle(
            context_, at, OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM, &handle));
        return handle;
    }
    static constexpr size_t kStride = 2 * OPTIX_TRANSFORM_BYTE_ALIGNMENT;
    static_assert(kStride >= sizeof(OptixStaticTransform));
    Buffer transforms_{2 * kStride, OPTIX_TRANSFORM_BYTE_ALIGNMENT};
};

TEST_P(GraphDepths, UndeclaredOnesAreFoundAtAnyDepth) {
    prepare(OPTIX_EXCEPTION_FLAG_NONE);
    build();
    for (const OptixTraversableHandle handle : {two_->handle, deep_, shallow_, scene_->ias.handle}) {
        EXPECT_TRUE(hits(handle));
        EXPECT_FALSE(isRemarkedUpon()) << log_.all();
    }
}

TEST_P(GraphDepths, ThoseDeclaredAreFoundAndMayChange) {
    prepare(OPTIX_EXCEPTION_FLAG_NONE);
    build();
    for (const unsigned depth : {2u, 3u, 2u, 4u}) {
        declare(depth);
        EXPECT_TRUE(hits(scene_->ias.handle)) << depth;
        EXPECT_TRUE(hits(scene_->gas.handle)) << depth;
        EXPECT_TRUE(hits(shallow_)) << depth;
        EXPECT_FALSE(isRemarkedUpon()) << log_.all();
        const bool isFound = hits(two_->handle) && hits(deep_);
        EXPECT_EQ(depth < 3, isRemarkedUpon()) << log_.all();
        if (depth >= 3)
            EXPECT_TRUE(isFound);
    }
}

TEST_P(GraphDepths, DeeperOnesRaiseExceptions) {
    prepare(OPTIX_EXCEPTION_FLAG_TRACE_DEPTH);
    build();
    declare(2);
    for (const OptixTraversableHandle handle : {two_->handle, deep_}) {
        traced_ = handle;
        ASSERT_OK(launch(kFine, 1));
        EXPECT_EQ(OPTIX_EXCEPTION_CODE_TRAVERSAL_DEPTH_EXCEEDED, result(0).code);
    }
    for (const OptixTraversableHandle handle : {shallow_, scene_->ias.handle}) {
        traced_ = handle;
        ASSERT_OK(launch(kFine, 1));
        EXPECT_EQ(1000, result(0).code);
    }
}

INSTANTIATE_DEVICE_TEST(DebugExceptions);
INSTANTIATE_DEVICE_TEST(GraphExceptions);
INSTANTIATE_DEVICE_TEST(GraphDepths);

} // namespace
} // namespace tests::api
