// SPDX-License-Identifier: Apache-2.0
// Shared by the files of the OptiX Prime shell: the objects behind the opaque handles, the checks
// of handles, the translation of errors into RTPresult. Source: OptiX 6.0 API reference,
// modules 5.30 to 5.36 and file chapters 8.20, 8.21. Read next: context.cpp, model.cpp, query.cpp.
//
// One lock for each context protects its objects. Calls wait without holding it.
#pragma once

#include "api/prime/work_queue.h"
#include "base/error.h"
#include "base/handles.h"
#include "base/log.h"
#include "base/threads/thread_team.h"
#include "device/cuda/driver.h"
#include "engine/queries/queries.h"

#include "optix_prime/optix_prime.h"

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace sunstone::prime {

// The text of a failure. Later failures have larger serial numbers.
struct ErrorText {
    uint64_t serial = 0;
    std::string text;
};
// The calling thread's last failure for a null or dead handle, whose context is unknown.
ErrorText& failureWithoutContext();

struct Context : Handled {
    RTPcontexttype type = RTP_CONTEXT_TYPE_CPU;
    std::mutex mutex;
    std::shared_ptr<engine::QueryDevice> device;
    std::shared_ptr<ThreadTeam> team; // null: all threads
    WorkQueue queue;                  // of asynchronous work
    int cudaDevice = -1;              // of CUDA contexts: the primary device
    void* cudaContext = nullptr;      // its CUcontext

    // The resources of the context's work. Read with the lock.
    struct Place {
        std::shared_ptr<ThreadTeam> team;
        void* cudaContext;
    };
    Place place() const { return {team, cudaContext}; }
    // Work that runs after all asynchronous work so far: at once, or pushed to the queue.
    struct Work {
        engine::CompletionPtr completion;
        std::function<void()> body;
        uint64_t ticket;
    };
    Work prepare(const Place& place, std::function<void()> work);
    // Waits, so it is called without the lock.
    void run(const Work& work);

    void setError(const std::string& text);
    // The text of the context, or a later one of failureWithoutContext().
    std::string lastError();

private:
    std::mutex errorMutex_;
    ErrorText lastError_ = {newSerial(), {}};
};
using ContextPtr = std::shared_ptr<Context>;

// A buffer descriptor; objects that use it hold a copy.
struct BufferDesc : Handled {
    ContextPtr context;
    RTPbufferformat format{};
    RTPbuffertype type{};
    void* buffer = nullptr;
    bool hasRange = false;
    uint64_t begin = 0, end = 0;
    uint32_t stride = 0; // 0: packed
    int cudaDevice = -1;

    uint64_t count() const { return end - begin; }
    uint32_t elementBytes() const; // 0 for bits
    uint32_t strideBytes() const { return stride ? stride : elementBytes(); }
    // For any address and range, which are checked later.
    void* addressAt(uint64_t offset) const {
        return reinterpret_cast<void*>(reinterpret_cast<uintptr_t>(buffer) + offset);
    }
    void* first() const { return addressAt(begin * strideBytes()); }
};

struct Model : Handled {
    ContextPtr context;
    std::optional<BufferDesc> indices, vertices; // as set; read by the next update
    std::optional<BufferDesc> instances, transforms;
    bool callerTriangles = false; // RTP_BUILDER_PARAM_USE_CALLER_TRIANGLES
    uint64_t chunkSize = 0;
    // The last update that was started, and its result.
    std::shared_ptr<struct ModelUpdate> update;
};

// Queries in progress keep it.
struct ModelUpdate {
    engine::CompletionPtr completion;
    engine::StructurePtr structure; // valid when completion is done without error
    bool callerTriangles = false;
    bool needsTriangles = false; // copied without triangles, which must be set
    bool isInstances = false;
    uint64_t triangles = 0;
    // The model's structure; waits. Throws the error of the update.
    engine::StructurePtr wait();
    bool isDone();

private:
    std::mutex mutex_;
    std::string error_;
    Code code_ = Code::kOk;
};

struct Query : Handled {
    ContextPtr context;
    std::shared_ptr<Model> model;
    RTPquerytype type{};
    std::optional<BufferDesc> rays, hits;
    void* stream = nullptr;
    engine::CompletionPtr completion; // of the last execution
};

HandleTable<Context>& contexts();
HandleTable<BufferDesc>& descs();
HandleTable<Model>& models();
HandleTable<Query>& queries();

// The live object of a handle. Throws kInvalidValue for null, kInvalidContext or kNotFound for
// other handles.
ContextPtr contextOf(RTPcontext handle);
std::shared_ptr<BufferDesc> descOf(RTPbufferdesc handle, const char* parameter);
std::shared_ptr<Model> modelOf(RTPmodel handle, const char* parameter);
std::shared_ptr<Query> queryOf(RTPquery handle);

// A copy of a descriptor that belongs to this context and has a range and one of these formats.
BufferDesc usableDesc(const Context& context, RTPbufferdesc handle, const char* parameter,
                      std::initializer_list<RTPbufferformat> formats);
const char* formatName(RTPbufferformat format);

// Throws unless the range is readable (or also writable) in the memory that the descriptor names.
void requireMemory(const Context& context, const BufferDesc& desc, const char* parameter,
                   uint64_t bytes, bool written);

// Writes the handle of an object's context.
template <class T>
void giveContext(const T& object, RTPcontext* context) {
    if (!context)
        fail(Code::kInvalidValue, "context is null");
    *context = static_cast<RTPcontext>(object.context->handle());
}

template <class T>
void requireNonNull(const T* pointer, const char* name) {
    if (!pointer)
        fail(Code::kInvalidValue, name, " is null");
}

// The own bits of hints, without their common bit. Throws kInvalidValue for unknown bits.
uint32_t hintBits(unsigned hints, unsigned common, unsigned known);

// The last execution of a query.
engine::CompletionPtr completionOf(const Query& query);

// Waits for the work of a query or model; errors of the work are dropped.
void finishQuietly(const engine::CompletionPtr& completion) noexcept;

// Runs body; turns its exceptions into a result, the last error message of the context and a line
// in the log. Without a context, the message of a call with an object is failureWithoutContext().
RTPresult guarded(const ContextPtr& context, const char* function,
                  const std::function<void()>& body);

// The context of a handle's object, for use outside guards; null if it is not alive.
template <class T>
ContextPtr peekContext(const HandleTable<T>& table, const void* handle) {
    const std::shared_ptr<T> object = handle ? table.find(handle) : nullptr;
    return object ? object->context : nullptr;
}

} // namespace sunstone::prime
