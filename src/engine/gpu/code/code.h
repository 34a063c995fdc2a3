// SPDX-License-Identifier: Apache-2.0
// Machine code of pipelines in a CUDA context, shared by equal pipelines.
#pragma once

#include "compiler/gpu/pipeline.h"
#include "device/cuda/driver.h"
#include "devlib/gpu/launch_block.h"
#include "engine/backend.h"
#include "engine/gpu/code/code_queue.h"
#include "engine/gpu/code/narrow_code.h"
#include "engine/gpu/patience.h"

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace sunstone::engine {

// A loaded module. All its launches have ended before its destruction; the context need not be
// current then.
class LoadedGpuCode {
public:
    // Loads the machine code, or the text if the driver accepts no machine code. The context is
    // current. Throws kLinkError with the driver's message if it refuses the text too, or if there
    // is none. `log`: the compiler's report on functions, or empty.
    LoadedGpuCode(CUcontext context, const compiler::GpuCode& code, unsigned maxRegisters,
                  std::string& log);
    ~LoadedGpuCode();
    LoadedGpuCode(const LoadedGpuCode&) = delete;
    LoadedGpuCode& operator=(const LoadedGpuCode&) = delete;
    CUfunction kernel = nullptr;
    bool isOfText = false; // not of machine code

private:
    CUresult load(const std::string& machineCode);
    void compileText(const std::string& ptx, unsigned maxRegisters, std::string& log);

    CUcontext context_;
    CUmodule module_ = nullptr;
};

// Which launches wait until the whole pipeline is compiled. The first ones show a picture early.
// Programs that launch more often gain from the wait: all further frames have the speed of the
// whole pipeline. Small launches, of which some programs make hundreds for a picture, gain less
// than the wait costs.
class WaitsForWhole {
public:
    static constexpr uint64_t kLargeLaunch = 1 << 16; // indices
    static bool isLarge(uint64_t indices) { return indices >= kLargeLaunch; }
    // Whether a launch on an idle stream waits. Counts the launch.
    bool next(uint64_t indices) { return isLarge(indices) && ++large_ > 2; }
    // How long that launch waits for its stream to become idle: applications may queue builds just
    // before each launch. Kernels that run for ever must not delay all launches.
    std::chrono::microseconds patience() const {
        constexpr unsigned kTries = 10;
        return std::chrono::microseconds(large_ > 2 && large_ <= kTries ? 20000 : 200);
    }

private:
    unsigned large_ = 0;
};

// Code of one pipeline for one kind of graphs. The destructor waits for its launches.
class GpuCodeObject {
public:
    GpuCodeObject(CUcontext context, std::shared_ptr<const LoadedGpuCode> code)
        : kernel(code->kernel), context_(context), code_(std::move(code)) {}
    ~GpuCodeObject();
    GpuCodeObject(const GpuCodeObject&) = delete;
    GpuCodeObject& operator=(const GpuCodeObject&) = delete;
    const CUfunction kernel;
    uint32_t firstGroup = 0; // base of group numbers in the code
    uint32_t groupCount = 0; // group numbers from there on
    unsigned blockThreads = 0;
    // Bytes of stack that the programs take for traces of full depth and callables two deep.
    // stackBytes: the limit for a launch index with stack overflow exceptions.
    size_t neededStack = 0;
    size_t reservedStack = 0;           // part of neededStack for functions that do not check
    devlib::LaneMemory laneMemory = {}; // claimed by its warps, if any
    unsigned mostBlocks = ~0u;          // of a launch, so that each warp has lane memory
    std::atomic<size_t> stackBytes = 0;
    std::string feedback; // messages of the compiler
    WaitsForWhole waits;
    // Faster code that replaces this code when it is compiled, or null.
    std::shared_ptr<const GpuLaterCode> later;
    // Narrow code that is compiled before that, or null.
    std::shared_ptr<const GpuLaterCode> narrow;
    GpuCodeKind narrowKind;
    const std::shared_ptr<LaunchFindings> findings = std::make_shared<LaunchFindings>();

private:
    CUcontext context_;
    std::shared_ptr<const LoadedGpuCode> code_;
};

// The code of one pipeline, which depends on the depth of graphs that the pipeline declares. Any
// thread may call.
class GpuPipelineCode final : public DeviceCode {
public:
    // Makes code. Null where programs have variables, because code for other graphs would have
    // copies of them. Never null for kGraphAny. `later`: the code to load, or null.
    using Make = std::function<std::shared_ptr<GpuCodeObject>(GpuCodeKind, const GpuLaterCode*)>;
    static constexpr unsigned kShallowDepth = 2; // of devlib::kGraphShallow
    // prepare: see GpuNarrowCodes; empty: the pipeline has no narrow code. flags:
    // OptixTraversableGraphFlags.
    GpuPipelineCode(Make make, GpuNarrowCodes::Prepare prepare, unsigned flags, bool motion)
        : make_(std::move(make)), flags_(flags),
          motion_(motion ? devlib::kMotionAll : devlib::kMotionNone), narrow_(std::move(prepare)) {}

    // The code for graphs of this depth, or for any, made if there is none. Throws what `make`
    // throws.
    std::shared_ptr<GpuCodeObject> get(unsigned depth);
    // The same for a launch of that many indices. Loads code that has become ready if the stream is
    // idle: a load waits for kernels that run, and these may wait for the caller. The third large
    // launch on an idle stream, and later ones, wait for that code. `there`: the traversables of
    // the process; the launch may get code for these alone, unless it is captured.
    std::shared_ptr<GpuCodeObject> getForLaunch(unsigned depth, const GpuGraphs& there,
                                                CUstream stream, uint64_t indices);

private:
    // With the mutex:
    std::shared_ptr<GpuCodeObject>& find(devlib::GraphKind kind);
    std::shared_ptr<GpuCodeObject> make(devlib::GraphKind kind, const GpuLaterCode* later);
    std::shared_ptr<GpuCodeObject> findNarrow(GpuCodeKind kind, uint64_t indices,
                                              const std::function<bool()>& isIdle);
    void replace(std::shared_ptr<GpuCodeObject>& code);

    const Make make_;
    const unsigned flags_;
    const devlib::MotionKind motion_;
    std::mutex mutex_;
    GpuNarrowCodes narrow_; // with the mutex

    // By GraphKind, and code that other code has replaced. None is unloaded before the pipeline is
    // destroyed: captured graphs may launch it.
    std::shared_ptr<GpuCodeObject> codes_[devlib::kGraphKinds];
    std::vector<std::shared_ptr<GpuCodeObject>> replaced_;
};

// Recently loaded code and its compiler's messages, by the key of the request. Code with module
// variables is not shared and not kept here. Any thread may call.
class LoadedGpuCodes {
public:
    struct Entry {
        std::string key;
        std::shared_ptr<const LoadedGpuCode> loaded;
        std::shared_ptr<const compiler::GpuCode> code; // without text and machine code
        std::shared_ptr<const GpuLaterCode> later;     // GpuCodeObject::later
    };
    static constexpr size_t kMost = 16; // a few hundred kilobytes of device memory each, at most

    // Null members if not found.
    Entry find(const std::string& key);
    void add(Entry entry);

private:
    std::mutex mutex_;
    std::vector<Entry> entries_; // the one used last at the end
};

} // namespace sunstone::engine
