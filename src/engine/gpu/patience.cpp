// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/patience.h"

namespace sunstone::engine {

namespace {

// Rays of one way that are worth an answer.
constexpr uint64_t kEnoughRays = 1 << 18;
// Scenes and cameras change: so many launches later both ways are tried again.
constexpr unsigned kLaunchesOfAChoice = 64;

double rateOf(const devlib::WarpPace& sum) {
    return double(sum.rays) / double(sum.time);
}

} // namespace

bool WarpPatience::isMeasured() const {
    return sums_[0].rays >= kEnoughRays && sums_[1].rays >= kEnoughRays && sums_[0].time != 0 &&
           sums_[1].time != 0;
}

void WarpPatience::choose(devlib::LaunchWork& work, bool mayTry) {
    constexpr uint32_t kWays[2] = {devlib::kShortPatience, devlib::kLongPatience};
    std::lock_guard lock(mutex_);
    if (isMeasured() && ++launches_ >= kLaunchesOfAChoice) {
        launches_ = 0;
        sums_[0] = sums_[1] = {};
    }
    const bool tries = mayTry && !isMeasured();
    const uint32_t better = isMeasured() && rateOf(sums_[1]) > rateOf(sums_[0]);
    for (uint32_t i = 0; i < 2; ++i)
        work.patience[i] = kWays[tries ? i : better];
    work.isMeasured = tries;
}

void WarpPatience::learn(const devlib::WarpPace (&paces)[2]) {
    std::lock_guard lock(mutex_);
    if (isMeasured()) // a launch that was queued before the choice
        return;
    for (unsigned i = 0; i < 2; ++i) {
        sums_[i].rays += paces[i].rays;
        sums_[i].time += paces[i].time;
    }
}

} // namespace sunstone::engine
