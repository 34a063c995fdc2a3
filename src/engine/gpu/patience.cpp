// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/patience.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace sunstone::engine {

namespace {

using devlib::WarpPace;

constexpr uint32_t kWays[] = {devlib::kShortPatience, devlib::kLongPatience, devlib::kTilePatience,
                              devlib::kDepthPatience};
static_assert(std::size(kWays) == devlib::kPatienceWays);

// After so many launches all settings are tried again, because scenes and cameras change.
constexpr unsigned kLaunchesOfAChoice = 64;

template <class Pace>
bool isSlower(const Pace& a, const Pace& b) {
    return double(a.rays) * double(b.time) < double(b.rays) * double(a.time);
}

// Whether there are enough rays for a decision.
template <class Pace>
bool isEnough(const Pace& pace) {
    constexpr uint64_t kEnoughRays = 1 << 18;
    return pace.rays >= kEnoughRays && pace.time != 0;
}

} // namespace

bool WarpPatience::isMeasured() const {
    return std::ranges::all_of(sums_, isEnough<WarpPace>);
}

void WarpPatience::renew() {
    launches_ = 0;
    std::ranges::fill(sums_, WarpPace{});
    std::ranges::fill(blocks_, Pace{});
}

void WarpPatience::setBlocks(std::vector<GpuBlockSize> sizes, unsigned processors) {
    sizes_ = std::move(sizes);
    blocks_.assign(sizes_.size(), {});
    processors_ = processors;
}

// Small launches have small blocks, so that each multiprocessor has one.
size_t WarpPatience::usableSizes(uint64_t indices) const {
    size_t usable = 1;
    while (usable < sizes_.size() && indices >= uint64_t(sizes_[usable].threads) * processors_)
        ++usable;
    return usable;
}

// The size to measure next, or the fastest one if that is known.
size_t WarpPatience::nextSize(size_t usable) const {
    if (usable == 1)
        return 0;
    for (size_t i = 0; i < usable; ++i) {
        if (!isEnough(blocks_[i]))
            return i;
        if (i > 0 && isSlower(blocks_[i], blocks_[i - 1]))
            return i - 1;
    }
    return usable - 1;
}

unsigned WarpPatience::choose(devlib::LaunchWork& work, bool mayTry) {
    std::lock_guard lock(mutex_);
    if (isMeasured() && ++launches_ >= kLaunchesOfAChoice)
        renew();
    const bool knows = isMeasured();
    work.isMeasured = mayTry && !knows;
    work.blockSize = 0;
    if (work.isMeasured) {
        std::ranges::copy(kWays, work.patience);
        return sizes_[0].threads;
    }
    uint32_t best = kWays[knows ? std::ranges::max_element(sums_, isSlower<WarpPace>) - sums_ : 0];
    if (best >= devlib::kTilePatience) {
        const size_t usable = usableSizes(work.count), size = nextSize(usable);
        const bool isNew = usable > 1 && !isEnough(blocks_[size]);
        work.isMeasured = mayTry && isNew;
        work.blockSize = uint32_t(isNew && !mayTry && size > 0 ? size - 1 : size);
    }
    if (work.blockSize > 0)
        best |= devlib::kWithBlock;
    std::ranges::fill(work.patience, best);
    return sizes_[work.blockSize].threads;
}

void WarpPatience::learn(const WarpPace (&paces)[devlib::kPatienceWays],
                         const devlib::LaunchWork& work) {
    if (!work.isMeasured)
        return;
    std::lock_guard lock(mutex_);
    const bool triesAll = work.patience[0] != work.patience[1];
    if (triesAll && isMeasured()) // a launch that was queued before the choice
        return;
    const double atOnce = double(std::min(work.count, sizes_[work.blockSize].resident));
    for (unsigned i = 0; i < devlib::kPatienceWays; ++i) {
        if (triesAll) {
            sums_[i].rays += paces[i].rays;
            sums_[i].time += paces[i].time;
        } else {
            blocks_[work.blockSize].rays += double(paces[i].rays);
            blocks_[work.blockSize].time += double(paces[i].time) / atOnce;
        }
    }
}

} // namespace sunstone::engine
