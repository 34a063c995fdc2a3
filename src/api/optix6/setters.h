// SPDX-License-Identifier: Apache-2.0
// Setters that several classes of graph objects share.
#pragma once

#include "api/optix6/call.h"

#include <cmath>

namespace sunstone::optix6 {

constexpr unsigned kMostMotionSteps = 0xFFFF;

inline void setMotionRange(Motion& motion, float begin, float end) {
    if (!(begin <= end) || !std::isfinite(begin) || !std::isfinite(end))
        refuse(RT_ERROR_INVALID_VALUE, "the motion range from ", begin, " to ", end,
               " is not a range of times");
    motion.begin = begin;
    motion.end = end;
}

inline void setMotionBorders(Motion& motion, RTmotionbordermode begin, RTmotionbordermode end) {
    for (const RTmotionbordermode mode : {begin, end})
        if (mode != RT_MOTIONBORDERMODE_CLAMP && mode != RT_MOTIONBORDERMODE_VANISH)
            refuse(RT_ERROR_INVALID_VALUE, "border mode ", unsigned(mode), " is unknown");
    motion.beginMode = begin;
    motion.endMode = end;
}

inline void setProgram(Object& object, Ref<Program>& slot, RTprogram handle,
                       compiler::ProgramKind kind) {
    const std::shared_ptr<Context> context = object.context();
    const auto program = requireOf<Program>(*context, handle, "program", RT_ERROR_TYPE_MISMATCH);
    checkKind(*program, kind, "program");
    slot = program;
    object.noteSceneChange();
}

// Reads a row-major matrix of 3 or 4 rows from the application's.
inline void readMatrix(const float* from, bool transposed, unsigned rows, float* to) {
    for (unsigned row = 0; row < rows; ++row)
        for (unsigned column = 0; column < 4; ++column)
            to[4 * row + column] = transposed ? from[column * rows + row] : from[4 * row + column];
}
inline void writeMatrix(const float* from, bool transposed, unsigned rows, float* to) {
    for (unsigned row = 0; row < rows; ++row)
        for (unsigned column = 0; column < 4; ++column)
            (transposed ? to[column * rows + row] : to[4 * row + column]) = from[4 * row + column];
}

} // namespace sunstone::optix6
