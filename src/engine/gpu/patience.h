// SPDX-License-Identifier: Apache-2.0
// Measures how long the warps of a pipeline should walk on for their slowest lanes before they
// refill idle ones (devlib/gpu/loop.h). Launches of the pipeline try all settings side by side, and
// later ones use the fastest; pictures are the same with all settings.
//
// With the settings for long programs, further launches tell whether it is faster if the warps of a
// block wait for each other, and how large blocks are then. One launch tries one size, because
// blocks of several sizes side by side would share the instruction cache. The sizes grow until one
// is slower than the size before.
#pragma once

#include "devlib/gpu/launch_block.h"

#include <atomic>
#include <mutex>
#include <vector>

namespace sunstone::engine {

// A size of a kernel's blocks.
struct GpuBlockSize {
    unsigned threads;
    uint64_t resident; // threads of such blocks that the GPU runs at a time
};

// Any thread may call any function but setBlocks at any time.
class WarpPatience {
public:
    // The first size is that of blocks whose warps never wait; warps of all others wait. Sizes
    // grow. `processors`: multiprocessors of the GPU. To be called before the first launch.
    void setBlocks(std::vector<GpuBlockSize> sizes, unsigned processors);
    // Sets the patience of the next launch and returns the threads of its blocks. `mayTry`: the
    // launch reports soon, unlike launches of graphs.
    unsigned choose(devlib::LaunchWork& work, bool mayTry);
    // Adds the report of the launch that `work` was chosen for.
    void learn(const devlib::WarpPace (&paces)[devlib::kPatienceWays],
               const devlib::LaunchWork& work);

private:
    // Of launches with one size of blocks. time: of all warps, divided by the number of threads
    // that run at a time.
    struct Pace {
        double rays = 0, time = 0;
    };

    bool isMeasured() const;
    void renew();
    size_t usableSizes(uint64_t indices) const;
    size_t nextSize(size_t usable) const;

    std::mutex mutex_;
    devlib::WarpPace sums_[devlib::kPatienceWays] = {};
    std::vector<GpuBlockSize> sizes_ = {{devlib::kGpuBlockThreads, 1}};
    std::vector<Pace> blocks_ = std::vector<Pace>(1); // with the fastest patience, for each size
    unsigned processors_ = 1;
    unsigned launches_ = 0; // since the choice was measured last
};

// Results of a pipeline's launches for later ones. Launches may outlive the pipeline.
struct LaunchFindings {
    std::atomic<uint64_t> usualHandle = 0; // that rays of the last launch used, if any reported it
    WarpPatience patience;
};

} // namespace sunstone::engine
