// SPDX-License-Identifier: Apache-2.0
// Memory of warps for the states of their rays and the frames of programs that wait, in place of
// the threads' local memory. Local memory interleaves the lanes of a warp word by word, so each
// word of a lane whose depth differs from its neighbours' takes a sector of its own; here a lane's
// words lie together. A warp claims one of the launch's slots and frees it when its last lane ends,
// also by an exception. A warp that finds none free waits for others to end.
#pragma once

#include "base/inline.h"
#include "devlib/gpu/launch_block.h"

namespace sunstone::devlib::gpu {

// 1 if warps of the kernel have claimed memory (compiler/gpu/launch_kernel.cpp).
extern "C" __attribute__((const)) uint32_t sunstone_gpu_hasLaneMemory();

// The slot of a warp of the block.
struct LaneSlot {
    uint32_t* word; // of the launch's set of free slots
    uint32_t bit;
    uint32_t lanes; // that have not ended
};

[[clang::loader_uninitialized]] static
    __attribute__((address_space(3))) LaneSlot laneSlots[kGpuStepBlockThreads / kGpuTile];

SUNSTONE_INLINE LaneSlot& laneSlot() {
    return *(LaneSlot*)&laneSlots[uint32_t(__nvvm_read_ptx_sreg_tid_x()) / kGpuTile];
}

// Ends the use of the slot by some lanes of the warp. In a pipeline of parts, the kernel's part has
// this function; the compiler inlines it elsewhere.
extern "C" __attribute__((noinline, section(".sunstone.part"))) void
sunstone_gpu_leaveLaneMemory(uint32_t lanes) {
    LaneSlot& slot = laneSlot();
    if (uint32_t(__nvvm_atom_add_gen_i(reinterpret_cast<int*>(&slot.lanes), -int(lanes))) != lanes)
        return;
    __nvvm_membar_gl(); // the writes of these lanes precede those of the next warp
    __nvvm_atom_or_gen_i(reinterpret_cast<int*>(slot.word), int(slot.bit));
}

// Claims a free slot and returns its number. One lane calls this.
SUNSTONE_INLINE uint32_t claimSlot(const LaneMemory& memory, LaneSlot& slot) {
    const uint32_t warp =
        (uint32_t(__nvvm_read_ptx_sreg_ctaid_x()) * uint32_t(__nvvm_read_ptx_sreg_ntid_x()) +
         uint32_t(__nvvm_read_ptx_sreg_tid_x())) /
        kGpuTile;
    for (uint32_t at = warp % memory.words;; at = at + 1 == memory.words ? 0 : at + 1) {
        auto* const word = reinterpret_cast<uint32_t*>(memory.freeSlots) + at;
        for (uint32_t free = *static_cast<volatile uint32_t*>(word); free != 0;) {
            const uint32_t bit = free & (0u - free);
            free = uint32_t(__nvvm_atom_and_gen_i(reinterpret_cast<int*>(word), int(~bit)));
            if (free & bit) {
                slot = {word, bit, kGpuTile};
                return at * 32 + uint32_t(__builtin_ctz(bit));
            }
        }
        asm volatile("nanosleep.u32 100;");
    }
}

// The memory of the calling warp. All lanes of the warp call this at the start of the kernel.
extern "C" uint8_t* sunstone_gpu_claimLaneMemory(LaunchBlock* block) {
    const LaneMemory& memory = block->work.laneMemory;
    uint32_t number = 0;
    if (__nvvm_read_ptx_sreg_laneid() == 0)
        number = claimSlot(memory, laneSlot());
    number = uint32_t(__nvvm_shfl_sync_idx_i32(~0u, int(number), 0, 31));
    __nvvm_membar_gl();
    return reinterpret_cast<uint8_t*>(memory.slots) + uint64_t(number) * memory.slotBytes;
}

// All lanes of the warp that have not ended call this at the end of the kernel.
extern "C" void sunstone_gpu_freeLaneMemory() {
    const uint32_t lanes = __nvvm_vote_ballot_sync(~0u, true);
    if (uint32_t(__nvvm_read_ptx_sreg_laneid()) == uint32_t(__builtin_ctz(lanes)))
        sunstone_gpu_leaveLaneMemory(uint32_t(__builtin_popcount(lanes)));
}

} // namespace sunstone::devlib::gpu
