/* SPDX-License-Identifier: Apache-2.0 */
// Atomic counters of Prime++'s reference counts.
#ifndef OPTIX_PRIMEPP_ATOM_H
#define OPTIX_PRIMEPP_ATOM_H

#if defined(__GNUC__) || defined(__clang__)
#define PRIME_ATOM32_GCC
#elif defined(_MSC_VER)
#include <intrin.h>
#else
#error "Prime++ needs GCC, clang or Microsoft's compiler"
#endif

namespace optix {
namespace prime {

typedef unsigned int atomic_word;

// A 32-bit counter; both operations return the new value.
class Atom32 {
public:
    explicit Atom32(atomic_word value = 0) : value_(value) {}
#if defined(PRIME_ATOM32_GCC)
    atomic_word operator++() { return __sync_add_and_fetch(&value_, 1u); }
    atomic_word operator--() { return __sync_sub_and_fetch(&value_, 1u); }
#else
    atomic_word operator++() {
        return atomic_word(_InterlockedIncrement(reinterpret_cast<volatile long*>(&value_)));
    }
    atomic_word operator--() {
        return atomic_word(_InterlockedDecrement(reinterpret_cast<volatile long*>(&value_)));
    }
#endif

private:
    Atom32(const Atom32&);
    Atom32& operator=(const Atom32&);
    volatile atomic_word value_;
};

} // namespace prime
} // namespace optix

#endif
