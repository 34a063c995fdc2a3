// SPDX-License-Identifier: Apache-2.0
#include "api/optix6/remote/channel.h"

#include "api/optix6/remote/frame.h"
#include "base/error.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace sunstone::optix6 {

namespace {

[[noreturn]] void failClosed(const char* what) {
    fail(Code::kLaunchFailure, "the connection to the other ranks is lost: ", what, ": ",
         errno ? std::strerror(errno) : "closed");
}

} // namespace

Channel::~Channel() {
    close(socket_);
}

void Channel::sendAll(const void* data, size_t size) {
    auto* from = static_cast<const char*>(data);
    while (size > 0) {
        const ssize_t sent = ::send(socket_, from, size, MSG_NOSIGNAL);
        if (sent < 0 && errno == EINTR)
            continue;
        if (sent <= 0)
            failClosed("send");
        from += sent;
        size -= size_t(sent);
    }
}

void Channel::send(uint32_t rank, std::string_view message) {
    std::lock_guard lock(sends_);
    do {
        const std::string_view part = message.substr(0, kMostFrameBytes);
        message.remove_prefix(part.size());
        const FrameHeader header{rank, uint32_t(part.size()), message.empty() ? 1u : 0u};
        sendAll(&header, sizeof header);
        sendAll(part.data(), part.size());
    } while (!message.empty());
}

void Channel::receiveAll(void* data, size_t size) {
    auto* to = static_cast<char*>(data);
    while (size > 0) {
        errno = 0;
        const ssize_t got = recv(socket_, to, size, 0);
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0)
            failClosed("receive");
        to += got;
        size -= size_t(got);
    }
}

std::optional<Message> Channel::receive(int milliseconds) {
    for (;;) {
        pollfd waiting{socket_, POLLIN, 0};
        const int ready = poll(&waiting, 1, milliseconds);
        if (ready < 0 && errno != EINTR)
            failClosed("poll");
        if (ready <= 0)
            return std::nullopt;
        FrameHeader header{};
        receiveAll(&header, sizeof header);
        if (header.size > kMostFrameBytes)
            fail(Code::kInternal, "a frame of ", header.size, " bytes");
        std::string& message = partial_[header.rank];
        const size_t before = message.size();
        message.resize(before + header.size);
        receiveAll(message.data() + before, header.size);
        if (header.isLast)
            return Message{header.rank, std::exchange(message, {})};
    }
}

} // namespace sunstone::optix6
