/* SPDX-License-Identifier: Apache-2.0 */
/* Enumerations of OptiX Prime 6.0. */
#ifndef OPTIX_PRIME_DECLARATIONS_H
#define OPTIX_PRIME_DECLARATIONS_H

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    RTP_SUCCESS = 0,
    RTP_ERROR_INVALID_VALUE = 1,
    RTP_ERROR_OUT_OF_MEMORY = 2,
    RTP_ERROR_INVALID_HANDLE = 3,
    RTP_ERROR_NOT_SUPPORTED = 4,
    RTP_ERROR_OBJECT_CREATION_FAILED = 5,
    RTP_ERROR_MEMORY_ALLOCATION_FAILED = 6,
    RTP_ERROR_INVALID_CONTEXT = 7,
    RTP_ERROR_VALIDATION_ERROR = 8,
    RTP_ERROR_INVALID_OPERATION = 9,
    RTP_ERROR_UNKNOWN = 999
} RTPresult;

typedef enum { RTP_CONTEXT_TYPE_CPU = 0x100, RTP_CONTEXT_TYPE_CUDA = 0x101 } RTPcontexttype;

typedef enum {
    RTP_BUFFER_TYPE_HOST = 0x200,
    RTP_BUFFER_TYPE_CUDA_LINEAR = 0x201 /* memory of a CUDA device */
} RTPbuffertype;

/* Elements of buffers. Hits of a ray that misses have t = -1, ids of -1, and u = v = 0. u belongs
   to the triangle's second vertex, v to its third, 1 - u - v to its first. */
typedef enum {
    RTP_BUFFER_FORMAT_INDICES_INT3 = 0x400,          /* int3 */
    RTP_BUFFER_FORMAT_INDICES_INT3_MASK_INT = 0x401, /* int3, int: visibility mask */

    RTP_BUFFER_FORMAT_VERTEX_FLOAT3 = 0x420, /* float3 */
    RTP_BUFFER_FORMAT_VERTEX_FLOAT4 = 0x421, /* float4; the fourth is ignored */

    RTP_BUFFER_FORMAT_RAY_ORIGIN_DIRECTION = 0x440,           /* float3, float3 */
    RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX = 0x441, /* float3, float, float3, float */
    RTP_BUFFER_FORMAT_RAY_ORIGIN_MASK_DIRECTION_TMAX = 0x442, /* float3, int, float3, float */

    RTP_BUFFER_FORMAT_HIT_BITMASK = 0x460, /* a bit for each ray, the lowest first: 1 is a hit */
    RTP_BUFFER_FORMAT_HIT_T = 0x461,       /* float */
    RTP_BUFFER_FORMAT_HIT_T_TRIID = 0x462, /* float, int */
    RTP_BUFFER_FORMAT_HIT_T_TRIID_U_V = 0x463,        /* float, int, float2 */
    RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID = 0x464,     /* float, int, int */
    RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V = 0x465, /* float, int, int, float2 */

    RTP_BUFFER_FORMAT_INSTANCE_MODEL = 0x480, /* RTPmodel */

    RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x4 = 0x490, /* 4 rows of 4 floats; the last row is ignored */
    RTP_BUFFER_FORMAT_TRANSFORM_FLOAT4x3 = 0x491  /* the first 3 of these rows */
} RTPbufferformat;

typedef enum { RTP_QUERY_TYPE_ANY = 0x1000, RTP_QUERY_TYPE_CLOSEST = 0x1001 } RTPquerytype;

/* Hints of models, and of queries, have a common bit in addition to their own. */
typedef enum {
    RTP_MODEL_HINT_NONE = 0x0000,
    RTP_MODEL_HINT_ASYNC = 0x2001,
    RTP_MODEL_HINT_MASK_UPDATE = 0x2002,
    RTP_MODEL_HINT_USER_TRIANGLES_AFTER_COPY_SET = 0x2004
} RTPmodelhint;

typedef enum {
    RTP_QUERY_HINT_NONE = 0x0000,
    RTP_QUERY_HINT_ASYNC = 0x4001,
    RTP_QUERY_HINT_WATERTIGHT = 0x4002
} RTPqueryhint;

typedef enum {
    RTP_BUILDER_PARAM_CHUNK_SIZE = 0x800,          /* RTPsize */
    RTP_BUILDER_PARAM_USE_CALLER_TRIANGLES = 0x801 /* int */
} RTPbuilderparam;

#ifdef __cplusplus
}
#endif

#endif
