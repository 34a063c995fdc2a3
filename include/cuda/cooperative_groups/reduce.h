// SPDX-License-Identifier: Apache-2.0
// Reductions over tiles and coalesced groups.
#ifndef SUNSTONE_COOPERATIVE_GROUPS_REDUCE_H
#define SUNSTONE_COOPERATIVE_GROUPS_REDUCE_H

#include "../cooperative_groups.h"

#ifdef SUNSTONE_CUDA_COMPILATION
namespace cooperative_groups {

#define SUNSTONE_OPERATION(name, result)                                                           \
    template <class T>                                                                             \
    struct name {                                                                                  \
        SUNSTONE_GROUP T operator()(T a, T b) const { return result; }                             \
    };
SUNSTONE_OPERATION(plus, a + b)
SUNSTONE_OPERATION(less, b < a ? b : a)
SUNSTONE_OPERATION(greater, a < b ? b : a)
SUNSTONE_OPERATION(bit_and, a & b)
SUNSTONE_OPERATION(bit_or, a | b)
SUNSTONE_OPERATION(bit_xor, a ^ b)
#undef SUNSTONE_OPERATION

// Every thread of the group gets the result.
template <class Group, class T, class Operation>
SUNSTONE_GROUP_STATIC T reduce(const Group& group, T value, Operation operation) {
    const unsigned int count = group.num_threads(), rank = group.thread_rank();
    for (unsigned int step = 1; step < count; step *= 2) {
        const T other = group.shfl_down(value, step);
        if (rank + step < count)
            value = operation(value, other);
    }
    return group.shfl(value, 0);
}

} // namespace cooperative_groups
#endif
#endif
