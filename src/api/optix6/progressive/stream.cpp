// SPDX-License-Identifier: Apache-2.0
#include "api/optix6/progressive/stream.h"

#include <cstring>
#include <utility>

namespace sunstone::optix6 {

void Stream::publish(std::vector<uint8_t> pixels, unsigned subframes, unsigned limit) {
    std::lock_guard lock(mutex_);
    pixels_ = std::move(pixels);
    update_ = {subframes, limit};
    isNew_ = true;
}

bool Stream::takeUpdate(Update& update) {
    std::lock_guard lock(mutex_);
    update = update_;
    return std::exchange(isNew_, false);
}

void Stream::dropUpdate() {
    std::lock_guard lock(mutex_);
    isNew_ = false;
}

void Stream::clear() {
    std::lock_guard lock(mutex_);
    pixels_.clear();
    isNew_ = false;
}

void Stream::copyTo(void* memory, size_t bytes) const {
    std::lock_guard lock(mutex_);
    if (pixels_.size() == bytes && bytes != 0)
        std::memcpy(memory, pixels_.data(), bytes);
}

} // namespace sunstone::optix6
