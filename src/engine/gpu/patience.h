// SPDX-License-Identifier: Apache-2.0
// How long the warps of a pipeline wait for the rays of their slowest lanes before they look after
// idle ones (devlib/gpu/loop.h). Launches of the pipeline try all ways side by side, and later ones
// take the fastest; pictures are the same either way.
#pragma once

#include "devlib/gpu/launch_block.h"

#include <atomic>
#include <mutex>

namespace sunstone::engine {

// Any thread may call any function at any time.
class WarpPatience {
public:
    // Fills the patience of the next launch. `mayTry`: it reports soon, as launches of graphs do
    // not.
    void choose(devlib::LaunchWork& work, bool mayTry);
    // What a launch has reported.
    void learn(const devlib::WarpPace (&paces)[devlib::kPatienceWays]);

private:
    bool isMeasured() const;

    std::mutex mutex_;
    devlib::WarpPace sums_[devlib::kPatienceWays] = {};
    unsigned launches_ = 0; // since the choice was measured last
};

// What launches of a pipeline have found out for later ones. Launches may outlive the pipeline.
struct LaunchFindings {
    std::atomic<uint64_t> usualHandle = 0; // that rays of the last launch used, if any reported it
    WarpPatience patience;
};

} // namespace sunstone::engine
