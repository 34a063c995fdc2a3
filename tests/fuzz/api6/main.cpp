// SPDX-License-Identifier: Apache-2.0
// Fuzzes the classic API: sequences of random calls on a scene that could be launched at first. The
// arguments of most functions are made of their types (arguments.h); functions.inc has all
// functions of the headers. A sequence is determined by its number: `fuzz_api6 --sequence NUMBER`
// repeats it.
//   fuzz_api6 [--seconds N] [--start N] [--sequence N] [--calls N]
//
// The caller's obligations are kept: memory is as large as sizes say, indices of triangles name
// vertices. RT_ERROR_UNKNOWN is an internal error and therefore a finding.
#include "../last_words.h"
#include "../options.h"
#include "arguments.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cinttypes>
#include <fstream>
#include <functional>
#include <iterator>
#include <set>
#include <tuple>

namespace fuzz {
namespace {

uint64_t gSequence = 0;
const char* gCall = "";
std::map<std::string, std::array<unsigned long, 2>> gCounts;

[[noreturn]] void fail(const std::string& what) {
    std::fprintf(stderr, "%s after %s; repeat with --sequence %" PRIu64 "\n", what.c_str(), gCall,
                 gSequence);
    std::_Exit(1);
}

struct Call {
    const char* name;
    unsigned weight;
    std::function<RTresult(World&)> run;
};

// ---- Functions whose arguments types do not tell -----------------------------------------------

// Some object that a node or a variable may refer to.
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

RTprogram newProgram(World& w, RTcontext context, const char* name) {
    RTprogram made = nullptr;
    for (const std::string* text : w.texts)
        if (!made)
            rtProgramCreateFromPTXString(context, text->c_str(), name, &made);
    if (made)
        w.note(typeid(RTprogram), made);
    return made;
}
RTresult createProgram(World& w) {
    RTprogram made = nullptr;
    std::string text = *w.texts[w.below(2)];
    const char* name = w.chance(97) ? w.anyOf(kPrograms) : nullptr;
    if (w.chance(4)) // cut off
        text.resize(w.below(text.size()));
    else if (w.chance(2))
        text[w.below(text.size())] = char(w.random());
    const char* several[2] = {text.c_str(), w.texts[w.below(2)]->c_str()};
    const RTcontext context = w.handle<RTcontext>();
    const RTresult result =
        w.chance(70)
            ? rtProgramCreateFromPTXString(context, w.chance(98) ? several[0] : nullptr, name,
                                           &made)
            : rtProgramCreateFromPTXStrings(context, unsigned(w.below(3)), several, name, &made);
    if (made)
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

// New contents of a buffer, as many bytes as it says it has.
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

// Sizes between small ones and those that no memory has would take it all.
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

RTresult launch(World& w) {
    const auto size = [&]() -> RTsize {
        return w.chance(97) ? w.below(6) : w.anyOf<RTsize>({~RTsize(0), RTsize(1) << 40, 0});
    };
    const RTcontext context = w.handle<RTcontext>();
    const unsigned entry = w.chance(95) ? 0 : unsigned(w.below(4));
    switch (w.below(3)) {
    case 0:
        return rtContextLaunch1D(context, entry, size());
    case 1:
        return rtContextLaunch2D(context, entry, size(), size());
    default:
        return rtContextLaunch3D(context, entry, size(), size(), size());
    }
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
        "rtContextDestroy", "rtContextCreate",
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

RTresult repair(World& w);

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

// ---- A scene that can be launched
// ----------------------------------------------------------------

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

// What a launch of the first scene needs, again after calls have taken it away.
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
    // A new group, or one of the graph that has come about.
    const RTvariable top = variable("top_object");
    if (isNew || w.chance(60) || rtVariableSetObject(top, anyObject(w, nodes())) != RT_SUCCESS)
        rtVariableSetObject(top, newGeometryGroup(w, context));
}

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

// ---- Sequences
// -----------------------------------------------------------------------------------

// Every failure has a text.
void checkResult(World& w, RTresult result) {
    if (result == RT_SUCCESS)
        return;
    const char* text = nullptr;
    rtContextGetErrorString(w.handle<RTcontext>(), result, &text);
    if (!text || !*text || std::strlen(text) > 100000)
        fail("no text of the failure");
    if (result == RT_ERROR_UNKNOWN)
        fail(std::string("an internal error: ") + text);
}

void run(uint64_t sequence, uint64_t count, const std::array<std::string, 2>& texts) {
    static const auto* const all = new std::vector<Call>(calls());
    static const unsigned total = [] {
        unsigned sum = 0;
        for (const Call& call : *all)
            sum += call.weight;
        return sum;
    }();
    gSequence = sequence;
    alarm(120);
    World w(sequence);
    w.texts[0] = &texts[0];
    w.texts[1] = &texts[1];
    gCall = "the first launch";
    createContext(w);
    for (uint64_t i = 0; i < count; ++i) {
        uint64_t place = w.below(total);
        const Call* call = all->data();
        for (; place >= call->weight; ++call)
            place -= call->weight;
        gCall = call->name;
        const RTresult result = call->run(w);
        checkResult(w, result);
        ++gCounts[call->name][result == RT_SUCCESS];
        gCall = "the end of a context";
        if (w.chance(1) && w.chance(30))
            destroyContext(w);
    }
    gCall = "the end";
    for (void* context : w.all<RTcontext>())
        rtContextDestroy(static_cast<RTcontext>(context));
    alarm(0);
}

// Only functions that signal handlers may call.
void tell() {
    char text[256];
    const int length =
        std::snprintf(text, sizeof(text), "\nfailed in %s; repeat with --sequence %" PRIu64 "\n",
                      gCall, gSequence);
    if (write(2, text, size_t(length)) < 0)
        return;
}

std::string read(const char* path) {
    std::ifstream file(path);
    std::string text(std::istreambuf_iterator<char>(file), {});
    if (text.empty())
        fail(std::string("cannot read ") + path);
    return text;
}

int report(uint64_t sequences, uint64_t start) {
    std::fprintf(stderr, "%" PRIu64 " sequences from %" PRIu64 "\n", sequences, start);
    unsigned never = 0;
    for (const auto& [name, counts] : gCounts) {
        never += counts[1] == 0;
        std::fprintf(stderr, "%-50s %8lu failed %8lu succeeded\n", name.c_str(), counts[0],
                     counts[1]);
    }
    const auto& launches = gCounts["rtContextLaunch"];
    if (launches[0] && launches[1] && never < 80)
        return 0;
    std::fprintf(stderr, "launches or too many functions never succeeded, or never failed\n");
    return 1;
}

} // namespace
} // namespace fuzz

int main(int argc, char** argv) {
    uint64_t duration = 10, start = 0, only = ~uint64_t(0), calls = 1500;
    fuzz::readOptions(argc, argv, "fuzz_api6 [--seconds N] [--start N] [--sequence N] [--calls N]",
                      {{"--seconds", &duration},
                       {"--start", &start},
                       {"--sequence", &only},
                       {"--calls", &calls}});
    fuzz::setLastWords(fuzz::tell, SIGALRM);
    if (!std::freopen("/dev/null", "w", stdout)) // programs print
        return 2;
    const std::array<std::string, 2> texts = {fuzz::read(SUNSTONE_FUZZ_TEXT1),
                                              fuzz::read(SUNSTONE_FUZZ_TEXT2)};
    if (only != ~uint64_t(0)) {
        fuzz::run(only, calls, texts);
        return 0;
    }
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + std::chrono::seconds(duration);
    uint64_t count = 0;
    for (; Clock::now() < end; ++count)
        fuzz::run(start + count, calls, texts);
    return fuzz::report(count, start);
}
