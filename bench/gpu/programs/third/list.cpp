// SPDX-License-Identifier: Apache-2.0
// The third set: programs of kinds that the first two sets lack.
#include "programs.h"

namespace bench {

std::vector<JobKind> thirdJobs() {
    return {bidirectionalJob(), subsurfaceJob(), dispersionJob(), resamplingJob(),
            probesJob(),        radarJob(),      xrayJob(),       radiosityJob(),
            furJob(),           particlesJob(),  forestJob(),     sectionViewJob(),
            trainingViewsJob(), tetVolumeJob()};
}

} // namespace bench
