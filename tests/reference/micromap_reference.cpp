// SPDX-License-Identifier: Apache-2.0
// Records how a library treats opacity micromaps: traces rays and prints the answers as lines,
// which can be compared between libraries:
//   micromap_reference PTX                prints
//   micromap_reference PTX RECORDED       compares with a file of such lines; prints differences
// Lines that begin with "info" are not compared: the API leaves them open.
#include "micromap_scene.h"
#include "reference_world.h"

#include <optix_stubs.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <functional>
#include <map>
#include <sstream>

namespace {

using reference::World;

using States = std::vector<unsigned char>;

// A micromap array in the making.
struct Maps {
    std::vector<unsigned char> bytes;
    std::vector<OptixOpacityMicromapDesc> descriptions;
    std::vector<OptixOpacityMicromapHistogramEntry> histogram;

    void add(unsigned int level, OptixOpacityMicromapFormat format, const States& states) {
        const unsigned int bits = format == OPTIX_OPACITY_MICROMAP_FORMAT_2_STATE ? 1 : 2;
        descriptions.push_back(
            {unsigned(bytes.size()), (unsigned short)level, (unsigned short)format});
        const size_t first = bytes.size();
        bytes.resize(first + (states.size() * bits + 7) / 8);
        for (size_t i = 0; i < states.size(); ++i)
            bytes[first + i * bits / 8] |= (unsigned char)(states[i] << i * bits % 8);
        for (auto& entry : histogram)
            if (entry.subdivisionLevel == level && entry.format == format) {
                ++entry.count;
                return;
            }
        histogram.push_back({1, level, format});
    }
};

CUdeviceptr buildArray(const World& world, const Maps& maps) {
    OptixOpacityMicromapArrayBuildInput input = {};
    input.flags = OPTIX_OPACITY_MICROMAP_FLAG_NONE;
    input.inputBuffer = world.cuda.upload(maps.bytes);
    input.perMicromapDescBuffer = world.cuda.upload(maps.descriptions);
    input.numMicromapHistogramEntries = unsigned(maps.histogram.size());
    input.micromapHistogramEntries = maps.histogram.data();
    OptixMicromapBufferSizes sizes = {};
    CHECK(optixOpacityMicromapArrayComputeMemoryUsage(world.context, &input, &sizes));
    OptixMicromapBuffers buffers = {};
    buffers.output = world.cuda.allocate(sizes.outputSizeInBytes);
    buffers.outputSizeInBytes = sizes.outputSizeInBytes;
    buffers.temp = world.cuda.allocate(sizes.tempSizeInBytes);
    buffers.tempSizeInBytes = sizes.tempSizeInBytes;
    CHECK(optixOpacityMicromapArrayBuild(world.context, nullptr, &input, &buffers));
    world.cuda.wait();
    return buffers.output;
}

// Right triangles with legs of length 1 in the plane z = 0, at x = 0, 2, 4 ...
struct Triangles {
    unsigned int count = 1;
    unsigned int geometryFlags = 0;
    unsigned int buildFlags = 0;
    OptixOpacityMicromapArrayIndexingMode mode = OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_NONE;
    CUdeviceptr array = 0;
    std::vector<OptixOpacityMicromapUsageCount> usage;
    std::vector<int> indices; // of mode INDEXED
    unsigned int indexSize = 4;
    unsigned int indexOffset = 0;
    CUdeviceptr vertices = 0;

    CUdeviceptr indexBuffer(const World& world) const {
        if (indexSize == 4)
            return world.cuda.upload(indices);
        return world.cuda.upload(std::vector<unsigned short>(indices.begin(), indices.end()));
    }

    OptixBuildInput input(const World& world) {
        std::vector<float> corners;
        for (unsigned int i = 0; i < count; ++i) {
            const float x = 2.0f * float(i);
            corners.insert(corners.end(), {x, 0, 0, x + 1, 0, 0, x, 1, 0});
        }
        vertices = world.cuda.upload(corners);
        OptixBuildInput input = {};
        input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
        auto& t = input.triangleArray;
        t.vertexBuffers = &vertices;
        t.numVertices = 3 * count;
        t.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
        t.flags = &geometryFlags;
        t.numSbtRecords = 1;
        if (mode == OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_NONE)
            return input;
        t.opacityMicromap.indexingMode = mode;
        t.opacityMicromap.opacityMicromapArray = array;
        if (mode == OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_INDEXED) {
            t.opacityMicromap.indexBuffer = indexBuffer(world);
            t.opacityMicromap.indexSizeInBytes = indexSize;
        }
        t.opacityMicromap.indexOffset = indexOffset;
        t.opacityMicromap.numMicromapUsageCounts = unsigned(usage.size());
        t.opacityMicromap.micromapUsageCounts = usage.data();
        return input;
    }
    OptixTraversableHandle build(const World& world, CUdeviceptr* output = nullptr) {
        return world.build(input(world), buildFlags, output);
    }
};

OptixTraversableHandle buildInstance(const World& world, OptixTraversableHandle child,
                                     unsigned int flags) {
    const OptixInstance instance = {
        {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, 0, 0, 255, flags, child, {}};
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_INSTANCES;
    input.instanceArray.instances = world.cuda.upload<OptixInstance>({instance});
    input.instanceArray.numInstances = 1;
    return world.build(input, 0);
}

struct Tracer {
    World world;
    OptixPipeline pipeline = nullptr;
    OptixShaderBindingTable sbt = {};

    void makePipeline(const std::string& ptx, bool allowMicromaps) {
        OptixPipelineCompileOptions options = {};
        options.numPayloadValues = 1;
        options.numAttributeValues = 2;
        options.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS |
                                        OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING;
        options.pipelineLaunchParamsVariableName = "params";
        options.allowOpacityMicromaps = allowMicromaps;
        const char* const names[4] = {"__raygen__queries", "__miss__mark", "__closesthit__mark",
                                      "__anyhit__count"};
        pipeline = world.pipeline(ptx, options, names, sbt);
    }
    std::vector<unsigned int> run(const std::vector<Query>& queries) const {
        const CUdeviceptr outcomes = world.cuda.allocate(4 * queries.size());
        const Params params = {reinterpret_cast<const Query*>(world.cuda.upload(queries)),
                               reinterpret_cast<unsigned int*>(outcomes)};
        const CUdeviceptr block = world.cuda.upload<Params>({params});
        CHECK(optixLaunch(pipeline, nullptr, block, sizeof(params), &sbt, unsigned(queries.size()),
                          1, 1));
        world.cuda.wait();
        std::vector<unsigned int> result(queries.size());
        world.cuda.copyOut(result.data(), outcomes, 4 * result.size());
        return result;
    }
};

// '.': miss, 'h': hit, 'a': hit after a call of the any-hit program, '?': something else.
char letter(unsigned int outcome) {
    switch (outcome) {
    case kMiss:
        return '.';
    case 0:
    case kHit:
        return 'h';
    case kAnyHit:
    case kHit + kAnyHit:
        return 'a';
    default:
        return '?';
    }
}

std::vector<std::string> lines;
template <class... Parts>
void say(const Parts&... parts) {
    std::ostringstream text;
    (text << ... << parts);
    lines.push_back(text.str());
    std::printf("%s\n", lines.back().c_str());
    std::fflush(stdout);
}

// ---- order of micro-triangles and bits ----

struct Point {
    float u, v;
};

// Centres of micro-triangles: all of them row by row, or a selection.
std::vector<Point> centres(unsigned int level) {
    std::vector<Point> points;
    const unsigned int n = 1u << level;
    const auto add = [&](unsigned int b, unsigned int c, bool head) {
        const double third = head ? 2 / 3.0 : 1 / 3.0;
        points.push_back({float((b + third) / n), float((c + third) / n)});
    };
    if (level <= 5) {
        for (unsigned int c = 0; c < n; ++c)
            for (unsigned int b = 0; b + c < n; ++b) {
                add(b, c, false);
                if (b + c + 1 < n)
                    add(b, c, true);
            }
        return points;
    }
    uint32_t seed = 12345;
    const auto random = [&](uint32_t below) {
        seed = seed * 1664525u + 1013904223u;
        return uint32_t(uint64_t(seed) * below >> 32);
    };
    while (points.size() < 1000) {
        const uint32_t b = random(n), c = random(n);
        if (b + c < n)
            add(b, c, b + c + 1 < n && random(2));
    }
    return points;
}

// One micromap for each bit of the micro-triangle's number, set where that bit is 1.
void askOrder(const Tracer& tracer, unsigned int level, OptixOpacityMicromapFormat format) {
    const bool two = format == OPTIX_OPACITY_MICROMAP_FORMAT_2_STATE;
    const std::vector<Point> points = centres(level);
    std::vector<Query> queries;
    const unsigned int bits = 2 * level;
    for (unsigned int bit = 0; bit < bits; ++bit) {
        States states(size_t(1) << bits);
        for (size_t i = 0; i < states.size(); ++i)
            states[i] = i >> bit & 1 ? OPTIX_OPACITY_MICROMAP_STATE_OPAQUE
                        : two        ? OPTIX_OPACITY_MICROMAP_STATE_TRANSPARENT
                                     : OPTIX_OPACITY_MICROMAP_STATE_UNKNOWN_OPAQUE;
        Maps maps;
        maps.add(level, format, states);
        Triangles triangles;
        triangles.mode = OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_LINEAR;
        triangles.array = buildArray(tracer.world, maps);
        triangles.usage = {{1, level, format}};
        const OptixTraversableHandle handle = triangles.build(tracer.world);
        for (const Point& p : points)
            queries.push_back({handle, p.u, p.v, 0, 0});
    }
    if (queries.empty())
        return;
    const std::vector<unsigned int> outcomes = tracer.run(queries);
    std::vector<uint32_t> numbers(points.size());
    for (unsigned int bit = 0; bit < bits; ++bit)
        for (size_t i = 0; i < points.size(); ++i)
            if (letter(outcomes[bit * points.size() + i]) == 'h')
                numbers[i] |= 1u << bit;
    std::ostringstream text;
    uint32_t hash = 2166136261u;
    for (uint32_t number : numbers) {
        hash = (hash ^ number) * 16777619u;
        if (level <= 3)
            text << ' ' << number;
    }
    say("order level ", level, two ? " 2-state" : " 4-state", ": hash ", hash, text.str());
}

// ---- states and flags ----

constexpr Point kInside[4] = {{0.1f, 0.1f}, {0.3f, 0.3f}, {0.8f, 0.1f}, {0.1f, 0.8f}};
constexpr unsigned int kRayFlags[] = {
    0, OPTIX_RAY_FLAG_DISABLE_ANYHIT, OPTIX_RAY_FLAG_ENFORCE_ANYHIT,
    OPTIX_RAY_FLAG_CULL_DISABLED_ANYHIT, OPTIX_RAY_FLAG_CULL_ENFORCED_ANYHIT};
constexpr unsigned int kMoreRayFlags[] = {
    0, OPTIX_RAY_FLAG_FORCE_OPACITY_MICROMAP_2_STATE, OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT,
    OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT};

void askFlags(const Tracer& tracer, const Triangles& triangles, const std::string& name,
              unsigned int placeCount, bool info = false) {
    Triangles copy = triangles;
    const OptixTraversableHandle gas = copy.build(tracer.world);
    for (unsigned int instanceFlags : {0u, 4u, 8u, 16u, 32u, 4u | 16, 8u | 16, 4u | 32, 8u | 32}) {
        const OptixTraversableHandle ias = buildInstance(tracer.world, gas, instanceFlags);
        std::vector<Query> queries;
        for (unsigned int flags : kRayFlags)
            for (unsigned int more : kMoreRayFlags)
                for (unsigned int place = 0; place < placeCount; ++place)
                    queries.push_back({ias, kInside[place].u, kInside[place].v, flags | more, 0});
        std::string text;
        size_t i = 0;
        for (unsigned int outcome : tracer.run(queries)) {
            if (i++ % placeCount == 0 && placeCount > 1)
                text += ' ';
            text += letter(outcome);
        }
        say(info ? "info " : "", "flags ", name, " instance ", instanceFlags, ":", text);
    }
}

void askAllFlags(const Tracer& tracer) {
    Maps four, two;
    four.add(1, OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE, {0, 1, 2, 3});
    two.add(1, OPTIX_OPACITY_MICROMAP_FORMAT_2_STATE, {0, 1, 1, 0});
    const CUdeviceptr arrays[2] = {buildArray(tracer.world, four), buildArray(tracer.world, two)};
    for (unsigned int geometryFlags : {0u, unsigned(OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT)}) {
        const std::string geometry = "geometry " + std::to_string(geometryFlags);
        Triangles t;
        t.geometryFlags = geometryFlags;
        askFlags(tracer, t, geometry + " no micromap", 1);
        t.buildFlags = OPTIX_BUILD_FLAG_ALLOW_DISABLE_OPACITY_MICROMAPS;
        t.mode = OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_INDEXED;
        t.array = arrays[0];
        t.indices = {0};
        t.usage = {{1, 1, OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE}};
        askFlags(tracer, t, geometry + " 4-state", 4);
        t.array = arrays[1];
        t.usage = {{1, 1, OPTIX_OPACITY_MICROMAP_FORMAT_2_STATE}};
        askFlags(tracer, t, geometry + " 2-state", 4);
        t.usage.clear();
        for (int index = -1; index >= -4; --index) {
            t.indices = {index};
            askFlags(tracer, t, geometry + " index " + std::to_string(index), 1);
        }
    }
    Triangles t;
    t.mode = OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_LINEAR;
    t.array = arrays[0];
    t.usage = {{1, 1, OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE}};
    askFlags(tracer, t, "structure without ALLOW_DISABLE, 4-state", 4, true);
}

// ---- which micromap a triangle gets ----

// Micromaps whose four micro-triangles encode the micromap's number (modulo 16).
Maps numbered(unsigned int count) {
    Maps maps;
    for (unsigned int i = 0; i < count; ++i)
        maps.add(1, OPTIX_OPACITY_MICROMAP_FORMAT_2_STATE,
                 {(unsigned char)(i & 1), (unsigned char)(i >> 1 & 1), (unsigned char)(i >> 2 & 1),
                  (unsigned char)(i >> 3 & 1)});
    return maps;
}

void askNumbers(const Tracer& tracer, OptixTraversableHandle gas, unsigned int count,
                const std::string& name) {
    std::vector<Query> queries;
    for (unsigned int i = 0; i < count; ++i)
        for (const Point& p : kInside)
            queries.push_back({gas, p.u + 2.0f * float(i), p.v, 0, 0});
    const std::vector<unsigned int> outcomes = tracer.run(queries);
    std::ostringstream text;
    for (unsigned int i = 0; i < count; ++i) {
        unsigned int number = 0;
        for (unsigned int k = 0; k < 4; ++k)
            number |= unsigned(letter(outcomes[4 * i + k]) == 'h') << k;
        text << ' ' << number;
    }
    say("numbers ", name, ":", text.str());
}

void askIndexing(const Tracer& tracer) {
    const CUdeviceptr array = buildArray(tracer.world, numbered(14));
    Triangles t;
    t.count = 4;
    t.array = array;
    t.mode = OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_LINEAR;
    t.usage = {{4, 1, OPTIX_OPACITY_MICROMAP_FORMAT_2_STATE}};
    askNumbers(tracer, t.build(tracer.world), t.count, "linear");
    t.mode = OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_INDEXED;
    t.count = 6;
    t.indices = {3, -1, 9, -2, 0, 3};
    for (unsigned int size : {2u, 4u})
        for (unsigned int offset : {0u, 4u}) {
            t.indexSize = size;
            t.indexOffset = offset;
            askNumbers(tracer, t.build(tracer.world), t.count,
                       "of " + std::to_string(size) + " bytes, offset " + std::to_string(offset));
        }
    t.indexOffset = 0;
    t.array = buildArray(tracer.world, numbered(65534));
    t.indices = {32767, 32768, 40001, 65531, 5, 65530};
    t.indexSize = 4;
    askNumbers(tracer, t.build(tracer.world), t.count, "large, of 4 bytes");

    // An update gives other micromaps.
    t.array = array;
    t.indexSize = 4;
    t.indices = {1, 2, 3, 4, 5, 6};
    t.buildFlags = OPTIX_BUILD_FLAG_ALLOW_UPDATE | OPTIX_BUILD_FLAG_ALLOW_OPACITY_MICROMAP_UPDATE;
    CUdeviceptr output = 0;
    OptixTraversableHandle gas = t.build(tracer.world, &output);
    askNumbers(tracer, gas, t.count, "before update");
    t.indices = {6, 5, 4, -2, -1, 1};
    t.array = buildArray(tracer.world, numbered(14));
    OptixAccelBuildOptions options = {};
    options.buildFlags = t.buildFlags;
    options.operation = OPTIX_BUILD_OPERATION_UPDATE;
    const OptixBuildInput input = t.input(tracer.world);
    OptixAccelBufferSizes sizes;
    CHECK(optixAccelComputeMemoryUsage(tracer.world.context, &options, &input, 1, &sizes));
    CHECK(optixAccelBuild(tracer.world.context, nullptr, &options, &input, 1,
                          tracer.world.cuda.allocate(sizes.tempUpdateSizeInBytes),
                          sizes.tempUpdateSizeInBytes, output, sizes.outputSizeInBytes, &gas,
                          nullptr, 0));
    tracer.world.cuda.wait();
    askNumbers(tracer, gas, t.count, "after update");
    t.indices = {32767, 32768, 40001, 65531, 5, 65530};
    t.buildFlags = 0;
    t.array = buildArray(tracer.world, numbered(65534));
    t.indexSize = 2;
    askNumbers(tracer, t.build(tracer.world), t.count, "large, of 2 bytes");
    t.count = 4;
    t.array = array;
    t.mode = OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_LINEAR;
    t.indexOffset = 3;
    askNumbers(tracer, t.build(tracer.world), t.count, "linear with offset 3");
}

// Undefined behaviour for a library without checks.
void askWithoutOption(Tracer& tracer, const std::string& ptx) {
    tracer.makePipeline(ptx, false);
    Maps maps;
    maps.add(1, OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE, {0, 1, 2, 3});
    Triangles t;
    t.mode = OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_LINEAR;
    t.array = buildArray(tracer.world, maps);
    t.usage = {{1, 1, OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE}};
    askFlags(tracer, t, "pipeline without allowOpacityMicromaps, 4-state", 4, true);
}

int compare(const std::string& recorded) {
    std::istringstream text(recorded);
    std::vector<std::string> expected;
    const auto isInfo = [](const std::string& line) { return line.rfind("info", 0) == 0; };
    for (std::string line; std::getline(text, line);)
        if (!line.empty() && line[0] != '#' && !isInfo(line))
            expected.push_back(line);
    lines.erase(std::remove_if(lines.begin(), lines.end(), isInfo), lines.end());
    int different = lines.size() != expected.size();
    for (size_t i = 0; i < std::min(lines.size(), expected.size()); ++i)
        if (lines[i] != expected[i]) {
            std::printf("DIFFERENT: %s\nrecorded:  %s\n", lines[i].c_str(), expected[i].c_str());
            ++different;
        }
    std::printf("%zu answers, %zu recorded, %d different\n", lines.size(), expected.size(),
                different);
    return different ? 1 : 0;
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 2 && argc != 3)
        return 2;
    const std::string ptx = reference::fileText(argv[1]);
    Tracer tracer;
    tracer.makePipeline(ptx, true);
    for (unsigned int level : {1u, 2u, 3u, 4u, 5u, 8u, 12u})
        askOrder(tracer, level, OPTIX_OPACITY_MICROMAP_FORMAT_2_STATE);
    for (unsigned int level : {1u, 2u, 3u, 5u, 11u})
        askOrder(tracer, level, OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE);
    askAllFlags(tracer);
    askIndexing(tracer);
    askWithoutOption(tracer, ptx);
    return argc == 3 ? compare(reference::fileText(argv[2])) : 0;
}
