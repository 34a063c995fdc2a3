// SPDX-License-Identifier: Apache-2.0
// The C++ wrapper of the classic API: the member functions of geometry.h.
#ifndef SUNSTONE_OPTIXPP_GEOMETRY_CALLS_H
#define SUNSTONE_OPTIXPP_GEOMETRY_CALLS_H

#include "calls.h"

namespace optix {

// ---- GeometryInstance -------------------------------------------------------------------------

inline void GeometryInstanceObj::destroy() {
    checkError(rtGeometryInstanceDestroy(m_geometryinstance));
    m_geometryinstance = 0;
}
inline void GeometryInstanceObj::validate() {
    checkError(rtGeometryInstanceValidate(m_geometryinstance));
}
inline Context GeometryInstanceObj::getContext() const {
    RTcontext context = 0;
    checkErrorNoGetContext(rtGeometryInstanceGetContext(m_geometryinstance, &context));
    return Context::take(context);
}
inline RTgeometryinstance GeometryInstanceObj::get() {
    return m_geometryinstance;
}
inline void GeometryInstanceObj::setGeometry(Geometry geometry) {
    checkError(rtGeometryInstanceSetGeometry(m_geometryinstance, internal::api(geometry)));
}
inline Geometry GeometryInstanceObj::getGeometry() const {
    RTgeometry value = 0;
    checkError(rtGeometryInstanceGetGeometry(m_geometryinstance, &value));
    return Geometry::take(value);
}
inline void GeometryInstanceObj::setGeometryTriangles(GeometryTriangles geometry) {
    checkError(rtGeometryInstanceSetGeometryTriangles(m_geometryinstance, internal::api(geometry)));
}
inline GeometryTriangles GeometryInstanceObj::getGeometryTriangles() const {
    RTgeometrytriangles value = 0;
    checkError(rtGeometryInstanceGetGeometryTriangles(m_geometryinstance, &value));
    return GeometryTriangles::take(value);
}
inline void GeometryInstanceObj::setMaterialCount(unsigned int count) {
    checkError(rtGeometryInstanceSetMaterialCount(m_geometryinstance, count));
}
inline unsigned int GeometryInstanceObj::getMaterialCount() const {
    unsigned int value = 0;
    checkError(rtGeometryInstanceGetMaterialCount(m_geometryinstance, &value));
    return value;
}
inline void GeometryInstanceObj::setMaterial(unsigned int idx, Material material) {
    checkError(rtGeometryInstanceSetMaterial(m_geometryinstance, idx, internal::api(material)));
}
inline Material GeometryInstanceObj::getMaterial(unsigned int idx) const {
    RTmaterial value = 0;
    checkError(rtGeometryInstanceGetMaterial(m_geometryinstance, idx, &value));
    return Material::take(value);
}
inline unsigned int GeometryInstanceObj::addMaterial(Material material) {
    const unsigned int index = getMaterialCount();
    setMaterialCount(index + 1);
    setMaterial(index, material);
    return index;
}
inline Variable GeometryInstanceObj::declareVariable(const std::string& name) {
    RTvariable value = 0;
    checkError(rtGeometryInstanceDeclareVariable(m_geometryinstance, name.c_str(), &value));
    return Variable::take(value);
}
inline Variable GeometryInstanceObj::queryVariable(const std::string& name) const {
    RTvariable value = 0;
    checkError(rtGeometryInstanceQueryVariable(m_geometryinstance, name.c_str(), &value));
    return Variable::take(value);
}
inline void GeometryInstanceObj::removeVariable(Variable v) {
    checkError(rtGeometryInstanceRemoveVariable(m_geometryinstance, internal::api(v)));
}
inline unsigned int GeometryInstanceObj::getVariableCount() const {
    unsigned int value = 0;
    checkError(rtGeometryInstanceGetVariableCount(m_geometryinstance, &value));
    return value;
}
inline Variable GeometryInstanceObj::getVariable(unsigned int index) const {
    RTvariable value = 0;
    checkError(rtGeometryInstanceGetVariable(m_geometryinstance, index, &value));
    return Variable::take(value);
}

// ---- Geometry ---------------------------------------------------------------------------------

inline void GeometryObj::destroy() {
    checkError(rtGeometryDestroy(m_geometry));
    m_geometry = 0;
}
inline void GeometryObj::validate() {
    checkError(rtGeometryValidate(m_geometry));
}
inline Context GeometryObj::getContext() const {
    RTcontext context = 0;
    checkErrorNoGetContext(rtGeometryGetContext(m_geometry, &context));
    return Context::take(context);
}
inline RTgeometry GeometryObj::get() {
    return m_geometry;
}
inline void GeometryObj::markDirty() {
    checkError(rtGeometryMarkDirty(m_geometry));
}
inline bool GeometryObj::isDirty() const {
    int value = 0;
    checkError(rtGeometryIsDirty(m_geometry, &value));
    return value != 0;
}
inline void GeometryObj::setPrimitiveCount(unsigned int num_primitives) {
    checkError(rtGeometrySetPrimitiveCount(m_geometry, num_primitives));
}
inline unsigned int GeometryObj::getPrimitiveCount() const {
    unsigned int value = 0;
    checkError(rtGeometryGetPrimitiveCount(m_geometry, &value));
    return value;
}
inline void GeometryObj::setPrimitiveIndexOffset(unsigned int index_offset) {
    checkError(rtGeometrySetPrimitiveIndexOffset(m_geometry, index_offset));
}
inline unsigned int GeometryObj::getPrimitiveIndexOffset() const {
    unsigned int value = 0;
    checkError(rtGeometryGetPrimitiveIndexOffset(m_geometry, &value));
    return value;
}
inline void GeometryObj::setMotionRange(float timeBegin, float timeEnd) {
    checkError(rtGeometrySetMotionRange(m_geometry, timeBegin, timeEnd));
}
inline void GeometryObj::getMotionRange(float& timeBegin, float& timeEnd) {
    checkError(rtGeometryGetMotionRange(m_geometry, &timeBegin, &timeEnd));
}
inline void GeometryObj::setMotionBorderMode(RTmotionbordermode beginMode,
                                             RTmotionbordermode endMode) {
    checkError(rtGeometrySetMotionBorderMode(m_geometry, beginMode, endMode));
}
inline void GeometryObj::getMotionBorderMode(RTmotionbordermode& beginMode,
                                             RTmotionbordermode& endMode) {
    checkError(rtGeometryGetMotionBorderMode(m_geometry, &beginMode, &endMode));
}
inline void GeometryObj::setMotionSteps(unsigned int n) {
    checkError(rtGeometrySetMotionSteps(m_geometry, n));
}
inline unsigned int GeometryObj::getMotionSteps() {
    unsigned int value = 0;
    checkError(rtGeometryGetMotionSteps(m_geometry, &value));
    return value;
}
inline void GeometryObj::setBoundingBoxProgram(Program program) {
    checkError(rtGeometrySetBoundingBoxProgram(m_geometry, internal::api(program)));
}
inline Program GeometryObj::getBoundingBoxProgram() const {
    RTprogram value = 0;
    checkError(rtGeometryGetBoundingBoxProgram(m_geometry, &value));
    return Program::take(value);
}
inline void GeometryObj::setIntersectionProgram(Program program) {
    checkError(rtGeometrySetIntersectionProgram(m_geometry, internal::api(program)));
}
inline Program GeometryObj::getIntersectionProgram() const {
    RTprogram value = 0;
    checkError(rtGeometryGetIntersectionProgram(m_geometry, &value));
    return Program::take(value);
}
inline void GeometryObj::setFlags(RTgeometryflags flags) {
    checkError(rtGeometrySetFlags(m_geometry, flags));
}
inline RTgeometryflags GeometryObj::setFlags() const {
    return getFlags();
}
inline RTgeometryflags GeometryObj::getFlags() const {
    RTgeometryflags value = RTgeometryflags();
    checkError(rtGeometryGetFlags(m_geometry, &value));
    return value;
}
inline Variable GeometryObj::declareVariable(const std::string& name) {
    RTvariable value = 0;
    checkError(rtGeometryDeclareVariable(m_geometry, name.c_str(), &value));
    return Variable::take(value);
}
inline Variable GeometryObj::queryVariable(const std::string& name) const {
    RTvariable value = 0;
    checkError(rtGeometryQueryVariable(m_geometry, name.c_str(), &value));
    return Variable::take(value);
}
inline void GeometryObj::removeVariable(Variable v) {
    checkError(rtGeometryRemoveVariable(m_geometry, internal::api(v)));
}
inline unsigned int GeometryObj::getVariableCount() const {
    unsigned int value = 0;
    checkError(rtGeometryGetVariableCount(m_geometry, &value));
    return value;
}
inline Variable GeometryObj::getVariable(unsigned int index) const {
    RTvariable value = 0;
    checkError(rtGeometryGetVariable(m_geometry, index, &value));
    return Variable::take(value);
}

// ---- GeometryTriangles ------------------------------------------------------------------------

inline void GeometryTrianglesObj::destroy() {
    checkError(rtGeometryTrianglesDestroy(m_geometrytriangles));
    m_geometrytriangles = 0;
}
inline void GeometryTrianglesObj::validate() {
    checkError(rtGeometryTrianglesValidate(m_geometrytriangles));
}
inline Context GeometryTrianglesObj::getContext() const {
    RTcontext context = 0;
    checkErrorNoGetContext(rtGeometryTrianglesGetContext(m_geometrytriangles, &context));
    return Context::take(context);
}
inline RTgeometrytriangles GeometryTrianglesObj::get() {
    return m_geometrytriangles;
}
inline void GeometryTrianglesObj::setPrimitiveIndexOffset(unsigned int index_offset) {
    checkError(rtGeometryTrianglesSetPrimitiveIndexOffset(m_geometrytriangles, index_offset));
}
inline unsigned int GeometryTrianglesObj::getPrimitiveIndexOffset() const {
    unsigned int value = 0;
    checkError(rtGeometryTrianglesGetPrimitiveIndexOffset(m_geometrytriangles, &value));
    return value;
}
inline void GeometryTrianglesObj::setPrimitiveCount(unsigned int num_triangles) {
    checkError(rtGeometryTrianglesSetPrimitiveCount(m_geometrytriangles, num_triangles));
}
inline unsigned int GeometryTrianglesObj::getPrimitiveCount() const {
    unsigned int value = 0;
    checkError(rtGeometryTrianglesGetPrimitiveCount(m_geometrytriangles, &value));
    return value;
}
inline void GeometryTrianglesObj::setPreTransformMatrix(bool transpose, const float* matrix) {
    checkError(rtGeometryTrianglesSetPreTransformMatrix(m_geometrytriangles, transpose, matrix));
}
inline void GeometryTrianglesObj::getPreTransformMatrix(bool transpose, float* matrix) {
    checkError(rtGeometryTrianglesGetPreTransformMatrix(m_geometrytriangles, transpose, matrix));
}
inline void GeometryTrianglesObj::setTriangleIndices(Buffer index_buffer,
                                                     RTformat tri_indices_format) {
    setTriangleIndices(index_buffer, 0, tri_indices_format);
}
inline void GeometryTrianglesObj::setTriangleIndices(Buffer index_buffer,
                                                     RTsize index_buffer_byte_offset,
                                                     RTformat tri_indices_format) {
    setTriangleIndices(index_buffer, index_buffer_byte_offset, internal::sizeOf(tri_indices_format),
                       tri_indices_format);
}
inline void GeometryTrianglesObj::setTriangleIndices(Buffer index_buffer,
                                                     RTsize index_buffer_byte_offset,
                                                     RTsize tri_indices_byte_stride,
                                                     RTformat tri_indices_format) {
    checkError(rtGeometryTrianglesSetTriangleIndices(
        m_geometrytriangles, internal::api(index_buffer), index_buffer_byte_offset,
        tri_indices_byte_stride, tri_indices_format));
}
inline void GeometryTrianglesObj::setVertices(unsigned int num_vertices, Buffer vertex_buffer,
                                              RTformat position_format) {
    setVertices(num_vertices, vertex_buffer, 0, position_format);
}
inline void GeometryTrianglesObj::setVertices(unsigned int num_vertices, Buffer vertex_buffer,
                                              RTsize vertex_buffer_byte_offset,
                                              RTformat position_format) {
    setVertices(num_vertices, vertex_buffer, vertex_buffer_byte_offset,
                internal::sizeOf(position_format), position_format);
}
inline void GeometryTrianglesObj::setVertices(unsigned int num_vertices, Buffer vertex_buffer,
                                              RTsize vertex_buffer_byte_offset,
                                              RTsize vertex_byte_stride, RTformat position_format) {
    checkError(rtGeometryTrianglesSetVertices(
        m_geometrytriangles, num_vertices, internal::api(vertex_buffer), vertex_buffer_byte_offset,
        vertex_byte_stride, position_format));
}
inline void GeometryTrianglesObj::setMotionVertices(unsigned int num_vertices, Buffer vertex_buffer,
                                                    RTsize vertex_buffer_byte_offset,
                                                    RTsize vertex_byte_stride,
                                                    RTsize vertex_motion_step_byte_stride,
                                                    RTformat position_format) {
    checkError(rtGeometryTrianglesSetMotionVertices(
        m_geometrytriangles, num_vertices, internal::api(vertex_buffer), vertex_buffer_byte_offset,
        vertex_byte_stride, vertex_motion_step_byte_stride, position_format));
}
template <class BufferIterator>
inline void GeometryTrianglesObj::setMotionVerticesMultiBuffer(unsigned int num_vertices,
                                                               BufferIterator vertex_buffers_begin,
                                                               BufferIterator vertex_buffers_end,
                                                               RTsize vertex_buffer_byte_offset,
                                                               RTsize vertex_byte_stride,
                                                               RTformat position_format) {
    std::vector<RTbuffer> buffers;
    for (; vertex_buffers_begin != vertex_buffers_end; ++vertex_buffers_begin)
        buffers.push_back(internal::api(*vertex_buffers_begin));
    checkError(rtGeometryTrianglesSetMotionVerticesMultiBuffer(
        m_geometrytriangles, num_vertices, buffers.data(),
        static_cast<unsigned int>(buffers.size()), vertex_buffer_byte_offset, vertex_byte_stride,
        position_format));
}
inline void GeometryTrianglesObj::setMotionRange(float timeBegin, float timeEnd) {
    checkError(rtGeometryTrianglesSetMotionRange(m_geometrytriangles, timeBegin, timeEnd));
}
inline void GeometryTrianglesObj::getMotionRange(float& timeBegin, float& timeEnd) const {
    checkError(rtGeometryTrianglesGetMotionRange(m_geometrytriangles, &timeBegin, &timeEnd));
}
inline void GeometryTrianglesObj::setMotionBorderMode(RTmotionbordermode beginMode,
                                                      RTmotionbordermode endMode) {
    checkError(rtGeometryTrianglesSetMotionBorderMode(m_geometrytriangles, beginMode, endMode));
}
inline void GeometryTrianglesObj::getMotionBorderMode(RTmotionbordermode& beginMode,
                                                      RTmotionbordermode& endMode) const {
    checkError(rtGeometryTrianglesGetMotionBorderMode(m_geometrytriangles, &beginMode, &endMode));
}
inline void GeometryTrianglesObj::setMotionSteps(unsigned int n) {
    checkError(rtGeometryTrianglesSetMotionSteps(m_geometrytriangles, n));
}
inline unsigned int GeometryTrianglesObj::getMotionSteps() const {
    unsigned int value = 0;
    checkError(rtGeometryTrianglesGetMotionSteps(m_geometrytriangles, &value));
    return value;
}
inline void GeometryTrianglesObj::setBuildFlags(RTgeometrybuildflags build_flags) {
    checkError(rtGeometryTrianglesSetBuildFlags(m_geometrytriangles, build_flags));
}
inline void GeometryTrianglesObj::setMaterialCount(unsigned int num_materials) {
    checkError(rtGeometryTrianglesSetMaterialCount(m_geometrytriangles, num_materials));
}
inline unsigned int GeometryTrianglesObj::getMaterialCount() const {
    unsigned int value = 0;
    checkError(rtGeometryTrianglesGetMaterialCount(m_geometrytriangles, &value));
    return value;
}
inline void GeometryTrianglesObj::setMaterialIndices(Buffer material_index_buffer,
                                                     RTsize material_index_buffer_byte_offset,
                                                     RTsize material_index_byte_stride,
                                                     RTformat material_index_format) {
    checkError(rtGeometryTrianglesSetMaterialIndices(
        m_geometrytriangles, internal::api(material_index_buffer),
        material_index_buffer_byte_offset, material_index_byte_stride, material_index_format));
}
inline void GeometryTrianglesObj::setFlagsPerMaterial(unsigned int material_index,
                                                      RTgeometryflags flags) {
    checkError(rtGeometryTrianglesSetFlagsPerMaterial(m_geometrytriangles, material_index, flags));
}
inline RTgeometryflags
GeometryTrianglesObj::getFlagsPerMaterial(unsigned int material_index) const {
    RTgeometryflags value = RTgeometryflags();
    checkError(rtGeometryTrianglesGetFlagsPerMaterial(m_geometrytriangles, material_index, &value));
    return value;
}
inline void GeometryTrianglesObj::setAttributeProgram(Program program) {
    checkError(rtGeometryTrianglesSetAttributeProgram(m_geometrytriangles, internal::api(program)));
}
inline Program GeometryTrianglesObj::getAttributeProgram() const {
    RTprogram value = 0;
    checkError(rtGeometryTrianglesGetAttributeProgram(m_geometrytriangles, &value));
    return Program::take(value);
}
inline Variable GeometryTrianglesObj::declareVariable(const std::string& name) {
    RTvariable value = 0;
    checkError(rtGeometryTrianglesDeclareVariable(m_geometrytriangles, name.c_str(), &value));
    return Variable::take(value);
}
inline Variable GeometryTrianglesObj::queryVariable(const std::string& name) const {
    RTvariable value = 0;
    checkError(rtGeometryTrianglesQueryVariable(m_geometrytriangles, name.c_str(), &value));
    return Variable::take(value);
}
inline void GeometryTrianglesObj::removeVariable(Variable v) {
    checkError(rtGeometryTrianglesRemoveVariable(m_geometrytriangles, internal::api(v)));
}
inline unsigned int GeometryTrianglesObj::getVariableCount() const {
    unsigned int value = 0;
    checkError(rtGeometryTrianglesGetVariableCount(m_geometrytriangles, &value));
    return value;
}
inline Variable GeometryTrianglesObj::getVariable(unsigned int index) const {
    RTvariable value = 0;
    checkError(rtGeometryTrianglesGetVariable(m_geometrytriangles, index, &value));
    return Variable::take(value);
}

// ---- Material ---------------------------------------------------------------------------------

inline void MaterialObj::destroy() {
    checkError(rtMaterialDestroy(m_material));
    m_material = 0;
}
inline void MaterialObj::validate() {
    checkError(rtMaterialValidate(m_material));
}
inline Context MaterialObj::getContext() const {
    RTcontext context = 0;
    checkErrorNoGetContext(rtMaterialGetContext(m_material, &context));
    return Context::take(context);
}
inline RTmaterial MaterialObj::get() {
    return m_material;
}
inline void MaterialObj::setClosestHitProgram(unsigned int ray_type_index, Program program) {
    checkError(rtMaterialSetClosestHitProgram(m_material, ray_type_index, internal::api(program)));
}
inline Program MaterialObj::getClosestHitProgram(unsigned int ray_type_index) const {
    RTprogram value = 0;
    checkError(rtMaterialGetClosestHitProgram(m_material, ray_type_index, &value));
    return Program::take(value);
}
inline void MaterialObj::setAnyHitProgram(unsigned int ray_type_index, Program program) {
    checkError(rtMaterialSetAnyHitProgram(m_material, ray_type_index, internal::api(program)));
}
inline Program MaterialObj::getAnyHitProgram(unsigned int ray_type_index) const {
    RTprogram value = 0;
    checkError(rtMaterialGetAnyHitProgram(m_material, ray_type_index, &value));
    return Program::take(value);
}
inline Variable MaterialObj::declareVariable(const std::string& name) {
    RTvariable value = 0;
    checkError(rtMaterialDeclareVariable(m_material, name.c_str(), &value));
    return Variable::take(value);
}
inline Variable MaterialObj::queryVariable(const std::string& name) const {
    RTvariable value = 0;
    checkError(rtMaterialQueryVariable(m_material, name.c_str(), &value));
    return Variable::take(value);
}
inline void MaterialObj::removeVariable(Variable v) {
    checkError(rtMaterialRemoveVariable(m_material, internal::api(v)));
}
inline unsigned int MaterialObj::getVariableCount() const {
    unsigned int value = 0;
    checkError(rtMaterialGetVariableCount(m_material, &value));
    return value;
}
inline Variable MaterialObj::getVariable(unsigned int index) const {
    RTvariable value = 0;
    checkError(rtMaterialGetVariable(m_material, index, &value));
    return Variable::take(value);
}

} // namespace optix

#endif
