// SPDX-License-Identifier: Apache-2.0
// See warp_functions.h.
#include "compiler/lockstep/warp_functions.h"

#include "compiler/runtime/matrix.h"

#include <algorithm>
#include <bit>

namespace sunstone::compiler {

using devlib::kWarpLanes;

uint32_t answerVote(uint32_t mode, const Gathered& all) {
    uint32_t ballot = 0;
    for (unsigned lane = 0; lane < kWarpLanes; ++lane)
        if (all.present >> lane & 1 && all.values[lane])
            ballot |= 1u << lane;
    switch (mode) {
    case 0:
        return ballot == all.present;
    case 1:
        return ballot != 0;
    case 2:
        return ballot == 0 || ballot == all.present;
    default:
        return ballot;
    }
}

// Source: PTX ISA manual, "shfl.sync".
ShuffleSource shuffleSource(uint32_t mode, uint32_t lane, uint32_t distance, uint32_t control) {
    const int own = int(lane), b = int(distance & 31);
    const int clamp = int(control & 31), segment = int(control >> 8 & 31);
    const int last = (own & segment) | (clamp & ~segment);
    const int source = mode == 0   ? own - b
                       : mode == 1 ? own + b
                       : mode == 2 ? own ^ b
                                   : (own & segment) | (b & ~segment);
    const bool isValid = mode == 0 ? source >= last : source <= last;
    return {isValid ? uint32_t(source) : lane, isValid}; // 0 <= last < 32
}

uint64_t answerShuffle(uint32_t mode, uint32_t lane, uint32_t distance, uint32_t control,
                       const Gathered& all) {
    const ShuffleSource source = shuffleSource(mode, lane, distance, control);
    const bool isThere = all.present >> source.lane & 1;
    return uint64_t(source.isValid) << 32 | uint32_t(all.values[isThere ? source.lane : lane]);
}

uint64_t answerMatch(uint32_t wantAll, uint64_t value, const Gathered& all) {
    uint32_t same = 0;
    for (unsigned lane = 0; lane < kWarpLanes; ++lane)
        if (all.present >> lane & 1 && all.values[lane] == value)
            same |= 1u << lane;
    if (!wantAll)
        return uint64_t(1) << 32 | same;
    return same == all.present ? uint64_t(1) << 32 | same : 0;
}

uint32_t answerReduce(uint32_t operation, const Gathered& all) {
    uint32_t result = 0;
    bool isFirst = true;
    for (unsigned lane = 0; lane < kWarpLanes; ++lane) {
        if (!(all.present >> lane & 1))
            continue;
        const uint32_t other = uint32_t(all.values[lane]);
        if (isFirst) {
            result = other;
            isFirst = false;
            continue;
        }
        switch (operation) {
        case 0:
            result += other;
            break;
        case 1:
            result &= other;
            break;
        case 2:
            result |= other;
            break;
        case 3:
            result ^= other;
            break;
        case 4:
            result = uint32_t(std::min(int32_t(result), int32_t(other)));
            break;
        case 5:
            result = std::min(result, other);
            break;
        case 6:
            result = uint32_t(std::max(int32_t(result), int32_t(other)));
            break;
        default:
            result = std::max(result, other);
        }
    }
    return result;
}

void answerLanes(devlib::LockstepWarp* warp, uint32_t what, uint32_t lanes, uint32_t asking) {
    const uint32_t kind = what >> devlib::kPointBits & 0xff, mode = what >> devlib::kModeShift;
    Gathered all{};
    all.present = lanes;
    for (unsigned lane = 0; lane < kWarpLanes; ++lane)
        if (lanes >> lane & 1)
            all.values[lane] = warp->value[lane];
    uint64_t common = 0;
    if (kind == devlib::kMeetMatrix)
        computeMatrix(all.values, lanes);
    else if (kind == devlib::kMeetVote)
        common = answerVote(mode, all);
    else if (kind == devlib::kMeetReduce)
        common = answerReduce(mode, all);
    for (unsigned lane = 0; lane < kWarpLanes; ++lane) {
        if (!(asking >> lane & 1))
            continue;
        if (kind == devlib::kMeetShuffle)
            warp->result[lane] =
                answerShuffle(mode, lane, warp->operand[1][lane], warp->operand[2][lane], all);
        else if (kind == devlib::kMeetMatch)
            warp->result[lane] = answerMatch(mode, warp->value[lane], all);
        else
            warp->result[lane] = common;
    }
}

namespace {

// Whether all lanes name the same partners, themselves included, and no partner is elsewhere.
bool isComplete(devlib::LockstepWarp* warp, uint32_t lanes) {
    const uint32_t partners = warp->operand[0][std::countr_zero(lanes)];
    for (unsigned lane = 0; lane < kWarpLanes; ++lane)
        if (lanes >> lane & 1 && warp->operand[0][lane] != partners)
            return false;
    warp->namedEnded |= partners & warp->all & ~warp->live;
    return (partners & warp->live & ~lanes) == 0 && (lanes & ~partners) == 0;
}

} // namespace

uint32_t meetLanes(devlib::LockstepWarp* warp, uint32_t what, uint32_t lanes) {
    const uint32_t kind = what >> devlib::kPointBits & 0xff;
    const bool isExchange =
        kind != devlib::kMeetBarrier && kind != devlib::kMeetPlain && kind != devlib::kMeetPause;
    if (isExchange && isComplete(warp, lanes)) {
        answerLanes(warp, what, lanes, lanes);
        return 1;
    }
    for (unsigned lane = 0; lane < kWarpLanes; ++lane)
        if (lanes >> lane & 1)
            warp->point[lane] = what;
    ++warp->stops;
    warp->stopPoint = what;
    warp->stopLanes = lanes;
    return 0;
}

void keepShared(uint64_t* kept, const uint64_t* values, const uint16_t* which, uint32_t count,
                uint32_t lanes) {
    for (uint32_t i = 0; i < count; ++i)
        for (unsigned lane = 0; lane < kWarpLanes; ++lane)
            if (lanes >> lane & 1)
                kept[i * kWarpLanes + lane] = values[which[i]];
}

uint32_t takeShared(const uint64_t* kept, uint64_t* values, const uint16_t* which, uint32_t count,
                    uint32_t lanes) {
    const auto first = unsigned(std::countr_zero(lanes));
    uint32_t alike = lanes;
    for (uint32_t i = 0; i < count; ++i) {
        const uint64_t value = values[which[i]] = kept[i * kWarpLanes + first];
        for (unsigned lane = first; lane < kWarpLanes; ++lane)
            if (lanes >> lane & 1 && kept[i * kWarpLanes + lane] != value)
                alike &= ~(1u << lane);
    }
    return alike;
}

} // namespace sunstone::compiler
