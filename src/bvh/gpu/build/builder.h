// SPDX-License-Identifier: Apache-2.0
// Builds acceleration structures on a GPU: asynchronous, in the caller's stream, inside the
// caller's buffers. The inputs are those of the CPU's builder (bvh/build/build.h) but all pointers in
// them are device addresses, except SbtInput::flags, which is read during the call. Contents of
// buffers are read when the kernels run.
//
// The result is the block of layout.h, ready for traversal.h; its header says what it holds. Builds
// of the same input are equal byte for byte.
#pragma once

#include "bvh/build/build.h"
#include "bvh/gpu/build/staging.h"
#include "bvh/micromap/micromap_array.h"
#include "bvh/relocate.h"
#include "device/cuda/kernel_set.h"

#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

namespace sunstone::bvh::gpu {

struct BuildJob;
struct BuildReport;

// The kernels, in the context that is current when it is made. Calls must be made with the same
// context current; they may come from any thread. A call that needs kernels that are not there has
// them made (device/cuda/kernel_set.h).
class Builder {
public:
    // `code`: where machine code comes from; null: the driver compiles.
    explicit Builder(const device::cuda::Driver& driver,
                     device::cuda::MachineCodeSource* code = nullptr);
    ~Builder();
    Builder(const Builder&) = delete;
    Builder& operator=(const Builder&) = delete;

    // Upper bounds for any data of these counts. Reads no buffer. Throws Error(kInvalidValue) as
    // bvh::computeMemoryUsage.
    static MemoryUsage computeMemoryUsage(const BuildInputs& inputs, const BuildOptions& options);

    // Makes the kernels ready that such a build needs, what follows it (updates, if it allows them,
    // compaction, relocation, what it reports) and arrays of micromaps: so that these calls only
    // queue. Throws as computeMemoryUsage.
    void prepare(const BuildInputs& inputs, const BuildOptions& options) const;

    // Queues a build. temp and output: 128-byte aligned, at least as large as computeMemoryUsage
    // says. Throws Error(kInvalidValue) otherwise. `known`: see known_handles.h; instances with
    // other children are inactive, and takeFailures() tells of them.
    void build(CUstream stream, const BuildInputs& inputs, const BuildOptions& options,
               CUdeviceptr temp, size_t tempSize, CUdeviceptr output, size_t outputSize,
               uint64_t known = 0) const;

    // Queues an update of the structure in `output`, built with allowUpdate and perhaps compacted
    // and moved since: the tree stays, primitives are read anew (bvh::update has the rules). temp
    // must have MemoryUsage::tempUpdate bytes. Throws Error(kInvalidValue) for buffers; and for a
    // structure that was built from inputs of another shape, if the stream has nothing left to do
    // so that the structure can be looked at. Otherwise kernels look, leave such a structure as it
    // is, and takeFailures() tells of it.
    void update(CUstream stream, const BuildInputs& inputs, const BuildOptions& options,
                CUdeviceptr temp, size_t tempSize, CUdeviceptr output, size_t outputSize,
                uint64_t known = 0) const;

    // Queues a compacting copy of the block into so many bytes (128-byte aligned). takeFailures()
    // tells of a block that cannot be compacted, or not to there; nothing is written then.
    void compact(CUstream stream, CUdeviceptr block, CUdeviceptr destination, size_t size) const;

    // Whether the stream has nothing left to do, so that waiting for it takes no time.
    bool isIdle(CUstream stream) const;

    // Queues the relocation of the copy at `block`: its instances get these handles, one each;
    // none: they keep theirs. `known` as in build(). What is wrong with the copy takeFailures() tells.
    void relocate(CUstream stream, const RelocationInfo& info, CUdeviceptr block,
                  CUdeviceptr children, size_t count, uint64_t known = 0) const;

    // Queues what a build reports: 8 bytes, or 6 floats for each motion key (lower, upper; inf,
    // -inf if there is nothing).
    void emitCompactedSize(CUstream stream, CUdeviceptr block, CUdeviceptr to) const;
    void emitBounds(CUstream stream, CUdeviceptr block, CUdeviceptr to) const;

    // Queues that build input `input` of a relocated structure finds its opacity micromaps in
    // `array`, a copy of the array it was built with; takeFailures() tells of what is none.
    void relocateMicromaps(CUstream stream, CUdeviceptr block, uint32_t input,
                           CUdeviceptr array) const;

    // Queues the build of an array of opacity micromaps; device addresses in the input, but for the
    // histogram. `statesSize`: bytes at input.states that may be read. Throws Error(kInvalidValue)
    // as micromapArraySizes. Descriptions that do not fit the histogram or lead beyond the states
    // are found by kernels: takeFailures() tells, and there is no array.
    void buildMicromapArray(CUstream stream, const MicromapArrayInput& input, uint64_t statesSize,
                            CUdeviceptr output, size_t outputSize) const;

    // What kernels of builds that have run meanwhile could not do, in words; each is told once.
    // Never waits. Where what was built is as good as its inputs, they are remarks; without a place
    // for those they are among the others.
    std::vector<std::string> takeFailures(std::vector<std::string>* remarks = nullptr) const;

    // For measuring: called after each kernel of later builds is queued, with its name; null ends
    // it.
    void observe(void (*observer)(void* user, const char* kernel), void* user) {
        observer_ = observer;
        observerUser_ = user;
    }

    // The modules that it loads, one for each kernel, as PTX.
    static std::vector<std::string> kernelTexts();

private:
    enum Kernel : uint32_t {
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
    void launch(Kernel kernel, CUstream stream, uint32_t blocks, uint32_t threads,
                void** arguments) const;
    void read(CUstream stream, void* to, CUdeviceptr from, size_t size) const;
    void checkUpdate(CUstream stream, CUdeviceptr output, size_t outputSize,
                     const std::vector<uint8_t>& expected, const BuildInputs& inputs) const;
    void launchOver(Kernel kernel, CUstream stream, uint32_t count, BuildJob& job) const;
    void queueReferences(CUstream stream, void** arguments, const BuildJob& job) const;
    void queueNodes(CUstream stream, void** arguments, const BuildJob& job) const;
    void queueKernels(CUstream stream, BuildJob& job, bool fast) const;

    void upload(CUstream stream, CUdeviceptr to, const void* from, size_t size) const;

    const device::cuda::Driver& driver_;
    mutable Staging staging_;
    mutable device::cuda::KernelSet kernels_;
    uint32_t multiprocessors_ = 1;
    BuildReport* report_ = nullptr; // page-locked
    mutable std::mutex reportMutex_;
    mutable uint32_t failuresTold_ = 0;
    void (*observer_)(void*, const char*) = nullptr;
    void* observerUser_ = nullptr;
};

} // namespace sunstone::bvh::gpu
