// SPDX-License-Identifier: Apache-2.0
// Statistics that fit images of any brightness to the range a filter expects. Sums are double and
// taken row by row in order, so that results do not depend on the number of threads.
#pragma once

#include "denoise/image.h"

namespace sunstone::denoise {

// 0.18 / exp(mean of ln L) over the pixels whose luminance L is above 1e-8 (Reinhard et al. 2002);
// 1 if there are none. Pixels that are not finite do not count.
float intensityScale(const Image& image);

// For each of the first three channels the mean of ln c over the values c above 1e-8; 0 if there
// are none. Values that are not finite do not count.
void averageLogColor(const Image& image, float (&result)[3]);

} // namespace sunstone::denoise
