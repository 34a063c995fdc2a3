// SPDX-License-Identifier: Apache-2.0
// The fifth set: programs of kinds that the other sets lack. Nothing is tuned on them.
#include "programs.h"

namespace bench {

std::vector<JobKind> fifthJobs() {
    return {assembliesJob(), latticeworkJob(), metaballsJob(),
            landscapeJob(),  showroomJob(),    carouselsJob()};
}

} // namespace bench
