// SPDX-License-Identifier: Apache-2.0
// See launch.h.
#include "api/cuda/driver/launch.h"

#include "api/cuda/driver/blocks/block.h"
#include "api/cuda/driver/blocks/cooperative.h"
#include "api/cuda/driver/device_faults.h"
#include "base/config.h"
#include "base/log.h"
#include "base/threads/threads.h"
#include "compiler/debug/place.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstring>

namespace sunstone::api::cuda {

namespace {

// Shorter launches do not justify waking other cores.
constexpr uint64_t kSmallNanoseconds = 20'000;
// The first launch of a kernel begins on one core if it has fewer threads than this.
constexpr uint64_t kSmallLaunch = 2048;

[[noreturn]] void refuseFault(const Launch& launch) {
    const FaultFrame& fault = launch.processorFault;
    const auto &block = launch.faulted.ctaid, &thread = launch.faulted.tid;
    std::string last;
    if (launch.faultedLanes > 1) {
        devlib::KernelThread end{};
        const uint32_t index = launch.faulted.warpid * devlib::kWarpLanes + launch.faulted.laneid;
        placeThread(end, launch, index + launch.faultedLanes - 1);
        last = message(" to (", end.tid[0], ", ", end.tid[1], ", ", end.tid[2], ")");
    }
    refuse(faultResult(fault), "kernel ", launch.name, ": ", describeFault(fault),
           freedRemark(fault), ", in block (", block[0], ", ", block[1], ", ", block[2],
           "), thread (", thread[0], ", ", thread[1], ", ", thread[2], ")", last,
           compiler::placeText(fault.instruction));
}

[[noreturn]] void refuseFault(const char* kernel, devlib::KernelFault fault) {
    switch (fault) {
    case devlib::kFaultAssertion:
        refuse(CUDA_ERROR_ASSERT, "kernel ", kernel, ": an assertion failed");
    case devlib::kFaultAddress:
        refuse(CUDA_ERROR_ILLEGAL_ADDRESS, "kernel ", kernel, ": invalid access of memory");
    case devlib::kFaultAlignment:
        refuse(CUDA_ERROR_MISALIGNED_ADDRESS, "kernel ", kernel, ": misaligned access of memory");
    case devlib::kFaultShared:
        refuse(CUDA_ERROR_LAUNCH_FAILED, "kernel ", kernel, ": shared memory out of bounds");
    case devlib::kFaultTrap:
        break;
    }
    refuse(CUDA_ERROR_LAUNCH_FAILED, "kernel ", kernel, ": executed a trap");
}

using Clock = std::chrono::steady_clock;

uint64_t nanosecondsSince(Clock::time_point start) {
    return uint64_t(std::chrono::nanoseconds(Clock::now() - start).count());
}

// Updates the estimated cost of a block from a launch, with a weight of one quarter.
void noteBlockCost(const Launch& launch, uint64_t nanoseconds, uint64_t blocks) {
    constexpr uint64_t kMost = ~uint32_t(0);
    const uint64_t made = std::clamp<uint64_t>(nanoseconds / blocks, 1, kMost);
    const uint64_t known = launch.blockCost->load(std::memory_order_relaxed);
    launch.blockCost->store(uint32_t(known ? (3 * known + made) / 4 : made),
                            std::memory_order_relaxed);
}

// Runs blocks on this thread while they are cheap; returns the first block not run.
uint64_t runSmall(Launch& launch, uint64_t blocks) {
    const Clock::time_point start = Clock::now();
    BlockRunner runner(launch);
    const uint64_t piece = std::max<uint64_t>(1, blocks / 8);
    uint64_t done = 0, spent = 0;
    while (done < blocks && spent < 2 * kSmallNanoseconds) {
        const uint64_t end = std::min(blocks, done + piece);
        runner.run(done, end);
        done = end;
        spent = nanosecondsSince(start);
    }
    noteBlockCost(launch, spent, done);
    return done;
}

void runBlocks(Launch& launch) {
    const uint64_t blocks = uint64_t(launch.grid[0]) * launch.grid[1] * launch.grid[2];
    const uint64_t perBlock = launch.threadsPerBlock();
    const uint64_t cost = launch.blockCost->load(std::memory_order_relaxed);
    const bool isSmall =
        cost != 0 ? cost < kSmallNanoseconds / blocks : blocks * perBlock <= kSmallLaunch;
    const uint64_t first = isSmall || blocks == 1 ? runSmall(launch, blocks) : 0;
    if (first == blocks)
        return;
    // Pieces of some thousand threads, but enough pieces for all cores.
    const uint64_t rest = blocks - first, pieces = uint64_t(threadCount()) * 8;
    const uint64_t grain = std::max<uint64_t>(
        1, std::min<uint64_t>((kSmallLaunch + perBlock - 1) / perBlock, rest / pieces));
    parallelFor(rest, grain, [&](size_t begin, size_t end) {
        const Clock::time_point start = Clock::now();
        BlockRunner(launch).run(first + begin, first + end);
        noteBlockCost(launch, nanosecondsSince(start), end - begin);
    });
}

void runLaunch(const LaunchPlan& plan) {
    Launch launch(plan);
    if (launch.cooperative)
        runCooperative(launch);
    else
        runBlocks(launch);
    if (launch.namesEnded)
        logOnce(LogLevel::kWarning, "cuda",
                message("kernel ", launch.name,
                        ": a shuffle or vote names lanes that have ended; on GPUs values from "
                        "them are undefined"));
    if (launch.deadlock)
        refuse(CUDA_ERROR_LAUNCH_FAILED, "kernel ", launch.name,
               ": deadlock: threads wait at a barrier that other threads of the block never reach");
    if (launch.fault == Launch::kProcessorFault)
        refuseFault(launch);
    if (const uint32_t fault = launch.fault)
        refuseFault(launch.name, devlib::KernelFault(fault - 1));
}

void checkShape(const LaunchRequest& request, const Function& function) {
    static constexpr char kAxes[] = "xyz";
    uint64_t threads = 1;
    for (int i = 0; i < 3; ++i) {
        if (request.grid[i] == 0 || request.grid[i] > kMaxGrid[i])
            refuse(CUDA_ERROR_INVALID_VALUE, "grid dimension ", kAxes[i], " is ", request.grid[i],
                   ", not in 1..", kMaxGrid[i]);
        if (request.block[i] == 0 || request.block[i] > kMaxBlock[i])
            refuse(CUDA_ERROR_INVALID_VALUE, "block dimension ", kAxes[i], " is ", request.block[i],
                   ", not in 1..", kMaxBlock[i]);
        threads *= request.block[i];
    }
    if (threads > kMaxThreads)
        refuse(CUDA_ERROR_INVALID_VALUE, threads, " threads in a block, at most ", kMaxThreads);
    if (threads > maxThreadsOf(function))
        refuse(CUDA_ERROR_LAUNCH_OUT_OF_RESOURCES, threads, " threads in a block of kernel ",
               function.info->name, ", whose launch bounds say ", maxThreadsOf(function));
    if (request.sharedBytes > maxDynamicSharedOf(function))
        refuse(CUDA_ERROR_INVALID_VALUE, request.sharedBytes,
               " bytes of dynamic shared memory, at most ", maxDynamicSharedOf(function));
    if (!request.cooperative)
        return;
    const uint64_t perProcessor = activeBlocks(function, unsigned(threads), request.sharedBytes);
    const uint64_t blocks = uint64_t(request.grid[0]) * request.grid[1] * request.grid[2];
    if (blocks > perProcessor * threadCount())
        refuse(CUDA_ERROR_COOPERATIVE_LAUNCH_TOO_LARGE, blocks, " blocks of kernel ",
               function.info->name, "; ", perProcessor, " fit on each of ", threadCount(),
               " multiprocessors at once");
}

// The parameter block in the layout that the kernel reads.
std::vector<std::byte> gatherParameters(const LaunchRequest& request,
                                        const compiler::KernelInfo& info) {
    std::vector<std::byte> block(std::max<size_t>(info.parameterBytes, 1));
    require(!request.params || !request.extra, "both params and extra are given");
    if (request.params) {
        for (size_t i = 0; i < info.parameterSizes.size(); ++i) {
            if (!cpu::isMapped(&request.params[i], sizeof(void*)) ||
                !cpu::isMapped(request.params[i], info.parameterSizes[i]))
                refuse(CUDA_ERROR_INVALID_VALUE, "parameter ", i, " of kernel ", info.name,
                       " is missing or unreadable");
            std::memcpy(block.data() + info.parameterOffsets[i], request.params[i],
                        info.parameterSizes[i]);
        }
        return block;
    }
    const void* buffer = nullptr;
    size_t size = 0;
    if (request.extra) {
        for (size_t i = 0; request.extra[i] != CU_LAUNCH_PARAM_END; i += 2) {
            if (request.extra[i] == CU_LAUNCH_PARAM_BUFFER_POINTER) {
                buffer = request.extra[i + 1];
            } else if (request.extra[i] == CU_LAUNCH_PARAM_BUFFER_SIZE) {
                require(request.extra[i + 1], "the size of the parameter buffer is null");
                size = *static_cast<size_t*>(request.extra[i + 1]);
            } else {
                refuse(CUDA_ERROR_INVALID_VALUE, "extra has an unknown key at ", i);
            }
        }
    }
    if (info.parameterBytes == 0)
        return block;
    if (!buffer || size < info.parameterBytes || !cpu::isMapped(buffer, info.parameterBytes))
        refuse(CUDA_ERROR_INVALID_VALUE, "kernel ", info.name, " takes ", info.parameterBytes,
               " bytes of parameters, ", buffer ? size : 0, " are given");
    std::memcpy(block.data(), buffer, info.parameterBytes);
    return block;
}

// Whether a launch uses the kernel's code for a warp at a time.
bool runsInLockstep(const LaunchPlan& plan) {
    constexpr uint32_t kFewThreads = 4; // most lanes would be idle
    if (!plan.meets && plan.threadsPerBlock() < kFewThreads)
        return false;
    return currentConfig(Setting::kKernels) != "single";
}

} // namespace

unsigned maxThreadsOf(const Function& function) {
    const unsigned bound = function.info->maxThreadsPerBlock;
    return bound ? std::min(bound, kMaxThreads) : kMaxThreads;
}

unsigned maxDynamicSharedOf(const Function& function) {
    const unsigned asked = function.maxDynamicShared;
    const unsigned statics = function.info->staticSharedBytes;
    const unsigned usual = statics < kSharedPerBlock ? kSharedPerBlock - statics : 0;
    return std::max(asked, usual);
}

unsigned activeBlocks(const Function& function, unsigned blockSize, size_t dynamicShared) {
    if (blockSize > maxThreadsOf(function))
        return 0;
    const unsigned warps = (blockSize + kWarpSize - 1) / kWarpSize;
    size_t blocks = std::min(kBlocksPerProcessor, kThreadsPerProcessor / (warps * kWarpSize));
    const size_t statics = function.info->staticSharedBytes;
    if (dynamicShared > kSharedOptin || statics > kSharedOptin - dynamicShared)
        return 0;
    const size_t shared = statics + dynamicShared;
    if (shared)
        blocks = std::min(blocks, kSharedPerProcessor / shared);
    return unsigned(blocks);
}

PreparedLaunch prepareLaunch(const LaunchRequest& request) {
    std::shared_ptr<Function> function = functionOf(request.function);
    std::shared_ptr<Module> module = function->module.lock();
    if (!module)
        refuse(CUDA_ERROR_INVALID_HANDLE, "the function's module has been unloaded");
    const compiler::KernelInfo& info = *function->info;
    if (!info.unsupported.empty())
        refuse(CUDA_ERROR_NOT_SUPPORTED, "kernel ", info.name, ": ", info.unsupported);
    checkShape(request, *function);

    struct Job {
        LaunchPlan plan;
        std::vector<std::byte> params;
        std::shared_ptr<Module> module;
        std::shared_ptr<Function> function;
        std::weak_ptr<cpu::Context> context;
        KernelDetails details;
    };
    auto job = std::make_shared<Job>();
    job->params = gatherParameters(request, info);
    job->module = std::move(module);
    job->context = cpu::contexts().shareCurrent();
    LaunchPlan& plan = job->plan;
    plan.kernel = reinterpret_cast<devlib::KernelFn>(const_cast<void*>(info.address));
    plan.params = job->params.data();
    for (int i = 0; i < 3; ++i) {
        plan.grid[i] = request.grid[i];
        plan.block[i] = request.block[i];
    }
    plan.paramBytes = info.parameterBytes;
    plan.staticShared = info.staticSharedBytes;
    plan.dynamicShared = request.sharedBytes;
    plan.localBytes = info.localBytes;
    plan.cooperative = request.cooperative;
    plan.meets = info.usesBarriers || info.usesWarpFunctions;
    plan.name = info.name.c_str();
    plan.blockCost = &function->blockCost;
    if (info.lockstep && runsInLockstep(plan)) {
        plan.lockstep = reinterpret_cast<devlib::LockstepFn>(const_cast<void*>(info.lockstep));
        plan.frameBytes = info.lockstepFrameBytes;
        plan.needsThreads = info.needsThreads;
    }

    job->function = std::move(function);
    for (size_t offset : info.parameterOffsets)
        job->details.pointers.push_back(job->params.data() + offset);
    job->details.request = request;
    job->details.request.params = job->details.pointers.data();
    job->details.request.extra = nullptr;
    return {[job] { runInContext(job->context, [&] { runLaunch(job->plan); }); },
            std::shared_ptr<const KernelDetails>(job, &job->details)};
}

void launch(const LaunchRequest& request, const cpu::StreamPtr& stream) {
    PreparedLaunch prepared = prepareLaunch(request);
    cpu::streams().submit(stream, std::move(prepared.work), {},
                          {cpu::WorkKind::kKernel, std::move(prepared.details)});
}

} // namespace sunstone::api::cuda
