// SPDX-License-Identifier: Apache-2.0
#include "engine/cpu/pace.h"

#include "base/config.h"

#include <bit>

namespace sunstone::engine::cpu {
namespace {

// Enough to tell the ways apart.
constexpr uint64_t kEnough = 2'000'000; // nanoseconds
// At each of these pieces, older ones count half from then on. Both ways forget at the same pieces,
// so that their averages are of the same parts of the picture. In the beginning they forget soon.
constexpr uint32_t kHalveEvery = 4096;
bool halvesAt(uint32_t piece) {
    return piece < kHalveEvery ? std::has_single_bit(piece) : piece % kHalveEvery == 0;
}
// The pieces before this one do not count later: they touch memory for the first time.
constexpr uint32_t kWarm = 64;
// One piece of 64 goes the slower way, to see whether it still is the slower one. Which one differs
// from launch to launch, as the parts of a picture cost different times.
bool isTrial(uint32_t piece) {
    return piece * 0x9E3779B1u >> 26 == 0;
}

} // namespace

WishedWay wishedWay() {
    if (currentConfig(Setting::kKernels) == "single")
        return WishedWay::kAlone;
    const std::string wish = currentConfig(Setting::kRays);
    return wish == "alone"     ? WishedWay::kAlone
           : wish == "batches" ? WishedWay::kInFlight
                               : WishedWay::kFaster;
}

// Another thread may add meanwhile: its piece is lost, or counts in one of the two, which does no
// harm.
void Pace::Sum::divide(uint64_t by) {
    nanoseconds.store(nanoseconds.load(std::memory_order_relaxed) / by, std::memory_order_relaxed);
    indices.store(indices.load(std::memory_order_relaxed) / by + 1, std::memory_order_relaxed);
}

bool Pace::isMeasured(const Sum& sum) const {
    return sum.nanoseconds.load(std::memory_order_relaxed) >= kEnough;
}

Way Pace::next() {
    const uint32_t piece = pieces_.fetch_add(1, std::memory_order_relaxed);
    if (piece >= kWarm && halvesAt(piece))
        for (Sum& sum : sums_)
            sum.divide(piece == kWarm ? ~uint64_t(0) : 2);
    const bool alone = isMeasured(of(Way::kAlone)), inFlight = isMeasured(of(Way::kInFlight));
    if (!alone || !inFlight)
        return alone || (!inFlight && piece % 2) ? Way::kInFlight : Way::kAlone;
    const auto cost = [&](Way way) {
        const Sum& sum = of(way);
        return double(sum.nanoseconds.load(std::memory_order_relaxed)) /
               double(sum.indices.load(std::memory_order_relaxed));
    };
    const bool better = cost(Way::kInFlight) < cost(Way::kAlone);
    const bool trial = isTrial(piece);
    return better != trial ? Way::kInFlight : Way::kAlone;
}

void Pace::add(Way way, uint64_t indices, uint64_t nanoseconds) {
    Sum& sum = of(way);
    sum.indices.fetch_add(indices, std::memory_order_relaxed);
    sum.nanoseconds.fetch_add(nanoseconds, std::memory_order_relaxed);
}

} // namespace sunstone::engine::cpu
