// SPDX-License-Identifier: Apache-2.0
// Kernels of the library itself (builders of acceleration structures, denoisers) in a CUDA context.
// Each is a module of its own: kernels call nothing of one another, so that their machine code can
// be made by many threads at a time, and what nobody needs is never made.
#pragma once

#include "device/cuda/driver.h"

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sunstone::device::cuda {

struct KernelSource {
    std::string name;                  // of the entry
    std::string id;                    // tells it from all other kernels of the library
    std::function<std::string()> text; // a PTX module of the kernel; any thread may call it
};

// Makes machine code of kernels, or has kept it. Any thread may call.
class MachineCodeSource {
public:
    virtual ~MachineCodeSource() = default;
    // Of each kernel; empty where there is none to be had, and the driver is to compile the text.
    // `anew`: what is kept is of no use.
    virtual std::vector<std::string> machineCode(std::span<const KernelSource* const> kernels,
                                                 bool anew) = 0;
};

// Calls must be made with the context current that was so when it was made; they may come from any
// thread, and while a graph is captured (see ContextScope).
class KernelSet {
public:
    // Without a source the driver compiles all texts.
    KernelSet(const Driver& driver, MachineCodeSource* source, std::vector<KernelSource> kernels);
    ~KernelSet();
    KernelSet(const KernelSet&) = delete;
    KernelSet& operator=(const KernelSet&) = delete;

    // Has machine code of these kernels made, together, and loads them; the driver may wait for the
    // GPU then. Returns at once where all of them are there.
    void prepare(std::span<const uint32_t> kernels);
    // Prepares the kernel if it is not there.
    CUfunction function(uint32_t kernel);
    const KernelSource& source(uint32_t kernel) const { return kernels_[kernel]; }

private:
    enum class State : uint8_t { kNone, kUnderWay, kReady };
    bool areReady(std::span<const uint32_t> kernels) const;
    void load(const std::vector<uint32_t>& kernels);
    CUfunction loadOne(uint32_t kernel, std::string code);

    const Driver& driver_;
    MachineCodeSource* source_;
    std::vector<KernelSource> kernels_;
    std::unique_ptr<std::atomic<CUfunction>[]> functions_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<State> states_;
    std::vector<CUmodule> modules_;
};

// A PTX module, taken apart into modules of one kernel each, with the functions it calls and all
// variables. Kernels and functions begin at the start of a line, as LLVM writes them. The text
// stays.
class KernelTexts {
public:
    explicit KernelTexts(std::string_view ptx);
    std::string moduleOf(std::string_view kernel) const;

private:
    // A kernel, a definition or declaration of a function, or what is between these.
    struct Piece {
        std::string_view text, name; // of a kernel or function
        bool isKernel = false;
    };
    std::vector<Piece> pieces_;
};

} // namespace sunstone::device::cuda
