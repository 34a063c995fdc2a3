// SPDX-License-Identifier: Apache-2.0
// Atomics without a CPU instruction: 16-bit numbers, alone or in pairs, and float sums in global
// memory, whose subnormals GPUs flush.
#include "compiler/runtime/runtime.h"
#include "compiler/runtime/small_floats.h"

#include <atomic>
#include <bit>
#include <cmath>

namespace sunstone::compiler {

namespace {

uint16_t combine(uint16_t a, uint16_t b, SmallFormat format, AtomicOperation operation) {
    const double x = decodeSmall(a, uint32_t(format)), y = decodeSmall(b, uint32_t(format));
    double result = x + y; // exact in double, or far from a tie of 16 bits
    if (operation != AtomicOperation::kAdd) {
        const bool min = operation == AtomicOperation::kMinimum;
        if (std::isnan(x) || std::isnan(y))
            result = std::isnan(x) ? y : x;
        else if (x == y) // zeros of either sign
            result = std::signbit(x) == min ? x : y;
        else
            result = (x < y) == min ? x : y;
    }
    return uint16_t(encodeSmall(result, uint32_t(format), 0));
}

template <class Word, class Change>
Word exchange(void* address, Change change) {
    std::atomic_ref<Word> word(*static_cast<Word*>(address));
    Word old = word.load(std::memory_order_relaxed);
    while (!word.compare_exchange_weak(old, change(old), std::memory_order_acq_rel,
                                       std::memory_order_relaxed)) {
    }
    return old;
}

uint32_t atomicHalf(void* address, uint32_t operand, uint32_t format, uint32_t operation) {
    return exchange<uint16_t>(address, [&](uint16_t old) {
        return combine(old, uint16_t(operand), SmallFormat(format), AtomicOperation(operation));
    });
}

uint32_t atomicPair(void* address, uint32_t operand, uint32_t format, uint32_t operation) {
    return exchange<uint32_t>(address, [&](uint32_t old) {
        const auto part = [&](unsigned shift) {
            return uint32_t(combine(uint16_t(old >> shift), uint16_t(operand >> shift),
                                    SmallFormat(format), AtomicOperation(operation)))
                   << shift;
        };
        return part(0) | part(16);
    });
}

float flushed(float value) {
    return std::fabs(value) < 0x1p-126f ? std::copysign(0.0f, value) : value;
}

float atomicAddFlushed(float* address, float operand) {
    return std::bit_cast<float>(exchange<uint32_t>(address, [&](uint32_t old) {
        return std::bit_cast<uint32_t>(
            flushed(flushed(std::bit_cast<float>(old)) + flushed(operand)));
    }));
}

template <class Function>
const void* addressOf(Function* function) {
    return reinterpret_cast<const void*>(function);
}

} // namespace

void addAtomicSymbols(std::vector<RuntimeSymbol>& symbols) {
    const RuntimeSymbol own[] = {
        {"sunstone_atomic_half", addressOf(atomicHalf)},
        {"sunstone_atomic_pair", addressOf(atomicPair)},
        {"sunstone_atomic_add_flushed", addressOf(atomicAddFlushed)},
    };
    symbols.insert(symbols.end(), std::begin(own), std::end(own));
}

} // namespace sunstone::compiler
