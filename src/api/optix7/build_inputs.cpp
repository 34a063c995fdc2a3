// SPDX-License-Identifier: Apache-2.0
// See build_inputs.h.
#include "api/optix7/build_inputs.h"

#include "bvh/micromap/micromap.h"
#include "bvh/shapes/curves.h"

#include <algorithm>
#include <cmath>

namespace sunstone::optix7 {
namespace {

struct FormatSize {
    unsigned bytes;     // of a packed element
    unsigned alignment; // of buffer and stride
};

FormatSize vertexFormatSize(OptixVertexFormat format, const std::string& where) {
    switch (format) {
    case OPTIX_VERTEX_FORMAT_FLOAT3: return {12, 4};
    case OPTIX_VERTEX_FORMAT_FLOAT2: return {8, 4};
    case OPTIX_VERTEX_FORMAT_HALF3: return {6, 2};
    case OPTIX_VERTEX_FORMAT_HALF2: return {4, 2};
    case OPTIX_VERTEX_FORMAT_SNORM16_3: return {6, 2};
    case OPTIX_VERTEX_FORMAT_SNORM16_2: return {4, 2};
    default: fail(Code::kInvalidValue, where, "vertexFormat = ", unsigned(format), " is unknown");
    }
}

FormatSize indexFormatSize(OptixIndicesFormat format, const std::string& where) {
    switch (format) {
    case OPTIX_INDICES_FORMAT_NONE: return {0, 1};
    case OPTIX_INDICES_FORMAT_UNSIGNED_SHORT3: return {6, 2};
    case OPTIX_INDICES_FORMAT_UNSIGNED_INT3: return {12, 4};
    default: fail(Code::kInvalidValue, where, "indexFormat = ", unsigned(format), " is unknown");
    }
}

// Checks build inputs one after another and adds them to an AccelInputs.
class Checker {
public:
    Checker(InputCheck check, Abi abi, unsigned keys, const ApiCall& call, engine::AccelInputs& out)
        : call_(call), buffers_(check == InputCheck::kBuffers), abi_(abi), keys_(keys),
          device_(*call.context.engine->device), out_(out) {}

    void triangles(const OptixBuildInputTriangleArray& in, const std::string& where) {
        bvh::TriangleInput t;
        FormatSize vertex{12, 4};
        if (in.numVertices != 0)
            vertex = vertexFormatSize(in.vertexFormat, where);
        FormatSize index = indexFormatSize(in.indexFormat, where);
        checkStride(in.vertexStrideInBytes, vertex, where, "vertexStrideInBytes");
        checkStride(in.indexStrideInBytes, index, where, "indexStrideInBytes");
        t.vertexFormat = bvh::VertexFormat(in.vertexFormat);
        t.vertexStride = in.vertexStrideInBytes;
        t.numVertices = in.numVertices;
        t.indexFormat = bvh::IndexFormat(in.indexFormat);
        t.indexStride = in.indexStrideInBytes;
        if (index.bytes == 0) {
            if (in.numIndexTriplets != 0)
                fail(Code::kInvalidValue, where, "numIndexTriplets = ", in.numIndexTriplets,
                     ", but indexFormat is NONE");
            if (buffers_ && in.indexBuffer != 0)
                fail(Code::kInvalidValue, where, "indexBuffer is set, but indexFormat is NONE");
            if (in.numVertices % 3 != 0)
                tolerate(call_, "the rest is ignored", where, "numVertices = ", in.numVertices,
                         " is not a multiple of 3, and there are no indices");
            t.numTriangles = in.numVertices / 3;
            t.numVertices = 3 * t.numTriangles;
        } else {
            t.numTriangles = in.numIndexTriplets;
        }
        checkPrimitiveCount(t.numTriangles, in.primitiveIndexOffset, where,
                            index.bytes == 0 ? "numVertices / 3" : "numIndexTriplets");
        transform(in, where, t);
        if (buffers_ && t.numTriangles != 0) {
            t.keyVertices = keyBuffers(in.vertexBuffers, in.numVertices, in.vertexStrideInBytes,
                                       vertex, where, "vertexBuffers");
            t.vertices = t.keyVertices[0];
            if (index.bytes != 0) {
                t.indices = pointer(in.indexBuffer);
                checkBuffer(t.indices, in.numIndexTriplets, in.indexStrideInBytes, index, where,
                            "indexBuffer");
            }
        }
        t.sbt = sbt(in.flags, in.numSbtRecords, in.sbtIndexOffsetBuffer,
                    in.sbtIndexOffsetSizeInBytes, in.sbtIndexOffsetStrideInBytes, t.numTriangles,
                    in.primitiveIndexOffset, where);
        t.micromaps = micromaps(in.opacityMicromap, t.numTriangles, where + "opacityMicromap.");
        out_.triangles.push_back(t);
    }

    void customs(const OptixBuildInputCustomPrimitiveArray& in, const std::string& where) {
        bvh::CustomInput c;
        c.numPrimitives = in.numPrimitives;
        c.stride = in.strideInBytes;
        if (in.strideInBytes % OPTIX_AABB_BUFFER_BYTE_ALIGNMENT != 0)
            fail(Code::kInvalidValue, where, "strideInBytes = ", in.strideInBytes,
                 " is not a multiple of ", unsigned(OPTIX_AABB_BUFFER_BYTE_ALIGNMENT));
        if (in.strideInBytes != 0 && in.strideInBytes < sizeof(OptixAabb))
            fail(Code::kInvalidValue, where, "strideInBytes = ", in.strideInBytes,
                 " is less than a box of ", sizeof(OptixAabb), " bytes");
        checkPrimitiveCount(in.numPrimitives, in.primitiveIndexOffset, where, "numPrimitives");
        if (buffers_ && in.numPrimitives != 0) {
            c.keyAabbs = keyBuffers(in.aabbBuffers, in.numPrimitives, in.strideInBytes,
                                    {sizeof(OptixAabb), OPTIX_AABB_BUFFER_BYTE_ALIGNMENT}, where,
                                    "aabbBuffers");
            c.aabbs = c.keyAabbs[0];
        }
        c.sbt = sbt(in.flags, in.numSbtRecords, in.sbtIndexOffsetBuffer,
                    in.sbtIndexOffsetSizeInBytes, in.sbtIndexOffsetStrideInBytes, in.numPrimitives,
                    in.primitiveIndexOffset, where);
        out_.customs.push_back(c);
    }

    void curves(const OptixBuildInputCurveArray& in, const std::string& where) {
        bvh::CurveInput c;
        checkCurveKind(in, where);
        checkStride(in.vertexStrideInBytes, {12, 4}, where, "vertexStrideInBytes");
        checkStride(in.widthStrideInBytes, {4, 4}, where, "widthStrideInBytes");
        checkStride(in.indexStrideInBytes, {4, 4}, where, "indexStrideInBytes");
        checkPrimitiveCount(in.numPrimitives, in.primitiveIndexOffset, where, "numPrimitives");
        c.basis = in.curveType;
        c.vertexStride = in.vertexStrideInBytes;
        c.numVertices = in.numVertices;
        c.radiusStride = in.widthStrideInBytes;
        c.indexStride = in.indexStrideInBytes;
        c.numSegments = in.numPrimitives;
        c.caps = in.curveType != OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR &&
                 (in.endcapFlags & OPTIX_CURVE_ENDCAP_ON);
        if (buffers_ && in.numPrimitives != 0) {
            c.keyVertices = keyBuffers(in.vertexBuffers, in.numVertices, in.vertexStrideInBytes,
                                       {12, 4}, where, "vertexBuffers");
            c.vertices = c.keyVertices[0];
            c.keyRadii = keyBuffers(in.widthBuffers, in.numVertices, in.widthStrideInBytes, {4, 4},
                                    where, "widthBuffers");
            c.radii = c.keyRadii[0];
            c.indices = pointer(in.indexBuffer);
            checkBuffer(c.indices, in.numPrimitives, in.indexStrideInBytes, {4, 4}, where,
                        "indexBuffer");
        }
        // A curve input has one SBT record and one word of flags.
        c.sbt = sbt(&in.flag, 1, 0, 0, 0, in.numPrimitives, in.primitiveIndexOffset, where);
        out_.curves.push_back(c);
    }

    void spheres(const OptixBuildInputSphereArray& in, const std::string& where) {
        bvh::SphereInput s;
        checkStride(in.vertexStrideInBytes, {12, 4}, where, "vertexStrideInBytes");
        checkStride(in.radiusStrideInBytes, {4, 4}, where, "radiusStrideInBytes");
        checkPrimitiveCount(in.numVertices, in.primitiveIndexOffset, where, "numVertices");
        s.centreStride = in.vertexStrideInBytes;
        s.numSpheres = in.numVertices;
        s.radiusStride = in.radiusStrideInBytes;
        s.oneRadius = in.singleRadius != 0;
        if (buffers_ && in.numVertices != 0) {
            s.keyCentres = keyBuffers(in.vertexBuffers, in.numVertices, in.vertexStrideInBytes,
                                      {12, 4}, where, "vertexBuffers");
            s.centres = s.keyCentres[0];
            s.keyRadii = keyBuffers(in.radiusBuffers, s.oneRadius ? 1 : in.numVertices,
                                    in.radiusStrideInBytes, {4, 4}, where, "radiusBuffers");
            s.radii = s.keyRadii[0];
        }
        s.sbt = sbt(in.flags, in.numSbtRecords, in.sbtIndexOffsetBuffer,
                    in.sbtIndexOffsetSizeInBytes, in.sbtIndexOffsetStrideInBytes, in.numVertices,
                    in.primitiveIndexOffset, where);
        out_.spheres.push_back(s);
    }

    void instances(const OptixBuildInputInstanceArray& in, bool pointers, const std::string& where) {
        auto i = std::make_unique<bvh::InstanceInput>();
        i->numInstances = in.numInstances;
        if (in.numInstances > Limits::instancesPerIas(abi_))
            fail(Code::kInvalidValue, where, "numInstances = ", in.numInstances, " is above ",
                 Limits::instancesPerIas(abi_));
        i->knownFlags = knownInstanceFlags(abi_);
        if (abi_ < kAbi74)
            i->identityFlag = kInstanceFlagDisableTransform;
        const FormatSize format =
            pointers ? FormatSize{8, 8}
                     : FormatSize{sizeof(OptixInstance), OPTIX_INSTANCE_BYTE_ALIGNMENT};
        if (!pointers) {
            checkStride(in.instanceStride, format, where, "instanceStride");
            i->stride = in.instanceStride;
        }
        if (buffers_ && in.numInstances != 0) {
            checkBuffer(pointer(in.instances), in.numInstances, i->stride, format, where,
                        "instances");
            if (pointers)
                i->instancePointers = static_cast<const uint64_t*>(pointer(in.instances));
            else
                i->instances = pointer(in.instances);
        }
        out_.instances = std::move(i);
    }

private:
    static const void* pointer(CUdeviceptr address) {
        return reinterpret_cast<const void*>(address);
    }

    static void checkStride(unsigned stride, FormatSize format, const std::string& where,
                            const char* field) {
        if (stride == 0 || format.bytes == 0)
            return;
        if (stride < format.bytes)
            fail(Code::kInvalidValue, where, field, " = ", stride, " is less than an element of ",
                 format.bytes, " bytes");
        if (stride % format.alignment != 0)
            fail(Code::kInvalidValue, where, field, " = ", stride, " is not a multiple of ",
                 format.alignment);
    }

    void checkCurveKind(const OptixBuildInputCurveArray& in, const std::string& where) const {
        if (!bvh::isCurveBasis(in.curveType) ||
            (in.curveType == OPTIX_PRIMITIVE_TYPE_ROUND_CATMULLROM && abi_ < kAbi74))
            fail(Code::kInvalidValue, where, "curveType = ", unsigned(in.curveType),
                 " is no type of curves in OptiX ", releaseOf(abi_));
        if (!out_.curves.empty() && out_.curves[0].basis != unsigned(in.curveType))
            fail(Code::kInvalidValue, where, "curveType = ", unsigned(in.curveType),
                 " differs from that of buildInputs[0]: a structure holds one type of curves");
        if (in.endcapFlags & ~unsigned(OPTIX_CURVE_ENDCAP_ON))
            fail(Code::kInvalidValue, where, "endcapFlags = ", in.endcapFlags, " has unknown bits");
        if (in.endcapFlags != 0 && in.curveType == OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR)
            tolerate(call_, "it is ignored", where,
                     "endcapFlags = 1, but linear curves have round ends always");
        if (in.normalBuffers || in.normalStrideInBytes)
            tolerate(call_, "they are ignored", where,
                     "normalBuffers and normalStrideInBytes are reserved and must be 0");
    }

    // `field`: the member that holds the count.
    static void checkPrimitiveCount(unsigned count, unsigned offset, const std::string& where,
                                    const char* field) {
        if (count > Limits::kPrimitivesPerGas)
            fail(Code::kInvalidValue, where, field, " = ", count, " is above ",
                 Limits::kPrimitivesPerGas, ", the most primitives of a structure");
        if (uint64_t(count) + offset > 0xFFFFFFFFull)
            fail(Code::kInvalidValue, where, "primitiveIndexOffset = ", offset, " plus ", count,
                 " primitives overflows 32 bits");
    }

    void transform(const OptixBuildInputTriangleArray& in, const std::string& where,
                   bvh::TriangleInput& t) const {
        if (in.transformFormat != OPTIX_TRANSFORM_FORMAT_NONE &&
            in.transformFormat != OPTIX_TRANSFORM_FORMAT_MATRIX_FLOAT12)
            fail(Code::kInvalidValue, where, "transformFormat = ", unsigned(in.transformFormat),
                 " is unknown");
        bool wanted = in.transformFormat == OPTIX_TRANSFORM_FORMAT_MATRIX_FLOAT12;
        if (!buffers_)
            return;
        if (wanted != (in.preTransform != 0))
            fail(Code::kInvalidValue, where, "transformFormat is ",
                 wanted ? "MATRIX_FLOAT12, but preTransform is 0" : "NONE, but preTransform is set");
        if (!wanted)
            return;
        checkBuffer(pointer(in.preTransform), 1, 0, {48, OPTIX_GEOMETRY_TRANSFORM_BYTE_ALIGNMENT},
                    where, "preTransform");
        t.preTransform = static_cast<const float*>(pointer(in.preTransform));
    }

    // The array of one buffer for each motion key; returns a copy of its addresses that the inputs
    // own.
    const void* const* keyBuffers(const CUdeviceptr* buffers, uint64_t count, unsigned stride,
                                  FormatSize format, const std::string& where, const char* field) {
        if (!buffers)
            fail(Code::kInvalidValue, where, field, " is null");
        std::vector<const void*> keys(keys_);
        for (unsigned key = 0; key < keys_; ++key) {
            keys[key] = pointer(buffers[key]);
            checkBuffer(keys[key], count, stride, format, where,
                        message(field, "[", key, "]").c_str());
        }
        return out_.keepKeys(std::move(keys));
    }

    // `count` elements with this stride (0: packed) must lie in device memory, aligned.
    void checkBuffer(const void* buffer, uint64_t count, unsigned stride, FormatSize format,
                     const std::string& where, const char* field) const {
        if (!buffer)
            fail(Code::kInvalidValue, where, field, " is 0");
        if (uint64_t(buffer) % format.alignment != 0)
            fail(Code::kInvalidValue, where, field, " = ", buffer, " is not a multiple of ",
                 format.alignment);
        if (count == 0)
            return;
        uint64_t bytes = (count - 1) * (stride ? stride : format.bytes) + format.bytes;
        if (!device_.isAccessible(buffer, bytes))
            fail(Code::kInvalidValue, where, field, " = ", buffer, " with ", bytes,
                 " bytes is not device memory");
    }

    bvh::SbtInput sbt(const unsigned* flags, unsigned numRecords, CUdeviceptr offsets,
                      unsigned offsetSize, unsigned offsetStride, unsigned count,
                      unsigned primitiveIndexOffset, const std::string& where) {
        bvh::SbtInput sbt;
        if (numRecords == 0 || numRecords > Limits::kSbtRecordsPerGas)
            fail(Code::kInvalidValue, where, "numSbtRecords = ", numRecords, " is outside 1..",
                 Limits::kSbtRecordsPerGas);
        if (!flags)
            fail(Code::kInvalidValue, where, "flags is null");
        const unsigned known = knownGeometryFlags(abi_);
        for (unsigned i = 0; i < numRecords; ++i)
            if (flags[i] & ~known)
                fail(Code::kInvalidValue, where, "flags[", i, "] = ", flags[i],
                     " has unknown bits");
        if (offsetSize != 0 && offsetSize != 1 && offsetSize != 2 && offsetSize != 4)
            fail(Code::kInvalidValue, where, "sbtIndexOffsetSizeInBytes = ", offsetSize,
                 " is not 0, 1, 2 or 4");
        if (offsetStride != 0 && offsetSize != 0 &&
            (offsetStride < offsetSize || offsetStride % offsetSize != 0))
            fail(Code::kInvalidValue, where, "sbtIndexOffsetStrideInBytes = ", offsetStride,
                 " is no multiple of the size ", offsetSize);
        sbt.flags = out_.keepFlags(flags, numRecords);
        sbt.numSbtRecords = numRecords;
        sbt.primitiveIndexOffset = primitiveIndexOffset;
        if (!buffers_ || offsets == 0)
            return sbt;
        if (offsetSize == 0)
            fail(Code::kInvalidValue, where,
                 "sbtIndexOffsetBuffer is set, but sbtIndexOffsetSizeInBytes is 0");
        checkBuffer(pointer(offsets), count, offsetStride, {offsetSize, offsetSize}, where,
                    "sbtIndexOffsetBuffer");
        sbt.indexOffsets = pointer(offsets);
        sbt.indexOffsetSize = offsetSize;
        sbt.indexOffsetStride = offsetStride;
        return sbt;
    }

    bvh::MicromapInput micromaps(const OptixBuildInputOpacityMicromap& in, unsigned numTriangles,
                                 const std::string& where) const {
        bvh::MicromapInput out;
        checkMicromapUsage(in, where);
        if (unsigned(in.indexingMode) > OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_INDEXED)
            fail(Code::kInvalidValue, where, "indexingMode = ", unsigned(in.indexingMode),
                 " is unknown");
        out.indexing = bvh::MicromapIndexing(in.indexingMode);
        const bool indexed = out.indexing == bvh::MicromapIndexing::kIndexed;
        if (indexed && in.indexSizeInBytes != 2 && in.indexSizeInBytes != 4)
            fail(Code::kInvalidValue, where, "indexSizeInBytes = ", in.indexSizeInBytes,
                 " is not 2 or 4");
        const FormatSize index{in.indexSizeInBytes, in.indexSizeInBytes};
        if (indexed)
            checkStride(in.indexStrideInBytes, index, where, "indexStrideInBytes");
        out.indexSize = in.indexSizeInBytes;
        out.indexStride = in.indexStrideInBytes;
        out.indexOffset = in.indexOffset;
        if (!buffers_)
            return out;
        const bool wanted = out.indexing != bvh::MicromapIndexing::kNone;
        if (wanted != (in.opacityMicromapArray != 0))
            fail(Code::kInvalidValue, where, wanted ? "opacityMicromapArray is 0, but indexingMode "
                                                      "is not NONE"
                                                    : "opacityMicromapArray is set, but "
                                                      "indexingMode is NONE");
        if (!indexed && in.indexBuffer != 0)
            tolerate(call_, "it is ignored", where,
                     "indexBuffer is set, but indexingMode is not INDEXED");
        if (!wanted)
            return out;
        out.array = pointer(in.opacityMicromapArray);
        checkBuffer(out.array, 1, 0,
                    {sizeof(bvh::MicromapArrayHeader),
                     OPTIX_OPACITY_MICROMAP_ARRAY_BUFFER_BYTE_ALIGNMENT},
                    where, "opacityMicromapArray");
        if (indexed && numTriangles != 0) {
            out.indices = pointer(in.indexBuffer);
            checkBuffer(out.indices, numTriangles, in.indexStrideInBytes, index, where,
                        "indexBuffer");
        }
        return out;
    }

    // The counts of triangles per kind of micromap are checked, but not used.
    static void checkMicromapUsage(const OptixBuildInputOpacityMicromap& in,
                                   const std::string& where) {
        if (in.numMicromapUsageCounts != 0 && !in.micromapUsageCounts)
            fail(Code::kInvalidValue, where, "micromapUsageCounts is null, but "
                 "numMicromapUsageCounts = ", in.numMicromapUsageCounts);
        for (unsigned i = 0; i < in.numMicromapUsageCounts; ++i)
            checkMicromapKind(in.micromapUsageCounts[i].subdivisionLevel,
                              in.micromapUsageCounts[i].format,
                              message(where, "micromapUsageCounts[", i, "]."));
    }

    const ApiCall& call_;
    bool buffers_;
    Abi abi_;
    unsigned keys_;
    device::Device& device_;
    engine::AccelInputs& out_;
};

} // namespace

void checkMicromapKind(unsigned level, OptixOpacityMicromapFormat format,
                       const std::string& where) {
    if (level > OPTIX_OPACITY_MICROMAP_MAX_SUBDIVISION_LEVEL)
        fail(Code::kInvalidValue, where, "subdivisionLevel = ", level, " is above ",
             OPTIX_OPACITY_MICROMAP_MAX_SUBDIVISION_LEVEL);
    if (format != OPTIX_OPACITY_MICROMAP_FORMAT_2_STATE &&
        format != OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE)
        fail(Code::kInvalidValue, where, "format = ", unsigned(format), " is unknown");
}

// Without motion the other members are ignored.
static bvh::MotionOptions checkMotion(const OptixMotionOptions& motion) {
    if (motion.numKeys <= 1)
        return {};
    if (motion.flags & ~(OPTIX_MOTION_FLAG_START_VANISH | OPTIX_MOTION_FLAG_END_VANISH))
        fail(Code::kInvalidValue, "accelOptions->motionOptions.flags = ", motion.flags,
             " has unknown bits");
    if (!std::isfinite(motion.timeBegin) || !std::isfinite(motion.timeEnd))
        fail(Code::kInvalidValue, "accelOptions->motionOptions.timeBegin = ", motion.timeBegin,
             " or timeEnd = ", motion.timeEnd, " is not finite");
    if (motion.timeBegin > motion.timeEnd)
        fail(Code::kInvalidValue, "accelOptions->motionOptions.timeBegin = ", motion.timeBegin,
             " is after timeEnd = ", motion.timeEnd);
    return {motion.numKeys, motion.flags, motion.timeBegin, motion.timeEnd};
}

unsigned withOnePreference(unsigned buildFlags) {
    constexpr unsigned kBoth =
        OPTIX_BUILD_FLAG_PREFER_FAST_TRACE | OPTIX_BUILD_FLAG_PREFER_FAST_BUILD;
    return (buildFlags & kBoth) == kBoth ? buildFlags & ~kBoth : buildFlags;
}

bvh::BuildOptions checkBuildOptions(const OptixAccelBuildOptions* options, const ApiCall& call) {
    requireNonNull(options, "accelOptions");
    const unsigned flags = withOnePreference(options->buildFlags);
    if (flags & ~knownBuildFlags(call.context.abi))
        fail(Code::kInvalidValue, "accelOptions->buildFlags = ", options->buildFlags,
             " has unknown bits");
    if (flags != options->buildFlags)
        tolerate(call, "both are ignored", "accelOptions->buildFlags = ", options->buildFlags,
                 " has both PREFER_FAST_TRACE and PREFER_FAST_BUILD");
    if (options->operation != OPTIX_BUILD_OPERATION_BUILD &&
        options->operation != OPTIX_BUILD_OPERATION_UPDATE)
        fail(Code::kInvalidValue, "accelOptions->operation = ", unsigned(options->operation),
             " is unknown");
    bvh::BuildOptions out;
    out.motion = checkMotion(options->motionOptions);
    out.allowUpdate = flags & OPTIX_BUILD_FLAG_ALLOW_UPDATE;
    out.allowCompaction = flags & OPTIX_BUILD_FLAG_ALLOW_COMPACTION;
    out.preferFastTrace = flags & OPTIX_BUILD_FLAG_PREFER_FAST_TRACE;
    out.preferFastBuild = flags & OPTIX_BUILD_FLAG_PREFER_FAST_BUILD;
    out.allowRandomVertexAccess = flags & OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS;
    out.allowRandomInstanceAccess = flags & OPTIX_BUILD_FLAG_ALLOW_RANDOM_INSTANCE_ACCESS;
    out.allowMicromapUpdate = flags & OPTIX_BUILD_FLAG_ALLOW_OPACITY_MICROMAP_UPDATE;
    out.allowDisableMicromaps = flags & OPTIX_BUILD_FLAG_ALLOW_DISABLE_OPACITY_MICROMAPS;
    return out;
}

std::shared_ptr<engine::AccelInputs> checkBuildInputs(const BuildInputs& inputs, unsigned count,
                                                      unsigned keys, InputCheck check,
                                                      const ApiCall& call) {
    if (!inputs)
        fail(Code::kInvalidValue, "buildInputs is null");
    if (count == 0)
        fail(Code::kInvalidValue, "numBuildInputs is 0");
    auto out = std::make_shared<engine::AccelInputs>();
    Checker checker(check, inputs.abi(), keys, call, *out);
    uint64_t total = 0;
    for (unsigned i = 0; i < count; ++i) {
        const OptixBuildInput input = inputs[i];
        std::string where = message("buildInputs[", i, "].");
        if (!inputs.hasType(input.type))
            fail(Code::kInvalidValue, where, "type = ", unsigned(input.type),
                 " is unknown in OptiX ", releaseOf(inputs.abi()));
        if (input.type != inputs[0].type)
            fail(Code::kInvalidValue, where, "type = ", unsigned(input.type),
                 " differs from that of buildInputs[0]; all must be of one type");
        switch (input.type) {
        case OPTIX_BUILD_INPUT_TYPE_TRIANGLES:
            checker.triangles(input.triangleArray, where);
            total += out->triangles.back().numTriangles;
            break;
        case OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES:
            checker.customs(input.customPrimitiveArray, where);
            total += out->customs.back().numPrimitives;
            break;
        case OPTIX_BUILD_INPUT_TYPE_INSTANCES:
        case OPTIX_BUILD_INPUT_TYPE_INSTANCE_POINTERS:
            if (count != 1)
                fail(Code::kInvalidValue, "numBuildInputs = ", count,
                     ", but an instance acceleration structure has exactly one build input");
            checker.instances(input.instanceArray,
                              input.type == OPTIX_BUILD_INPUT_TYPE_INSTANCE_POINTERS, where);
            break;
        case OPTIX_BUILD_INPUT_TYPE_CURVES:
            checker.curves(input.curveArray, where);
            total += out->curves.back().numSegments;
            break;
        case OPTIX_BUILD_INPUT_TYPE_SPHERES:
            checker.spheres(input.sphereArray, where);
            total += out->spheres.back().numSpheres;
            break;
        default:
            fail(Code::kInvalidValue, where, "type = ", unsigned(input.type), " is unknown");
        }
    }
    if (total * keys > Limits::kPrimitivesPerGas)
        fail(Code::kInvalidValue, "all build inputs together have ", total,
             " primitives with ", keys, " motion keys each, more than ",
             Limits::kPrimitivesPerGas, " in all");
    return out;
}

} // namespace sunstone::optix7
