// SPDX-License-Identifier: Apache-2.0
// What the functions of a warp answer, from what each lane brought.
#pragma once

#include "devlib/lockstep.h"

namespace sunstone::compiler {

// The lanes that take part, and what they brought.
struct Gathered {
    uint64_t values[devlib::kWarpLanes];
    uint32_t present;
};

// Where shfl.sync finds the value of a lane, by its own number.
struct ShuffleSource {
    uint32_t lane; // itself where `isValid` says that there is none
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
// what: as in LockstepWarp::point; the number of the point does not matter.
void answerLanes(devlib::LockstepWarp* warp, uint32_t what, uint32_t lanes, uint32_t asking);

} // namespace sunstone::compiler
