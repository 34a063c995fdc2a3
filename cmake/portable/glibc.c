// SPDX-License-Identifier: Apache-2.0
// Names of glibc 2.32 to 2.36 that archives of Debian 12 need, for programs on glibc 2.31.
// cmake/portable/sysroot adds them to libc_nonshared.a, so that each link with the C library finds
// them.
#include <errno.h>
#include <malloc.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/random.h>

#define HIDDEN __attribute__((visibility("hidden")))

// 2.32: libstdc++ omits atomic operations while this is true.
HIDDEN char __libc_single_threaded = 0;

// 2.33
struct mallinfo2 {
    size_t arena, ordblks, smblks, hblks, hblkhd, usmblks, fsmblks, uordblks, fordblks, keepcost;
};
HIDDEN struct mallinfo2 mallinfo2(void) {
    // The fields of mallinfo are ints that wrap around; LLVM prints them in statistics.
    struct mallinfo info = mallinfo();
    struct mallinfo2 result = {(unsigned)info.arena,    (unsigned)info.ordblks,
                               (unsigned)info.smblks,   (unsigned)info.hblks,
                               (unsigned)info.hblkhd,   (unsigned)info.usmblks,
                               (unsigned)info.fsmblks,  (unsigned)info.uordblks,
                               (unsigned)info.fordblks, (unsigned)info.keepcost};
    return result;
}

// 2.36
HIDDEN uint32_t arc4random(void) {
    uint32_t value;
    while (getrandom(&value, sizeof value, 0) != sizeof value)
        if (errno != EINTR)
            abort();
    return value;
}
