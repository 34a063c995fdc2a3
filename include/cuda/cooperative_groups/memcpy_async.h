// SPDX-License-Identifier: Apache-2.0
// Copies by a whole group. CUDA completes them at the wait at the latest; this implementation
// copies in the call.
#ifndef SUNSTONE_COOPERATIVE_GROUPS_MEMCPY_ASYNC_H
#define SUNSTONE_COOPERATIVE_GROUPS_MEMCPY_ASYNC_H

#include "../cooperative_groups.h"

#ifdef SUNSTONE_CUDA_COMPILATION
namespace cooperative_groups {

template <class Group, class T>
SUNSTONE_GROUP_STATIC void memcpy_async(const Group& group, T* to, const T* from, size_t bytes) {
    unsigned char* const t = (unsigned char*)to;
    const unsigned char* const f = (const unsigned char*)from;
    const size_t words = ((size_t)t | (size_t)f) % 4 == 0 ? bytes / 4 : 0;
    for (size_t i = group.thread_rank(); i < words; i += group.num_threads())
        ((unsigned int*)t)[i] = ((const unsigned int*)f)[i];
    for (size_t i = words * 4 + group.thread_rank(); i < bytes; i += group.num_threads())
        t[i] = f[i];
}
// Counts of elements; the smaller one counts.
template <class Group, class T>
SUNSTONE_GROUP_STATIC void memcpy_async(const Group& group, T* to, size_t toCount, const T* from,
                                        size_t fromCount) {
    memcpy_async(group, to, from, (toCount < fromCount ? toCount : fromCount) * sizeof(T));
}
template <class Group>
SUNSTONE_GROUP_STATIC void wait(const Group& group) {
    group.sync();
}
template <unsigned int kStages, class Group>
SUNSTONE_GROUP_STATIC void wait_prior(const Group& group) {
    group.sync();
}

} // namespace cooperative_groups
#endif
#endif
