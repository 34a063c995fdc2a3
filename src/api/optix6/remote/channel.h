// SPDX-License-Identifier: Apache-2.0
// Messages between the ranks of `mpirun sunstone run`. The processes that run programs do not use
// MPI: each has a socket to the `sunstone run` of its rank, which forwards frames
// (tools/sunstone/ranks.cpp). A message is one or more frames.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace sunstone::optix6 {

// The first byte of a message.
enum class MessageKind : uint8_t {
    kHello = 1, // from a node: it is ready
    kScene,     // to a node: changes of a scene's copy
    kDrop,      // to a node: a copy is no longer needed
    kStart,     // to a node: a launch
    kWork,      // to a node: subframes to render
    kStop,      // to a node: the launch has ended
    kSums,      // from a node: sums of subframes
    kFailed,    // from a node: it cannot render the launch's subframes
    kDied = 64, // from the rank's `sunstone run`: its node has died
};

struct Message {
    uint32_t rank = 0; // of the other side
    std::string bytes;
};

class Channel {
public:
    explicit Channel(int socket) : socket_(socket) {}
    ~Channel();
    Channel(const Channel&) = delete;

    // Any thread may send. Throws Error: the socket is closed.
    void send(uint32_t rank, std::string_view message);
    // The next message, if one arrives within that time. Throws Error: the socket is closed.
    std::optional<Message> receive(int milliseconds);

private:
    void sendAll(const void* data, size_t size);
    void receiveAll(void* data, size_t size);

    const int socket_;
    std::mutex sends_;
    std::map<uint32_t, std::string> partial_; // messages whose last frame has not arrived
};

} // namespace sunstone::optix6
