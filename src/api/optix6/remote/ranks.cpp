// SPDX-License-Identifier: Apache-2.0
#include "api/optix6/remote/ranks.h"

#include "api/optix6/remote/archive.h"
#include "base/config.h"
#include "base/log.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>

namespace sunstone::optix6 {

// SOCKET:RANKS:PARENT. A process started by the application inherits the variable but not the
// socket, so the socket is valid only in the child of the `sunstone run` that created it.
Ranks* Ranks::connect() {
    const std::string& value = config(Setting::kRanks);
    int socket = -1, parent = 0;
    unsigned size = 0;
    if (value.empty() || std::sscanf(value.c_str(), "%d:%u:%d", &socket, &size, &parent) != 3)
        return nullptr;
    struct stat status {};
    if (getppid() != parent || fstat(socket, &status) != 0 || !S_ISSOCK(status.st_mode))
        return nullptr;
    fcntl(socket, F_SETFD, FD_CLOEXEC);
    log(LogLevel::kInfo, "optix6",
        message("progressive launches use ", size, " ranks, of which this is rank 0"));
    return new Ranks(socket, size);
}

// Never destroyed: a launch may run while the process ends.
Ranks* Ranks::get() {
    static Ranks* const ranks = connect();
    return ranks;
}

bool Ranks::isAlive(uint32_t rank) const {
    std::lock_guard lock(mutex_);
    return rank < size_ && !dead_.count(rank);
}

std::vector<uint32_t> Ranks::alive() const {
    std::vector<uint32_t> list;
    for (uint32_t rank = 1; rank < size_; ++rank)
        if (isAlive(rank))
            list.push_back(rank);
    return list;
}

uint64_t Ranks::memory() const {
    std::lock_guard lock(mutex_);
    uint64_t sum = 0;
    for (const auto& [rank, bytes] : memories_)
        sum += bytes;
    return sum;
}

void Ranks::refresh() {
    if (!acquire(this))
        return;
    while (receive(0)) {
    }
    release(this);
}

bool Ranks::acquire(const void* owner) {
    std::lock_guard lock(mutex_);
    if (owner_ && owner_ != owner)
        return false;
    owner_ = owner;
    return true;
}

void Ranks::release(const void* owner) {
    std::lock_guard lock(mutex_);
    if (owner_ == owner)
        owner_ = nullptr;
}

void Ranks::send(uint32_t rank, const std::string& message) {
    if (!isAlive(rank))
        return;
    try {
        channel_.send(rank, message);
    } catch (const Error& error) {
        noteDeath(rank, error.what());
    }
}

std::optional<Message> Ranks::receive(int milliseconds) {
    std::lock_guard lock(receives_);
    try {
        while (std::optional<Message> message = channel_.receive(milliseconds))
            if (note(*message))
                return message;
    } catch (const Error& error) {
        for (const uint32_t rank : alive())
            noteDeath(rank, error.what());
    }
    return std::nullopt;
}

// Handles a message about nodes. Returns whether the message is for the launch.
bool Ranks::note(const Message& message) {
    Reader in(message.bytes);
    const auto kind = in.get<MessageKind>();
    if (kind == MessageKind::kHello) {
        std::lock_guard lock(mutex_);
        memories_[message.rank] = in.get<uint64_t>();
        return false;
    }
    if (kind == MessageKind::kDied)
        noteDeath(message.rank, message.bytes.substr(1));
    return true;
}

void Ranks::noteDeath(uint32_t rank, const std::string& cause) {
    {
        std::lock_guard lock(mutex_);
        if (!dead_.insert(rank).second)
            return;
        memories_.erase(rank);
    }
    log(LogLevel::kError, "optix6",
        message("rank ", rank, " has died (", cause, "); the other ranks go on"));
}

} // namespace sunstone::optix6
