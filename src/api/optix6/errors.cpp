// SPDX-License-Identifier: Apache-2.0
// Results: their texts, the conversion from engine codes, and the guard of every entry point.
#include "api/optix6/call.h"
#include "base/threads/thread_object.h"

namespace sunstone::optix6 {

const char* textOf(RTresult result) {
    switch (result) {
    case RT_SUCCESS:
        return "Success";
    case RT_TIMEOUT_CALLBACK:
        return "Stopped by the timeout callback";
    case RT_ERROR_INVALID_CONTEXT:
        return "Invalid context";
    case RT_ERROR_INVALID_VALUE:
        return "Invalid value";
    case RT_ERROR_MEMORY_ALLOCATION_FAILED:
        return "Memory allocation failed";
    case RT_ERROR_TYPE_MISMATCH:
        return "Type mismatch";
    case RT_ERROR_VARIABLE_NOT_FOUND:
        return "Variable not found";
    case RT_ERROR_VARIABLE_REDECLARED:
        return "Variable redeclared";
    case RT_ERROR_ILLEGAL_SYMBOL:
        return "Illegal symbol";
    case RT_ERROR_INVALID_SOURCE:
        return "Invalid source";
    case RT_ERROR_VERSION_MISMATCH:
        return "Version mismatch";
    case RT_ERROR_OBJECT_CREATION_FAILED:
        return "Object creation failed";
    case RT_ERROR_NO_DEVICE:
        return "No device";
    case RT_ERROR_INVALID_DEVICE:
        return "Invalid device";
    case RT_ERROR_INVALID_IMAGE:
        return "Invalid image";
    case RT_ERROR_FILE_NOT_FOUND:
        return "File not found";
    case RT_ERROR_ALREADY_MAPPED:
        return "Already mapped";
    case RT_ERROR_INVALID_DRIVER_VERSION:
        return "Invalid driver version";
    case RT_ERROR_CONTEXT_CREATION_FAILED:
        return "Context creation failed";
    case RT_ERROR_RESOURCE_NOT_REGISTERED:
        return "Resource not registered";
    case RT_ERROR_RESOURCE_ALREADY_REGISTERED:
        return "Resource already registered";
    case RT_ERROR_OPTIX_NOT_LOADED:
        return "Library not loaded";
    case RT_ERROR_DENOISER_NOT_LOADED:
        return "Denoiser not loaded";
    case RT_ERROR_SSIM_PREDICTOR_NOT_LOADED:
        return "SSIM predictor not loaded";
    case RT_ERROR_DRIVER_VERSION_FAILED:
        return "Driver version is not known";
    case RT_ERROR_LAUNCH_FAILED:
        return "Launch failed";
    case RT_ERROR_NOT_SUPPORTED:
        return "Not supported";
    case RT_ERROR_CONNECTION_FAILED:
        return "Connection failed";
    case RT_ERROR_AUTHENTICATION_FAILED:
        return "Authentication failed";
    case RT_ERROR_CONNECTION_ALREADY_EXISTS:
        return "Connection already exists";
    case RT_ERROR_NETWORK_LOAD_FAILED:
        return "Network library not loaded";
    case RT_ERROR_NETWORK_INIT_FAILED:
        return "Network not initialised";
    case RT_ERROR_CLUSTER_NOT_RUNNING:
        return "Cluster not running";
    case RT_ERROR_CLUSTER_ALREADY_RUNNING:
        return "Cluster already running";
    case RT_ERROR_INSUFFICIENT_FREE_NODES:
        return "Not enough free nodes";
    case RT_ERROR_INVALID_GLOBAL_ATTRIBUTE:
        return "Invalid global attribute";
    case RT_ERROR_UNKNOWN:
        return "Unknown error";
    }
    return "Unknown result";
}

RTresult resultOf(Code code) {
    switch (code) {
    case Code::kInvalidValue:
    case Code::kCacheInvalidPath:
        return RT_ERROR_INVALID_VALUE;
    case Code::kOutOfMemory:
        return RT_ERROR_MEMORY_ALLOCATION_FAILED;
    case Code::kNotSupported:
        return RT_ERROR_NOT_SUPPORTED;
    case Code::kInvalidPtx:
    case Code::kInvalidFunctionUse:
    case Code::kInvalidFunctionArguments:
    case Code::kInvalidAttributeAccess:
    case Code::kInvalidPayloadAccess:
    case Code::kOutOfConstantMemory:
    case Code::kNotFound:
    case Code::kLinkError:
        return RT_ERROR_INVALID_SOURCE;
    case Code::kInvalidContext:
        return RT_ERROR_INVALID_CONTEXT;
    case Code::kLaunchFailure:
        return RT_ERROR_LAUNCH_FAILED;
    case Code::kFileError:
        return RT_ERROR_FILE_NOT_FOUND;
    default:
        return RT_ERROR_UNKNOWN;
    }
}

namespace {

std::string& lostFailure() {
    struct Text {
        std::string text;
    };
    return threadObject<Text>().text;
}

} // namespace

const std::string& failureWithoutContext() {
    return lostFailure();
}

RTresult guarded(const std::shared_ptr<Context>& context, const char* function,
                 const std::function<void()>& body) {
    if (refusesForkedChild()) // rtContextGetErrorString returns the text
        return RT_ERROR_UNKNOWN;
    RTresult result = RT_SUCCESS;
    std::string cause;
    try {
        body();
    } catch (const Failure& failure) {
        result = failure.result;
        cause = failure.what();
    } catch (const Error& error) {
        result = resultOf(error.code());
        cause = error.what();
    } catch (const std::bad_alloc&) {
        result = RT_ERROR_MEMORY_ALLOCATION_FAILED;
        cause = "out of host memory";
    } catch (const std::exception& error) {
        result = RT_ERROR_UNKNOWN;
        cause = error.what();
    }
    if (result != RT_SUCCESS) {
        while (!cause.empty() && cause.back() == '\n')
            cause.pop_back();
        const std::string line =
            message(textOf(result), " (Details: Function \"", function, "\": ", cause, ")");
        log(LogLevel::kError, "optix6", line);
        // Wrappers query the context of the object whose call has failed; this keeps the cause.
        const bool isQuestion = std::string_view(function).ends_with("GetContext");
        if (!isQuestion || lostFailure().empty())
            lostFailure() = context ? "" : line;
        if (context) {
            std::lock_guard lock(context->mutex());
            context->lastError = line;
            context->report(1, "ERROR", line);
        }
    }
    if (context)
        context->deliverReports();
    return result;
}

} // namespace sunstone::optix6
