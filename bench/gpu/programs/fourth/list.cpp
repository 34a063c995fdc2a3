// SPDX-License-Identifier: Apache-2.0
// The fourth set: programs of kinds that the first three sets lack. They did not serve to tune
// Sunstone before their first run.
#include "programs.h"

namespace bench {

std::vector<JobKind> fourthJobs() {
    return {interiorJob(),    cityJob(),          nestedGlassJob(),   voxelsJob(),
            heightFieldJob(), csgJob(),           rigidBodiesJob(),   moleculesJob(),
            nodeGraphsJob(),  bezierPatchesJob(), motionPlannerJob(), gradientsJob()};
}

} // namespace bench
