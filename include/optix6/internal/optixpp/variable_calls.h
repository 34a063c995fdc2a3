// SPDX-License-Identifier: Apache-2.0
// The C++ wrapper of the classic API: the member functions of variable.h.
#ifndef SUNSTONE_OPTIXPP_VARIABLE_CALLS_H
#define SUNSTONE_OPTIXPP_VARIABLE_CALLS_H

#include "calls.h"

namespace optix {

SUNSTONE_DEPRECATED_TYPES_BEGIN

// ---- Variable ---------------------------------------------------------------------------------

inline Context VariableObj::getContext() const {
    RTcontext context = 0;
    checkErrorNoGetContext(rtVariableGetContext(m_variable, &context));
    return Context::take(context);
}
inline RTvariable VariableObj::get() {
    return m_variable;
}
inline std::string VariableObj::getName() const {
    const char* value = 0;
    checkError(rtVariableGetName(m_variable, &value));
    return value ? value : "";
}
inline std::string VariableObj::getAnnotation() const {
    const char* value = 0;
    checkError(rtVariableGetAnnotation(m_variable, &value));
    return value ? value : "";
}
inline RTobjecttype VariableObj::getType() const {
    RTobjecttype value = RTobjecttype();
    checkError(rtVariableGetType(m_variable, &value));
    return value;
}
inline RTsize VariableObj::getSize() const {
    RTsize value = 0;
    checkError(rtVariableGetSize(m_variable, &value));
    return value;
}
inline void VariableObj::setFloat(float f1) {
    checkError(rtVariableSet1f(m_variable, f1));
}
inline void VariableObj::setFloat(float f1, float f2) {
    checkError(rtVariableSet2f(m_variable, f1, f2));
}
inline void VariableObj::setFloat(optix::float2 f) {
    checkError(rtVariableSet2f(m_variable, f.x, f.y));
}
inline void VariableObj::setFloat(float f1, float f2, float f3) {
    checkError(rtVariableSet3f(m_variable, f1, f2, f3));
}
inline void VariableObj::setFloat(optix::float3 f) {
    checkError(rtVariableSet3f(m_variable, f.x, f.y, f.z));
}
inline void VariableObj::setFloat(float f1, float f2, float f3, float f4) {
    checkError(rtVariableSet4f(m_variable, f1, f2, f3, f4));
}
inline void VariableObj::setFloat(optix::float4 f) {
    checkError(rtVariableSet4f(m_variable, f.x, f.y, f.z, f.w));
}
inline void VariableObj::set1fv(const float* f) {
    checkError(rtVariableSet1fv(m_variable, f));
}
inline void VariableObj::set2fv(const float* f) {
    checkError(rtVariableSet2fv(m_variable, f));
}
inline void VariableObj::set3fv(const float* f) {
    checkError(rtVariableSet3fv(m_variable, f));
}
inline void VariableObj::set4fv(const float* f) {
    checkError(rtVariableSet4fv(m_variable, f));
}
inline void VariableObj::setInt(int i1) {
    checkError(rtVariableSet1i(m_variable, i1));
}
inline void VariableObj::setInt(int i1, int i2) {
    checkError(rtVariableSet2i(m_variable, i1, i2));
}
inline void VariableObj::setInt(optix::int2 i) {
    checkError(rtVariableSet2i(m_variable, i.x, i.y));
}
inline void VariableObj::setInt(int i1, int i2, int i3) {
    checkError(rtVariableSet3i(m_variable, i1, i2, i3));
}
inline void VariableObj::setInt(optix::int3 i) {
    checkError(rtVariableSet3i(m_variable, i.x, i.y, i.z));
}
inline void VariableObj::setInt(int i1, int i2, int i3, int i4) {
    checkError(rtVariableSet4i(m_variable, i1, i2, i3, i4));
}
inline void VariableObj::setInt(optix::int4 i) {
    checkError(rtVariableSet4i(m_variable, i.x, i.y, i.z, i.w));
}
inline void VariableObj::set1iv(const int* i) {
    checkError(rtVariableSet1iv(m_variable, i));
}
inline void VariableObj::set2iv(const int* i) {
    checkError(rtVariableSet2iv(m_variable, i));
}
inline void VariableObj::set3iv(const int* i) {
    checkError(rtVariableSet3iv(m_variable, i));
}
inline void VariableObj::set4iv(const int* i) {
    checkError(rtVariableSet4iv(m_variable, i));
}
inline void VariableObj::setUint(unsigned int u1) {
    checkError(rtVariableSet1ui(m_variable, u1));
}
inline void VariableObj::setUint(unsigned int u1, unsigned int u2) {
    checkError(rtVariableSet2ui(m_variable, u1, u2));
}
inline void VariableObj::setUint(optix::uint2 u) {
    checkError(rtVariableSet2ui(m_variable, u.x, u.y));
}
inline void VariableObj::setUint(unsigned int u1, unsigned int u2, unsigned int u3) {
    checkError(rtVariableSet3ui(m_variable, u1, u2, u3));
}
inline void VariableObj::setUint(optix::uint3 u) {
    checkError(rtVariableSet3ui(m_variable, u.x, u.y, u.z));
}
inline void VariableObj::setUint(unsigned int u1, unsigned int u2, unsigned int u3,
                                 unsigned int u4) {
    checkError(rtVariableSet4ui(m_variable, u1, u2, u3, u4));
}
inline void VariableObj::setUint(optix::uint4 u) {
    checkError(rtVariableSet4ui(m_variable, u.x, u.y, u.z, u.w));
}
inline void VariableObj::set1uiv(const unsigned int* u) {
    checkError(rtVariableSet1uiv(m_variable, u));
}
inline void VariableObj::set2uiv(const unsigned int* u) {
    checkError(rtVariableSet2uiv(m_variable, u));
}
inline void VariableObj::set3uiv(const unsigned int* u) {
    checkError(rtVariableSet3uiv(m_variable, u));
}
inline void VariableObj::set4uiv(const unsigned int* u) {
    checkError(rtVariableSet4uiv(m_variable, u));
}
inline void VariableObj::setLongLong(long long i1) {
    checkError(rtVariableSet1ll(m_variable, i1));
}
inline void VariableObj::setLongLong(long long i1, long long i2) {
    checkError(rtVariableSet2ll(m_variable, i1, i2));
}
inline void VariableObj::setLongLong(optix::longlong2 i) {
    checkError(rtVariableSet2ll(m_variable, i.x, i.y));
}
inline void VariableObj::setLongLong(long long i1, long long i2, long long i3) {
    checkError(rtVariableSet3ll(m_variable, i1, i2, i3));
}
inline void VariableObj::setLongLong(optix::longlong3 i) {
    checkError(rtVariableSet3ll(m_variable, i.x, i.y, i.z));
}
inline void VariableObj::setLongLong(long long i1, long long i2, long long i3, long long i4) {
    checkError(rtVariableSet4ll(m_variable, i1, i2, i3, i4));
}
inline void VariableObj::setLongLong(optix::longlong4 i) {
    checkError(rtVariableSet4ll(m_variable, i.x, i.y, i.z, i.w));
}
inline void VariableObj::set1llv(const long long* i) {
    checkError(rtVariableSet1llv(m_variable, i));
}
inline void VariableObj::set2llv(const long long* i) {
    checkError(rtVariableSet2llv(m_variable, i));
}
inline void VariableObj::set3llv(const long long* i) {
    checkError(rtVariableSet3llv(m_variable, i));
}
inline void VariableObj::set4llv(const long long* i) {
    checkError(rtVariableSet4llv(m_variable, i));
}
inline void VariableObj::setULongLong(unsigned long long u1) {
    checkError(rtVariableSet1ull(m_variable, u1));
}
inline void VariableObj::setULongLong(unsigned long long u1, unsigned long long u2) {
    checkError(rtVariableSet2ull(m_variable, u1, u2));
}
inline void VariableObj::setULongLong(optix::ulonglong2 u) {
    checkError(rtVariableSet2ull(m_variable, u.x, u.y));
}
inline void VariableObj::setULongLong(unsigned long long u1, unsigned long long u2,
                                      unsigned long long u3) {
    checkError(rtVariableSet3ull(m_variable, u1, u2, u3));
}
inline void VariableObj::setULongLong(optix::ulonglong3 u) {
    checkError(rtVariableSet3ull(m_variable, u.x, u.y, u.z));
}
inline void VariableObj::setULongLong(unsigned long long u1, unsigned long long u2,
                                      unsigned long long u3, unsigned long long u4) {
    checkError(rtVariableSet4ull(m_variable, u1, u2, u3, u4));
}
inline void VariableObj::setULongLong(optix::ulonglong4 u) {
    checkError(rtVariableSet4ull(m_variable, u.x, u.y, u.z, u.w));
}
inline void VariableObj::set1ullv(const unsigned long long* u) {
    checkError(rtVariableSet1ullv(m_variable, u));
}
inline void VariableObj::set2ullv(const unsigned long long* u) {
    checkError(rtVariableSet2ullv(m_variable, u));
}
inline void VariableObj::set3ullv(const unsigned long long* u) {
    checkError(rtVariableSet3ullv(m_variable, u));
}
inline void VariableObj::set4ullv(const unsigned long long* u) {
    checkError(rtVariableSet4ullv(m_variable, u));
}
inline void VariableObj::setMatrix2x2fv(bool transpose, const float* m) {
    checkError(rtVariableSetMatrix2x2fv(m_variable, transpose, m));
}
inline void VariableObj::setMatrix2x3fv(bool transpose, const float* m) {
    checkError(rtVariableSetMatrix2x3fv(m_variable, transpose, m));
}
inline void VariableObj::setMatrix2x4fv(bool transpose, const float* m) {
    checkError(rtVariableSetMatrix2x4fv(m_variable, transpose, m));
}
inline void VariableObj::setMatrix3x2fv(bool transpose, const float* m) {
    checkError(rtVariableSetMatrix3x2fv(m_variable, transpose, m));
}
inline void VariableObj::setMatrix3x3fv(bool transpose, const float* m) {
    checkError(rtVariableSetMatrix3x3fv(m_variable, transpose, m));
}
inline void VariableObj::setMatrix3x4fv(bool transpose, const float* m) {
    checkError(rtVariableSetMatrix3x4fv(m_variable, transpose, m));
}
inline void VariableObj::setMatrix4x2fv(bool transpose, const float* m) {
    checkError(rtVariableSetMatrix4x2fv(m_variable, transpose, m));
}
inline void VariableObj::setMatrix4x3fv(bool transpose, const float* m) {
    checkError(rtVariableSetMatrix4x3fv(m_variable, transpose, m));
}
inline void VariableObj::setMatrix4x4fv(bool transpose, const float* m) {
    checkError(rtVariableSetMatrix4x4fv(m_variable, transpose, m));
}
inline float VariableObj::getFloat() const {
    float value = 0.0f;
    checkError(rtVariableGet1f(m_variable, &value));
    return value;
}
inline optix::float2 VariableObj::getFloat2() const {
    optix::float2 value;
    checkError(rtVariableGet2f(m_variable, &value.x, &value.y));
    return value;
}
inline optix::float3 VariableObj::getFloat3() const {
    optix::float3 value;
    checkError(rtVariableGet3f(m_variable, &value.x, &value.y, &value.z));
    return value;
}
inline optix::float4 VariableObj::getFloat4() const {
    optix::float4 value;
    checkError(rtVariableGet4f(m_variable, &value.x, &value.y, &value.z, &value.w));
    return value;
}
inline void VariableObj::getFloat(float& f1) const {
    checkError(rtVariableGet1f(m_variable, &f1));
}
inline void VariableObj::getFloat(float& f1, float& f2) const {
    checkError(rtVariableGet2f(m_variable, &f1, &f2));
}
inline void VariableObj::getFloat(float& f1, float& f2, float& f3) const {
    checkError(rtVariableGet3f(m_variable, &f1, &f2, &f3));
}
inline void VariableObj::getFloat(float& f1, float& f2, float& f3, float& f4) const {
    checkError(rtVariableGet4f(m_variable, &f1, &f2, &f3, &f4));
}
inline unsigned VariableObj::getUInt() const {
    unsigned int value = 0;
    checkError(rtVariableGet1ui(m_variable, &value));
    return value;
}
inline optix::uint2 VariableObj::getUInt2() const {
    optix::uint2 value;
    checkError(rtVariableGet2ui(m_variable, &value.x, &value.y));
    return value;
}
inline optix::uint3 VariableObj::getUInt3() const {
    optix::uint3 value;
    checkError(rtVariableGet3ui(m_variable, &value.x, &value.y, &value.z));
    return value;
}
inline optix::uint4 VariableObj::getUInt4() const {
    optix::uint4 value;
    checkError(rtVariableGet4ui(m_variable, &value.x, &value.y, &value.z, &value.w));
    return value;
}
inline void VariableObj::getUInt(unsigned& u1) const {
    checkError(rtVariableGet1ui(m_variable, &u1));
}
inline void VariableObj::getUInt(unsigned& u1, unsigned& u2) const {
    checkError(rtVariableGet2ui(m_variable, &u1, &u2));
}
inline void VariableObj::getUInt(unsigned& u1, unsigned& u2, unsigned& u3) const {
    checkError(rtVariableGet3ui(m_variable, &u1, &u2, &u3));
}
inline void VariableObj::getUInt(unsigned& u1, unsigned& u2, unsigned& u3, unsigned& u4) const {
    checkError(rtVariableGet4ui(m_variable, &u1, &u2, &u3, &u4));
}
inline unsigned VariableObj::getUint() const {
    return getUInt();
}
inline optix::uint2 VariableObj::getUint2() const {
    return getUInt2();
}
inline optix::uint3 VariableObj::getUint3() const {
    return getUInt3();
}
inline optix::uint4 VariableObj::getUint4() const {
    return getUInt4();
}
inline void VariableObj::getUint(unsigned& u1) const {
    getUInt(u1);
}
inline void VariableObj::getUint(unsigned& u1, unsigned& u2) const {
    getUInt(u1, u2);
}
inline void VariableObj::getUint(unsigned& u1, unsigned& u2, unsigned& u3) const {
    getUInt(u1, u2, u3);
}
inline void VariableObj::getUint(unsigned& u1, unsigned& u2, unsigned& u3, unsigned& u4) const {
    getUInt(u1, u2, u3, u4);
}
inline int VariableObj::getInt() const {
    int value = 0;
    checkError(rtVariableGet1i(m_variable, &value));
    return value;
}
inline optix::int2 VariableObj::getInt2() const {
    optix::int2 value;
    checkError(rtVariableGet2i(m_variable, &value.x, &value.y));
    return value;
}
inline optix::int3 VariableObj::getInt3() const {
    optix::int3 value;
    checkError(rtVariableGet3i(m_variable, &value.x, &value.y, &value.z));
    return value;
}
inline optix::int4 VariableObj::getInt4() const {
    optix::int4 value;
    checkError(rtVariableGet4i(m_variable, &value.x, &value.y, &value.z, &value.w));
    return value;
}
inline void VariableObj::getInt(int& i1) const {
    checkError(rtVariableGet1i(m_variable, &i1));
}
inline void VariableObj::getInt(int& i1, int& i2) const {
    checkError(rtVariableGet2i(m_variable, &i1, &i2));
}
inline void VariableObj::getInt(int& i1, int& i2, int& i3) const {
    checkError(rtVariableGet3i(m_variable, &i1, &i2, &i3));
}
inline void VariableObj::getInt(int& i1, int& i2, int& i3, int& i4) const {
    checkError(rtVariableGet4i(m_variable, &i1, &i2, &i3, &i4));
}
inline unsigned long long VariableObj::getULongLong() const {
    unsigned long long value = 0;
    checkError(rtVariableGet1ull(m_variable, &value));
    return value;
}
inline optix::ulonglong2 VariableObj::getULongLong2() const {
    optix::ulonglong2 value;
    checkError(rtVariableGet2ull(m_variable, &value.x, &value.y));
    return value;
}
inline optix::ulonglong3 VariableObj::getULongLong3() const {
    optix::ulonglong3 value;
    checkError(rtVariableGet3ull(m_variable, &value.x, &value.y, &value.z));
    return value;
}
inline optix::ulonglong4 VariableObj::getULongLong4() const {
    optix::ulonglong4 value;
    checkError(rtVariableGet4ull(m_variable, &value.x, &value.y, &value.z, &value.w));
    return value;
}
inline void VariableObj::getULongLong(unsigned long long& ull1) const {
    checkError(rtVariableGet1ull(m_variable, &ull1));
}
inline void VariableObj::getULongLong(unsigned long long& ull1, unsigned long long& ull2) const {
    checkError(rtVariableGet2ull(m_variable, &ull1, &ull2));
}
inline void VariableObj::getULongLong(unsigned long long& ull1, unsigned long long& ull2,
                                      unsigned long long& ull3) const {
    checkError(rtVariableGet3ull(m_variable, &ull1, &ull2, &ull3));
}
inline void VariableObj::getULongLong(unsigned long long& ull1, unsigned long long& ull2,
                                      unsigned long long& ull3, unsigned long long& ull4) const {
    checkError(rtVariableGet4ull(m_variable, &ull1, &ull2, &ull3, &ull4));
}
inline long long VariableObj::getLongLong() const {
    long long value = 0;
    checkError(rtVariableGet1ll(m_variable, &value));
    return value;
}
inline optix::longlong2 VariableObj::getLongLong2() const {
    optix::longlong2 value;
    checkError(rtVariableGet2ll(m_variable, &value.x, &value.y));
    return value;
}
inline optix::longlong3 VariableObj::getLongLong3() const {
    optix::longlong3 value;
    checkError(rtVariableGet3ll(m_variable, &value.x, &value.y, &value.z));
    return value;
}
inline optix::longlong4 VariableObj::getLongLong4() const {
    optix::longlong4 value;
    checkError(rtVariableGet4ll(m_variable, &value.x, &value.y, &value.z, &value.w));
    return value;
}
inline void VariableObj::getLongLong(long long& ll1) const {
    checkError(rtVariableGet1ll(m_variable, &ll1));
}
inline void VariableObj::getLongLong(long long& ll1, long long& ll2) const {
    checkError(rtVariableGet2ll(m_variable, &ll1, &ll2));
}
inline void VariableObj::getLongLong(long long& ll1, long long& ll2, long long& ll3) const {
    checkError(rtVariableGet3ll(m_variable, &ll1, &ll2, &ll3));
}
inline void VariableObj::getLongLong(long long& ll1, long long& ll2, long long& ll3,
                                     long long& ll4) const {
    checkError(rtVariableGet4ll(m_variable, &ll1, &ll2, &ll3, &ll4));
}
inline void VariableObj::getMatrix2x2(bool transpose, float* m) const {
    checkError(rtVariableGetMatrix2x2fv(m_variable, transpose, m));
}
inline void VariableObj::getMatrix2x3(bool transpose, float* m) const {
    checkError(rtVariableGetMatrix2x3fv(m_variable, transpose, m));
}
inline void VariableObj::getMatrix2x4(bool transpose, float* m) const {
    checkError(rtVariableGetMatrix2x4fv(m_variable, transpose, m));
}
inline void VariableObj::getMatrix3x2(bool transpose, float* m) const {
    checkError(rtVariableGetMatrix3x2fv(m_variable, transpose, m));
}
inline void VariableObj::getMatrix3x3(bool transpose, float* m) const {
    checkError(rtVariableGetMatrix3x3fv(m_variable, transpose, m));
}
inline void VariableObj::getMatrix3x4(bool transpose, float* m) const {
    checkError(rtVariableGetMatrix3x4fv(m_variable, transpose, m));
}
inline void VariableObj::getMatrix4x2(bool transpose, float* m) const {
    checkError(rtVariableGetMatrix4x2fv(m_variable, transpose, m));
}
inline void VariableObj::getMatrix4x3(bool transpose, float* m) const {
    checkError(rtVariableGetMatrix4x3fv(m_variable, transpose, m));
}
inline void VariableObj::getMatrix4x4(bool transpose, float* m) const {
    checkError(rtVariableGetMatrix4x4fv(m_variable, transpose, m));
}
inline void VariableObj::setBuffer(Buffer buffer) {
    checkError(rtVariableSetObject(m_variable, internal::api(buffer)));
}
inline void VariableObj::set(Buffer buffer) {
    checkError(rtVariableSetObject(m_variable, internal::api(buffer)));
}
inline void VariableObj::setTextureSampler(TextureSampler texturesample) {
    checkError(rtVariableSetObject(m_variable, internal::api(texturesample)));
}
inline void VariableObj::set(TextureSampler texturesample) {
    checkError(rtVariableSetObject(m_variable, internal::api(texturesample)));
}
inline void VariableObj::set(GeometryGroup group) {
    checkError(rtVariableSetObject(m_variable, internal::api(group)));
}
inline void VariableObj::set(Group group) {
    checkError(rtVariableSetObject(m_variable, internal::api(group)));
}
inline void VariableObj::set(Program program) {
    checkError(rtVariableSetObject(m_variable, internal::api(program)));
}
inline void VariableObj::set(Selector selector) {
    checkError(rtVariableSetObject(m_variable, internal::api(selector)));
}
inline void VariableObj::set(Transform transform) {
    checkError(rtVariableSetObject(m_variable, internal::api(transform)));
}
inline void VariableObj::setProgramId(Program program) {
    setInt(program->getId());
}
inline Buffer VariableObj::getBuffer() const {
    RTobject value = 0;
    checkError(rtVariableGetObject(m_variable, &value));
    return Buffer::take(value);
}
inline GeometryGroup VariableObj::getGeometryGroup() const {
    RTobject value = 0;
    checkError(rtVariableGetObject(m_variable, &value));
    return GeometryGroup::take(value);
}
inline GeometryInstance VariableObj::getGeometryInstance() const {
    RTobject value = 0;
    checkError(rtVariableGetObject(m_variable, &value));
    return GeometryInstance::take(value);
}
inline Group VariableObj::getGroup() const {
    RTobject value = 0;
    checkError(rtVariableGetObject(m_variable, &value));
    return Group::take(value);
}
inline Program VariableObj::getProgram() const {
    RTobject value = 0;
    checkError(rtVariableGetObject(m_variable, &value));
    return Program::take(value);
}
inline Selector VariableObj::getSelector() const {
    RTobject value = 0;
    checkError(rtVariableGetObject(m_variable, &value));
    return Selector::take(value);
}
inline TextureSampler VariableObj::getTextureSampler() const {
    RTobject value = 0;
    checkError(rtVariableGetObject(m_variable, &value));
    return TextureSampler::take(value);
}
inline Transform VariableObj::getTransform() const {
    RTobject value = 0;
    checkError(rtVariableGetObject(m_variable, &value));
    return Transform::take(value);
}
inline void VariableObj::setUserData(RTsize size, const void* ptr) {
    checkError(rtVariableSetUserData(m_variable, size, ptr));
}
inline void VariableObj::getUserData(RTsize size, void* ptr) const {
    checkError(rtVariableGetUserData(m_variable, size, ptr));
}

SUNSTONE_DEPRECATED_TYPES_END

} // namespace optix

#endif
