// SPDX-License-Identifier: Apache-2.0
// Machine code of pipelines in a CUDA context, shared by the pipelines that are the same.
#pragma once

#include "compiler/gpu/pipeline.h"
#include "device/cuda/driver.h"
#include "engine/backend.h"

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace sunstone::engine {

// A loaded module. Nothing may run it any more when it dies; then the context need not be current.
class LoadedGpuCode {
public:
    // Loads the machine code, or the text where there is none, or none that the driver takes. The
    // context is current. Throws kLinkError with what the driver has to say if it refuses the text,
    // or has none. `log`: what its compiler tells of functions, or empty.
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

// The code of one pipeline. Waits for its launches when it dies.
class GpuCodeObject final : public DeviceCode {
public:
    GpuCodeObject(CUcontext context, std::shared_ptr<const LoadedGpuCode> code)
        : kernel(code->kernel), context_(context), code_(std::move(code)) {}
    ~GpuCodeObject() override;
    const CUfunction kernel;
    uint32_t firstGroup = 0; // what the code counts group numbers from
    // Bytes of stack that the programs take for traces of full depth and callables two deep, beside
    // what a launch index may use of what there is, with stack overflow exceptions.
    size_t neededStack = 0;
    size_t reservedStack = 0; // of it, for functions that do not check
    std::atomic<size_t> stackBytes = 0;
    // What rays of the last launch were given, if launches said; these may outlive the pipeline.
    const std::shared_ptr<std::atomic<uint64_t>> usualHandle =
        std::make_shared<std::atomic<uint64_t>>(0);

private:
    CUcontext context_;
    std::shared_ptr<const LoadedGpuCode> code_;
};

// What was loaded of late, and what compiling had to say of it, by the key of its request. Code with
// variables of its own is not for sharing and does not come here. Any thread may call.
class LoadedGpuCodes {
public:
    struct Entry {
        std::string key;
        std::shared_ptr<const LoadedGpuCode> loaded;
        std::shared_ptr<const compiler::GpuCode> code; // without text and machine code
    };
    static constexpr size_t kMost = 16; // a few hundred kilobytes of device memory each, at most

    // Null members where there is none.
    Entry find(const std::string& key);
    void add(Entry entry);

private:
    std::mutex mutex_;
    std::vector<Entry> entries_; // the one used last at the end
};

} // namespace sunstone::engine
