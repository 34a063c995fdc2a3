// SPDX-License-Identifier: Apache-2.0
// A shader binding table that the program's own memory manager lays out: one allocation for
// everything, records of several sizes, strides that are larger than any record, data pointers in
// records, and material indices of one, two and four bytes at strides of their own.
#include "common.h"

#include <optix_function_table_definition.h>

#include <cstring>

#include "device/odd_records.h"

namespace {

constexpr unsigned kWide = 16, kInputs = 3, kMaterials = 3, kTypes = 2, kInstances = 2;

// Row y of the grid is one build input: kWide quads of two triangles, each with a material.
struct Row {
    Buffer vertices, materials;
    CUdeviceptr address = 0;
    unsigned flags[kMaterials] = {};
};

unsigned materialOf(unsigned row, unsigned triangle) {
    return (triangle * (row + 2) + triangle / 5) % kMaterials;
}

Row makeRow(unsigned y) {
    std::vector<float3> corners;
    for (unsigned x = 0; x < kWide; ++x)
        for (const auto& c : {float2{0, 0}, {1, 0}, {0, 1}, {1, 1}, {0, 1}, {1, 0}})
            corners.push_back({x + c.x, y + c.y, 0});
    const unsigned sizes[kInputs] = {1, 2, 4}, strides[kInputs] = {3, 2, 12};
    std::vector<unsigned char> bytes(2 * kWide * strides[y], 0xee);
    for (unsigned t = 0; t < 2 * kWide; ++t) {
        const unsigned material = materialOf(y, t);
        std::memcpy(&bytes[t * strides[y]], &material, sizes[y]);
    }
    Row row;
    row.vertices = Buffer(corners);
    row.materials = Buffer(bytes);
    row.address = row.vertices.ptr();
    return row;
}

OptixTraversableHandle makeMesh(OptixDeviceContext context, std::vector<Row>& rows,
                                Buffer& memory) {
    const unsigned sizes[kInputs] = {1, 2, 4}, strides[kInputs] = {3, 0, 12};
    std::vector<OptixBuildInput> inputs(kInputs);
    for (unsigned y = 0; y < kInputs; ++y) {
        auto& triangles = inputs[y].triangleArray;
        inputs[y].type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
        triangles.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
        triangles.numVertices = 6 * kWide;
        triangles.vertexBuffers = &rows[y].address;
        triangles.flags = rows[y].flags;
        triangles.numSbtRecords = kMaterials;
        triangles.sbtIndexOffsetBuffer = rows[y].materials.ptr();
        triangles.sbtIndexOffsetSizeInBytes = sizes[y];
        triangles.sbtIndexOffsetStrideInBytes = strides[y];
    }
    return buildAccel(context, inputs, memory, OPTIX_BUILD_FLAG_ALLOW_COMPACTION);
}

// Bump allocator for the table.
struct Arena {
    explicit Arena(size_t bytes) : host(bytes, char(0xcd)), device(bytes) {}
    size_t take(size_t bytes, size_t alignment, size_t skew) {
        used = (used + alignment - 1) / alignment * alignment + skew;
        const size_t at = used;
        used += bytes;
        return at;
    }
    std::vector<char> host;
    Buffer device;
    size_t used = 0;
};

template <class T>
void put(Arena& arena, size_t at, OptixProgramGroup group, const T& data) {
    std::vector<char> record(OPTIX_SBT_RECORD_HEADER_SIZE);
    OPTIX_TRY(optixSbtRecordPackHeader(group, record.data()));
    std::memcpy(&arena.host[at], record.data(), record.size());
    std::memcpy(&arena.host[at + record.size()], &data, sizeof data);
}

HitData hitData(unsigned record, const Colour* colours) {
    HitData data = {};
    data.colour = !colours || record % 5 == 4 ? nullptr : colours + record;
    data.id = (unsigned short)(record * 3 + 1);
    data.type = (unsigned char)(record % kTypes);
    data.name[20] = char(record % 7);
    return data;
}

bool check(const std::vector<unsigned>& seen, unsigned records) {
    unsigned wrong = 0;
    const unsigned width = 2 * kWide + 2;
    for (unsigned type = 0, ray = 0; type < kTypes; ++type)
        for (unsigned y = 0; y < kInputs; ++y)
            for (unsigned x = 0; x < width; ++x, ++ray) {
                const unsigned instance = x / (kWide + 1), column = x % (kWide + 1);
                unsigned a = 0, b = 0;
                if (column == kWide) { // the gap behind each instance
                    a = 5 + type + 99;
                    b = 17 * type;
                } else {
                    const unsigned record = instance * kInputs * kMaterials * kTypes +
                                            (y * kMaterials + materialOf(y, 2 * column)) * kTypes +
                                            type;
                    if (record >= records)
                        return false;
                    const HitData data = hitData(record, nullptr);
                    a = data.id + 1000u * data.type + 100000u * unsigned(data.name[20]);
                    b = record % 5 == 4 ? 7 : record * 10 + 2 * column % 3;
                }
                wrong += seen[2 * ray] != a || seen[2 * ray + 1] != b;
            }
    std::printf("%u of %zu rays wrong\n", wrong, seen.size() / 2);
    return wrong == 0;
}

bool run() {
    OptixDeviceContext context = makeContext(true);
    const auto options =
        pipelineOptions(2, 2, OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING);
    OptixModule module = makeModule(context, options);
    const OptixProgramGroup raygen = raygenGroup(context, module, "__raygen__grid"),
                            miss = missGroup(context, module, "__miss__record"),
                            hit =
                                hitGroup(context, module, "__closesthit__record", nullptr, nullptr);
    OptixPipeline pipeline = makePipeline(context, options, {raygen, miss, hit});
    OPTIX_TRY(optixPipelineSetStackSize(pipeline, 0, 0, 2048, 2));

    std::vector<Row> rows;
    for (unsigned y = 0; y < kInputs; ++y)
        rows.push_back(makeRow(y));
    Buffer meshMemory, sceneMemory;
    const OptixTraversableHandle mesh = makeMesh(context, rows, meshMemory);
    constexpr unsigned kPerInstance = kInputs * kMaterials * kTypes,
                       kRecords = kPerInstance * kInstances;
    std::vector<OptixInstance> instances(kInstances);
    for (unsigned i = 0; i < kInstances; ++i) {
        const float place[12] = {1, 0, 0, float(i * (kWide + 1)), 0, 1, 0, 0, 0, 0, 1, -2};
        std::memcpy(instances[i].transform, place, sizeof place);
        instances[i].sbtOffset = i * kPerInstance;
        instances[i].visibilityMask = 255;
        instances[i].traversableHandle = mesh;
    }
    Buffer instanceBuffer(instances);
    std::vector<OptixBuildInput> input(1);
    input[0].type = OPTIX_BUILD_INPUT_TYPE_INSTANCES;
    input[0].instanceArray = {instanceBuffer.ptr(), kInstances};
    const OptixTraversableHandle scene = buildAccel(context, input, sceneMemory);

    std::vector<Colour> colours(kRecords);
    for (unsigned i = 0; i < kRecords; ++i)
        colours[i] = {{i * 10, i * 10 + 1, i * 10 + 2}};
    Buffer colourBuffer(colours);

    Arena arena(64 * 1024);
    OptixShaderBindingTable table = {};
    const size_t raygenAt = arena.take(32 + sizeof(RaygenData), 16, 48);
    table.missRecordStrideInBytes = 48;
    table.missRecordCount = kTypes;
    const size_t missAt = arena.take(48 * kTypes, 16, 16);
    table.hitgroupRecordStrideInBytes = 32 + (sizeof(HitData) + 15) / 16 * 16 + 80;
    table.hitgroupRecordCount = kRecords;
    const size_t hitAt = arena.take(table.hitgroupRecordStrideInBytes * kRecords, 16, 32);
    put(arena, raygenAt, raygen, RaygenData{50.0f, kTypes, {}, 99});
    for (unsigned i = 0; i < kTypes; ++i)
        put(arena, missAt + 48 * i, miss, MissData{5ull + i + (17ull * i << 32)});
    for (unsigned i = 0; i < kRecords; ++i)
        put(arena, hitAt + i * table.hitgroupRecordStrideInBytes, hit,
            hitData(i, colourBuffer.as<Colour>()));
    arena.device.upload(arena.host.data(), arena.host.size());
    table.raygenRecord = arena.device.ptr() + raygenAt;
    table.missRecordBase = arena.device.ptr() + missAt;
    table.hitgroupRecordBase = arena.device.ptr() + hitAt;

    const unsigned width = 2 * kWide + 2;
    Buffer seen(size_t(width) * kInputs * kTypes * 8);
    Buffer paramBuffer(std::vector<Params>{{seen.as<unsigned>(), scene, kInputs}});
    OPTIX_TRY(optixLaunch(pipeline, nullptr, paramBuffer.ptr(), sizeof(Params), &table, width,
                          kInputs, kTypes));
    const bool right = check(seen.download<unsigned>(), kRecords);
    OPTIX_TRY(optixPipelineDestroy(pipeline));
    OPTIX_TRY(optixDeviceContextDestroy(context));
    return right;
}

} // namespace

int main() {
    return runChecked(run);
}
