// SPDX-License-Identifier: Apache-2.0
#include "base/threads/worker_object.h"

#include <memory>
#include <pthread.h>

namespace sunstone {

namespace {

struct Entry {
    void (*function)();
    Entry* next; // registered earlier
};

void callAll(void* entries) {
    for (auto* entry = static_cast<Entry*>(entries); entry;) {
        const std::unique_ptr<Entry> owner(entry);
        entry = owner->next;
        owner->function();
    }
}

} // namespace

void atThreadEnd(void (*function)()) {
    static const pthread_key_t* const key = [] {
        auto* made = new pthread_key_t;
        return pthread_key_create(made, callAll) == 0 ? made : nullptr;
    }();
    if (!key)
        return; // the process has no key left: the object lives until the process ends
    auto* latest = static_cast<Entry*>(pthread_getspecific(*key));
    pthread_setspecific(*key, new Entry{function, latest});
}

} // namespace sunstone
