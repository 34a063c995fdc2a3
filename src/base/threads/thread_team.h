// SPDX-License-Identifier: Apache-2.0
// A limited number of the process's threads, for callers that ask for one.
#pragma once

#include <functional>
#include <memory>

namespace sunstone {

class ThreadTeam {
public:
    // At least one thread, at most threadCount().
    explicit ThreadTeam(unsigned threads);
    ~ThreadTeam();
    ThreadTeam(const ThreadTeam&) = delete;
    ThreadTeam& operator=(const ThreadTeam&) = delete;

    unsigned threads() const { return threads_; }
    // Runs body on the calling thread. parallelFor and inArena, called there, use this team.
    void run(const std::function<void()>& body);

private:
    friend void inArena(const std::function<void()>& body);
    friend void parallelFor(size_t count, size_t grain,
                            const std::function<void(size_t, size_t)>& body);
    struct Arena;
    unsigned threads_;
    std::unique_ptr<Arena> arena_;
};

} // namespace sunstone
