// SPDX-License-Identifier: Apache-2.0
// Entry points of geometry triangles (section 5.11).
#include "api/optix6/call.h"
#include "api/optix6/setters.h"

using namespace sunstone;
using namespace sunstone::optix6;

namespace {

void requireFormat(RTformat format, std::initializer_list<RTformat> known, const char* name) {
    std::string names;
    for (const RTformat each : known) {
        if (each == format)
            return;
        names += (names.empty() ? "" : ", ") + nameOf(each);
    }
    refuse(RT_ERROR_INVALID_VALUE, name, " = ", nameOf(format), " is not one of ", names);
}

void requireVertexFormat(RTformat format) {
    requireFormat(format, {RT_FORMAT_FLOAT3, RT_FORMAT_FLOAT2, RT_FORMAT_HALF3, RT_FORMAT_HALF2},
                  "vertexFormat");
}

void setVertices(GeometryTriangles& object, unsigned count, std::vector<Ref<Buffer>> buffers,
                 RTsize offset, RTsize stride, RTsize motionStride, RTformat format) {
    requireVertexFormat(format);
    constexpr RTsize kMost = 0xFFFFFFFF;
    if (stride > kMost || (stride != 0 && stride < bytesOf(format)))
        refuse(RT_ERROR_INVALID_VALUE, "vertexBufferByteStride = ", stride,
               " is neither 0 nor at least ", bytesOf(format), ", the bytes of a vertex");
    object.vertices = std::move(buffers);
    object.vertexCount = count;
    object.vertexByteOffset = offset;
    object.vertexStride = stride;
    object.vertexMotionStride = motionStride;
    object.vertexFormat = format;
}

} // namespace

SUNSTONE_API RTresult rtGeometryTrianglesCreate(RTcontext context,
                                                RTgeometrytriangles* geometrytriangles) {
    return create<GeometryTriangles>(__func__, context, "geometrytriangles", geometrytriangles);
}
SUNSTONE_API RTresult rtGeometryTrianglesDestroy(RTgeometrytriangles geometrytriangles) {
    return destroy<GeometryTriangles>(__func__, geometrytriangles, "geometrytriangles");
}
SUNSTONE_API RTresult rtGeometryTrianglesValidate(RTgeometrytriangles geometrytriangles) {
    return call<GeometryTriangles>(__func__, geometrytriangles, "geometrytriangles",
                                   [](GeometryTriangles& object) { object.validate(); });
}
SUNSTONE_API RTresult rtGeometryTrianglesGetContext(RTgeometrytriangles geometrytriangles,
                                                    RTcontext* context) {
    return getContext<GeometryTriangles>(__func__, geometrytriangles, "geometrytriangles", context);
}
SUNSTONE_API RTresult rtGeometryTrianglesSetPrimitiveCount(RTgeometrytriangles geometrytriangles,
                                                           unsigned value) {
    return call<GeometryTriangles>(__func__, geometrytriangles, "geometrytriangles",
                                   [&](GeometryTriangles& object) { object.primitives = value; });
}
SUNSTONE_API RTresult rtGeometryTrianglesGetPrimitiveCount(RTgeometrytriangles geometrytriangles,
                                                           unsigned* value) {
    return call<GeometryTriangles>(
        __func__, geometrytriangles, "geometrytriangles",
        [&](GeometryTriangles& object) { store(value, "triangleCount", object.primitives); });
}
SUNSTONE_API RTresult
rtGeometryTrianglesSetPrimitiveIndexOffset(RTgeometrytriangles geometrytriangles, unsigned value) {
    return call<GeometryTriangles>(__func__, geometrytriangles, "geometrytriangles",
                                   [&](GeometryTriangles& object) { object.indexOffset = value; });
}
SUNSTONE_API RTresult
rtGeometryTrianglesGetPrimitiveIndexOffset(RTgeometrytriangles geometrytriangles, unsigned* value) {
    return call<GeometryTriangles>(
        __func__, geometrytriangles, "geometrytriangles",
        [&](GeometryTriangles& object) { store(value, "indexOffset", object.indexOffset); });
}
SUNSTONE_API RTresult rtGeometryTrianglesSetMotionSteps(RTgeometrytriangles geometrytriangles,
                                                        unsigned n) {
    return call<GeometryTriangles>(
        __func__, geometrytriangles, "geometrytriangles", [&](auto& object) {
            if (n == 0 || n > kMostMotionSteps)
                refuse(RT_ERROR_INVALID_VALUE, "n = ", n, " is outside 1..", kMostMotionSteps);
            object.motion.steps = n;
            object.noteSceneChange();
        });
}
SUNSTONE_API RTresult rtGeometryTrianglesGetMotionSteps(RTgeometrytriangles geometrytriangles,
                                                        unsigned* n) {
    return call<GeometryTriangles>(__func__, geometrytriangles, "geometrytriangles",
                                   [&](auto& object) { store(n, "n", object.motion.steps); });
}
SUNSTONE_API RTresult rtGeometryTrianglesSetMotionRange(RTgeometrytriangles geometrytriangles,
                                                        float begin, float end) {
    return call<GeometryTriangles>(__func__, geometrytriangles, "geometrytriangles",
                                   [&](auto& object) {
                                       setMotionRange(object.motion, begin, end);
                                       object.noteSceneChange();
                                   });
}
SUNSTONE_API RTresult rtGeometryTrianglesGetMotionRange(RTgeometrytriangles geometrytriangles,
                                                        float* begin, float* end) {
    return call<GeometryTriangles>(__func__, geometrytriangles, "geometrytriangles",
                                   [&](auto& object) {
                                       requireNonNull(begin, "timeBegin");
                                       store(end, "timeEnd", object.motion.end);
                                       *begin = object.motion.begin;
                                   });
}
SUNSTONE_API RTresult rtGeometryTrianglesSetMotionBorderMode(RTgeometrytriangles geometrytriangles,
                                                             RTmotionbordermode begin,
                                                             RTmotionbordermode end) {
    return call<GeometryTriangles>(__func__, geometrytriangles, "geometrytriangles",
                                   [&](auto& object) {
                                       setMotionBorders(object.motion, begin, end);
                                       object.noteSceneChange();
                                   });
}
SUNSTONE_API RTresult rtGeometryTrianglesGetMotionBorderMode(RTgeometrytriangles geometrytriangles,
                                                             RTmotionbordermode* begin,
                                                             RTmotionbordermode* end) {
    return call<GeometryTriangles>(__func__, geometrytriangles, "geometrytriangles",
                                   [&](auto& object) {
                                       requireNonNull(begin, "beginMode");
                                       store(end, "endMode", object.motion.endMode);
                                       *begin = object.motion.beginMode;
                                   });
}
SUNSTONE_API RTresult rtGeometryTrianglesSetAttributeProgram(RTgeometrytriangles geometrytriangles,
                                                             RTprogram handle) {
    return call<GeometryTriangles>(
        __func__, geometrytriangles, "geometrytriangles", [&](GeometryTriangles& object) {
            setProgram(object, object.attributes, handle, compiler::ProgramKind::kAttribute);
        });
}
SUNSTONE_API RTresult rtGeometryTrianglesGetAttributeProgram(RTgeometrytriangles geometrytriangles,
                                                             RTprogram* program) {
    return call<GeometryTriangles>(
        __func__, geometrytriangles, "geometrytriangles", [&](GeometryTriangles& object) {
            store(program, "program", static_cast<RTprogram>(handleOf(object.attributes)));
        });
}
SUNSTONE_API RTresult rtGeometryTrianglesSetPreTransformMatrix(RTgeometrytriangles triangles,
                                                               int transpose, const float* matrix) {
    return call<GeometryTriangles>(__func__, triangles, "geometrytriangles", [&](auto& object) {
        constexpr std::array<float, 12> kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
        object.hasTransform = matrix != nullptr;
        object.transform = kIdentity;
        if (matrix)
            readMatrix(matrix, transpose != 0, 3, object.transform.data());
    });
}
SUNSTONE_API RTresult rtGeometryTrianglesGetPreTransformMatrix(RTgeometrytriangles triangles,
                                                               int transpose, float* matrix) {
    return call<GeometryTriangles>(__func__, triangles, "geometrytriangles", [&](auto& object) {
        requireNonNull(matrix, "matrix");
        writeMatrix(object.transform.data(), transpose != 0, 3, matrix);
    });
}
namespace {

// A buffer that builds read.
std::shared_ptr<Buffer> sourceOf(const GeometryTriangles& object, RTbuffer handle,
                                 const char* parameter) {
    std::shared_ptr<Buffer> buffer = requireOf<Buffer>(*object.context(), handle, parameter);
    buffer->isUsedByObjects = true;
    return buffer;
}

} // namespace

SUNSTONE_API RTresult rtGeometryTrianglesSetTriangleIndices(RTgeometrytriangles triangles,
                                                            RTbuffer buffer, RTsize offset,
                                                            RTsize stride, RTformat format) {
    return call<GeometryTriangles>(__func__, triangles, "geometrytriangles", [&](auto& object) {
        if (!buffer) {
            object.hasIndices = false;
            return;
        }
        requireFormat(format, {RT_FORMAT_UNSIGNED_INT3, RT_FORMAT_UNSIGNED_SHORT3},
                      "triIndicesFormat");
        object.indices = sourceOf(object, buffer, "indexBuffer");
        object.indexByteOffset = offset;
        object.indexStride = stride;
        object.indexFormat = format;
        object.hasIndices = true;
    });
}
SUNSTONE_API RTresult rtGeometryTrianglesSetVertices(RTgeometrytriangles triangles, unsigned count,
                                                     RTbuffer buffer, RTsize offset, RTsize stride,
                                                     RTformat format) {
    return call<GeometryTriangles>(__func__, triangles, "geometrytriangles", [&](auto& object) {
        auto vertices = sourceOf(object, buffer, "vertexBuffer");
        setVertices(object, count, {vertices}, offset, stride, 0, format);
    });
}
SUNSTONE_API RTresult rtGeometryTrianglesSetMotionVertices(RTgeometrytriangles triangles,
                                                           unsigned count, RTbuffer buffer,
                                                           RTsize offset, RTsize stride,
                                                           RTsize motionStride, RTformat format) {
    return call<GeometryTriangles>(__func__, triangles, "geometrytriangles", [&](auto& object) {
        auto vertices = sourceOf(object, buffer, "vertexBuffer");
        setVertices(object, count, {vertices}, offset, stride, motionStride, format);
    });
}
SUNSTONE_API RTresult rtGeometryTrianglesSetMotionVerticesMultiBuffer(
    RTgeometrytriangles triangles, unsigned count, RTbuffer* buffers, unsigned bufferCount,
    RTsize offset, RTsize stride, RTformat format) {
    return call<GeometryTriangles>(__func__, triangles, "geometrytriangles", [&](auto& object) {
        requireNonNull(buffers, "vertexBuffers");
        if (bufferCount == 0 || bufferCount > kMostMotionSteps)
            refuse(RT_ERROR_INVALID_VALUE, "vertexBufferCount = ", bufferCount, " is outside 1..",
                   kMostMotionSteps);
        std::vector<Ref<Buffer>> list;
        for (unsigned i = 0; i < bufferCount; ++i)
            list.push_back(sourceOf(object, buffers[i], "a vertex buffer"));
        setVertices(object, count, std::move(list), offset, stride, 0, format);
    });
}
SUNSTONE_API RTresult rtGeometryTrianglesSetBuildFlags(RTgeometrytriangles triangles,
                                                       RTgeometrybuildflags flags) {
    return call<GeometryTriangles>(__func__, triangles, "geometrytriangles", [&](auto& object) {
        if (flags & ~RT_GEOMETRY_BUILD_FLAG_RELEASE_BUFFERS)
            refuse(RT_ERROR_INVALID_VALUE, "buildFlags = ", unsigned(flags), " has unknown bits");
        object.buildFlags = flags;
    });
}
SUNSTONE_API RTresult rtGeometryTrianglesSetMaterialCount(RTgeometrytriangles triangles,
                                                          unsigned count) {
    return call<GeometryTriangles>(__func__, triangles, "geometrytriangles", [&](auto& object) {
        constexpr unsigned kMost = 1u << 16;
        if (count == 0 || count > kMost)
            refuse(RT_ERROR_INVALID_VALUE, "numMaterials = ", count, " is outside 1..", kMost);
        object.materialFlags.resize(count, RT_GEOMETRY_FLAG_NONE);
        object.noteSceneChange();
    });
}
SUNSTONE_API RTresult rtGeometryTrianglesGetMaterialCount(RTgeometrytriangles triangles,
                                                          unsigned* count) {
    return call<GeometryTriangles>(__func__, triangles, "geometrytriangles", [&](auto& object) {
        store(count, "numMaterials", unsigned(object.materialFlags.size()));
    });
}
SUNSTONE_API RTresult rtGeometryTrianglesSetMaterialIndices(RTgeometrytriangles triangles,
                                                            RTbuffer buffer, RTsize offset,
                                                            RTsize stride, RTformat format) {
    return call<GeometryTriangles>(__func__, triangles, "geometrytriangles", [&](auto& object) {
        if (!buffer) {
            object.hasMaterialIndices = false;
            return;
        }
        requireFormat(format,
                      {RT_FORMAT_UNSIGNED_INT, RT_FORMAT_UNSIGNED_SHORT, RT_FORMAT_UNSIGNED_BYTE},
                      "materialIndexFormat");
        object.materialIndices = sourceOf(object, buffer, "materialIndexBuffer");
        object.materialByteOffset = offset;
        object.materialStride = stride;
        object.materialFormat = format;
        object.hasMaterialIndices = true;
    });
}

namespace {

RTgeometryflags& flagsOf(GeometryTriangles& object, unsigned index) {
    if (index >= object.materialFlags.size())
        refuse(RT_ERROR_INVALID_VALUE, "materialIndex = ", index, " of ",
               object.materialFlags.size(), " materials");
    return object.materialFlags[index];
}

} // namespace

SUNSTONE_API RTresult rtGeometryTrianglesSetFlagsPerMaterial(RTgeometrytriangles triangles,
                                                             unsigned index,
                                                             RTgeometryflags flags) {
    return call<GeometryTriangles>(__func__, triangles, "geometrytriangles", [&](auto& object) {
        if (unsigned(flags) > 3)
            refuse(RT_ERROR_INVALID_VALUE, "flags = ", unsigned(flags), " has unknown bits");
        flagsOf(object, index) = flags;
    });
}
SUNSTONE_API RTresult rtGeometryTrianglesGetFlagsPerMaterial(RTgeometrytriangles triangles,
                                                             unsigned index,
                                                             RTgeometryflags* flags) {
    return call<GeometryTriangles>(__func__, triangles, "geometrytriangles", [&](auto& object) {
        store(flags, "flags", flagsOf(object, index));
    });
}
