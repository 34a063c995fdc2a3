// SPDX-License-Identifier: Apache-2.0
// Compiles if all host headers together match the table of facts. The include order is that of
// applications: the API, the stubs, the table's definition, utilities.
#include <optix.h>

#include <optix_7_host.h>
#include <optix_7_types.h>
#include <optix_denoiser_tiling.h>
#include <optix_function_table.h>
#include <optix_function_table_definition.h>
#include <optix_host.h>
#include <optix_stack_size.h>
#include <optix_stubs.h>
#include <optix_types.h>

#include <cstddef>

namespace {
template <typename A, typename B>
struct SameType {
    static const bool value = false;
};
template <typename A>
struct SameType<A, A> {
    static const bool value = true;
};
} // namespace
#define CHECK_OFFSET(type, member, offset)                                                         \
    static_assert(offsetof(type, member) == offset, "offset of " #type "::" #member);

#include "host_checks.inc"
