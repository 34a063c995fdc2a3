// SPDX-License-Identifier: Apache-2.0
// The functions that matrix instructions (matrix.h) call if threads run one by one. Warps that run
// in lockstep use answerLanes (warp_functions.cpp).
#include "compiler/runtime/matrix.h"
#include "compiler/runtime/runtime.h"
#include "devlib/abi.h"

#include <bit>

namespace sunstone::compiler {

namespace {

using devlib::KernelThread;

// All lanes pass the addresses of their blocks, the first one computes all results, then all
// continue.
uint32_t runMatrix(KernelThread* thread, uint32_t, uint32_t mask, uint64_t block) {
    const auto* functions = *static_cast<devlib::BlockFunctions* const*>(thread->block);
    uint64_t values[32] = {};
    const uint32_t present =
        functions->exchange(thread, mask, block, values) | 1u << thread->laneid;
    values[thread->laneid] = block;
    if (thread->laneid == uint32_t(std::countr_zero(present)))
        computeMatrix(values, present);
    functions->exchange(thread, mask, block, values);
    return 0;
}

} // namespace

void addMatrixSymbols(std::vector<RuntimeSymbol>& symbols) {
    symbols.push_back({"sunstone_matrix", reinterpret_cast<const void*>(&runMatrix)});
}

} // namespace sunstone::compiler
