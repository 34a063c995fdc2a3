// SPDX-License-Identifier: Apache-2.0
// The binary interfaces that this library serves. An application is compiled against one OptiX
// release, whose ABI number it passes to optixQueryFunctionTable. Its table, struct sizes, limits
// and some meanings follow from that number. Clients of several ABIs may share a process.
//
// The implementation uses one form of everything: the structs of the newest ABI here (our public
// headers as OptiX 7.6). Arguments are converted to that form at the table (client_structs.h,
// adapter.h). The meaning of numbers is a property of the object's ABI, defined here.
#pragma once

#include "optix.h"

#include <cstdint>

namespace sunstone::optix7 {

// The number of the ABI, named by release. Compare with < and >=: numbers only grow.
enum Abi : int {
    kAbi70 = 22,
    kAbi71 = 36,
    kAbi72 = 41,
    kAbi73 = 47,
    kAbi74 = 55,
    kAbi75 = 60,
    kAbi76 = 68,
    kNewestAbi = kAbi76,
};

// "7.4" for kAbi74.
const char* releaseOf(Abi abi);

// Limits that applications query and builds enforce.
struct Limits {
    static constexpr unsigned kTraceDepth = 31;
    static constexpr unsigned kGraphDepth = 31;
    // The largest number a structure can address with any build flags (bvh/layout.h).
    static constexpr unsigned kPrimitivesPerGas = 80'000'000;
    static constexpr unsigned kVisibilityMaskBits = 8;
    static constexpr unsigned kSbtRecordsPerGas = 1u << 24;
    static constexpr uint64_t kLaunchIndices = uint64_t(1) << 30;

    // 7.0 has 24 bits where later releases have 28.
    static constexpr unsigned instancesPerIas(Abi abi) {
        return abi < kAbi71 ? 1u << 24 : 1u << 26;
    }
    static constexpr unsigned instanceId(Abi abi) { return abi < kAbi71 ? k24Bits : k28Bits; }
    static constexpr unsigned sbtOffset(Abi abi) { return abi < kAbi71 ? k24Bits : k28Bits; }
    static constexpr int payloadValues(Abi abi) { return abi < kAbi74 ? 8 : 32; }

private:
    static constexpr unsigned k24Bits = (1u << 24) - 1;
    static constexpr unsigned k28Bits = (1u << 28) - 1;
};

// An instance flag of releases before 7.4: the instance's transform is ignored.
constexpr unsigned kInstanceFlagDisableTransform = 1u << 6;

// The bits defined in an ABI; other bits in a client's word are an error.
unsigned knownBuildFlags(Abi abi);
unsigned knownGeometryFlags(Abi abi);
unsigned knownPrimitiveTypeFlags(Abi abi);
unsigned knownInstanceFlags(Abi abi);

// 7.0 counts levels from 0, without a default. Unknown numbers map to unknown ones.
OptixCompileOptimizationLevel optLevelOf70(int level);
OptixCompileDebugLevel debugLevelOf70(int level);

} // namespace sunstone::optix7
