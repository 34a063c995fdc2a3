// SPDX-License-Identifier: Apache-2.0
// Measures how long the warps of a pipeline should walk on for their slowest lanes before they
// refill idle ones (devlib/gpu/loop.h). Launches of the pipeline try all settings side by side, and
// later ones use the fastest; pictures are the same with all settings.
//
// Where the fastest is that for long programs, two further launches tell whether it is faster if
// the warps of a block wait for each other. Blocks of both kinds side by side would not tell: they
// share the instruction cache.
#pragma once

#include "devlib/gpu/launch_block.h"

#include <atomic>
#include <mutex>

namespace sunstone::engine {

// Any thread may call any function at any time.
class WarpPatience {
public:
    // Sets the patience of the next launch. `mayTry`: the launch reports soon, unlike launches of
    // graphs. `withBlocks`: the warps of a block may wait for each other.
    void choose(devlib::LaunchWork& work, bool mayTry, bool withBlocks);
    // Adds the report of the launch that `work` was chosen for.
    void learn(const devlib::WarpPace (&paces)[devlib::kPatienceWays],
               const devlib::LaunchWork& work);

private:
    bool isMeasured() const;
    void renew();

    std::mutex mutex_;
    devlib::WarpPace sums_[devlib::kPatienceWays] = {};
    devlib::WarpPace alone_ = {}, withBlock_ = {}; // of the fastest
    unsigned launches_ = 0;                        // since the choice was measured last
};

// Results of a pipeline's launches for later ones. Launches may outlive the pipeline.
struct LaunchFindings {
    std::atomic<uint64_t> usualHandle = 0; // that rays of the last launch used, if any reported it
    WarpPatience patience;
};

} // namespace sunstone::engine
