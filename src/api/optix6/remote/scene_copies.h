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
        std::vector<std::shared_ptr<Buffer>> sources; // whose sums are wanted
    };
    // Brings the copies up to date and starts the launch on them; its number. Throws Failure: the
    // remote device has no nodes.
    uint64_t start(const Launch& launch);
    void release(); // the ranks, for other contexts
    // Those that take part in the launch; null and none: this rank is alone.
    Ranks* ranks() const { return ranks_; }
    const std::vector<uint32_t>& nodes() const { return nodes_; }

private:
    std::vector<uint32_t> wantedNodes(Ranks* ranks) const;
    void drop();

    Context& context_;
    Ranks* ranks_ = nullptr; // while a launch has them
    std::vector<uint32_t> nodes_;
    // What the copies are, and where they are.
    uint64_t number_ = 0;
    std::vector<uint32_t> holders_;
    std::unique_ptr<SceneSender> sender_;
};

} // namespace sunstone::optix6
