// SPDX-License-Identifier: Apache-2.0
#include "bvh/gpu/builder.h"

#include "base/error.h"
#include "bvh/build_input.h"
#include "bvh/build_parts.h"
#include "bvh/gpu/job.h"
#include "bvh/gpu/kernels_ptx.h"
#include "bvh/presplit.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <string>
#include <vector>

namespace sunstone::bvh::gpu {
namespace {

// Device code and host code agree on this.
static_assert(sizeof(BuildJob) < 4096 && sizeof(Counters) % 16 == 0);

uint64_t addressOf(const void* pointer) {
    return reinterpret_cast<uint64_t>(pointer);
}

uint32_t vertexSize(VertexFormat format) {
    switch (format) {
    case VertexFormat::kFloat3:
        return 12;
    case VertexFormat::kFloat2:
        return 8;
    case VertexFormat::kHalf3:
    case VertexFormat::kSnorm16x3:
        return 6;
    default:
        return 4;
    }
}

void requireSupported(const BuildInputs& inputs, const BuildOptions& options) {
    if (!inputs.curves.empty() || !inputs.spheres.empty())
        fail(Code::kNotSupported, "curves and spheres on a GPU are not available yet");
    if (options.motion.keys > 1)
        fail(Code::kNotSupported, "motion keys on a GPU are not available yet");
    for (const TriangleInput& t : inputs.triangles)
        if (t.micromaps.indexing != MicromapIndexing::kNone)
            fail(Code::kNotSupported, "opacity micromaps on a GPU are not available yet");
}

// Counts and places of a build.
struct Plan {
    BlockType type;
    uint32_t numInputs = 1, numPrimitives = 0, maxReferences, maxWide, tiles;
    uint32_t numSbtRecords = 0;
    uint64_t table = 0, instances = 0, records, nodes, outputSize;
    // Scratch: places in the temp buffer, or in the output buffer where records will be.
    struct Place {
        uint64_t offset = 0;
        bool inOutput = false;
    };
    uint64_t inputs, flags, counters, tileStates, parents, tasks, boxes, tempSize;
    Place origins, keys[2], values[2], binary, costs, order;

    Plan(const BuildInputs& in, const BuildOptions& options) {
        requireSupported(in, options);
        const int kinds = !in.triangles.empty() + !in.customs.empty() + (in.instances != nullptr);
        if (kinds != 1)
            fail(Code::kInvalidValue,
                 "a build takes triangles, custom primitives or instances: got ", kinds, " kinds");
        type = !in.triangles.empty() ? BlockType::kTriangles
               : !in.customs.empty() ? BlockType::kCustom
                                     : BlockType::kInstances;
        if (type != BlockType::kInstances)
            numInputs = uint32_t(std::max(in.triangles.size(), in.customs.size()));
        count(in);
        countReferences(options);
        layOutOutput(options);
        layOutTemp();
    }

    const SbtInput& sbtOf(const BuildInputs& in, uint32_t i) const {
        return type == BlockType::kTriangles ? in.triangles[i].sbt : in.customs[i].sbt;
    }
    uint32_t countOf(const BuildInputs& in, uint32_t i) const {
        return type == BlockType::kTriangles ? triangleCount(in.triangles[i])
               : type == BlockType::kCustom  ? in.customs[i].numPrimitives
                                             : in.instances->numInstances;
    }

private:
    void count(const BuildInputs& in) {
        uint64_t total = 0, sbtRecords = 0;
        for (uint32_t i = 0; i < numInputs; ++i) {
            total += countOf(in, i);
            if (type == BlockType::kInstances)
                continue;
            if (sbtOf(in, i).numSbtRecords == 0)
                fail(Code::kInvalidValue, "build input ", i, " has no SBT record");
            sbtRecords += sbtOf(in, i).numSbtRecords;
        }
        if (sbtRecords > kSbtIndexMask + 1u)
            fail(Code::kInvalidValue, sbtRecords, " SBT records in one structure, the limit is ",
                 kSbtIndexMask + 1u);
        // References have 30 bits, and all ones mean none.
        if (total >= kMaxPrimitives)
            fail(Code::kInvalidValue, total, " primitives in one structure, the limit is ",
                 kMaxPrimitives - 1);
        numPrimitives = uint32_t(total);
        numSbtRecords = uint32_t(sbtRecords);
    }

    void countReferences(const BuildOptions& options) {
        // Updates need one place for each primitive; parts of a triangle may move apart.
        uint64_t total = numPrimitives;
        if (type == BlockType::kTriangles && options.preferFastTrace && !options.allowUpdate)
            total += maxSplits(total);
        if (total >= kMaxPrimitives)
            total = kMaxPrimitives - 1;
        maxReferences = uint32_t(total);
        tiles = (maxReferences + kSortTile - 1) / kSortTile;
        // A node whose primitives do not fit into its slots has eight children. By induction there
        // are no more than (2 n - 1) / 7 nodes where an inner child has four primitives or more, (4
        // n - 1) / 7 where it has two or more.
        const uint64_t least = type == BlockType::kTriangles ? 2 : 4;
        maxWide = uint32_t(least * total / 7 + 1);
    }

    void layOutOutput(const BuildOptions& options) {
        uint64_t offset = sizeof(BlockHeader) + uint64_t(numInputs) * sizeof(InputRecord);
        if (type == BlockType::kTriangles && options.allowRandomVertexAccess) {
            table = alignUp(offset, 64);
            offset = table + uint64_t(numPrimitives) * sizeof(uint32_t);
        }
        if (type == BlockType::kInstances) {
            instances = alignUp(offset, 64);
            offset = instances + uint64_t(numPrimitives) * sizeof(InstanceData);
        }
        const uint64_t record = type == BlockType::kTriangles ? sizeof(TriangleRecord)
                                : type == BlockType::kCustom  ? sizeof(CustomLeaf)
                                                              : sizeof(uint32_t);
        records = alignUp(offset, 128);
        nodes = alignUp(records + maxReferences * record, 128);
        outputSize = alignUp(nodes + uint64_t(maxWide) * sizeof(WideNode), kBlockAlignment);
    }

    // Records are written last; until then, their part of the output is scratch.
    void layOutTemp() {
        uint64_t offset = 0, spare = records;
        const auto place = [&](uint64_t bytes) {
            const uint64_t at = offset;
            offset = alignUp(offset + bytes, 128);
            return at;
        };
        const auto placeAnywhere = [&](uint64_t bytes) {
            if (spare + bytes > nodes)
                return Place{place(bytes), false};
            const uint64_t at = spare;
            spare = alignUp(spare + bytes, 128);
            return Place{at, true};
        };
        const uint64_t n = maxReferences;
        inputs = place(numInputs * sizeof(DeviceInput) + numSbtRecords);
        flags = inputs + numInputs * sizeof(DeviceInput);
        counters = place(sizeof(Counters)); // and what is zeroed with them
        tileStates = place(uint64_t(kSortPasses) * tiles * kSortDigits * 4);
        parents = place(n * 4); // and what is set to ones with them
        tasks = place(uint64_t(maxWide) * 8);
        boxes = place(n * sizeof(PrimitiveBox));
        // What is read while records are written must not lie where they go.
        origins = {place((n - numPrimitives) * 4), false};
        values[1] = {place(n * 4), false};
        keys[0] = {place(n * 8), false};
        binary = placeAnywhere(n * sizeof(BinaryNode));
        keys[1] = placeAnywhere(n * 8);
        values[0] = placeAnywhere(n * 4);
        costs = keys[1];   // free after the sort
        order = values[1]; // and this after the tree
        tempSize = offset;
    }
};

DeviceInput describe(const TriangleInput& in) {
    DeviceInput d{};
    d.data = addressOf(in.vertices);
    d.indices = addressOf(in.indices);
    d.preTransform = addressOf(in.preTransform);
    d.vertexFormat = uint32_t(in.vertexFormat);
    d.indexFormat = uint32_t(in.indexFormat);
    d.stride = in.vertexStride ? in.vertexStride : vertexSize(in.vertexFormat);
    d.indexStride = in.indexStride                            ? in.indexStride
                    : in.indexFormat == IndexFormat::kUshort3 ? 6
                                                              : 12;
    // Without vertices or indices every triangle is inactive.
    const bool missing = !in.vertices || (in.indexFormat != IndexFormat::kNone && !in.indices);
    d.numVertices = missing ? 0 : in.numVertices;
    return d;
}

DeviceInput describe(const CustomInput& in) {
    DeviceInput d{};
    d.data = addressOf(in.aabbs);
    d.stride = in.stride ? in.stride : 24;
    return d;
}

DeviceInput describe(const InstanceInput& in) {
    DeviceInput d{};
    d.areAddresses = in.instances == nullptr;
    d.data = addressOf(in.instances ? in.instances : static_cast<const void*>(in.instancePointers));
    d.stride = in.stride ? in.stride : uint32_t(sizeof(InstanceDesc));
    d.knownFlags = in.knownFlags;
    d.identityFlag = in.identityFlag;
    return d;
}

// What the host writes into the buffers before kernels run.
struct Uploads {
    std::vector<uint8_t> output, temp;

    Uploads(const BuildInputs& in, const BuildOptions& options, const Plan& plan, uint64_t tempBase)
        : output(sizeof(BlockHeader) + plan.numInputs * sizeof(InputRecord)),
          temp(plan.numInputs * sizeof(DeviceInput) + plan.numSbtRecords) {
        auto& header = *new (output.data()) BlockHeader{};
        auto* const records = reinterpret_cast<InputRecord*>(output.data() + sizeof(BlockHeader));
        auto* const inputs = reinterpret_cast<DeviceInput*>(temp.data());
        uint8_t* flags = temp.data() + plan.numInputs * sizeof(DeviceInput);
        startHeader(header, options, plan);
        uint32_t firstPrimitive = 0, firstSbt = 0;
        for (uint32_t i = 0; i < plan.numInputs; ++i) {
            const uint32_t count = plan.countOf(in, i);
            if (plan.type == BlockType::kInstances) {
                inputs[i] = describe(*in.instances);
                records[i].numPrimitives = count;
                header.geometryFlagsAnd = 0;
                break;
            }
            const bool triangles = plan.type == BlockType::kTriangles;
            const SbtInput& sbt = plan.sbtOf(in, i);
            inputs[i] = triangles ? describe(in.triangles[i]) : describe(in.customs[i]);
            inputs[i].sbtOffsets = addressOf(sbt.indexOffsets);
            inputs[i].sbtOffsetSize = sbt.indexOffsetSize;
            inputs[i].sbtOffsetStride =
                sbt.indexOffsetStride ? sbt.indexOffsetStride : sbt.indexOffsetSize;
            inputs[i].flags = tempBase + plan.flags + firstSbt;
            for (uint32_t k = 0; k < sbt.numSbtRecords; ++k) {
                const uint32_t word = sbt.flags ? sbt.flags[k] : 0;
                flags[firstSbt + k] = uint8_t(word);
                header.geometryFlagsAnd &= word;
            }
            records[i] = makeInputRecord(sbt, firstSbt, firstPrimitive, count,
                                         triangles ? &in.triangles[i] : nullptr);
            firstSbt += sbt.numSbtRecords;
            firstPrimitive += count;
        }
        header.numSbtRecords = firstSbt;
    }

private:
    static void startHeader(BlockHeader& header, const BuildOptions& options, const Plan& plan) {
        header.version = kBlockVersion; // the magic number comes last, on the device
        header.type = plan.type;
        header.root = header.wholeRoot = kNoNode;
        header.numPrimitives = plan.numPrimitives;
        header.numInputs = plan.numInputs;
        header.geometryFlagsAnd = ~0u;
        header.inputsOffset = sizeof(BlockHeader);
        header.tableOffset = plan.table;
        header.instancesOffset = plan.instances;
        header.recordsOffset = plan.records;
        header.nodesOffset = plan.nodes;
        header.options = optionBits(options);
        header.motionKeys = 1;
    }
};

void requireBuffer(const char* name, CUdeviceptr buffer, size_t size, size_t needed) {
    if (buffer == 0 || buffer % kBlockAlignment != 0)
        fail(Code::kInvalidValue, name, " buffer at address ", buffer, ", it must be aligned to ",
             kBlockAlignment, " bytes");
    if (size < needed)
        fail(Code::kInvalidValue, name, " buffer has ", size, " bytes, the build needs ", needed);
}

constexpr const char* kKernelNames[] = {
    "sunstone_references",  "sunstone_split_measure", "sunstone_split_choose",
    "sunstone_split_count", "sunstone_split_sum",     "sunstone_split",
    "sunstone_codes",       "sunstone_sort",          "sunstone_hierarchy",
    "sunstone_collapse",    "sunstone_retry",         "sunstone_records",
    "sunstone_finish",      "sunstone_compact",       "sunstone_emit"};

std::string describeFailure(uint64_t block, uint32_t failure) {
    const auto address = reinterpret_cast<const void*>(block);
    switch (failure) {
    case kTreeBroken:
        return message("the build into outputBuffer = ", address,
                       " came to a tree that cannot be; there is no acceleration structure "
                       "(an error in Sunstone, or something wrote into the buffers meanwhile)");
    default:
        return message("building into outputBuffer = ", address, " failed: ", failure);
    }
}

uint32_t blocksFor(uint32_t count, uint32_t threads, uint32_t most) {
    return std::clamp((count + threads - 1) / threads, 1u, most);
}

} // namespace

Builder::Builder(const device::cuda::Driver& driver) : driver_(driver) {
    static_assert(std::size(kKernelNames) == kKernelCount);
    CUdevice device = 0;
    int count = 1;
    check(driver_.ctxGetDevice(&device), "cuCtxGetDevice");
    check(driver_.deviceGetAttribute(&count, CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT, device),
          "cuDeviceGetAttribute");
    multiprocessors_ = uint32_t(std::max(count, 1));
    check(driver_.moduleLoadDataEx(&module_, builderPtx(), 0, nullptr, nullptr),
          "cuModuleLoadDataEx");
    for (uint32_t i = 0; i < kKernelCount; ++i)
        check(driver_.moduleGetFunction(&kernels_[i], module_, kKernelNames[i]), kKernelNames[i]);
    // With unified addresses, which every GPU of today has, kernels use the host's pointer.
    void* report = nullptr;
    check(driver_.memAllocHost(&report, sizeof(BuildReport)), "cuMemAllocHost");
    report_ = new (report) BuildReport{};
}

Builder::~Builder() {
    if (module_)
        driver_.moduleUnload(module_);
    if (report_)
        driver_.memFreeHost(report_);
}

std::vector<std::string> Builder::takeFailures() const {
    std::vector<std::string> texts;
    std::lock_guard lock(reportMutex_);
    for (;;) {
        const volatile BuildReport::Entry& entry =
            report_->entries[failuresTold_ % BuildReport::kEntries];
        const uint32_t number = entry.number;
        if (number <= failuresTold_)
            return texts;
        std::atomic_thread_fence(std::memory_order_acquire);
        texts.push_back(describeFailure(entry.block, entry.failure));
        failuresTold_ = number;
    }
}

void Builder::check(CUresult result, const char* what) const {
    if (result == CUDA_SUCCESS)
        return;
    const char* name = nullptr;
    driver_.getErrorName(result, &name);
    fail(result == CUDA_ERROR_OUT_OF_MEMORY ? Code::kOutOfMemory : Code::kCudaError, what, ": ",
         name ? name : "unknown error", " (", int(result), ")");
}

MemoryUsage Builder::computeMemoryUsage(const BuildInputs& inputs, const BuildOptions& options) {
    const Plan plan(inputs, options);
    return {plan.outputSize, plan.tempSize, kUpdateTempSize};
}

void Builder::launch(Kernel kernel, CUstream stream, uint32_t blocks, uint32_t threads,
                     void** arguments) const {
    check(driver_.launchKernel(kernels_[kernel], blocks, 1, 1, threads, 1, 1, 0, stream, arguments,
                               nullptr),
          kKernelNames[kernel]);
    if (observer_)
        observer_(observerUser_, kKernelNames[kernel]);
}

void Builder::build(CUstream stream, const BuildInputs& inputs, const BuildOptions& options,
                    CUdeviceptr temp, size_t tempSize, CUdeviceptr output,
                    size_t outputSize) const {
    const Plan plan(inputs, options);
    requireBuffer("temp", temp, tempSize, plan.tempSize);
    requireBuffer("output", output, outputSize, plan.outputSize);
    const Uploads uploads(inputs, options, plan, temp);
    // Pageable memory: the driver has copied it when the calls return.
    check(driver_.memcpyHtoDAsync(output, uploads.output.data(), uploads.output.size(), stream),
          "cuMemcpyHtoDAsync");
    check(driver_.memcpyHtoDAsync(temp + plan.inputs, uploads.temp.data(), uploads.temp.size(),
                                  stream),
          "cuMemcpyHtoDAsync");
    check(driver_.memsetD8Async(temp + plan.counters, 0, plan.parents - plan.counters, stream),
          "cuMemsetD8Async");
    check(driver_.memsetD8Async(temp + plan.parents, 0xFF, plan.boxes - plan.parents, stream),
          "cuMemsetD8Async");
    if (plan.table && plan.numPrimitives)
        check(driver_.memsetD8Async(output + plan.table, 0xFF,
                                    plan.numPrimitives * sizeof(uint32_t), stream),
              "cuMemsetD8Async");
    BuildJob job{};
    job.output = output;
    job.inputRecords = output + sizeof(BlockHeader);
    job.table = plan.table ? output + plan.table : 0;
    job.instances = output + plan.instances;
    job.records = output + plan.records;
    job.nodes = output + plan.nodes;
    job.inputs = temp + plan.inputs;
    job.counters = temp + plan.counters;
    job.boxes = temp + plan.boxes;
    const auto addressOf = [&](Plan::Place p) { return (p.inOutput ? output : temp) + p.offset; };
    for (int i = 0; i < 2; ++i) {
        job.keys[i] = addressOf(plan.keys[i]);
        job.values[i] = addressOf(plan.values[i]);
    }
    job.tileStates = temp + plan.tileStates;
    job.binary = addressOf(plan.binary);
    job.parents = temp + plan.parents;
    job.tasks = temp + plan.tasks;
    job.order = addressOf(plan.order);
    job.costs = addressOf(plan.costs);
    job.report = bvh::gpu::addressOf(report_);
    job.numInputs = plan.numInputs;
    job.numPrimitives = plan.numPrimitives;
    job.maxReferences = plan.maxReferences;
    job.origins = addressOf(plan.origins);
    job.maxWide = plan.maxWide;
    job.type = plan.type;
    job.searchRadius = 8;
    job.primitiveCost = 0.3f;
    queueKernels(stream, job, options.preferFastBuild);
}

void Builder::queueKernels(CUstream stream, BuildJob& job, bool fast) const {
    void* arguments[] = {&job};
    const uint32_t n = job.maxReferences, most = multiprocessors_ * 8;
    if (n != 0) {
        launch(kReferences, stream, blocksFor(job.numPrimitives, 256, most), 256, arguments);
        if (n != job.numPrimitives) {
            const uint32_t blocks = blocksFor(job.numPrimitives, 256, ~0u);
            launch(kSplitMeasure, stream, std::min(blocks, most), 256, arguments);
            launch(kSplitChoose, stream, 1, kSplitBins / 8, arguments);
            launch(kSplitCount, stream, blocks, 256, arguments);
            launch(kSplitSum, stream, 1, 256, arguments);
            launch(kSplit, stream, blocks, 256, arguments);
        }
        launch(kCodes, stream, blocksFor(n, 256, most), 256, arguments);
        for (uint32_t pass = 0; pass < kSortPasses; ++pass) {
            void* passArguments[] = {&job, &pass};
            launch(kSort, stream, (n + kSortTile - 1) / kSortTile, kSortThreads, passArguments);
        }
        const TreeMode first = fast ? kRadix : kClustered;
        for (TreeMode mode : {first, kRadixByLevel}) {
            void* treeArguments[] = {&job, &mode};
            launch(kHierarchy, stream, (n + 127) / 128, 128, treeArguments);
            launch(kCollapse, stream, blocksFor(n, 512, most), 128, treeArguments);
            if (mode == first)
                launch(kRetry, stream, blocksFor(n, 4096, most), 256, arguments);
        }
        launch(kRecords, stream, blocksFor(n, 256, most * 4), 256, arguments);
    }
    launch(kFinish, stream, 1, 1, arguments);
}

void Builder::compact(CUstream stream, CUdeviceptr block, CUdeviceptr destination) const {
    requireBuffer("destination", destination, 0, 0);
    uint64_t from = block, to = destination;
    void* arguments[] = {&from, &to};
    launch(kCompact, stream, multiprocessors_ * 8, 256, arguments);
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
