// SPDX-License-Identifier: Apache-2.0
// Results of warp functions, computed from each lane's operands.
#pragma once

#include "devlib/lockstep.h"

namespace sunstone::compiler {

// The participating lanes and their operands.
struct Gathered {
    uint64_t values[devlib::kWarpLanes];
    uint32_t present;
};

// The lane from which shfl.sync reads, for one lane.
struct ShuffleSource {
    uint32_t lane; // the lane itself unless isValid
    bool isValid;
};
ShuffleSource shuffleSource(uint32_t mode, uint32_t lane, uint32_t distance, uint32_t control);

uint32_t answerVote(uint32_t mode, const Gathered& all);
// Value in the low, validity in the high word.
uint64_t answerShuffle(uint32_t mode, uint32_t lane, uint32_t distance, uint32_t control,
                       const Gathered& all);
uint64_t answerMatch(uint32_t wantAll, uint64_t value, const Gathered& all);
uint32_t answerReduce(uint32_t operation, const Gathered& all);

// Lanes have met at warp functions: fills LockstepWarp::result of `asking`, some or all of them.
// what: as in LockstepWarp::point; the point's number is ignored.
void answerLanes(devlib::LockstepWarp* warp, uint32_t what, uint32_t lanes, uint32_t asking);

} // namespace sunstone::compiler
