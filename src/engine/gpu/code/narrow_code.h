// SPDX-License-Identifier: Apache-2.0
// Narrow code of a pipeline: code for the traversables that the process has, in place of those that
// the pipeline declares. It has no motion where nothing moves, no motion keys where only transforms
// move, and no instances where there are none. Its frames take up to a third less time
// (docs/notes/programs-gpu.md). Another thread compiles it: from the pipeline's creation on if
// the process has a scene by then, else after the pipeline has run for a while. A later process
// finds it in the disk cache.
#pragma once

#include "devlib/gpu/launch_block.h"
#include "engine/gpu/code/code_queue.h"
#include "engine/gpu/handle_table.h"

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace sunstone::engine {

class GpuCodeObject;

// The traversables that code can traverse.
struct GpuCodeKind {
    devlib::GraphKind graph = devlib::kGraphAny;
    devlib::MotionKind motion = devlib::kMotionNone;
    friend bool operator==(const GpuCodeKind&, const GpuCodeKind&) = default;
};

// The kind that suffices for these traversables and for what the pipeline declares.
GpuCodeKind narrowed(GpuCodeKind declared, const GpuGraphs& there);

// Whether a new pipeline is likely to be launched with these traversables alone. `flags`, the
// pipeline's OptixTraversableGraphFlags, may announce instances.
bool isSceneComplete(const GpuGraphs& there, unsigned flags);

// When narrow code is worth its compilation. A process waits at its end for a step of a compilation
// that has begun, so programs of a few launches do not start one.
class StartsNarrow {
public:
    using Time = std::chrono::steady_clock::time_point;
    static constexpr unsigned kLaunches = 4; // large ones, see WaitsForWhole
    static constexpr std::chrono::milliseconds kTime{500};
    // Counts a large launch.
    bool next(Time now);

private:
    unsigned launches_ = 0;
    Time first_;
};

// The narrow codes of a pipeline. The caller serialises the calls.
class GpuNarrowCodes {
public:
    // Code of this kind from the disk cache; with `compiles`, else code that is compiled from now
    // on; or null.
    using Prepare = std::function<std::shared_ptr<const GpuLaterCode>(GpuCodeKind, bool compiles)>;
    using Load = std::function<std::shared_ptr<GpuCodeObject>(const GpuLaterCode&)>;
    explicit GpuNarrowCodes(Prepare prepare);

    bool areMade() const { return bool(prepare_); }
    // Code of this kind that is compiled since the pipeline's creation.
    void begin(GpuCodeKind kind, std::shared_ptr<const GpuLaterCode> later);
    // The code of this kind while it is compiled, or null.
    const GpuLaterCode* pending(GpuCodeKind kind);
    // The code for a launch of that many indices, or null if it is not ready. `isIdle`: whether
    // code may be loaded now.
    std::shared_ptr<GpuCodeObject> get(GpuCodeKind kind, uint64_t indices,
                                       const std::function<bool()>& isIdle, const Load& load);

private:
    struct Code {
        GpuCodeKind kind;
        std::shared_ptr<const GpuLaterCode> later;
        std::shared_ptr<GpuCodeObject> loaded;
        bool isRefused = false; // it cannot be compiled or loaded, or has variables
        StartsNarrow starts;
    };
    Code& find(GpuCodeKind kind);
    void prepare(Code& code, uint64_t indices);

    const Prepare prepare_;
    const bool atOnce_; // compile at the first launch, which waits
    std::vector<Code> codes_;
};

} // namespace sunstone::engine
