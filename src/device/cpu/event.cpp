// SPDX-License-Identifier: Apache-2.0
// See event.h.
#include "device/cpu/event.h"

namespace sunstone::device::cpu {

void Event::record(const StreamPtr& stream) {
    CompletionPtr mark = streams().submit(stream, nullptr);
    std::lock_guard lock(mutex_);
    mark_ = std::move(mark);
}

CompletionPtr Event::mark() const {
    std::lock_guard lock(mutex_);
    return mark_;
}

} // namespace sunstone::device::cpu
