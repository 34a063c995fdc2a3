// SPDX-License-Identifier: Apache-2.0
// See shell.h.
#include "api/prime/shell.h"

#include "api/prime/cuda_library.h"
#include "base/forked.h"
#include "base/log.h"
#include "base/threads/thread_object.h"

#include <new>
#include <string_view>

namespace sunstone::prime {

// Never destroyed: clients may call from their own exit handlers.
HandleTable<Context>& contexts() {
    static auto* table = new HandleTable<Context>;
    return *table;
}
HandleTable<BufferDesc>& descs() {
    static auto* table = new HandleTable<BufferDesc>;
    return *table;
}
HandleTable<Model>& models() {
    static auto* table = new HandleTable<Model>;
    return *table;
}
HandleTable<Query>& queries() {
    static auto* table = new HandleTable<Query>;
    return *table;
}

namespace {

template <class T>
std::shared_ptr<T> require(HandleTable<T>& table, const void* handle, const char* parameter,
                           const char* kind, Code dead = Code::kNotFound) {
    if (!handle)
        fail(Code::kInvalidValue, parameter, " is null");
    std::shared_ptr<T> object = table.find(handle);
    if (!object)
        fail(dead, parameter, " = ", handle, " is not a live ", kind);
    return object;
}

RTPresult resultOf(Code code) {
    switch (code) {
    case Code::kOk:
        return RTP_SUCCESS;
    case Code::kInvalidValue:
        return RTP_ERROR_INVALID_VALUE;
    case Code::kOutOfMemory:
        return RTP_ERROR_MEMORY_ALLOCATION_FAILED;
    case Code::kInvalidOperation:
        return RTP_ERROR_INVALID_OPERATION;
    case Code::kNotSupported:
        return RTP_ERROR_NOT_SUPPORTED;
    case Code::kInvalidContext:
        return RTP_ERROR_INVALID_CONTEXT;
    case Code::kNotFound:
        return RTP_ERROR_INVALID_HANDLE;
    case Code::kNotInitialized:
        return RTP_ERROR_OBJECT_CREATION_FAILED;
    default:
        return RTP_ERROR_UNKNOWN;
    }
}

} // namespace

ContextPtr contextOf(RTPcontext handle) {
    return require(contexts(), handle, "context", "context", Code::kInvalidContext);
}
std::shared_ptr<BufferDesc> descOf(RTPbufferdesc handle, const char* parameter) {
    return require(descs(), handle, parameter, "buffer descriptor");
}
std::shared_ptr<Model> modelOf(RTPmodel handle, const char* parameter) {
    return require(models(), handle, parameter, "model");
}
std::shared_ptr<Query> queryOf(RTPquery handle) {
    return require(queries(), handle, "query", "query");
}

ErrorText& failureWithoutContext() {
    return threadObject<ErrorText>();
}

void Context::setError(const std::string& text) {
    std::lock_guard lock(errorMutex_);
    lastError_ = {newSerial(), text};
}

std::string Context::lastError() {
    const ErrorText& without = failureWithoutContext();
    std::lock_guard lock(errorMutex_);
    return without.serial > lastError_.serial ? without.text : lastError_.text;
}

Context::Work Context::prepare(const Place& place, std::function<void()> work) {
    auto completion = std::make_shared<engine::HostCompletion>();
    auto body = [completion, work = std::move(work), place] {
        completion->run([&] {
            CudaScope scope(place.cudaContext);
            if (place.team)
                place.team->run(work);
            else
                work();
        });
    };
    return {completion, std::move(body), queue.ticket()};
}

void Context::run(const Work& work) {
    queue.waitFor(work.ticket);
    work.body();
}

engine::StructurePtr ModelUpdate::wait() {
    std::lock_guard lock(mutex_);
    if (completion) {
        try {
            completion->wait();
        } catch (const Error& error) {
            code_ = error.code();
            error_ = error.what();
        } catch (const std::bad_alloc&) {
            code_ = Code::kOutOfMemory;
            error_ = "no memory for the acceleration structure";
        }
        completion = nullptr;
    }
    if (code_ != Code::kOk)
        throw Error(code_, "the model's update failed: " + error_);
    return structure;
}

bool ModelUpdate::isDone() {
    std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock)
        return false; // a thread waits for it
    return !completion || completion->isDone();
}

uint32_t hintBits(unsigned hints, unsigned common, unsigned known) {
    const unsigned own = hints & ~common;
    if (own & ~known)
        fail(Code::kInvalidValue, "hints = 0x", std::hex, hints, " has unknown bits 0x",
             own & ~known);
    if (hints != 0 && (hints & common) == 0)
        fail(Code::kInvalidValue, "hints = 0x", std::hex, hints, " is no combination of hints");
    return own;
}

engine::CompletionPtr completionOf(const Query& query) {
    std::lock_guard lock(query.context->mutex);
    return query.completion;
}

void finishQuietly(const engine::CompletionPtr& completion) noexcept {
    try {
        if (completion)
            completion->wait();
    } catch (const std::exception& error) {
        log(LogLevel::kWarning, "prime", error.what());
    }
}

RTPresult guarded(const ContextPtr& context, const char* function,
                  const std::function<void()>& body) {
    if (refusesForkedChild()) // rtpContextGetLastErrorString returns the text
        return RTP_ERROR_INVALID_OPERATION;
    RTPresult result = RTP_ERROR_UNKNOWN;
    std::string cause = "unknown exception";
    try {
        body();
        return RTP_SUCCESS;
    } catch (const Error& error) {
        result = resultOf(error.code());
        cause = error.what();
    } catch (const std::bad_alloc&) {
        result = RTP_ERROR_MEMORY_ALLOCATION_FAILED;
        cause = "no host memory";
    } catch (const std::exception& error) {
        cause = error.what();
    }
    const std::string text = message(function, ": ", cause);
    const auto isOf = [&](const char* kind) {
        return std::string_view(function).starts_with(kind);
    };
    if (context)
        context->setError(text);
    else if (isOf("rtpBufferDesc") || isOf("rtpModel") || isOf("rtpQuery"))
        failureWithoutContext() = {newSerial(), text};
    log(LogLevel::kError, "prime", text);
    return result;
}

} // namespace sunstone::prime
