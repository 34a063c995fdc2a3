// SPDX-License-Identifier: Apache-2.0
// The programs of the second set, in the order of the report. Each has a file of its own, and its
// device code and data in device/.
#pragma once

#include "kit.h"

namespace bench {

JobKind gaussiansJob();
JobKind neighboursJob();
JobKind keyQueriesJob();
JobKind lineOfSightJob();
JobKind lidarJob();
JobKind distanceFieldJob();
JobKind materials40Job();
JobKind cloudJob();
JobKind manyLightsJob();
JobKind robotsJob();
JobKind lightTracerJob();
JobKind lightmapJob();
JobKind wavefrontJob();
JobKind manyMeshesJob();
JobKind mixedShapesJob();
JobKind clothJob();
JobKind previewJob();
JobKind rayPacketsInCallablesJob();

} // namespace bench
