// SPDX-License-Identifier: Apache-2.0
// An object for each thread that calls of the API may use at any time. Programs call from exit
// handlers and from destructors of global objects, which run after the main thread's thread_local
// objects are gone: there is a new object then, which stays.
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
        thread_local Owner owner; // not made once more when it has gone
        (void)owner;
    }
    return *object;
}

} // namespace sunstone
