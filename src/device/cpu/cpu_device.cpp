// SPDX-License-Identifier: Apache-2.0
// The CPU as a Device: implements device.h with streams, memory and contexts.
#include "base/error.h"
#include "device/cpu/context.h"
#include "device/cpu/memory.h"
#include "device/cpu/pages.h"
#include "device/cpu/stream.h"
#include "device/device.h"

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

void lendToCpuDevice(void* memory, size_t size) {
    // Refused where the application has registered the addresses.
    cpu::memory().adopt(memory, size, cpu::MemoryKind::kManagedVariable, 0, nullptr);
}
void takeFromCpuDevice(void* memory) noexcept {
    cpu::memory().release(memory, {cpu::MemoryKind::kManagedVariable});
}
bool isCpuDeviceAddress(const void* address) {
    return cpu::pages().holds(address);
}

Device& cpuDevice() {
    static CpuDevice* device = new CpuDevice; // outlives every worker thread
    return *device;
}

} // namespace sunstone::device
