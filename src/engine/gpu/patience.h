// SPDX-License-Identifier: Apache-2.0
// Measures how long the warps of a pipeline should walk on for their slowest lanes before they
// refill idle ones (devlib/gpu/loop.h). Launches of the pipeline try all settings side by side, and
// later ones use the fastest; pictures are the same with all settings.
#pragma once

#include "devlib/gpu/launch_block.h"

#include <atomic>
#include <mutex>

namespace sunstone::engine {

// Any thread may call any function at any time.
class WarpPatience {
public:
    // Sets the patience of the next launch. `mayTry`: the launch reports soon, unlike launches of
    // graphs.
    void choose(devlib::LaunchWork& work, bool mayTry);
    // Adds the report of a launch.
    void learn(const devlib::WarpPace (&paces)[devlib::kPatienceWays]);

private:
    bool isMeasured() const;

    std::mutex mutex_;
    devlib::WarpPace sums_[devlib::kPatienceWays] = {};
    unsigned launches_ = 0; // since the choice was measured last
};

// Results of a pipeline's launches for later ones. Launches may outlive the pipeline.
struct LaunchFindings {
    std::atomic<uint64_t> usualHandle = 0; // that rays of the last launch used, if any reported it
    WarpPatience patience;
};

} // namespace sunstone::engine
