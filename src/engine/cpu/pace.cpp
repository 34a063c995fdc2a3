// SPDX-License-Identifier: Apache-2.0
#include "engine/cpu/pace.h"

#include "base/config.h"

namespace sunstone::engine::cpu {
namespace {

// Enough to tell the ways apart.
constexpr uint64_t kEnough = 2'000'000; // nanoseconds
// Older pieces count half from here on, so that the choice follows the scene.
constexpr uint64_t kMuch = 100'000'000;
// One piece of so many goes the slower way, to see whether it still is the slower one.
constexpr uint32_t kTrialEvery = 64;

} // namespace

WishedWay wishedWay() {
    if (currentConfig(Setting::kKernels) == "single")
        return WishedWay::kAlone;
    const std::string wish = currentConfig(Setting::kRays);
    return wish == "alone"     ? WishedWay::kAlone
           : wish == "batches" ? WishedWay::kInFlight
                               : WishedWay::kFaster;
}

bool Pace::isMeasured(const Sum& sum) const {
    return sum.nanoseconds.load(std::memory_order_relaxed) >= kEnough;
}

Way Pace::next() {
    const uint32_t piece = pieces_.fetch_add(1, std::memory_order_relaxed);
    const bool alone = isMeasured(of(Way::kAlone)), inFlight = isMeasured(of(Way::kInFlight));
    if (!alone || !inFlight)
        return alone || (!inFlight && piece % 2) ? Way::kInFlight : Way::kAlone;
    const auto cost = [&](Way way) {
        const Sum& sum = of(way);
        return double(sum.nanoseconds.load(std::memory_order_relaxed)) /
               double(sum.indices.load(std::memory_order_relaxed));
    };
    const bool better = cost(Way::kInFlight) < cost(Way::kAlone);
    const bool trial = piece % kTrialEvery == 0;
    return better != trial ? Way::kInFlight : Way::kAlone;
}

void Pace::add(Way way, uint64_t indices, uint64_t nanoseconds) {
    Sum& sum = of(way);
    // Two threads that halve at once make older pieces count a quarter, which does no harm.
    if (sum.nanoseconds.load(std::memory_order_relaxed) > kMuch) {
        sum.nanoseconds.store(sum.nanoseconds.load(std::memory_order_relaxed) / 2,
                              std::memory_order_relaxed);
        sum.indices.store(sum.indices.load(std::memory_order_relaxed) / 2 + 1,
                          std::memory_order_relaxed);
    }
    sum.indices.fetch_add(indices, std::memory_order_relaxed);
    sum.nanoseconds.fetch_add(nanoseconds, std::memory_order_relaxed);
}

} // namespace sunstone::engine::cpu
