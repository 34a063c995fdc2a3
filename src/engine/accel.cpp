// SPDX-License-Identifier: Apache-2.0
#include "engine/accel.h"

#include "base/error.h"
#include "bvh/gpu/layout.h"
#include "bvh/layout.h"
#include "devlib/abi.h"
#include "engine/cpu/backend.h"

#include <cstring>

namespace sunstone::engine {
namespace {

void emitProperty(const AccelEmit& emit, const void* block) {
    if (emit.kind == AccelEmit::kCompactedSize) {
        uint64_t size = bvh::compactedSize(block);
        std::memcpy(emit.destination, &size, sizeof(size));
        return;
    }
    const uint32_t keys = bvh::motionOf(block).keys;
    for (uint32_t key = 0; key < keys; ++key) {
        const bvh::Box box = bvh::boundsAtKey(block, key);
        const float values[6] = {box.lower.x, box.lower.y, box.lower.z,
                                 box.upper.x, box.upper.y, box.upper.z};
        std::memcpy(static_cast<uint8_t*>(emit.destination) + key * sizeof(values), values,
                    sizeof(values));
    }
}

void enqueue(const std::shared_ptr<Context>& context, void* stream, std::function<void()> work) {
    enqueueLogged(context, stream, "ACCEL", std::move(work));
}

// The block of a structure whose handle the caller gave.
const void* checkedBlock(const Context& context, uint64_t handle, const char* parameter) {
    const devlib::HandleTag tag = devlib::tagOf(handle);
    const void* block = reinterpret_cast<const void*>(devlib::addressOf(handle));
    if ((tag != devlib::kTagGas && tag != devlib::kTagIas) ||
        !context.device->isAccessible(block, sizeof(bvh::BlockHeader)) || !bvh::isBlock(block))
        fail(Code::kInvalidValue, parameter, " = ", reinterpret_cast<void*>(handle),
             " is no acceleration structure");
    if (bvh::traversableHandle(block) != handle)
        fail(Code::kInvalidValue, parameter, " = ", reinterpret_cast<void*>(handle),
             " is not the handle of the acceleration structure at its address");
    return block;
}

// Whether a call itself checks the contents of a structure's memory, as the GPU back end does: if
// the stream is idle, or in validation mode, which waits for the stream.
bool checksAtCall(const Context& context, void* stream) {
    if (context.validation)
        context.device->synchronize(stream);
    return context.validation || context.device->isIdle(stream);
}

void checkCompaction(const Context& context, uint64_t handle, const void* destination,
                     size_t destinationSize) {
    const void* source = checkedBlock(context, handle, "inputHandle");
    if (!bvh::allowsCompaction(source))
        tolerateCompaction(context, handle);
    const uint64_t size = bvh::compactedSize(source);
    if (destinationSize < size)
        fail(Code::kInvalidValue, "outputBufferSizeInBytes = ", destinationSize,
             " is less than the compacted size ", size);
    const uint64_t from = uint64_t(source), to = uint64_t(destination);
    if (from < to + size && to < from + size)
        fail(Code::kInvalidValue, "outputBuffer = ", destination,
             " overlaps the structure that is compacted");
}

} // namespace

bvh::BuildInputs AccelInputs::view() const {
    bvh::BuildInputs inputs;
    inputs.triangles = triangles;
    inputs.customs = customs;
    inputs.curves = curves;
    inputs.spheres = spheres;
    inputs.instances = instances.get();
    return inputs;
}

const uint32_t* AccelInputs::keepFlags(const unsigned* words, size_t count) {
    flags.emplace_back(words, words + count);
    return flags.back().data();
}

const void* const* AccelInputs::keepKeys(std::vector<const void*> buffers) {
    keys.push_back(std::move(buffers));
    return keys.back().data();
}

void tolerateCompaction(const Context& context, uint64_t handle) {
    tolerate(context, "compaction",
             message("inputHandle = ", reinterpret_cast<void*>(handle),
                     " was built without ALLOW_COMPACTION"),
             "it is compacted");
}

uint64_t cpu::buildAccel(const ContextPtr& context, AccelBuild request) {
    bool isInstances = request.inputs->instances != nullptr;
    uint64_t handle =
        devlib::makeHandle(request.output, isInstances ? devlib::kTagIas : devlib::kTagGas);
    void* stream = request.stream;
    // A busy stream may still build the structure; the queued work then checks it.
    const bool checksNow = request.update && checksAtCall(*context, stream);
    if (checksNow)
        bvh::checkUpdate(request.inputs->view(), request.options, request.output,
                         request.outputSize);
    enqueue(context, stream, [context, request = std::move(request), checksNow] {
        if (request.update && !checksNow)
            bvh::checkUpdate(request.inputs->view(), request.options, request.output,
                             request.outputSize);
        if (request.rules && request.inputs->instances && context->log)
            warnOfBrokenRule(*context, *request.inputs->instances, *request.rules);
        const auto run = request.update ? bvh::update : bvh::build;
        run(request.inputs->view(), request.options, request.temp, request.tempSize, request.output,
            request.outputSize);
        if (request.inputs->instances && context->log)
            warnOfUnknownChild(*context, *request.inputs->instances, request.output);
        for (const AccelEmit& emit : request.emit)
            emitProperty(emit, request.output);
    });
    return handle;
}

uint64_t cpu::compactAccel(const ContextPtr& context, void* stream, uint64_t handle,
                           void* destination, size_t destinationSize) {
    const bool checksNow = checksAtCall(*context, stream);
    if (checksNow)
        checkCompaction(*context, handle, destination, destinationSize);
    enqueue(context, stream, [context, handle, destination, destinationSize, checksNow] {
        if (!checksNow)
            checkCompaction(*context, handle, destination, destinationSize);
        const auto* const source = reinterpret_cast<const void*>(devlib::addressOf(handle));
        bvh::compact(source, destination, destinationSize);
    });
    return devlib::makeHandle(destination, devlib::tagOf(handle));
}

bvh::RelocationInfo cpu::relocationInfo(const ContextPtr& context, uint64_t handle) {
    context->device->synchronizeAll();
    return bvh::relocationInfo(checkedBlock(*context, handle, "handle"));
}

uint64_t cpu::relocateAccel(const ContextPtr& context, void* stream,
                            const bvh::RelocationInfo& info, void* block, const uint64_t* children,
                            size_t count, std::vector<const void*> arrays) {
    enqueue(context, stream, [info, block, children, count, arrays = std::move(arrays)] {
        bvh::relocate(info, block, children, count);
        if (!arrays.empty())
            bvh::relocateMicromaps(info, block, arrays.data(), arrays.size());
    });
    return devlib::makeHandle(block, bvh::holdsInstances(info) ? devlib::kTagIas : devlib::kTagGas);
}

bvh::MemoryUsage accelMemory(const Context& context, const AccelInputs& inputs,
                             const bvh::BuildOptions& options) {
    return context.backend->accelMemory(inputs.view(), options);
}

uint64_t buildAccel(const ContextPtr& context, AccelBuild request) {
    return context->backend->buildAccel(context, std::move(request));
}

uint64_t compactAccel(const ContextPtr& context, void* stream, uint64_t handle, void* destination,
                      size_t destinationSize) {
    return context->backend->compactAccel(context, stream, handle, destination, destinationSize);
}

bool isRelocatable(const Context& context, const bvh::RelocationInfo& info) {
    return context.backend->sharesMemory() ? bvh::isRelocatable(info)
                                           : bvh::isRelocatable(info, bvh::gpu::kGpuBlockMagic);
}

bvh::RelocationInfo relocationInfo(const ContextPtr& context, uint64_t handle) {
    return context->backend->relocationInfo(context, handle);
}

uint64_t relocateAccel(const ContextPtr& context, void* stream, const bvh::RelocationInfo& info,
                       void* block, const uint64_t* children, size_t count,
                       std::vector<const void*> arrays) {
    return context->backend->relocateAccel(context, stream, info, block, children, count,
                                           std::move(arrays));
}

uint64_t transformHandle(const void* transform, TransformType type) {
    return devlib::makeHandle(transform, type == TransformType::kStatic ? devlib::kTagStatic
                                         : type == TransformType::kMatrixMotion
                                             ? devlib::kTagMatrixMotion
                                             : devlib::kTagSrtMotion);
}

} // namespace sunstone::engine
