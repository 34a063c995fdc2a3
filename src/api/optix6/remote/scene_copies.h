// SPDX-License-Identifier: Apache-2.0
// The copies of a context's scene on other ranks, and the ranks that take part in its progressive
// launches: those that its remote device has reserved, or all.
#pragma once

#include "api/optix6/object.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace sunstone::optix6 {

class Buffer;
class Ranks;
class SceneSender;

class SceneCopies {
public:
    explicit SceneCopies(Context& context);
    ~SceneCopies();

    struct Launch {
        unsigned entry;
        uint32_t width, height;
        std::vector<std::shared_ptr<Buffer>> sources; // whose sums are requested
    };
    // Updates the copies and starts the launch on them; returns its number. Throws Failure: the
    // remote device has no nodes.
    uint64_t start(const Launch& launch);
    void release(); // releases the ranks for other contexts
    // The ranks that take part in the launch; null if this rank is alone.
    Ranks* ranks() const { return ranks_; }
    const std::vector<uint32_t>& nodes() const { return nodes_; }

private:
    std::vector<uint32_t> wantedNodes(Ranks* ranks) const;
    void drop();

    Context& context_;
    Ranks* ranks_ = nullptr; // while a launch uses them
    std::vector<uint32_t> nodes_;
    // The state and the ranks of the copies.
    uint64_t number_ = 0;
    std::vector<uint32_t> holders_;
    std::unique_ptr<SceneSender> sender_;
};

} // namespace sunstone::optix6
