// SPDX-License-Identifier: Apache-2.0
// See shell.h.
#include "api/cuda/driver/shell.h"

#include "api/cuda/driver/visible_devices.h"
#include "base/config.h"
#include "base/forked.h"
#include "base/log.h"
#include "base/process_end.h"
#include "check/memory_check.h"
#include "device/device.h"

#include <new>

namespace sunstone::api::cuda {

namespace {

std::atomic<bool> initialized{false};

} // namespace

void initialize(unsigned flags) {
    require(flags == 0, "flags of cuInit must be 0");
    const std::string visible = currentConfig(Setting::kVisibleDevices);
    if (isSet(Setting::kVisibleDevices) && !showsDevice(visible))
        refuse(CUDA_ERROR_NO_DEVICE, "CUDA_VISIBLE_DEVICES=\"", visible,
               "\" names no device; the CPU is device 0");
    initialized.store(true, std::memory_order_release);
    watchForks();
    check::start();
    watchProcessEnd();
}

CUresult resultOf(Code code) {
    switch (code) {
    case Code::kOk:
        return CUDA_SUCCESS;
    case Code::kInvalidValue:
        return CUDA_ERROR_INVALID_VALUE;
    case Code::kOutOfMemory:
        return CUDA_ERROR_OUT_OF_MEMORY;
    case Code::kInvalidOperation:
        return CUDA_ERROR_ILLEGAL_STATE;
    case Code::kNotSupported:
        return CUDA_ERROR_NOT_SUPPORTED;
    case Code::kInvalidPtx:
    case Code::kInvalidPayloadAccess:
    case Code::kInvalidAttributeAccess:
    case Code::kInvalidFunctionUse:
    case Code::kInvalidFunctionArguments:
    case Code::kLinkError:
        return CUDA_ERROR_INVALID_PTX;
    case Code::kInvalidContext:
        return CUDA_ERROR_INVALID_CONTEXT;
    case Code::kNotInitialized:
        return CUDA_ERROR_NOT_INITIALIZED;
    case Code::kNotFound:
        return CUDA_ERROR_NOT_FOUND;
    case Code::kFileError:
        return CUDA_ERROR_FILE_NOT_FOUND;
    case Code::kInvalidLaunchParameter:
        return CUDA_ERROR_INVALID_VALUE;
    case Code::kLaunchFailure:
        return CUDA_ERROR_LAUNCH_FAILED;
    default:
        return CUDA_ERROR_UNKNOWN;
    }
}

namespace {

// The context of a stream that the program created, else the current one.
cpu::ContextPtr contextFor(CUstream stream) {
    if (const cpu::StreamPtr named = cpu::streams().findCreated(stream))
        if (cpu::ContextPtr owner = cpu::contexts().find(named->owner()))
            return owner;
    return cpu::contexts().shareCurrent();
}

} // namespace

CUresult guardedCall(const char* function, Precondition precondition,
                     const std::function<CUresult()>& body) {
    const Needs needs = precondition.needs;
    // As with a GPU's driver, functions that need no initialisation still work.
    if (needs != Needs::kNothing && refusesForkedChild())
        return CUDA_ERROR_NOT_INITIALIZED;
    auto report = [&](CUresult result, const char* text) {
        log(LogLevel::kError, "cuda", message(function, ": ", nameOf(result), ": ", text));
        return result;
    };
    // Errors that need an explanation are logged once even if the log is off.
    auto explain = [&](CUresult result, const char* text) {
        if (!logEnabled(LogLevel::kError, "cuda"))
            logOnce(LogLevel::kFatal, "cuda", message(nameOf(result), ": ", text));
        return report(result, text);
    };
    try {
        if (needs != Needs::kNothing && !initialized.load(std::memory_order_acquire))
            return report(CUDA_ERROR_NOT_INITIALIZED, "cuInit has not been called");
        if (needs < Needs::kObject)
            return body();
        const cpu::ContextPtr context = contextFor(precondition.stream);
        if (!context && needs == Needs::kObject)
            return body();
        if (!context)
            return report(CUDA_ERROR_INVALID_CONTEXT, "no context is current on this thread");
        const ContextScope scope(context.get());
        if (needs == Needs::kAnyContext)
            return body();
        const auto failed = [&](int fault) {
            const std::string text = "device code has failed in this context: ";
            return explain(CUresult(fault), (text + context->faultText()).c_str());
        };
        if (const int fault = context->fault)
            return failed(fault);
        const CUresult result = body();
        // The context may have failed while the call waited.
        if (result == CUDA_SUCCESS && needs != Needs::kQueue)
            if (const int fault = context->fault)
                return failed(fault);
        return result;
    } catch (const ProcessEnds& end) {
        return report(CUDA_ERROR_DEINITIALIZED, end.what());
    } catch (const device::ContextFault& fault) {
        return explain(CUresult(fault.number()), fault.what());
    } catch (const Failure& failure) {
        const CUresult result = failure.result();
        return result == CUDA_ERROR_NOT_SUPPORTED || result == CUDA_ERROR_INVALID_PTX ||
                       result == CUDA_ERROR_NO_BINARY_FOR_GPU
                   ? explain(result, failure.what())
                   : report(result, failure.what());
    } catch (const cpu::CaptureError& error) {
        return report(CUresult(error.number()), error.what());
    } catch (const Error& error) {
        const CUresult result = resultOf(error.code());
        return result == CUDA_ERROR_NOT_SUPPORTED || result == CUDA_ERROR_INVALID_PTX
                   ? explain(result, error.what())
                   : report(result, error.what());
    } catch (const std::bad_alloc&) {
        return report(CUDA_ERROR_OUT_OF_MEMORY, "no host memory");
    } catch (const std::exception& error) {
        return report(CUDA_ERROR_UNKNOWN, error.what());
    } catch (...) {
        return report(CUDA_ERROR_UNKNOWN, "unknown exception");
    }
}

void requireDevice(CUdevice device) {
    if (device != 0)
        refuse(CUDA_ERROR_INVALID_DEVICE, "device ", device, " does not exist; there is 1");
}

cpu::Context* requireContext(CUcontext context) {
    cpu::ContextPtr live = cpu::contexts().find(context);
    if (!live)
        refuse(CUDA_ERROR_INVALID_CONTEXT, "context ", static_cast<void*>(context), " is not live");
    return live.get();
}

} // namespace sunstone::api::cuda

using namespace sunstone::api::cuda;

SUNSTONE_EXPORT CUresult cuInit(unsigned int flags) {
    if (sunstone::refusesForkedChild())
        return CUDA_ERROR_NOT_INITIALIZED;
    return guarded("cuInit", Needs::kNothing, [&] { initialize(flags); });
}

SUNSTONE_EXPORT CUresult cuDriverGetVersion(int* version) {
    return guarded("cuDriverGetVersion", Needs::kNothing, [&] {
        require(version, "version is null");
        *version = kDriverVersion;
    });
}

SUNSTONE_EXPORT CUresult cuGetErrorName(CUresult error, const char** name) {
    if (!name)
        return CUDA_ERROR_INVALID_VALUE;
    *name = nameOf(error);
    return *name ? CUDA_SUCCESS : CUDA_ERROR_INVALID_VALUE;
}

SUNSTONE_EXPORT CUresult cuGetErrorString(CUresult error, const char** text) {
    if (!text)
        return CUDA_ERROR_INVALID_VALUE;
    *text = textOf(error);
    return *text ? CUDA_SUCCESS : CUDA_ERROR_INVALID_VALUE;
}

SUNSTONE_EXPORT CUresult cuProfilerStart(void) {
    return guarded("cuProfilerStart", Needs::kAnyContext, [] {});
}
SUNSTONE_EXPORT CUresult cuProfilerStop(void) {
    return guarded("cuProfilerStop", Needs::kAnyContext, [] {});
}
