// SPDX-License-Identifier: Apache-2.0
// The surfaces of the sample, for host and device.
#pragma once

enum ShapeKind { kBoredCube, kTwistedRing, kJulia };
