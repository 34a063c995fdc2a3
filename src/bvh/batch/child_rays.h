// SPDX-License-Identifier: Apache-2.0
// For each child of a node, the set of the rays that meet the child. Included by files that are
// compiled once per instruction set (see bvh/simd.h).
#pragma once

#include "bvh/simd.h"

namespace sunstone::bvh::SUNSTONE_ISA {

// The rays that meet each child of a node, one bit per ray.
#if defined(__AVX512F__)
class ChildRays {
public:
    SUNSTONE_INLINE_MEMBER void add(uint32_t ray, Mask children) {
        sets_ = _mm512_mask_or_epi64(sets_, __mmask8(children), sets_,
                                     _mm512_set1_epi64(int64_t(uint64_t(1) << ray)));
    }
    SUNSTONE_INLINE_MEMBER void finish(uint64_t* sets) { _mm512_store_si512(sets, sets_); }

private:
    __m512i sets_ = _mm512_setzero_si512();
};
#else
class ChildRays {
public:
    SUNSTONE_INLINE_MEMBER void add(uint32_t ray, Mask children) {
        bytes_[ray] = uint8_t(children);
    }
    SUNSTONE_INLINE_MEMBER void finish(uint64_t* sets) const {
        for (uint32_t child = 0; child < 8; ++child) {
            // The rays whose byte has the child's bit.
            const __m128i shift = _mm_cvtsi32_si128(int(7 - child));
            uint64_t set = 0;
            for (int i = 3; i >= 0; --i) {
                const __m128i hits = _mm_load_si128(reinterpret_cast<const __m128i*>(bytes_) + i);
                set = set << 16 |
                      uint64_t(uint32_t(_mm_movemask_epi8(_mm_sll_epi16(hits, shift))) & 0xFFFFu);
            }
            sets[child] = set;
        }
    }

private:
    alignas(16) uint8_t bytes_[64] = {};
};
#endif

} // namespace sunstone::bvh::SUNSTONE_ISA
