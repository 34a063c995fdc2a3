// SPDX-License-Identifier: Apache-2.0
#include "engine/cpu/pace.h"

#include "base/config.h"

namespace sunstone::engine::cpu {
namespace {

// Halves of pieces, and nanoseconds, that suffice for a comparison of the ways.
constexpr uint64_t kEnoughHalves = 8, kEnoughTime = 2'000'000;
// The first measured pieces are discarded later: they touch memory for the first time.
constexpr uint32_t kWarm = 8;
// After so many measured pieces earlier ones count half, so that the choice follows the scene.
constexpr uint32_t kHalveEvery = 64;
// Once both ways are known, one piece in this many is measured.
constexpr uint32_t kMeasureEvery = 32;

} // namespace

WishedWay wishedWay() {
    if (currentConfig(Setting::kKernels) == "single")
        return WishedWay::kAlone;
    const std::string wish = currentConfig(Setting::kRays);
    return wish == "alone"     ? WishedWay::kAlone
           : wish == "batches" ? WishedWay::kInFlight
                               : WishedWay::kFaster;
}

// Another thread may add meanwhile. Its half is then lost or counts in part, which is harmless.
void Pace::Sum::divide(uint64_t by) {
    for (std::atomic<uint64_t>* each : {&nanoseconds, &indices, &halves})
        each->store(each->load(std::memory_order_relaxed) / by, std::memory_order_relaxed);
}

double Pace::Sum::cost() const {
    return double(nanoseconds.load(std::memory_order_relaxed)) /
           double(indices.load(std::memory_order_relaxed) + 1);
}

bool Pace::isKnown(Way way) const {
    return of(way).halves.load(std::memory_order_relaxed) >= kEnoughHalves &&
           of(way).nanoseconds.load(std::memory_order_relaxed) >= kEnoughTime;
}

Pace::Plan Pace::next() {
    const uint32_t piece = pieces_.fetch_add(1, std::memory_order_relaxed);
    if (isKnown(Way::kAlone) && isKnown(Way::kInFlight) && piece % kMeasureEvery != 0)
        return {false,
                of(Way::kInFlight).cost() < of(Way::kAlone).cost() ? Way::kInFlight : Way::kAlone};
    const uint32_t number = measured_.fetch_add(1, std::memory_order_relaxed);
    if (number == kWarm || (number > kWarm && number % kHalveEvery == 0))
        for (Sum& sum : sums_)
            sum.divide(number == kWarm ? ~uint64_t(0) : 2);
    return {true, number % 2 ? Way::kInFlight : Way::kAlone};
}

void Pace::add(Way way, uint64_t indices, uint64_t nanoseconds) {
    Sum& sum = sums_[unsigned(way)];
    sum.indices.fetch_add(indices, std::memory_order_relaxed);
    sum.nanoseconds.fetch_add(nanoseconds, std::memory_order_relaxed);
    sum.halves.fetch_add(1, std::memory_order_relaxed);
}

} // namespace sunstone::engine::cpu
