// SPDX-License-Identifier: Apache-2.0
// The C++ wrapper of the classic API: handles, exceptions, and the base classes of objects. Read
// next: context.h. Source: OptiX API reference 6.0, sections 5.27, 7.3, 7.17, 7.19, 7.25, 7.48.
//
// A handle counts references to a wrapper. The last handle deletes the wrapper; only destroy()
// destroys the object of the C API, and several wrappers of one object are normal. Compare objects
// by get()->get(). Counts are not atomic: threads share no wrapper.
#ifndef SUNSTONE_OPTIXPP_HANDLE_H
#define SUNSTONE_OPTIXPP_HANDLE_H

#include "../../optix_cuda_interop.h"
#include "../../optix_gl_interop.h"
#include "../../optix_host.h"
#include "../../optixu/optixu.h"
#include "../../optixu/optixu_vector_types.h"

#include <exception>
#include <iterator>
#include <string>
#include <vector>

namespace optix {

class AccelerationObj;
class BufferObj;
class CommandListObj;
class ContextObj;
class GeometryGroupObj;
class GeometryInstanceObj;
class GeometryObj;
class GeometryTrianglesObj;
class GroupObj;
class MaterialObj;
class PostprocessingStageObj;
class ProgramObj;
class RemoteDeviceObj;
class SelectorObj;
class TextureSamplerObj;
class TransformObj;
class VariableObj;

template <class T>
class Handle;

typedef Handle<AccelerationObj> Acceleration;
typedef Handle<BufferObj> Buffer;
typedef Handle<CommandListObj> CommandList;
typedef Handle<ContextObj> Context;
typedef Handle<GeometryGroupObj> GeometryGroup;
typedef Handle<GeometryInstanceObj> GeometryInstance;
typedef Handle<GeometryObj> Geometry;
typedef Handle<GeometryTrianglesObj> GeometryTriangles;
typedef Handle<GroupObj> Group;
typedef Handle<MaterialObj> Material;
typedef Handle<PostprocessingStageObj> PostprocessingStage;
typedef Handle<ProgramObj> Program;
typedef Handle<RemoteDeviceObj> RemoteDevice;
typedef Handle<SelectorObj> Selector;
typedef Handle<TextureSamplerObj> TextureSampler;
typedef Handle<TransformObj> Transform;
typedef Handle<VariableObj> Variable;

/** A call that failed: its code, and the text of rtContextGetErrorString. */
class Exception : public std::exception {
public:
    Exception(const std::string& message, RTresult error_code = RT_ERROR_UNKNOWN)
        : m_errorMessage(message), m_errorCode(error_code) {}
    virtual ~Exception() throw() {}

    const std::string& getErrorString() const { return m_errorMessage; }
    RTresult getErrorCode() const { return m_errorCode; }
    virtual const char* what() const throw() { return m_errorMessage.c_str(); }

    static Exception makeException(RTresult code, RTcontext context) {
        const char* text = 0;
        rtContextGetErrorString(context, code, &text);
        return Exception(text ? text : "", code);
    }

private:
    std::string m_errorMessage;
    RTresult m_errorCode;
};

namespace internal {

/** Throws for each code but success and RT_TIMEOUT_CALLBACK, which reports no failure. */
inline void check(RTresult code, RTcontext context = 0) {
    if (code != RT_SUCCESS && code != RT_TIMEOUT_CALLBACK)
        throw Exception::makeException(code, context);
}

/** `function`: the caller, for the text of the Exception. */
inline void checkIndex(const char* function, unsigned int index, unsigned int count) {
    if (index >= count)
        throw Exception(std::string(function) + ": child " + std::to_string(index) + " of " +
                            std::to_string(count),
                        RT_ERROR_INVALID_VALUE);
}

} // namespace internal

/** A counted reference to a wrapper, or null. */
template <class T>
class Handle {
public:
    Handle() : m_pointer(0) {}
    Handle(T* ptr) : m_pointer(ptr) { reference(); }
    template <class U>
    Handle(U* ptr) : m_pointer(ptr) {
        reference();
    }
    Handle(const Handle<T>& copy) : m_pointer(copy.m_pointer) { reference(); }
    template <class U>
    Handle(const Handle<U>& copy) : m_pointer(copy.m_pointer) {
        reference();
    }
    ~Handle() { release(); }

    Handle<T>& operator=(const Handle<T>& copy) { return assign(copy.m_pointer); }
    template <class U>
    Handle<T>& operator=(const Handle<U>& copy) {
        return assign(copy.m_pointer);
    }

    /** A new wrapper of an object of the C API; null for null. */
    template <class U = T>
    static Handle<T> take(typename U::api_t p) {
        return p ? new T(p) : 0;
    }
    static Handle<T> take(RTobject p) { return take(static_cast<typename T::api_t>(p)); }

    /** A null handle throws RT_ERROR_INVALID_VALUE. */
    T* operator->() { return checked(); }
    const T* operator->() const { return checked(); }
    T* get() { return m_pointer; }
    const T* get() const { return m_pointer; }
    operator bool() const { return m_pointer != 0; }

    /** The variable of this name; declares it if the object has none. */
    Handle<VariableObj> operator[](const std::string& varname);
    /** The same: without this overload the handle could become a bool that indexes the string. */
    Handle<VariableObj> operator[](const char* varname);

    /** For contexts only. */
    static Handle<T> create() { return T::create(); }
    static unsigned int getDeviceCount() { return T::getDeviceCount(); }

private:
    template <class U>
    friend class Handle;

    void reference() {
        if (m_pointer)
            m_pointer->addReference();
    }
    void release() {
        if (m_pointer && m_pointer->removeReference() == 0)
            delete m_pointer;
    }
    Handle<T>& assign(T* pointer) {
        if (pointer)
            pointer->addReference(); // before release: both may be the same
        release();
        m_pointer = pointer;
        return *this;
    }
    T* checked() const {
        if (!m_pointer)
            throw Exception("use of a null handle: the object does not exist or a query found none",
                            RT_ERROR_INVALID_VALUE);
        return m_pointer;
    }

    T* m_pointer;
};

/** Base of all wrappers. */
class APIObj {
public:
    APIObj() : m_references(0) {}
    virtual ~APIObj() {}

    void addReference() { ++m_references; }
    /** Returns the references that remain. */
    int removeReference() { return --m_references; }

    virtual Context getContext() const = 0;

    /** Throws an Exception with the text of the object's context unless the call succeeded. */
    virtual void checkError(RTresult code) const;
    virtual void checkError(RTresult code, Context context) const;
    /** For failures of the search for the context. */
    void checkErrorNoGetContext(RTresult code) const { internal::check(code); }

    /** The same as Exception::makeException. */
    static Exception makeException(RTresult code, RTcontext context) {
        return Exception::makeException(code, context);
    }

private:
    APIObj(const APIObj&);
    APIObj& operator=(const APIObj&);

    int m_references;
};

/** Base of objects that live until destroy(). */
class DestroyableObj : public APIObj {
public:
    virtual ~DestroyableObj() {}

    /** Destroys the object of the C API; wrappers of it then fail. */
    virtual void destroy() = 0;
    /** Throws if the object is incomplete. */
    virtual void validate() = 0;
};

/** Base of objects with variables. */
class ScopedObj : public DestroyableObj {
public:
    virtual ~ScopedObj() {}

    virtual Variable declareVariable(const std::string& name) = 0;
    /** A null handle if there is none. */
    virtual Variable queryVariable(const std::string& name) const = 0;
    virtual void removeVariable(Variable v) = 0;
    virtual unsigned int getVariableCount() const = 0;
    virtual Variable getVariable(unsigned int index) const = 0;
};

} // namespace optix

#endif
