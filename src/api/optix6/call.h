// SPDX-License-Identifier: Apache-2.0
// Entry points: each looks up its object, takes the context's lock, runs a body and turns
// exceptions into a result. The context keeps the text for rtContextGetErrorString.
#pragma once

#include "api/optix6/context.h"
#include "api/optix6/progressive/progressive.h"
#include "base/forked.h"
#include "engine/gpu/gpus.h"

#include <functional>
#include <mutex>

#define SUNSTONE_API extern "C" __attribute__((visibility("default")))

namespace sunstone::optix6 {

// Devices of the machine: its GPUs, or else one for the CPU.
inline unsigned deviceCount() {
    return unsigned(std::max<size_t>(1, engine::gpus().size()));
}

// Runs a body without an object, or with a context that may be null for the text.
RTresult guarded(const std::shared_ptr<Context>& context, const char* function,
                 const std::function<void()>& body);

// Takes the context's lock and ends its progressive launch: the manual lets only a few calls
// continue it. The data of a progressive launch therefore stays unchanged while the launch runs.
inline std::unique_lock<std::mutex> enter(Context& context) {
    std::unique_lock lock(context.mutex());
    context.progressive->stop();
    return lock;
}

// Another thread may have destroyed the object while this one waited for the context's lock.
inline void requireAlive(const void* handle, const char* parameter, RTresult dead) {
    if (!objects().isAlive(handle))
        refuse(dead, parameter, " = ", handle, " was destroyed by another thread");
}

// Runs body(object) with the lock of its context. T has kKind. `goesOn(object)`: whether a
// progressive launch continues.
template <class T, class Body>
RTresult call(const char* function, const void* handle, const char* parameter, const Body& body,
              bool (*goesOn)(const T&) = nullptr) {
    if (refusesForkedChild())
        return RT_ERROR_UNKNOWN;
    std::shared_ptr<Object> found = handle ? objects().find(handle) : nullptr;
    std::shared_ptr<Context> context = found ? found->context() : nullptr;
    return guarded(context, function, [&] {
        const std::shared_ptr<T> object = require<T>(handle, parameter);
        const auto lock =
            goesOn && goesOn(*object) ? std::unique_lock(context->mutex()) : enter(*context);
        requireAlive(handle, parameter, RT_ERROR_INVALID_VALUE);
        body(*object);
    });
}

// The same for contexts. `dead`: the result for an invalid handle.
template <class Body>
RTresult callContext(const char* function, RTcontext handle, const Body& body,
                     RTresult dead = RT_ERROR_INVALID_VALUE, bool goesOn = false) {
    if (refusesForkedChild())
        return RT_ERROR_UNKNOWN;
    std::shared_ptr<Object> found = handle ? objects().find(handle) : nullptr;
    const bool good = found && found->kind == Kind::kContext;
    std::shared_ptr<Context> context = good ? std::static_pointer_cast<Context>(found) : nullptr;
    return guarded(context, function, [&] {
        if (!context)
            refuse(dead, "context = ", static_cast<const void*>(handle), " is not a live context");
        const auto lock = goesOn ? std::unique_lock(context->mutex()) : enter(*context);
        requireAlive(handle, "context", dead);
        body(*context);
    });
}

// rtXCreate: makes an object of class T for the context.
template <class T, class Handle, class... Args>
RTresult create(const char* function, RTcontext handle, const char* parameter, Handle* result,
                const Args&... args) {
    return callContext(
        function, handle,
        [&](Context& context) {
            requireNonNull(result, parameter);
            *result = nullptr;
            *result =
                static_cast<Handle>(objects().add(std::make_shared<T>(context.self(), args...)));
        },
        RT_ERROR_INVALID_CONTEXT);
}

// Removes an object with its variables. References to it are empty afterwards.
template <class T>
void removeObject(T& object) {
    if constexpr (std::is_base_of_v<Scoped, T>)
        for (const std::shared_ptr<Variable>& variable : object.scope.list())
            objects().remove(variable->handle());
    objects().remove(object.handle());
}
inline void removeObject(Buffer& buffer) {
    const auto self = std::static_pointer_cast<Buffer>(buffer.shared_from_this());
    buffer.context()->mappedBuffers.erase(self);
    objects().remove(buffer.handle());
}

// Whether the scene may depend on the object, apart from its id.
template <class T>
bool isSeen(const T& object) {
    if constexpr (std::is_base_of_v<Scoped, T>)
        for (const std::shared_ptr<Variable>& variable : object.scope.list())
            if (variable->isSeen())
                return true;
    return object.isInScene;
}
inline bool isSeen(const Buffer& buffer) {
    return buffer.hasHolders();
}

// rtXDestroy.
template <class T>
RTresult destroy(const char* function, const void* handle, const char* parameter) {
    return call<T>(function, handle, parameter, [&](T& object) {
        if (isSeen(object))
            object.context()->noteStructure();
        removeObject(object);
    });
}

// rtXGetContext.
template <class T>
RTresult getContext(const char* function, const void* handle, const char* parameter,
                    RTcontext* context) {
    return call<T>(function, handle, parameter, [&](T& object) {
        requireNonNull(context, "context");
        *context = static_cast<RTcontext>(object.context()->handle());
    });
}

// Runs a launch and notes a failure for rtContextDestroy. A launch whose programs fail has failed;
// a rejected call has not.
template <class Body>
void noteFailure(Context& context, const Body& body) {
    try {
        body();
    } catch (const Error& error) {
        if (resultOf(error.code()) == RT_ERROR_LAUNCH_FAILED)
            context.launchFailed = true;
        throw;
    }
}

// Launches an entry point and waits; the caller handles objects shared with OpenGL (gl/share.h).
// Throws Failure.
void launchEntry(Context& context, unsigned entryPoint, RTsize width, RTsize height, RTsize depth);

template <class Value>
void store(Value* pointer, const char* name, const Value& value) {
    requireNonNull(pointer, name);
    *pointer = value;
}

} // namespace sunstone::optix6
