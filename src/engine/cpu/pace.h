// SPDX-License-Identifier: Apache-2.0
// Decides which way of running launch indices is faster for a pipeline. Launches measure both ways
// on pieces of the picture; results are the same either way.
#pragma once

#include <atomic>
#include <cstdint>

namespace sunstone::engine::cpu {

enum class Way : uint8_t { kAlone, kInFlight };

// The value of SUNSTONE_RAYS.
enum class WishedWay : uint8_t { kAlone, kInFlight, kFaster };
WishedWay wishedWay();

// Any thread may call any function at any time.
//
// The cost of a picture's parts varies widely. A measured piece therefore runs one half in each
// way: halves with the same neighbourhood are comparable. Only the second part of a half counts,
// because the first finds the caches filled by the other way, which favours single rays.
class Pace {
public:
    struct Plan {
        bool isMeasured;
        Way way; // of the piece; of its first half if it is measured
    };
    Plan next();
    // Adds the counted part of a half: `indices` launch indices and the time that they took on
    // their thread.
    void add(Way way, uint64_t indices, uint64_t nanoseconds);

private:
    struct Sum {
        std::atomic<uint64_t> nanoseconds{0}, indices{0}, halves{0};
        void divide(uint64_t by);
        double cost() const;
    };
    const Sum& of(Way way) const { return sums_[unsigned(way)]; }
    bool isKnown(Way way) const;

    Sum sums_[2];
    std::atomic<uint32_t> pieces_{0}, measured_{0};
};

} // namespace sunstone::engine::cpu
