// SPDX-License-Identifier: Apache-2.0
// Pipelines on a GPU: programs to PTX (compiler/gpu/pipeline.h), PTX to machine code by the
// compiler that comes with the driver (device/cuda/ptx_compiler.h), or by the driver when it loads
// the text.
#include "base/config.h"
#include "base/error.h"
#include "base/log.h"
#include "base/threads/threads.h"
#include "bvh/gpu/layout.h"
#include "compiler/flavor.h"
#include "compiler/gpu/header.h"
#include "compiler/gpu/pipeline.h"
#include "devlib/flags.h"
#include "devlib/gpu/launch_block.h"
#include "devlib/gpu_runtime.h"
#include "engine/gpu/backend.h"
#include "engine/gpu/code/machine_code.h"
#include "engine/gpu/code/ready_code.h"
#include "engine/gpu/process.h"
#include "engine/pipeline.h"
#include "ptx/printer.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <memory>
#include <mutex>

namespace sunstone::engine {

using namespace device::cuda;

namespace {

// The newest PTX that a driver reads: the CUDA releases that introduced a version of PTX, and that
// version, 10 * major + minor (release notes in the PTX ISA manual).
struct PtxOfRelease {
    int driver; // 1000 * major + 10 * minor
    unsigned ptx;
};
constexpr PtxOfRelease kReleases[] = {
    {0, 65},     {11000, 70}, {11010, 71}, {11020, 72}, {11030, 73}, {11040, 74}, {11050, 75},
    {11060, 76}, {11070, 77}, {11080, 78}, {12000, 80}, {12010, 81}, {12020, 82}, {12030, 83},
    {12040, 84}, {12050, 85}, {12070, 86}, {12080, 87}, {12090, 88}, {13000, 90}};

unsigned ptxVersionOf(int driverVersion) {
    unsigned version = 0;
    for (const auto& [driver, ptx] : kReleases)
        if (driver <= driverVersion)
            version = ptx;
    return version;
}

// Whether programs can start again while an instance of them waits for a trace or call.
bool mayRecurse(const PipelineParts& parts) {
    for (const auto& group : parts.groups) {
        if (group->kind == devlib::kGroupCallables || group->kind == devlib::kGroupException ||
            group->kind == devlib::kGroupVisit)
            return true;
        const ProgramRef& main = group->programs[devlib::kRoleMain];
        if (group->kind == devlib::kGroupRaygen || !main)
            continue;
        const auto* program = main.module->findProgram(main.function);
        if (program && program->traces)
            return true;
    }
    return false;
}

// Whether any program traces rays.
bool tracesRays(const PipelineParts& parts) {
    return std::ranges::any_of(parts.groups, [](const auto& group) {
        return std::ranges::any_of(group->programs, [](const ProgramRef& program) {
            const auto* found = program ? program.module->findProgram(program.function) : nullptr;
            return found && found->traces;
        });
    });
}

// Whether the stack may overflow: it has room for traces of full depth and for all frames of
// programs, but not for functions that call themselves. `traceDepth`: 0 is unknown.
bool mayOverflow(const PipelineParts& parts, unsigned traceDepth) {
    const auto recurses = [](const ProgramRef& program) {
        return program && program.module->summary.mayRecurse;
    };
    return traceDepth == 0 || std::ranges::any_of(parts.groups, [&](const auto& group) {
               return group->kind == devlib::kGroupCallables ||
                      std::ranges::any_of(group->programs, recurses);
           });
}

// The details of callables for debug exceptions.
void addCallables(compiler::GpuGroup& to, const ProgramGroup& from) {
    const auto describe = [](const ProgramRef& program) {
        return program ? compiler::GpuGroup::Callable{program.function,
                                                      program.module->findProgram(program.function)
                                                          ->parameterWords}
                       : compiler::GpuGroup::Callable{};
    };
    to.callables[0] = describe(from.programs[devlib::kRoleDirect]);
    to.callables[1] = describe(from.programs[devlib::kRoleContinuation]);
}

// Makes room for the frames of recursion, which the driver cannot compute; false if it refuses. The
// limit belongs to the CUDA context: without the lock a thread could lower a limit that another has
// just raised.
bool raiseStackLimit(size_t bytes) {
    std::lock_guard lock(gpuProcess().stackLimit);
    size_t limit = 0;
    SUNSTONE_CU(ctxGetLimit, &limit, CU_LIMIT_STACK_SIZE);
    if (limit >= bytes)
        return true;
    const CUresult result = driver().ctxSetLimit(CU_LIMIT_STACK_SIZE, bytes);
    if (result == CUDA_ERROR_INVALID_VALUE || result == CUDA_ERROR_OUT_OF_MEMORY)
        return false;
    check(result, DriverNames::ctxSetLimit);
    return true;
}

// In addition to frames: the driver's own use of the stack, and functions that it provides.
constexpr size_t kReserved = 1024;
// Bytes that the driver's compiler spills in kernels without a report.
constexpr size_t kSpills = 1024;

size_t stackNeed(unsigned traceDepth, const compiler::GpuStack& stack, size_t kernelFrame) {
    const size_t depth = size_t(traceDepth) + 1;
    return kernelFrame + kReserved + (stack.isMeasured ? 0 : kSpills) + stack.entry +
           depth * stack.waiting + stack.other;
}

} // namespace

// The input of a pipeline's compilation, for graphs of any kind.
struct GpuBackend::CodePlan {
    compiler::GpuPipelineRequest request; // without the kind of graphs
    compiler::ObjectStore* cache = nullptr;
    uint32_t firstGroup = ~0u;
    uint32_t groupCount = 0;
    bool measuresStack = false; // programs recurse, or overflows of the stack are exceptions
    bool hasVisits = false;
    bool narrows = false; // the pipeline may have narrow code

    compiler::GpuPipelineRequest requestFor(GpuCodeKind kind) const;
};

GpuPipelineCode& GpuBackend::codeOf(const Pipeline& pipeline) {
    return static_cast<GpuPipelineCode&>(*pipeline.deviceCode);
}

// The declared depth; before a declaration, the depth of the graphs that can exist now. Code for
// two levels takes half the time to compile and runs faster. A launch compiles other code, and
// waits for the GPU, only if deep graphs appear after the pipeline and it never declares their
// depth.
unsigned GpuBackend::depthOfGraphs(const PipelineLimits& limits, const GpuGraphs& there) {
    if (limits.maxGraphDepth != devlib::kMaxGraphDepth || there.deep)
        return limits.maxGraphDepth;
    return GpuPipelineCode::kShallowDepth;
}

// Sets the part of the stack that a launch index may use; more is an overflow.
void GpuBackend::setStackUse(GpuCodeObject& code) {
    size_t limit = 0;
    SUNSTONE_CU(ctxGetLimit, &limit, CU_LIMIT_STACK_SIZE);
    code.stackBytes = limit - std::min(limit, code.reservedStack);
}

// The sizes can only enlarge the stack beyond the known need of the programs.
void GpuBackend::setStackSizes(const Context& context, Pipeline& pipeline) {
    const PipelineLimits set = pipeline.limits.get();
    GpuCodeObject& code = *codeOf(pipeline).get(depthOfGraphs(set, gpuGraphs()));
    const size_t asked = size_t(set.directStackFromTraversal) + set.directStackFromState +
                         set.continuationStack + code.reservedStack;
    ContextScope scope(device_.context());
    if (!raiseStackLimit(asked) && context.log)
        context.log(LogLevel::kWarning, "PIPELINE",
                    message("stack sizes of ", asked,
                            " bytes together are more than this GPU can "
                            "give to all threads: the stack stays as it was"));
    setStackUse(code);
}

// The pipeline's code, with machine code where the driver has a compiler for it. Programs with
// variables have no machine code for shallow graphs: all graphs share the variables.
compiler::GpuCode GpuBackend::compileWhole(const compiler::GpuPipelineRequest& request) {
    compiler::GpuCode code = compiler::compileGpuPipeline(request);
    addMachineCodeOfWhole(code, request);
    return code;
}

void GpuBackend::addMachineCodeOfWhole(compiler::GpuCode& code,
                                       const compiler::GpuPipelineRequest& request) {
    if (!code.hasState || constantOf(request, kGraphConstant) != devlib::kGraphShallow)
        addMachineCode(code, request);
}

bool GpuBackend::addMachineCode(compiler::GpuCode& code,
                                const compiler::GpuPipelineRequest& request) {
    auto made =
        machineCodeOf(code, request, registersOf(request, code.takesTurns), device_.context());
    if (!made)
        return false;
    code.machineCode = std::move(made->cubin);
    compiler::measureGpuStack(code, made->log);
    return true;
}

std::shared_ptr<const GpuLaterCode>
GpuBackend::compileLater(const compiler::GpuPipelineRequest& request, compiler::ObjectStore* store,
                         bool isNarrow, std::function<void()> sooner) {
    const auto later = std::make_shared<GpuLaterCode>();
    gpuProcess().codeQueue.add(this, [this, later, request, store, isNarrow, sooner] {
        if (sooner)
            sooner();
        compileInto(*later, request, store, isNarrow);
    });
    return later;
}

void GpuBackend::compileInto(GpuLaterCode& later, const compiler::GpuPipelineRequest& request,
                             compiler::ObjectStore* store, bool isNarrow) {
    try {
        later.code = compiler::compileGpuPipeline(request);
        // A later process finds the whole pipeline in the cache. Narrow code is not worth a wait at
        // the end of the process; machine code takes most of the time.
        if (isNarrow && gpuProcess().codeQueue.isUnwanted(this))
            return;
        addMachineCodeOfWhole(later.code, request);
        if (store)
            compiler::keepGpuPipeline(compiler::keyOf(request), later.code, *store);
        std::string().swap(later.code.ptx);
    } catch (const std::exception& error) { // launches go on with the code that was ready
        later.code = {};
        log(LogLevel::kWarning, "engine",
            message("a pipeline cannot be compiled as a whole: ", error.what()));
    }
    later.isReady = true;
}

void GpuBackend::prepareReadyKernels(compiler::ObjectStore* store) {
    if (!hasPtxCompiler())
        return;
    const auto kernels = readyKernels(target());
    parallelFor(kernels.size(), 1, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i)
            if (readyKernelCode(kernels[i], store).empty())
                compileReadyKernel(kernels[i], store);
    });
}

// The archive has no kernel for this GPU, or the driver is too old for its machine code. The next
// pipelines find the kernel in the disk cache.
void GpuBackend::makeReadyKernelLater(const compiler::GpuPipelineRequest& request,
                                      compiler::ObjectStore* store) {
    const auto kernel = readyKernelFor(request);
    if (!kernel || !store || !hasPtxCompiler() || currentConfig(Setting::kGpuCode) == "whole" ||
        !readyKernelCode(*kernel, store).empty())
        return;
    gpuProcess().codeQueue.add(this, [kernel, store] {
        try {
            compileReadyKernel(*kernel, store);
        } catch (const std::exception& error) {
            log(LogLevel::kWarning, "engine",
                message("a kernel cannot be compiled: ", error.what()));
        }
    });
}

// Throws kLinkError if the driver refuses the machine code: there is no text.
LoadedGpuCodes::Entry GpuBackend::loadMachineCode(compiler::GpuCode code) {
    std::string unused;
    LoadedGpuCodes::Entry entry;
    entry.loaded =
        std::make_shared<const LoadedGpuCode>(device_.context(), code, kMostRegisters, unused);
    std::string().swap(code.machineCode);
    entry.code = std::make_shared<const compiler::GpuCode>(std::move(code));
    return entry;
}

// Code from a kernel that is there already, and from now on the whole pipeline compiles. Null
// `loaded` where the pipeline must compile as a whole first.
LoadedGpuCodes::Entry GpuBackend::obtainReadyCode(const compiler::GpuPipelineRequest& request,
                                                  compiler::ObjectStore* store,
                                                  const BeforeWhole& beforeWhole) {
    const std::string setting = currentConfig(Setting::kGpuCode);
    const std::string key = store ? "ready " + compiler::keyOf(request) : std::string();
    LoadedGpuCodes::Entry entry = store ? loaded_.find(key) : LoadedGpuCodes::Entry();
    if (entry.loaded || setting == "whole")
        return entry;
    const auto kernel = readyKernelFor(request);
    const std::string kernelCode = kernel ? readyKernelCode(*kernel, store) : std::string();
    if (kernelCode.empty())
        return entry;
    std::optional<compiler::GpuCode> code =
        readyCodeOf(request, *kernel, kernelCode, device_.context());
    if (!code)
        return entry;
    try {
        entry = loadMachineCode(std::move(*code));
    } catch (const Error& error) {
        if (error.code() != Code::kLinkError)
            throw;
        return {}; // the driver refuses the code
    }
    if (setting != "ready")
        entry.later = compileLater(request, store, false, beforeWhole(*entry.code));
    if (store) {
        entry.key = key;
        loaded_.add(entry);
    }
    return entry;
}

// Without a store no code is kept here either, because a disabled cache means compilation. `loaded`
// is null where GpuPipelineCode::Make returns null.
LoadedGpuCodes::Entry GpuBackend::obtainCode(const compiler::GpuPipelineRequest& request,
                                             compiler::ObjectStore* store,
                                             const BeforeWhole& beforeWhole) {
    LoadedGpuCodes::Entry entry;
    compiler::GpuCode code;
    std::string log;
    const auto load = [&](unsigned most) {
        entry.loaded = std::make_shared<const LoadedGpuCode>(device_.context(), code, most, log);
    };
    bool isKept = false;
    if (store) {
        const std::string key = compiler::keyOf(request);
        entry = loaded_.find(key);
        if (!entry.loaded)
            isKept = compiler::findGpuPipeline(key, *store, code);
        else if (store->has(key))
            return entry;
        entry = {key, nullptr, nullptr, nullptr};
    }
    if (isKept && !code.machineCode.empty())
        try {
            load(registersOf(request, code.takesTurns));
        } catch (const Error& error) {
            if (error.code() != Code::kLinkError)
                throw;
            isKept = false; // for example of another driver with the same number
        }
    if (!isKept) {
        if (LoadedGpuCodes::Entry ready = obtainReadyCode(request, store, beforeWhole);
            ready.loaded)
            return ready;
        code = compileWhole(request);
        makeReadyKernelLater(request, store);
    }
    if (code.hasState && constantOf(request, kGraphConstant) == devlib::kGraphShallow) {
        if (store && !isKept)
            compiler::keepGpuPipeline(entry.key, code, *store);
        return entry;
    }
    if (!entry.loaded) {
        if (code.machineCode.empty() && addMachineCode(code, request))
            isKept = false;
        const unsigned registers = registersOf(request, code.takesTurns);
        load(registers);
        if (entry.loaded->isOfText) {
            code.machineCode.clear(); // the driver accepts no machine code
            if (const unsigned better = betterRegisters(log, code, request, registers))
                load(better);
        }
        if (!log.empty()) {
            compiler::measureGpuStack(code, log);
            isKept = false;
        }
        if (store && !isKept)
            compiler::keepGpuPipeline(entry.key, code, *store);
    }
    std::string().swap(code.ptx);
    std::string().swap(code.machineCode);
    const bool isShared = store && !code.hasState;
    entry.code = std::make_shared<const compiler::GpuCode>(std::move(code));
    if (isShared)
        loaded_.add(entry);
    return entry;
}

// This variant works with every driver, even if its compiler cannot return machine code.
bool GpuBackend::takes(const std::string& ptx) {
    ContextScope scope(device_.context());
    CUmodule module = nullptr;
    if (driver().moduleLoadDataEx(&module, ptx.c_str(), 0, nullptr, nullptr) != CUDA_SUCCESS)
        return false;
    driver().moduleUnload(module);
    return true;
}

// Drivers newer than this library report the versions that they read.
unsigned GpuBackend::newestPtx() {
    std::call_once(ptxAsked_, [this] {
        newestPtx_ = ptxVersionOf(device_.driverVersion());
        if (device_.driverVersion() < std::rbegin(kReleases)->driver + 10)
            return;
        const auto reads = [this](unsigned version) {
            return takes(compiler::withHeader(".version 6.0\n.target sm_70\n.address_size 64\n",
                                              {version, "sm_75"}));
        };
        constexpr unsigned kMost = 999;
        for (unsigned next = newestPtx_ + 1; next < kMost && reads(next); ++next)
            newestPtx_ = next;
        for (unsigned next = (newestPtx_ / 10 + 1) * 10; next < kMost && reads(next); ++next)
            newestPtx_ = next;
    });
    return newestPtx_;
}

compiler::GpuTarget GpuBackend::target() {
    return {device_.computeCapability(), newestPtx(), unsigned(device_.driverVersion())};
}

bool GpuBackend::accepts(const ptx::Module& module) {
    compiler::GpuHeader header = compiler::plainHeader(target());
    compiler::widen(header, module, target());
    return takes(compiler::withHeader(ptx::print(module), header));
}

// Makes room on the stack for the code; the driver cannot compute the need of recursive programs.
void GpuBackend::makeRoom(GpuCodeObject& code, const CodePlan& plan,
                          const compiler::GpuStack& stack) {
    int frame = 0;
    SUNSTONE_CU(funcGetAttribute, &frame, CU_FUNC_ATTRIBUTE_LOCAL_SIZE_BYTES, code.kernel);
    if (!plan.measuresStack) { // else the driver makes room in the first launch, and waits
        raiseStackLimit(size_t(frame) + kReserved);
        return;
    }
    code.neededStack = stackNeed(plan.request.maxTraceDepth, stack, size_t(frame));
    if (plan.hasVisits) // `stack` counts the cycle of walks and visit programs once
        code.neededStack += (devlib::kMostNestedVisits - 1) * std::max(stack.entry, stack.other);
    code.reservedStack = stack.other + kReserved;
    if (!raiseStackLimit(code.neededStack))
        fail(Code::kNotSupported, "traces of full depth take ", code.neededStack,
             " bytes of stack a thread, which this GPU cannot give to all of them");
}

// Code of parts has large slots. Its launches get fewer warps where the slots of all warps would
// exceed a share of the device's memory.
void GpuBackend::obtainLaneMemory(GpuCodeObject& object, const compiler::GpuCode& code) {
    constexpr size_t kLeast = size_t(64) << 20, kShare = 64;
    const unsigned warpsOfBlock = object.blockThreads / devlib::kGpuTile;
    unsigned warps = residentWarps(object.kernel, object.blockThreads);
    if (code.frameBytes != 0) {
        size_t unused = 0, total = 0;
        SUNSTONE_CU(memGetInfo, &unused, &total);
        const size_t most = std::max(kLeast, total / kShare) / code.laneMemoryBytes;
        object.mostBlocks =
            unsigned(std::max<size_t>(std::min<size_t>(most, warps) / warpsOfBlock, 1));
        warps = object.mostBlocks * warpsOfBlock;
    }
    object.laneMemory = laneMemory_.obtain(code.laneMemoryBytes, warps, code.walksInStep);
    object.laneMemory.frameBytes = code.frameBytes;
}

namespace {

// Blocks whose warps may wait for each other have up to as many threads as the kernel's registers
// allow, because the instruction cache is that of a multiprocessor.
void setBlockSizes(GpuCodeObject& object, bool mayWait) {
    constexpr unsigned kWaiting[] = {128, 256, 512};
    const auto sizeOf = [&](unsigned threads) {
        return GpuBlockSize{threads, residentWarps(object.kernel, threads) * devlib::kGpuTile};
    };
    std::vector<GpuBlockSize> sizes = {sizeOf(object.blockThreads)};
    if (mayWait) {
        int most = 0;
        SUNSTONE_CU(funcGetAttribute, &most, CU_FUNC_ATTRIBUTE_MAX_THREADS_PER_BLOCK,
                    object.kernel);
        const unsigned largest = unsigned(most) / devlib::kGpuTile * devlib::kGpuTile;
        for (const unsigned threads : kWaiting)
            if (threads <= largest)
                sizes.push_back(sizeOf(threads));
        if (largest > std::end(kWaiting)[-1])
            sizes.push_back(sizeOf(largest));
    }
    object.findings->patience.setBlocks(std::move(sizes), multiprocessors());
}

} // namespace

std::shared_ptr<GpuCodeObject> GpuBackend::makeCode(const CodePlan& plan, GpuCodeKind kind,
                                                    const GpuLaterCode* later) {
    ContextScope scope(device_.context());
    const GpuGraphs there = gpuGraphs();
    const GpuCodeKind narrowKind = narrowed(kind, there);
    std::shared_ptr<const GpuLaterCode> narrow;
    const auto beginNarrow = [&](const compiler::GpuCode& ready) {
        const unsigned flags = plan.request.pipeline.rules.traversableGraphFlags;
        std::function<void()> job;
        if (!plan.narrows || ready.hasState || narrowKind == kind || !isSceneComplete(there, flags))
            return job;
        narrow = prepareNarrow(plan, narrowKind, false);
        if (narrow)
            return job;
        const auto later = std::make_shared<GpuLaterCode>();
        narrow = later;
        job = [this, later, request = plan.requestFor(narrowKind), store = plan.cache] {
            compileInto(*later, request, store, false);
        };
        return job;
    };
    const LoadedGpuCodes::Entry entry =
        later ? loadMachineCode(later->code)
              : obtainCode(plan.requestFor(kind), plan.cache, beginNarrow);
    if (!entry.loaded)
        return nullptr;
    const compiler::GpuCode& code = *entry.code;
    auto loaded = std::make_shared<GpuCodeObject>(device_.context(), entry.loaded);
    loaded->feedback = code.feedback;
    loaded->later = entry.later;
    loaded->narrow = std::move(narrow);
    loaded->narrowKind = narrowKind;
    loaded->firstGroup = plan.firstGroup;
    loaded->groupCount = plan.groupCount;
    loaded->blockThreads =
        code.walksInStep ? devlib::kGpuStepBlockThreads : devlib::kGpuBlockThreads;
    // Warps that wait for lane memory would wait for warps that wait for them.
    const bool mayWait = !code.walksInStep && code.laneMemoryBytes == 0;
    setBlockSizes(*loaded, mayWait);
    if (code.laneMemoryBytes != 0)
        obtainLaneMemory(*loaded, code);
    makeRoom(*loaded, plan, code.stack);
    setStackUse(*loaded);
    return loaded;
}

compiler::GpuPipelineRequest GpuBackend::CodePlan::requestFor(GpuCodeKind kind) const {
    compiler::GpuPipelineRequest made = request;
    made.constants.emplace_back(kMotionConstant, kind.motion);
    made.constants.emplace_back(kGraphConstant, kind.graph);
    return made;
}

// Code from the disk cache; with `compiles`, else code that the queue compiles; or null.
std::shared_ptr<const GpuLaterCode> GpuBackend::prepareNarrow(const CodePlan& plan,
                                                              GpuCodeKind kind, bool compiles) {
    const compiler::GpuPipelineRequest request = plan.requestFor(kind);
    const std::string key = compiler::keyOf(request);
    const auto kept = std::make_shared<GpuLaterCode>();
    if (plan.cache && plan.cache->has(key) && // a search logs what it does not find
        compiler::findGpuPipeline(key, *plan.cache, kept->code)) {
        kept->isReady = true;
        return kept;
    }
    return compiles ? compileLater(request, plan.cache, true) : nullptr;
}

void GpuBackend::compile(Pipeline& pipeline, const PipelineParts& parts) {
    CodePlan plan;
    compiler::GpuPipelineRequest& request = plan.request;
    request.pipeline = parts.request;
    const bool isClassic = parts.request.flavor == &compiler::optix6Flavor();
    request.runtime = isClassic ? devlib::gpuClassicRuntime() : devlib::gpuRuntime();
    request.target = target();
    const PipelineLimits limits = pipeline.limits.get();
    request.maxTraceDepth = limits.maxTraceDepth;
    plan.cache = parts.cache;
    uint32_t& flags = request.pipeline.rules.exceptionFlags;
    if ((flags & devlib::kFlagStackOverflow) && !mayOverflow(parts, limits.maxTraceDepth))
        flags &= ~devlib::kFlagStackOverflow; // checks exclude the fast kernels
    for (const auto& group : parts.groups)
        plan.firstGroup = std::min(plan.firstGroup, group->number);
    const auto has = [&](devlib::GroupKind kind) {
        return std::ranges::any_of(parts.groups,
                                   [=](const auto& group) { return group->kind == kind; });
    };
    plan.hasVisits = has(devlib::kGroupVisit);
    plan.measuresStack = (flags & devlib::kFlagStackOverflow) || mayRecurse(parts);
    for (size_t i = 0; i < parts.groups.size(); ++i) {
        static_assert(compiler::GpuGroup::kNone == PipelineParts::kNone);
        const ProgramGroup& group = *parts.groups[i];
        const uint32_t number = group.number - plan.firstGroup;
        plan.groupCount = std::max(plan.groupCount, number + 1);
        request.groups.push_back({number, group.kind, parts.indices[i]});
        addCallables(request.groups.back(), group);
        request.groups.back().builtin = group.builtinPrimitive;
    }
    request.constants = {
        {"sunstone_gpu_hasAnyHit", pipeline.hasAnyHit},
        {"sunstone_gpu_hasIntersection", pipeline.hasIntersection},
        {"sunstone_gpu_micromaps", limits.opacityMicromaps},
        {"sunstone_gpu_shapes", bvh::gpu::shapeBitsOf(pipeline.rules.primitiveTypeFlags)},
        {"sunstone_gpu_hasBounds", has(devlib::kGroupBounds)},
        {"sunstone_gpu_hasVisits", plan.hasVisits},
        {"sunstone_gpu_hasException", has(devlib::kGroupException)},
        {"sunstone_gpu_exceptionFlags", flags},
    };
    plan.narrows = !isClassic && tracesRays(parts) &&
                   !(flags & (devlib::kFlagDebug | devlib::kFlagStackOverflow));
    const GpuPipelineCode::Make make = [this, plan](GpuCodeKind kind, const GpuLaterCode* later) {
        return makeCode(plan, kind, later);
    };
    GpuNarrowCodes::Prepare prepare;
    if (plan.narrows)
        prepare = [this, plan](GpuCodeKind kind, bool compiles) {
            return prepareNarrow(plan, kind, compiles);
        };
    const auto code = std::make_shared<GpuPipelineCode>(
        make, prepare, pipeline.rules.traversableGraphFlags, pipeline.rules.motionBlur);
    pipeline.deviceCode = code;
    pipeline.feedback =
        code->get(isClassic ? limits.maxGraphDepth : depthOfGraphs(limits, gpuGraphs()))->feedback;
}

} // namespace sunstone::engine
