// SPDX-License-Identifier: Apache-2.0
// Acceleration structures on a GPU: kernels of src/bvh/gpu in the caller's stream.
#include "engine/accel.h"
#include "base/error.h"
#include "bvh/gpu/batch/batches.h"
#include "bvh/gpu/layout.h"
#include "engine/gpu/backend.h"

#include <cstddef>
#include <vector>

namespace sunstone::engine {

using namespace device::cuda;

namespace {

// Instances in host memory: their rules are checked there, after the stream's earlier work.
struct HostInstances {
    bvh::InstanceInput input;
    std::vector<bvh::InstanceDesc> copies;
    std::vector<uint64_t> pointers;

    HostInstances(const bvh::InstanceInput& given, CUstream stream) : input(given) {
        const auto read = [stream](void* to, const void* from, size_t size) {
            SUNSTONE_CU(memcpyDtoHAsync, to, CUdeviceptr(from), size, stream);
        };
        const size_t count = given.numInstances, size = sizeof(bvh::InstanceDesc);
        copies.resize(count);
        if (given.instances) {
            const size_t stride = given.stride ? given.stride : size;
            for (size_t i = 0; i < count; ++i)
                read(&copies[i], static_cast<const std::byte*>(given.instances) + i * stride, size);
            input.instances = copies.data();
            input.stride = 0;
        } else {
            pointers.resize(count);
            read(pointers.data(), given.instancePointers, count * sizeof(uint64_t));
            SUNSTONE_CU(streamSynchronize, stream);
            for (size_t i = 0; i < count; ++i) {
                if (pointers[i] % InstanceRules::kAlignment != 0)
                    continue; // broken by its address alone
                read(&copies[i], reinterpret_cast<const void*>(pointers[i]), size);
                pointers[i] = reinterpret_cast<uint64_t>(&copies[i]);
            }
            input.instancePointers = pointers.data();
        }
        SUNSTONE_CU(streamSynchronize, stream);
    }
};

} // namespace

const bvh::gpu::Builder& GpuBackend::builder() {
    std::call_once(builderMade_,
                   [&] { builder_ = std::make_unique<bvh::gpu::Builder>(driver(), &kernelCode_); });
    return *builder_;
}

void GpuBackend::prepareKernels() {
    ContextScope scope(device_.context());
    builder().prepareAll();
    denoiser().prepareAll();
    bvh::gpu::Batches(driver(), &kernelCode_).prepareAll();
}

bvh::MemoryUsage GpuBackend::accelMemory(const bvh::BuildInputs& inputs,
                                         const bvh::BuildOptions& options) {
    // The driver may wait for the GPU when it loads kernels; a build that is only queued must not.
    ContextScope scope(device_.context());
    builder().prepare(inputs, options);
    return bvh::gpu::Builder::computeMemoryUsage(inputs, options);
}

// Kernels cannot return errors; the context of the next call logs them.
void GpuBackend::tellOfBuilds(const Context& context) {
    if (!context.log)
        return;
    std::vector<std::string> remarks;
    for (const std::string& failure : builder().takeFailures(&remarks))
        context.log(LogLevel::kError, "ACCEL", failure);
    for (const std::string& remark : remarks)
        context.log(LogLevel::kWarning, "ACCEL", remark);
}

uint64_t GpuBackend::buildAccel(const ContextPtr& context, AccelBuild request) {
    ContextScope scope(device_.context());
    const auto stream = CUstream(request.stream);
    const auto output = CUdeviceptr(request.output);
    const bvh::BuildInputs inputs = request.inputs->view();
    if (request.rules && inputs.instances && context->log)
        warnOfBrokenRule(*context, HostInstances(*inputs.instances, stream).input, *request.rules);
    tellOfBuilds(*context);
    const uint64_t known =
        inputs.instances ? known_->update(GpuKnownHandles::kSome, 0, stream).known : 0;
    const auto run = request.update ? &bvh::gpu::Builder::update : &bvh::gpu::Builder::build;
    (builder().*run)(stream, inputs, request.options, CUdeviceptr(request.temp), request.tempSize,
                     output, request.outputSize, known);
    for (const AccelEmit& emit : request.emit) {
        const auto to = CUdeviceptr(emit.destination);
        if (emit.kind == AccelEmit::kCompactedSize)
            builder().emitCompactedSize(stream, output, to);
        else
            builder().emitBounds(stream, output, to);
    }
    const uint64_t handle =
        devlib::makeHandle(request.output, inputs.instances ? devlib::kTagIas : devlib::kTagGas);
    noteGpuHandle(handle, request.options.motion.keys > 1);
    return handle;
}

[[noreturn]] static void refuseHandle(uint64_t handle, const char* parameter) {
    fail(Code::kInvalidValue, parameter, " = ", reinterpret_cast<void*>(handle),
         " is no acceleration structure");
}

// Checks the handle itself, without the memory behind it.
void GpuBackend::requireStructure(uint64_t handle, const char* parameter) {
    const devlib::HandleTag tag = devlib::tagOf(handle);
    if ((tag != devlib::kTagGas && tag != devlib::kTagIas) ||
        !device_.isAccessible(reinterpret_cast<const void*>(devlib::addressOf(handle)),
                              sizeof(bvh::BlockHeader)))
        refuseHandle(handle, parameter);
}

// The header of the structure behind a caller's handle, read after the stream's queued work.
bvh::BlockHeader GpuBackend::headerOf(uint64_t handle, CUstream stream, const char* parameter) {
    requireStructure(handle, parameter);
    bvh::BlockHeader header;
    SUNSTONE_CU(memcpyDtoHAsync, &header, devlib::addressOf(handle), sizeof(header), stream);
    SUNSTONE_CU(streamSynchronize, stream);
    const bool instances = bvh::kindOf(header.type) == bvh::BlockType::kInstances;
    if (header.magic != bvh::gpu::kGpuBlockMagic ||
        instances != (devlib::tagOf(handle) == devlib::kTagIas))
        refuseHandle(handle, parameter);
    return header;
}

static void checkCompaction(const Context& context, const bvh::BlockHeader& header, uint64_t handle,
                            uint64_t to, size_t size) {
    const uint64_t source = devlib::addressOf(handle), used = header.usedSize;
    if (!(header.options & bvh::kOptionCompaction))
        tolerateCompaction(context, handle);
    if (size < used)
        fail(Code::kInvalidValue, "outputBufferSizeInBytes = ", size,
             " is less than the compacted size ", used);
    if (source < to + used && to < source + used)
        fail(Code::kInvalidValue, "outputBuffer = ", reinterpret_cast<void*>(to),
             " overlaps the structure that is compacted");
}

// An invalid structure or buffer is an error of this call if the stream is idle, and in validation
// mode; else the call does not wait, and the kernel finds it.
uint64_t GpuBackend::compactAccel(const ContextPtr& context, void* stream, uint64_t handle,
                                  void* destination, size_t destinationSize) {
    ContextScope scope(device_.context());
    const uint64_t source = devlib::addressOf(handle);
    const uint64_t to = uint64_t(destination);
    requireStructure(handle, "inputHandle");
    tellOfBuilds(*context);
    if (context->validation || builder().isIdle(CUstream(stream)))
        checkCompaction(*context, headerOf(handle, CUstream(stream), "inputHandle"), handle, to,
                        destinationSize);
    builder().compact(CUstream(stream), source, to, destinationSize);
    const uint64_t copy = devlib::makeHandle(destination, devlib::tagOf(handle));
    noteGpuHandle(copy);
    return copy;
}

bvh::RelocationInfo GpuBackend::relocationInfo(const ContextPtr&, uint64_t handle) {
    device_.synchronizeAll();
    ContextScope scope(device_.context());
    return bvh::relocationInfo(headerOf(handle, nullptr, "handle"));
}

uint64_t GpuBackend::relocateAccel(const ContextPtr& context, void* stream,
                                   const bvh::RelocationInfo& info, void* block,
                                   const uint64_t* children, size_t count,
                                   std::vector<const void*> arrays) {
    ContextScope scope(device_.context());
    tellOfBuilds(*context);
    const uint64_t known =
        children ? known_->update(GpuKnownHandles::kSome, 0, CUstream(stream)).known : 0;
    builder().relocate(CUstream(stream), info, CUdeviceptr(block), CUdeviceptr(children),
                       children ? count : 0, known);
    for (size_t i = 0; i < arrays.size(); ++i)
        if (arrays[i])
            builder().relocateMicromaps(CUstream(stream), CUdeviceptr(block), uint32_t(i),
                                        CUdeviceptr(arrays[i]));
    const uint64_t handle =
        devlib::makeHandle(block, bvh::holdsInstances(info) ? devlib::kTagIas : devlib::kTagGas);
    noteGpuHandle(handle, bvh::isMoving(bvh::relocatedType(info)));
    return handle;
}

} // namespace sunstone::engine
