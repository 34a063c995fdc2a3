// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/code/ready_code.h"

#include "base/config.h"
#include "base/log.h"
#include "base/threads/cpu_limits.h"
#include "base/threads/threads.h"
#include "device/cuda/ptx_parts.h"
#include "devlib/gpu/launch_block.h"
#include "engine/gpu/code/kernel_code.h"
#include "engine/gpu/code/machine_code.h"
#include "engine/gpu/process.h"

#include <chrono>

namespace sunstone::engine {

using namespace device::cuda;

namespace {

using Clock = std::chrono::steady_clock;

// Whether the driver links texts, as the CPU device does.
bool linksTexts() {
    return !hasPtxCompiler();
}

std::optional<std::string> codeOf(const std::string& text, unsigned capability,
                                  unsigned registers) {
    if (linksTexts())
        return text;
    auto made = compilePtx(text, capability, registers, PtxUse::kPart);
    return made ? std::optional(std::move(made->cubin)) : std::nullopt;
}

// The parts of a pipeline's programs.
struct Programs {
    std::vector<compiler::GpuPart> parts;
    std::vector<compiler::GpuCode> codes;
    std::vector<std::string> machineCodes; // empty: compiled together with the kernel only

    // Parts compile at the same time where there are processors for them.
    Programs() {
        using enum compiler::GpuPart;
        if (cpuLimit().threads > 2)
            parts = {kEntries, kRays, kResumes};
        else
            parts = {kPrograms};
        codes.resize(parts.size());
        machineCodes.resize(parts.size());
    }

    void compile(const compiler::GpuPipelineRequest& request, unsigned registers) {
        parallelFor(parts.size(), 1, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i) {
                compiler::GpuPipelineRequest part = request;
                part.part = parts[i];
                try {
                    codes[i] = compiler::compileGpuPipeline(part);
                } catch (const std::exception& error) { // the whole pipeline will report it
                    codes[i].feedback = error.what();
                }
                if (!codes[i].ptx.empty() && !codes[i].hasState)
                    machineCodes[i] =
                        codeOf(codes[i].ptx, request.target.computeCapability, registers)
                            .value_or("");
            }
        });
    }
};

// The lane memory of states and frames beyond compiler::kNearDepths.
void claimLaneMemory(compiler::GpuCode& code, const Programs& programs, unsigned depth) {
    constexpr uint64_t kAlignment = alignof(devlib::RayState);
    uint64_t most = 1;
    for (const compiler::GpuCode& part : programs.codes)
        most = std::max(most, part.frameBytes);
    code.frameBytes = (most + kAlignment - 1) / kAlignment * kAlignment;
    code.laneMemoryBytes =
        devlib::kGpuTile * devlib::FarLayout(depth, compiler::kNearDepths, code.frameBytes).bytes;
}

} // namespace

std::string compileReadyKernel(const compiler::GpuPipelineRequest& kernel,
                               compiler::ObjectStore* store) {
    KnownKernelCode& known = gpuProcess().kernels;
    const std::string key = compiler::keyOf(kernel.target, readyKernelId(kernel));
    std::string code;
    if (!known.find(key, code)) {
        code = codeOf(compiler::compileGpuPipeline(kernel).ptx, kernel.target.computeCapability,
                      readyKernelRegisters(kernel))
                   .value_or("");
        known.add(key, code);
        if (store && !code.empty() && !linksTexts())
            keepKernelCode(key, *store, code);
    }
    return code;
}

std::string readyKernelCode(const compiler::GpuPipelineRequest& kernel,
                            compiler::ObjectStore* store) {
    const compiler::GpuTarget& gpu = kernel.target;
    const std::string id = readyKernelId(kernel), key = compiler::keyOf(gpu, id);
    KnownKernelCode& known = gpuProcess().kernels;
    std::string code;
    if (const KernelImages* images = linksTexts() ? nullptr : usableKernelImages())
        code = images->find(gpu.computeCapability, gpu.driverVersion, id);
    if (!code.empty() || known.find(key, code))
        return code;
    if (store && !linksTexts() && findKernelCode(key, *store, code))
        known.add(key, code);
    else if (currentConfig(Setting::kGpuCode) == "ready")
        code = compileReadyKernel(kernel, store);
    return code;
}

std::optional<compiler::GpuCode> readyCodeOf(const compiler::GpuPipelineRequest& request,
                                             const compiler::GpuPipelineRequest& kernel,
                                             const std::string& kernelCode, CUcontext context) {
    const auto start = Clock::now();
    Programs programs;
    programs.compile(request, readyKernelRegisters(kernel));
    const CUjitInputType type = linksTexts() ? CU_JIT_INPUT_PTX : CU_JIT_INPUT_CUBIN;
    std::vector<LinkPart> parts = {{type, kernelCode}};
    for (size_t i = 0; i < programs.parts.size(); ++i) {
        if (programs.machineCodes[i].empty()) {
            log(LogLevel::kDebug, "engine",
                message("no code that is ready: ", programs.codes[i].hasState
                                                       ? "programs have variables"
                                                       : programs.codes[i].feedback));
            return {};
        }
        parts.push_back({type, programs.machineCodes[i]});
    }
    ContextScope scope(context);
    auto linked = linkParts(driver(), parts);
    if (!linked)
        return {};
    compiler::GpuCode code;
    code.feedback = programs.codes.front().feedback + "kernel: " + readyKernelId(kernel) + "\n";
    code.machineCode = std::move(*linked);
    code.stack.isMeasured = true; // the linker adds all frames to the kernel's
    code.takesTurns = code.recurses = true;
    code.walksInStep = compiler::mayWalkInStep(kernel);
    if (request.maxTraceDepth > compiler::kReadyDepth)
        claimLaneMemory(code, programs, request.maxTraceDepth);
    const std::chrono::duration<double, std::milli> time = Clock::now() - start;
    log(LogLevel::kDebug, "engine",
        message("pipeline for ", readyKernelId(kernel), " in ", time.count(), " ms"));
    return code;
}

} // namespace sunstone::engine
