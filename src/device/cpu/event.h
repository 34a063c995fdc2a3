// SPDX-License-Identifier: Apache-2.0
// Events of the CPU device: a mark in a stream; streams wait for it, and two marks give a time.
#pragma once

#include "base/handles.h"
#include "device/cpu/stream.h"

namespace sunstone::device::cpu {

class Event : public Handled {
public:
    Event(unsigned flags, const void* owner) : flags_(flags), owner_(owner) {}
    unsigned flags() const { return flags_; }
    const void* owner() const { return owner_; }
    bool timed() const { return (flags_ & 2u) == 0; } // CU_EVENT_DISABLE_TIMING is 2

    // Marks the stream's current end; later calls move the mark.
    void record(const StreamPtr& stream);
    // The mark; null if never recorded. Throws CaptureError if it was recorded in a capture, where
    // it marks no point in time.
    CompletionPtr mark() const;
    void setMark(CompletionPtr mark);
    // The mark of a capturing stream; null capture if the event has another mark or none.
    CapturedMark capturedMark() const;

private:
    const unsigned flags_;
    const void* const owner_;
    mutable std::mutex mutex_;
    CompletionPtr mark_;
    CapturedMark captured_;
};

} // namespace sunstone::device::cpu
