// SPDX-License-Identifier: Apache-2.0
// Defines g_optixFunctionTable, the table that optix_stubs.h calls through. Include it in exactly
// one source file of an application. Source: OptiX API reference 7.4, sections 3.13.3, 6.11.
#ifndef SUNSTONE_OPTIX7_OPTIX_FUNCTION_TABLE_DEFINITION_H
#define SUNSTONE_OPTIX7_OPTIX_FUNCTION_TABLE_DEFINITION_H

#include "optix_function_table.h"

#ifdef __cplusplus
extern "C" {
#endif

extern OptixFunctionTable g_optixFunctionTable;
/** All null until optixInit fills it. */
OptixFunctionTable g_optixFunctionTable;

#ifdef __cplusplus
}
#endif

#endif
