// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/backend.h"

#include "base/error.h"
#include "devlib/flags.h"
#include "engine/accel.h"
#include "engine/gpu/process.h"
#include "engine/launch.h"

#include <algorithm>
#include <cstring>

namespace sunstone::engine {

using namespace device::cuda;

namespace {

constexpr unsigned kLeastCapability = 70;

} // namespace

GpuBackend::GpuBackend(CUcontext context)
    : device_(context),
      kernelCode_(device_.computeCapability(), device_.driverVersion(), usableKernelImages()),
      slots_(context), shared_(context) {
    if (device_.computeCapability() < kLeastCapability)
        fail(Code::kNotSupported, device_.name(),
             ": GPUs from compute capability 7.0 on are "
             "supported");
}

GpuBackend::~GpuBackend() {
    gpuProcess().codeQueue.finish(this);
    try {
        ContextScope scope(device_.context());
        builder_.reset();
        denoiser_.reset();
        known_.reset();
        laneMemory_.release();
    } catch (const Error&) { // the application has destroyed its context
        if (builder_)
            builder_->abandon();
        if (denoiser_)
            denoiser_->abandon();
        known_->abandon();
    }
}

std::shared_ptr<Backend> createGpuBackend(void* cudaContext) {
    return std::make_shared<GpuBackend>(CUcontext(cudaContext));
}

void GpuBackend::flush(const Context& context) {
    try {
        ContextScope scope(device_.context());
        slots_.tellOfEnded(~0u);
        if (builder_)
            tellOfBuilds(context);
        if (denoiser_)
            tellOfRefusals(context);
    } catch (const Error&) { // the application has destroyed its context
    }
}

void GpuBackend::copy(void* to, const void* from, size_t bytes) {
    ContextScope scope(device_.context());
    SUNSTONE_CU(memcpyAsync, CUdeviceptr(to), CUdeviceptr(from), bytes, nullptr);
    SUNSTONE_CU(streamSynchronize, nullptr);
}

void GpuBackend::launch(const ContextPtr& context, const LaunchRequest& request) {
    using devlib::LaunchBlock;
    const Pipeline& pipeline = *request.pipeline;
    ContextScope scope(device_.context());
    const auto stream = CUstream(request.stream);
    const size_t variable = pipeline.launchParamsSize;
    const size_t given = request.params ? std::min<size_t>(request.paramsSize, variable) : 0;

    if (request.validation && isCapturing(driver(), stream))
        fail(Code::kNotSupported, "stream = ", request.stream,
             " is captured; launches of a context in validation mode wait for their end");
    if (request.validation && variable != 0) {
        std::vector<uint8_t> params(variable);
        if (given)
            SUNSTONE_CU(memcpyDtoHAsync, params.data(), CUdeviceptr(request.params), given, stream);
        SUNSTONE_CU(streamSynchronize, stream);
        checkBoundValues(pipeline, params.data());
    }
    const bool debugging = pipeline.rules.exceptionFlags & devlib::kFlagDebug;
    const GpuGraphs there = gpuGraphs();
    const std::shared_ptr<const GpuCodeObject> kept =
        codeOf(pipeline).getForLaunch(depthOfGraphs(request.limits, there), there, stream,
                                      uint64_t(request.width) * request.height * request.depth);
    const GpuCodeObject& code = *kept;
    GpuLaunchSlots::Lease slot(slots_, context, stream, variable, request.validation);
    slot->findings = code.findings;
    const bool asksAll = debugging || request.validation;
    const GpuKnownHandles::View handles =
        known_->update(asksAll ? GpuKnownHandles::kAll : GpuKnownHandles::kSome,
                       code.findings->usualHandle, stream);
    LaunchBlock& block = *slot->host;
    std::memset(static_cast<void*>(&block), 0, sizeof(block));
    block.launch.params = reinterpret_cast<const void*>(slot->memory + GpuLaunchSlots::kParameters);
    block.launch.dimensions[0] = request.width;
    block.launch.dimensions[1] = request.height;
    block.launch.dimensions[2] = request.depth;
    block.launch.maxTraceDepth = request.limits.maxTraceDepth;
    block.launch.sbt = request.sbt;
    block.launch.entryKind = request.entryKind;
    block.launch.boxes = request.boxes;
    block.launch.firstPrimitive = request.firstPrimitive;
    block.launch.motionStep = request.motionStep;
    block.launch.exceptionFlags = pipeline.rules.exceptionFlags;
    block.launch.hasAnyHit = pipeline.hasAnyHit;
    block.launch.opacityMicromaps = request.limits.opacityMicromaps;
    block.launch.motion = pipeline.rules.motionBlur;
    block.launch.traversableGraphFlags = pipeline.rules.traversableGraphFlags;
    block.launch.primitiveTypeFlags = pipeline.rules.primitiveTypeFlags;
    block.launch.maxGraphDepth = request.limits.maxGraphDepth;
    block.launch.numAttributes = pipeline.rules.optix7.numAttributeValues;
    block.launch.firstGroup = code.firstGroup;
    block.launch.groupCount = code.groupCount;
    const uint64_t tiles = devlib::gpuTiles(block.launch.dimensions);
    block.work.count = tiles * devlib::kGpuTile;
    block.work.laneMemory = code.laneMemory;
    block.report = devlib::emptyReport();
    block.stackBytes = uint32_t(code.stackBytes);
    const bool captured = isCapturing(driver(), stream);
    const unsigned threads = code.findings->patience.choose(block.work, !captured);
    const uint64_t tilesOfBlock = threads / devlib::kGpuTile;
    const uint64_t blocks =
        std::min<uint64_t>((tiles + tilesOfBlock - 1) / tilesOfBlock, code.mostBlocks);
    const bool looksUp = debugging || !captured; // see devlib/gpu/programs.h
    // The flags limit the depth of graphs with one level of instances.
    const bool hasOneLevel =
        pipeline.rules.traversableGraphFlags & devlib::kAllowSingleLevelInstancing;
    block.constants = {handles.usual, looksUp ? handles.known : 0,
                       hasOneLevel ? devlib::kMaxGraphDepth : request.limits.maxGraphDepth};
    SUNSTONE_CU(memcpyHtoDAsync, slot->memory, &block, sizeof(block), stream);
    const CUdeviceptr params = slot->memory + GpuLaunchSlots::kParameters;
    if (given)
        SUNSTONE_CU(memcpyAsync, params, CUdeviceptr(request.params), given, stream);
    if (given < variable) // reads beyond the caller's block see zeros
        SUNSTONE_CU(memsetD8Async, params + given, 0, variable - given, stream);

    void* arguments[] = {&slot->memory, &block.constants.usual, &block.constants.known,
                         &block.constants.maxGraphDepth};
    SUNSTONE_CU(launchKernel, code.kernel, unsigned(blocks), 1, 1, threads, 1, 1, 0, stream,
                arguments, nullptr);
    SUNSTONE_CU(memcpyDtoHAsync, slot->report, slot->memory + offsetof(LaunchBlock, report),
                sizeof(block.report), stream);
    if (!request.validation && !request.waits)
        return slot.queued();
    const std::string failure = slot.finish();
    if (!failure.empty())
        fail(Code::kLaunchFailure, failure);
}

} // namespace sunstone::engine
