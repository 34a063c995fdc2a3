// SPDX-License-Identifier: Apache-2.0
// The CPU as a Device: implements device.h with streams, memory and contexts.
#include "base/error.h"
#include "device/cpu/context.h"
#include "device/cpu/memory.h"
#include "device/cpu/pages.h"
#include "device/cpu/stream.h"
#include "device/device.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

namespace sunstone::device {

namespace {

class CpuDevice final : public Device {
public:
    const char* name() const override { return "Sunstone CPU"; }

    void enqueue(void* stream, std::function<void()> work) override {
        requireNoFault();
        cpu::streams().submit(cpu::streams().find(stream), std::move(work));
    }
    const void* streamContext(void* stream) override {
        return cpu::streams().isDefault(stream) ? nullptr : cpu::streams().find(stream)->owner();
    }
    bool isIdle(void* stream) override {
        const cpu::StreamPtr found = cpu::streams().find(stream);
        return !cpu::streams().captureState(found).capture && cpu::streams().idle(found);
    }
    void synchronize(void* stream) override {
        cpu::streams().synchronize(cpu::streams().find(stream));
        requireNoFault();
    }
    void synchronizeAll() override { cpu::streams().waitAll(); }

    void* currentContext() override { return cpu::contexts().current(); }
    bool ownsContext(void* context) override { return cpu::contexts().find(context) != nullptr; }

    bool isAccessible(const void* address, size_t size) override {
        if (cpu::memory().find(address))
            return cpu::memory().contains(address, size);
        return cpu::isMappedReadWrite(address, size);
    }

private:
    static void requireNoFault() {
        const cpu::ContextPtr context = cpu::contexts().shareCurrent();
        if (const int fault = context ? context->fault.load() : 0)
            throw ContextFault(fault,
                               message("device code has failed in the current CUDA context (CUDA "
                                       "error ",
                                       fault, "): ", context->faultText()));
    }
};

} // namespace

void* allocateCpuShared(size_t size) {
    // The device's memory begins at pages. Fresh pages are zero and take no memory before they are
    // used; small pieces would waste them.
    constexpr size_t kOwnPagesFrom = 256 << 10, kAlignment = 128;
    if (size >= kOwnPagesFrom)
        return cpu::memory().allocateZeroed(size, cpu::MemoryKind::kShared, 0, nullptr);
    void* memory = nullptr;
    const size_t whole = std::max((size + kAlignment - 1) / kAlignment * kAlignment, kAlignment);
    if (posix_memalign(&memory, kAlignment, whole) != 0)
        fail(Code::kOutOfMemory, "no memory for ", size, " bytes");
    std::memset(memory, 0, whole);
    // Refused where the application has registered the addresses.
    cpu::memory().adopt(memory, std::max<size_t>(size, 1), cpu::MemoryKind::kLent, 0, nullptr);
    return memory;
}

void freeCpuShared(void* memory) noexcept {
    if (cpu::memory().release(memory, {cpu::MemoryKind::kShared}))
        return;
    cpu::memory().release(memory, {cpu::MemoryKind::kLent});
    std::free(memory);
}

bool isCpuDeviceAddress(const void* address) {
    return cpu::pages().holds(address);
}

Device& cpuDevice() {
    static CpuDevice* device = new CpuDevice; // outlives every worker thread
    return *device;
}

} // namespace sunstone::device
