// SPDX-License-Identifier: Apache-2.0
// One of the sixteen barriers of a block: the threads that have arrived, and the result.
#pragma once

#include "devlib/abi.h"

#include <algorithm>
#include <cstdint>

namespace sunstone::api::cuda {

class BlockBarrier {
public:
    static constexpr uint32_t kCount = 16; // per block; ids are taken modulo this count

    // threads: the number expected; 0: all live threads.
    void arrive(uint32_t threads, uint32_t count = 1) {
        arrived_ += count;
        expected_ = threads;
    }
    // The same for threads that wait for all others and contribute no value.
    void waitPlainly(uint32_t count) {
        arrive(0, count);
        reduction_ = devlib::kReduceNone;
    }
    // The same for a thread that waits and contributes a value.
    void wait(uint32_t threads, uint32_t reduction, bool value) {
        arrive(threads);
        reduction_ = reduction;
        all_ &= value;
        any_ |= value;
        count_ += value;
    }
    bool isUsed() const { return arrived_ != 0; }
    // Threads that have ended count as arrived.
    bool isComplete(uint32_t live) const {
        return arrived_ >= (expected_ ? std::min(expected_, live) : live);
    }
    uint32_t result() const {
        switch (reduction_) {
        case devlib::kReduceAnd:
            return all_;
        case devlib::kReduceOr:
            return any_;
        case devlib::kReduceCount:
            return count_;
        }
        return 0;
    }

private:
    uint32_t arrived_ = 0, expected_ = 0, reduction_ = devlib::kReduceNone;
    uint32_t all_ = 1, any_ = 0, count_ = 0;
};

} // namespace sunstone::api::cuda
