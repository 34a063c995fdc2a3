// SPDX-License-Identifier: Apache-2.0
// The fifth set: programs of kinds that the first four sets lack.
#include "programs.h"

namespace bench {

std::vector<JobKind> fifthJobs() {
    return {assembliesJob(), latticeworkJob(), metaballsJob(),
            landscapeJob(),  showroomJob(),    carouselsJob()};
}

} // namespace bench
