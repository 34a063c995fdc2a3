// SPDX-License-Identifier: Apache-2.0
// A client built for CUDA 12 on libcudart.so.12: structs and prototypes of that version, declared
// here, with checks that the library writes no byte beyond their ends. Exits with the number of
// failures.
#include "api/cuda/runtime12/device_properties.h"

#include <cstdio>
#include <cstring>

using sunstone::cudart::DeviceProperties12;

namespace cuda12 {

struct PointerAttributes {
    int type, device;
    void *devicePointer, *hostPointer;
};

extern "C" {
int properties(DeviceProperties12*, int) asm("cudaGetDeviceProperties_v2");
int propertiesOf11(void*, int) asm("cudaGetDeviceProperties");
int pointerAttributes(PointerAttributes*, const void*) asm("cudaPointerGetAttributes");
int prefetch(const void*, size_t, int, void*) asm("cudaMemPrefetchAsync");
int advise(const void*, size_t, int, int) asm("cudaMemAdvise");
int getEdges(void*, void**, void**, size_t*) asm("cudaGraphGetEdges");
int addDependencies(void*, void* const*, void* const*, size_t) asm("cudaGraphAddDependencies");
int getDependencies(void*, void**, size_t*) asm("cudaGraphNodeGetDependencies");
int captureInfo(void*, int*, unsigned long long*, void**, void* const**,
                size_t*) asm("cudaStreamGetCaptureInfo_v2");
}

} // namespace cuda12

namespace {

int failures = 0;

void check(bool condition, const char* what) {
    if (condition)
        return;
    std::printf("failed: %s\n", what);
    ++failures;
}

// A value followed by bytes that must stay unchanged.
template <class T, size_t kSize = sizeof(T)>
struct Guarded {
    alignas(16) unsigned char bytes[kSize + 64];
    Guarded() { std::memset(bytes, 0xab, sizeof bytes); }
    T* get() { return reinterpret_cast<T*>(bytes); }
    bool intact() const {
        for (size_t i = kSize; i < sizeof bytes; ++i)
            if (bytes[i] != 0xab)
                return false;
        return true;
    }
};

void checkProperties() {
    Guarded<DeviceProperties12> guarded;
    check(cuda12::properties(guarded.get(), 0) == 0, "cudaGetDeviceProperties_v2");
    check(guarded.intact(), "cudaGetDeviceProperties_v2 writes 1032 bytes");
    const DeviceProperties12& p = *guarded.get();
    const auto attribute = [](cudaDeviceAttr name) {
        int value = -1;
        cudaDeviceGetAttribute(&value, name, 0);
        return value;
    };
    check(std::strlen(p.name) > 0 && p.totalGlobalMem > 0, "name and memory");
    check(p.clockRate == attribute(cudaDevAttrClockRate) && p.clockRate > 0, "clockRate");
    check(p.memoryClockRate == attribute(cudaDevAttrMemoryClockRate), "memoryClockRate");
    check(p.deviceOverlap == attribute(cudaDevAttrGpuOverlap), "deviceOverlap");
    check(p.totalConstMem == 65536, "totalConstMem, behind clockRate");
    check(p.multiProcessorCount == attribute(cudaDevAttrMultiProcessorCount), "processors");
    check(p.integrated == attribute(cudaDevAttrIntegrated), "integrated");
    check(p.maxTexture2D[0] == attribute(cudaDevAttrMaxTexture2DWidth), "maxTexture2D");
    check(p.memoryBusWidth == attribute(cudaDevAttrGlobalMemoryBusWidth), "memoryBusWidth");
    check(p.singleToDoublePrecisionPerfRatio ==
              attribute(cudaDevAttrSingleToDoublePrecisionPerfRatio),
          "singleToDoublePrecisionPerfRatio");
    check(p.cooperativeLaunch == attribute(cudaDevAttrCooperativeLaunch), "cooperativeLaunch");
    check(int(p.sharedMemPerBlockOptin) == attribute(cudaDevAttrMaxSharedMemoryPerBlockOptin),
          "sharedMemPerBlockOptin");
    check(int(p.sharedMemPerMultiprocessor) ==
                  attribute(cudaDevAttrMaxSharedMemoryPerMultiprocessor) &&
              p.regsPerMultiprocessor == attribute(cudaDevAttrMaxRegistersPerMultiprocessor) &&
              p.managedMemory == attribute(cudaDevAttrManagedMemory),
          "sharedMemPerMultiprocessor, where padding differs");
    check(p.memoryPoolsSupported == attribute(cudaDevAttrMemoryPoolsSupported) &&
              p.clusterLaunch == attribute(cudaDevAttrClusterLaunch),
          "memoryPoolsSupported");

    Guarded<char, sunstone::cudart::kPropertyBytes11> old;
    check(cuda12::propertiesOf11(old.get(), 0) == 0 && old.intact(), "cudaGetDeviceProperties");
    check(cuda12::properties(nullptr, 0) == cudaErrorInvalidValue, "null properties");
    check(cuda12::properties(guarded.get(), 7) == cudaErrorInvalidDevice, "no such device");
}

void checkMemory() {
    void* memory = nullptr;
    check(cudaMallocManaged(&memory, 4096) == 0, "cudaMallocManaged");
    Guarded<cuda12::PointerAttributes> attributes;
    check(cuda12::pointerAttributes(attributes.get(), memory) == 0, "cudaPointerGetAttributes");
    check(attributes.intact() && attributes.get()->devicePointer == memory,
          "cudaPointerGetAttributes writes 24 bytes");
    check(cuda12::advise(memory, 4096, cudaMemAdviseSetReadMostly, 0) == 0, "cudaMemAdvise");
    check(cuda12::advise(memory, 4096, cudaMemAdviseSetPreferredLocation, cudaCpuDeviceId) == 0,
          "cudaMemAdvise for the host");
    check(cuda12::advise(memory, 4096, cudaMemAdviseSetPreferredLocation, 7) ==
              cudaErrorInvalidDevice,
          "cudaMemAdvise for a device that does not exist");
    check(cuda12::prefetch(memory, 4096, cudaCpuDeviceId, nullptr) == 0, "cudaMemPrefetchAsync");
    check(cuda12::prefetch(memory, 0, 0, nullptr) == cudaErrorInvalidValue, "prefetch of nothing");
    check(cudaFree(memory) == 0, "cudaFree");
}

void checkGraphs() {
    cudaGraph_t graph = nullptr;
    cudaGraphNode_t nodes[2] = {};
    check(cudaGraphCreate(&graph, 0) == 0, "cudaGraphCreate");
    for (cudaGraphNode_t& node : nodes)
        check(cudaGraphAddEmptyNode(&node, graph, nullptr, 0) == 0, "cudaGraphAddEmptyNode");
    void* from[1] = {nodes[0]};
    void* to[1] = {nodes[1]};
    check(cuda12::addDependencies(graph, from, to, 1) == 0, "cudaGraphAddDependencies");
    void *starts[4] = {}, *ends[4] = {};
    size_t count = 4;
    check(cuda12::getEdges(graph, starts, ends, &count) == 0 && count == 1, "cudaGraphGetEdges");
    check(starts[0] == nodes[0] && ends[0] == nodes[1], "the edge");
    count = 4;
    check(cuda12::getDependencies(nodes[1], starts, &count) == 0 && count == 1,
          "cudaGraphNodeGetDependencies");
    check(cudaGraphDestroy(graph) == 0, "cudaGraphDestroy");

    cudaStream_t stream = nullptr;
    check(cudaStreamCreate(&stream) == 0, "cudaStreamCreate");
    check(cudaStreamBeginCapture(stream, cudaStreamCaptureModeRelaxed) == 0, "begin");
    int status = -1;
    unsigned long long id = 0;
    void* captured = nullptr;
    void* const* tips = nullptr;
    count = 77;
    check(cuda12::captureInfo(stream, &status, &id, &captured, &tips, &count) == 0 && status == 1 &&
              captured && count == 0,
          "cudaStreamGetCaptureInfo_v2");
    check(cudaStreamEndCapture(stream, &graph) == 0, "end");
    check(cudaGraphDestroy(graph) == 0 && cudaStreamDestroy(stream) == 0, "clean up");
}

} // namespace

int main() {
    int version = 0;
    check(cudaRuntimeGetVersion(&version) == 0 && version / 1000 == 12, "the version is 12");
    checkProperties();
    checkMemory();
    checkGraphs();
    return failures;
}
