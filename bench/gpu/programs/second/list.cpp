// SPDX-License-Identifier: Apache-2.0
// The second set: programs of kinds that the first set lacks. Their first run, before anything was
// tuned on them, shows how Sunstone runs programs that it does not know; third/list.cpp has newer
// ones.
#include "programs.h"

namespace bench {

std::vector<JobKind> secondJobs() {
    return {gaussiansJob(),   neighboursJob(),  keyQueriesJob(),
            lineOfSightJob(), lidarJob(),       distanceFieldJob(),
            materials40Job(), cloudJob(),       manyLightsJob(),
            robotsJob(),      lightTracerJob(), lightmapJob(),
            wavefrontJob(),   manyMeshesJob(),  mixedShapesJob(),
            clothJob(),       previewJob(),     rayPacketsInCallablesJob()};
}

} // namespace bench
