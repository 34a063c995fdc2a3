// SPDX-License-Identifier: Apache-2.0
// The one interface to hardware. A Device runs work in stream order on memory that programs reach
// by address. The CPU device (device/cpu) is the machine itself; its streams are CUstream values of
// src/api/cuda, opaque here.
#pragma once

#include "base/error.h"

#include <cstddef>
#include <functional>

namespace sunstone::device {

// Device code has failed in this context. Every later call that needs the context fails with the
// same error, whose number is that of the CUDA API. Only the context keeps the error: queued work
// that throws it leaves no error with its stream.
class ContextFault : public Error {
public:
    ContextFault(int number, const std::string& text)
        : Error(Code::kCudaError, text), number_(number) {}
    int number() const { return number_; }

private:
    int number_;
};

class Device {
public:
    virtual ~Device() = default;
    virtual const char* name() const = 0;

    // Runs `work` after all work queued earlier on `stream` (null: the legacy default stream,
    // (void*)2: the per-thread default stream) and returns at once. An exception of `work` becomes
    // the stream's error, which the next call on the stream throws. Throws Error(kInvalidValue) if
    // `stream` is not a live stream, and ContextFault if device code failed in the current context.
    virtual void enqueue(void* stream, std::function<void()> work) = 0;
    // The CUcontext in which a stream was created; null for the default streams, which belong to
    // the current context. Throws like enqueue.
    virtual const void* streamContext(void* stream) = 0;
    // Whether a stream has no work left. False while it captures.
    virtual bool isIdle(void* stream) = 0;
    // Waits for a stream; rethrows its pending error.
    virtual void synchronize(void* stream) = 0;
    // Waits for all streams; errors stay with their streams.
    virtual void synchronizeAll() = 0;

    // The CUcontext current on this thread, or null. ownsContext: whether `context` is a live
    // context of this device.
    virtual void* currentContext() = 0;
    virtual bool ownsContext(void* context) = 0;

    // Whether device code can read and write [address, address + size): the range lies in one live
    // allocation or in ordinary process memory. Never faults.
    virtual bool isAccessible(const void* address, size_t size) = 0;
};

// The CPU as a device; one per process.
Device& cpuDevice();

// Zeroed memory of the library for host and device code of the CPU, aligned to 128 bytes. CUDA
// calls treat it as managed memory, and do not free it. Throws kOutOfMemory.
void* allocateCpuShared(size_t size);
void freeCpuShared(void* memory) noexcept;
// Whether the address lies in ranges that contain only the CPU device's memory.
bool isCpuDeviceAddress(const void* address);

} // namespace sunstone::device
