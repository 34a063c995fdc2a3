// SPDX-License-Identifier: Apache-2.0
// Marks bytes that the library must not access, for builds with the address sanitizer. Other builds
// do nothing here.
#pragma once

#include <cstddef>
#include <cstdint>

#if defined(__SANITIZE_ADDRESS__)
#define SUNSTONE_POISONS 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SUNSTONE_POISONS 1
#endif
#endif

#ifdef SUNSTONE_POISONS
#include <sanitizer/asan_interface.h>
#endif

namespace sunstone::device::cpu {

#ifdef SUNSTONE_POISONS
constexpr bool kPoisons = true;
inline void poison(uintptr_t begin, size_t bytes) {
    __asan_poison_memory_region(reinterpret_cast<void*>(begin), bytes);
}
inline void unpoison(uintptr_t begin, size_t bytes) {
    __asan_unpoison_memory_region(reinterpret_cast<void*>(begin), bytes);
}
#else
constexpr bool kPoisons = false;
inline void poison(uintptr_t, size_t) {}
inline void unpoison(uintptr_t, size_t) {}
#endif

} // namespace sunstone::device::cpu
