// SPDX-License-Identifier: Apache-2.0
// The releases as types: the structs, numbers and slots of each release's clients.
#pragma once

#include "layouts.h"

#include <string>
#include <vector>

namespace tests::abi {

struct Release70 {
    static constexpr int kAbi = 22;
    static constexpr size_t kTableSize = 288;
    static constexpr int kOptLevel3 = 3;
    static constexpr int kDebugNone = 0;
    using ContextOptions = DeviceContextOptions70;
    using ModuleOptions = ModuleCompileOptions70;
    using CompileOptions = PipelineCompileOptions70;
    using LinkOptions = PipelineLinkOptions70;
    using GroupOptions = ProgramGroupOptions70;
    using DenoiserOptions = DenoiserOptions70;
    using DenoiserParams = DenoiserParams70;
    using DenoiserSizes = DenoiserSizes70;
};
struct Release71 : Release70 {
    static constexpr int kAbi = 36;
    static constexpr size_t kTableSize = 296;
    static constexpr int kOptLevel3 = 0x2343;
    static constexpr int kDebugNone = 0x2350;
    using CompileOptions = PipelineCompileOptions71;
    using LinkOptions = PipelineLinkOptions71;
    using DenoiserOptions = DenoiserOptions71;
};
struct Release72 : Release71 {
    static constexpr int kAbi = 41;
    static constexpr size_t kTableSize = 304;
    using ContextOptions = DeviceContextOptions72;
    using ModuleOptions = ModuleCompileOptions72;
    using DenoiserParams = DenoiserParams72;
};
struct Release73 : Release72 {
    static constexpr int kAbi = 47;
    using CompileOptions = PipelineCompileOptions73;
    using DenoiserOptions = DenoiserOptions73;
    using GuideLayer = GuideLayer73;
};
struct Release74 : Release73 {
    static constexpr int kAbi = 55;
    static constexpr size_t kTableSize = 344;
    using ModuleOptions = ModuleCompileOptions74;
    using CompileOptions = PipelineCompileOptions71;
    using GroupOptions = ProgramGroupOptions74;
};
struct Release75 : Release74 {
    static constexpr int kAbi = 60;
    using DenoiserParams = DenoiserParams75;
    using DenoiserSizes = DenoiserSizes75;
    using GuideLayer = GuideLayer75;
};
struct Release76 : Release75 {
    static constexpr int kAbi = 68;
    static constexpr size_t kTableSize = 376;
    using CompileOptions = PipelineCompileOptions76;
};

// Names of the slots of an ABI's table, in order, without "optix".
std::vector<std::string> slotsOf(int abi);

} // namespace tests::abi
