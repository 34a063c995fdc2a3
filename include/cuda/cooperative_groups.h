// SPDX-License-Identifier: Apache-2.0
// Cooperative groups for clang's CUDA mode: the block, the grid, tiles of a warp, active threads.
// reduce.h, scan.h and memcpy_async.h in cooperative_groups/ have the collective functions. Source:
// CUDA C++ Programming Guide, "Cooperative Groups".
#ifndef SUNSTONE_COOPERATIVE_GROUPS_H
#define SUNSTONE_COOPERATIVE_GROUPS_H

#include "cuda_runtime.h"

#ifdef SUNSTONE_CUDA_COMPILATION
namespace cooperative_groups {

#define SUNSTONE_GROUP __inline__ __attribute__((device))
#define SUNSTONE_GROUP_STATIC static __inline__ __attribute__((device))

namespace details {

SUNSTONE_GROUP_STATIC unsigned int laneIndex() { return __lane_id(); }
// The bits of lanes below the calling one.
SUNSTONE_GROUP_STATIC unsigned int lanesBelow() { return (1u << laneIndex()) - 1; }
SUNSTONE_GROUP_STATIC unsigned int threadRankInBlock() {
    return threadIdx.x + blockDim.x * (threadIdx.y + blockDim.y * threadIdx.z);
}
SUNSTONE_GROUP_STATIC unsigned int threadsOfBlock() {
    return blockDim.x * blockDim.y * blockDim.z;
}

// Reads a value of any type, word by word, from a lane of the mask.
template <class T>
SUNSTONE_GROUP_STATIC T fromLane(unsigned int mask, SUNSTONE_LANE T value, unsigned int lane) {
    constexpr int kWords = (int)((sizeof(T) + 3) / 4);
    unsigned int words[kWords] = {};
    __builtin_memcpy(words, &value, sizeof(T));
    for (int i = 0; i < kWords; ++i)
        words[i] = __shfl_sync(mask, words[i], (int)lane);
    __builtin_memcpy(&value, words, sizeof(T));
    return value;
}

// The word that a launch provides for its grid. Each block adds to it once per barrier. The first
// block adds a value with which the top bit changes when all blocks have arrived.
SUNSTONE_GROUP_STATIC unsigned int* gridBarrier() {
    unsigned int low, high;
    asm("mov.u32 %0, %%envreg2;" : "=r"(low));
    asm("mov.u32 %0, %%envreg1;" : "=r"(high));
    const unsigned long long workspace = (unsigned long long)high << 32 | low;
    return workspace ? (unsigned int*)workspace + 1 : nullptr;
}

} // namespace details

class thread_block {
public:
    SUNSTONE_GROUP_STATIC void sync() { __syncthreads(); }
    SUNSTONE_GROUP_STATIC unsigned int thread_rank() { return details::threadRankInBlock(); }
    SUNSTONE_GROUP_STATIC unsigned int num_threads() { return details::threadsOfBlock(); }
    SUNSTONE_GROUP_STATIC unsigned int size() { return num_threads(); }
    SUNSTONE_GROUP_STATIC dim3 group_index() { return dim3(blockIdx.x, blockIdx.y, blockIdx.z); }
    SUNSTONE_GROUP_STATIC dim3 thread_index() {
        return dim3(threadIdx.x, threadIdx.y, threadIdx.z);
    }
    SUNSTONE_GROUP_STATIC dim3 dim_threads() { return dim3(blockDim.x, blockDim.y, blockDim.z); }
    SUNSTONE_GROUP_STATIC dim3 group_dim() { return dim_threads(); }
    // A split barrier: the wait does the work of both.
    struct arrival_token {};
    SUNSTONE_GROUP arrival_token barrier_arrive() const { return {}; }
    SUNSTONE_GROUP void barrier_wait(arrival_token&&) const { sync(); }
};
SUNSTONE_GROUP_STATIC thread_block this_thread_block() { return thread_block(); }

class grid_group {
public:
    // False in launches that are not cooperative.
    SUNSTONE_GROUP bool is_valid() const { return details::gridBarrier() != nullptr; }
    SUNSTONE_GROUP void sync() const {
        unsigned int* const word = details::gridBarrier();
        if (!word)
            __trap();
        __syncthreads();
        if (details::threadRankInBlock() == 0) {
            const unsigned int step =
                block_rank() == 0 ? 0x80000000u - ((unsigned int)num_blocks() - 1) : 1;
            __threadfence();
            const unsigned int before = atomicAdd(word, step);
            while (((*(volatile unsigned int*)word ^ before) & 0x80000000u) == 0) {
            }
            __threadfence();
        }
        __syncthreads();
    }
    SUNSTONE_GROUP unsigned long long num_blocks() const {
        return (unsigned long long)gridDim.x * gridDim.y * gridDim.z;
    }
    SUNSTONE_GROUP unsigned long long block_rank() const {
        return blockIdx.x +
               gridDim.x * (blockIdx.y + (unsigned long long)gridDim.y * blockIdx.z);
    }
    SUNSTONE_GROUP unsigned long long num_threads() const {
        return num_blocks() * details::threadsOfBlock();
    }
    SUNSTONE_GROUP unsigned long long size() const { return num_threads(); }
    SUNSTONE_GROUP unsigned long long thread_rank() const {
        return block_rank() * details::threadsOfBlock() + details::threadRankInBlock();
    }
    SUNSTONE_GROUP dim3 dim_blocks() const { return dim3(gridDim.x, gridDim.y, gridDim.z); }
    SUNSTONE_GROUP dim3 group_dim() const { return dim_blocks(); }
    SUNSTONE_GROUP dim3 block_index() const { return dim3(blockIdx.x, blockIdx.y, blockIdx.z); }
};
SUNSTONE_GROUP_STATIC grid_group this_grid() { return grid_group(); }

namespace details {

// Threads of one warp, selected by a mask: the common part of tiles and coalesced groups. Group has
// mask(), num_threads(), thread_rank() and laneOf(rank).
template <class Group>
class WarpGroup {
public:
    // Shuffles take references, because clang 19 applies the attribute of SUNSTONE_LANE to another
    // argument of member functions.
    SUNSTONE_GROUP void sync() const { __syncwarp(self().mask()); }
    SUNSTONE_GROUP unsigned int size() const { return self().num_threads(); }
    template <class T>
    SUNSTONE_GROUP T shfl(const T& value, int rank) const {
        return fromLane(self().mask(), value,
                        self().laneOf((unsigned int)rank % self().num_threads()));
    }
    template <class T>
    SUNSTONE_GROUP T shfl_up(const T& value, unsigned int delta) const {
        const unsigned int rank = self().thread_rank();
        return fromLane(self().mask(), value, self().laneOf(rank < delta ? rank : rank - delta));
    }
    template <class T>
    SUNSTONE_GROUP T shfl_down(const T& value, unsigned int delta) const {
        const unsigned int rank = self().thread_rank();
        return fromLane(self().mask(), value,
                        self().laneOf(rank + delta < self().num_threads() ? rank + delta : rank));
    }
    SUNSTONE_GROUP int any(int predicate) const { return __any_sync(self().mask(), predicate); }
    SUNSTONE_GROUP int all(int predicate) const { return __all_sync(self().mask(), predicate); }
    SUNSTONE_GROUP unsigned int ballot(int predicate) const {
        return self().ranksOf(__ballot_sync(self().mask(), predicate));
    }
    template <class T>
    SUNSTONE_GROUP unsigned int match_any(T value) const {
        return self().ranksOf(__match_any_sync(self().mask(), value));
    }
    template <class T>
    SUNSTONE_GROUP unsigned int match_all(T value, int& same) const {
        return self().ranksOf(__match_all_sync(self().mask(), value, &same));
    }

private:
    SUNSTONE_GROUP const Group& self() const { return static_cast<const Group&>(*this); }
};

} // namespace details

// kSize consecutive threads of a warp.
template <unsigned int kSize, class Parent = void>
class thread_block_tile : public details::WarpGroup<thread_block_tile<kSize, Parent>> {
    static_assert(kSize <= 32 && (kSize & (kSize - 1)) == 0, "a tile has 1, 2, 4, 8, 16 or 32 threads");

public:
    // A tile of a group of `count` threads, in which the calling thread has `rank`.
    SUNSTONE_GROUP thread_block_tile(unsigned int rank, unsigned int count)
        : metaRank_(rank / kSize), metaSize_((count + kSize - 1) / kSize) {}
    template <class Other>
    SUNSTONE_GROUP thread_block_tile(const thread_block_tile<kSize, Other>& other)
        : metaRank_(other.meta_group_rank()), metaSize_(other.meta_group_size()) {}
    SUNSTONE_GROUP_STATIC unsigned int num_threads() { return kSize; }
    SUNSTONE_GROUP_STATIC unsigned int thread_rank() { return details::laneIndex() % kSize; }
    SUNSTONE_GROUP_STATIC unsigned int mask() {
        return (0xffffffffu >> (32 - kSize)) << (details::laneIndex() / kSize * kSize);
    }
    SUNSTONE_GROUP_STATIC unsigned int laneOf(unsigned int rank) {
        return details::laneIndex() / kSize * kSize + rank;
    }
    SUNSTONE_GROUP_STATIC unsigned int ranksOf(unsigned int lanes) {
        return lanes >> (details::laneIndex() / kSize * kSize);
    }
    template <class T>
    SUNSTONE_GROUP T shfl_xor(const T& value, unsigned int lanes) const {
        return details::fromLane(mask(), value, laneOf((thread_rank() ^ lanes) % kSize));
    }
    // The rank of this tile among the tiles of its parent.
    SUNSTONE_GROUP unsigned int meta_group_rank() const { return metaRank_; }
    SUNSTONE_GROUP unsigned int meta_group_size() const { return metaSize_; }

private:
    unsigned int metaRank_, metaSize_;
};

// Threads of a warp by their lanes: active threads, or threads with a common property.
class coalesced_group : public details::WarpGroup<coalesced_group> {
public:
    SUNSTONE_GROUP explicit coalesced_group(unsigned int mask, unsigned int metaRank = 0,
                                            unsigned int metaSize = 1)
        : mask_(mask), metaRank_(metaRank), metaSize_(metaSize) {}
    SUNSTONE_GROUP unsigned int mask() const { return mask_; }
    SUNSTONE_GROUP unsigned int num_threads() const { return (unsigned int)__popc(mask_); }
    SUNSTONE_GROUP unsigned int thread_rank() const {
        return (unsigned int)__popc(mask_ & details::lanesBelow());
    }
    SUNSTONE_GROUP unsigned int laneOf(unsigned int rank) const {
        unsigned int rest = mask_;
        for (; rank > 0; --rank)
            rest &= rest - 1;
        return (unsigned int)__ffs((int)rest) - 1;
    }
    SUNSTONE_GROUP unsigned int ranksOf(unsigned int lanes) const {
        unsigned int ranks = 0, rank = 0;
        for (unsigned int rest = mask_; rest; rest &= rest - 1, ++rank)
            ranks |= (lanes & rest & -rest) ? 1u << rank : 0;
        return ranks;
    }
    SUNSTONE_GROUP unsigned int meta_group_rank() const { return metaRank_; }
    SUNSTONE_GROUP unsigned int meta_group_size() const { return metaSize_; }

private:
    unsigned int mask_, metaRank_, metaSize_;
};
SUNSTONE_GROUP_STATIC coalesced_group coalesced_threads() { return coalesced_group(__activemask()); }

// A block or threads of a warp, whichever the caller passes.
class thread_group {
public:
    SUNSTONE_GROUP thread_group(const thread_block&) : mask_(0) {}
    template <class Group>
    SUNSTONE_GROUP thread_group(const details::WarpGroup<Group>& group)
        : mask_(static_cast<const Group&>(group).mask()) {}
    SUNSTONE_GROUP void sync() const {
        if (mask_)
            __syncwarp(mask_);
        else
            __syncthreads();
    }
    SUNSTONE_GROUP unsigned int num_threads() const {
        return mask_ ? coalesced_group(mask_).num_threads() : details::threadsOfBlock();
    }
    SUNSTONE_GROUP unsigned int size() const { return num_threads(); }
    SUNSTONE_GROUP unsigned int thread_rank() const {
        return mask_ ? coalesced_group(mask_).thread_rank() : details::threadRankInBlock();
    }
    // Lanes of the warp; 0: the group is the block.
    SUNSTONE_GROUP unsigned int mask() const { return mask_; }

private:
    unsigned int mask_;
};

// ---- dividing groups --------------------------------------------------------------------------------
template <unsigned int kSize>
SUNSTONE_GROUP_STATIC thread_block_tile<kSize, thread_block> tiled_partition(const thread_block& block) {
    return thread_block_tile<kSize, thread_block>(block.thread_rank(), block.num_threads());
}
template <unsigned int kSize, unsigned int kParent, class Parent>
SUNSTONE_GROUP_STATIC thread_block_tile<kSize, thread_block_tile<kParent, Parent>>
tiled_partition(const thread_block_tile<kParent, Parent>& tile) {
    static_assert(kSize <= kParent, "a tile is no larger than what it is a part of");
    return thread_block_tile<kSize, thread_block_tile<kParent, Parent>>(tile.thread_rank(),
                                                                        kParent);
}
// By ranks, `size` at a time.
SUNSTONE_GROUP_STATIC coalesced_group tiled_partition(const coalesced_group& group,
                                                      unsigned int size) {
    const unsigned int first = group.thread_rank() / size * size;
    unsigned int mask = 0;
    for (unsigned int rank = first; rank < first + size && rank < group.num_threads(); ++rank)
        mask |= 1u << group.laneOf(rank);
    return coalesced_group(mask, first / size, (group.num_threads() + size - 1) / size);
}
// `size` is a power of two up to 32.
SUNSTONE_GROUP_STATIC thread_group tiled_partition(const thread_group& group, unsigned int size) {
    if (group.mask())
        return tiled_partition(coalesced_group(group.mask()), size);
    const unsigned int first = details::laneIndex() / size * size;
    return coalesced_group((0xffffffffu >> (32 - size)) << first & __activemask());
}
// Threads with the same label.
template <class Group, class Label>
SUNSTONE_GROUP_STATIC coalesced_group labeled_partition(const Group& group, Label label) {
    const unsigned int mask = __match_any_sync(group.mask(), label);
    // Groups are numbered by their first lanes.
    const unsigned int firsts =
        __ballot_sync(group.mask(), (mask & details::lanesBelow()) == 0);
    const unsigned int own = mask & -mask;
    return coalesced_group(mask, (unsigned int)__popc(firsts & (own - 1)),
                           (unsigned int)__popc(firsts));
}
template <class Group>
SUNSTONE_GROUP_STATIC coalesced_group binary_partition(const Group& group, bool predicate) {
    const unsigned int holds = __ballot_sync(group.mask(), predicate);
    return coalesced_group(predicate ? holds : group.mask() & ~holds, predicate ? 1 : 0, 2);
}

// ---- as functions -----------------------------------------------------------------------------------
template <class Group>
SUNSTONE_GROUP_STATIC void sync(const Group& group) {
    group.sync();
}
template <class Group>
SUNSTONE_GROUP_STATIC void synchronize(const Group& group) {
    group.sync();
}
template <class Group>
SUNSTONE_GROUP_STATIC unsigned int thread_rank(const Group& group) {
    return (unsigned int)group.thread_rank();
}
template <class Group>
SUNSTONE_GROUP_STATIC unsigned int group_size(const Group& group) {
    return (unsigned int)group.size();
}
template <class Group, class Function>
SUNSTONE_GROUP_STATIC void invoke_one(const Group& group, Function&& function) {
    if (group.thread_rank() == 0)
        function();
}
// All threads get the result. The group is a tile or coalesced.
template <class Group, class Function>
SUNSTONE_GROUP_STATIC auto invoke_one_broadcast(const Group& group, Function&& function)
    -> decltype(function()) {
    decltype(function()) result{};
    if (group.thread_rank() == 0)
        result = function();
    return group.shfl(result, 0);
}

} // namespace cooperative_groups
#endif
#endif
