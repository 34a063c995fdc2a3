// SPDX-License-Identifier: Apache-2.0
// The C++ wrapper of the classic API: geometry, its instances and materials. A member function
// calls the C function whose name has the same words. Source: OptiX API reference 6.0, chapter 7.
#ifndef SUNSTONE_OPTIXPP_GEOMETRY_H
#define SUNSTONE_OPTIXPP_GEOMETRY_H

#include "handle.h"

namespace optix {

/** Geometry with materials. */
class GeometryInstanceObj : public ScopedObj {
public:
    typedef RTgeometryinstance api_t;

    void destroy() override;
    void validate() override;
    Context getContext() const override;
    RTgeometryinstance get();

    void setGeometry(Geometry geometry);
    Geometry getGeometry() const;
    void setGeometryTriangles(GeometryTriangles geometry);
    GeometryTriangles getGeometryTriangles() const;
    void setMaterialCount(unsigned int count);
    unsigned int getMaterialCount() const;
    void setMaterial(unsigned int idx, Material material);
    Material getMaterial(unsigned int idx) const;
    /** Appends; returns the index. */
    unsigned int addMaterial(Material material);

    Variable declareVariable(const std::string& name) override;
    Variable queryVariable(const std::string& name) const override;
    void removeVariable(Variable v) override;
    unsigned int getVariableCount() const override;
    Variable getVariable(unsigned int index) const override;

private:
    friend class Handle<GeometryInstanceObj>;
    explicit GeometryInstanceObj(RTgeometryinstance object) : m_geometryinstance(object) {}

    RTgeometryinstance m_geometryinstance;
};

/** Primitives with bounding box and intersection programs. */
class GeometryObj : public ScopedObj {
public:
    typedef RTgeometry api_t;

    void destroy() override;
    void validate() override;
    Context getContext() const override;
    RTgeometry get();

    /** Deprecated, without effect. */
    void markDirty();
    bool isDirty() const;

    void setPrimitiveCount(unsigned int num_primitives);
    unsigned int getPrimitiveCount() const;
    void setPrimitiveIndexOffset(unsigned int index_offset);
    unsigned int getPrimitiveIndexOffset() const;

    void setMotionRange(float timeBegin, float timeEnd);
    void getMotionRange(float& timeBegin, float& timeEnd);
    void setMotionBorderMode(RTmotionbordermode beginMode, RTmotionbordermode endMode);
    void getMotionBorderMode(RTmotionbordermode& beginMode, RTmotionbordermode& endMode);
    void setMotionSteps(unsigned int n);
    unsigned int getMotionSteps();

    void setBoundingBoxProgram(Program program);
    Program getBoundingBoxProgram() const;
    void setIntersectionProgram(Program program);
    Program getIntersectionProgram() const;
    void setFlags(RTgeometryflags flags);
    /** The flags; the API has the getter under both names. */
    RTgeometryflags setFlags() const;
    RTgeometryflags getFlags() const;

    Variable declareVariable(const std::string& name) override;
    Variable queryVariable(const std::string& name) const override;
    void removeVariable(Variable v) override;
    unsigned int getVariableCount() const override;
    Variable getVariable(unsigned int index) const override;

private:
    friend class Handle<GeometryObj>;
    explicit GeometryObj(RTgeometry object) : m_geometry(object) {}

    RTgeometry m_geometry;
};

/** Triangles from buffers. Without an offset data start at 0; without a stride they are packed. */
class GeometryTrianglesObj : public DestroyableObj {
public:
    typedef RTgeometrytriangles api_t;

    void destroy() override;
    void validate() override;
    Context getContext() const override;
    RTgeometrytriangles get();

    void setPrimitiveIndexOffset(unsigned int index_offset);
    unsigned int getPrimitiveIndexOffset() const;
    void setPrimitiveCount(unsigned int num_triangles);
    unsigned int getPrimitiveCount() const;
    void setPreTransformMatrix(bool transpose, const float* matrix);
    void getPreTransformMatrix(bool transpose, float* matrix);

    void setTriangleIndices(Buffer index_buffer, RTformat tri_indices_format);
    void setTriangleIndices(Buffer index_buffer, RTsize index_buffer_byte_offset,
                            RTformat tri_indices_format);
    void setTriangleIndices(Buffer index_buffer, RTsize index_buffer_byte_offset,
                            RTsize tri_indices_byte_stride, RTformat tri_indices_format);
    void setVertices(unsigned int num_vertices, Buffer vertex_buffer, RTformat position_format);
    void setVertices(unsigned int num_vertices, Buffer vertex_buffer,
                     RTsize vertex_buffer_byte_offset, RTformat position_format);
    void setVertices(unsigned int num_vertices, Buffer vertex_buffer,
                     RTsize vertex_buffer_byte_offset, RTsize vertex_byte_stride,
                     RTformat position_format);
    void setMotionVertices(unsigned int num_vertices, Buffer vertex_buffer,
                           RTsize vertex_buffer_byte_offset, RTsize vertex_byte_stride,
                           RTsize vertex_motion_step_byte_stride, RTformat position_format);
    template <class BufferIterator>
    void setMotionVerticesMultiBuffer(unsigned int num_vertices,
                                      BufferIterator vertex_buffers_begin,
                                      BufferIterator vertex_buffers_end,
                                      RTsize vertex_buffer_byte_offset, RTsize vertex_byte_stride,
                                      RTformat position_format);

    void setMotionRange(float timeBegin, float timeEnd);
    void getMotionRange(float& timeBegin, float& timeEnd) const;
    void setMotionBorderMode(RTmotionbordermode beginMode, RTmotionbordermode endMode);
    void getMotionBorderMode(RTmotionbordermode& beginMode, RTmotionbordermode& endMode) const;
    void setMotionSteps(unsigned int n);
    unsigned int getMotionSteps() const;

    void setBuildFlags(RTgeometrybuildflags build_flags);
    void setMaterialCount(unsigned int num_materials);
    unsigned int getMaterialCount() const;
    void setMaterialIndices(Buffer material_index_buffer, RTsize material_index_buffer_byte_offset,
                            RTsize material_index_byte_stride, RTformat material_index_format);
    void setFlagsPerMaterial(unsigned int material_index, RTgeometryflags flags);
    RTgeometryflags getFlagsPerMaterial(unsigned int material_index) const;
    void setAttributeProgram(Program program);
    Program getAttributeProgram() const;

    Variable declareVariable(const std::string& name);
    Variable queryVariable(const std::string& name) const;
    void removeVariable(Variable v);
    unsigned int getVariableCount() const;
    Variable getVariable(unsigned int index) const;

private:
    friend class Handle<GeometryTrianglesObj>;
    explicit GeometryTrianglesObj(RTgeometrytriangles object) : m_geometrytriangles(object) {}

    RTgeometrytriangles m_geometrytriangles;
};

/** The hit programs of each ray type. */
class MaterialObj : public ScopedObj {
public:
    typedef RTmaterial api_t;

    void destroy() override;
    void validate() override;
    Context getContext() const override;
    RTmaterial get();

    void setClosestHitProgram(unsigned int ray_type_index, Program program);
    Program getClosestHitProgram(unsigned int ray_type_index) const;
    void setAnyHitProgram(unsigned int ray_type_index, Program program);
    Program getAnyHitProgram(unsigned int ray_type_index) const;

    Variable declareVariable(const std::string& name) override;
    Variable queryVariable(const std::string& name) const override;
    void removeVariable(Variable v) override;
    unsigned int getVariableCount() const override;
    Variable getVariable(unsigned int index) const override;

private:
    friend class Handle<MaterialObj>;
    explicit MaterialObj(RTmaterial object) : m_material(object) {}

    RTmaterial m_material;
};

} // namespace optix

#endif
