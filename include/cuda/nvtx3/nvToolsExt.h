// SPDX-License-Identifier: Apache-2.0
// Annotations for profilers (NVTX 3): marks, ranges, names. No profiler attaches to Sunstone, so
// all functions do nothing and return what the interface documents for a process without a tool. C
// and C++.
#ifndef SUNSTONE_NVTOOLSEXT_H
#define SUNSTONE_NVTOOLSEXT_H

#include <stddef.h>
#include <stdint.h>
#include <wchar.h>

#define NVTX_VERSION 3

#define NVTX_SUCCESS 0
#define NVTX_FAIL 1
#define NVTX_ERR_INIT_LOAD_PROPERTY 2
#define NVTX_ERR_INIT_ACCESS_LIBRARY 3
#define NVTX_ERR_INIT_LOAD_LIBRARY 4
#define NVTX_ERR_INIT_MISSING_LIBRARY_ENTRY_POINT 5
#define NVTX_ERR_INIT_FAILED_LIBRARY_ENTRY_POINT 6
#define NVTX_ERR_NO_INJECTION_LIBRARY_AVAILABLE 7
// Result of pushes and pops without a tool.
#define NVTX_NO_PUSH_POP_TRACKING ((int)-2)

typedef uint64_t nvtxRangeId_t;
typedef struct nvtxDomainRegistration_st* nvtxDomainHandle_t;
typedef struct nvtxStringRegistration_st* nvtxStringHandle_t;
typedef struct nvtxResourceHandle* nvtxResourceHandle_t;

typedef enum nvtxColorType_t { NVTX_COLOR_UNKNOWN = 0, NVTX_COLOR_ARGB = 1 } nvtxColorType_t;

typedef enum nvtxMessageType_t {
    NVTX_MESSAGE_UNKNOWN = 0,
    NVTX_MESSAGE_TYPE_ASCII = 1,
    NVTX_MESSAGE_TYPE_UNICODE = 2,
    NVTX_MESSAGE_TYPE_REGISTERED = 3
} nvtxMessageType_t;

typedef union nvtxMessageValue_t {
    const char* ascii;
    const wchar_t* unicode;
    nvtxStringHandle_t registered;
} nvtxMessageValue_t;

typedef enum nvtxPayloadType_t {
    NVTX_PAYLOAD_UNKNOWN = 0,
    NVTX_PAYLOAD_TYPE_UNSIGNED_INT64 = 1,
    NVTX_PAYLOAD_TYPE_INT64 = 2,
    NVTX_PAYLOAD_TYPE_DOUBLE = 3,
    NVTX_PAYLOAD_TYPE_UNSIGNED_INT32 = 4,
    NVTX_PAYLOAD_TYPE_INT32 = 5,
    NVTX_PAYLOAD_TYPE_FLOAT = 6
} nvtxPayloadType_t;

typedef struct nvtxEventAttributes_v2 {
    uint16_t version;
    uint16_t size;
    uint32_t category;
    int32_t colorType;
    uint32_t color;
    int32_t payloadType;
    int32_t reserved0;
    union payload_t {
        uint64_t ullValue;
        int64_t llValue;
        double dValue;
        uint32_t uiValue;
        int32_t iValue;
        float fValue;
    } payload;
    int32_t messageType;
    nvtxMessageValue_t message;
} nvtxEventAttributes_v2;
typedef nvtxEventAttributes_v2 nvtxEventAttributes_t;
#define NVTX_EVENT_ATTRIB_STRUCT_SIZE ((uint16_t)sizeof(nvtxEventAttributes_t))

typedef enum nvtxResourceGenericType_t {
    NVTX_RESOURCE_TYPE_UNKNOWN = 0,
    NVTX_RESOURCE_TYPE_GENERIC_POINTER = 1,
    NVTX_RESOURCE_TYPE_GENERIC_HANDLE = 2,
    NVTX_RESOURCE_TYPE_GENERIC_THREAD_NATIVE = 3,
    NVTX_RESOURCE_TYPE_GENERIC_THREAD_POSIX = 4
} nvtxResourceGenericType_t;

typedef struct nvtxResourceAttributes_v0 {
    uint16_t version;
    uint16_t size;
    int32_t identifierType;
    union identifier_t {
        const void* pValue;
        uint64_t ullValue;
    } identifier;
    int32_t messageType;
    nvtxMessageValue_t message;
} nvtxResourceAttributes_v0;
typedef nvtxResourceAttributes_v0 nvtxResourceAttributes_t;
#define NVTX_RESOURCE_ATTRIB_STRUCT_SIZE ((uint16_t)sizeof(nvtxResourceAttributes_t))

// A function that ignores its parameters, in C as in C++.
#define SUNSTONE_NVTX(type, name, parameters, result)                                              \
    static inline type name parameters {                                                           \
        return result;                                                                             \
    }
#define SUNSTONE_NVTX_VOID(name, parameters)                                                       \
    static inline void name parameters {}

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wunused-function"
#endif

SUNSTONE_NVTX_VOID(nvtxInitialize, (const void* reserved))

SUNSTONE_NVTX_VOID(nvtxMarkEx, (const nvtxEventAttributes_t* attributes))
SUNSTONE_NVTX_VOID(nvtxMarkA, (const char* message))
SUNSTONE_NVTX_VOID(nvtxMarkW, (const wchar_t* message))
SUNSTONE_NVTX_VOID(nvtxDomainMarkEx,
                   (nvtxDomainHandle_t domain, const nvtxEventAttributes_t* attributes))

SUNSTONE_NVTX(nvtxRangeId_t, nvtxRangeStartEx, (const nvtxEventAttributes_t* attributes), 0)
SUNSTONE_NVTX(nvtxRangeId_t, nvtxRangeStartA, (const char* message), 0)
SUNSTONE_NVTX(nvtxRangeId_t, nvtxRangeStartW, (const wchar_t* message), 0)
SUNSTONE_NVTX(nvtxRangeId_t, nvtxDomainRangeStartEx,
              (nvtxDomainHandle_t domain, const nvtxEventAttributes_t* attributes), 0)
SUNSTONE_NVTX_VOID(nvtxRangeEnd, (nvtxRangeId_t id))
SUNSTONE_NVTX_VOID(nvtxDomainRangeEnd, (nvtxDomainHandle_t domain, nvtxRangeId_t id))

SUNSTONE_NVTX(int, nvtxRangePushEx, (const nvtxEventAttributes_t* attributes),
              NVTX_NO_PUSH_POP_TRACKING)
SUNSTONE_NVTX(int, nvtxRangePushA, (const char* message), NVTX_NO_PUSH_POP_TRACKING)
SUNSTONE_NVTX(int, nvtxRangePushW, (const wchar_t* message), NVTX_NO_PUSH_POP_TRACKING)
SUNSTONE_NVTX(int, nvtxRangePop, (void), NVTX_NO_PUSH_POP_TRACKING)
SUNSTONE_NVTX(int, nvtxDomainRangePushEx,
              (nvtxDomainHandle_t domain, const nvtxEventAttributes_t* attributes),
              NVTX_NO_PUSH_POP_TRACKING)
SUNSTONE_NVTX(int, nvtxDomainRangePop, (nvtxDomainHandle_t domain), NVTX_NO_PUSH_POP_TRACKING)

SUNSTONE_NVTX(nvtxDomainHandle_t, nvtxDomainCreateA, (const char* name), NULL)
SUNSTONE_NVTX(nvtxDomainHandle_t, nvtxDomainCreateW, (const wchar_t* name), NULL)
SUNSTONE_NVTX_VOID(nvtxDomainDestroy, (nvtxDomainHandle_t domain))
SUNSTONE_NVTX(nvtxStringHandle_t, nvtxDomainRegisterStringA,
              (nvtxDomainHandle_t domain, const char* string), NULL)
SUNSTONE_NVTX(nvtxStringHandle_t, nvtxDomainRegisterStringW,
              (nvtxDomainHandle_t domain, const wchar_t* string), NULL)
SUNSTONE_NVTX(nvtxResourceHandle_t, nvtxDomainResourceCreate,
              (nvtxDomainHandle_t domain, nvtxResourceAttributes_t* attributes), NULL)
SUNSTONE_NVTX_VOID(nvtxDomainResourceDestroy, (nvtxResourceHandle_t resource))

SUNSTONE_NVTX_VOID(nvtxNameCategoryA, (uint32_t category, const char* name))
SUNSTONE_NVTX_VOID(nvtxNameCategoryW, (uint32_t category, const wchar_t* name))
SUNSTONE_NVTX_VOID(nvtxDomainNameCategoryA,
                   (nvtxDomainHandle_t domain, uint32_t category, const char* name))
SUNSTONE_NVTX_VOID(nvtxDomainNameCategoryW,
                   (nvtxDomainHandle_t domain, uint32_t category, const wchar_t* name))
SUNSTONE_NVTX_VOID(nvtxNameOsThreadA, (uint32_t thread, const char* name))
SUNSTONE_NVTX_VOID(nvtxNameOsThreadW, (uint32_t thread, const wchar_t* name))

#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

#if defined(UNICODE)
#define nvtxMark nvtxMarkW
#define nvtxRangeStart nvtxRangeStartW
#define nvtxRangePush nvtxRangePushW
#define nvtxDomainCreate nvtxDomainCreateW
#define nvtxDomainRegisterString nvtxDomainRegisterStringW
#define nvtxNameCategory nvtxNameCategoryW
#define nvtxDomainNameCategory nvtxDomainNameCategoryW
#define nvtxNameOsThread nvtxNameOsThreadW
#else
#define nvtxMark nvtxMarkA
#define nvtxRangeStart nvtxRangeStartA
#define nvtxRangePush nvtxRangePushA
#define nvtxDomainCreate nvtxDomainCreateA
#define nvtxDomainRegisterString nvtxDomainRegisterStringA
#define nvtxNameCategory nvtxNameCategoryA
#define nvtxDomainNameCategory nvtxDomainNameCategoryA
#define nvtxNameOsThread nvtxNameOsThreadA
#endif

#endif
