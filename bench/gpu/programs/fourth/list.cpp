// SPDX-License-Identifier: Apache-2.0
// The fourth set: programs of kinds that the other sets lack. Nothing is tuned on them.
#include "programs.h"

namespace bench {

std::vector<JobKind> fourthJobs() {
    return {interiorJob(),    cityJob(),          nestedGlassJob(),   voxelsJob(),
            heightFieldJob(), csgJob(),           rigidBodiesJob(),   moleculesJob(),
            nodeGraphsJob(),  bezierPatchesJob(), motionPlannerJob(), gradientsJob()};
}

} // namespace bench
