// SPDX-License-Identifier: Apache-2.0
// Runs the launch indices of a tile one after the other. in_flight.h runs them side by side.
#pragma once

#include "base/faults.h"
#include "devlib/abi.h"
#include "devlib/records.h"
#include "engine/exceptions.h"
#include "engine/wording.h"

#include <algorithm>
#include <cstdint>
#include <string>

namespace sunstone::engine::cpu {

// Shapes of a tile: square tiles keep neighbouring rays together; one-dimensional launches take the
// same number of indices in a row.
constexpr uint32_t kTileSide = 16;
constexpr uint32_t kTileRow = kTileSide * kTileSide;

struct Tiling {
    uint32_t width, height, depth;
    uint32_t tileWidth, tileHeight;
    uint64_t columns, rows;

    Tiling(uint32_t w, uint32_t h, uint32_t d) : width(w), height(h), depth(d) {
        tileWidth = h == 1 ? kTileRow : kTileSide;
        tileHeight = h == 1 ? 1 : kTileSide;
        columns = (uint64_t(w) + tileWidth - 1) / tileWidth;
        rows = (uint64_t(h) + tileHeight - 1) / tileHeight;
    }
    uint64_t count() const { return columns * rows * depth; }
};

struct Tile {
    uint32_t x, y, z, width, height;
    uint32_t count() const { return width * height; }

    Tile(const Tiling& tiling, uint64_t number) {
        x = uint32_t(number % tiling.columns) * tiling.tileWidth;
        number /= tiling.columns;
        y = uint32_t(number % tiling.rows) * tiling.tileHeight;
        z = uint32_t(number / tiling.rows);
        width = std::min(tiling.tileWidth, tiling.width - x);
        height = std::min(tiling.tileHeight, tiling.height - y);
    }
    void place(uint32_t i, uint32_t index[3]) const {
        index[0] = x + i % width;
        index[1] = y + i / width;
        index[2] = z;
    }
};

// The programs of a launch, and the exceptions that ended launch indices early.
class Runner {
public:
    // `stackBudget`: bytes of stack that a launch index may use.
    Runner(const devlib::LaunchState& launch, devlib::ProgramFn entry, devlib::ProgramFn exception,
           uint64_t stackBudget, const Wording& wording)
        : launch_(launch), entry_(entry), exception_(exception), stackBudget_(stackBudget),
          fatal_(wording), raised_(wording), unseen_(wording) {}

    void run(const Tile& tile);

    // Throws the fatal exception of a device program, if any; with `validation` also an exception
    // of the run-time. Otherwise returns the text of an exception that no exception program
    // handled, or an empty one.
    std::string finish(bool validation) const;

    // ---- for in_flight.cpp ----
    const devlib::LaunchState& launch() const { return launch_; }
    // The state of a new launch index; its programs' frames lie between `stack` and `stackLimit`.
    void prepare(devlib::RayState& state, devlib::ThreadState& thread, uint64_t stack,
                 uint64_t stackLimit) const;
    void runEntry(devlib::RayState& state) const {
        state.sbtData =
            reinterpret_cast<const void*>(launch_.sbt.entryRecord + sizeof(devlib::SbtHeader));
        state.depth = 0;
        if (launch_.boxes)
            devlib::prepareBounds(state);
        entry_(&state);
    }
    // Handles an exception: runs the exception program, or notes the exception if there is none or
    // the launch ends. Called outside device code; `faults` receives faults of the exception
    // program.
    void endIndex(devlib::RayState& state, const FaultFrame& place, FaultFrame& faults);
    void noteFault(const FaultFrame& frame, const devlib::ThreadState& thread) {
        fatal_.add(frame, thread, launch_);
    }

private:
    const devlib::LaunchState& launch_;
    devlib::ProgramFn entry_;
    devlib::ProgramFn exception_;
    uint64_t stackBudget_;
    ExceptionRecord fatal_;  // ends the launch
    ExceptionRecord raised_; // by the run-time
    ExceptionRecord unseen_; // without an exception program
};

} // namespace sunstone::engine::cpu
