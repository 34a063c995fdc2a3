// SPDX-License-Identifier: Apache-2.0
// The CPU's back end: cpu/launch.cpp and cpu/compile.cpp; accel.cpp, micromap.cpp and denoiser.cpp
// implement the other functions.
#pragma once

#include "engine/accel.h"
#include "engine/denoiser.h"
#include "engine/launch.h"
#include "engine/micromap.h"
#include "engine/pipeline.h"

namespace sunstone::engine::cpu {

void compile(Pipeline& pipeline, const PipelineParts& parts);
void launch(const ContextPtr& context, const LaunchRequest& request);
uint64_t buildAccel(const ContextPtr& context, AccelBuild request);
uint64_t compactAccel(const ContextPtr& context, void* stream, uint64_t handle, void* destination,
                      size_t destinationSize);
bvh::RelocationInfo relocationInfo(const ContextPtr& context, uint64_t handle);
uint64_t relocateAccel(const ContextPtr& context, void* stream, const bvh::RelocationInfo& info,
                       void* block, const uint64_t* children, size_t count,
                       std::vector<const void*> arrays);
void buildMicromapArray(const ContextPtr& context, MicromapArrayBuild request);
bvh::RelocationInfo micromapRelocationInfo(const ContextPtr& context, const void* array);
void relocateMicromapArray(const ContextPtr& context, void* stream, const bvh::RelocationInfo& info,
                           void* array);
void setupDenoiser(const ContextPtr& context, const DenoiserSetup& setup);
void denoise(const ContextPtr& context, DenoiseRequest request);
void imageStatistics(const ContextPtr& context, const StatisticsRequest& request);

} // namespace sunstone::engine::cpu
