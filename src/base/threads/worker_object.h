// SPDX-License-Identifier: Apache-2.0
// One object per thread for code that the library's own threads run.
//
// The C library registers the destructor of a thread_local object under the lock of the dynamic
// loader. A program holds this lock while a static constructor or destructor of a library runs in
// dlopen or dlclose. If this constructor waits for a launch, a worker thread must not wait for the
// lock. Objects of workers are therefore destroyed by a key of pthread_key_create, which needs no
// lock. The main thread's objects are never destroyed.
#pragma once

namespace sunstone {

// Calls the function when the calling thread ends. The code of the function must never be unloaded.
void atThreadEnd(void (*function)());

template <class T>
T& workerObject() {
    thread_local T* object = nullptr; // has no destructor
    if (!object) {
        object = new T;
        atThreadEnd([] {
            delete object;
            object = nullptr;
        });
    }
    return *object;
}

} // namespace sunstone
