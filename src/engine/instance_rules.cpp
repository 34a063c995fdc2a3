// SPDX-License-Identifier: Apache-2.0
#include "engine/instance_rules.h"

#include "base/error.h"
#include "bvh/input/build_input.h"
#include "devlib/flags.h"
#include "engine/context.h"

namespace sunstone::engine {
namespace {

std::string brokenBy(const bvh::InstanceDesc& instance, const InstanceRules& rules) {
    const auto isAbove = [](const char* field, uint32_t value, uint32_t limit) {
        return message(field, " = ", value, " is above ", limit);
    };
    if (instance.instanceId > rules.maxId)
        return isAbove("instanceId", instance.instanceId, rules.maxId);
    if (instance.sbtOffset > rules.maxSbtOffset)
        return isAbove("sbtOffset", instance.sbtOffset, rules.maxSbtOffset);
    if (instance.visibilityMask >> rules.visibilityMaskBits)
        return message("visibilityMask = ", instance.visibilityMask, " has more than ",
                       rules.visibilityMaskBits, " bits");
    if (instance.flags & ~rules.knownFlags)
        return message("flags = ", instance.flags, " has unknown bits");
    constexpr uint32_t kBoth = devlib::kInstanceDisableAnyHit | devlib::kInstanceEnforceAnyHit;
    if ((instance.flags & kBoth) == kBoth)
        return message("flags = ", instance.flags, " has both DISABLE_ANYHIT and ENFORCE_ANYHIT");
    if ((instance.traversableHandle & devlib::kTagMask) == devlib::kTagIas &&
        instance.sbtOffset != 0)
        return message("sbtOffset = ", instance.sbtOffset,
                       ", but must be 0 for an instance acceleration structure");
    return {};
}

} // namespace

void warnOfBrokenRule(const Context& context, const bvh::InstanceInput& input,
                      const InstanceRules& rules) {
    bvh::InstanceInput given = input; // with unchanged flags
    given.knownFlags = ~0u;
    given.identityFlag = 0;
    for (uint32_t i = 0; i < input.numInstances; ++i) {
        const uint64_t pointer = input.instances ? 0 : input.instancePointers[i];
        const std::string text = pointer % InstanceRules::kAlignment != 0
                                     ? message("address ", reinterpret_cast<const void*>(pointer),
                                               " is not a multiple of ", InstanceRules::kAlignment)
                                     : brokenBy(bvh::instanceAt(given, i), rules);
        if (!text.empty())
            return context.log(LogLevel::kWarning, "ACCEL",
                               message("validation: instances[", i, "]: ", text));
    }
}

void warnOfUnknownChild(const Context& context, const bvh::InstanceInput& input,
                        const void* structure) {
    if (static_cast<const bvh::BlockHeader*>(structure)->numActive == input.numInstances)
        return;
    for (uint32_t i = 0; i < input.numInstances; ++i) {
        const bvh::InstanceDesc instance = bvh::instanceAt(input, i);
        const uint64_t handle = instance.traversableHandle;
        if (handle != 0 && (instance.visibilityMask & 0xFF) != 0 && !bvh::leadsToBlock(handle))
            return context.log(
                LogLevel::kWarning, "ACCEL",
                message("instances[", i,
                        "]: traversableHandle = ", reinterpret_cast<const void*>(handle),
                        ", or that of a transform it leads to, is that of no acceleration "
                        "structure whose memory is allocated; rays never hit the instance"));
    }
}

} // namespace sunstone::engine
