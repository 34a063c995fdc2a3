/* SPDX-License-Identifier: Apache-2.0
   The headers promise C: compiles as C99 if sizes, offsets and values are those of the table. */
#include <optix.h>
#include <optix_function_table_definition.h>
#include <optix_stack_size.h>
#include <optix_stubs.h>

#include <stddef.h>

#include "host_checks_c.inc"
