// SPDX-License-Identifier: Apache-2.0
// Builds acceleration structures on a GPU: asynchronous, in the caller's stream, inside the
// caller's buffers. Inputs are those of the CPU's builder (bvh/build/build.h) with device
// addresses; only SbtInput::flags is a host address, read during the call. The kernels read the
// buffers when they run.
//
// The result is the block of layout.h, ready for traversal.h. Builds of the same input are equal
// byte for byte.
#pragma once

#include "bvh/build/build.h"
#include "bvh/gpu/build/staging.h"
#include "bvh/micromap/micromap_array.h"
#include "bvh/relocate.h"
#include "device/cuda/kernel_set.h"

#include <cstdint>
#include <initializer_list>
#include <mutex>
#include <string>
#include <vector>

namespace sunstone::bvh::gpu {

struct BuildJob;
struct BuildReport;
struct Uploads;

// The kernels in the context that is current at construction. The same context must be current in
// all calls. Thread-safe. A call compiles kernels that are not loaded (device/cuda/kernel_set.h).
class Builder {
public:
    // `code`: source of machine code; null: the driver compiles.
    explicit Builder(const device::cuda::Driver& driver,
                     device::cuda::MachineCodeSource* code = nullptr);
    ~Builder();
    Builder(const Builder&) = delete;
    Builder& operator=(const Builder&) = delete;

    // Upper bounds for any data of these counts. Reads no buffer. Throws Error(kInvalidValue) as
    // bvh::computeMemoryUsage.
    static MemoryUsage computeMemoryUsage(const BuildInputs& inputs, const BuildOptions& options);

    // Loads the kernels for such a build, for updates (if allowed), compaction, relocation, emitted
    // properties and arrays of micromaps, so that these calls only queue work. Throws as
    // computeMemoryUsage.
    void prepare(const BuildInputs& inputs, const BuildOptions& options) const;
    // Loads the kernels for builds of all kinds.
    void prepareAll() const { kernels_.prepareAll(); }
    // Call after the context was destroyed: the destructor then does not call the driver.
    void abandon();

    // Queues a build. temp and output must be 128-byte aligned and at least as large as
    // computeMemoryUsage requires, else throws Error(kInvalidValue). `known`: see known_handles.h;
    // instances with other children are inactive, and takeFailures() reports them.
    void build(CUstream stream, const BuildInputs& inputs, const BuildOptions& options,
               CUdeviceptr temp, size_t tempSize, CUdeviceptr output, size_t outputSize,
               uint64_t known = 0) const;

    // Queues an update of the structure in `output`, built with allowUpdate and perhaps compacted
    // and moved since: the tree stays, primitives are read again (bvh::update has the rules). temp
    // must have MemoryUsage::tempUpdate bytes. Throws Error(kInvalidValue) for invalid buffers and,
    // if the stream is idle, for a structure built from inputs of another shape. If the stream is
    // busy, kernels check the shape and leave such a structure unchanged, and takeFailures()
    // reports it.
    void update(CUstream stream, const BuildInputs& inputs, const BuildOptions& options,
                CUdeviceptr temp, size_t tempSize, CUdeviceptr output, size_t outputSize,
                uint64_t known = 0) const;

    // Queues a compacting copy of the block into a buffer of so many bytes (128-byte aligned). If
    // the block cannot be compacted into it, the copy is not written and takeFailures() reports the
    // block.
    void compact(CUstream stream, CUdeviceptr block, CUdeviceptr destination, size_t size) const;

    // Whether the stream is idle.
    bool isIdle(CUstream stream) const;

    // Queues the relocation of the copy at `block`: its instances get these handles, one each;
    // without handles they keep theirs. `known` as in build(). takeFailures() reports a copy that
    // does not match.
    void relocate(CUstream stream, const RelocationInfo& info, CUdeviceptr block,
                  CUdeviceptr children, size_t count, uint64_t known = 0) const;

    // Queues an emitted property: 8 bytes, or 6 floats for each motion key (lower, upper; inf, -inf
    // if empty).
    void emitCompactedSize(CUstream stream, CUdeviceptr block, CUdeviceptr to) const;
    void emitBounds(CUstream stream, CUdeviceptr block, CUdeviceptr to) const;

    // Queues the relocation of build input `input`'s opacity micromaps to `array`, a copy of the
    // array it was built with; takeFailures() reports an invalid `array`.
    void relocateMicromaps(CUstream stream, CUdeviceptr block, uint32_t input,
                           CUdeviceptr array) const;

    // Queues the build of an array of opacity micromaps; the input holds device addresses, except
    // for the histogram. `statesSize`: bytes at input.states that may be read. Throws
    // Error(kInvalidValue) as micromapArraySizes. Kernels find descriptions that do not fit the
    // histogram or exceed the states: takeFailures() reports them, and no array is made.
    void buildMicromapArray(CUstream stream, const MicromapArrayInput& input, uint64_t statesSize,
                            CUdeviceptr output, size_t outputSize) const;

    // Returns the failures of kernels that have run since the last call, as texts. Never waits.
    // Failures that leave a usable structure are remarks; if `remarks` is null, they are among the
    // failures.
    std::vector<std::string> takeFailures(std::vector<std::string>* remarks = nullptr) const;

    // For tests: builds of more references take the kernels of large ones.
    void setMostInBlock(uint32_t references) { mostInBlock_ = references; }

    // For measuring: called after each kernel of later builds is queued, with its name; null ends
    // it.
    void observe(void (*observer)(void* user, const char* kernel), void* user) {
        observer_ = observer;
        observerUser_ = user;
    }

    // The modules that a Builder loads, one for each kernel, as PTX.
    static std::vector<std::string> kernelTexts();

private:
    enum Kernel : uint32_t {
        kBegin,
        kReferences,
        kInstances,
        kLeftInstances,
        kMovingInstances,
        kMovingReferences,
        kShapes,
        kMovingShapes,
        kSplitMeasure,
        kSplitChoose,
        kSplitTry,
        kSplitCount,
        kSplitSum,
        kSplit,
        kSmallTree,
        kCodes,
        kSort,
        kClusters,
        kRadixTree,
        kCollapse,
        kRetry,
        kSubtrees,
        kArrange,
        kRecords,
        kShapeRecords,
        kMovingRecords,
        kMovingShapeRecords,
        kKeyBounds,
        kKeyFinish,
        kUpdateCheck,
        kUpdateRecords,
        kUpdateShapeRecords,
        kUpdateMovingRecords,
        kUpdateMovingShapeRecords,
        kLinks,
        kUpdateNodes,
        kUpdateMovingNodes,
        kMicromaps,
        kMicromapRefs,
        kMicromapStates,
        kMicromapFinish,
        kCompact,
        kEmit,
        kRelocate,
        kRelocateMicromaps,
        kKernelCount
    };
    static std::vector<device::cuda::KernelSource> kernelSources();
    static Kernel recordsOf(BlockType type, bool moves);
    static Kernel updateRecordsOf(BlockType type, bool moves);
    void check(CUresult result, const char* what) const;
    void launch(Kernel kernel, CUstream stream, uint32_t blocks, uint32_t threads, void** arguments,
                uint32_t sharedBytes = 0) const;
    void read(CUstream stream, void* to, CUdeviceptr from, size_t size) const;
    void checkUpdate(CUstream stream, CUdeviceptr output, size_t outputSize,
                     const std::vector<uint8_t>& expected, const BuildInputs& inputs) const;
    void launchOver(Kernel kernel, CUstream stream, uint32_t count, BuildJob& job) const;
    void queueReferences(CUstream stream, void** arguments, const BuildJob& job) const;
    void queueNodes(CUstream stream, void** arguments, const BuildJob& job) const;
    void queueKernels(CUstream stream, BuildJob& job, bool fast) const;
    void queueSmallTree(CUstream stream, BuildJob& job, bool fast) const;
    void queueTree(CUstream stream, BuildJob& job, bool fast) const;
    bool isSmall(uint32_t references, uint32_t nodes, bool fast) const;

    // Words to set before other kernels run.
    struct Fill {
        CUdeviceptr to;
        uint64_t bytes;
        uint8_t byte;
    };
    void begin(CUstream stream, const Uploads& uploads, CUdeviceptr output, CUdeviceptr temp,
               std::initializer_list<Fill> fills) const;
    void upload(CUstream stream, CUdeviceptr to, const void* from, size_t size) const;

    const device::cuda::Driver& driver_;
    mutable Staging staging_;
    mutable device::cuda::KernelSet kernels_;
    uint32_t multiprocessors_ = 1, sharedMemory_ = 0;
    uint32_t mostInBlock_;
    BuildReport* report_ = nullptr; // page-locked
    mutable std::mutex reportMutex_;
    mutable uint32_t failuresTold_ = 0;
    void (*observer_)(void*, const char*) = nullptr;
    void* observerUser_ = nullptr;
};

} // namespace sunstone::bvh::gpu
