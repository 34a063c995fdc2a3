// SPDX-License-Identifier: Apache-2.0
// The additional data of a stream buffer: its source, its attributes, and the newest picture of a
// progressive launch. The launch's thread publishes pictures while the application maps the buffer;
// mapping copies the newest one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace sunstone::optix6 {

class Buffer;

class Stream {
public:
    std::weak_ptr<Buffer> source;
    std::string format = "auto"; // of streams over a network, like the next two
    int bitrate = 5000000, perSecond = 30;
    float gamma = 1;

    // `limit`: number of subframes, as in the launch.
    void publish(std::vector<uint8_t> pixels, unsigned subframes, unsigned limit);
    struct Update {
        unsigned subframes, limit;
    };
    // Whether a picture was published since the last call.
    bool takeUpdate(Update& update);
    void dropUpdate();
    // Drops the pictures, because the buffer's size or format has changed.
    void clear();
    // Copies the newest picture if it has this size.
    void copyTo(void* memory, size_t bytes) const;

private:
    mutable std::mutex mutex_;
    std::vector<uint8_t> pixels_;
    Update update_{0, 0};
    bool isNew_ = false;
};

} // namespace sunstone::optix6
