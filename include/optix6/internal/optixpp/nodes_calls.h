// SPDX-License-Identifier: Apache-2.0
// The C++ wrapper of the classic API: the member functions of nodes.h.
#ifndef SUNSTONE_OPTIXPP_NODES_CALLS_H
#define SUNSTONE_OPTIXPP_NODES_CALLS_H

#include "calls.h"

namespace optix {

// ---- Group ------------------------------------------------------------------------------------

inline void GroupObj::destroy() {
    checkError(rtGroupDestroy(m_group));
    m_group = 0;
}
inline void GroupObj::validate() {
    checkError(rtGroupValidate(m_group));
}
inline Context GroupObj::getContext() const {
    RTcontext context = 0;
    checkErrorNoGetContext(rtGroupGetContext(m_group, &context));
    return Context::take(context);
}
inline RTgroup GroupObj::get() {
    return m_group;
}
inline void GroupObj::setAcceleration(Acceleration acceleration) {
    checkError(rtGroupSetAcceleration(m_group, internal::api(acceleration)));
}
inline Acceleration GroupObj::getAcceleration() const {
    RTacceleration value = 0;
    checkError(rtGroupGetAcceleration(m_group, &value));
    return Acceleration::take(value);
}
inline void GroupObj::setChildCount(unsigned int count) {
    checkError(rtGroupSetChildCount(m_group, count));
}
inline unsigned int GroupObj::getChildCount() const {
    unsigned int value = 0;
    checkError(rtGroupGetChildCount(m_group, &value));
    return value;
}
template <typename T>
inline void GroupObj::setChild(unsigned int index, T child) {
    checkError(rtGroupSetChild(m_group, index, internal::api(child)));
}
template <typename T>
inline T GroupObj::getChild(unsigned int index) const {
    RTobject child = 0;
    checkError(rtGroupGetChild(m_group, index, &child));
    return T::take(child);
}
inline RTobjecttype GroupObj::getChildType(unsigned int index) const {
    RTobjecttype value = RTobjecttype();
    checkError(rtGroupGetChildType(m_group, index, &value));
    return value;
}
template <typename T>
inline unsigned int GroupObj::addChild(T child) {
    unsigned int index = 0;
    checkError(rtuGroupAddChild(m_group, internal::api(child), &index));
    return index;
}
template <typename T>
inline unsigned int GroupObj::removeChild(T child) {
    const unsigned int index = getChildIndex(child);
    removeChild(index);
    return index;
}
inline void GroupObj::removeChild(int index) {
    removeChild(static_cast<unsigned int>(index));
}
inline void GroupObj::removeChild(unsigned int index) {
    internal::checkIndex("Group::removeChild", index, getChildCount());
    checkError(rtuGroupRemoveChildByIndex(m_group, index));
}
template <typename T>
inline unsigned int GroupObj::getChildIndex(T child) const {
    unsigned int index = 0;
    checkError(rtuGroupGetChildIndex(m_group, internal::api(child), &index));
    return index;
}
inline void GroupObj::setVisibilityMask(RTvisibilitymask mask) {
    checkError(rtGroupSetVisibilityMask(m_group, mask));
}
inline RTvisibilitymask GroupObj::getVisibilityMask() const {
    RTvisibilitymask value = 0;
    checkError(rtGroupGetVisibilityMask(m_group, &value));
    return value;
}

// ---- GeometryGroup ----------------------------------------------------------------------------

inline void GeometryGroupObj::destroy() {
    checkError(rtGeometryGroupDestroy(m_geometrygroup));
    m_geometrygroup = 0;
}
inline void GeometryGroupObj::validate() {
    checkError(rtGeometryGroupValidate(m_geometrygroup));
}
inline Context GeometryGroupObj::getContext() const {
    RTcontext context = 0;
    checkErrorNoGetContext(rtGeometryGroupGetContext(m_geometrygroup, &context));
    return Context::take(context);
}
inline RTgeometrygroup GeometryGroupObj::get() {
    return m_geometrygroup;
}
inline void GeometryGroupObj::setAcceleration(Acceleration acceleration) {
    checkError(rtGeometryGroupSetAcceleration(m_geometrygroup, internal::api(acceleration)));
}
inline Acceleration GeometryGroupObj::getAcceleration() const {
    RTacceleration value = 0;
    checkError(rtGeometryGroupGetAcceleration(m_geometrygroup, &value));
    return Acceleration::take(value);
}
inline void GeometryGroupObj::setChildCount(unsigned int count) {
    checkError(rtGeometryGroupSetChildCount(m_geometrygroup, count));
}
inline unsigned int GeometryGroupObj::getChildCount() const {
    unsigned int value = 0;
    checkError(rtGeometryGroupGetChildCount(m_geometrygroup, &value));
    return value;
}
inline void GeometryGroupObj::setChild(unsigned int index, GeometryInstance geometryinstance) {
    checkError(rtGeometryGroupSetChild(m_geometrygroup, index, internal::api(geometryinstance)));
}
inline GeometryInstance GeometryGroupObj::getChild(unsigned int index) const {
    RTgeometryinstance value = 0;
    checkError(rtGeometryGroupGetChild(m_geometrygroup, index, &value));
    return GeometryInstance::take(value);
}
inline unsigned int GeometryGroupObj::addChild(GeometryInstance child) {
    unsigned int index = 0;
    checkError(rtuGeometryGroupAddChild(m_geometrygroup, internal::api(child), &index));
    return index;
}
inline unsigned int GeometryGroupObj::removeChild(GeometryInstance child) {
    const unsigned int index = getChildIndex(child);
    removeChild(index);
    return index;
}
inline void GeometryGroupObj::removeChild(int index) {
    removeChild(static_cast<unsigned int>(index));
}
inline void GeometryGroupObj::removeChild(unsigned int index) {
    internal::checkIndex("GeometryGroup::removeChild", index, getChildCount());
    checkError(rtuGeometryGroupRemoveChildByIndex(m_geometrygroup, index));
}
inline unsigned int GeometryGroupObj::getChildIndex(GeometryInstance child) const {
    unsigned int index = 0;
    checkError(rtuGeometryGroupGetChildIndex(m_geometrygroup, internal::api(child), &index));
    return index;
}
inline void GeometryGroupObj::setFlags(RTinstanceflags flags) {
    checkError(rtGeometryGroupSetFlags(m_geometrygroup, flags));
}
inline RTinstanceflags GeometryGroupObj::getFlags() const {
    RTinstanceflags value = RTinstanceflags();
    checkError(rtGeometryGroupGetFlags(m_geometrygroup, &value));
    return value;
}
inline void GeometryGroupObj::setVisibilityMask(RTvisibilitymask mask) {
    checkError(rtGeometryGroupSetVisibilityMask(m_geometrygroup, mask));
}
inline RTvisibilitymask GeometryGroupObj::getVisibilityMask() const {
    RTvisibilitymask value = 0;
    checkError(rtGeometryGroupGetVisibilityMask(m_geometrygroup, &value));
    return value;
}

// ---- Transform --------------------------------------------------------------------------------

inline void TransformObj::destroy() {
    checkError(rtTransformDestroy(m_transform));
    m_transform = 0;
}
inline void TransformObj::validate() {
    checkError(rtTransformValidate(m_transform));
}
inline Context TransformObj::getContext() const {
    RTcontext context = 0;
    checkErrorNoGetContext(rtTransformGetContext(m_transform, &context));
    return Context::take(context);
}
inline RTtransform TransformObj::get() {
    return m_transform;
}
template <typename T>
inline void TransformObj::setChild(T child) {
    checkError(rtTransformSetChild(m_transform, internal::api(child)));
}
template <typename T>
inline T TransformObj::getChild() const {
    RTobject child = 0;
    checkError(rtTransformGetChild(m_transform, &child));
    return T::take(child);
}
inline RTobjecttype TransformObj::getChildType() const {
    RTobjecttype value = RTobjecttype();
    checkError(rtTransformGetChildType(m_transform, &value));
    return value;
}
inline void TransformObj::setMatrix(bool transpose, const float* matrix,
                                    const float* inverse_matrix) {
    checkError(rtTransformSetMatrix(m_transform, transpose, matrix, inverse_matrix));
}
inline void TransformObj::getMatrix(bool transpose, float* matrix, float* inverse_matrix) const {
    checkError(rtTransformGetMatrix(m_transform, transpose, matrix, inverse_matrix));
}
inline void TransformObj::setMotionRange(float timeBegin, float timeEnd) {
    checkError(rtTransformSetMotionRange(m_transform, timeBegin, timeEnd));
}
inline void TransformObj::getMotionRange(float& timeBegin, float& timeEnd) {
    checkError(rtTransformGetMotionRange(m_transform, &timeBegin, &timeEnd));
}
inline void TransformObj::setMotionBorderMode(RTmotionbordermode beginMode,
                                              RTmotionbordermode endMode) {
    checkError(rtTransformSetMotionBorderMode(m_transform, beginMode, endMode));
}
inline void TransformObj::getMotionBorderMode(RTmotionbordermode& beginMode,
                                              RTmotionbordermode& endMode) {
    checkError(rtTransformGetMotionBorderMode(m_transform, &beginMode, &endMode));
}
inline void TransformObj::setMotionKeys(unsigned int n, RTmotionkeytype type, const float* keys) {
    checkError(rtTransformSetMotionKeys(m_transform, n, type, keys));
}
inline unsigned int TransformObj::getMotionKeyCount() {
    unsigned int value = 0;
    checkError(rtTransformGetMotionKeyCount(m_transform, &value));
    return value;
}
inline RTmotionkeytype TransformObj::getMotionKeyType() {
    RTmotionkeytype value = RTmotionkeytype();
    checkError(rtTransformGetMotionKeyType(m_transform, &value));
    return value;
}
inline void TransformObj::getMotionKeys(float* keys) {
    checkError(rtTransformGetMotionKeys(m_transform, keys));
}

// ---- Selector ---------------------------------------------------------------------------------

inline void SelectorObj::destroy() {
    checkError(rtSelectorDestroy(m_selector));
    m_selector = 0;
}
inline void SelectorObj::validate() {
    checkError(rtSelectorValidate(m_selector));
}
inline Context SelectorObj::getContext() const {
    RTcontext context = 0;
    checkErrorNoGetContext(rtSelectorGetContext(m_selector, &context));
    return Context::take(context);
}
inline RTselector SelectorObj::get() {
    return m_selector;
}
inline void SelectorObj::setVisitProgram(Program program) {
    checkError(rtSelectorSetVisitProgram(m_selector, internal::api(program)));
}
inline Program SelectorObj::getVisitProgram() const {
    RTprogram value = 0;
    checkError(rtSelectorGetVisitProgram(m_selector, &value));
    return Program::take(value);
}
inline void SelectorObj::setChildCount(unsigned int count) {
    checkError(rtSelectorSetChildCount(m_selector, count));
}
inline unsigned int SelectorObj::getChildCount() const {
    unsigned int value = 0;
    checkError(rtSelectorGetChildCount(m_selector, &value));
    return value;
}
template <typename T>
inline void SelectorObj::setChild(unsigned int index, T child) {
    checkError(rtSelectorSetChild(m_selector, index, internal::api(child)));
}
template <typename T>
inline T SelectorObj::getChild(unsigned int index) const {
    RTobject child = 0;
    checkError(rtSelectorGetChild(m_selector, index, &child));
    return T::take(child);
}
inline RTobjecttype SelectorObj::getChildType(unsigned int index) const {
    RTobjecttype value = RTobjecttype();
    checkError(rtSelectorGetChildType(m_selector, index, &value));
    return value;
}
template <typename T>
inline unsigned int SelectorObj::addChild(T child) {
    unsigned int index = 0;
    checkError(rtuSelectorAddChild(m_selector, internal::api(child), &index));
    return index;
}
template <typename T>
inline unsigned int SelectorObj::removeChild(T child) {
    const unsigned int index = getChildIndex(child);
    removeChild(index);
    return index;
}
inline void SelectorObj::removeChild(int index) {
    removeChild(static_cast<unsigned int>(index));
}
inline void SelectorObj::removeChild(unsigned int index) {
    const unsigned int count = getChildCount();
    internal::checkIndex("Selector::removeChild", index, count);
    for (unsigned int i = index + 1; i < count; ++i) {
        RTobject child = 0;
        checkError(rtSelectorGetChild(m_selector, i, &child));
        checkError(rtSelectorSetChild(m_selector, i - 1, child));
    }
    setChildCount(count - 1);
}
template <typename T>
inline unsigned int SelectorObj::getChildIndex(T child) const {
    unsigned int index = 0;
    checkError(rtuSelectorGetChildIndex(m_selector, internal::api(child), &index));
    return index;
}
inline Variable SelectorObj::declareVariable(const std::string& name) {
    RTvariable value = 0;
    checkError(rtSelectorDeclareVariable(m_selector, name.c_str(), &value));
    return Variable::take(value);
}
inline Variable SelectorObj::queryVariable(const std::string& name) const {
    RTvariable value = 0;
    checkError(rtSelectorQueryVariable(m_selector, name.c_str(), &value));
    return Variable::take(value);
}
inline void SelectorObj::removeVariable(Variable v) {
    checkError(rtSelectorRemoveVariable(m_selector, internal::api(v)));
}
inline unsigned int SelectorObj::getVariableCount() const {
    unsigned int value = 0;
    checkError(rtSelectorGetVariableCount(m_selector, &value));
    return value;
}
inline Variable SelectorObj::getVariable(unsigned int index) const {
    RTvariable value = 0;
    checkError(rtSelectorGetVariable(m_selector, index, &value));
    return Variable::take(value);
}

// ---- Acceleration -----------------------------------------------------------------------------

inline void AccelerationObj::destroy() {
    checkError(rtAccelerationDestroy(m_acceleration));
    m_acceleration = 0;
}
inline void AccelerationObj::validate() {
    checkError(rtAccelerationValidate(m_acceleration));
}
inline Context AccelerationObj::getContext() const {
    RTcontext context = 0;
    checkErrorNoGetContext(rtAccelerationGetContext(m_acceleration, &context));
    return Context::take(context);
}
inline RTacceleration AccelerationObj::get() {
    return m_acceleration;
}
inline void AccelerationObj::markDirty() {
    checkError(rtAccelerationMarkDirty(m_acceleration));
}
inline bool AccelerationObj::isDirty() const {
    int value = 0;
    checkError(rtAccelerationIsDirty(m_acceleration, &value));
    return value != 0;
}
inline void AccelerationObj::setProperty(const std::string& name, const std::string& value) {
    checkError(rtAccelerationSetProperty(m_acceleration, name.c_str(), value.c_str()));
}
inline std::string AccelerationObj::getProperty(const std::string& name) const {
    const char* value = 0;
    checkError(rtAccelerationGetProperty(m_acceleration, name.c_str(), &value));
    return value ? value : "";
}
inline void AccelerationObj::setBuilder(const std::string& builder) {
    checkError(rtAccelerationSetBuilder(m_acceleration, builder.c_str()));
}
inline std::string AccelerationObj::getBuilder() const {
    const char* value = 0;
    checkError(rtAccelerationGetBuilder(m_acceleration, &value));
    return value ? value : "";
}
inline void AccelerationObj::setTraverser(const std::string& traverser) {
    checkError(rtAccelerationSetTraverser(m_acceleration, traverser.c_str()));
}
inline std::string AccelerationObj::getTraverser() const {
    const char* value = 0;
    checkError(rtAccelerationGetTraverser(m_acceleration, &value));
    return value ? value : "";
}
inline RTsize AccelerationObj::getDataSize() const {
    RTsize value = 0;
    checkError(rtAccelerationGetDataSize(m_acceleration, &value));
    return value;
}
inline void AccelerationObj::getData(void* data) const {
    checkError(rtAccelerationGetData(m_acceleration, data));
}
inline void AccelerationObj::setData(const void* data, RTsize size) {
    checkError(rtAccelerationSetData(m_acceleration, data, size));
}

} // namespace optix

#endif
