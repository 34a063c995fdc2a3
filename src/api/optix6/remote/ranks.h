// SPDX-License-Identifier: Apache-2.0
// The other ranks of `mpirun sunstone run`, seen from the rank that runs the application. Each has
// a node: a process that holds copies of scenes and renders subframes (node.cpp).
#pragma once

#include "api/optix6/remote/channel.h"

#include <atomic>
#include <memory>
#include <mutex>
#include <set>
#include <vector>

namespace sunstone::optix6 {

class Ranks {
public:
    // Null if the process is not part of such a run, or is its only rank.
    static Ranks* get();

    unsigned size() const { return size_; } // including this rank, which is 0
    bool isAlive(uint32_t rank) const;
    std::vector<uint32_t> alive() const; // excluding this rank
    // Memory of the devices of all ranks that have reported it, excluding this rank.
    uint64_t memory() const;
    // Handles deaths of nodes while no launch does.
    void refresh();

    // One launch at a time uses the nodes.
    bool acquire(const void* owner);
    void release(const void* owner);
    uint64_t newNumber() { return ++lastNumber_; } // of a launch or a copy of a scene

    // A message that cannot be sent is lost together with its node.
    void send(uint32_t rank, const std::string& message);
    // The next message from a node for the launch; also the message that a node has died.
    std::optional<Message> receive(int milliseconds);

private:
    Ranks(int socket, unsigned size) : channel_(socket), size_(size) {}
    static Ranks* connect();
    bool note(const Message& message);
    void noteDeath(uint32_t rank, const std::string& cause);

    Channel channel_;
    const unsigned size_;
    std::atomic<uint64_t> lastNumber_{1};
    std::mutex receives_;
    mutable std::mutex mutex_;
    const void* owner_ = nullptr;
    std::set<uint32_t> dead_;
    std::map<uint32_t, uint64_t> memories_;
};

} // namespace sunstone::optix6
