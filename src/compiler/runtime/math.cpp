// SPDX-License-Identifier: Apache-2.0
// Transcendental functions; the list of all functions of the run-time.
#include "compiler/runtime/runtime.h"

#include <cmath>
#include <cstdint>

namespace sunstone::compiler {

namespace {

float sine(float x) {
    return std::sin(x);
}
float cosine(float x) {
    return std::cos(x);
}
float logarithm2(float x) {
    return std::log2(x);
}
float exponential2(float x) {
    return std::exp2(x);
}
float hyperbolicTangent(float x) {
    return std::tanh(x);
}

// fns: the position of the n-th set bit of `mask`, counted from `base` upwards (n > 0) or
// downwards (n < 0); n = 0 tests whether bit `base` is set. All ones if no bit is found.
uint32_t findNth(uint32_t mask, uint32_t base, uint32_t n) {
    const int32_t offset = int32_t(n);
    if (base > 31)
        return ~0u;
    if (offset == 0)
        return mask >> base & 1 ? base : ~0u;
    const int step = offset > 0 ? 1 : -1;
    int64_t left = offset > 0 ? int64_t(offset) : -int64_t(offset);
    for (int position = int(base); position >= 0 && position < 32; position += step)
        if (mask >> position & 1 && --left == 0)
            return uint32_t(position);
    return ~0u;
}

template <class Function>
const void* addressOf(Function* function) {
    return reinterpret_cast<const void*>(function);
}

} // namespace

void addMathSymbols(std::vector<RuntimeSymbol>& symbols) {
    const RuntimeSymbol own[] = {
        {"sunstone_sin_f32", addressOf(sine)},
        {"sunstone_cos_f32", addressOf(cosine)},
        {"sunstone_lg2_f32", addressOf(logarithm2)},
        {"sunstone_ex2_f32", addressOf(exponential2)},
        {"sunstone_tanh_f32", addressOf(hyperbolicTangent)},
        {"sunstone_fns", addressOf(findNth)},
    };
    symbols.insert(symbols.end(), std::begin(own), std::end(own));
}

const std::vector<RuntimeSymbol>& runtimeSymbols() {
    static const auto* all = [] {
        auto* made = new std::vector<RuntimeSymbol>;
        std::vector<RuntimeSymbol>& symbols = *made;
        addRoundingSymbols(symbols);
        addMathSymbols(symbols);
        addLibrarySymbols(symbols);
        addKernelSymbols(symbols);
        addAsyncSymbols(symbols);
        addTextureSymbols(symbols);
        addCheckSymbols(symbols);
        addSmallFloatSymbols(symbols);
        addAtomicSymbols(symbols);
        addMatrixSymbols(symbols);
        return made;
    }();
    return *all;
}

} // namespace sunstone::compiler
