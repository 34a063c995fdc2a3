// SPDX-License-Identifier: Apache-2.0
// Builds structures of curves and spheres; build.cpp forwards here. The functions are those of
// build.h.
#pragma once

#include "bvh/build/build.h"

namespace sunstone::bvh {

MemoryUsage shapeMemoryUsage(const BuildInputs& inputs, const BuildOptions& options);
void buildShapes(const BuildInputs& inputs, const BuildOptions& options, void* temp,
                 size_t tempSize, void* output, size_t outputSize);
void checkShapeUpdate(const BuildInputs& inputs, const BuildOptions& options, const void* output,
                      size_t outputSize);
void updateShapes(const BuildInputs& inputs, const BuildOptions& options, void* temp,
                  size_t tempSize, void* output, size_t outputSize);

} // namespace sunstone::bvh
