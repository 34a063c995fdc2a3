// SPDX-License-Identifier: Apache-2.0
// Ids of objects: indices of a list that programs read. Ids of destroyed objects are collected once
// the list has doubled, so that creating n objects takes linear time. They are reused in ascending
// order, so that an id that a program still uses stays invalid for long.
#pragma once

#include "api/optix6/object.h"

#include <algorithm>
#include <deque>
#include <vector>

namespace sunstone::optix6 {

template <class T>
class IdList {
public:
    explicit IdList(size_t firstSearch) : nextSearch_(firstSearch) {}

    size_t size() const { return list_.size(); }
    const Ref<T>& operator[](size_t id) const { return list_[id]; }
    std::vector<Ref<T>>& list() { return list_; } // for copies of the context
    const std::vector<Ref<T>>& list() const { return list_; }
    auto begin() const { return list_.begin(); }
    auto end() const { return list_.end(); }

    // An id for an object under construction; 0 is no id. `set` must follow before the next call.
    unsigned reserve() {
        if (free_.empty() && list_.size() >= nextSearch_) {
            for (unsigned i = 1; i < list_.size(); ++i)
                if (list_[i].expired())
                    free_.push_back(i);
            nextSearch_ = std::max(nextSearch_, 2 * (list_.size() - free_.size()));
        }
        if (free_.empty()) {
            list_.emplace_back();
            return unsigned(list_.size() - 1);
        }
        const unsigned id = free_.front();
        free_.pop_front();
        return id;
    }
    void set(unsigned id, const std::shared_ptr<T>& object) { list_[id] = object; }

private:
    std::vector<Ref<T>> list_ = std::vector<Ref<T>>(1);
    std::deque<unsigned> free_;
    size_t nextSearch_;
};

} // namespace sunstone::optix6
