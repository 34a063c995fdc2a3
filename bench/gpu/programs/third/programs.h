// SPDX-License-Identifier: Apache-2.0
// The programs of the third set, in the order of the report. Each has a file of its own, and its
// device code and data in device/.
#pragma once

#include "renderer.h"

namespace bench {

JobKind bidirectionalJob();
JobKind subsurfaceJob();
JobKind dispersionJob();
JobKind resamplingJob();
JobKind probesJob();
JobKind radarJob();
JobKind xrayJob();
JobKind radiosityJob();
JobKind furJob();
JobKind particlesJob();
JobKind forestJob();
JobKind sectionViewJob();
JobKind trainingViewsJob();
JobKind tetVolumeJob();

} // namespace bench
