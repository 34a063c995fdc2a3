/* SPDX-License-Identifier: Apache-2.0 */
/* Values and types of optix_prime.h against the manual's tables (OptiX 6.0, 8.20 and 8.21), in C.
 */
#include "optix_prime/optix_prime.h"

#define CHECK(name, value) typedef char check_##name[(name) == (value) ? 1 : -1]

CHECK(OPTIX_PRIME_VERSION, 60000);
CHECK(RTP_SUCCESS, 0);
CHECK(RTP_ERROR_INVALID_VALUE, 1);
CHECK(RTP_ERROR_OUT_OF_MEMORY, 2);
CHECK(RTP_ERROR_INVALID_HANDLE, 3);
CHECK(RTP_ERROR_NOT_SUPPORTED, 4);
CHECK(RTP_ERROR_OBJECT_CREATION_FAILED, 5);
CHECK(RTP_ERROR_MEMORY_ALLOCATION_FAILED, 6);
CHECK(RTP_ERROR_INVALID_CONTEXT, 7);
CHECK(RTP_ERROR_VALIDATION_ERROR, 8);
CHECK(RTP_ERROR_INVALID_OPERATION, 9);
CHECK(RTP_ERROR_UNKNOWN, 999);
CHECK(RTP_CONTEXT_TYPE_CPU, 0x100);
CHECK(RTP_CONTEXT_TYPE_CUDA, 0x101);
CHECK(RTP_BUFFER_TYPE_HOST, 0x200);
CHECK(RTP_BUFFER_TYPE_CUDA_LINEAR, 0x201);
CHECK(RTP_BUFFER_FORMAT_INDICES_INT3, 0x400);
CHECK(RTP_BUFFER_FORMAT_INDICES_INT3_MASK_INT, 0x401);
CHECK(RTP_BUFFER_FORMAT_VERTEX_FLOAT3, 0x420);
CHECK(RTP_BUFFER_FORMAT_VERTEX_FLOAT4, 0x421);
CHECK(RTP_BUFFER_FORMAT_RAY_ORIGIN_DIRECTION, 0x440);
CHECK(RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX, 0x441);
CHECK(RTP_BUFFER_FORMAT_RAY_ORIGIN_MASK_DIRECTION_TMAX, 0x442);
CHECK(RTP_BUFFER_FORMAT_HIT_BITMASK, 0x460);
CHECK(RTP_BUFFER_FORMAT_HIT_T, 0x461);
CHECK(RTP_BUFFER_FORMAT_HIT_T_TRIID, 0x462);
CHECK(RTP_BUFFER_FORMAT_HIT_T_TRIID_U_V, 0x463);
CHECK(RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID, 0x464);
CHECK(RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V, 0x465);
CHECK(RTP_BUFFER_FORMAT_INSTANCE_MODEL, 0x480);
CHECK(RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x4, 0x490);
CHECK(RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x3, 0x491);
CHECK(RTP_QUERY_TYPE_ANY, 0x1000);
CHECK(RTP_QUERY_TYPE_CLOSEST, 0x1001);
CHECK(RTP_MODEL_HINT_NONE, 0);
CHECK(RTP_MODEL_HINT_ASYNC, 0x2001);
CHECK(RTP_MODEL_HINT_MASK_UPDATE, 0x2002);
CHECK(RTP_MODEL_HINT_USER_TRIANGLES_AFTER_COPY_SET, 0x2004);
CHECK(RTP_QUERY_HINT_NONE, 0);
CHECK(RTP_QUERY_HINT_ASYNC, 0x4001);
CHECK(RTP_QUERY_HINT_WATERTIGHT, 0x4002);
CHECK(RTP_BUILDER_PARAM_CHUNK_SIZE, 0x800);
CHECK(RTP_BUILDER_PARAM_USE_CALLER_TRIANGLES, 0x801);

/* A call of each function with the manual's types. */
static RTPresult callAll(RTPcontext context, RTPmodel model, RTPquery query, RTPbufferdesc desc,
                         cudaStream_t stream, void* memory) {
    RTPresult result = RTP_SUCCESS;
    const char* text = NULL;
    unsigned number = 0;
    int finished = 0;
    RTPsize size = 8;
#define CALL(call) result = (call) != RTP_SUCCESS ? RTP_ERROR_UNKNOWN : result
    CALL(rtpContextCreate(RTP_CONTEXT_TYPE_CPU, &context));
    CALL(rtpContextSetCudaDeviceNumbers(context, 1, &number));
    CALL(rtpContextSetCpuThreads(context, number));
    CALL(rtpContextGetLastErrorString(context, &text));
    CALL(
        rtpBufferDescCreate(context, RTP_BUFFER_FORMAT_HIT_T, RTP_BUFFER_TYPE_HOST, memory, &desc));
    CALL(rtpBufferDescGetContext(desc, &context));
    CALL(rtpBufferDescSetRange(desc, size, size));
    CALL(rtpBufferDescSetStride(desc, number));
    CALL(rtpBufferDescSetCudaDeviceNumber(desc, number));
    CALL(rtpModelCreate(context, &model));
    CALL(rtpModelGetContext(model, &context));
    CALL(rtpModelSetTriangles(model, desc, desc));
    CALL(rtpModelSetInstances(model, desc, desc));
    CALL(rtpModelUpdate(model, number));
    CALL(rtpModelFinish(model));
    CALL(rtpModelGetFinished(model, &finished));
    CALL(rtpModelCopy(model, model));
    CALL(rtpModelSetBuilderParameter(model, RTP_BUILDER_PARAM_CHUNK_SIZE, size, memory));
    CALL(rtpQueryCreate(model, RTP_QUERY_TYPE_ANY, &query));
    CALL(rtpQueryGetContext(query, &context));
    CALL(rtpQuerySetRays(query, desc));
    CALL(rtpQuerySetHits(query, desc));
    CALL(rtpQueryExecute(query, number));
    CALL(rtpQueryFinish(query));
    CALL(rtpQueryGetFinished(query, &finished));
    CALL(rtpQuerySetCudaStream(query, stream));
    CALL(rtpQueryDestroy(query));
    CALL(rtpModelDestroy(model));
    CALL(rtpBufferDescDestroy(desc));
    CALL(rtpContextDestroy(context));
    CALL(rtpHostBufferLock(memory, size));
    CALL(rtpHostBufferUnlock(memory));
    CALL(rtpGetErrorString(result, &text));
    CALL(rtpGetVersion(&number));
    CALL(rtpGetVersionString(&text));
    return number == OPTIX_PRIME_VERSION ? RTP_SUCCESS : result;
}

int main(void) {
    double memory = 0;
    return callAll(NULL, NULL, NULL, NULL, NULL, &memory) != RTP_SUCCESS;
}
