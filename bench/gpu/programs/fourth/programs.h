// SPDX-License-Identifier: Apache-2.0
// The programs of the fourth set, in the order of the report. Each has a file of its own, and its
// device code and data in device/. ../third/renderer.h has what they share with the third set.
#pragma once

#include "../third/renderer.h"
#include "meshes.h"

namespace bench {

template <class T>
JobKind fourthJob(const char* name, const char* summary, double meanTolerance,
                  double pixelTolerance) {
    return applicationJob<T>("fourth", name, summary, meanTolerance, pixelTolerance);
}

JobKind interiorJob();
JobKind cityJob();
JobKind nestedGlassJob();
JobKind voxelsJob();
JobKind heightFieldJob();
JobKind csgJob();
JobKind rigidBodiesJob();
JobKind moleculesJob();
JobKind nodeGraphsJob();
JobKind bezierPatchesJob();
JobKind motionPlannerJob();
JobKind gradientsJob();

} // namespace bench
