// SPDX-License-Identifier: Apache-2.0
// The second set: programs of kinds that the first set lacks. Nothing is tuned on them, so their
// results show how Sunstone runs programs that it does not know.
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
