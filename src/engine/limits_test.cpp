// SPDX-License-Identifier: Apache-2.0
// Limits of a pipeline that one thread sets while another launches.
#include "engine/pipeline.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace sunstone::engine {
namespace {

TEST(SharedLimits, AreReadAsOneCallSetThem) {
    constexpr unsigned kRounds = 200'000;
    Pipeline pipeline;
    const auto set = [&](unsigned value) {
        pipeline.limits.update([&](PipelineLimits& limits) {
            limits.directStackFromTraversal = value;
            limits.directStackFromState = value;
            limits.continuationStack = value;
            limits.maxGraphDepth = value;
        });
    };
    set(0);
    std::atomic<bool> ends{false};
    std::thread setter([&] {
        for (unsigned value = 1; !ends.load(std::memory_order_relaxed); ++value)
            set(value);
    });
    unsigned torn = 0;
    for (unsigned i = 0; i < kRounds; ++i) {
        const PipelineLimits seen = pipeline.limits.get();
        torn += seen.directStackFromState != seen.directStackFromTraversal ||
                seen.continuationStack != seen.directStackFromTraversal ||
                seen.maxGraphDepth != seen.directStackFromTraversal;
    }
    ends = true;
    setter.join();
    EXPECT_EQ(torn, 0u);
}

} // namespace
} // namespace sunstone::engine
