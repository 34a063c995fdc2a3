// SPDX-License-Identifier: Apache-2.0
// Events of the CPU device: a mark in a stream that can be waited for and, with another, timed.
#pragma once

#include "device/cpu/stream.h"

namespace sunstone::device::cpu {

class Event {
public:
    Event(unsigned flags, const void* owner) : flags_(flags), owner_(owner) {}
    unsigned flags() const { return flags_; }
    const void* owner() const { return owner_; }
    bool timed() const { return (flags_ & 2u) == 0; } // CU_EVENT_DISABLE_TIMING is 2

    // Marks the stream's present end; later calls move the mark.
    void record(const StreamPtr& stream);
    // The mark; null if never recorded.
    CompletionPtr mark() const;

private:
    const unsigned flags_;
    const void* const owner_;
    mutable std::mutex mutex_;
    CompletionPtr mark_;
};

} // namespace sunstone::device::cpu
