// SPDX-License-Identifier: Apache-2.0
// The base of all objects of the classic API. One table owns the objects of all classes: a handle
// of another class and the handle of a destroyed object give different errors. Objects refer to one
// another by weak pointers, which are empty once the object is destroyed.
#pragma once

#include "base/error.h"
#include "base/handles.h"

#include "optix.h"

#include <memory>
#include <string>

namespace sunstone::optix6 {

class Context;

enum class Kind : uint8_t {
    kContext,
    kProgram,
    kVariable,
    kBuffer,
    kTextureSampler,
    kGeometry,
    kGeometryTriangles,
    kMaterial,
    kGeometryInstance,
    kGeometryGroup,
    kGroup,
    kTransform,
    kSelector,
    kAcceleration,
    kPostProcessingStage,
    kCommandList,
    kRemoteDevice,
};
const char* nameOf(Kind kind);

class Object : public Handled, public std::enable_shared_from_this<Object> {
public:
    Object(Kind kind, const std::shared_ptr<Context>& context) : kind(kind), owner_(context) {}
    virtual ~Object() = default;
    Object(const Object&) = delete;

    const Kind kind;
    // The scene reads the object, or has read it: a change of the object may change the scene.
    mutable bool isInScene = false;
    // Reports such a change to the context (Context::noteStructure).
    void noteSceneChange() const;
    // Reports that an object with an id is new, destroyed or different (Context::idsChanged).
    void noteIds() const;
    // Null while the context is being destroyed.
    virtual std::shared_ptr<Context> context() const { return owner_.lock(); }

private:
    std::weak_ptr<Context> owner_;
};

template <class T>
using Ref = std::weak_ptr<T>;

template <class T>
void* handleOf(const Ref<T>& ref) {
    const std::shared_ptr<T> object = ref.lock();
    return object ? object->handle() : nullptr;
}

HandleTable<Object>& objects();

// A result of the API with its cause.
struct Failure : std::runtime_error {
    Failure(RTresult r, const std::string& text) : std::runtime_error(text), result(r) {}
    RTresult result;
};
template <class... Parts>
[[noreturn]] void refuse(RTresult result, const Parts&... parts) {
    throw Failure(result, message(parts...));
}

// Throws "NAME is null".
template <class T>
void requireNonNull(const T* pointer, const char* name) {
    if (!pointer)
        refuse(RT_ERROR_INVALID_VALUE, name, " is null");
}

// The live object of class T behind a handle; other handles are an error that names the parameter.
// `otherKind`: the result for live objects of another class.
template <class T>
std::shared_ptr<T> require(const void* handle, const char* parameter,
                           RTresult otherKind = RT_ERROR_INVALID_VALUE) {
    requireNonNull(handle, parameter);
    std::shared_ptr<Object> object = objects().find(handle);
    if (!object)
        refuse(RT_ERROR_INVALID_VALUE, parameter, " = ", handle, " is not a live object");
    if (object->kind != T::kKind)
        refuse(otherKind, parameter, " is a ", nameOf(object->kind), ", not a ", nameOf(T::kKind));
    return std::static_pointer_cast<T>(object);
}

// The same for objects that must belong to this context.
template <class T>
std::shared_ptr<T> requireOf(const Context& context, const void* handle, const char* parameter,
                             RTresult otherKind = RT_ERROR_INVALID_VALUE) {
    std::shared_ptr<T> object = require<T>(handle, parameter, otherKind);
    if (object->context().get() != &context)
        refuse(RT_ERROR_INVALID_VALUE, parameter, " belongs to another context");
    return object;
}

} // namespace sunstone::optix6
