// SPDX-License-Identifier: Apache-2.0
// The row kernels of a CPU: the bodies of rows_body.h over chunks of a row. Include once in a file
// that is compiled for one instruction set.
#pragma once

#include "denoise/rows/rows_body.h"

namespace sunstone::denoise {
namespace {

constexpr uint32_t kChunk = 256;      // pixels whose sums are held on the stack
constexpr uint32_t kDetailChunk = 64; // all moments stay in the first-level cache

template <class Chunk>
void forChunks(const Pass& pass, Chunk chunk, uint32_t size = kChunk) {
    for (uint32_t begin = 0; begin < pass.width; begin += size)
        chunk(begin, std::min(pass.width, begin + size));
}

// Selects the variant for a pass's number of guides.
template <class Call>
void withGuides(const Pass& pass, Call call) {
    switch (pass.guideCount) {
    case 2:
        return call.template operator()<2>();
    case 3:
        return call.template operator()<3>();
    case 5:
        return call.template operator()<5>();
    case 6:
        return call.template operator()<6>();
    default:
        return call.template operator()<0>();
    }
}

void repairRow(const Pass& pass, uint32_t y) {
    withGuides(pass, [&]<int kGuides>() {
        forChunks(pass,
                  [&](uint32_t a, uint32_t b) { repairChunk<kGuides, kChunk>(pass, y, a, b); });
    });
}
void residualRow(const Pass& pass, uint32_t y) {
    withGuides(pass, [&]<int kGuides>() {
        forChunks(pass,
                  [&](uint32_t a, uint32_t b) { residualChunk<kGuides, kChunk>(pass, y, a, b); });
    });
}
void spreadRow(const Pass& pass, uint32_t y) {
    withGuides(pass, [&]<int kGuides>() {
        forChunks(pass,
                  [&](uint32_t a, uint32_t b) { spreadChunk<kGuides, kChunk>(pass, y, a, b); });
    });
}
void detailRow(const Pass& pass, uint32_t y) {
    withGuides(pass, [&]<int kGuides>() {
        if constexpr (kGuides != 0)
            forChunks(
                pass,
                [&](uint32_t a, uint32_t b) { detailChunk<kGuides, kDetailChunk>(pass, y, a, b); },
                kDetailChunk);
    });
}
void smoothRow(const Pass& pass, uint32_t y) {
    withGuides(pass, [&]<int kGuides>() {
        forChunks(pass, [&](uint32_t a, uint32_t b) {
            if (pass.hasAlpha)
                smoothChunk<kGuides, true, kChunk>(pass, y, a, b);
            else
                smoothChunk<kGuides, false, kChunk>(pass, y, a, b);
        });
    });
}

void lossRow(const Pass& pass, uint32_t y) {
    forChunks(pass, [&](uint32_t a, uint32_t b) { lossChunk<kChunk>(pass, y, a, b); });
}
void correlateRow(const Pass& pass, uint32_t y) {
    forChunks(pass, [&](uint32_t a, uint32_t b) { correlateChunk<kChunk>(pass, y, a, b); });
}
void gatherRow(const Pass& pass, uint32_t y) {
    forChunks(pass, [&](uint32_t a, uint32_t b) { gatherChunk<kChunk>(pass, y, a, b); });
}
void sumRowRow(const Pass& pass, uint32_t y) {
    forChunks(pass, [&](uint32_t a, uint32_t b) { sumRowChunk<kChunk>(pass, y, a, b); });
}
void meanOfBoxRow(const Pass& pass, uint32_t y) {
    forChunks(pass, [&](uint32_t a, uint32_t b) { meanOfBoxChunk<kChunk>(pass, y, a, b); });
}
void giveBackRow(const Pass& pass, uint32_t y) {
    forChunks(pass, [&](uint32_t a, uint32_t b) { returnChunk<kChunk>(pass, y, a, b); });
}

constexpr RowKernels kKernels = {repairRow, residualRow,  spreadRow,    detailRow,
                                 smoothRow, lossRow,      correlateRow, gatherRow,
                                 sumRowRow, meanOfBoxRow, giveBackRow};

} // namespace
} // namespace sunstone::denoise
