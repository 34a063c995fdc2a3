// SPDX-License-Identifier: Apache-2.0
// Kernels of the library itself (builders of acceleration structures, denoisers) in a CUDA context.
// Each kernel is a module of its own and calls no other kernel, so many threads can make machine
// code at once, and only the kernels in use are compiled.
#pragma once

#include "device/cuda/driver.h"
#include "device/cuda/ptx_parts.h"

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
    std::string name;                  // of the kernel's entry
    std::string id;                    // unique among the kernels of the library
    std::function<std::string()> text; // a PTX module of the kernel; any thread may call it
};

// Makes machine code of kernels or finds it in a store. Any thread may call.
class MachineCodeSource {
public:
    virtual ~MachineCodeSource() = default;
    // The code of each kernel; empty if it cannot be made and the driver has to compile the text.
    // `anew`: stored code did not load and must be made again.
    virtual std::vector<std::string> machineCode(std::span<const KernelSource* const> kernels,
                                                 bool anew) = 0;
};

// All calls need the context that was current in the constructor. They may come from any thread,
// also while a graph is captured (see ContextScope).
class KernelSet {
public:
    // With a null source the driver compiles all texts.
    KernelSet(const Driver& driver, MachineCodeSource* source, std::vector<KernelSource> kernels);
    ~KernelSet();
    KernelSet(const KernelSet&) = delete;
    KernelSet& operator=(const KernelSet&) = delete;

    // Makes and loads machine code of these kernels in parallel; the driver may wait for the GPU.
    // Returns at once if all of them are loaded.
    void prepare(std::span<const uint32_t> kernels);
    // The same for every kernel of the set.
    void prepareAll();
    // The context was destroyed, and the modules with it: the destructor does not call the driver.
    void abandon() { modules_.clear(); }
    // The kernel, which is prepared first if it is not loaded.
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

// Splits a PTX module into modules of one kernel each, with the functions it calls and all
// variables. The text must outlive this object.
class KernelTexts {
public:
    explicit KernelTexts(std::string_view ptx);
    std::string moduleOf(std::string_view kernel) const;

private:
    std::vector<PtxPiece> pieces_;
};

} // namespace sunstone::device::cuda
