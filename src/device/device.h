// SPDX-License-Identifier: Apache-2.0
// The one interface to hardware. A Device executes work in stream order on memory that programs
// reach by address. The CPU device (device/cpu) is the machine itself; streams are CUstream values
// of src/api/cuda, opaque here.
#pragma once

#include "base/error.h"

#include <cstddef>
#include <functional>

namespace sunstone::device {

// Device code has failed in this context, which can do nothing more: every call that needs it fails
// with the same error, whose number is that of the CUDA API. The context alone keeps it: queued work
// that throws this leaves no error with its stream.
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

    // Runs `work` after everything queued earlier on `stream` (null: the legacy default stream,
    // (void*)2: the per-thread default stream) and returns at once. What work throws becomes the
    // stream's error, seen by the next call on the stream. Throws Error(kInvalidValue) if `stream`
    // is not a live stream, and ContextFault if device code failed in the current context.
    virtual void enqueue(void* stream, std::function<void()> work) = 0;
    // The CUcontext a stream was made in; null for the default streams, which belong to whatever
    // context is current. Throws as enqueue does.
    virtual const void* streamContext(void* stream) = 0;
    // Waits for a stream; rethrows its pending error.
    virtual void synchronize(void* stream) = 0;
    // Waits for all streams; their errors stay with them.
    virtual void synchronizeAll() = 0;

    // The CUcontext current on this thread, or null. ownsContext: is it a live context of ours?
    virtual void* currentContext() = 0;
    virtual bool ownsContext(void* context) = 0;

    // Whether [address, address + size) can be read and written by device code: inside one live
    // allocation, or ordinary process memory. Never faults.
    virtual bool isAccessible(const void* address, size_t size) = 0;
};

// The CPU as a device; one per process.
Device& cpuDevice();

} // namespace sunstone::device
