// SPDX-License-Identifier: Apache-2.0
// Random calls: functions whose types do not determine their arguments, and all others by their
// names in functions.inc, which CMake generates from the headers.
#include "calls.h"

#include <algorithm>
#include <set>
#include <tuple>

namespace fuzz {

RTobject anyObject(World& w, const std::vector<std::type_index>& kinds) {
    const std::vector<void*>& objects = w.live[kinds[w.below(kinds.size())]];
    return objects.empty() || w.chance(3) ? RTobject(w.handle<RTmaterial>())
                                          : objects[w.below(objects.size())];
}

const std::vector<std::type_index>& nodes() {
    static const std::vector<std::type_index> all = {typeid(RTgroup), typeid(RTgeometrygroup),
                                                     typeid(RTtransform), typeid(RTselector)};
    return all;
}

RTprogram newProgram(World& w, RTcontext context, const char* name) {
    RTprogram made = nullptr;
    for (const std::string* text : w.texts)
        if (!made)
            rtProgramCreateFromPTXString(context, text->c_str(), name, &made);
    if (made)
        w.note(typeid(RTprogram), made);
    return made;
}

namespace {

// ---- Functions whose types do not determine their arguments ------------------------------------

RTresult setObject(World& w) {
    std::vector<std::type_index> kinds = nodes();
    kinds.insert(kinds.end(), {typeid(RTbuffer), typeid(RTprogram), typeid(RTtexturesampler)});
    return rtVariableSetObject(w.handle<RTvariable>(), anyObject(w, kinds));
}
RTresult setGroupChild(World& w) {
    return rtGroupSetChild(w.handle<RTgroup>(), unsigned(w.below(5)), anyObject(w, nodes()));
}
RTresult setSelectorChild(World& w) {
    return rtSelectorSetChild(w.handle<RTselector>(), unsigned(w.below(5)), anyObject(w, nodes()));
}
RTresult setTransformChild(World& w) {
    return rtTransformSetChild(w.handle<RTtransform>(), anyObject(w, nodes()));
}

RTresult createProgram(World& w) {
    RTprogram made = nullptr;
    std::string text = *w.texts[w.below(2)];
    const char* name = w.chance(97) ? w.anyOf(kPrograms) : nullptr;
    const bool isChanged = w.chance(6);
    if (isChanged && w.chance(60))
        text.resize(w.below(text.size()));
    else if (isChanged)
        text[w.below(text.size())] = char(w.random());
    const char* several[2] = {text.c_str(), w.texts[w.below(2)]->c_str()};
    const RTcontext context = w.handle<RTcontext>();
    const RTresult result =
        w.chance(70)
            ? rtProgramCreateFromPTXString(context, w.chance(98) ? several[0] : nullptr, name,
                                           &made)
            : rtProgramCreateFromPTXStrings(context, unsigned(w.below(3)), several, name, &made);
    if (made && isChanged)
        rtProgramDestroy(made); // it might write anywhere
    else if (made)
        w.note(typeid(RTprogram), made);
    return result;
}

// A program that suits the place, which random ones seldom do.
RTresult setProgram(World& w) {
    const RTcontext context = w.handle<RTcontext>();
    const auto made = [&](std::initializer_list<const char*> names) {
        return newProgram(w, context, names.begin()[w.below(names.size())]);
    };
    switch (w.below(8)) {
    case 0:
        return rtContextSetRayGenerationProgram(
            context, 0,
            made({"shoot", "shoot_far", "shoot_at", "read_ids", "read_outside", "write_scoped",
                  "call_programs", "sample", "print_index", "throw_user"}));
    case 1:
        return rtContextSetMissProgram(context, unsigned(w.below(2)), made({"missed"}));
    case 2:
        return rtMaterialSetClosestHitProgram(
            w.handle<RTmaterial>(), unsigned(w.below(2)),
            made({"hit_mark", "hit_world", "hit_triangle", "hit_tag", "hit_again"}));
    case 3:
        return rtMaterialSetAnyHitProgram(
            w.handle<RTmaterial>(), unsigned(w.below(2)),
            made({"count_any", "ignore_any", "terminate_any", "any_random"}));
    case 4:
        return rtGeometrySetIntersectionProgram(w.handle<RTgeometry>(),
                                                made({"square_hit", "two_hits", "intersect_all"}));
    case 5:
        return rtGeometrySetBoundingBoxProgram(
            w.handle<RTgeometry>(), made({"square_bounds", "bound_any", "bound_motion"}));
    case 6:
        return rtSelectorSetVisitProgram(w.handle<RTselector>(),
                                         made({"visit_chosen", "visit_many"}));
    default:
        return rtGeometryTrianglesSetAttributeProgram(w.handle<RTgeometrytriangles>(),
                                                      made({"attribute_tag"}));
    }
}

// New contents of a buffer, of the size that the API reports.
RTresult fillBuffer(World& w) {
    const RTbuffer buffer = w.handle<RTbuffer>();
    void* data = nullptr;
    RTsize sizes[3] = {1, 1, 1}, element = 0;
    unsigned dimensions = 0;
    rtBufferGetDimensionality(buffer, &dimensions);
    rtBufferGetSizev(buffer, dimensions, sizes);
    rtBufferGetElementSize(buffer, &element);
    const RTresult result = rtBufferMapEx(buffer, unsigned(1u << w.below(4)), 0, nullptr, &data);
    if (result == RT_SUCCESS && data && dimensions)
        w.fill(data, sizes[0] * sizes[1] * sizes[2] * element);
    if (w.chance(95))
        rtBufferUnmap(buffer);
    return result;
}
RTresult setDevicePointer(World& w) {
    const RTbuffer buffer = w.handle<RTbuffer>();
    RTsize sizes[3] = {1, 1, 1}, element = 0;
    unsigned dimensions = 0;
    rtBufferGetDimensionality(buffer, &dimensions);
    rtBufferGetSizev(buffer, dimensions, sizes);
    rtBufferGetElementSize(buffer, &element);
    if (double(sizes[0]) * double(sizes[1]) * double(sizes[2]) * double(element) > kScratch / 4)
        return RT_ERROR_INVALID_VALUE;
    // The size stays: the buffer is not among those that further calls may enlarge.
    std::vector<void*>& all = w.all<RTbuffer>();
    const RTresult result =
        rtBufferSetDevicePointer(buffer, int(w.below(2)), w.memory[w.below(4)].data());
    if (result == RT_SUCCESS)
        all.erase(std::remove(all.begin(), all.end(), buffer), all.end());
    return result;
}

// Small sizes, or sizes that no machine has: those between would take all memory.
RTresult setSizes(World& w) {
    RTsize sizes[3] = {};
    for (RTsize& size : sizes)
        size = w.chance(97) ? w.below(20) : w.anyOf<RTsize>({~RTsize(0), RTsize(1) << 62});
    return rtBufferSetSizev(w.handle<RTbuffer>(), unsigned(wholeNumber(w)),
                            w.chance(97) ? sizes : nullptr);
}

RTcontext contextOf(RTgeometrytriangles triangles) {
    RTcontext context = nullptr;
    rtGeometryTrianglesGetContext(triangles, &context);
    return context;
}
RTresult setVertices(World& w) {
    const RTgeometrytriangles triangles = w.handle<RTgeometrytriangles>();
    const RTsize stride = w.chance(60) ? 0 : w.below(20) * 4;
    const unsigned count = 3 + unsigned(w.chance(80) ? w.below(4) : w.below(100000));
    const RTformat format = w.chance(80) ? RT_FORMAT_FLOAT3 : RTformat(0x101 + w.below(0x30));
    const RTsize offset = w.chance(80) ? 0 : w.below(300);
    if (w.chance(60))
        return rtGeometryTrianglesSetVertices(triangles, count, w.handle<RTbuffer>(), offset,
                                              stride, format);
    if (w.chance(50))
        return rtGeometryTrianglesSetMotionVertices(triangles, count, w.handle<RTbuffer>(), offset,
                                                    stride, w.below(20) * 12, format);
    RTbuffer buffers[4] = {w.handle<RTbuffer>(), w.handle<RTbuffer>(), w.handle<RTbuffer>(),
                           w.handle<RTbuffer>()};
    return rtGeometryTrianglesSetMotionVerticesMultiBuffer(
        triangles, count, buffers, unsigned(w.below(5)), offset, stride, format);
}
RTresult setIndices(World& w) {
    const RTgeometrytriangles triangles = w.handle<RTgeometrytriangles>();
    const RTbuffer buffer = w.indices[contextOf(triangles)];
    return rtGeometryTrianglesSetTriangleIndices(
        triangles, buffer, w.chance(80) ? 0 : w.below(60) * 4, w.chance(70) ? 0 : w.below(40),
        w.chance(80) ? RT_FORMAT_UNSIGNED_INT3 : RTformat(0x101 + w.below(0x30)));
}
RTresult setMaterialIndices(World& w) {
    const RTgeometrytriangles triangles = w.handle<RTgeometrytriangles>();
    return rtGeometryTrianglesSetMaterialIndices(
        triangles, w.zeros[contextOf(triangles)], w.chance(80) ? 0 : w.below(60),
        w.chance(80) ? 0 : w.below(20),
        w.anyOf({RT_FORMAT_UNSIGNED_BYTE, RT_FORMAT_UNSIGNED_SHORT, RT_FORMAT_UNSIGNED_INT,
                 RT_FORMAT_FLOAT}));
}

RTresult setAttribute(World& w) {
    const RTcontext context = w.handle<RTcontext>();
    const int threads = int(w.below(4));
    if (w.chance(50))
        return rtContextSetAttribute(context, RT_CONTEXT_ATTRIBUTE_CPU_NUM_THREADS,
                                     w.chance(90) ? 4 : 3, &threads);
    const auto attribute = RTcontextattribute(w.anyOf({0, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 13, 99}));
    return rtContextSetAttribute(context, attribute, w.below(64), w.scratch());
}

RTsize launchSize(World& w) {
    return w.chance(97) ? w.below(6) : w.anyOf<RTsize>({~RTsize(0), RTsize(1) << 40, 0});
}

RTresult launch(World& w) {
    const auto size = [&] { return launchSize(w); };
    const RTcontext context = w.handle<RTcontext>();
    const unsigned entry = w.chance(95) ? 0 : unsigned(w.below(4));
    switch (w.below(4)) {
    case 0:
        return rtContextLaunch1D(context, entry, size());
    case 1:
        return rtContextLaunch2D(context, entry, size(), size());
    case 2:
        return rtContextLaunchProgressive2D(context, entry, size(), size(), unsigned(w.below(4)));
    default:
        return rtContextLaunch3D(context, entry, size(), size(), size());
    }
}

// ---- Command lists -----------------------------------------------------------------------------

RTresult appendLaunch(World& w) {
    return rtCommandListAppendLaunch2D(w.handle<RTcommandlist>(), w.chance(95) ? 0 : 7,
                                       launchSize(w), launchSize(w));
}

// A small image, mostly of a format that stages take.
RTbuffer newImage(World& w, RTcontext context, RTsize width, RTsize height) {
    RTbuffer made = nullptr;
    rtBufferCreate(context, RT_BUFFER_INPUT_OUTPUT, &made);
    rtBufferSetFormat(made, w.anyOf({RT_FORMAT_FLOAT3, RT_FORMAT_FLOAT4, RT_FORMAT_HALF3,
                                     RT_FORMAT_HALF4, RT_FORMAT_UNSIGNED_BYTE4}));
    rtBufferSetSize2D(made, width, height);
    w.note(typeid(RTbuffer), made);
    return made;
}

// A list with a stage whose variables mostly fit.
RTresult runStage(World& w) {
    const RTcontext context = w.handle<RTcontext>();
    const RTsize width = w.below(40), height = width ? 1 + w.below(40) : 0;
    RTpostprocessingstage stage = nullptr;
    RTcommandlist list = nullptr;
    const bool isPredictor = w.chance(20);
    rtPostProcessingStageCreateBuiltin(
        context, isPredictor ? "DLSSIMPredictor" : w.anyOf({"DLDenoiser", "TonemapperSimple"}),
        &stage);
    const auto set = [&](const char* name, RTsize x, RTsize y) {
        RTvariable v = nullptr;
        rtPostProcessingStageQueryVariable(stage, name, &v);
        rtVariableSetObject(v, w.chance(90) ? newImage(w, context, x, y) : w.handle<RTbuffer>());
    };
    const RTsize block = isPredictor ? 16 : 1;
    set("input_buffer", width, height);
    set("output_buffer", (width + block - 1) / block, (height + block - 1) / block);
    if (w.chance(50))
        set("input_albedo_buffer", width, height);
    if (w.chance(30))
        set("input_normal_buffer", width, height);
    for (const char* name : {"blend", "hdr", "maxmem", "exposure", "gamma"}) {
        RTvariable v = nullptr;
        rtPostProcessingStageQueryVariable(stage, name, &v);
        if (v && w.chance(30))
            rtVariableSet1f(v, w.anyOf({0.0f, 0.5f, 1.0f, 1e6f, 3e6f, -1.0f, NAN, INFINITY}));
    }
    rtCommandListCreate(context, &list);
    rtCommandListAppendPostprocessingStage(list, stage, width, height);
    rtCommandListFinalize(list);
    const RTresult result = rtCommandListExecute(list);
    w.note(typeid(RTpostprocessingstage), stage);
    w.note(typeid(RTcommandlist), list);
    return result;
}

// A stream and its source, of equal sizes; launches of this size show it.
RTresult makeStream(World& w) {
    const RTcontext context = w.handle<RTcontext>();
    const RTsize width = w.below(6), height = width == 0 ? 0 : 1 + w.below(5);
    RTbuffer made[2] = {};
    const unsigned types[] = {RT_BUFFER_PROGRESSIVE_STREAM, RT_BUFFER_OUTPUT};
    const RTformat formats[] = {RT_FORMAT_UNSIGNED_BYTE4,
                                w.anyOf({RT_FORMAT_FLOAT3, RT_FORMAT_FLOAT4})};
    for (int i = 0; i < 2; ++i) {
        rtBufferCreate(context, types[i], &made[i]);
        rtBufferSetFormat(made[i], formats[i]);
        rtBufferSetSize2D(made[i], width, height);
        if (made[i])
            w.note(typeid(RTbuffer), made[i]);
    }
    const RTresult result = rtBufferBindProgressiveStream(made[0], made[1]);
    if (w.chance(80))
        rtContextLaunchProgressive2D(context, 0, width, height, unsigned(w.below(4)));
    return result;
}

// ---- All other functions
// -------------------------------------------------------------------------

bool isSpecial(const std::string& name) {
    static const std::set<std::string> names = {
        "rtVariableSetObject", "rtGroupSetChild", "rtSelectorSetChild", "rtTransformSetChild",
        "rtProgramCreateFromPTXString", "rtProgramCreateFromPTXStrings", "rtBufferSetDevicePointer",
        "rtBufferSetSizev", "rtGeometryTrianglesSetVertices",
        "rtGeometryTrianglesSetMotionVertices", "rtGeometryTrianglesSetMotionVerticesMultiBuffer",
        "rtGeometryTrianglesSetTriangleIndices", "rtGeometryTrianglesSetMaterialIndices",
        "rtContextSetAttribute", "rtContextLaunch1D", "rtContextLaunch2D", "rtContextLaunch3D",
        "rtContextLaunchProgressive2D", "rtContextDestroy", "rtContextCreate",
        "rtCommandListAppendLaunch2D",
        // A string whose address is in the memory.
        "rtGlobalSetAttribute"};
    return names.contains(name);
}

bool isBounded(const std::string& name) {
    return name.find("Count") != name.npos || name.find("Steps") != name.npos ||
           name.find("Size") != name.npos || name.find("Levels") != name.npos;
}

template <class Result, class... A>
RTresult generic(World& w, const char* name, Result (*function)(A...)) {
    w.slots.clear();
    w.kinds.clear();
    w.smallCounts = (kIsMemory<A> || ... || false) || isBounded(name);
    std::tuple<A...> arguments{argument<A>(w)...};
    RTresult result = RT_SUCCESS;
    if constexpr (std::is_void_v<Result>)
        std::apply(function, arguments);
    else
        result = std::apply(function, arguments);
    for (size_t i = 0; i < w.slots.size(); ++i)
        if (w.slots[i])
            w.note(w.kinds[i], w.slots[i]);
    return result;
}

} // namespace

std::vector<Call> calls() {
    std::vector<Call> all = {
        {"repair", 25, repair},
        {"rtVariableSetObject", 30, setObject},
        {"rtGroupSetChild", 20, setGroupChild},
        {"rtSelectorSetChild", 10, setSelectorChild},
        {"rtTransformSetChild", 10, setTransformChild},
        {"rtProgramCreateFromPTXString", 20, createProgram},
        {"a program where it fits", 40, setProgram},
        {"contents of a buffer", 30, fillBuffer},
        {"rtBufferSetDevicePointer", 3, setDevicePointer},
        {"rtBufferSetSizev", 6, setSizes},
        {"rtGeometryTrianglesSetVertices", 12, setVertices},
        {"rtGeometryTrianglesSetTriangleIndices", 8, setIndices},
        {"rtGeometryTrianglesSetMaterialIndices", 4, setMaterialIndices},
        {"rtContextSetAttribute", 3, setAttribute},
        {"rtContextLaunch", 120, launch},
        {"rtCommandListAppendLaunch2D", 6, appendLaunch},
        {"a stage whose variables fit", 20, runStage},
        {"rtBufferBindProgressiveStream", 8, makeStream},
    };
    const auto add = [&](const char* name, auto function) {
        if (isSpecial(name))
            return;
        const std::string text = name;
        const bool isRare = text.find("Destroy") != text.npos || text.find("Remove") != text.npos;
        const bool isGet = text.find("Get") != text.npos || text.starts_with("rtVariableSet");
        all.push_back({name,
                       isRare  ? 1u
                       : isGet ? 2u
                               : 6u,
                       [name, function](World& w) { return generic(w, name, function); }});
    };
#define FUZZ_FUNCTION(name) add(#name, &name);
#include "functions.inc"
#undef FUZZ_FUNCTION
    return all;
}

} // namespace fuzz
