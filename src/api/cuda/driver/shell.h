// SPDX-License-Identifier: Apache-2.0
// Shared by all driver API functions: the one place where C calls become C++ and errors become
// CUresult. Source files named *_streams.cpp are compiled twice: with
// CUDA_API_PER_THREAD_DEFAULT_STREAM the header gives their functions the _ptsz and _ptds names,
// and resolveStream maps a null stream to the calling thread's.
#pragma once

#include "base/error.h"
#include "device/cpu/context.h"
#include "device/cpu/event.h"
#include "device/cpu/memory.h"
#include "device/cpu/stream.h"

#include <cuda.h>

#include <atomic>
#include <functional>

#define SUNSTONE_EXPORT extern "C" __attribute__((visibility("default")))

namespace sunstone::api::cuda {

namespace cpu = sunstone::device::cpu;

// A failure thrown with its CUresult.
class Failure : public Error {
public:
    Failure(CUresult result, const std::string& text)
        : Error(Code::kInvalidValue, text), result_(result) {}
    CUresult result() const { return result_; }

private:
    CUresult result_;
};

template <class... Parts>
[[noreturn]] void refuse(CUresult result, const Parts&... parts) {
    throw Failure(result, message(parts...));
}
// Throws CUDA_ERROR_INVALID_VALUE unless the condition holds.
inline void require(bool condition, const char* text) {
    if (!condition)
        throw Failure(CUDA_ERROR_INVALID_VALUE, text);
}

// The precondition of an entry point. kObject: the call names an object, whose context need not be
// current; if a context is current, no device code has failed in it. kAnyContext: a current
// context. kContext: a current context in which no device code has failed, before the call or while
// it waits. kQueue: the same, checked only before the call, for functions that queue work and
// return (a later failure is a matter of timing).
enum class Needs { kNothing, kInit, kObject, kAnyContext, kContext, kQueue };
// For functions that share a body: whether this one waits for the work.
constexpr Needs needsToQueue(bool waits) {
    return waits ? Needs::kContext : Needs::kQueue;
}

// With a stream that the program created, that stream's context is current during the call.
struct Precondition {
    Precondition(Needs needed) : needs(needed) {}
    Precondition(Needs needed, CUstream named) : needs(needed), stream(named) {}

    Needs needs;
    CUstream stream = nullptr;
};

// Runs a body, logs its exceptions with the function's name, and returns the code. A CUresult
// returned by the body is passed on.
CUresult guardedCall(const char* function, Precondition precondition,
                     const std::function<CUresult()>& body);
template <class Body>
CUresult guarded(const char* function, Precondition needs, Body&& body) {
    if constexpr (std::is_void_v<decltype(body())>)
        return guardedCall(function, needs, [&] {
            body();
            return CUDA_SUCCESS;
        });
    else
        return guardedCall(function, needs, body);
}

// Makes a context current on this thread during its lifetime.
class ContextScope {
public:
    explicit ContextScope(cpu::Context* context) : isNeeded_(context != cpu::contexts().current()) {
        if (isNeeded_)
            cpu::contexts().push(context);
    }
    ~ContextScope() {
        if (isNeeded_)
            cpu::contexts().pop();
    }
    ContextScope(const ContextScope&) = delete;
    ContextScope& operator=(const ContextScope&) = delete;

private:
    const bool isNeeded_;
};

CUresult resultOf(Code code);
const char* nameOf(CUresult result); // null if unknown
const char* textOf(CUresult result);

void initialize(unsigned flags);
void requireDevice(CUdevice device);             // CUDA_ERROR_INVALID_DEVICE unless it is ours
cpu::Context* requireContext(CUcontext context); // a live context, or CUDA_ERROR_INVALID_CONTEXT

inline cpu::StreamPtr streamOf(void* handle) {
    try {
        return cpu::streams().find(handle);
    } catch (const Error& error) {
        throw Failure(CUDA_ERROR_INVALID_HANDLE, error.what());
    }
}
// See the head comment.
inline cpu::StreamPtr resolveStream(CUstream stream) {
#ifdef CUDA_API_PER_THREAD_DEFAULT_STREAM
    if (!stream)
        stream = CU_STREAM_PER_THREAD;
#endif
    return streamOf(stream);
}
std::shared_ptr<cpu::Event> eventOf(CUevent event);

// Device properties shared by attribute queries, launches and occupancy.
constexpr int kMajor = 7, kMinor = 5;
constexpr int kDriverVersion = 13000;
constexpr unsigned kWarpSize = 32;
constexpr unsigned kMaxThreads = 1024;
constexpr unsigned kMaxBlock[3] = {1024, 1024, 64};
constexpr unsigned kMaxGrid[3] = {2147483647u, 65535, 65535};
constexpr unsigned kSharedPerBlock = 48 << 10;
constexpr unsigned kSharedOptin = 64 << 10;
constexpr unsigned kSharedPerProcessor = 64 << 10;
constexpr unsigned kReservedShared = 0;
constexpr unsigned kThreadsPerProcessor = 1024;
constexpr unsigned kBlocksPerProcessor = 16;
constexpr unsigned kRegisters = 65536;
constexpr size_t kPitchAlignment = 512;
constexpr size_t kMaxPitch = 2147483647;

} // namespace sunstone::api::cuda
