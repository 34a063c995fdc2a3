/* SPDX-License-Identifier: Apache-2.0
   A library in the place of libnvoptix.so.1, for the tests of optixInit: answers what the
   environment variable FAKE_OPTIX_RESULT says. Built a second time without the entry point. */
#include <optix_function_table.h>

#include <stdlib.h>
#include <string.h>

#ifndef WITHOUT_ENTRY

static const char* errorName(OptixResult result) {
    (void)result;
    return "from the library";
}

OptixResult optixQueryFunctionTable(int abiId, unsigned int numOptions,
                                    OptixQueryFunctionTableOptions* keys, const void** values,
                                    void* functionTable, size_t sizeOfTable) {
    const char* result = getenv("FAKE_OPTIX_RESULT");
    if (abiId != 55 || numOptions != 0 || keys || values || sizeOfTable != 43 * sizeof(void*))
        return OPTIX_ERROR_INTERNAL_ERROR;
    memset(functionTable, 0xFF, sizeOfTable);
    ((OptixFunctionTable*)functionTable)->optixGetErrorName = errorName;
    return result ? (OptixResult)atoi(result) : OPTIX_SUCCESS;
}

#else

int unrelated(void);
int unrelated(void) {
    return 0;
}

#endif
