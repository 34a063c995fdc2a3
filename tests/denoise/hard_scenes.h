// SPDX-License-Identifier: Apache-2.0
// Scenes that denoisers can make worse: lamps with jittered edges, dark textures, hard shadows
// without guides, thin objects, glowing patterns, light found by chance.
#pragma once

#include "small_tracer.h"

namespace hard {

constexpr unsigned kSceneCount = 16;
// The filter's constants were chosen on the first scenes; the last scenes were held out.
constexpr unsigned kTunedCount = 12;

Scene makeScene(unsigned number);

} // namespace hard
