// SPDX-License-Identifier: Apache-2.0
// One object per thread for API calls. Programs also call the API from exit handlers and from
// destructors of global objects, which run after the main thread's thread_local objects have been
// destroyed. Such a call creates a second object, which is never destroyed. The library of the call
// may be unloaded, which workerObject() (worker_object.h) does not allow.
#pragma once

namespace sunstone {

template <class T>
T& threadObject() {
    thread_local T* object = nullptr; // has no destructor
    struct Owner {
        ~Owner() {
            delete object;
            object = nullptr;
        }
    };
    if (!object) {
        object = new T;
        thread_local Owner owner; // never constructed again after its destruction
        (void)owner;
    }
    return *object;
}

} // namespace sunstone
