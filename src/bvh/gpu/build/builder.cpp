// SPDX-License-Identifier: Apache-2.0
#include "bvh/gpu/build/builder.h"

#include "base/error.h"
#include "bvh/gpu/build/plan.h"
#include "bvh/gpu/kernels_ptx.h"
#include "bvh/micromap/micromap_binding.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <string>
#include <vector>

namespace sunstone::bvh::gpu {
namespace {

void requireBuffer(const char* name, CUdeviceptr buffer, size_t size, size_t needed) {
    if (buffer == 0 || buffer % kBlockAlignment != 0)
        fail(Code::kInvalidValue, name, " buffer at address ", buffer, ", it must be aligned to ",
             kBlockAlignment, " bytes");
    if (size < needed)
        fail(Code::kInvalidValue, name, " buffer has ", size, " bytes, the build needs ", needed);
}

// In the order of Kernel.
constexpr const char* kKernelNames[] = {"sunstone_begin",
                                        "sunstone_references",
                                        "sunstone_instances",
                                        "sunstone_left_instances",
                                        "sunstone_moving_instances",
                                        "sunstone_moving_references",
                                        "sunstone_shapes",
                                        "sunstone_moving_shapes",
                                        "sunstone_split_measure",
                                        "sunstone_split_choose",
                                        "sunstone_split_try",
                                        "sunstone_split_count",
                                        "sunstone_split_sum",
                                        "sunstone_split",
                                        "sunstone_small_tree",
                                        "sunstone_codes",
                                        "sunstone_sort",
                                        "sunstone_clusters",
                                        "sunstone_radix_tree",
                                        "sunstone_collapse",
                                        "sunstone_retry",
                                        "sunstone_subtrees",
                                        "sunstone_arrange",
                                        "sunstone_records",
                                        "sunstone_shape_records",
                                        "sunstone_moving_records",
                                        "sunstone_moving_shape_records",
                                        "sunstone_key_bounds",
                                        "sunstone_key_finish",
                                        "sunstone_update_check",
                                        "sunstone_update_records",
                                        "sunstone_update_shape_records",
                                        "sunstone_update_moving_records",
                                        "sunstone_update_moving_shape_records",
                                        "sunstone_links",
                                        "sunstone_update_nodes",
                                        "sunstone_update_moving_nodes",
                                        "sunstone_micromaps",
                                        "sunstone_micromap_refs",
                                        "sunstone_micromap_states",
                                        "sunstone_micromap_finish",
                                        "sunstone_compact",
                                        "sunstone_emit",
                                        "sunstone_relocate",
                                        "sunstone_relocate_micromaps"};

std::string describeFailure(uint64_t block, uint32_t failure) {
    const auto address = reinterpret_cast<const void*>(block);
    switch (failure) {
    case kTreeBroken:
        return message("the build into outputBuffer = ", address,
                       " came to a tree that cannot be; there is no acceleration structure "
                       "(an error in Sunstone, or something wrote into the buffers meanwhile)");
    case kNotThatStructure:
        return message("the update of outputBuffer = ", address,
                       " did nothing: there is no acceleration structure that was built with "
                       "ALLOW_UPDATE, these build flags and inputs of this shape");
    case kNoCopy:
        return message(
            "the relocation to targetAccel = ", address,
            " did nothing: the memory holds no copy of what the relocation info is from");
    case kNoChild:
        return message("the relocation to targetAccel = ", address,
                       " was given an instance handle that is no traversable whose memory is "
                       "allocated; such instances keep their children");
    case kNoMicromapArray:
        return message("the build or update of outputBuffer = ", address,
                       " found no opacity micromap array at opacityMicromapArray of a build input");
    case kMicromapsDoNotFit:
        return message("there is no opacity micromap array at buffers->output = ", address,
                       ": a description is not what the histogram counts, or leads beyond the "
                       "memory of inputBuffer");
    case kNotCompacted:
        return message("the compaction to outputBuffer = ", address,
                       " did nothing: inputHandle is no acceleration structure, or the buffer is "
                       "too small, or overlaps it");
    case kNoMicromapCopy:
        return message("the relocation to targetAccel = ", address,
                       " was given an opacity micromap array that is no copy of the one a build "
                       "input was built with; it keeps that");
    case kUnknownChild:
        return message("the build or update of outputBuffer = ", address,
                       " was given instances whose traversableHandle, or that of a transform they "
                       "lead to, is that of no acceleration structure whose memory is allocated; "
                       "they are never hit");
    default:
        return message("building into outputBuffer = ", address, " failed: ", failure);
    }
}

void setMotion(BuildJob& job, const MotionOptions& motion) {
    job.motionKeys = motion.keys;
    job.motionBegin = motion.begin;
    job.motionEnd = motion.end;
}

uint32_t blocksFor(uint32_t count, uint32_t threads, uint32_t most) {
    return std::clamp((count + threads - 1) / threads, 1u, most);
}

// Whether triangles become several references.
bool isSplit(uint32_t references, uint32_t primitives, BlockType type) {
    return references != primitives && type != BlockType::kShapes;
}

} // namespace

Builder::Builder(const device::cuda::Driver& driver, device::cuda::MachineCodeSource* code)
    : driver_(driver), staging_(driver), kernels_(driver, code, kernelSources()),
      mostInBlock_(kSmallMost) {
    CUdevice device = 0;
    check(driver_.ctxGetDevice(&device), "cuCtxGetDevice");
    const auto attribute = [&](CUdevice_attribute which) {
        int value = 0;
        check(driver_.deviceGetAttribute(&value, which, device), "cuDeviceGetAttribute");
        return uint32_t(std::max(value, 0));
    };
    multiprocessors_ = std::max(attribute(CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT), 1u);
    sharedMemory_ = attribute(CU_DEVICE_ATTRIBUTE_MAX_SHARED_MEMORY_PER_BLOCK_OPTIN);
    // All supported GPUs have unified addresses, so kernels use the host's pointer.
    void* report = nullptr;
    check(driver_.memAllocHost(&report, sizeof(BuildReport)), "cuMemAllocHost");
    report_ = new (report) BuildReport{};
}

Builder::~Builder() {
    if (report_)
        driver_.memFreeHost(report_);
}

void Builder::abandon() {
    staging_.abandon();
    kernels_.abandon();
    report_ = nullptr;
}

std::vector<device::cuda::KernelSource> Builder::kernelSources() {
    static_assert(std::size(kKernelNames) == kKernelCount);
    std::vector<device::cuda::KernelSource> sources;
    for (const char* name : kKernelNames)
        sources.push_back({name, name, [name] {
                               static const device::cuda::KernelTexts all(builderPtx());
                               return all.moduleOf(name);
                           }});
    return sources;
}

std::vector<std::string> Builder::kernelTexts() {
    std::vector<std::string> texts;
    for (const device::cuda::KernelSource& source : kernelSources())
        texts.push_back(source.text());
    return texts;
}

Builder::Kernel Builder::recordsOf(BlockType type, bool moves) {
    return type == BlockType::kShapes ? (moves ? kMovingShapeRecords : kShapeRecords)
                                      : (moves ? kMovingRecords : kRecords);
}

Builder::Kernel Builder::updateRecordsOf(BlockType type, bool moves) {
    return type == BlockType::kShapes ? (moves ? kUpdateMovingShapeRecords : kUpdateShapeRecords)
                                      : (moves ? kUpdateMovingRecords : kUpdateRecords);
}

void Builder::prepare(const BuildInputs& inputs, const BuildOptions& options) const {
    const Plan plan(inputs, options);
    const bool moves = plan.motion.keys > 1;
    std::vector<uint32_t> needed = {kBegin,          kCompact,           kEmit,
                                    kRelocate,       kRelocateMicromaps, kMicromapRefs,
                                    kMicromapStates, kMicromapFinish};
    const auto need = [&](std::initializer_list<uint32_t> kernels) {
        needed.insert(needed.end(), kernels);
    };
    need({recordsOf(plan.type, moves)}); // also of empty structures
    if (isSmall(plan.maxReferences, plan.maxWide, options.preferFastBuild))
        need({kSmallTree, kArrange});
    else
        need({kCodes, kSort, options.preferFastBuild ? kRadixTree : kClusters, kCollapse, kRetry,
              kSubtrees, kArrange});
    if (moves)
        need({kLinks, kUpdateMovingNodes, kKeyBounds, kKeyFinish});
    if (plan.micromaps)
        need({kMicromaps});
    const bool instances = plan.type == BlockType::kInstances;
    if (instances && moves)
        need({kMovingInstances});
    else if (instances)
        need({kInstances, kLeftInstances});
    else if (plan.type == BlockType::kShapes)
        need({moves ? kMovingShapes : kShapes});
    else
        need({moves ? kMovingReferences : kReferences});
    if (isSplit(plan.maxReferences, plan.numPrimitives, plan.type))
        need({kSplitMeasure, kSplitChoose, kSplitTry, kSplitCount, kSplitSum, kSplit});
    if (options.allowUpdate)
        need({kUpdateCheck, moves ? kUpdateMovingNodes : kUpdateNodes});
    if (options.allowUpdate && !instances)
        need({updateRecordsOf(plan.type, moves)});
    kernels_.prepare(needed);
}

std::vector<std::string> Builder::takeFailures(std::vector<std::string>* remarks) const {
    std::vector<std::string> texts;
    std::lock_guard lock(reportMutex_);
    for (;;) {
        const volatile BuildReport::Entry& entry =
            report_->entries[failuresTold_ % BuildReport::kEntries];
        const uint32_t number = entry.number;
        if (number <= failuresTold_)
            return texts;
        std::atomic_thread_fence(std::memory_order_acquire);
        const bool isRemark = remarks && entry.failure == kUnknownChild;
        (isRemark ? *remarks : texts).push_back(describeFailure(entry.block, entry.failure));
        failuresTold_ = number;
    }
}

void Builder::check(CUresult result, const char* what) const {
    device::cuda::check(driver_, result, what);
}

MemoryUsage Builder::computeMemoryUsage(const BuildInputs& inputs, const BuildOptions& options) {
    const Plan plan(inputs, options);
    return {plan.outputSize, plan.tempSize, options.allowUpdate ? UpdatePlan(plan).tempSize : 0};
}

// One kernel writes all words if they fit into its arguments; memory is in words of four bytes.
void Builder::begin(CUstream stream, const Uploads& uploads, CUdeviceptr output, CUdeviceptr temp,
                    std::initializer_list<Fill> fills) const {
    const auto wordsOf = [](uint64_t bytes) { return (bytes + 3) / 4; };
    const uint64_t first = wordsOf(uploads.output.size()), second = wordsOf(uploads.temp.size());
    if (first + second > BeginJob::kMostWords) {
        upload(stream, output, uploads.output.data(), uploads.output.size());
        upload(stream, temp, uploads.temp.data(), uploads.temp.size());
        for (const Fill& each : fills)
            if (each.bytes != 0)
                check(driver_.memsetD8Async(each.to, each.byte, each.bytes, stream),
                      "cuMemsetD8Async");
        return;
    }
    BeginJob job{};
    job.parts[0] = {output, first};
    job.parts[1] = {temp, second};
    std::memcpy(job.words, uploads.output.data(), uploads.output.size());
    std::memcpy(job.words + first, uploads.temp.data(), uploads.temp.size());
    uint64_t most = first + second;
    size_t number = 0;
    for (const Fill& each : fills) {
        job.fills[number++] = {each.to, wordsOf(each.bytes), each.byte * 0x01010101u};
        most = std::max(most, wordsOf(each.bytes));
    }
    void* arguments[] = {&job};
    launch(kBegin, stream, uint32_t(std::clamp<uint64_t>(most / 1024, 1, multiprocessors_ * 4)),
           256, arguments);
}

void Builder::upload(CUstream stream, CUdeviceptr to, const void* from, size_t size) const {
    check(staging_.copy(stream, to, from, size), "cuMemcpyHtoDAsync");
}

bool Builder::isIdle(CUstream stream) const {
    return device::cuda::isIdle(driver_, stream);
}

void Builder::launch(Kernel kernel, CUstream stream, uint32_t blocks, uint32_t threads,
                     void** arguments, uint32_t sharedBytes) const {
    const CUfunction function = kernels_.function(kernel);
    if (sharedBytes != 0)
        check(driver_.funcSetAttribute(function, CU_FUNC_ATTRIBUTE_MAX_DYNAMIC_SHARED_SIZE_BYTES,
                                       int(sharedBytes)),
              "cuFuncSetAttribute");
    check(driver_.launchKernel(function, blocks, 1, 1, threads, 1, 1, sharedBytes, stream,
                               arguments, nullptr),
          kKernelNames[kernel]);
    if (observer_)
        observer_(observerUser_, kKernelNames[kernel]);
}

void Builder::build(CUstream stream, const BuildInputs& inputs, const BuildOptions& options,
                    CUdeviceptr temp, size_t tempSize, CUdeviceptr output, size_t outputSize,
                    uint64_t known) const {
    const Plan plan(inputs, options);
    requireBuffer("temp", temp, tempSize, plan.tempSize);
    requireBuffer("output", output, outputSize, plan.outputSize);
    const auto addressOf = [&](Plan::Place p) { return (p.inOutput ? output : temp) + p.offset; };
    const Uploads uploads(inputs, options, plan, temp + plan.inputs);
    const bool small = isSmall(plan.maxReferences, plan.maxWide,
                               options.preferFastBuild); // the block sets words that only it reads
    const uint64_t word = sizeof(uint32_t);
    begin(
        stream, uploads, output, temp + plan.inputs,
        {{temp + plan.counters, plan.tasks - plan.counters, 0},
         {temp + plan.tasks, small ? 0 : plan.origins.offset - plan.tasks, 0xFF},
         {addressOf(plan.parents), !small && plan.maySplit() ? plan.maxReferences * word : 0, 0xFF},
         {output + plan.table, plan.table ? plan.numPrimitives * word : 0, 0xFF}});
    if (plan.micromaps)
        upload(stream, output + plan.micromaps, uploads.micromaps.data(),
               uploads.micromaps.size() * sizeof(MicromapRecord));
    BuildJob job{};
    job.known = known;
    job.output = output;
    job.inputRecords = output + sizeof(BlockHeader);
    job.table = plan.table ? output + plan.table : 0;
    job.instances = output + plan.instances;
    job.records = output + plan.records;
    job.nodes = output + plan.nodes;
    job.inputs = temp + plan.inputs;
    job.counters = temp + plan.counters;
    job.boxes = temp + plan.boxes;
    for (int i = 0; i < 2; ++i) {
        job.keys[i] = addressOf(plan.keys[i]);
        job.values[i] = addressOf(plan.values[i]);
    }
    job.tileStates = temp + plan.tileStates;
    job.binary = addressOf(plan.binary);
    job.parents = addressOf(plan.parents);
    job.tasks = temp + plan.tasks;
    job.order = addressOf(plan.order);
    job.links = temp + plan.links;
    job.newNodes = temp + plan.newNodes;
    job.newOrder = temp + plan.newOrder;
    std::copy(std::begin(plan.gaps), std::end(plan.gaps), job.gaps);
    job.savings = addressOf(plan.savings);
    job.report = bvh::gpu::addressOf(report_);
    job.numInputs = plan.numInputs;
    job.numPrimitives = plan.numPrimitives;
    job.maxReferences = plan.maxReferences;
    job.origins = addressOf(plan.origins);
    job.maxWide = plan.maxWide;
    job.type = plan.type;
    job.primitiveCost = 0.3f;
    job.keepInactive = options.allowUpdate;
    setMotion(job, plan.motion);
    if (job.motionKeys > 1) {
        job.keyWords = temp + plan.keyWords;
        job.arrivals = temp + plan.arrivals;
        job.keyBoxes = temp + plan.keyBoxes;
        job.nodeBoxes = temp + plan.nodeBoxes;
    }
    job.points = plan.points ? output + plan.points : 0;
    job.shape = plan.shape;
    job.pieces = plan.pieces;
    if (plan.micromaps)
        launchOver(kMicromaps, stream, plan.numPrimitives, job);
    queueKernels(stream, job, options.preferFastBuild);
}

void Builder::launchOver(Kernel kernel, CUstream stream, uint32_t count, BuildJob& job) const {
    void* arguments[] = {&job};
    launch(kernel, stream, blocksFor(count, 256, multiprocessors_ * 8), 256, arguments);
}

void Builder::buildMicromapArray(CUstream stream, const MicromapArrayInput& input,
                                 uint64_t statesSize, CUdeviceptr output, size_t outputSize) const {
    MicromapArrayLayout layout = micromapArrayLayout(input.histogram);
    requireBuffer("output", output, outputSize, layout.usedSize);
    MicromapJob job{};
    job.report = addressOf(report_);
    job.output = output;
    job.states = addressOf(input.states);
    job.statesSize = statesSize;
    job.descriptions = addressOf(input.descriptions);
    job.descriptionStride =
        input.descriptionStride ? input.descriptionStride : uint32_t(sizeof(MicromapDesc));
    job.refsOffset = layout.refsOffset;
    job.dataOffset = layout.dataOffset;
    job.usedSize = layout.usedSize;
    job.numMicromaps = uint32_t(layout.numMicromaps);
    static_assert(kMicromapLevels == kMaxMicromapLevel + 1);
    for (uint32_t level = 0; level < kMicromapLevels; ++level) {
        job.counts[level] = uint32_t(layout.counts.at(level, MicromapFormat::kTwoState));
        job.counts[kMicromapLevels + level] =
            uint32_t(layout.counts.at(level, MicromapFormat::kFourState));
    }
    check(driver_.memsetD8Async(output, 0, layout.usedSize, stream), "cuMemsetD8Async");
    void* arguments[] = {&job};
    launch(kMicromapRefs, stream, 1, kSortThreads, arguments);
    if (job.numMicromaps)
        launch(kMicromapStates, stream, blocksFor(job.numMicromaps, 8, multiprocessors_ * 8), 256,
               arguments);
    launch(kMicromapFinish, stream, 1, 1, arguments);
}

void Builder::relocateMicromaps(CUstream stream, CUdeviceptr block, uint32_t input,
                                CUdeviceptr array) const {
    uint64_t report = addressOf(report_);
    void* arguments[] = {&block, &report, &input, &array};
    launch(kRelocateMicromaps, stream, 1, 1, arguments);
}

bool Builder::isSmall(uint32_t references, uint32_t nodes, bool fast) const {
    return references <= std::min(mostInBlock_, fast ? kSmallMost : kSmallMostClustered) &&
           nodes <= kSmallMostNodes;
}

void Builder::queueKernels(CUstream stream, BuildJob& job, bool fast) const {
    void* arguments[] = {&job};
    const uint32_t n = job.maxReferences, most = multiprocessors_ * 8;
    const bool moves = job.motionKeys > 1;
    if (n != 0) {
        queueReferences(stream, arguments, job);
        if (isSplit(n, job.numPrimitives, job.type)) {
            const uint32_t blocks = blocksFor(job.numPrimitives, 256, ~0u);
            launch(kSplitMeasure, stream, std::min(blocks, most), 256, arguments);
            launch(kSplitChoose, stream, 1, kSplitBins / 8, arguments);
            launch(kSplitTry, stream, std::min(blocks, most), 256, arguments);
            launch(kSplitCount, stream, blocks, 256, arguments);
            launch(kSplitSum, stream, 1, 256, arguments);
            launch(kSplit, stream, blocks, 256, arguments);
        }
        if (isSmall(n, job.maxWide, fast))
            queueSmallTree(stream, job, fast);
        else
            queueTree(stream, job, fast);
        launchOver(kArrange, stream, job.maxWide, job);
    }
    launch(recordsOf(job.type, moves), stream, blocksFor(n, 256, most * 4), 256, arguments);
    if (moves) { // so far it has only boxes of the means
        launch(kLinks, stream, blocksFor(job.maxWide, 256, most), 256, arguments);
        queueNodes(stream, arguments, job);
    }
}

void Builder::queueSmallTree(CUstream stream, BuildJob& job, bool fast) const {
    TreeMode mode = fast ? kRadix : kClustered;
    constexpr uint32_t kOther = 20 << 10; // statically allocated shared memory, at most
    uint32_t shared = uint32_t(std::min<uint64_t>(smallTreeBytes(job.maxReferences, job.maxWide),
                                                  sharedMemory_ - std::min(sharedMemory_, kOther)));
    void* arguments[] = {&job, &mode, &shared};
    launch(kSmallTree, stream, 1, kSmallThreads, arguments, shared);
}

void Builder::queueTree(CUstream stream, BuildJob& job, bool fast) const {
    void* arguments[] = {&job};
    const uint32_t n = job.maxReferences, most = multiprocessors_ * 8;
    // Each block adds all of its digit counts to the global counts.
    launch(kCodes, stream, blocksFor(n, 512, multiprocessors_ * 2), 512, arguments);
    for (uint32_t pass = 0; pass < kSortPasses; ++pass) {
        void* passArguments[] = {&job, &pass};
        launch(kSort, stream, (n + kSortTile - 1) / kSortTile, kSortThreads, passArguments);
    }
    TreeMode mode = fast ? kRadix : kClustered;
    void* treeArguments[] = {&job, &mode};
    launch(fast ? kRadixTree : kClusters, stream, (n + 127) / 128, 128, arguments);
    launch(kCollapse, stream, blocksFor(n, 64, most), 128, treeArguments);
    launch(kRetry, stream, blocksFor(n, 64, multiprocessors_ * 4), 128, arguments);
    launchOver(kSubtrees, stream, job.maxWide, job);
}

void Builder::queueReferences(CUstream stream, void** arguments, const BuildJob& job) const {
    const uint32_t blocks = blocksFor(job.numPrimitives, 256, multiprocessors_ * 8);
    const bool moves = job.motionKeys > 1;
    switch (job.type) {
    case BlockType::kInstances:
        if (moves)
            return launch(kMovingInstances, stream, std::min(blocks, multiprocessors_ * 2), 256,
                          arguments);
        launch(kInstances, stream, blocksFor(job.numPrimitives, 128, multiprocessors_ * 16), 128,
               arguments);
        // In most scenes this kernel has no instances.
        return launch(kLeftInstances, stream, std::min(blocks, multiprocessors_ * 2), 256,
                      arguments);
    case BlockType::kShapes:
        return launch(moves ? kMovingShapes : kShapes, stream, blocks, 256, arguments);
    default:
        return launch(moves ? kMovingReferences : kReferences, stream, blocks, 256, arguments);
    }
}

// From records to boxes of nodes, and with motion to the bounds at the keys.
void Builder::queueNodes(CUstream stream, void** arguments, const BuildJob& job) const {
    const uint32_t most = multiprocessors_ * 8;
    launch(job.motionKeys > 1 ? kUpdateMovingNodes : kUpdateNodes, stream,
           blocksFor(job.maxWide, 256 / 8, most * 8), 256, arguments);
    if (job.motionKeys > 1) {
        const uint32_t blocks = blocksFor(job.maxReferences, 256, most);
        launch(kKeyBounds, stream, std::max(blocks / job.motionKeys, 1u) * job.motionKeys, 256,
               arguments);
        launch(kKeyFinish, stream, 1, 256, arguments);
    }
}

// Waits only for this stream.
void Builder::read(CUstream stream, void* to, CUdeviceptr from, size_t size) const {
    check(driver_.memcpyDtoHAsync(to, from, size, stream), "cuMemcpyDtoHAsync");
    check(driver_.streamSynchronize(stream), "cuStreamSynchronize");
}

void Builder::checkUpdate(CUstream stream, CUdeviceptr output, size_t outputSize,
                          const std::vector<uint8_t>& expected, const BuildInputs& inputs) const {
    std::vector<uint8_t> found(expected.size());
    read(stream, found.data(), output, found.size());
    const auto& is = *reinterpret_cast<const BlockHeader*>(found.data());
    const auto& wanted = *reinterpret_cast<const BlockHeader*>(expected.data());
    if (is.magic != kGpuBlockMagic || is.version != kBlockVersion ||
        is.inputsOffset != wanted.inputsOffset)
        fail(Code::kInvalidValue,
             "an update needs an acceleration structure in the output buffer at ",
             reinterpret_cast<const void*>(output));
    checkSameShape(is, wanted);
    requireBuffer("output", output, outputSize, is.usedSize);
    checkSameInputs({reinterpret_cast<const InputRecord*>(expected.data() + sizeof(BlockHeader)),
                     wanted.numInputs},
                    reinterpret_cast<const InputRecord*>(found.data() + sizeof(BlockHeader)));
    std::vector<MicromapRecord> micromaps(is.micromapsOffset ? is.numInputs : 0);
    if (!micromaps.empty())
        read(stream, micromaps.data(), output + is.micromapsOffset,
             micromaps.size() * sizeof(MicromapRecord));
    checkMicromapUpdate(micromaps.empty() ? nullptr : micromaps.data(),
                        is.options & kOptionMicromapUpdate, inputs.triangles);
}

void Builder::update(CUstream stream, const BuildInputs& inputs, const BuildOptions& options,
                     CUdeviceptr temp, size_t tempSize, CUdeviceptr output, size_t outputSize,
                     uint64_t known) const {
    const Plan plan(inputs, options);
    const UpdatePlan places(plan);
    requireBuffer("temp", temp, tempSize, places.tempSize);
    const Uploads uploads(inputs, options, plan, temp + places.inputs);
    requireBuffer("output", output, outputSize, uploads.output.size());
    if (isIdle(stream))
        checkUpdate(stream, output, outputSize, uploads.output, inputs);
    begin(stream, uploads, temp + places.expected, temp + places.inputs,
          {{temp + places.counters, places.expected - places.counters, 0}});
    BuildJob job{};
    job.report = addressOf(report_);
    job.known = known;
    job.output = output;
    job.outputSize = outputSize;
    job.expected = temp + places.expected;
    job.inputs = temp + places.inputs;
    job.counters = temp + places.counters;
    job.arrivals = temp + places.arrivals;
    job.parents = temp + places.parents;
    job.nodeBoxes = temp + places.nodeBoxes;
    job.boxes = temp + places.boxes;
    job.numInputs = plan.numInputs;
    job.numPrimitives = plan.numPrimitives;
    job.maxReferences = plan.maxReferences;
    job.maxWide = plan.maxWide;
    job.type = plan.type;
    job.keepInactive = 1;
    setMotion(job, plan.motion);
    job.keyWords = temp + places.keyWords;
    job.keyBoxes = temp + places.keyBoxes;
    void* arguments[] = {&job};
    const uint32_t most = multiprocessors_ * 8;
    launch(kUpdateCheck, stream, 1, 256, arguments);
    if (plan.micromaps && options.allowMicromapUpdate)
        launchOver(kMicromaps, stream, plan.numPrimitives, job);
    if (plan.numPrimitives != 0) {
        if (job.type == BlockType::kInstances)
            queueReferences(stream, arguments, job);
        else
            launch(updateRecordsOf(job.type, job.motionKeys > 1), stream,
                   blocksFor(plan.maxReferences, 256, most), 256, arguments);
    }
    queueNodes(stream, arguments, job);
}

void Builder::compact(CUstream stream, CUdeviceptr block, CUdeviceptr destination,
                      size_t size) const {
    requireBuffer("destination", destination, 0, 0);
    uint64_t from = block, to = destination, bytes = size, report = addressOf(report_);
    void* arguments[] = {&from, &to, &bytes, &report};
    launch(kCompact, stream, multiprocessors_ * 8, 256, arguments);
}

void Builder::relocate(CUstream stream, const RelocationInfo& info, CUdeviceptr block,
                       CUdeviceptr children, size_t count, uint64_t known) const {
    requireBuffer("target", block, 0, 0);
    RelocateJob job{};
    job.block = block;
    job.report = CUdeviceptr(report_);
    job.children = children;
    job.known = known;
    job.usedSize = relocatedSize(info);
    job.numChildren = uint32_t(count);
    job.version = kBlockVersion;
    job.numPrimitives = relocatedPrimitives(info);
    job.type = relocatedType(info);
    void* arguments[] = {&job};
    launch(kRelocate, stream, blocksFor(job.numChildren, 256, multiprocessors_ * 8), 256,
           arguments);
}

void Builder::emitCompactedSize(CUstream stream, CUdeviceptr block, CUdeviceptr to) const {
    uint64_t from = block, address = to;
    uint32_t what = 1;
    void* arguments[] = {&from, &address, &what};
    launch(kEmit, stream, 1, 1, arguments);
}

void Builder::emitBounds(CUstream stream, CUdeviceptr block, CUdeviceptr to) const {
    uint64_t from = block, address = to;
    uint32_t what = 2;
    void* arguments[] = {&from, &address, &what};
    launch(kEmit, stream, 1, 1, arguments);
}

} // namespace sunstone::bvh::gpu
