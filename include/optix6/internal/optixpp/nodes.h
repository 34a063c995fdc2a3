// SPDX-License-Identifier: Apache-2.0
// The C++ wrapper of the classic API: groups, transforms, selectors and their acceleration
// structures. A member function calls the C function whose name has the same words. Source: OptiX
// API reference 6.0, chapter 7.
#ifndef SUNSTONE_OPTIXPP_NODES_H
#define SUNSTONE_OPTIXPP_NODES_H

#include "handle.h"

namespace optix {

/** A group of groups, geometry groups, transforms and selectors. */
class GroupObj : public DestroyableObj {
public:
    typedef RTgroup api_t;

    void destroy() override;
    void validate() override;
    Context getContext() const override;
    RTgroup get();

    void setAcceleration(Acceleration acceleration);
    Acceleration getAcceleration() const;

    void setChildCount(unsigned int count);
    unsigned int getChildCount() const;
    template <typename T>
    void setChild(unsigned int index, T child);
    template <typename T>
    T getChild(unsigned int index) const;
    RTobjecttype getChildType(unsigned int index) const;
    /** Appends; returns the index. */
    template <typename T>
    unsigned int addChild(T child);

    /** Removes a child; the last one takes its place. Returns the former index.
        RT_ERROR_INVALID_VALUE: the object is no child, or the index is beyond the count. */
    template <typename T>
    unsigned int removeChild(T child);
    void removeChild(int index);
    void removeChild(unsigned int index);
    template <typename T>
    unsigned int getChildIndex(T child) const;

    void setVisibilityMask(RTvisibilitymask mask);
    RTvisibilitymask getVisibilityMask() const;

private:
    friend class Handle<GroupObj>;
    explicit GroupObj(RTgroup object) : m_group(object) {}

    RTgroup m_group;
};

/** A group of geometry instances. */
class GeometryGroupObj : public DestroyableObj {
public:
    typedef RTgeometrygroup api_t;

    void destroy() override;
    void validate() override;
    Context getContext() const override;
    RTgeometrygroup get();

    void setAcceleration(Acceleration acceleration);
    Acceleration getAcceleration() const;

    void setChildCount(unsigned int count);
    unsigned int getChildCount() const;
    void setChild(unsigned int index, GeometryInstance geometryinstance);
    GeometryInstance getChild(unsigned int index) const;
    /** Appends; returns the index. */
    unsigned int addChild(GeometryInstance child);

    /** Removes a child; the last one takes its place. Returns the former index.
        RT_ERROR_INVALID_VALUE: the object is no child, or the index is beyond the count. */
    unsigned int removeChild(GeometryInstance child);
    void removeChild(int index);
    void removeChild(unsigned int index);
    unsigned int getChildIndex(GeometryInstance child) const;

    void setFlags(RTinstanceflags flags);
    RTinstanceflags getFlags() const;
    void setVisibilityMask(RTvisibilitymask mask);
    RTvisibilitymask getVisibilityMask() const;

private:
    friend class Handle<GeometryGroupObj>;
    explicit GeometryGroupObj(RTgeometrygroup object) : m_geometrygroup(object) {}

    RTgeometrygroup m_geometrygroup;
};

/** A transform of its child, still or in motion. */
class TransformObj : public DestroyableObj {
public:
    typedef RTtransform api_t;

    void destroy() override;
    void validate() override;
    Context getContext() const override;
    RTtransform get();

    template <typename T>
    void setChild(T child);
    template <typename T>
    T getChild() const;
    RTobjecttype getChildType() const;
    void setMatrix(bool transpose, const float* matrix, const float* inverse_matrix);
    void getMatrix(bool transpose, float* matrix, float* inverse_matrix) const;

    void setMotionRange(float timeBegin, float timeEnd);
    void getMotionRange(float& timeBegin, float& timeEnd);
    void setMotionBorderMode(RTmotionbordermode beginMode, RTmotionbordermode endMode);
    void getMotionBorderMode(RTmotionbordermode& beginMode, RTmotionbordermode& endMode);

    void setMotionKeys(unsigned int n, RTmotionkeytype type, const float* keys);
    unsigned int getMotionKeyCount();
    RTmotionkeytype getMotionKeyType();
    void getMotionKeys(float* keys);

private:
    friend class Handle<TransformObj>;
    explicit TransformObj(RTtransform object) : m_transform(object) {}

    RTtransform m_transform;
};

/** A node whose visit program selects children. */
class SelectorObj : public DestroyableObj {
public:
    typedef RTselector api_t;

    void destroy() override;
    void validate() override;
    Context getContext() const override;
    RTselector get();

    void setVisitProgram(Program program);
    Program getVisitProgram() const;

    void setChildCount(unsigned int count);
    unsigned int getChildCount() const;
    template <typename T>
    void setChild(unsigned int index, T child);
    template <typename T>
    T getChild(unsigned int index) const;
    RTobjecttype getChildType(unsigned int index) const;
    /** Appends; returns the index. */
    template <typename T>
    unsigned int addChild(T child);

    /** Removes a child; later ones move down. Returns the former index.
        RT_ERROR_INVALID_VALUE: the object is no child, or the index is beyond the count. */
    template <typename T>
    unsigned int removeChild(T child);
    void removeChild(int index);
    void removeChild(unsigned int index);
    template <typename T>
    unsigned int getChildIndex(T child) const;

    Variable declareVariable(const std::string& name);
    Variable queryVariable(const std::string& name) const;
    void removeVariable(Variable v);
    unsigned int getVariableCount() const;
    Variable getVariable(unsigned int index) const;

private:
    friend class Handle<SelectorObj>;
    explicit SelectorObj(RTselector object) : m_selector(object) {}

    RTselector m_selector;
};

/** The acceleration structure of a group or geometry group. */
class AccelerationObj : public DestroyableObj {
public:
    typedef RTacceleration api_t;

    void destroy() override;
    void validate() override;
    Context getContext() const override;
    RTacceleration get();

    void markDirty();
    bool isDirty() const;
    void setProperty(const std::string& name, const std::string& value);
    std::string getProperty(const std::string& name) const;
    void setBuilder(const std::string& builder);
    std::string getBuilder() const;
    /** Deprecated. */
    void setTraverser(const std::string& traverser);
    std::string getTraverser() const;
    RTsize getDataSize() const;
    void getData(void* data) const;
    void setData(const void* data, RTsize size);

private:
    friend class Handle<AccelerationObj>;
    explicit AccelerationObj(RTacceleration object) : m_acceleration(object) {}

    RTacceleration m_acceleration;
};

} // namespace optix

#endif
