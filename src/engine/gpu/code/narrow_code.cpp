// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/code/narrow_code.h"

#include "base/config.h"
#include "base/error.h"
#include "base/log.h"
#include "devlib/flags.h"
#include "engine/gpu/code/code.h"

#include <algorithm>

namespace sunstone::engine {

GpuCodeKind narrowed(GpuCodeKind declared, const GpuGraphs& there) {
    if (!there.any)
        return declared;
    GpuCodeKind kind = declared;
    if (!there.motion)
        kind.motion = devlib::kMotionNone;
    else if (!there.keys && kind.motion == devlib::kMotionAll)
        kind.motion = devlib::kMotionTransforms;
    if (!there.instances)
        kind.graph = devlib::kGraphGas;
    else if (kind.graph == devlib::kGraphAny && !there.deep)
        kind.graph = devlib::kGraphShallow;
    return kind;
}

bool isSceneComplete(const GpuGraphs& there, unsigned flags) {
    return there.any && (there.instances || !(flags & devlib::kAllowSingleLevelInstancing));
}

bool StartsNarrow::next(Time now) {
    if (launches_++ == 0)
        first_ = now;
    return launches_ >= kLaunches && now - first_ >= kTime;
}

GpuNarrowCodes::GpuNarrowCodes(Prepare prepare)
    : prepare_(std::move(prepare)), atOnce_(currentConfig(Setting::kGpuCode) == "narrow") {}

GpuNarrowCodes::Code& GpuNarrowCodes::find(GpuCodeKind kind) {
    const auto found = std::ranges::find(codes_, kind, &Code::kind);
    if (found != codes_.end())
        return *found;
    codes_.push_back({kind, prepare_(kind, false), nullptr, false, {}});
    return codes_.back();
}

void GpuNarrowCodes::begin(GpuCodeKind kind, std::shared_ptr<const GpuLaterCode> later) {
    if (std::ranges::find(codes_, kind, &Code::kind) == codes_.end())
        codes_.push_back({kind, std::move(later), nullptr, false, {}});
}

const GpuLaterCode* GpuNarrowCodes::pending(GpuCodeKind kind) {
    const auto found = std::ranges::find(codes_, kind, &Code::kind);
    return found != codes_.end() ? found->later.get() : nullptr;
}

void GpuNarrowCodes::prepare(Code& code, uint64_t indices) {
    const bool starts =
        WaitsForWhole::isLarge(indices) && code.starts.next(std::chrono::steady_clock::now());
    if (!atOnce_ && !starts)
        return;
    code.later = prepare_(code.kind, true);
    if (atOnce_)
        waitFor(*code.later);
}

std::shared_ptr<GpuCodeObject> GpuNarrowCodes::get(GpuCodeKind kind, uint64_t indices,
                                                   const std::function<bool()>& isIdle,
                                                   const Load& load) {
    Code& code = find(kind);
    if (code.loaded || code.isRefused)
        return code.loaded;
    if (!code.later)
        prepare(code, indices);
    else if (atOnce_)
        waitFor(*code.later);
    if (!code.later || !code.later->isReady || !isIdle())
        return nullptr;
    const auto later = std::move(code.later);
    // Module variables must not have copies.
    code.isRefused = later->code.machineCode.empty() || later->code.hasState;
    if (!code.isRefused)
        try {
            code.loaded = load(*later);
        } catch (const Error& error) {
            code.isRefused = true;
            log(LogLevel::kWarning, "engine",
                message("launches keep code for more traversables than there are: ", error.what()));
        }
    return code.loaded;
}

} // namespace sunstone::engine
