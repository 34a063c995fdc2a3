// SPDX-License-Identifier: Apache-2.0
// Arrays of opacity micromaps on a GPU: kernels of src/bvh/gpu in the caller's stream. An array
// holds no addresses; relocation only checks that it is a copy.
#include "base/error.h"
#include "engine/gpu/backend.h"
#include "engine/micromap.h"

#include <cstdint>

namespace sunstone::engine {

using namespace device::cuda;

namespace {

// Bytes from an address to the end of its allocation; for memory of other kinds the driver reports
// no range.
uint64_t bytesFrom(const void* address) {
    CUdeviceptr base = 0;
    size_t bytes = 0;
    const auto place = CUdeviceptr(address);
    if (driver().memGetAddressRange(&base, &bytes, place) != CUDA_SUCCESS)
        return UINT64_MAX >> 1;
    return base + bytes - place;
}

// The header of the array, after the stream's earlier work.
bvh::MicromapArrayHeader readHeader(GpuDevice& device, CUstream stream, const void* array,
                                    const char* parameter) {
    bvh::MicromapArrayHeader header{};
    if (uintptr_t(array) % bvh::kMicromapArrayAlignment != 0 ||
        !device.isAccessible(array, sizeof(header)))
        fail(Code::kInvalidValue, parameter, " = ", array, " is no opacity micromap array");
    SUNSTONE_CU(memcpyDtoHAsync, &header, CUdeviceptr(array), sizeof(header), stream);
    SUNSTONE_CU(streamSynchronize, stream);
    if (!bvh::looksLikeMicromapArray(&header))
        fail(Code::kInvalidValue, parameter, " = ", array, " is no opacity micromap array");
    return header;
}

} // namespace

void GpuBackend::buildMicromapArray(const ContextPtr& context, MicromapArrayBuild request) {
    ContextScope scope(device_.context());
    tellOfBuilds(*context);
    const bvh::MicromapArrayInput input{request.histogram, request.states, request.descriptions,
                                        request.descriptionStride};
    builder().buildMicromapArray(CUstream(request.stream), input, bytesFrom(request.states),
                                 CUdeviceptr(request.output), request.outputSize);
}

bvh::RelocationInfo GpuBackend::micromapRelocationInfo(const ContextPtr&, const void* array) {
    ContextScope scope(device_.context());
    SUNSTONE_CU(ctxSynchronize);
    const bvh::MicromapArrayHeader header =
        readHeader(device_, nullptr, array, "opacityMicromapArray");
    return bvh::micromapRelocationInfo(&header);
}

// As on the CPU the memory must hold a copy; the call waits for the stream to check it.
void GpuBackend::relocateMicromapArray(const ContextPtr&, void* stream,
                                       const bvh::RelocationInfo& info, void* array) {
    ContextScope scope(device_.context());
    const bvh::MicromapArrayHeader header =
        readHeader(device_, CUstream(stream), array, "targetOpacityMicromapArray");
    bvh::requireCopy(info, bvh::micromapRelocationInfo(&header), array);
}

} // namespace sunstone::engine
