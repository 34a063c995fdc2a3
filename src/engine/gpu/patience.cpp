// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/patience.h"

#include <algorithm>
#include <iterator>

namespace sunstone::engine {

namespace {

// Rays with one patience that suffice for a decision.
constexpr uint64_t kEnoughRays = 1 << 18;
// After so many launches all settings are tried again, because scenes and cameras change.
constexpr unsigned kLaunchesOfAChoice = 64;

bool isSlower(const devlib::WarpPace& a, const devlib::WarpPace& b) {
    return double(a.rays) * double(b.time) < double(b.rays) * double(a.time);
}

} // namespace

bool WarpPatience::isMeasured() const {
    return std::ranges::all_of(sums_, [](const devlib::WarpPace& each) {
        return each.rays >= kEnoughRays && each.time != 0;
    });
}

void WarpPatience::choose(devlib::LaunchWork& work, bool mayTry) {
    constexpr uint32_t kWays[] = {devlib::kShortPatience, devlib::kLongPatience,
                                  devlib::kTilePatience, devlib::kDepthPatience};
    static_assert(std::size(kWays) == devlib::kPatienceWays);
    std::lock_guard lock(mutex_);
    if (isMeasured() && ++launches_ >= kLaunchesOfAChoice) {
        launches_ = 0;
        std::ranges::fill(sums_, devlib::WarpPace{});
    }
    const bool tries = mayTry && !isMeasured();
    const auto best = isMeasured() ? std::ranges::max_element(sums_, isSlower) - sums_ : 0;
    for (size_t i = 0; i < std::size(kWays); ++i)
        work.patience[i] = kWays[tries ? i : size_t(best)];
    work.isMeasured = tries;
}

void WarpPatience::learn(const devlib::WarpPace (&paces)[devlib::kPatienceWays]) {
    std::lock_guard lock(mutex_);
    if (isMeasured()) // a launch that was queued before the choice
        return;
    for (unsigned i = 0; i < devlib::kPatienceWays; ++i) {
        sums_[i].rays += paces[i].rays;
        sums_[i].time += paces[i].time;
    }
}

} // namespace sunstone::engine
