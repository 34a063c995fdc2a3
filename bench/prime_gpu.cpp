// SPDX-License-Identifier: Apache-2.0
// Queries of OptiX Prime on a GPU against the same rays through optixLaunch of this library, whose
// programs store the same values. Structures of both are built with PREFER_FAST_TRACE.
//   bench_prime_gpu [--quick] [--scene 0-3] [--ptx launch_rays.ptx]
// Sides alternate; the best of several rounds counts.
#include "optix_rays.h"

#include <optix_function_table_definition.h>

#include "optix_prime/optix_prime.h"

#include <string>

namespace {

using namespace bench;

void check(RTPresult result, const char* call) {
    if (result == RTP_SUCCESS)
        return;
    std::fprintf(stderr, "%s failed: error %d\n", call, int(result));
    std::exit(1);
}
#define RTP(call) ::check(call, #call)

RTPbufferdesc describe(RTPcontext context, RTPbufferformat format, RTPbuffertype type,
                       const void* data, size_t count) {
    RTPbufferdesc desc = nullptr;
    RTP(rtpBufferDescCreate(context, format, type, const_cast<void*>(data), &desc));
    RTP(rtpBufferDescSetRange(desc, 0, count));
    return desc;
}

class Prime {
public:
    Prime() { RTP(rtpContextCreate(RTP_CONTEXT_TYPE_CUDA, &context_)); }
    void setMesh(const Mesh& mesh) {
        if (model_)
            RTP(rtpModelDestroy(model_)); // and its query
        query_ = nullptr;
        RTP(rtpModelCreate(context_, &model_));
        const auto host = [&](RTPbufferformat format, const void* data, size_t count) {
            return describe(context_, format, RTP_BUFFER_TYPE_HOST, data, count);
        };
        RTP(rtpModelSetTriangles(
            model_, host(RTP_BUFFER_FORMAT_INDICES_INT3, mesh.indices.data(), mesh.numTriangles()),
            host(RTP_BUFFER_FORMAT_VERTEX_FLOAT3, mesh.vertices.data(), mesh.numVertices())));
        RTP(rtpModelUpdate(model_, 0));
    }
    void setRays(const Buffer& rays, const Buffer& hits, size_t count, bool any) {
        if (query_)
            RTP(rtpQueryDestroy(query_));
        RTP(rtpQueryCreate(model_, any ? RTP_QUERY_TYPE_ANY : RTP_QUERY_TYPE_CLOSEST, &query_));
        RTP(rtpQuerySetRays(query_,
                            describe(context_, RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX,
                                     RTP_BUFFER_TYPE_CUDA_LINEAR, rays.as<void>(), count)));
        RTP(rtpQuerySetHits(query_, describe(context_, RTP_BUFFER_FORMAT_HIT_T_TRIID,
                                             RTP_BUFFER_TYPE_CUDA_LINEAR, hits.as<void>(), count)));
    }
    void trace() { RTP(rtpQueryExecute(query_, 0)); }

private:
    RTPcontext context_ = nullptr;
    RTPmodel model_ = nullptr;
    RTPquery query_ = nullptr;
};

void contest(const Mesh& mesh, const char* name, Prime& prime, Optix& optix,
             const Structure& structure, const std::vector<Ray>& rays, Optix::Kind kind,
             int rounds) {
    const Buffer in(rays), ours(rays.size() * sizeof(BenchHit)),
        theirs(rays.size() * sizeof(BenchHit));
    prime.setRays(in, ours, rays.size(), kind == Optix::kAny);
    optix.prepare(in, theirs, structure.handle);
    double best = 1e30, launch = 1e30;
    for (int i = 0; i < rounds; ++i) {
        best = std::min(best, seconds([&] { prime.trace(); }));
        launch = std::min(launch, seconds([&] { optix.launch(kind, rays.size()); }));
    }
    const auto a = ours.read<BenchHit>(rays.size()), b = theirs.read<BenchHit>(rays.size());
    size_t differ = 0;
    for (size_t i = 0; i < rays.size(); ++i)
        differ += kind == Optix::kAny ? (a[i].t >= 0) != (b[i].primitive != 0)
                                      : a[i].t != b[i].t || a[i].primitive != b[i].primitive;
    const double mrays = double(rays.size()) * 1e-6;
    std::printf("| %-9s | %-8s | %8.1f | %8.1f | %5.2f | %zu |\n", mesh.name.c_str(), name,
                mrays / best, mrays / launch, launch / best, differ);
    std::fflush(stdout);
}

void benchScene(Prime& prime, Optix& optix, SceneKind kind, uint32_t triangles, bool quick) {
    const Mesh mesh = makeScene(kind, triangles);
    Structure structure(optix, mesh, OPTIX_BUILD_FLAG_PREFER_FAST_TRACE);
    structure.build();
    prime.setMesh(mesh);
    const std::vector<Ray> primary = primaryRays(mesh, quick ? 320 : 1920, quick ? 180 : 1080);
    const Buffer in(primary), out(primary.size() * sizeof(BenchHit));
    prime.setRays(in, out, primary.size(), false);
    prime.trace();
    std::vector<SurfacePoint> points;
    for (const BenchHit& hit : out.read<BenchHit>(primary.size()))
        points.push_back({hit.t >= 0, hit.t, hit.primitive});
    const auto secondary = [&](RayKind kindOf) {
        return secondaryRays(mesh, primary, points, kindOf);
    };
    const int rounds = quick ? 2 : 15;
    const auto run = [&](const char* name, const std::vector<Ray>& rays, Optix::Kind rayKind) {
        contest(mesh, name, prime, optix, structure, rays, rayKind, rounds);
    };
    run("primary", primary, Optix::kClosest);
    run("shadow", secondary(RayKind::kShadow), Optix::kAny);
    run("AO", secondary(RayKind::kAmbientOcclusion), Optix::kAny);
    run("diffuse", secondary(RayKind::kDiffuse), Optix::kClosest);
}

} // namespace

int main(int argc, char** argv) {
    bool quick = false;
    int only = -1;
    std::string ptx = BENCH_PTX;
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        if (word == "--quick") {
            quick = true;
        } else if (word == "--scene" && i + 1 < argc) {
            only = std::atoi(argv[++i]);
        } else if (word == "--ptx" && i + 1 < argc) {
            ptx = argv[++i];
        } else {
            std::fprintf(stderr, "bench_prime_gpu [--quick] [--scene 0-3] [--ptx FILE]\n");
            return 1;
        }
    }
    Prime prime; // makes the device current
    Optix optix(OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS, OPTIX_PRIMITIVE_TYPE_TRIANGLE, ptx);
    std::printf("Mrays/s\n\n| scene     | rays     | Prime    | launch   | ratio | hits differ |\n"
                "|---|---|---|---|---|---|\n");
    const struct {
        SceneKind kind;
        uint32_t triangles;
    } scenes[] = {{SceneKind::kTerrain, 2000000},
                  {SceneKind::kSoup, 1000000},
                  {SceneKind::kLongThin, 1000000},
                  {SceneKind::kSpheres, 10000000}};
    for (int i = 0; i < 4; ++i)
        if (only < 0 || only == i)
            benchScene(prime, optix, scenes[i].kind,
                       quick ? scenes[i].triangles / 100 : scenes[i].triangles, quick);
}
