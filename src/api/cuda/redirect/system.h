// SPDX-License-Identifier: Apache-2.0
// System calls and text of the audit library, which is linked without the C library: for an auditor
// that needs one, the loader loads a second C library with thread-local storage of its own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>

namespace sunstone::redirect {

inline long systemCall(long number, long a = 0, long b = 0, long c = 0, long d = 0, long e = 0,
                       long f = 0) {
    long result = number;
    register long r10 asm("r10") = d;
    register long r8 asm("r8") = e;
    register long r9 asm("r9") = f;
    asm volatile("syscall"
                 : "+a"(result)
                 : "D"(a), "S"(b), "d"(c), "r"(r10), "r"(r8), "r"(r9)
                 : "rcx", "r11", "memory");
    return result;
}

inline bool failed(long result) {
    return result < 0 && result >= -4095;
}

// Null on failure.
inline uint8_t* mapMemory(uintptr_t address, size_t size, int access, int flags, int file = -1) {
    const long at = systemCall(SYS_mmap, long(address), long(size), access, flags, file, 0);
    return failed(at) ? nullptr : reinterpret_cast<uint8_t*>(at);
}
inline void unmapMemory(void* at, size_t size) {
    systemCall(SYS_munmap, reinterpret_cast<long>(at), long(size));
}
inline bool protectMemory(uintptr_t at, size_t size, int access) {
    return systemCall(SYS_mprotect, long(at), long(size), access) == 0;
}

inline size_t lengthOf(const char* text) {
    size_t length = 0;
    while (text[length])
        ++length;
    return length;
}
inline int compare(const char* a, const char* b) {
    while (*a && *a == *b)
        ++a, ++b;
    return int(uint8_t(*a)) - int(uint8_t(*b));
}
inline bool startsWith(const char* text, const char* prefix) {
    while (*prefix)
        if (*text++ != *prefix++)
            return false;
    return true;
}
inline bool sameBytes(const uint8_t* a, const uint8_t* b, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (a[i] != b[i])
            return false;
    return true;
}

// One line on stderr, in one write.
template <class... Texts>
void say(Texts... texts) {
    char line[2048];
    size_t size = 0;
    const auto add = [&](const char* text) {
        for (; *text && size < sizeof line - 1; ++text)
            line[size++] = *text;
    };
    add("[sunstone redirect] ");
    (add(texts), ...);
    line[size++] = '\n';
    systemCall(SYS_write, 2, reinterpret_cast<long>(line), long(size));
}

} // namespace sunstone::redirect
