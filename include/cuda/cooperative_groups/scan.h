// SPDX-License-Identifier: Apache-2.0
// Prefix sums over tiles and coalesced groups, by rank.
#ifndef SUNSTONE_COOPERATIVE_GROUPS_SCAN_H
#define SUNSTONE_COOPERATIVE_GROUPS_SCAN_H

#include "reduce.h"

#ifdef SUNSTONE_CUDA_COMPILATION
namespace cooperative_groups {

template <class Group, class T, class Operation>
SUNSTONE_GROUP_STATIC T inclusive_scan(const Group& group, T value, Operation operation) {
    const unsigned int count = group.num_threads(), rank = group.thread_rank();
    for (unsigned int step = 1; step < count; step *= 2) {
        const T other = group.shfl_up(value, step);
        if (rank >= step)
            value = operation(other, value);
    }
    return value;
}
template <class Group, class T>
SUNSTONE_GROUP_STATIC T inclusive_scan(const Group& group, T value) {
    return inclusive_scan(group, value, plus<T>());
}
// The first thread gets T().
template <class Group, class T, class Operation>
SUNSTONE_GROUP_STATIC T exclusive_scan(const Group& group, T value, Operation operation) {
    const T before = group.shfl_up(inclusive_scan(group, value, operation), 1);
    return group.thread_rank() == 0 ? T() : before;
}
template <class Group, class T>
SUNSTONE_GROUP_STATIC T exclusive_scan(const Group& group, T value) {
    return exclusive_scan(group, value, plus<T>());
}

} // namespace cooperative_groups
#endif
#endif
