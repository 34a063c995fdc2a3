// SPDX-License-Identifier: Apache-2.0
// The programs of the fifth set, in the order of the report. Each has a file of its own, and its
// device code and data in device/. ../third/renderer.h has what they share with the earlier sets.
#pragma once

#include "../fourth/meshes.h"
#include "../third/renderer.h"

namespace bench {

template <class T>
JobKind fifthJob(const char* name, const char* summary, double meanTolerance,
                 double pixelTolerance) {
    return applicationJob<T>("fifth", name, summary, meanTolerance, pixelTolerance);
}

JobKind assembliesJob();
JobKind latticeworkJob();
JobKind metaballsJob();
JobKind landscapeJob();
JobKind showroomJob();
JobKind carouselsJob();

} // namespace bench
