// SPDX-License-Identifier: Apache-2.0
// See event.h.
#include "device/cpu/event.h"

namespace sunstone::device::cpu {

void Event::record(const StreamPtr& stream) {
    CapturedMark captured = streams().captureState(stream);
    CompletionPtr mark;
    if (!captured.capture)
        mark = streams().submit(stream, nullptr);
    else if (captured.capture->invalidated)
        throw CaptureError(CaptureError::kInvalidated, "the stream's capture is invalid");
    captured.graph = nullptr;
    std::lock_guard lock(mutex_);
    mark_ = std::move(mark);
    captured_ = std::move(captured);
}

void Event::setMark(CompletionPtr mark) {
    std::lock_guard lock(mutex_);
    mark_ = std::move(mark);
    captured_ = {};
}

CompletionPtr Event::mark() const {
    std::lock_guard lock(mutex_);
    if (captured_.capture) {
        if (!captured_.capture->ended)
            captured_.capture->invalidated = true;
        throw CaptureError(CaptureError::kCapturedEvent, "the event was recorded in a capture");
    }
    return mark_;
}

CapturedMark Event::capturedMark() const {
    std::lock_guard lock(mutex_);
    return captured_;
}

} // namespace sunstone::device::cpu
