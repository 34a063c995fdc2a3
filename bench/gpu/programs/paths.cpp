// SPDX-License-Identifier: Apache-2.0
// Path tracers in a room: payloads of several sizes, payload types, recursion, textures and
// callables.
#include "scene.h"

#include "sampling.h"

std::string_view bench_paths_2_ptx();
std::string_view bench_paths_8_ptx();
std::string_view bench_paths_16_ptx();
std::string_view bench_paths_32_ptx();
std::string_view bench_paths_typed_ptx();
std::string_view bench_recursion_ptx();
std::string_view bench_textured_2_ptx();
std::string_view bench_textured_16_ptx();
std::string_view bench_textured_200_ptx();
std::string_view bench_shaded_4_ptx();
std::string_view bench_shaded_8_ptx();
std::string_view bench_shaded_16_ptx();
std::string_view bench_shaded_200_ptx();

namespace bench {
namespace {

constexpr double kRoomTriangles = 1e6;

// Paths of up to eight bounces, two records for each material: for paths and for shadow rays.
Job paths(OptixDeviceContext context, const JobSettings& settings, std::string_view ptx,
          unsigned payloadValues) {
    Job job;
    job.ptx = ptx;
    job.payloadValues = payloadValues;
    job.traceDepth = 2;
    job.raygen = "__raygen__paths";
    job.misses = {"__miss__sky", "__miss__lamp"};
    job.hits = {{"__closesthit__surface"}, {}};
    addRoom(context, job, makeRoom(settings.some(kRoomTriangles, 600), 0), 2);
    lightRoom(job, settings);
    job.params.samples = 4;
    job.params.depth = 8;
    job.allocatePicture(settings.width, settings.height);
    return job;
}
Job paths2(OptixDeviceContext context, const JobSettings& settings) {
    return paths(context, settings, bench_paths_2_ptx(), 2);
}
Job pathsAny(OptixDeviceContext context, const JobSettings& settings) {
    Job job = paths2(context, settings);
    job.graph = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY;
    return job;
}
Job paths8(OptixDeviceContext context, const JobSettings& settings) {
    Job job = paths(context, settings, bench_paths_8_ptx(), 8);
    job.traceDepth = 1; // the ray generation program traces all rays
    return job;
}
Job paths16(OptixDeviceContext context, const JobSettings& settings) {
    return paths(context, settings, bench_paths_16_ptx(), 16);
}
Job paths32(OptixDeviceContext context, const JobSettings& settings) {
    return paths(context, settings, bench_paths_32_ptx(), 32);
}
Job pathsTyped(OptixDeviceContext context, const JobSettings& settings) {
    Job job = paths(context, settings, bench_paths_typed_ptx(), 0);
    const unsigned word = OPTIX_PAYLOAD_SEMANTICS_TRACE_CALLER_READ_WRITE |
                          OPTIX_PAYLOAD_SEMANTICS_CH_READ_WRITE |
                          OPTIX_PAYLOAD_SEMANTICS_MS_READ_WRITE;
    const unsigned flag =
        OPTIX_PAYLOAD_SEMANTICS_TRACE_CALLER_READ_WRITE | OPTIX_PAYLOAD_SEMANTICS_MS_WRITE;
    job.payloadTypes = {std::vector<unsigned>(16, word), {flag}};
    job.hits[1].payloadType = 2;
    return job;
}

Job recursive(OptixDeviceContext context, const JobSettings& settings, const char* closestHit,
              unsigned depth, bool isMirror) {
    Job job;
    job.ptx = bench_recursion_ptx();
    job.payloadValues = 5;
    job.traceDepth = depth + 1; // and a shadow ray
    job.raygen = "__raygen__camera";
    job.misses = {"__miss__sky", "__miss__lamp"};
    job.hits = {{closestHit}};
    addRoom(context, job, makeRoom(settings.some(kRoomTriangles, 600), 0, isMirror), 1);
    lightRoom(job, settings);
    job.params.samples = 2;
    job.params.depth = depth;
    job.allocatePicture(settings.width, settings.height);
    return job;
}
Job whitted(OptixDeviceContext context, const JobSettings& settings) {
    return recursive(context, settings, "__closesthit__whitted", 5, false);
}
Job bounces20(OptixDeviceContext context, const JobSettings& settings) {
    return recursive(context, settings, "__closesthit__path", 20, true);
}

// Spots of two shades.
std::vector<unsigned char> spots(unsigned seed, unsigned side) {
    std::vector<unsigned char> texels(size_t(side) * side * 4);
    for (unsigned i = 0; i < side * side; ++i) {
        const unsigned cell = i / side / 8 * (side / 8) + i % side / 8;
        for (unsigned k = 0; k < 4; ++k)
            texels[4 * size_t(i) + k] =
                (unsigned char)(100 + 100 * randomOf(cell + seed, k) + 55 * randomOf(i, k));
    }
    return texels;
}

// A room with textures. `job` has its programs.
void furnish(OptixDeviceContext context, const JobSettings& settings, Job& job,
             unsigned materials) {
    constexpr unsigned kSide = 128;
    job.payloadValues = 2;
    job.traceDepth = 2;
    job.raygen = "__raygen__paths";
    job.misses = {"__miss__sky", "__miss__lamp"};
    MaterialMesh room = makeRoom(settings.some(kRoomTriangles, 600), materials);
    for (Look& look : room.looks)
        for (unsigned k = 0; k < kTextures; ++k) {
            job.textures.emplace_back(spots(unsigned(1000 * job.textures.size()), kSide), kSide);
            look.textures[k] = job.textures.back().object();
        }
    addRoom(context, job, room, 1);
    lightRoom(job, settings);
    job.params.samples = 4;
    job.params.depth = 6;
    job.allocatePicture(settings.width, settings.height);
}

Job textured(OptixDeviceContext context, const JobSettings& settings, std::string_view ptx,
             unsigned materials) {
    Job job;
    job.ptx = ptx;
    job.hits = {{"__closesthit__textured"}};
    for (unsigned i = 0; i < materials; ++i)
        job.callables.push_back("__direct_callable__" + std::to_string(i));
    furnish(context, settings, job, materials);
    return job;
}
Job textured2(OptixDeviceContext context, const JobSettings& settings) {
    return textured(context, settings, bench_textured_2_ptx(), 2);
}
Job textured16(OptixDeviceContext context, const JobSettings& settings) {
    return textured(context, settings, bench_textured_16_ptx(), 16);
}
Job textured200(OptixDeviceContext context, const JobSettings& settings) {
    return textured(context, settings, bench_textured_200_ptx(), 200);
}

Job shaded(OptixDeviceContext context, const JobSettings& settings, std::string_view ptx,
           unsigned materials) {
    Job job;
    job.ptx = ptx;
    for (unsigned i = 0; i < materials; ++i)
        job.closestHits.push_back("__closesthit__" + std::to_string(i));
    for (const std::string& name : job.closestHits)
        job.hits.push_back({name.c_str()});
    furnish(context, settings, job, materials);
    for (HitRecord& record : job.records)
        record.group = record.material.callable;
    return job;
}
Job shaded4(OptixDeviceContext context, const JobSettings& settings) {
    return shaded(context, settings, bench_shaded_4_ptx(), 4);
}
Job shaded8(OptixDeviceContext context, const JobSettings& settings) {
    return shaded(context, settings, bench_shaded_8_ptx(), 8);
}
Job shaded16(OptixDeviceContext context, const JobSettings& settings) {
    return shaded(context, settings, bench_shaded_16_ptx(), 16);
}
Job shaded200(OptixDeviceContext context, const JobSettings& settings) {
    return shaded(context, settings, bench_shaded_200_ptx(), 200);
}

} // namespace

std::vector<JobKind> pathJobs() {
    return {
        {"paths_2", "paths in a struct, its address in two payload words", paths2, 0.01, 0.1},
        {"paths_any", "the same, compiled for graphs of any depth", pathsAny, 0.01, 0.1},
        {"paths_8", "eight payload words: hits; shading in ray generation", paths8, 0.01, 0.1},
        {"paths_16", "sixteen payload words: the path", paths16, 0.01, 0.1},
        {"paths_32", "32 payload words: the path and further outputs", paths32, 0.01, 0.1},
        {"paths_typed", "payload types of sixteen words and of one", pathsTyped, 0.01, 0.1},
        {"whitted", "closest-hit programs trace shadow rays and recurse", whitted, 0.01, 0.1},
        {"bounces_20", "recursion of twenty bounces in a room of mirrors", bounces20, 0.01, 0.2},
        {"textured_2", "three texture reads and a callable, two materials", textured2, 0.01, 0.1},
        {"textured_16", "the same, sixteen materials", textured16, 0.01, 0.1},
        {"textured_200", "the same, 200 materials", textured200, 0.01, 0.1},
        {"shaded_4", "three texture reads, four closest-hit programs", shaded4, 0.01, 0.1},
        {"shaded_8", "the same, eight closest-hit programs", shaded8, 0.01, 0.1},
        {"shaded_16", "the same, sixteen closest-hit programs", shaded16, 0.01, 0.1},
        {"shaded_200", "the same, 200 closest-hit programs", shaded200, 0.01, 0.1},
    };
}

} // namespace bench
