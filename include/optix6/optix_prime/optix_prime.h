/* SPDX-License-Identifier: Apache-2.0 */
/* OptiX Prime 6.0: rays against triangles, without programs. Link liboptix_prime. docs/prime.md has
   the rules that the functions check. */
#ifndef OPTIX_PRIME_H
#define OPTIX_PRIME_H

#include "optix_prime_declarations.h"

#include <stddef.h>

#define OPTIX_PRIME_VERSION 60000 /* major * 10000 + minor * 100 + micro */

#ifndef RTPAPI
#if defined(_WIN32)
#define RTPAPI __declspec(dllimport)
#else
#define RTPAPI
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef size_t RTPsize;

typedef struct RTPcontext_api* RTPcontext;
typedef struct RTPmodel_api* RTPmodel;
typedef struct RTPquery_api* RTPquery;
typedef struct RTPbufferdesc_api* RTPbufferdesc;
typedef struct CUstream_st* cudaStream_t;

RTPresult RTPAPI rtpContextCreate(RTPcontexttype type, RTPcontext* context);
RTPresult RTPAPI rtpContextSetCudaDeviceNumbers(RTPcontext context, unsigned deviceCount,
                                                const unsigned* deviceNumbers);
RTPresult RTPAPI rtpContextSetCpuThreads(RTPcontext context, unsigned numThreads);
RTPresult RTPAPI rtpContextDestroy(RTPcontext context);
RTPresult RTPAPI rtpContextGetLastErrorString(RTPcontext context, const char** return_string);

RTPresult RTPAPI rtpBufferDescCreate(RTPcontext context, RTPbufferformat format, RTPbuffertype type,
                                     void* buffer, RTPbufferdesc* desc);
RTPresult RTPAPI rtpBufferDescGetContext(RTPbufferdesc desc, RTPcontext* context);
RTPresult RTPAPI rtpBufferDescSetRange(RTPbufferdesc desc, RTPsize begin, RTPsize end);
RTPresult RTPAPI rtpBufferDescSetStride(RTPbufferdesc desc, unsigned strideBytes);
RTPresult RTPAPI rtpBufferDescSetCudaDeviceNumber(RTPbufferdesc desc, unsigned deviceNumber);
RTPresult RTPAPI rtpBufferDescDestroy(RTPbufferdesc desc);

RTPresult RTPAPI rtpModelCreate(RTPcontext context, RTPmodel* model);
RTPresult RTPAPI rtpModelGetContext(RTPmodel model, RTPcontext* context);
RTPresult RTPAPI rtpModelSetTriangles(RTPmodel model, RTPbufferdesc indices,
                                      RTPbufferdesc vertices);
RTPresult RTPAPI rtpModelSetInstances(RTPmodel model, RTPbufferdesc instances,
                                      RTPbufferdesc transforms);
RTPresult RTPAPI rtpModelUpdate(RTPmodel model, unsigned hints);
RTPresult RTPAPI rtpModelFinish(RTPmodel model);
RTPresult RTPAPI rtpModelGetFinished(RTPmodel model, int* isFinished);
RTPresult RTPAPI rtpModelCopy(RTPmodel model, RTPmodel srcModel);
RTPresult RTPAPI rtpModelSetBuilderParameter(RTPmodel model_api, RTPbuilderparam param,
                                             RTPsize size, const void* ptr);
RTPresult RTPAPI rtpModelDestroy(RTPmodel model);

RTPresult RTPAPI rtpQueryCreate(RTPmodel model, RTPquerytype queryType, RTPquery* query);
RTPresult RTPAPI rtpQueryGetContext(RTPquery query, RTPcontext* context);
RTPresult RTPAPI rtpQuerySetRays(RTPquery query, RTPbufferdesc rays);
RTPresult RTPAPI rtpQuerySetHits(RTPquery query, RTPbufferdesc hits);
RTPresult RTPAPI rtpQueryExecute(RTPquery query, unsigned hints);
RTPresult RTPAPI rtpQueryFinish(RTPquery query);
RTPresult RTPAPI rtpQueryGetFinished(RTPquery query, int* isFinished);
RTPresult RTPAPI rtpQuerySetCudaStream(RTPquery query, cudaStream_t stream);
RTPresult RTPAPI rtpQueryDestroy(RTPquery query);

RTPresult RTPAPI rtpHostBufferLock(void* buffer, RTPsize size);
RTPresult RTPAPI rtpHostBufferUnlock(void* buffer);
RTPresult RTPAPI rtpGetErrorString(RTPresult errorCode, const char** errorString);
RTPresult RTPAPI rtpGetVersion(unsigned* version);
RTPresult RTPAPI rtpGetVersionString(const char** versionString);

#ifdef __cplusplus
}
#endif

#endif
