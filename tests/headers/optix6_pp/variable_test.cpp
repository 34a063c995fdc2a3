// SPDX-License-Identifier: Apache-2.0
// The C++ wrapper of the classic API on a C API that records its calls: variables. Arguments have
// different values, so that swapped ones are found.
#include "fixture.h"

TEST_F(OptixPpMembers, VariableSettersAndGetters) {
    CALLS(variable->getName(), "rtVariableGetName(variable, out)");
    CALLS(variable->getAnnotation(), "rtVariableGetAnnotation(variable, out)");
    CALLS(variable->getType(), "rtVariableGetType(variable, out)");
    CALLS(variable->getSize(), "rtVariableGetSize(variable, out)");
    CALLS(variable->setFloat(2.5f), "rtVariableSet1f(variable, 2.5)");
    CALLS(variable->setFloat(2.5f, 3.5f), "rtVariableSet2f(variable, 2.5, 3.5)");
    CALLS(variable->setFloat(make_float2(2.5f, 3.5f)), "rtVariableSet2f(variable, 2.5, 3.5)");
    CALLS(variable->setFloat(2.5f, 3.5f, 4.5f), "rtVariableSet3f(variable, 2.5, 3.5, 4.5)");
    CALLS(variable->setFloat(make_float3(2.5f, 3.5f, 4.5f)),
          "rtVariableSet3f(variable, 2.5, 3.5, 4.5)");
    CALLS(variable->setFloat(2.5f, 3.5f, 4.5f, 5.5f),
          "rtVariableSet4f(variable, 2.5, 3.5, 4.5, 5.5)");
    CALLS(variable->setFloat(make_float4(2.5f, 3.5f, 4.5f, 5.5f)),
          "rtVariableSet4f(variable, 2.5, 3.5, 4.5, 5.5)");
    CALLS(variable->set1fv(input<float>()), "rtVariableSet1fv(variable, input)");
    CALLS(variable->set2fv(input<float>()), "rtVariableSet2fv(variable, input)");
    CALLS(variable->set3fv(input<float>()), "rtVariableSet3fv(variable, input)");
    CALLS(variable->set4fv(input<float>()), "rtVariableSet4fv(variable, input)");
    CALLS(variable->setInt(2), "rtVariableSet1i(variable, 2)");
    CALLS(variable->setInt(2, 3), "rtVariableSet2i(variable, 2, 3)");
    CALLS(variable->setInt(make_int2(2, 3)), "rtVariableSet2i(variable, 2, 3)");
    CALLS(variable->setInt(2, 3, 4), "rtVariableSet3i(variable, 2, 3, 4)");
    CALLS(variable->setInt(make_int3(2, 3, 4)), "rtVariableSet3i(variable, 2, 3, 4)");
    CALLS(variable->setInt(2, 3, 4, 5), "rtVariableSet4i(variable, 2, 3, 4, 5)");
    CALLS(variable->setInt(make_int4(2, 3, 4, 5)), "rtVariableSet4i(variable, 2, 3, 4, 5)");
    CALLS(variable->set1iv(input<int>()), "rtVariableSet1iv(variable, input)");
    CALLS(variable->set2iv(input<int>()), "rtVariableSet2iv(variable, input)");
    CALLS(variable->set3iv(input<int>()), "rtVariableSet3iv(variable, input)");
    CALLS(variable->set4iv(input<int>()), "rtVariableSet4iv(variable, input)");
    CALLS(variable->setUint(2u), "rtVariableSet1ui(variable, 2)");
    CALLS(variable->setUint(2u, 3u), "rtVariableSet2ui(variable, 2, 3)");
    CALLS(variable->setUint(make_uint2(2u, 3u)), "rtVariableSet2ui(variable, 2, 3)");
    CALLS(variable->setUint(2u, 3u, 4u), "rtVariableSet3ui(variable, 2, 3, 4)");
    CALLS(variable->setUint(make_uint3(2u, 3u, 4u)), "rtVariableSet3ui(variable, 2, 3, 4)");
    CALLS(variable->setUint(2u, 3u, 4u, 5u), "rtVariableSet4ui(variable, 2, 3, 4, 5)");
    CALLS(variable->setUint(make_uint4(2u, 3u, 4u, 5u)), "rtVariableSet4ui(variable, 2, 3, 4, 5)");
    CALLS(variable->set1uiv(input<unsigned int>()), "rtVariableSet1uiv(variable, input)");
    CALLS(variable->set2uiv(input<unsigned int>()), "rtVariableSet2uiv(variable, input)");
    CALLS(variable->set3uiv(input<unsigned int>()), "rtVariableSet3uiv(variable, input)");
    CALLS(variable->set4uiv(input<unsigned int>()), "rtVariableSet4uiv(variable, input)");
    CALLS(variable->setLongLong(2), "rtVariableSet1ll(variable, 2)");
    CALLS(variable->setLongLong(2, 3), "rtVariableSet2ll(variable, 2, 3)");
    CALLS(variable->setLongLong(make_longlong2(2, 3)), "rtVariableSet2ll(variable, 2, 3)");
    CALLS(variable->setLongLong(2, 3, 4), "rtVariableSet3ll(variable, 2, 3, 4)");
    CALLS(variable->setLongLong(make_longlong3(2, 3, 4)), "rtVariableSet3ll(variable, 2, 3, 4)");
    CALLS(variable->setLongLong(2, 3, 4, 5), "rtVariableSet4ll(variable, 2, 3, 4, 5)");
    CALLS(variable->setLongLong(make_longlong4(2, 3, 4, 5)),
          "rtVariableSet4ll(variable, 2, 3, 4, 5)");
    CALLS(variable->set1llv(input<long long>()), "rtVariableSet1llv(variable, input)");
    CALLS(variable->set2llv(input<long long>()), "rtVariableSet2llv(variable, input)");
    CALLS(variable->set3llv(input<long long>()), "rtVariableSet3llv(variable, input)");
    CALLS(variable->set4llv(input<long long>()), "rtVariableSet4llv(variable, input)");
    CALLS(variable->setULongLong(2u), "rtVariableSet1ull(variable, 2)");
    CALLS(variable->setULongLong(2u, 3u), "rtVariableSet2ull(variable, 2, 3)");
    CALLS(variable->setULongLong(make_ulonglong2(2u, 3u)), "rtVariableSet2ull(variable, 2, 3)");
    CALLS(variable->setULongLong(2u, 3u, 4u), "rtVariableSet3ull(variable, 2, 3, 4)");
    CALLS(variable->setULongLong(make_ulonglong3(2u, 3u, 4u)),
          "rtVariableSet3ull(variable, 2, 3, 4)");
    CALLS(variable->setULongLong(2u, 3u, 4u, 5u), "rtVariableSet4ull(variable, 2, 3, 4, 5)");
    CALLS(variable->setULongLong(make_ulonglong4(2u, 3u, 4u, 5u)),
          "rtVariableSet4ull(variable, 2, 3, 4, 5)");
    CALLS(variable->set1ullv(input<unsigned long long>()), "rtVariableSet1ullv(variable, input)");
    CALLS(variable->set2ullv(input<unsigned long long>()), "rtVariableSet2ullv(variable, input)");
    CALLS(variable->set3ullv(input<unsigned long long>()), "rtVariableSet3ullv(variable, input)");
    CALLS(variable->set4ullv(input<unsigned long long>()), "rtVariableSet4ullv(variable, input)");
    CALLS(variable->setMatrix2x2fv(true, input<float>()),
          "rtVariableSetMatrix2x2fv(variable, 1, input)");
    CALLS(variable->setMatrix2x3fv(true, input<float>()),
          "rtVariableSetMatrix2x3fv(variable, 1, input)");
    CALLS(variable->setMatrix2x4fv(true, input<float>()),
          "rtVariableSetMatrix2x4fv(variable, 1, input)");
    CALLS(variable->setMatrix3x2fv(true, input<float>()),
          "rtVariableSetMatrix3x2fv(variable, 1, input)");
    CALLS(variable->setMatrix3x3fv(true, input<float>()),
          "rtVariableSetMatrix3x3fv(variable, 1, input)");
    CALLS(variable->setMatrix3x4fv(true, input<float>()),
          "rtVariableSetMatrix3x4fv(variable, 1, input)");
    CALLS(variable->setMatrix4x2fv(true, input<float>()),
          "rtVariableSetMatrix4x2fv(variable, 1, input)");
    CALLS(variable->setMatrix4x3fv(true, input<float>()),
          "rtVariableSetMatrix4x3fv(variable, 1, input)");
    CALLS(variable->setMatrix4x4fv(true, input<float>()),
          "rtVariableSetMatrix4x4fv(variable, 1, input)");
    CALLS(variable->getFloat(), "rtVariableGet1f(variable, out)");
    CALLS(variable->getFloat(out<float>()), "rtVariableGet1f(variable, out)");
    CALLS(variable->getFloat(out<float>(), out<float>()), "rtVariableGet2f(variable, out, out)");
    CALLS(variable->getFloat(out<float>(), out<float>(), out<float>()),
          "rtVariableGet3f(variable, out, out, out)");
    CALLS(variable->getFloat(out<float>(), out<float>(), out<float>(), out<float>()),
          "rtVariableGet4f(variable, out, out, out, out)");
    CALLS(variable->getUInt(), "rtVariableGet1ui(variable, out)");
    CALLS(variable->getUInt(out<unsigned>()), "rtVariableGet1ui(variable, out)");
    CALLS(variable->getUInt(out<unsigned>(), out<unsigned>()),
          "rtVariableGet2ui(variable, out, out)");
    CALLS(variable->getUInt(out<unsigned>(), out<unsigned>(), out<unsigned>()),
          "rtVariableGet3ui(variable, out, out, out)");
    CALLS(variable->getUInt(out<unsigned>(), out<unsigned>(), out<unsigned>(), out<unsigned>()),
          "rtVariableGet4ui(variable, out, out, out, out)");
    CALLS(variable->getInt(), "rtVariableGet1i(variable, out)");
    CALLS(variable->getInt(out<int>()), "rtVariableGet1i(variable, out)");
    CALLS(variable->getInt(out<int>(), out<int>()), "rtVariableGet2i(variable, out, out)");
    CALLS(variable->getInt(out<int>(), out<int>(), out<int>()),
          "rtVariableGet3i(variable, out, out, out)");
    CALLS(variable->getInt(out<int>(), out<int>(), out<int>(), out<int>()),
          "rtVariableGet4i(variable, out, out, out, out)");
    CALLS(variable->getULongLong(), "rtVariableGet1ull(variable, out)");
    CALLS(variable->getULongLong(out<unsigned long long>()), "rtVariableGet1ull(variable, out)");
    CALLS(variable->getULongLong(out<unsigned long long>(), out<unsigned long long>()),
          "rtVariableGet2ull(variable, out, out)");
    CALLS(variable->getULongLong(out<unsigned long long>(), out<unsigned long long>(),
                                 out<unsigned long long>()),
          "rtVariableGet3ull(variable, out, out, out)");
    CALLS(variable->getULongLong(out<unsigned long long>(), out<unsigned long long>(),
                                 out<unsigned long long>(), out<unsigned long long>()),
          "rtVariableGet4ull(variable, out, out, out, out)");
    CALLS(variable->getLongLong(), "rtVariableGet1ll(variable, out)");
    CALLS(variable->getLongLong(out<long long>()), "rtVariableGet1ll(variable, out)");
    CALLS(variable->getLongLong(out<long long>(), out<long long>()),
          "rtVariableGet2ll(variable, out, out)");
    CALLS(variable->getLongLong(out<long long>(), out<long long>(), out<long long>()),
          "rtVariableGet3ll(variable, out, out, out)");
    CALLS(variable->getLongLong(out<long long>(), out<long long>(), out<long long>(),
                                out<long long>()),
          "rtVariableGet4ll(variable, out, out, out, out)");
    CALLS(variable->getMatrix2x2(true, &out<float>()),
          "rtVariableGetMatrix2x2fv(variable, 1, out)");
    CALLS(variable->getMatrix2x3(true, &out<float>()),
          "rtVariableGetMatrix2x3fv(variable, 1, out)");
    CALLS(variable->getMatrix2x4(true, &out<float>()),
          "rtVariableGetMatrix2x4fv(variable, 1, out)");
    CALLS(variable->getMatrix3x2(true, &out<float>()),
          "rtVariableGetMatrix3x2fv(variable, 1, out)");
    CALLS(variable->getMatrix3x3(true, &out<float>()),
          "rtVariableGetMatrix3x3fv(variable, 1, out)");
    CALLS(variable->getMatrix3x4(true, &out<float>()),
          "rtVariableGetMatrix3x4fv(variable, 1, out)");
    CALLS(variable->getMatrix4x2(true, &out<float>()),
          "rtVariableGetMatrix4x2fv(variable, 1, out)");
    CALLS(variable->getMatrix4x3(true, &out<float>()),
          "rtVariableGetMatrix4x3fv(variable, 1, out)");
    CALLS(variable->getMatrix4x4(true, &out<float>()),
          "rtVariableGetMatrix4x4fv(variable, 1, out)");
    CALLS(variable->setBuffer(buffer), "rtVariableSetObject(variable, buffer)");
    CALLS(variable->set(buffer), "rtVariableSetObject(variable, buffer)");
    CALLS(variable->setTextureSampler(sampler), "rtVariableSetObject(variable, sampler)");
    CALLS(variable->set(sampler), "rtVariableSetObject(variable, sampler)");
    CALLS(variable->set(geometryGroup), "rtVariableSetObject(variable, geometryGroup)");
    CALLS(variable->set(group), "rtVariableSetObject(variable, group)");
    CALLS(variable->set(program), "rtVariableSetObject(variable, program)");
    CALLS(variable->set(selector), "rtVariableSetObject(variable, selector)");
    CALLS(variable->set(transform), "rtVariableSetObject(variable, transform)");
    CALLS(variable->getBuffer(), "rtVariableGetObject(variable, out)");
    CALLS(variable->getGeometryGroup(), "rtVariableGetObject(variable, out)");
    CALLS(variable->getGeometryInstance(), "rtVariableGetObject(variable, out)");
    CALLS(variable->getGroup(), "rtVariableGetObject(variable, out)");
    CALLS(variable->getProgram(), "rtVariableGetObject(variable, out)");
    CALLS(variable->getSelector(), "rtVariableGetObject(variable, out)");
    CALLS(variable->getTextureSampler(), "rtVariableGetObject(variable, out)");
    CALLS(variable->getTransform(), "rtVariableGetObject(variable, out)");
    CALLS(variable->setUserData(2u, memory), "rtVariableSetUserData(variable, 2, memory)");
    CALLS(variable->getUserData(2u, memory), "rtVariableGetUserData(variable, 2, memory)");
}

TEST_F(OptixPpMembers, VariableGettersOfVectors) {
#define VECTOR(name, letters, type)                                                                \
    CALLS(variable->get##name##2(), "rtVariableGet2" letters "(variable, out, out)");              \
    CALLS(variable->get##name##3(), "rtVariableGet3" letters "(variable, out, out, out)");         \
    CALLS(variable->get##name##4(), "rtVariableGet4" letters "(variable, out, out, out, out)");    \
    EXPECT_EQ(variable->get##name##4().w, static_cast<type>(Recorder::kNumber));
    VECTOR(Float, "f", float)
    VECTOR(Int, "i", int)
    VECTOR(UInt, "ui", unsigned)
    VECTOR(Uint, "ui", unsigned)
    VECTOR(LongLong, "ll", long long)
    VECTOR(ULongLong, "ull", unsigned long long)
#undef VECTOR
    CALLS(variable->getUint(), "rtVariableGet1ui(variable, out)");
    unsigned a, b, c, d;
    CALLS(variable->getUint(a), "rtVariableGet1ui(variable, out)");
    CALLS(variable->getUint(a, b), "rtVariableGet2ui(variable, out, out)");
    CALLS(variable->getUint(a, b, c), "rtVariableGet3ui(variable, out, out, out)");
    CALLS(variable->getUint(a, b, c, d), "rtVariableGet4ui(variable, out, out, out, out)");
    CALLS(variable->setProgramId(program), "rtProgramGetId(program, out)",
          "rtVariableSet1i(variable, 41)");
}
