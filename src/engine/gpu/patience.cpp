// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/patience.h"

#include <algorithm>
#include <iterator>

namespace sunstone::engine {

namespace {

using devlib::WarpPace;

constexpr uint32_t kWays[] = {devlib::kShortPatience, devlib::kLongPatience, devlib::kTilePatience,
                              devlib::kDepthPatience};
static_assert(std::size(kWays) == devlib::kPatienceWays);

// After so many launches all settings are tried again, because scenes and cameras change.
constexpr unsigned kLaunchesOfAChoice = 64;

bool isSlower(const WarpPace& a, const WarpPace& b) {
    return double(a.rays) * double(b.time) < double(b.rays) * double(a.time);
}

// Whether there are enough rays for a decision.
bool isEnough(const WarpPace& pace) {
    constexpr uint64_t kEnoughRays = 1 << 18;
    return pace.rays >= kEnoughRays && pace.time != 0;
}

void add(WarpPace& sum, const WarpPace& pace) {
    sum.rays += pace.rays;
    sum.time += pace.time;
}

} // namespace

bool WarpPatience::isMeasured() const {
    return std::ranges::all_of(sums_, isEnough);
}

void WarpPatience::renew() {
    launches_ = 0;
    std::ranges::fill(sums_, WarpPace{});
    alone_ = withBlock_ = {};
}

void WarpPatience::choose(devlib::LaunchWork& work, bool mayTry, bool withBlocks) {
    std::lock_guard lock(mutex_);
    if (isMeasured() && ++launches_ >= kLaunchesOfAChoice)
        renew();
    const bool knows = isMeasured();
    work.isMeasured = mayTry && !knows;
    if (work.isMeasured) {
        std::ranges::copy(kWays, work.patience);
        return;
    }
    uint32_t best = kWays[knows ? std::ranges::max_element(sums_, isSlower) - sums_ : 0];
    if (withBlocks && best == devlib::kDepthPatience) {
        const bool compares = !isEnough(alone_) || !isEnough(withBlock_);
        work.isMeasured = mayTry && compares;
        if (compares ? mayTry && isEnough(alone_) : isSlower(alone_, withBlock_))
            best |= devlib::kWithBlock;
    }
    std::ranges::fill(work.patience, best);
}

void WarpPatience::learn(const WarpPace (&paces)[devlib::kPatienceWays],
                         const devlib::LaunchWork& work) {
    if (!work.isMeasured)
        return;
    std::lock_guard lock(mutex_);
    const bool triesAll = work.patience[0] != work.patience[1];
    if (triesAll && isMeasured()) // a launch that was queued before the choice
        return;
    WarpPace& whole = work.patience[0] & devlib::kWithBlock ? withBlock_ : alone_;
    for (unsigned i = 0; i < devlib::kPatienceWays; ++i)
        add(triesAll ? sums_[i] : whole, paces[i]);
}

} // namespace sunstone::engine
