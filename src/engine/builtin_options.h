// SPDX-License-Identifier: Apache-2.0
// The options of a built-in intersection, and the number that represents them in program groups.
#pragma once

#include "devlib/builtin.h"

namespace sunstone::engine {

struct BuiltinOptions {
    uint32_t primitive = 0; // OptixPrimitiveType
    bool endcaps = false;
    bool motion = false; // of vertices
    bool fastTrace = false, fastBuild = false;
};

// ProgramGroup::builtinPrimitive.
inline uint32_t packBuiltin(const BuiltinOptions& options) {
    uint32_t traits = 0;
    traits |= options.endcaps ? devlib::kBuiltinEndcaps : 0;
    traits |= options.motion ? devlib::kBuiltinMotion : 0;
    traits |= options.fastTrace ? devlib::kBuiltinFastTrace : 0;
    traits |= options.fastBuild ? devlib::kBuiltinFastBuild : 0;
    return devlib::packBuiltin(options.primitive, traits);
}

} // namespace sunstone::engine
