// SPDX-License-Identifier: Apache-2.0
// Scenes that can be launched: at the start of a sequence, and again after calls have broken them.
#include "calls.h"

namespace fuzz {
namespace {

RTbuffer newBuffer(RTcontext context, RTformat format, RTsize size, unsigned value) {
    RTbuffer made = nullptr;
    void* data = nullptr;
    rtBufferCreate(context, RT_BUFFER_INPUT_OUTPUT, &made);
    rtBufferSetFormat(made, format);
    rtBufferSetSize1D(made, size);
    rtBufferMap(made, &data);
    const size_t words = size * (format == RT_FORMAT_FLOAT ? 1 : 3);
    for (size_t i = 0; i < words; ++i)
        static_cast<uint32_t*>(data)[i] = value ? uint32_t(i % value) : 0;
    rtBufferUnmap(made);
    return made;
}

RTgeometrygroup newGeometryGroup(World& w, RTcontext context) {
    RTgeometry geometry = nullptr;
    RTmaterial material = nullptr;
    RTgeometryinstance instance = nullptr;
    RTgeometrygroup group = nullptr;
    RTacceleration acceleration = nullptr;
    rtGeometryCreate(context, &geometry);
    rtGeometrySetPrimitiveCount(geometry, 3);
    rtGeometrySetIntersectionProgram(geometry, newProgram(w, context, "square_hit"));
    rtGeometrySetBoundingBoxProgram(geometry, newProgram(w, context, "square_bounds"));
    rtMaterialCreate(context, &material);
    rtMaterialSetClosestHitProgram(material, 0, newProgram(w, context, "hit_mark"));
    rtGeometryInstanceCreate(context, &instance);
    rtGeometryInstanceSetGeometry(instance, geometry);
    rtGeometryInstanceSetMaterialCount(instance, 1);
    rtGeometryInstanceSetMaterial(instance, 0, material);
    rtAccelerationCreate(context, &acceleration);
    rtAccelerationSetBuilder(acceleration, "Trbvh");
    rtGeometryGroupCreate(context, &group);
    rtGeometryGroupSetAcceleration(group, acceleration);
    rtGeometryGroupSetChildCount(group, 1);
    rtGeometryGroupSetChild(group, 0, instance);
    w.note(typeid(RTgeometry), geometry);
    w.note(typeid(RTmaterial), material);
    w.note(typeid(RTgeometryinstance), instance);
    w.note(typeid(RTacceleration), acceleration);
    w.note(typeid(RTgeometrygroup), group);
    return group;
}

// Creates what a launch of the first scene needs, or restores it after calls have removed it.
void furnish(World& w, RTcontext context, bool isNew) {
    const auto variable = [&](const char* name) {
        RTvariable found = nullptr;
        rtContextQueryVariable(context, name, &found);
        if (found)
            rtContextRemoveVariable(context, found); // its type may be another
        rtContextDeclareVariable(context, name, &found);
        w.note(typeid(RTvariable), found);
        return found;
    };
    rtContextSetRayTypeCount(context, 2);
    rtContextSetEntryPointCount(context, 1);
    rtContextSetRayGenerationProgram(
        context, 0, newProgram(w, context, w.anyOf({"shoot", "shoot_far", "shoot_at"})));
    const RTbuffer results = newBuffer(context, RT_FORMAT_FLOAT, 64, 0);
    RTbuffer picture = nullptr;
    rtBufferCreate(context, RT_BUFFER_OUTPUT, &picture);
    rtBufferSetFormat(picture, RT_FORMAT_FLOAT4);
    rtBufferSetSize2D(picture, 8, 8);
    w.note(typeid(RTbuffer), results);
    w.note(typeid(RTbuffer), picture);
    w.note(typeid(RTbuffer), newBuffer(context, RT_FORMAT_FLOAT3, 16, 3));
    rtVariableSetObject(variable("result"), results);
    rtVariableSetObject(variable("picture"), picture);
    for (const char* name : {"step", "mark", "height", "ray_time", "scoped"})
        rtVariableSet1f(variable(name), 1);
    for (const char* name : {"ray_type", "flags"})
        rtVariableSet1ui(variable(name), 0);
    for (const char* name : {"chosen", "materials", "element", "texture_id", "by_id"})
        rtVariableSet1i(variable(name), 1);
    // A new group, or one of the graph that the calls have made.
    const RTvariable top = variable("top_object");
    if (isNew || w.chance(60) || rtVariableSetObject(top, anyObject(w, nodes())) != RT_SUCCESS)
        rtVariableSetObject(top, newGeometryGroup(w, context));
}

} // namespace

RTresult repair(World& w) {
    for (void* buffer : w.all<RTbuffer>())
        while (rtBufferUnmap(static_cast<RTbuffer>(buffer)) == RT_SUCCESS)
            ;
    const RTcontext context = w.handle<RTcontext>();
    unsigned count = 0;
    if (rtContextGetEntryPointCount(context, &count) != RT_SUCCESS)
        return RT_ERROR_INVALID_CONTEXT;
    furnish(w, context, false);
    return RT_SUCCESS;
}

void createContext(World& w) {
    RTcontext context = nullptr;
    const RTresult result = rtContextCreate(&context);
    if (result != RT_SUCCESS)
        fail("no context");
    w.note(typeid(RTcontext), context);
    w.indices[context] = newBuffer(context, RT_FORMAT_UNSIGNED_INT3, 40, 3);
    w.zeros[context] = newBuffer(context, RT_FORMAT_UNSIGNED_INT3, 40, 0);
    furnish(w, context, true);
    const RTresult launched = rtContextLaunch2D(context, 0, 2, 3);
    const char* text = nullptr;
    rtContextGetErrorString(context, launched, &text);
    if (launched != RT_SUCCESS)
        fail(std::string("the first scene cannot be launched: ") + text);
}

void destroyContext(World& w) {
    std::vector<void*>& contexts = w.all<RTcontext>();
    const auto dead = static_cast<RTcontext>(contexts[w.below(contexts.size())]);
    rtContextDestroy(dead);
    w.indices.erase(dead);
    w.zeros.erase(dead);
    if (w.chance(90)) { // else calls name dead handles for a while
        const std::vector<void*> others = contexts;
        w.live.clear();
        for (void* each : others)
            if (each != dead)
                w.note(typeid(RTcontext), each);
    }
    createContext(w);
}

} // namespace fuzz
