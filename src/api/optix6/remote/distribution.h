// SPDX-License-Identifier: Apache-2.0
// Distributes the subframes of one progressive launch over the ranks: this rank takes one after the
// other, nodes get ranges that take them about a fifth of a second. The subframes of a node that
// dies go to other ranks, so that the picture has the same subframes as on one rank.
#pragma once

#include "api/optix6/remote/ranks.h"

#include <deque>
#include <functional>
#include <optional>

namespace sunstone::optix6 {

class Reader;

class Distribution {
public:
    // `limit`: number of subframes; 0: none. Without nodes this rank renders all.
    Distribution(Ranks* ranks, std::vector<uint32_t> nodes, uint64_t launch, unsigned limit);
    // Tells the nodes that the launch has ended.
    ~Distribution();
    Distribution(const Distribution&) = delete;

    // The next subframe of this rank; none if other ranks render the rest.
    std::optional<unsigned> take();
    void noteOwn() {
        ++made_;
        ++counts_[0];
    }
    // add(count, sums): `sums` contains the sum of `count` subframes for each picture.
    using Add = std::function<void(unsigned count, Reader& sums)>;
    // Receives the results of nodes, and waits that long for them.
    void receive(int milliseconds, const Add& add);
    bool isDone() const { return limit_ != 0 && made_ == limit_; }

private:
    struct Range {
        unsigned first, count;
    };
    struct Node {
        std::deque<Range> given;
        double secondsEach = 0; // 0: not known yet
    };
    Range cut(unsigned most);
    void give(uint32_t rank);
    void takeBack(uint32_t rank);
    void takeSums(uint32_t rank, Reader& in, const Add& add);

    Ranks* const ranks_;
    const uint64_t launch_;
    const unsigned limit_;
    std::map<uint32_t, Node> nodes_;
    std::deque<Range> open_; // that nodes have not finished
    unsigned next_ = 0, made_ = 0;
    std::map<uint32_t, unsigned> counts_; // of subframes, by rank; for the log
};

} // namespace sunstone::optix6
