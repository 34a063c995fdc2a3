/* SPDX-License-Identifier: Apache-2.0 */
// Handles of Prime++: pointers that count references.
#ifndef OPTIX_PRIMEPP_HANDLE_H
#define OPTIX_PRIMEPP_HANDLE_H

#include "Ref.h"

namespace optix {
namespace prime {

template <class T>
class Handle {
public:
    Handle() : object_(0) {}
    Handle(T* object) : object_(object) { ref(); }
    template <class U>
    Handle(U* object) : object_(object) {
        ref();
    }
    Handle(const Handle<T>& other) : object_(other.object_) { ref(); }
    template <class U>
    Handle(const Handle<U>& other) : object_(other.get()) {
        ref();
    }
    ~Handle() { unref(); }

    Handle<T>& operator=(const Handle<T>& other) {
        set(other.object_);
        return *this;
    }
    template <class U>
    Handle<T>& operator=(const Handle<U>& other) {
        set(other.get());
        return *this;
    }

    T* operator->() const { return object_; }
    T& operator*() const { return *object_; }
    T* get() const { return object_; }
    bool isValid() const { return object_ != 0; }
    operator bool() const { return object_ != 0; }

    // The type's own create().
    template <class A>
    static Handle<T> create(A a) {
        return T::create(a);
    }

private:
    void ref() {
        if (object_)
            object_->ref();
    }
    void unref() {
        if (object_)
            object_->unref();
    }
    // References the new object first: it may be the old one, or depend on it.
    void set(T* object) {
        if (object)
            object->ref();
        unref();
        object_ = object;
    }

    T* object_;
};

} // namespace prime
} // namespace optix

#endif
