// SPDX-License-Identifier: Apache-2.0
// The binary interfaces this library serves. An application is compiled against one OptiX release,
// whose ABI number it passes to optixQueryFunctionTable; its table, struct sizes, limits and a few
// meanings follow from that number. Clients of several ABIs may live in one process.
//
// The implementation knows one form of everything: the structs of the newest ABI here (our public
// headers as OptiX 7.6). What an application passes is brought into that form at the table
// (client_structs.h, adapter.h); what a number means is asked of the object's ABI, here.
#pragma once

#include "optix.h"

#include <cstdint>

namespace sunstone::optix7 {

// Number of the ABI, named by release. Compare with < and >=: they only grow.
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

// Limits that applications ask for and builds enforce.
struct Limits {
    static constexpr unsigned kTraceDepth = 31;
    static constexpr unsigned kGraphDepth = 31;
    // What a structure can address whatever the build flags are (bvh/layout.h).
    static constexpr unsigned kPrimitivesPerGas = 80'000'000;
    static constexpr unsigned kVisibilityMaskBits = 8;
    static constexpr unsigned kSbtRecordsPerGas = 1u << 24;
    static constexpr uint64_t kLaunchIndices = uint64_t(1) << 30;

    // 7.0 had 24 bits for what later releases have 28 for.
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

// An instance flag that releases before 7.4 had: the instance's transform does not count.
constexpr unsigned kInstanceFlagDisableTransform = 1u << 6;

// Bits that have a meaning in an ABI; others in a client's word are an error.
unsigned knownBuildFlags(Abi abi);
unsigned knownGeometryFlags(Abi abi);
unsigned knownPrimitiveTypeFlags(Abi abi);
unsigned knownInstanceFlags(Abi abi);

// 7.0 counts levels from 0, without a default. Unknown numbers become unknown ones.
OptixCompileOptimizationLevel optLevelOf70(int level);
OptixCompileDebugLevel debugLevelOf70(int level);

} // namespace sunstone::optix7
