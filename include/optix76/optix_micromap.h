// SPDX-License-Identifier: Apache-2.0
// Positions of micro-triangles, for programs that make opacity micromaps. Host and device code,
// C++. Source: OptiX 7.6 programming guide, opacity micromaps.
#ifndef SUNSTONE_OPTIX76_OPTIX_MICROMAP_H
#define SUNSTONE_OPTIX76_OPTIX_MICROMAP_H

#include "internal/optix_7_micromap_impl.h"

/** The corners of a micro-triangle, as barycentrics (u, v) of the triangle that has the micromap: u
    belongs to vertex 1, v to vertex 2. The first corner is the one with the right angle of the
    (u, v) plane; the second differs from it in u, the third in v.
    @param[in]  microTriangleIndex  number along the curve, below 4^subdivisionLevel
    @param[in]  subdivisionLevel    0 to OPTIX_OPACITY_MICROMAP_MAX_SUBDIVISION_LEVEL */
OPTIX_MICROMAP_INLINE_FUNC void
optixMicromapIndexToBaseBarycentrics(unsigned int microTriangleIndex, unsigned int subdivisionLevel,
                                     float2& baseBarycentrics0, float2& baseBarycentrics1,
                                     float2& baseBarycentrics2) {
    optix_impl::cornersOfMicroTriangle(microTriangleIndex, subdivisionLevel, baseBarycentrics0,
                                       baseBarycentrics1, baseBarycentrics2);
}

#endif
