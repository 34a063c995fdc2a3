// SPDX-License-Identifier: Apache-2.0
// Runs the threads of a block a warp at a time. See block_lockstep.cpp.
#pragma once

#include "api/cuda/driver/blocks/block.h"
#include "api/cuda/driver/blocks/block_barrier.h"

#include <vector>

namespace sunstone::api::cuda {

// Warps are made for a shape of blocks and run the blocks of any launch with that shape.
struct BlockRunner::Lockstep {
    explicit Lockstep(const Launch& launch);
    bool fits(const Launch& launch) const;
    size_t bytes() const;
    // Starts a block, whose threads then run in steps; `prototype` has their shared properties. The
    // launch must fit, and outlive the steps.
    void start(Launch& launch, const devlib::KernelThread& prototype);
    enum class Progress : uint8_t {
        kGoesOn, // not the result of a step
        kDone,
        kPaused, // other blocks may run first
        kWaits,  // for other blocks or the host
    };
    Progress step();

    // ---- called by compiled code, through BlockFunctions ----
    void arrive(uint32_t id, uint32_t threads);
    void fault(uint32_t kind);

private:
    static constexpr uint32_t kLanes = devlib::kWarpLanes;
    struct Warp {
        uint32_t ready = 0;                      // lanes that can continue, each at its `point`
        uint32_t barrier = 0;                    // lanes that wait at a barrier
        uint32_t exchange = 0;                   // lanes that wait for other lanes of the warp
        uint32_t ids[BlockBarrier::kCount] = {}; // lanes in `barrier`, by the barrier's id
        bool isAtBarrier = false;                // all lanes are there; used in rounds
    };

    void describeThreads(const devlib::KernelThread& prototype);
    Progress advance();
    Progress runTogether();
    bool runWhole(size_t warp);
    Progress runApart();
    bool join();
    void part(size_t warp);
    static void notePause(devlib::LockstepWarp& warp);
    uint32_t runLanes(size_t warp, uint32_t point, uint32_t lanes);
    bool runReady(size_t warp);
    bool onlySpin(size_t warp, uint32_t lanes) const;
    bool release();
    void takeStops(size_t warp, uint32_t lanes);
    void comeToBarrier(size_t warp, uint32_t lanes, uint32_t what);
    bool tryBarrier(uint32_t id); // whether it is complete
    bool tryExchanges(size_t warp);

    // First, so that KernelThread::block points to the table.
    [[maybe_unused]] const devlib::BlockFunctions* functions_;
    const std::array<uint32_t, 3> shape_;
    const uint32_t frameBytes_;
    const size_t threadsPerWarp_; // of KernelThread structs
    Launch* launch_ = nullptr;
    std::vector<devlib::LockstepWarp> warps_;
    std::vector<devlib::KernelThread> threads_;
    std::vector<uint8_t> frames_;
    std::vector<Warp> states_;
    std::array<BlockBarrier, BlockBarrier::kCount> barriers_;
    devlib::KernelThread prototype_{};
    FaultFrame frame_;
    uint32_t barrier_ = 0; // that warps have reached together
    size_t runningWarp_ = 0;
    uint32_t runningLanes_ = 0;
    uint32_t live_ = 0;
    bool isApart_ = false;
    bool mayJoin_ = false; // a barrier has completed since the last join()
};

} // namespace sunstone::api::cuda
