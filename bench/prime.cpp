// SPDX-License-Identifier: Apache-2.0
// Queries of OptiX Prime on the CPU against Embree 3: identical rays in one process, all threads.
//   bench_prime [--quick] [--scene 0-3] [--processor-time]
// Each side reads rays of 32 bytes (origin, tmin, direction, tmax) and stores t, triangle, u and v,
// or for any-hit rays t. Embree's rays are single rays, packets of 16 (8, 4) and streams; the best
// of them counts. Sides alternate; the best of several rounds counts.
#include "scenes.h"

#include "optix_prime/optix_prime.h"

#include <embree3/rtcore.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <string>

namespace {

using namespace bench;

bool gProcessorTime = false;

double seconds(const std::function<void()>& work) {
    const auto now = [] {
        timespec t;
        clock_gettime(gProcessorTime ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC, &t);
        return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
    };
    const double start = now();
    work();
    return now() - start;
}

void require(RTPresult result, const char* what) {
    if (result == RTP_SUCCESS)
        return;
    const char* text = "";
    rtpGetErrorString(result, &text);
    std::fprintf(stderr, "%s: %s\n", what, text);
    std::exit(1);
}
#define RTP(call) require(call, #call)

RTCScene embreeScene(RTCDevice device, const Mesh& mesh) {
    RTCScene scene = rtcNewScene(device);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               mesh.vertices.data(), 0, 12, mesh.numVertices());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               mesh.indices.data(), 0, 12, mesh.numTriangles());
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    return scene;
}

RTCRay embreeRay(const Ray& r) {
    RTCRay ray = {};
    ray.org_x = r.origin[0], ray.org_y = r.origin[1], ray.org_z = r.origin[2];
    ray.dir_x = r.direction[0], ray.dir_y = r.direction[1], ray.dir_z = r.direction[2];
    ray.tnear = r.tmin, ray.tfar = r.tmax, ray.mask = ~0u;
    return ray;
}

struct Hit {
    float t;
    uint32_t triangle;
    float u, v;
};

RTPbufferdesc describe(RTPcontext context, RTPbufferformat format, const void* data, size_t count) {
    RTPbufferdesc desc = nullptr;
    RTP(rtpBufferDescCreate(context, format, RTP_BUFFER_TYPE_HOST, const_cast<void*>(data), &desc));
    RTP(rtpBufferDescSetRange(desc, 0, count));
    return desc;
}

class Prime {
public:
    explicit Prime(const Mesh& mesh) {
        RTP(rtpContextCreate(RTP_CONTEXT_TYPE_CPU, &context_));
        RTP(rtpModelCreate(context_, &model_));
        RTP(rtpModelSetTriangles(model_,
                                 describe(context_, RTP_BUFFER_FORMAT_INDICES_INT3,
                                          mesh.indices.data(), mesh.numTriangles()),
                                 describe(context_, RTP_BUFFER_FORMAT_VERTEX_FLOAT3,
                                          mesh.vertices.data(), mesh.numVertices())));
        buildTime = seconds([&] { RTP(rtpModelUpdate(model_, 0)); });
    }
    ~Prime() { rtpContextDestroy(context_); }
    Prime(const Prime&) = delete;

    void trace(const std::vector<Ray>& rays, bool any, std::vector<Hit>& hits,
               std::vector<float>& distances) {
        RTPquery query = nullptr;
        RTP(rtpQueryCreate(model_, any ? RTP_QUERY_TYPE_ANY : RTP_QUERY_TYPE_CLOSEST, &query));
        RTPbufferdesc in = describe(context_, RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX,
                                    rays.data(), rays.size());
        RTPbufferdesc out =
            any ? describe(context_, RTP_BUFFER_FORMAT_HIT_T, distances.data(), rays.size())
                : describe(context_, RTP_BUFFER_FORMAT_HIT_T_TRIID_U_V, hits.data(), rays.size());
        RTP(rtpQuerySetRays(query, in));
        RTP(rtpQuerySetHits(query, out));
        RTP(rtpQueryExecute(query, 0));
        rtpQueryDestroy(query);
        rtpBufferDescDestroy(in);
        rtpBufferDescDestroy(out);
    }
    double buildTime = 0;

private:
    RTPcontext context_ = nullptr;
    RTPmodel model_ = nullptr;
};

enum class Way { kSingle, kPackets, kStreams };
constexpr const char* kWayNames[] = {"single", "packets", "streams"};

// One block of rays for Embree, in the format of each of its modes.
constexpr size_t kBlock = 256;

void embreeSingle(RTCScene scene, const Ray* rays, size_t count, bool any, Hit* hits, float* t) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (size_t i = 0; i < count; ++i) {
        if (any) {
            RTCRay ray = embreeRay(rays[i]);
            rtcOccluded1(scene, &context, &ray);
            t[i] = ray.tfar < 0 ? 0.0f : -1.0f;
            continue;
        }
        RTCRayHit hit;
        hit.ray = embreeRay(rays[i]);
        hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene, &context, &hit);
        const bool found = hit.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        hits[i] =
            found ? Hit{hit.ray.tfar, hit.hit.primID, hit.hit.u, hit.hit.v} : Hit{-1, ~0u, 0, 0};
    }
}

template <class RayHitN>
void fillLane(RayHitN& to, size_t lane, const Ray& r) {
    to.org_x[lane] = r.origin[0], to.org_y[lane] = r.origin[1], to.org_z[lane] = r.origin[2];
    to.dir_x[lane] = r.direction[0], to.dir_y[lane] = r.direction[1],
    to.dir_z[lane] = r.direction[2];
    to.tnear[lane] = r.tmin, to.tfar[lane] = r.tmax;
    to.mask[lane] = ~0u, to.time[lane] = 0, to.flags[lane] = 0, to.id[lane] = unsigned(lane);
}

template <size_t N, class RayHitN, class RayN, class Intersect, class Occluded>
void embreePackets(RTCScene scene, const Ray* rays, size_t count, bool any, bool coherent,
                   Hit* hits, float* t, Intersect intersect, Occluded occluded) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags =
        coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    for (size_t first = 0; first < count; first += N) {
        const size_t lanes = std::min(N, count - first);
        alignas(64) int valid[N];
        for (size_t i = 0; i < N; ++i)
            valid[i] = i < lanes ? -1 : 0;
        if (any) {
            alignas(64) RayN packet;
            for (size_t i = 0; i < lanes; ++i)
                fillLane(packet, i, rays[first + i]);
            occluded(valid, scene, &context, &packet);
            for (size_t i = 0; i < lanes; ++i)
                t[first + i] = packet.tfar[i] < 0 ? 0.0f : -1.0f;
            continue;
        }
        alignas(64) RayHitN packet;
        for (size_t i = 0; i < lanes; ++i) {
            fillLane(packet.ray, i, rays[first + i]);
            packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
            packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        }
        intersect(valid, scene, &context, &packet);
        for (size_t i = 0; i < lanes; ++i)
            hits[first + i] = packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID
                                  ? Hit{packet.ray.tfar[i], packet.hit.primID[i], packet.hit.u[i],
                                        packet.hit.v[i]}
                                  : Hit{-1, ~0u, 0, 0};
    }
}

void embreeStream(RTCScene scene, const Ray* rays, size_t count, bool any, bool coherent, Hit* hits,
                  float* t) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags =
        coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    if (any) {
        RTCRay block[kBlock];
        for (size_t i = 0; i < count; ++i)
            block[i] = embreeRay(rays[i]);
        rtcOccluded1M(scene, &context, block, unsigned(count), sizeof(RTCRay));
        for (size_t i = 0; i < count; ++i)
            t[i] = block[i].tfar < 0 ? 0.0f : -1.0f;
        return;
    }
    RTCRayHit block[kBlock];
    for (size_t i = 0; i < count; ++i) {
        block[i].ray = embreeRay(rays[i]);
        block[i].hit.geomID = RTC_INVALID_GEOMETRY_ID;
        block[i].hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect1M(scene, &context, block, unsigned(count), sizeof(RTCRayHit));
    for (size_t i = 0; i < count; ++i)
        hits[i] = block[i].hit.geomID != RTC_INVALID_GEOMETRY_ID
                      ? Hit{block[i].ray.tfar, block[i].hit.primID, block[i].hit.u, block[i].hit.v}
                      : Hit{-1, ~0u, 0, 0};
}

void traceEmbree(RTCDevice device, RTCScene scene, Way way, const std::vector<Ray>& rays, bool any,
                 bool coherent, std::vector<Hit>& hits, std::vector<float>& distances) {
    const bool wide = rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED);
    const bool eight = rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED);
    tbb::parallel_for(
        tbb::blocked_range<size_t>(0, (rays.size() + kBlock - 1) / kBlock, 4),
        [&](const auto& range) {
            for (size_t block = range.begin(); block < range.end(); ++block) {
                const size_t first = block * kBlock;
                const size_t count = std::min(kBlock, rays.size() - first);
                const Ray* in = rays.data() + first;
                Hit* out = any ? nullptr : hits.data() + first;
                float* t = any ? distances.data() + first : nullptr;
                if (way == Way::kSingle)
                    embreeSingle(scene, in, count, any, out, t);
                else if (way == Way::kStreams)
                    embreeStream(scene, in, count, any, coherent, out, t);
                else if (wide)
                    embreePackets<16, RTCRayHit16, RTCRay16>(scene, in, count, any, coherent, out,
                                                             t, rtcIntersect16, rtcOccluded16);
                else if (eight)
                    embreePackets<8, RTCRayHit8, RTCRay8>(scene, in, count, any, coherent, out, t,
                                                          rtcIntersect8, rtcOccluded8);
                else
                    embreePackets<4, RTCRayHit4, RTCRay4>(scene, in, count, any, coherent, out, t,
                                                          rtcIntersect4, rtcOccluded4);
            }
        });
}

struct Results {
    std::vector<Hit> hits;
    std::vector<float> distances;
    explicit Results(size_t count) : hits(count), distances(count) {}
    bool hit(size_t i, bool any) const { return (any ? distances[i] : hits[i].t) >= 0; }
};

void contest(const char* scene, const char* name, Prime& prime, RTCDevice device, RTCScene embree,
             const std::vector<Ray>& rays, bool any, bool coherent, int rounds) {
    Results ours(rays.size()), theirs(rays.size());
    double best = 1e30, ways[3] = {1e30, 1e30, 1e30};
    for (int round = 0; round < rounds; ++round) {
        best = std::min(best, seconds([&] { prime.trace(rays, any, ours.hits, ours.distances); }));
        for (int way = 0; way < 3; ++way)
            ways[way] = std::min(ways[way], seconds([&] {
                                     traceEmbree(device, embree, Way(way), rays, any, coherent,
                                                 theirs.hits, theirs.distances);
                                 }));
    }
    size_t differ = 0;
    for (size_t i = 0; i < rays.size(); ++i)
        differ += ours.hit(i, any) != theirs.hit(i, any) ||
                  (!any && ours.hit(i, any) &&
                   std::abs(ours.hits[i].t - theirs.hits[i].t) > 1e-3f * theirs.hits[i].t);
    const double* const peer = std::min_element(ways, ways + 3);
    const double mrays = double(rays.size()) * 1e-6;
    std::printf("| %-9s | %-8s | %7.2f | %7.2f | %7.2f | %7.2f | %-7s | %5.2f | %.4f%% |\n", scene,
                name, mrays / best, mrays / ways[0], mrays / ways[1], mrays / ways[2],
                kWayNames[peer - ways], *peer / best, 100.0 * double(differ) / double(rays.size()));
    std::fflush(stdout);
}

void benchScene(RTCDevice device, SceneKind kind, uint32_t triangles, bool quick) {
    Mesh mesh = makeScene(kind, triangles);
    mesh.vertices.push_back(0); // Embree reads 16 bytes at the last vertex
    Prime prime(mesh);
    RTCScene embree = embreeScene(device, mesh);
    const double build = seconds([&] { rtcCommitScene(embree); });
    std::printf("| %-9s | build ms | %7.0f | %7.0f |\n", mesh.name.c_str(), prime.buildTime * 1e3,
                build * 1e3);
    const std::vector<Ray> primary = primaryRays(mesh, quick ? 640 : 1920, quick ? 360 : 1080);
    Results first(primary.size());
    prime.trace(primary, false, first.hits, first.distances);
    std::vector<SurfacePoint> points;
    for (const Hit& hit : first.hits)
        points.push_back({hit.t >= 0, hit.t, hit.triangle});
    const auto secondary = [&](RayKind kind) { return secondaryRays(mesh, primary, points, kind); };
    const int rounds = quick ? 3 : 7;
    const char* name = mesh.name.c_str();
    contest(name, "primary", prime, device, embree, primary, false, true, rounds);
    contest(name, "shadow", prime, device, embree, secondary(RayKind::kShadow), true, true, rounds);
    contest(name, "AO", prime, device, embree, secondary(RayKind::kAmbientOcclusion), true, false,
            rounds);
    contest(name, "diffuse", prime, device, embree, secondary(RayKind::kDiffuse), false, false,
            rounds);
    rtcReleaseScene(embree);
}

} // namespace

int main(int argc, char** argv) {
    bool quick = false;
    int only = -1;
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        if (word == "--quick") {
            quick = true;
        } else if (word == "--processor-time") {
            gProcessorTime = true;
        } else if (word == "--scene" && i + 1 < argc) {
            only = std::atoi(argv[++i]);
        } else {
            std::fprintf(stderr, "bench_prime [--quick] [--scene 0-3] [--processor-time]\n");
            return 1;
        }
    }
    RTCDevice device = rtcNewDevice(nullptr);
    std::printf("Mrays/s; ratio: ours to the best of Embree's\n\n| scene     | rays     | ours    "
                "| single  | packets | streams | best    | ratio | hits differ |\n"
                "|---|---|---|---|---|---|---|---|---|\n");
    const struct {
        SceneKind kind;
        uint32_t triangles;
    } scenes[] = {{SceneKind::kTerrain, 2000000},
                  {SceneKind::kSoup, 1000000},
                  {SceneKind::kLongThin, 1000000},
                  {SceneKind::kSpheres, 10000000}};
    for (int i = 0; i < 4; ++i)
        if (only < 0 || only == i)
            benchScene(device, scenes[i].kind,
                       quick ? scenes[i].triangles / 4 : scenes[i].triangles, quick);
    rtcReleaseDevice(device);
}
