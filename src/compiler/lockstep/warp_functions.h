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
// Returns the value in the low and the validity in the high word.
uint64_t answerShuffle(uint32_t mode, uint32_t lane, uint32_t distance, uint32_t control,
                       const Gathered& all);
uint64_t answerMatch(uint32_t wantAll, uint64_t value, const Gathered& all);
uint32_t answerReduce(uint32_t operation, const Gathered& all);

// Called when `lanes` have met at a warp function. Fills LockstepWarp::result of `asking`, some or
// all of them. what: as in LockstepWarp::point; the point's number is ignored.
void answerLanes(devlib::LockstepWarp* warp, uint32_t what, uint32_t lanes, uint32_t asking);

// Lanes reach a point together, with their operands in the warp. Returns 1 if all lanes that they
// name are here; they then have their results. Returns 0 if they wait.
uint32_t meetLanes(devlib::LockstepWarp* warp, uint32_t what, uint32_t lanes);

// Saves values that all `lanes` share across a point: `count` of `values`, at the indices `which`.
// kept: one element for each lane and value.
void keepShared(uint64_t* kept, const uint64_t* values, const uint16_t* which, uint32_t count,
                uint32_t lanes);
// Fills `values` with the values of the first lane; returns the lanes with equal values.
uint32_t takeShared(const uint64_t* kept, uint64_t* values, const uint16_t* which, uint32_t count,
                    uint32_t lanes);

} // namespace sunstone::compiler
