// SPDX-License-Identifier: Apache-2.0
// OptiX types: constants, handles, and structs whose sizes and offsets are the binary interface
// between an application and the library (checked field by field in tests/headers). Compiles with
// host compilers (C99, C++11) and device compilers, so it includes almost nothing. Read next:
// optix_7_host.h or optix_7_device.h. Source: OptiX API reference 7.4, sections 3.12, 5, 6.7; OptiX
// API reference 7.6, optix_7_host.h; layouts of 7.5 and 7.6 are those of their ABI.
//
// The file serves two versions: in this folder it is OptiX 7.4; ../optix76 includes it as OptiX
// 7.6, whose additions are between SUNSTONE_OPTIX_API lines.
//
// Conventions: CUdeviceptr members are device addresses and may be 0 if marked optional. Strides
// are in bytes; 0 means densely packed elements. Matrices are affine 3x4, row-major.
#ifndef SUNSTONE_OPTIX7_OPTIX_7_TYPES_H
#define SUNSTONE_OPTIX7_OPTIX_7_TYPES_H

#ifndef SUNSTONE_OPTIX_API
#define SUNSTONE_OPTIX_API 70400
#endif

#if !defined(__CUDACC_RTC__)
#include <stddef.h> /* size_t; NVRTC has it built in */
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Scalars and handles (section 3.12.3) ---- */

/** Device address. The same type as in cuda.h, repeated so that this header does not need
    cuda.h. */
#if defined(__cplusplus) || (defined(__STDC_VERSION__) && __STDC_VERSION__ >= 201112L)
typedef unsigned long long CUdeviceptr;
#elif !defined(OPTIX_DONT_INCLUDE_CUDA)
#include <cuda.h> /* C99 has no repeated typedef */
#endif

/** A device as seen by this API; made by optixDeviceContextCreate. */
typedef struct OptixDeviceContext_t* OptixDeviceContext;
/** One compiled PTX text; made by optixModuleCreateFromPTX. */
typedef struct OptixModule_t* OptixModule;
/** The programs of one shader binding table record; made by optixProgramGroupCreate. */
typedef struct OptixProgramGroup_t* OptixProgramGroup;
/** Linked program groups, ready for optixLaunch; made by optixPipelineCreate. */
typedef struct OptixPipeline_t* OptixPipeline;
/** A denoiser; made by optixDenoiserCreate. */
typedef struct OptixDenoiser_t* OptixDenoiser;
/** A piece of module compilation; made by optixModuleCreateFromPTXWithTasks, owned by the
    module. */
typedef struct OptixTask_t* OptixTask;

/** Handle of an acceleration structure or transform on the device; 0 is the null handle (never
    hit). */
typedef unsigned long long OptixTraversableHandle;
/** A mask whose low 8 bits count; a ray meets an instance only if their masks share a bit. */
typedef unsigned int OptixVisibilityMask;

/* ---- Constants (section 3.12.2) ---- */

/** Size in bytes of the opaque first part of a shader binding table record. */
#define OPTIX_SBT_RECORD_HEADER_SIZE ((size_t)32)
/** Alignment in bytes of shader binding table records and strides. */
#define OPTIX_SBT_RECORD_ALIGNMENT 16ull
/** Alignment in bytes of temporary and output buffers of acceleration structures. */
#define OPTIX_ACCEL_BUFFER_BYTE_ALIGNMENT 128ull
/** Alignment in bytes of OptixInstance in device memory. */
#define OPTIX_INSTANCE_BYTE_ALIGNMENT 16ull
/** Alignment in bytes of OptixAabb buffers and their stride. */
#define OPTIX_AABB_BUFFER_BYTE_ALIGNMENT 8ull
/** Alignment in bytes of OptixBuildInputTriangleArray::preTransform. */
#define OPTIX_GEOMETRY_TRANSFORM_BYTE_ALIGNMENT 16ull
/** Alignment in bytes of static and motion transforms in device memory. */
#define OPTIX_TRANSFORM_BYTE_ALIGNMENT 64ull
/** OptixModuleCompileOptions::maxRegisterCount for "no limit". */
#define OPTIX_COMPILE_DEFAULT_MAX_REGISTER_COUNT 0
/** Largest number of payload types of a module. */
#define OPTIX_COMPILE_DEFAULT_MAX_PAYLOAD_TYPE_COUNT 8
/** Largest number of 32-bit words of a payload. */
#define OPTIX_COMPILE_DEFAULT_MAX_PAYLOAD_VALUE_COUNT 32
#if SUNSTONE_OPTIX_API >= 70600
/** Alignment in bytes of opacity micromap arrays and of the input of their builds. */
#define OPTIX_OPACITY_MICROMAP_ARRAY_BUFFER_BYTE_ALIGNMENT 128ull
/** Alignment in bytes of OptixOpacityMicromapDesc buffers and their stride. */
#define OPTIX_OPACITY_MICROMAP_DESC_BUFFER_BYTE_ALIGNMENT 8ull
/** Largest number of subdivision levels of an opacity micromap: it has 4^level micro-triangles. */
#define OPTIX_OPACITY_MICROMAP_MAX_SUBDIVISION_LEVEL 12
/** State of a micro-triangle: rays pass. */
#define OPTIX_OPACITY_MICROMAP_STATE_TRANSPARENT (0)
/** State of a micro-triangle: hit, and the any-hit program does not run. */
#define OPTIX_OPACITY_MICROMAP_STATE_OPAQUE (1)
/** State of a micro-triangle: the any-hit program decides; transparent in two-state mode. */
#define OPTIX_OPACITY_MICROMAP_STATE_UNKNOWN_TRANSPARENT (2)
/** State of a micro-triangle: the any-hit program decides; opaque in two-state mode. */
#define OPTIX_OPACITY_MICROMAP_STATE_UNKNOWN_OPAQUE (3)
/** Indices for a micromap with one state everywhere; they use no array entry. */
#define OPTIX_OPACITY_MICROMAP_PREDEFINED_INDEX_FULLY_TRANSPARENT (-1)
#define OPTIX_OPACITY_MICROMAP_PREDEFINED_INDEX_FULLY_OPAQUE (-2)
#define OPTIX_OPACITY_MICROMAP_PREDEFINED_INDEX_FULLY_UNKNOWN_TRANSPARENT (-3)
#define OPTIX_OPACITY_MICROMAP_PREDEFINED_INDEX_FULLY_UNKNOWN_OPAQUE (-4)
#endif

/* ---- Enumerations (section 3.12.4) ---- */

/** Result of each host function; any value except OPTIX_SUCCESS is an error, never a warning. */
typedef enum OptixResult {
    OPTIX_SUCCESS = 0,
    OPTIX_ERROR_INVALID_VALUE = 7001,               /**< bad argument */
    OPTIX_ERROR_HOST_OUT_OF_MEMORY = 7002,          /**< heap exhausted */
    OPTIX_ERROR_INVALID_OPERATION = 7003,           /**< object in the wrong state */
    OPTIX_ERROR_FILE_IO_ERROR = 7004,               /**< reading or writing a file failed */
    OPTIX_ERROR_INVALID_FILE_FORMAT = 7005,         /**< data has a wrong format */
    OPTIX_ERROR_DISK_CACHE_INVALID_PATH = 7010,     /**< cache location cannot be used */
    OPTIX_ERROR_DISK_CACHE_PERMISSION_ERROR = 7011, /**< no right to use the cache location */
    OPTIX_ERROR_DISK_CACHE_DATABASE_ERROR = 7012,   /**< cache database failed */
    OPTIX_ERROR_DISK_CACHE_INVALID_DATA = 7013,     /**< cache content damaged */
    OPTIX_ERROR_LAUNCH_FAILURE = 7050,              /**< launch could not be run */
    OPTIX_ERROR_INVALID_DEVICE_CONTEXT = 7051,      /**< context is null or not a live one */
    OPTIX_ERROR_CUDA_NOT_INITIALIZED = 7052,        /**< no CUDA context is current */
    OPTIX_ERROR_VALIDATION_FAILURE = 7053,          /**< validation mode found a fault */
    OPTIX_ERROR_INVALID_PTX = 7200,                 /**< program text is faulty; see the log */
    OPTIX_ERROR_INVALID_LAUNCH_PARAMETER = 7201,    /**< launch parameter variable is unusable */
    OPTIX_ERROR_INVALID_PAYLOAD_ACCESS = 7202,      /**< payload word does not exist or is barred */
    OPTIX_ERROR_INVALID_ATTRIBUTE_ACCESS = 7203,    /**< attribute word does not exist */
    OPTIX_ERROR_INVALID_FUNCTION_USE = 7204,        /**< device function in a wrong program type */
    OPTIX_ERROR_INVALID_FUNCTION_ARGUMENTS = 7205,  /**< device function with bad constants */
    OPTIX_ERROR_PIPELINE_OUT_OF_CONSTANT_MEMORY = 7250, /**< more constants than the device has */
    OPTIX_ERROR_PIPELINE_LINK_ERROR = 7251,             /**< symbols or options do not fit */
    OPTIX_ERROR_ILLEGAL_DURING_TASK_EXECUTE = 7270,     /**< module busy in optixTaskExecute */
    OPTIX_ERROR_INTERNAL_COMPILER_ERROR = 7299,         /**< fault of the compiler itself */
    OPTIX_ERROR_DENOISER_MODEL_NOT_SET = 7300,          /**< denoiser without a model */
    OPTIX_ERROR_DENOISER_NOT_INITIALIZED = 7301,        /**< denoiser used before its setup */
#if SUNSTONE_OPTIX_API >= 70600
    OPTIX_ERROR_NOT_COMPATIBLE = 7400, /**< structure or micromap array of another device */
#else
    OPTIX_ERROR_ACCEL_NOT_COMPATIBLE = 7400, /**< structure does not fit this context */
#endif
    OPTIX_ERROR_PAYLOAD_TYPE_MISMATCH = 7500, /**< program lacks the group's payload type */
    OPTIX_ERROR_PAYLOAD_TYPE_RESOLUTION_FAILED = 7501, /**< no or several payload types possible */
    OPTIX_ERROR_PAYLOAD_TYPE_ID_INVALID = 7502,        /**< payload type the module does not have */
    OPTIX_ERROR_NOT_SUPPORTED = 7800,                  /**< not available in this library */
    OPTIX_ERROR_UNSUPPORTED_ABI_VERSION = 7801,        /**< library does not know these headers */
    OPTIX_ERROR_FUNCTION_TABLE_SIZE_MISMATCH = 7802,   /**< table size differs from the ABI's */
    OPTIX_ERROR_INVALID_ENTRY_FUNCTION_OPTIONS = 7803, /**< options given to the entry function */
    OPTIX_ERROR_LIBRARY_NOT_FOUND = 7804,              /**< stubs found no library to load */
    OPTIX_ERROR_ENTRY_SYMBOL_NOT_FOUND = 7805,         /**< library lacks optixQueryFunctionTable */
    OPTIX_ERROR_LIBRARY_UNLOAD_FAILURE = 7806,         /**< library could not be unloaded */
#if SUNSTONE_OPTIX_API >= 70600
    OPTIX_ERROR_DEVICE_OUT_OF_MEMORY = 7807, /**< device memory exhausted */
#endif
    OPTIX_ERROR_CUDA_ERROR = 7900,     /**< a CUDA call failed */
    OPTIX_ERROR_INTERNAL_ERROR = 7990, /**< fault of the library itself */
    OPTIX_ERROR_UNKNOWN = 7999         /**< anything else */
} OptixResult;

/** Properties for optixDeviceContextGetProperty; each value is one unsigned int. */
typedef enum OptixDeviceProperty {
    /** Largest OptixPipelineLinkOptions::maxTraceDepth. */
    OPTIX_DEVICE_PROPERTY_LIMIT_MAX_TRACE_DEPTH = 0x2001,
    /** Largest maxTraversableGraphDepth of optixPipelineSetStackSize. */
    OPTIX_DEVICE_PROPERTY_LIMIT_MAX_TRAVERSABLE_GRAPH_DEPTH = 0x2002,
    /** Largest number of primitives of a geometry structure, summed over its build inputs. */
    OPTIX_DEVICE_PROPERTY_LIMIT_MAX_PRIMITIVES_PER_GAS = 0x2003,
    /** Largest number of instances of an instance structure. */
    OPTIX_DEVICE_PROPERTY_LIMIT_MAX_INSTANCES_PER_IAS = 0x2004,
    /** Version of ray tracing hardware times 10; 0 without any. */
    OPTIX_DEVICE_PROPERTY_RTCORE_VERSION = 0x2005,
    /** Largest OptixInstance::instanceId. */
    OPTIX_DEVICE_PROPERTY_LIMIT_MAX_INSTANCE_ID = 0x2006,
    /** Number of bits in use in OptixInstance::visibilityMask; the others must be 0. */
    OPTIX_DEVICE_PROPERTY_LIMIT_NUM_BITS_INSTANCE_VISIBILITY_MASK = 0x2007,
    /** Largest number of shader binding table records of a geometry structure. */
    OPTIX_DEVICE_PROPERTY_LIMIT_MAX_SBT_RECORDS_PER_GAS = 0x2008,
    /** Largest OptixInstance::sbtOffset. */
    OPTIX_DEVICE_PROPERTY_LIMIT_MAX_SBT_OFFSET = 0x2009
} OptixDeviceProperty;

/** Extra run-time checks of a context; slow, for development. */
typedef enum OptixDeviceContextValidationMode {
    OPTIX_DEVICE_CONTEXT_VALIDATION_MODE_OFF = 0,
    OPTIX_DEVICE_CONTEXT_VALIDATION_MODE_ALL = 0xFFFFFFFF
} OptixDeviceContextValidationMode;

/** Bits of the flags of triangles, custom primitives and curves. */
typedef enum OptixGeometryFlags {
    OPTIX_GEOMETRY_FLAG_NONE = 0,
    /** Any-hit programs do not run, unless instance or ray flags enforce them. */
    OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT = 1u << 0,
    /** Exactly one any-hit call for each primitive hit; otherwise possibly several. */
    OPTIX_GEOMETRY_FLAG_REQUIRE_SINGLE_ANYHIT_CALL = 1u << 1,
#if SUNSTONE_OPTIX_API >= 70600
    /** Face culling flags of rays have no effect on these triangles. */
    OPTIX_GEOMETRY_FLAG_DISABLE_TRIANGLE_FACE_CULLING = 1u << 2
#endif
} OptixGeometryFlags;

/** Hit kinds of triangles. Prefer optixGetPrimitiveType, optixIsFrontFaceHit, optixIsBackFaceHit.
 */
typedef enum OptixHitKind {
    OPTIX_HIT_KIND_TRIANGLE_FRONT_FACE = 0xFE,
    OPTIX_HIT_KIND_TRIANGLE_BACK_FACE = 0xFF
} OptixHitKind;

/** Layout of triangle vertex indices. */
typedef enum OptixIndicesFormat {
    OPTIX_INDICES_FORMAT_NONE = 0, /**< no indices: each 3 vertices are a triangle */
    OPTIX_INDICES_FORMAT_UNSIGNED_SHORT3 = 0x2102, /**< three 16-bit indices, 2-byte aligned */
    OPTIX_INDICES_FORMAT_UNSIGNED_INT3 = 0x2103    /**< three 32-bit indices, 4-byte aligned */
} OptixIndicesFormat;

/** Layout of triangle vertices; two-component formats lie in the plane z = 0. */
typedef enum OptixVertexFormat {
    OPTIX_VERTEX_FORMAT_NONE = 0,
    OPTIX_VERTEX_FORMAT_FLOAT3 = 0x2121,
    OPTIX_VERTEX_FORMAT_FLOAT2 = 0x2122,
    OPTIX_VERTEX_FORMAT_HALF3 = 0x2123,
    OPTIX_VERTEX_FORMAT_HALF2 = 0x2124,
    OPTIX_VERTEX_FORMAT_SNORM16_3 = 0x2125, /**< three 16-bit signed normalised numbers */
    OPTIX_VERTEX_FORMAT_SNORM16_2 = 0x2126  /**< two of them */
} OptixVertexFormat;

/** Layout of OptixBuildInputTriangleArray::preTransform. */
typedef enum OptixTransformFormat {
    OPTIX_TRANSFORM_FORMAT_NONE = 0,
    OPTIX_TRANSFORM_FORMAT_MATRIX_FLOAT12 = 0x21E1 /**< 12 floats, a 3x4 row-major matrix */
} OptixTransformFormat;

#if SUNSTONE_OPTIX_API >= 70600
/** How triangles select their micromap in the array; see OptixBuildInputOpacityMicromap. */
typedef enum OptixOpacityMicromapArrayIndexingMode {
    OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_NONE = 0,   /**< no micromaps */
    OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_LINEAR = 1, /**< triangle i has micromap i */
    OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_INDEXED = 2 /**< by indexBuffer */
} OptixOpacityMicromapArrayIndexingMode;

/** Storage of a micro-triangle of an opacity micromap. Each map starts at a byte; its
    micro-triangles follow one another from the least significant bit. */
typedef enum OptixOpacityMicromapFormat {
    OPTIX_OPACITY_MICROMAP_FORMAT_NONE = 0,    /**< not a format */
    OPTIX_OPACITY_MICROMAP_FORMAT_2_STATE = 1, /**< one bit: transparent or opaque */
    OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE = 2  /**< two bits: OPTIX_OPACITY_MICROMAP_STATE_... */
} OptixOpacityMicromapFormat;

/** Bits of OptixOpacityMicromapArrayBuildInput::flags; the two exclude one another. */
typedef enum OptixOpacityMicromapFlags {
    OPTIX_OPACITY_MICROMAP_FLAG_NONE = 0,
    OPTIX_OPACITY_MICROMAP_FLAG_PREFER_FAST_TRACE = 1 << 0,
    OPTIX_OPACITY_MICROMAP_FLAG_PREFER_FAST_BUILD = 1 << 1
} OptixOpacityMicromapFlags;

#endif
/** Kinds of primitives. Curves have circular cross-sections. */
typedef enum OptixPrimitiveType {
    OPTIX_PRIMITIVE_TYPE_CUSTOM = 0x2500,
    OPTIX_PRIMITIVE_TYPE_ROUND_QUADRATIC_BSPLINE = 0x2501,
    OPTIX_PRIMITIVE_TYPE_ROUND_CUBIC_BSPLINE = 0x2502,
    OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR = 0x2503,
    OPTIX_PRIMITIVE_TYPE_ROUND_CATMULLROM = 0x2504,
#if SUNSTONE_OPTIX_API >= 70600
    OPTIX_PRIMITIVE_TYPE_SPHERE = 0x2506,
#endif
    OPTIX_PRIMITIVE_TYPE_TRIANGLE = 0x2531
} OptixPrimitiveType;

/** Bits of OptixPipelineCompileOptions::usesPrimitiveTypeFlags. Compare as unsigned: bit 31 is in
 * use. */
typedef enum OptixPrimitiveTypeFlags {
    OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM = 1 << 0,
    OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_QUADRATIC_BSPLINE = 1 << 1,
    OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_CUBIC_BSPLINE = 1 << 2,
    OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_LINEAR = 1 << 3,
    OPTIX_PRIMITIVE_TYPE_FLAGS_ROUND_CATMULLROM = 1 << 4,
#if SUNSTONE_OPTIX_API >= 70600
    OPTIX_PRIMITIVE_TYPE_FLAGS_SPHERE = 1 << 6,
#endif
    OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE = 1 << 31
} OptixPrimitiveTypeFlags;

/** End caps of curves. */
typedef enum OptixCurveEndcapFlags {
    OPTIX_CURVE_ENDCAP_DEFAULT = 0, /**< round for linear curves, open for the others */
    OPTIX_CURVE_ENDCAP_ON = 1 << 0  /**< flat at both ends; not for linear curves */
} OptixCurveEndcapFlags;

/** The member of the union in OptixBuildInput that holds the input. */
typedef enum OptixBuildInputType {
    OPTIX_BUILD_INPUT_TYPE_TRIANGLES = 0x2141,         /**< OptixBuildInputTriangleArray */
    OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES = 0x2142, /**< OptixBuildInputCustomPrimitiveArray */
    OPTIX_BUILD_INPUT_TYPE_INSTANCES = 0x2143,         /**< OptixBuildInputInstanceArray */
    OPTIX_BUILD_INPUT_TYPE_INSTANCE_POINTERS = 0x2144, /**< the same, as an array of pointers */
    OPTIX_BUILD_INPUT_TYPE_CURVES = 0x2145,            /**< OptixBuildInputCurveArray */
#if SUNSTONE_OPTIX_API >= 70600
    OPTIX_BUILD_INPUT_TYPE_SPHERES = 0x2146 /**< OptixBuildInputSphereArray */
#endif
} OptixBuildInputType;

/** Bits of OptixInstance::flags. */
typedef enum OptixInstanceFlags {
    OPTIX_INSTANCE_FLAG_NONE = 0,
    /** Face culling flags of rays have no effect on this instance. */
    OPTIX_INSTANCE_FLAG_DISABLE_TRIANGLE_FACE_CULLING = 1u << 0,
    /** Swaps front and back of triangles, for culling and for the reported face. */
    OPTIX_INSTANCE_FLAG_FLIP_TRIANGLE_FACING = 1u << 1,
    /** Any-hit programs do not run, unless the ray enforces them; not with ENFORCE_ANYHIT. */
    OPTIX_INSTANCE_FLAG_DISABLE_ANYHIT = 1u << 2,
    /** Any-hit programs run despite geometry flags, unless the ray disables them. */
    OPTIX_INSTANCE_FLAG_ENFORCE_ANYHIT = 1u << 3,
#if SUNSTONE_OPTIX_API >= 70600
    /** Opacity micromaps have two states only, as with
        OPTIX_RAY_FLAG_FORCE_OPACITY_MICROMAP_2_STATE. */
    OPTIX_INSTANCE_FLAG_FORCE_OPACITY_MICROMAP_2_STATE = 1u << 4,
    /** Opacity micromaps are ignored. Needs ALLOW_DISABLE_OPACITY_MICROMAPS in the geometry
        structure; takes precedence over the flag above. */
    OPTIX_INSTANCE_FLAG_DISABLE_OPACITY_MICROMAPS = 1u << 5
#endif
} OptixInstanceFlags;

/** Bits of OptixAccelBuildOptions::buildFlags. */
typedef enum OptixBuildFlags {
    OPTIX_BUILD_FLAG_NONE = 0,
    OPTIX_BUILD_FLAG_ALLOW_UPDATE = 1u << 0,     /**< may be updated with new positions later */
    OPTIX_BUILD_FLAG_ALLOW_COMPACTION = 1u << 1, /**< may be given to optixAccelCompact */
    OPTIX_BUILD_FLAG_PREFER_FAST_TRACE = 1u << 2,
    OPTIX_BUILD_FLAG_PREFER_FAST_BUILD = 1u << 3, /**< not with PREFER_FAST_TRACE */
    /** Device code may read vertices back (optixGetTriangleVertexData and the like). */
    OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS = 1u << 4,
    /** Device code may look up instances (optixGetInstanceTraversableFromIAS). */
    OPTIX_BUILD_FLAG_ALLOW_RANDOM_INSTANCE_ACCESS = 1u << 5,
#if SUNSTONE_OPTIX_API >= 70600
    /** Updates may change micromap arrays and indices; without it they must stay unchanged. */
    OPTIX_BUILD_FLAG_ALLOW_OPACITY_MICROMAP_UPDATE = 1u << 6,
    /** Instances may have OPTIX_INSTANCE_FLAG_DISABLE_OPACITY_MICROMAPS. */
    OPTIX_BUILD_FLAG_ALLOW_DISABLE_OPACITY_MICROMAPS = 1u << 7
#endif
} OptixBuildFlags;

/** The operation of optixAccelBuild. */
typedef enum OptixBuildOperation {
    OPTIX_BUILD_OPERATION_BUILD = 0x2161,
    /** Fits an earlier build in the output buffer to new positions; needs ALLOW_UPDATE. */
    OPTIX_BUILD_OPERATION_UPDATE = 0x2162
} OptixBuildOperation;

/** Bits of OptixMotionOptions::flags. Without them the first and last keys extend beyond the
    range. */
typedef enum OptixMotionFlags {
    OPTIX_MOTION_FLAG_NONE = 0,
    OPTIX_MOTION_FLAG_START_VANISH = 1u << 0, /**< absent before timeBegin */
    OPTIX_MOTION_FLAG_END_VANISH = 1u << 1    /**< absent after timeEnd */
} OptixMotionFlags;

/** Properties that a build can emit; see OptixAccelEmitDesc. */
typedef enum OptixAccelPropertyType {
    OPTIX_PROPERTY_TYPE_COMPACTED_SIZE = 0x2181, /**< one 64-bit size in bytes */
    OPTIX_PROPERTY_TYPE_AABBS = 0x2182           /**< one OptixAabb per motion key */
} OptixAccelPropertyType;

/** The object at the address given to optixConvertPointerToTraversableHandle. */
typedef enum OptixTraversableType {
    OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM = 0x21C1,        /**< OptixStaticTransform */
    OPTIX_TRAVERSABLE_TYPE_MATRIX_MOTION_TRANSFORM = 0x21C2, /**< OptixMatrixMotionTransform */
    OPTIX_TRAVERSABLE_TYPE_SRT_MOTION_TRANSFORM = 0x21C3     /**< OptixSRTMotionTransform */
} OptixTraversableType;

/** Pixel formats of denoiser images. */
typedef enum OptixPixelFormat {
    OPTIX_PIXEL_FORMAT_HALF2 = 0x2207, /**< two halves, XY */
    OPTIX_PIXEL_FORMAT_HALF3 = 0x2201, /**< three halves, RGB */
    OPTIX_PIXEL_FORMAT_HALF4 = 0x2202, /**< four halves, RGBA */
    OPTIX_PIXEL_FORMAT_FLOAT2 = 0x2208,
    OPTIX_PIXEL_FORMAT_FLOAT3 = 0x2203,
    OPTIX_PIXEL_FORMAT_FLOAT4 = 0x2204,
    OPTIX_PIXEL_FORMAT_UCHAR3 = 0x2205, /**< three bytes, RGB */
    OPTIX_PIXEL_FORMAT_UCHAR4 = 0x2206, /**< four bytes, RGBA */
#if SUNSTONE_OPTIX_API >= 70600
    /** The denoiser's own format: internalGuideLayerPixelSizeInBytes (OptixDenoiserSizes) per
        pixel. */
    OPTIX_PIXEL_FORMAT_INTERNAL_GUIDE_LAYER = 0x2209
#endif
} OptixPixelFormat;

/** Built-in denoiser models. AOV models take further layers besides the beauty image. */
typedef enum OptixDenoiserModelKind {
    OPTIX_DENOISER_MODEL_KIND_LDR = 0x2322, /**< low dynamic range */
    OPTIX_DENOISER_MODEL_KIND_HDR = 0x2323, /**< high dynamic range */
    OPTIX_DENOISER_MODEL_KIND_AOV = 0x2324,
    OPTIX_DENOISER_MODEL_KIND_TEMPORAL = 0x2325, /**< stable over the frames of a sequence */
    OPTIX_DENOISER_MODEL_KIND_TEMPORAL_AOV = 0x2326,
#if SUNSTONE_OPTIX_API >= 70600
    OPTIX_DENOISER_MODEL_KIND_UPSCALE2X = 0x2327,         /**< output twice as wide and high */
    OPTIX_DENOISER_MODEL_KIND_TEMPORAL_UPSCALE2X = 0x2328 /**< both */
#endif
} OptixDenoiserModelKind;

#if SUNSTONE_OPTIX_API >= 70600
/** Treatment of the alpha channel; see OptixDenoiserParams::denoiseAlpha. */
typedef enum OptixDenoiserAlphaMode {
    OPTIX_DENOISER_ALPHA_MODE_COPY = 0,         /**< as in the input */
    OPTIX_DENOISER_ALPHA_MODE_ALPHA_AS_AOV = 1, /**< denoised separately, in AOV models as AOV */
    OPTIX_DENOISER_ALPHA_MODE_FULL_DENOISE_PASS = 2 /**< AOV models: a full pass */
} OptixDenoiserAlphaMode;
#endif

/** Bits of the rayFlags of optixTrace. The four any-hit flags exclude one another, and so do the
    two face culling flags. */
typedef enum OptixRayFlags {
    OPTIX_RAY_FLAG_NONE = 0u,
    OPTIX_RAY_FLAG_DISABLE_ANYHIT = 1u << 0,         /**< overrides instance and geometry flags */
    OPTIX_RAY_FLAG_ENFORCE_ANYHIT = 1u << 1,         /**< overrides instance and geometry flags */
    OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT = 1u << 2, /**< first accepted hit ends traversal */
    OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT = 1u << 3,     /**< a miss program still runs */
    OPTIX_RAY_FLAG_CULL_BACK_FACING_TRIANGLES = 1u << 4,
    OPTIX_RAY_FLAG_CULL_FRONT_FACING_TRIANGLES = 1u << 5,
    OPTIX_RAY_FLAG_CULL_DISABLED_ANYHIT = 1u << 6, /**< skip geometry whose any-hit is disabled */
    OPTIX_RAY_FLAG_CULL_ENFORCED_ANYHIT = 1u << 7, /**< skip geometry whose any-hit is enabled */
#if SUNSTONE_OPTIX_API >= 70600
    /** Unknown states of opacity micromaps become transparent or opaque, according to their
        names. */
    OPTIX_RAY_FLAG_FORCE_OPACITY_MICROMAP_2_STATE = 1u << 10
#endif
} OptixRayFlags;

/** Kind of a handle of the transform list; see optixGetTransformTypeFromHandle. */
typedef enum OptixTransformType {
    OPTIX_TRANSFORM_TYPE_NONE = 0, /**< no transform */
    OPTIX_TRANSFORM_TYPE_STATIC_TRANSFORM = 1,
    OPTIX_TRANSFORM_TYPE_MATRIX_MOTION_TRANSFORM = 2,
    OPTIX_TRANSFORM_TYPE_SRT_MOTION_TRANSFORM = 3,
    OPTIX_TRANSFORM_TYPE_INSTANCE = 4
} OptixTransformType;

/** Graphs that a pipeline may traverse; fewer are faster. */
typedef enum OptixTraversableGraphFlags {
    OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY = 0, /**< all graphs; not with other flags */
    /** A geometry structure alone. */
    OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS = 1u << 0,
    /** One instance structure directly above geometry structures. */
    OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING = 1u << 1
} OptixTraversableGraphFlags;

/** Optimisation of a module. */
typedef enum OptixCompileOptimizationLevel {
    OPTIX_COMPILE_OPTIMIZATION_DEFAULT = 0,      /**< as LEVEL_3 */
    OPTIX_COMPILE_OPTIMIZATION_LEVEL_0 = 0x2340, /**< none */
    OPTIX_COMPILE_OPTIMIZATION_LEVEL_1 = 0x2341,
    OPTIX_COMPILE_OPTIMIZATION_LEVEL_2 = 0x2342,
    OPTIX_COMPILE_OPTIMIZATION_LEVEL_3 = 0x2343 /**< all */
} OptixCompileOptimizationLevel;

/** Debug information of a module or pipeline. The numbers are not in order of severity. */
typedef enum OptixCompileDebugLevel {
    OPTIX_COMPILE_DEBUG_LEVEL_DEFAULT = 0, /**< as MINIMAL */
    OPTIX_COMPILE_DEBUG_LEVEL_NONE = 0x2350,
    OPTIX_COMPILE_DEBUG_LEVEL_MINIMAL = 0x2351,  /**< information without a cost in speed */
    OPTIX_COMPILE_DEBUG_LEVEL_MODERATE = 0x2353, /**< some, at a slight cost */
    OPTIX_COMPILE_DEBUG_LEVEL_FULL = 0x2352
} OptixCompileDebugLevel;

/** Progress of a module compiled with tasks; see optixModuleGetCompilationState. */
typedef enum OptixModuleCompileState {
    OPTIX_MODULE_COMPILE_STATE_NOT_STARTED = 0x2360, /**< no task has run */
    OPTIX_MODULE_COMPILE_STATE_STARTED = 0x2361,     /**< some tasks are left, none has failed */
    OPTIX_MODULE_COMPILE_STATE_IMPENDING_FAILURE = 0x2362, /**< tasks are left, one has failed */
    OPTIX_MODULE_COMPILE_STATE_FAILED = 0x2363,            /**< all done, one has failed */
    OPTIX_MODULE_COMPILE_STATE_COMPLETED = 0x2364          /**< all done, module ready for use */
} OptixModuleCompileState;

/** Payload types of a module: bit i stands for OptixModuleCompileOptions::payloadTypes[i]. */
typedef enum OptixPayloadTypeID {
    OPTIX_PAYLOAD_TYPE_DEFAULT = 0, /**< the only type of a module */
    OPTIX_PAYLOAD_TYPE_ID_0 = 1 << 0,
    OPTIX_PAYLOAD_TYPE_ID_1 = 1 << 1,
    OPTIX_PAYLOAD_TYPE_ID_2 = 1 << 2,
    OPTIX_PAYLOAD_TYPE_ID_3 = 1 << 3,
    OPTIX_PAYLOAD_TYPE_ID_4 = 1 << 4,
    OPTIX_PAYLOAD_TYPE_ID_5 = 1 << 5,
    OPTIX_PAYLOAD_TYPE_ID_6 = 1 << 6,
    OPTIX_PAYLOAD_TYPE_ID_7 = 1 << 7
} OptixPayloadTypeID;

/** Read and write access to one payload word: a pair of bits for each program type.
    TRACE_CALLER_WRITE: programs may use the value that the caller passed in; TRACE_CALLER_READ: the
    caller may use the value after the trace. Each word needs a writer, and a reader after it. */
typedef enum OptixPayloadSemantics {
    OPTIX_PAYLOAD_SEMANTICS_TRACE_CALLER_NONE = 0,
    OPTIX_PAYLOAD_SEMANTICS_TRACE_CALLER_READ = 1u << 0,
    OPTIX_PAYLOAD_SEMANTICS_TRACE_CALLER_WRITE = 2u << 0,
    OPTIX_PAYLOAD_SEMANTICS_TRACE_CALLER_READ_WRITE = 3u << 0,
    OPTIX_PAYLOAD_SEMANTICS_CH_NONE = 0,
    OPTIX_PAYLOAD_SEMANTICS_CH_READ = 1u << 2,
    OPTIX_PAYLOAD_SEMANTICS_CH_WRITE = 2u << 2,
    OPTIX_PAYLOAD_SEMANTICS_CH_READ_WRITE = 3u << 2,
    OPTIX_PAYLOAD_SEMANTICS_MS_NONE = 0,
    OPTIX_PAYLOAD_SEMANTICS_MS_READ = 1u << 4,
    OPTIX_PAYLOAD_SEMANTICS_MS_WRITE = 2u << 4,
    OPTIX_PAYLOAD_SEMANTICS_MS_READ_WRITE = 3u << 4,
    OPTIX_PAYLOAD_SEMANTICS_AH_NONE = 0,
    OPTIX_PAYLOAD_SEMANTICS_AH_READ = 1u << 6,
    OPTIX_PAYLOAD_SEMANTICS_AH_WRITE = 2u << 6,
    OPTIX_PAYLOAD_SEMANTICS_AH_READ_WRITE = 3u << 6,
    OPTIX_PAYLOAD_SEMANTICS_IS_NONE = 0,
    OPTIX_PAYLOAD_SEMANTICS_IS_READ = 1u << 8,
    OPTIX_PAYLOAD_SEMANTICS_IS_WRITE = 2u << 8,
    OPTIX_PAYLOAD_SEMANTICS_IS_READ_WRITE = 3u << 8
} OptixPayloadSemantics;

/** The member of the union in OptixProgramGroupDesc that is in use. */
typedef enum OptixProgramGroupKind {
    OPTIX_PROGRAM_GROUP_KIND_RAYGEN = 0x2421,    /**< OptixProgramGroupDesc::raygen */
    OPTIX_PROGRAM_GROUP_KIND_MISS = 0x2422,      /**< OptixProgramGroupDesc::miss */
    OPTIX_PROGRAM_GROUP_KIND_EXCEPTION = 0x2423, /**< OptixProgramGroupDesc::exception */
    OPTIX_PROGRAM_GROUP_KIND_HITGROUP = 0x2424,  /**< OptixProgramGroupDesc::hitgroup */
    OPTIX_PROGRAM_GROUP_KIND_CALLABLES = 0x2425  /**< OptixProgramGroupDesc::callables */
} OptixProgramGroupKind;

/** Bits of OptixProgramGroupDesc::flags; none are defined yet. */
typedef enum OptixProgramGroupFlags { OPTIX_PROGRAM_GROUP_FLAGS_NONE = 0 } OptixProgramGroupFlags;

/** Results of optixGetExceptionCode for exceptions of the library; user exceptions are >= 0. The
    named device functions return details in the exception program. */
typedef enum OptixExceptionCodes {
    OPTIX_EXCEPTION_CODE_STACK_OVERFLOW = -1,
    OPTIX_EXCEPTION_CODE_TRACE_DEPTH_EXCEEDED = -2,
    /** Details: optixGetTransformListSize, optixGetTransformListHandle. */
    OPTIX_EXCEPTION_CODE_TRAVERSAL_DEPTH_EXCEEDED = -3,
    /** Details: the transform list and optixGetExceptionInvalidTraversable. */
    OPTIX_EXCEPTION_CODE_TRAVERSAL_INVALID_TRAVERSABLE = -5,
    /** Miss index not below missRecordCount. Details: optixGetExceptionInvalidSbtOffset. */
    OPTIX_EXCEPTION_CODE_TRAVERSAL_INVALID_MISS_SBT = -6,
    /** Instance offset + GAS index * stride + offset of the trace is not below hitgroupRecordCount.
        Details: the transform list, optixGetExceptionInvalidSbtOffset and optixGetSbtGASIndex. */
    OPTIX_EXCEPTION_CODE_TRAVERSAL_INVALID_HIT_SBT = -7,
    /** A primitive type that usesPrimitiveTypeFlags of the pipeline does not enable. */
    OPTIX_EXCEPTION_CODE_UNSUPPORTED_PRIMITIVE_TYPE = -8,
    /** A float argument of optixTrace is infinite or NaN. Details: optixGetExceptionInvalidRay. */
    OPTIX_EXCEPTION_CODE_INVALID_RAY = -9,
    /** Arguments of a callable do not match. Details: optixGetExceptionParameterMismatch. */
    OPTIX_EXCEPTION_CODE_CALLABLE_PARAMETER_MISMATCH = -10,
    /** The built-in intersection program does not match the geometry structure. */
    OPTIX_EXCEPTION_CODE_BUILTIN_IS_MISMATCH = -11,
    /** Callable index not below the count. Details: optixGetExceptionInvalidSbtOffset. */
    OPTIX_EXCEPTION_CODE_CALLABLE_INVALID_SBT = -12,
    OPTIX_EXCEPTION_CODE_CALLABLE_NO_DC_SBT_RECORD = -13, /**< record has no direct callable */
    OPTIX_EXCEPTION_CODE_CALLABLE_NO_CC_SBT_RECORD = -14, /**< no continuation callable */
    /** Geometry structure traversed alone without ALLOW_SINGLE_GAS. Details: as for -5. */
    OPTIX_EXCEPTION_CODE_UNSUPPORTED_SINGLE_LEVEL_GAS = -15,
    OPTIX_EXCEPTION_CODE_INVALID_VALUE_ARGUMENT_0 = -16, /**< first argument out of range */
    OPTIX_EXCEPTION_CODE_INVALID_VALUE_ARGUMENT_1 = -17, /**< second argument out of range */
    OPTIX_EXCEPTION_CODE_INVALID_VALUE_ARGUMENT_2 = -18, /**< third argument out of range */
    /** Random access to a structure built without the flag for it. */
    OPTIX_EXCEPTION_CODE_UNSUPPORTED_DATA_ACCESS = -32,
    /** The program's payload type differs from that of the trace. */
    OPTIX_EXCEPTION_CODE_PAYLOAD_TYPE_MISMATCH = -33
} OptixExceptionCodes;

/** Bits of OptixPipelineCompileOptions::exceptionFlags. */
typedef enum OptixExceptionFlags {
    OPTIX_EXCEPTION_FLAG_NONE = 0,
    OPTIX_EXCEPTION_FLAG_STACK_OVERFLOW = 1u << 0,
    OPTIX_EXCEPTION_FLAG_TRACE_DEPTH = 1u << 1,
    OPTIX_EXCEPTION_FLAG_USER = 1u << 2, /**< needed in all modules if one throws */
    OPTIX_EXCEPTION_FLAG_DEBUG = 1u << 3 /**< checks of arguments and traversal */
} OptixExceptionFlags;

/** Options of optixQueryFunctionTable; none are defined yet. */
typedef enum OptixQueryFunctionTableOptions {
    OPTIX_QUERY_FUNCTION_TABLE_OPTION_DUMMY = 0 /**< placeholder */
} OptixQueryFunctionTableOptions;

/* ---- Host: library entry, context (sections 3.12.3.39, 3.12.3.64, 5.17) ---- */

/** Receives the messages of a context, from any thread; must be thread-safe. level: 1 fatal, 2
    error, 3 warning, 4 print; higher levels may appear. tag: area of the message. message:
    zero-terminated, without a newline at its end. cbdata: the pointer set with the function. */
typedef void (*OptixLogCallback)(unsigned int level, const char* tag, const char* message,
                                 void* cbdata);

/** Type of optixQueryFunctionTable, the only function that the library exports: fills functionTable
    (sizeOfTable bytes) for clients of ABI abiId. numOptions must be 0; the arrays are unused. */
typedef OptixResult(OptixQueryFunctionTable_t)(int abiId, unsigned int numOptions,
                                               OptixQueryFunctionTableOptions*, const void**,
                                               void* functionTable, size_t sizeOfTable);

/** Options of optixDeviceContextCreate. All zero: no log, no validation. */
typedef struct OptixDeviceContextOptions {
    OptixLogCallback logCallbackFunction; /**< optional */
    void* logCallbackData;                /**< passed to the function */
    int logCallbackLevel;                 /**< messages above this level are not sent */
    OptixDeviceContextValidationMode validationMode;
} OptixDeviceContextOptions;

/* ---- Host: acceleration structures (sections 5.1 to 5.10, 5.20, 5.24) ---- */

/** Motion of a structure or transform: numKeys states at equal distances from timeBegin to timeEnd.
    With numKeys 0 or 1 there is no motion and the other members are ignored. */
typedef struct OptixMotionOptions {
    unsigned short numKeys;
    unsigned short flags; /**< OptixMotionFlags */
    float timeBegin;
    float timeEnd;
} OptixMotionOptions;

#if SUNSTONE_OPTIX_API >= 70600
/** The number of triangles of a build input that use one kind of micromap. */
typedef struct OptixOpacityMicromapUsageCount {
    unsigned int count;
    unsigned int subdivisionLevel;
    OptixOpacityMicromapFormat format;
} OptixOpacityMicromapUsageCount;

/** The opacity micromaps of a triangle build input. The structure refers to the array's memory,
    which must stay valid while the structure is traversed. */
typedef struct OptixBuildInputOpacityMicromap {
    OptixOpacityMicromapArrayIndexingMode indexingMode;
    CUdeviceptr opacityMicromapArray; /**< from optixOpacityMicromapArrayBuild; 0 with mode NONE */
    /** Mode INDEXED: a signed integer for each triangle; negative ones are
        OPTIX_OPACITY_MICROMAP_PREDEFINED_INDEX_... */
    CUdeviceptr indexBuffer;
    unsigned int indexSizeInBytes; /**< 2 or 4; 0 without indexBuffer */
    unsigned int indexStrideInBytes;
    unsigned int indexOffset; /**< added to non-negative indices */
    unsigned int numMicromapUsageCounts;
    const OptixOpacityMicromapUsageCount* micromapUsageCounts; /**< in host memory; kinds add up */
} OptixBuildInputOpacityMicromap;

#endif
/** Triangles. */
typedef struct OptixBuildInputTriangleArray {
    /** Host array of one device address for each motion key (one without motion). */
    const CUdeviceptr* vertexBuffers;
    unsigned int numVertices; /**< in each buffer */
    OptixVertexFormat vertexFormat;
    /** Addresses and stride are multiples of 4 for float formats, else of 2; multiples of 16 are
        fastest. */
    unsigned int vertexStrideInBytes;
    CUdeviceptr indexBuffer;       /**< optional; aligned as its number type */
    unsigned int numIndexTriplets; /**< 0 without indexBuffer */
    OptixIndicesFormat indexFormat;
    unsigned int indexStrideInBytes; /**< from one triangle to the next */
    /** Optional matrix applied to the vertices at build; OPTIX_GEOMETRY_TRANSFORM_BYTE_ALIGNMENT.
     */
    CUdeviceptr preTransform;
    const unsigned int* flags;  /**< host array of OptixGeometryFlags, one for each SBT record */
    unsigned int numSbtRecords; /**< at least 1 */
    /** Optional SBT record of each triangle, each below numSbtRecords. */
    CUdeviceptr sbtIndexOffsetBuffer;
    unsigned int sbtIndexOffsetSizeInBytes; /**< 0, 1, 2 or 4 */
    unsigned int sbtIndexOffsetStrideInBytes;
    unsigned int primitiveIndexOffset;    /**< added to the result of optixGetPrimitiveIndex */
    OptixTransformFormat transformFormat; /**< of preTransform */
#if SUNSTONE_OPTIX_API >= 70600
    OptixBuildInputOpacityMicromap opacityMicromap;
#endif
} OptixBuildInputTriangleArray;

#if SUNSTONE_OPTIX_API >= 70600
/** Spheres. Each is a vertex and a radius; motion keys interpolate both linearly. */
typedef struct OptixBuildInputSphereArray {
    const CUdeviceptr* vertexBuffers; /**< host array, one address of float3 for each motion key */
    unsigned int vertexStrideInBytes;
    unsigned int numVertices;
    const CUdeviceptr* radiusBuffers; /**< the same for radii, floats */
    unsigned int radiusStrideInBytes;
    int singleRadius;           /**< non-zero: each radius buffer has one float for all spheres */
    const unsigned int* flags;  /**< host array of OptixGeometryFlags, one for each SBT record */
    unsigned int numSbtRecords; /**< at least 1 */
    CUdeviceptr sbtIndexOffsetBuffer; /**< as for triangles */
    unsigned int sbtIndexOffsetSizeInBytes;
    unsigned int sbtIndexOffsetStrideInBytes;
    unsigned int primitiveIndexOffset;
} OptixBuildInputSphereArray;

#endif
/** Segments of curves, swept by a circle. A segment of a curve of degree d is given by d+1
    consecutive vertices and widths; widths are radii and follow the same basis. All segments of an
    input use one SBT record. */
typedef struct OptixBuildInputCurveArray {
    OptixPrimitiveType curveType;     /**< degree and basis */
    unsigned int numPrimitives;       /**< segments */
    const CUdeviceptr* vertexBuffers; /**< host array, one address of float3 for each motion key */
    unsigned int numVertices;
    unsigned int vertexStrideInBytes;
    const CUdeviceptr* widthBuffers; /**< the same for widths, one float for each vertex */
    unsigned int widthStrideInBytes;
    const CUdeviceptr* normalBuffers; /**< reserved, 0 */
    unsigned int normalStrideInBytes; /**< reserved, 0 */
    CUdeviceptr indexBuffer;          /**< required: first vertex of each segment, unsigned int */
    unsigned int indexStrideInBytes;
    unsigned int flag; /**< OptixGeometryFlags, one word, not an array */
    unsigned int primitiveIndexOffset;
    unsigned int endcapFlags; /**< OptixCurveEndcapFlags */
} OptixBuildInputCurveArray;

/** Axis-aligned box. Inverted or NaN boxes are never hit. */
typedef struct OptixAabb {
    float minX;
    float minY;
    float minZ;
    float maxX;
    float maxY;
    float maxZ;
} OptixAabb;

/** Primitives of an intersection program, given by their boxes. */
typedef struct OptixBuildInputCustomPrimitiveArray {
    /** Host array of one address of OptixAabb for each motion key (one without motion);
        OPTIX_AABB_BUFFER_BYTE_ALIGNMENT. */
    const CUdeviceptr* aabbBuffers;
    unsigned int numPrimitives; /**< boxes in each buffer */
    unsigned int strideInBytes; /**< a multiple of OPTIX_AABB_BUFFER_BYTE_ALIGNMENT */
    const unsigned int* flags;  /**< host array of OptixGeometryFlags, one for each SBT record */
    unsigned int numSbtRecords; /**< at least 1 */
    CUdeviceptr sbtIndexOffsetBuffer; /**< as for triangles */
    unsigned int sbtIndexOffsetSizeInBytes;
    unsigned int sbtIndexOffsetStrideInBytes;
    unsigned int primitiveIndexOffset;
} OptixBuildInputCustomPrimitiveArray;

/** Instances. */
typedef struct OptixBuildInputInstanceArray {
    /** OptixInstance array, or array of addresses of them, according to OptixBuildInput::type;
        each instance at OPTIX_INSTANCE_BYTE_ALIGNMENT. */
    CUdeviceptr instances;
    unsigned int numInstances;
#if SUNSTONE_OPTIX_API >= 70600
    unsigned int instanceStride; /**< from one to the next; multiple of its alignment */
#endif
} OptixBuildInputInstanceArray;

/** One input of a build. All inputs of a geometry structure have the same type; an instance
    structure has exactly one input. */
typedef struct OptixBuildInput {
    OptixBuildInputType type;
    union {
        OptixBuildInputTriangleArray triangleArray;
        OptixBuildInputCurveArray curveArray;
#if SUNSTONE_OPTIX_API >= 70600
        OptixBuildInputSphereArray sphereArray;
#endif
        OptixBuildInputCustomPrimitiveArray customPrimitiveArray;
        OptixBuildInputInstanceArray instanceArray;
        char pad[1024]; /**< reserved for later versions */
    };
} OptixBuildInput;

/** One use of a traversable; lies in device memory. */
typedef struct OptixInstance {
    float transform[12];         /**< object to world; must be invertible */
    unsigned int instanceId;     /**< chosen by the application, up to the device's limit */
    unsigned int sbtOffset;      /**< added to hit record indices; 0 above instance structures */
    unsigned int visibilityMask; /**< rays whose mask shares no bit miss the instance */
    unsigned int flags;          /**< OptixInstanceFlags */
    OptixTraversableHandle traversableHandle;
    unsigned int pad[2]; /**< makes the size a multiple of the alignment */
} OptixInstance;

/** Options of a build. */
typedef struct OptixAccelBuildOptions {
    unsigned int buildFlags;       /**< OptixBuildFlags */
    OptixBuildOperation operation; /**< an update needs the same number of primitives */
    OptixMotionOptions motionOptions;
} OptixAccelBuildOptions;

/** Results of optixAccelComputeMemoryUsage. */
typedef struct OptixAccelBufferSizes {
    size_t outputSizeInBytes;     /**< of outputBuffer */
    size_t tempSizeInBytes;       /**< of tempBuffer for a build */
    size_t tempUpdateSizeInBytes; /**< of tempBuffer for an update; 0 without ALLOW_UPDATE */
} OptixAccelBufferSizes;

/** Requests that a build writes a property to device memory, in stream order. */
typedef struct OptixAccelEmitDesc {
    CUdeviceptr result;
    OptixAccelPropertyType type;
} OptixAccelEmitDesc;

#if SUNSTONE_OPTIX_API >= 70600
/** Information about a structure or micromap array for its relocation; opaque. */
typedef struct OptixRelocationInfo {
    unsigned long long info[4];
} OptixRelocationInfo;

/** New addresses of the children of a relocated instance structure. */
typedef struct OptixRelocateInputInstanceArray {
    unsigned int numInstances;      /**< as in the build, or 0 */
    CUdeviceptr traversableHandles; /**< device array, numInstances long; 0 keeps the old */
} OptixRelocateInputInstanceArray;

/** New address of the micromap array of a relocated build input. */
typedef struct OptixRelocateInputOpacityMicromap {
    CUdeviceptr opacityMicromapArray; /**< 0 keeps the old one */
} OptixRelocateInputOpacityMicromap;

/** References of a relocated triangle build input. */
typedef struct OptixRelocateInputTriangleArray {
    unsigned int numSbtRecords; /**< as in the build */
    OptixRelocateInputOpacityMicromap opacityMicromap;
} OptixRelocateInputTriangleArray;

/** New addresses for the references of one build input; other input types have no references. */
typedef struct OptixRelocateInput {
    OptixBuildInputType type;
    union {
        OptixRelocateInputInstanceArray instanceArray;
        OptixRelocateInputTriangleArray triangleArray;
    };
} OptixRelocateInput;

/** One opacity micromap of an array; lies in device memory at
    OPTIX_OPACITY_MICROMAP_DESC_BUFFER_BYTE_ALIGNMENT. */
typedef struct OptixOpacityMicromapDesc {
    unsigned int byteOffset;         /**< offset of its first byte in inputBuffer */
    unsigned short subdivisionLevel; /**< at most OPTIX_OPACITY_MICROMAP_MAX_SUBDIVISION_LEVEL */
    unsigned short format;           /**< OptixOpacityMicromapFormat */
} OptixOpacityMicromapDesc;

/** The number of micromaps of one kind in the build of an array; entries of one kind add up. */
typedef struct OptixOpacityMicromapHistogramEntry {
    unsigned int count;
    unsigned int subdivisionLevel;
    OptixOpacityMicromapFormat format;
} OptixOpacityMicromapHistogramEntry;

/** The micromaps of an array. */
typedef struct OptixOpacityMicromapArrayBuildInput {
    unsigned int flags;                /**< OptixOpacityMicromapFlags */
    CUdeviceptr inputBuffer;           /**< the maps; ..._ARRAY_BUFFER_BYTE_ALIGNMENT */
    CUdeviceptr perMicromapDescBuffer; /**< OptixOpacityMicromapDesc, one for each map */
    unsigned int perMicromapDescStrideInBytes;
    unsigned int numMicromapHistogramEntries;
    const OptixOpacityMicromapHistogramEntry* micromapHistogramEntries; /**< in host memory */
} OptixOpacityMicromapArrayBuildInput;

/** Results of optixOpacityMicromapArrayComputeMemoryUsage. */
typedef struct OptixMicromapBufferSizes {
    size_t outputSizeInBytes;
    size_t tempSizeInBytes;
} OptixMicromapBufferSizes;

/** Buffers of a build of a micromap array. */
typedef struct OptixMicromapBuffers {
    CUdeviceptr output; /**< OPTIX_OPACITY_MICROMAP_ARRAY_BUFFER_BYTE_ALIGNMENT */
    size_t outputSizeInBytes;
    CUdeviceptr temp;
    size_t tempSizeInBytes;
} OptixMicromapBuffers;
#else
/** Information about a structure for optixAccelRelocate; opaque. */
typedef struct OptixAccelRelocationInfo {
    unsigned long long info[4];
} OptixAccelRelocationInfo;
#endif

/* ---- Transforms (sections 5.21, 5.34, 5.35, 5.37) ---- */
/* Transforms lie in device memory with alignment OPTIX_TRANSFORM_BYTE_ALIGNMENT and become
   traversables by optixConvertPointerToTraversableHandle. */

/** A fixed transform. */
typedef struct OptixStaticTransform {
    OptixTraversableHandle child;
    unsigned int pad[2];
    float transform[12];    /**< object to world */
    float invTransform[12]; /**< its inverse, provided by the application */
} OptixStaticTransform;

/** Matrices interpolated element by element. For more than two keys allocate
    sizeof(OptixMatrixMotionTransform) + (numKeys - 2) * 12 * sizeof(float) bytes. */
typedef struct OptixMatrixMotionTransform {
    OptixTraversableHandle child;
    OptixMotionOptions motionOptions;
    unsigned int pad[3];
    float transform[2][12]; /**< object to world, numKeys of them */
} OptixMatrixMotionTransform;

/** Scale, rotation, translation: object to world is T * R * S, with
    S = [sx a b pvx; 0 sy c pvy; 0 0 sz pvz], R the rotation of the quaternion
    (qx, qy, qz) = sin(angle/2) * axis, qw = cos(angle/2), and T the translation by (tx, ty, tz). */
typedef struct OptixSRTData {
    float sx;
    float a;
    float b;
    float pvx;
    float sy;
    float c;
    float pvy;
    float sz;
    float pvz;
    float qx;
    float qy;
    float qz;
    float qw;
    float tx;
    float ty;
    float tz;
} OptixSRTData;

/** SRT keys: all 16 numbers are interpolated, then the quaternion is normalised. For more than two
    keys allocate sizeof(OptixSRTMotionTransform) + (numKeys - 2) * sizeof(OptixSRTData) bytes. */
typedef struct OptixSRTMotionTransform {
    OptixTraversableHandle child;
    OptixMotionOptions motionOptions;
    unsigned int pad[3];
    OptixSRTData srtData[2]; /**< numKeys of them */
} OptixSRTMotionTransform;

/* ---- Host: denoiser (sections 5.12 to 5.16, 5.19) ---- */

/** An image in device memory. */
typedef struct OptixImage2D {
    CUdeviceptr data;
    unsigned int width;  /**< in pixels */
    unsigned int height; /**< in pixels */
    unsigned int rowStrideInBytes;
    unsigned int pixelStrideInBytes; /**< 0 or the size of a pixel */
    OptixPixelFormat format;
} OptixImage2D;

/** The guide images that each call provides; non-zero for yes. */
typedef struct OptixDenoiserOptions {
    unsigned int guideAlbedo;
    unsigned int guideNormal;
} OptixDenoiserOptions;

/** Guide images; those not enabled are ignored. */
typedef struct OptixDenoiserGuideLayer {
    OptixImage2D albedo;
    OptixImage2D normal; /**< in camera space for temporal models; else only x and y count */
    OptixImage2D flow;   /**< temporal models: pixels moved since the previous frame */
#if SUNSTONE_OPTIX_API >= 70600
    /** Temporal AOV and upscaling models: outputInternalGuideLayer of the previous frame. */
    OptixImage2D previousOutputInternalGuideLayer;
    OptixImage2D outputInternalGuideLayer; /**< written; for the next frame */
#endif
} OptixDenoiserGuideLayer;

/** One image to denoise. */
typedef struct OptixDenoiserLayer {
    OptixImage2D input;
    OptixImage2D previousOutput; /**< temporal models; may be the same memory as output */
    OptixImage2D output;         /**< may be the same memory as input, but not when upscaling */
} OptixDenoiserLayer;

/** Parameters for denoising one frame. */
typedef struct OptixDenoiserParams {
    unsigned int denoiseAlpha; /**< 0 copy, 1 denoise separately, 2 (AOV models) full pass */
    CUdeviceptr hdrIntensity;  /**< optional: one float of optixDenoiserComputeIntensity */
    float blendFactor;         /**< 0 denoised, 1 input, linear between */
    CUdeviceptr
        hdrAverageColor; /**< optional, AOV models: three floats of ...ComputeAverageColor */
#if SUNSTONE_OPTIX_API >= 70600
    /** Temporal models: 0 in the first frame of a sequence, which has no predecessor. */
    unsigned int temporalModeUsePreviousLayers;
#endif
} OptixDenoiserParams;

/** Results of optixDenoiserComputeMemoryResources. */
typedef struct OptixDenoiserSizes {
    size_t stateSizeInBytes;
    size_t withOverlapScratchSizeInBytes;    /**< scratch for tiles */
    size_t withoutOverlapScratchSizeInBytes; /**< scratch for whole images */
    unsigned int overlapWindowSizeInPixels;  /**< overlap of a tile on each side */
#if SUNSTONE_OPTIX_API >= 70600
    size_t computeAverageColorSizeInBytes; /**< scratch of optixDenoiserComputeAverageColor */
    size_t computeIntensitySizeInBytes;    /**< scratch of optixDenoiserComputeIntensity */
    unsigned int internalGuideLayerPixelSizeInBytes; /**< 0 if the model needs no such layer */
#endif
} OptixDenoiserSizes;

/* ---- Host: modules, program groups, pipelines (sections 5.11, 5.22 to 5.36) ---- */

/** A part of the launch parameters with the same value in all launches. Code is specialised to it
    where possible; the parameters in memory must have the same value. */
typedef struct OptixModuleCompileBoundValueEntry {
    size_t pipelineParamOffsetInBytes;
    size_t sizeInBytes;        /**< not 0; ranges must be disjoint and inside the variable */
    const void* boundValuePtr; /**< the bytes, in host memory */
    const char* annotation;    /**< optional name for the compile log */
} OptixModuleCompileBoundValueEntry;

/** A payload layout. */
typedef struct OptixPayloadType {
    unsigned int numPayloadValues;        /**< 32-bit words, at most 32 */
    const unsigned int* payloadSemantics; /**< host array of OptixPayloadSemantics, one per word */
} OptixPayloadType;

/** Options for compiling one module; modules of a pipeline may differ. */
typedef struct OptixModuleCompileOptions {
    int maxRegisterCount; /**< 0: no limit */
    OptixCompileOptimizationLevel optLevel;
    OptixCompileDebugLevel debugLevel;
    const OptixModuleCompileBoundValueEntry* boundValues;
    unsigned int numBoundValues;
    unsigned int numPayloadTypes; /**< 0 for untyped payloads; then numPayloadValues counts */
    OptixPayloadType* payloadTypes;
} OptixModuleCompileOptions;

/** A single program: ray generation, miss or exception. A miss program may be null. */
typedef struct OptixProgramGroupSingleModule {
    OptixModule module;
    const char* entryFunctionName;
} OptixProgramGroupSingleModule;

/** The programs of a hit; each may be null. */
typedef struct OptixProgramGroupHitgroup {
    OptixModule moduleCH;
    const char* entryFunctionNameCH;
    OptixModule moduleAH;
    const char* entryFunctionNameAH;
    OptixModule moduleIS; /**< with a null name: a module of optixBuiltinISModuleGet */
    const char* entryFunctionNameIS;
} OptixProgramGroupHitgroup;

/** Callables; at least one of the two is needed. */
typedef struct OptixProgramGroupCallables {
    OptixModule moduleDC;
    const char* entryFunctionNameDC;
    OptixModule moduleCC;
    const char* entryFunctionNameCC;
} OptixProgramGroupCallables;

/** A program group to create. */
typedef struct OptixProgramGroupDesc {
    OptixProgramGroupKind kind;
    unsigned int flags; /**< OptixProgramGroupFlags: 0 */
    union {
        OptixProgramGroupSingleModule raygen;
        OptixProgramGroupSingleModule miss;
        OptixProgramGroupSingleModule exception;
        OptixProgramGroupCallables callables;
        OptixProgramGroupHitgroup hitgroup;
    };
} OptixProgramGroupDesc;

/** Options of the groups of one optixProgramGroupCreate call. */
typedef struct OptixProgramGroupOptions {
    /** The payload type of the groups. Null: the only type that all programs of a group support. */
    OptixPayloadType* payloadType;
} OptixProgramGroupOptions;

/** Options that must be equal for a pipeline and all its modules. */
typedef struct OptixPipelineCompileOptions {
    int usesMotionBlur;                 /**< non-zero: motion may occur */
    unsigned int traversableGraphFlags; /**< OptixTraversableGraphFlags */
    int numPayloadValues;               /**< 32-bit words, 0 to 32; 0 with payload types */
    int numAttributeValues;             /**< 32-bit words, 2 to 8; less than 2 means 2 */
    unsigned int exceptionFlags;        /**< OptixExceptionFlags */
    /** Name of the launch parameter variable; null without one. */
    const char* pipelineLaunchParamsVariableName;
    /** OptixPrimitiveTypeFlags; 0 means custom primitives and triangles. */
    unsigned int usesPrimitiveTypeFlags;
#if SUNSTONE_OPTIX_API >= 70600
    int allowOpacityMicromaps; /**< non-zero: rays may meet opacity micromaps */
#endif
} OptixPipelineCompileOptions;

/** Options for linking a pipeline. */
typedef struct OptixPipelineLinkOptions {
    unsigned int maxTraceDepth; /**< nested optixTrace calls, at most 31; 0: no traces */
    OptixCompileDebugLevel debugLevel;
} OptixPipelineLinkOptions;

/** The programs of a launch and their data, in device memory. Addresses and strides are multiples
    of OPTIX_SBT_RECORD_ALIGNMENT. */
typedef struct OptixShaderBindingTable {
    CUdeviceptr raygenRecord;
    CUdeviceptr exceptionRecord; /**< optional */
    CUdeviceptr missRecordBase;
    unsigned int missRecordStrideInBytes;
    unsigned int missRecordCount;
    CUdeviceptr hitgroupRecordBase;
    unsigned int hitgroupRecordStrideInBytes;
    unsigned int hitgroupRecordCount;
    CUdeviceptr callablesRecordBase; /**< optional; then stride and count are not 0 */
    unsigned int callablesRecordStrideInBytes;
    unsigned int callablesRecordCount; /**< 0 without callablesRecordBase */
} OptixShaderBindingTable;

/** Stack use in bytes: css on the continuation stack, dss on the direct stack. */
typedef struct OptixStackSizes {
    unsigned int cssRG; /**< ray generation */
    unsigned int cssMS; /**< miss */
    unsigned int cssCH; /**< closest-hit */
    unsigned int cssAH; /**< any-hit */
    unsigned int cssIS; /**< intersection */
    unsigned int cssCC; /**< continuation callable */
    unsigned int dssDC; /**< direct callable */
} OptixStackSizes;

/** The built-in intersection program to return from optixBuiltinISModuleGet. */
typedef struct OptixBuiltinISOptions {
    OptixPrimitiveType builtinISModuleType; /**< not custom */
    int usesMotionBlur;                     /**< vertex motion; motion transforms are irrelevant */
    unsigned int buildFlags;                /**< as the geometry structure is built */
    unsigned int curveEndcapFlags;          /**< as in the build input; 0 if not curves */
} OptixBuiltinISOptions;

#if defined(__CUDACC__) || defined(__CUDA__)

/* ---- Device: exception details (sections 3.1.2.23, 3.1.2.27) ---- */

/** The ray that raised OPTIX_EXCEPTION_CODE_INVALID_RAY; all zero for other exceptions. */
typedef struct OptixInvalidRayExceptionDetails {
    float3 origin;
    float3 direction;
    float tmin;
    float tmax;
    float time; /**< 0 without motion */
} OptixInvalidRayExceptionDetails;

/** The call that raised OPTIX_EXCEPTION_CODE_CALLABLE_PARAMETER_MISMATCH; all zero for others.
    Counts are 32-bit words after packing, not arguments. */
typedef struct OptixParameterMismatchExceptionDetails {
    unsigned int expectedParameterCount;
    unsigned int passedArgumentCount;
    unsigned int sbtIndex;
    char* callableName;
} OptixParameterMismatchExceptionDetails;

#endif

#ifdef __cplusplus
}
#endif

#endif
