// SPDX-License-Identifier: Apache-2.0
// Which way of running launch indices is faster for a pipeline. Launches measure both on pieces of
// their own; pictures are the same either way.
#pragma once

#include <atomic>
#include <cstdint>

namespace sunstone::engine::cpu {

enum class Way : uint8_t { kAlone, kInFlight };

// What SUNSTONE_RAYS asks for.
enum class WishedWay : uint8_t { kAlone, kInFlight, kFaster };
WishedWay wishedWay();

// Any thread may call any function at any time.
//
// The parts of a picture cost very different times. So a piece that is measured runs one half in
// each way: the two have the same neighbourhood.
class Pace {
public:
    struct Plan {
        bool isMeasured;
        Way way; // of the piece; of its first half if it is measured
    };
    Plan next();
    // A half of `indices` launch indices took so long on its thread.
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
