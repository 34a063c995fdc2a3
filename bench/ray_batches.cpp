// SPDX-License-Identifier: Apache-2.0
// Batches of rays (bvh/batch) against the best of Embree 3's single rays, packets and streams.
//   bench_batches [--scene N] [--isa avx512|avx2|baseline] [--rounds N] [--part N]
//                 [--kind primary|shadow|AO|diffuse] [--slice N]
// One thread, processor time. The rays of a kind are cut into slices of 16,384 (--slice). Each
// slice goes to all sides in random order, so that no side profits from cache contents of another.
// A round is the sum of all slices; the table has the median round, and the lowest and the highest
// ratio. --part: only every Nth slice (4). Scenes: 0 terrain, 1 soup, 2 long thin, 3 spheres, 4
// overlapping, 5 interior, 6 leaves.
#include "scenes.h"

#include "bvh/batch/batch.h"
#include "bvh/build/build.h"

#include <embree3/rtcore.h>
#include <sys/mman.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <random>
#include <string>

namespace {

using namespace bench;
using namespace sunstone;

double processorSeconds() {
    timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

// Memory with huge pages, like that of the device and of Embree.
std::shared_ptr<void> hugeMemory(size_t size) {
    constexpr size_t kHugePage = 1u << 21;
    const size_t padded = (size + kHugePage - 1) / kHugePage * kHugePage;
    void* const memory = std::aligned_alloc(kHugePage, padded);
    madvise(memory, padded, MADV_HUGEPAGE);
    return {memory, std::free};
}

std::shared_ptr<void> buildOurs(const Mesh& mesh) {
    bvh::TriangleInput input;
    input.vertices = mesh.vertices.data();
    input.numVertices = mesh.numVertices();
    input.indices = mesh.indices.data();
    input.indexFormat = bvh::IndexFormat::kUint3;
    input.numTriangles = mesh.numTriangles();
    bvh::BuildInputs inputs;
    inputs.triangles = {&input, 1};
    const bvh::MemoryUsage usage = bvh::computeMemoryUsage(inputs, {});
    const auto temp = hugeMemory(usage.temp), output = hugeMemory(usage.output);
    bvh::build(inputs, {}, temp.get(), usage.temp, output.get(), usage.output);
    const uint64_t used = bvh::compactedSize(output.get());
    auto block = hugeMemory((used + 127) / 128 * 128);
    bvh::compact(output.get(), block.get(), (used + 127) / 128 * 128);
    return block;
}

RTCScene buildEmbree(RTCDevice device, const Mesh& mesh) {
    RTCScene scene = rtcNewScene(device);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               mesh.vertices.data(), 0, 12, mesh.numVertices());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               mesh.indices.data(), 0, 12, mesh.numTriangles());
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    return scene;
}

struct Hit {
    float t;
    uint32_t triangle;
    float u, v;
};

RTCRay embreeRay(const Ray& r) {
    RTCRay ray = {};
    ray.org_x = r.origin[0], ray.org_y = r.origin[1], ray.org_z = r.origin[2];
    ray.dir_x = r.direction[0], ray.dir_y = r.direction[1], ray.dir_z = r.direction[2];
    ray.tnear = r.tmin, ray.tfar = r.tmax, ray.mask = ~0u;
    return ray;
}

Hit hitOf(float t, unsigned geometry, unsigned primitive, float u, float v) {
    return geometry != RTC_INVALID_GEOMETRY_ID ? Hit{t, primitive, u, v} : Hit{-1, ~0u, 0, 0};
}

// One slice for Embree, in the format of each of its modes.
struct Embree {
    RTCScene scene;
    bool any, coherent;

    RTCIntersectContext context() const {
        RTCIntersectContext c;
        rtcInitIntersectContext(&c);
        c.flags =
            coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
        return c;
    }
    void single(const Ray* rays, size_t count, Hit* hits, float* t) const {
        RTCIntersectContext c = context();
        for (size_t i = 0; i < count; ++i) {
            RTCRayHit hit;
            hit.ray = embreeRay(rays[i]);
            if (any) {
                rtcOccluded1(scene, &c, &hit.ray);
                t[i] = hit.ray.tfar < 0 ? 0.0f : -1.0f;
                continue;
            }
            hit.hit.geomID = hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
            rtcIntersect1(scene, &c, &hit);
            hits[i] = hitOf(hit.ray.tfar, hit.hit.geomID, hit.hit.primID, hit.hit.u, hit.hit.v);
        }
    }
    template <size_t N, class RayHitN, class Intersect, class Occluded>
    void packets(const Ray* rays, size_t count, Hit* hits, float* t, Intersect intersect,
                 Occluded occluded) const {
        RTCIntersectContext c = context();
        for (size_t first = 0; first < count; first += N) {
            const size_t lanes = std::min(N, count - first);
            alignas(64) int valid[N];
            alignas(64) RayHitN packet;
            for (size_t i = 0; i < N; ++i)
                valid[i] = i < lanes ? -1 : 0;
            for (size_t i = 0; i < lanes; ++i) {
                const Ray& r = rays[first + i];
                packet.ray.org_x[i] = r.origin[0], packet.ray.org_y[i] = r.origin[1];
                packet.ray.org_z[i] = r.origin[2], packet.ray.dir_x[i] = r.direction[0];
                packet.ray.dir_y[i] = r.direction[1], packet.ray.dir_z[i] = r.direction[2];
                packet.ray.tnear[i] = r.tmin, packet.ray.tfar[i] = r.tmax;
                packet.ray.mask[i] = ~0u, packet.ray.time[i] = 0, packet.ray.flags[i] = 0;
                packet.ray.id[i] = unsigned(i);
                packet.hit.geomID[i] = packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
            }
            if (any)
                occluded(valid, scene, &c, &packet.ray);
            else
                intersect(valid, scene, &c, &packet);
            for (size_t i = 0; i < lanes; ++i)
                if (any)
                    t[first + i] = packet.ray.tfar[i] < 0 ? 0.0f : -1.0f;
                else
                    hits[first + i] = hitOf(packet.ray.tfar[i], packet.hit.geomID[i],
                                            packet.hit.primID[i], packet.hit.u[i], packet.hit.v[i]);
        }
    }
    void stream(const Ray* rays, size_t count, Hit* hits, float* t) const {
        RTCIntersectContext c = context();
        constexpr size_t kBlock = 256;
        for (size_t first = 0; first < count; first += kBlock) {
            const size_t n = std::min(kBlock, count - first);
            RTCRayHit block[kBlock];
            for (size_t i = 0; i < n; ++i) {
                block[i].ray = embreeRay(rays[first + i]);
                block[i].hit.geomID = block[i].hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
            }
            if (any)
                rtcOccluded1M(scene, &c, &block[0].ray, unsigned(n), sizeof(RTCRayHit));
            else
                rtcIntersect1M(scene, &c, block, unsigned(n), sizeof(RTCRayHit));
            for (size_t i = 0; i < n; ++i)
                if (any)
                    t[first + i] = block[i].ray.tfar < 0 ? 0.0f : -1.0f;
                else
                    hits[first + i] = hitOf(block[i].ray.tfar, block[i].hit.geomID,
                                            block[i].hit.primID, block[i].hit.u, block[i].hit.v);
        }
    }
};

struct Options {
    int scene = -1, rounds = 5, part = 4, slice = 16384;
    std::string kind; // empty: all
    bvh::Isa isa = bvh::chosenIsa();
};

struct Scene {
    RTCDevice device;
    RTCScene embree;
    const void* block;
    const char* name;
};

enum Side { kOurs, kSingle, kPackets, kStreams, kSides };
constexpr const char* kSideNames[] = {"ours", "single", "packets", "streams"};

void contest(const Options& options, const Scene& scene, const char* kind,
             const std::vector<Ray>& rays, bool any, bool coherent) {
    if (!options.kind.empty() && options.kind != kind)
        return;
    const bvh::BatchKernels& kernels = bvh::batchKernels(options.isa);
    const Embree embree = {scene.embree, any, coherent};
    std::vector<Hit> hits[2] = {std::vector<Hit>(rays.size()), std::vector<Hit>(rays.size())};
    std::vector<float> ts[2] = {std::vector<float>(rays.size()), std::vector<float>(rays.size())};
    const size_t slice = size_t(options.slice);
    std::mt19937 random(1);
    struct Round {
        double seconds[kSides] = {};
    };
    const bool wide =
        rtcGetDeviceProperty(scene.device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED);
    const auto run = [&](int side, size_t first, size_t count) {
        const Ray* const in = rays.data() + first;
        Hit* const out = hits[side != kOurs].data() + first;
        float* const t = ts[side != kOurs].data() + first;
        const double start = processorSeconds();
        if (side == kOurs) {
            bvh::RayBatch batch;
            batch.handle = uint64_t(scene.block);
            batch.rays = uint64_t(in);
            batch.hits = any ? uint64_t(t) : uint64_t(out);
            batch.count = count;
            batch.hitFormat = any ? bvh::HitFormat::kT : bvh::HitFormat::kTTriangleUv;
            (any ? kernels.any : kernels.closest)(batch, 0, bvh::pieceCount(batch));
        } else if (side == kSingle) {
            embree.single(in, count, out, t);
        } else if (side == kStreams) {
            embree.stream(in, count, out, t);
        } else if (wide) {
            embree.packets<16, RTCRayHit16>(in, count, out, t, rtcIntersect16, rtcOccluded16);
        } else {
            embree.packets<8, RTCRayHit8>(in, count, out, t, rtcIntersect8, rtcOccluded8);
        }
        return processorSeconds() - start;
    };
    size_t total = 0;
    std::vector<Round> rounds;
    for (int r = 0; r < options.rounds; ++r) {
        Round round;
        total = 0;
        for (size_t first = 0; first < rays.size(); first += slice * size_t(options.part)) {
            const size_t count = std::min(slice, rays.size() - first);
            total += count;
            int order[kSides] = {0, 1, 2, 3};
            std::shuffle(order, order + kSides, random);
            for (const int side : order)
                round.seconds[side] += run(side, first, count);
        }
        rounds.push_back(round);
    }
    size_t differ = 0;
    for (size_t first = 0; first < rays.size(); first += slice * size_t(options.part))
        for (size_t i = first; i < std::min(rays.size(), first + slice); ++i)
            differ +=
                any ? (ts[0][i] >= 0) != (ts[1][i] >= 0)
                    : (hits[0][i].t >= 0) != (hits[1][i].t >= 0) ||
                          std::fabs(hits[0][i].t - hits[1][i].t) > 1e-3f * std::fabs(hits[1][i].t);
    const auto median = [&](int side) {
        std::vector<double> values;
        for (const Round& r : rounds)
            values.push_back(r.seconds[side]);
        std::sort(values.begin(), values.end());
        return values[values.size() / 2];
    };
    int peer = kSingle;
    for (int side = kSingle; side < kSides; ++side)
        if (median(side) < median(peer))
            peer = side;
    double low = 1e30, high = 0;
    for (const Round& r : rounds) {
        low = std::min(low, r.seconds[peer] / r.seconds[kOurs]);
        high = std::max(high, r.seconds[peer] / r.seconds[kOurs]);
    }
    const double mrays = double(total) * 1e-6;
    std::printf(
        "| %-9s | %-7s | %6.2f | %6.2f | %6.2f | %6.2f | %-7s | %5.2f (%.2f to %.2f) | %.4f%% |\n",
        scene.name, kind, mrays / median(kOurs), mrays / median(kSingle), mrays / median(kPackets),
        mrays / median(kStreams), kSideNames[peer], median(peer) / median(kOurs), low, high,
        100.0 * double(differ) / double(total));
    std::fflush(stdout);
}

void benchScene(RTCDevice device, SceneKind kind, uint32_t triangles, const Options& options) {
    Mesh mesh = makeScene(kind, triangles);
    mesh.vertices.push_back(0); // Embree reads 16 bytes at the last vertex
    const auto block = buildOurs(mesh);
    const Scene scene = {device, buildEmbree(device, mesh), block.get(), mesh.name.c_str()};
    const std::vector<Ray> primary = primaryRays(mesh, 1920, 1080);
    std::vector<Hit> first(primary.size());
    bvh::RayBatch batch;
    batch.handle = uint64_t(block.get());
    batch.rays = uint64_t(primary.data());
    batch.hits = uint64_t(first.data());
    batch.count = primary.size();
    bvh::batchKernels(options.isa).closest(batch, 0, bvh::pieceCount(batch));
    std::vector<SurfacePoint> points;
    for (const Hit& hit : first)
        points.push_back({hit.t >= 0, hit.t, hit.triangle});
    const auto secondary = [&](RayKind k) { return secondaryRays(mesh, primary, points, k); };
    contest(options, scene, "primary", primary, false, true);
    contest(options, scene, "shadow", secondary(RayKind::kShadow), true, true);
    contest(options, scene, "AO", secondary(RayKind::kAmbientOcclusion), true, false);
    contest(options, scene, "diffuse", secondary(RayKind::kDiffuse), false, false);
    rtcReleaseScene(scene.embree);
}

bool parse(int argc, char** argv, Options& options) {
    for (int i = 1; i + 1 < argc; i += 2) {
        const std::string word = argv[i], value = argv[i + 1];
        if (word == "--scene")
            options.scene = std::atoi(value.c_str());
        else if (word == "--rounds")
            options.rounds = std::max(1, std::atoi(value.c_str()));
        else if (word == "--part")
            options.part = std::max(1, std::atoi(value.c_str()));
        else if (word == "--slice")
            options.slice = std::max(1, std::atoi(value.c_str()));
        else if (word == "--kind")
            options.kind = value;
        else if (word == "--isa")
            options.isa = value == "avx512" ? bvh::Isa::kAvx512
                          : value == "avx2" ? bvh::Isa::kAvx2
                                            : bvh::Isa::kBaseline;
        else
            return false;
    }
    return argc % 2 == 1 && bvh::isaSupported(options.isa);
}

} // namespace

int main(int argc, char** argv) {
    Options options;
    if (!parse(argc, argv, options)) {
        std::fprintf(stderr, "bench_batches [--scene 0-6] [--isa avx512|avx2|baseline] "
                             "[--rounds N] [--part N] [--slice N] "
                             "[--kind primary|shadow|AO|diffuse]\n");
        return 1;
    }
    RTCDevice device = rtcNewDevice("threads=1");
    std::printf("Mrays/s; ratio: ours to the best of Embree's\n\n| scene     | rays    | ours   | "
                "single | packets | streams | best    | ratio               | hits differ |\n"
                "|---|---|---|---|---|---|---|---|---|\n");
    const struct {
        SceneKind kind;
        uint32_t triangles;
    } scenes[] = {{SceneKind::kTerrain, 2000000},     {SceneKind::kSoup, 1000000},
                  {SceneKind::kLongThin, 1000000},    {SceneKind::kSpheres, 10000000},
                  {SceneKind::kOverlapping, 1000000}, {SceneKind::kInterior, 1000000},
                  {SceneKind::kLeaves, 1000000}};
    for (int i = 0; i < 7; ++i)
        if (options.scene < 0 || options.scene == i)
            benchScene(device, scenes[i].kind, scenes[i].triangles, options);
    rtcReleaseDevice(device);
}
