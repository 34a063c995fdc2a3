// SPDX-License-Identifier: Apache-2.0
// Opaque handles given to C callers. A handle is the address of an object. It is dereferenced only
// after the table has confirmed that the object is alive, so garbage, stale and foreign handles are
// recognised. Lookups return shared ownership: destroying a handle while another thread uses the
// object is safe.
#pragma once

#include <memory>
#include <mutex>
#include <shared_mutex>
#include <unordered_map>
#include <vector>

namespace sunstone {

template <class T>
class HandleTable {
public:
    // Registers an object and returns its handle.
    void* add(std::shared_ptr<T> object) {
        void* handle = object.get();
        std::unique_lock lock(mutex_);
        objects_[handle] = std::move(object);
        return handle;
    }

    // The live object of this handle, or null.
    std::shared_ptr<T> find(const void* handle) const {
        std::shared_lock lock(mutex_);
        auto found = objects_.find(handle);
        return found == objects_.end() ? nullptr : found->second;
    }

    // A live object for which `predicate(object)` holds, or null.
    template <class Predicate>
    std::shared_ptr<T> findIf(Predicate predicate) const {
        std::shared_lock lock(mutex_);
        for (const auto& [handle, object] : objects_)
            if (predicate(*object))
                return object;
        return nullptr;
    }

    // Removes the handle and returns its object, or null if it is not alive.
    std::shared_ptr<T> remove(const void* handle) {
        std::unique_lock lock(mutex_);
        auto found = objects_.find(handle);
        if (found == objects_.end())
            return nullptr;
        std::shared_ptr<T> object = std::move(found->second);
        objects_.erase(found);
        return object;
    }

    // Removes every object for which `predicate(object)` holds, e.g. those of a destroyed context.
    template <class Predicate>
    std::vector<std::shared_ptr<T>> removeIf(Predicate predicate) {
        std::vector<std::shared_ptr<T>> removed;
        std::unique_lock lock(mutex_);
        for (auto it = objects_.begin(); it != objects_.end();) {
            if (!predicate(*it->second)) {
                ++it;
                continue;
            }
            removed.push_back(std::move(it->second));
            it = objects_.erase(it);
        }
        return removed;
    }

private:
    mutable std::shared_mutex mutex_;
    std::unordered_map<const void*, std::shared_ptr<T>> objects_;
};

} // namespace sunstone
