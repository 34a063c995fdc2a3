// SPDX-License-Identifier: Apache-2.0
// Scenes on which denoisers do harm: lamps with jittered edges, dark textures, hard shadows without
// guides, thin objects, glowing patterns, light found by chance.
#pragma once

#include "small_tracer.h"

namespace hard {

constexpr unsigned kSceneCount = 16;
// The filter's constants were chosen on the first scenes; the last ones were kept aside.
constexpr unsigned kTunedCount = 12;

Scene makeScene(unsigned number);

} // namespace hard
