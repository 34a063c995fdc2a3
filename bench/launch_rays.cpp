// SPDX-License-Identifier: Apache-2.0
// Rays per second through the whole optixLaunch path (compiled ray generation program, trace,
// closest-hit and miss programs) against Embree's single-ray kernels on identical ray arrays, in one
// process, all threads on both sides; and acceleration-structure builds through optixAccelBuild
// against Embree's medium quality.
//   bench_launch [--quick] [--scene N] [--json]
// Runs alternate between the two; the best of several counts.
#include "launch_rays.h"
#include "scenes.h"

#include <cuda_runtime.h>
#include <optix.h>
#include <optix_function_table_definition.h>
#include <optix_stubs.h>

#include <embree3/rtcore.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace {

using bench::Mesh;
using bench::Ray;

void check(OptixResult result, const char* call) {
    if (result == OPTIX_SUCCESS)
        return;
    std::fprintf(stderr, "%s failed: error %d\n", call, int(result));
    std::exit(1);
}
void check(cudaError_t result, const char* call) {
    if (result == cudaSuccess)
        return;
    std::fprintf(stderr, "%s failed: %s\n", call, cudaGetErrorString(result));
    std::exit(1);
}
#define CHECK(call) check(call, #call)

double seconds(const std::function<void()>& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Device memory.
class Buffer {
public:
    explicit Buffer(size_t size) {
        CHECK(cudaMalloc(&memory_, std::max<size_t>(size, 16)));
    }
    template <class T>
    explicit Buffer(const std::vector<T>& from) : Buffer(from.size() * sizeof(T)) {
        CHECK(cudaMemcpy(memory_, from.data(), from.size() * sizeof(T), cudaMemcpyHostToDevice));
    }
    Buffer(Buffer&& other) noexcept : memory_(std::exchange(other.memory_, nullptr)) {}
    Buffer& operator=(Buffer&& other) noexcept {
        std::swap(memory_, other.memory_);
        return *this;
    }
    ~Buffer() { cudaFree(memory_); }
    CUdeviceptr address() const { return reinterpret_cast<CUdeviceptr>(memory_); }
    template <class T>
    T* as() const {
        return static_cast<T*>(memory_);
    }
    template <class T>
    std::vector<T> read(size_t count) const {
        std::vector<T> out(count);
        CHECK(cudaMemcpy(out.data(), memory_, count * sizeof(T), cudaMemcpyDeviceToHost));
        return out;
    }

private:
    void* memory_ = nullptr;
};

struct alignas(OPTIX_SBT_RECORD_ALIGNMENT) Record {
    char header[OPTIX_SBT_RECORD_HEADER_SIZE];
};

void onLog(unsigned level, const char* tag, const char* text, void*) {
    if (level <= 3)
        std::fprintf(stderr, "[%s] %s\n", tag, text);
}

// The OptiX side: one pipeline with two ray generation programs.
class Optix {
public:
    enum Kind { kClosest, kAny };

    Optix() : records_(4 * sizeof(Record)), params_(sizeof(LaunchRaysParams)) {
        CHECK(cudaFree(nullptr));
        CHECK(optixInit());
        OptixDeviceContextOptions options = {};
        options.logCallbackFunction = onLog;
        options.logCallbackLevel = 4;
        CHECK(optixDeviceContextCreate(nullptr, &options, &context));
        createPipeline();
    }

    OptixDeviceContext context = nullptr;

    // Uploads what a series of launches needs.
    void prepare(const Buffer& rays, const Buffer& hits, OptixTraversableHandle handle) {
        LaunchRaysParams params;
        params.rays = rays.as<BenchRay>();
        params.hits = hits.as<BenchHit>();
        params.handle = handle;
        CHECK(cudaMemcpy(params_.as<void>(), &params, sizeof(params), cudaMemcpyHostToDevice));
    }

    // Traces `count` rays and waits.
    void launch(Kind kind, size_t count) {
        OptixShaderBindingTable sbt = {};
        sbt.raygenRecord = records_.address() + kind * sizeof(Record);
        sbt.missRecordBase = records_.address() + 2 * sizeof(Record);
        sbt.missRecordStrideInBytes = sizeof(Record);
        sbt.missRecordCount = 1;
        sbt.hitgroupRecordBase = records_.address() + 3 * sizeof(Record);
        sbt.hitgroupRecordStrideInBytes = sizeof(Record);
        sbt.hitgroupRecordCount = 1;
        CHECK(optixLaunch(pipeline_, nullptr, params_.address(), sizeof(LaunchRaysParams), &sbt,
                          unsigned(count), 1, 1));
        CHECK(cudaDeviceSynchronize());
    }

private:
    void createPipeline() {
        std::ifstream file(BENCH_PTX);
        std::stringstream text;
        text << file.rdbuf();
        const std::string ptx = text.str();
        OptixModuleCompileOptions moduleOptions = {};
        OptixPipelineCompileOptions options = {};
        options.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS;
        options.numPayloadValues = 2;
        options.numAttributeValues = 2;
        options.pipelineLaunchParamsVariableName = "params";
        OptixModule module = nullptr;
        CHECK(optixModuleCreateFromPTX(context, &moduleOptions, &options, ptx.data(), ptx.size(),
                                       nullptr, nullptr, &module));
        OptixProgramGroupDesc descs[4] = {};
        const char* names[] = {"__raygen__closest", "__raygen__any", "__miss__clear"};
        for (int i = 0; i < 3; ++i) {
            descs[i].kind = i < 2 ? OPTIX_PROGRAM_GROUP_KIND_RAYGEN : OPTIX_PROGRAM_GROUP_KIND_MISS;
            descs[i].raygen.module = module; // raygen and miss share their place in the union
            descs[i].raygen.entryFunctionName = names[i];
        }
        descs[3].kind = OPTIX_PROGRAM_GROUP_KIND_HITGROUP;
        descs[3].hitgroup.moduleCH = module;
        descs[3].hitgroup.entryFunctionNameCH = "__closesthit__store";
        OptixProgramGroupOptions groupOptions = {};
        OptixProgramGroup groups[4] = {};
        CHECK(optixProgramGroupCreate(context, descs, 4, &groupOptions, nullptr, nullptr, groups));
        OptixPipelineLinkOptions link = {};
        link.maxTraceDepth = 1;
        CHECK(optixPipelineCreate(context, &options, &link, groups, 4, nullptr, nullptr,
                                  &pipeline_));
        std::vector<Record> records(4);
        for (int i = 0; i < 4; ++i)
            CHECK(optixSbtRecordPackHeader(groups[i], &records[i]));
        records_ = Buffer(records);
    }

    OptixPipeline pipeline_ = nullptr;
    Buffer records_, params_;
};

// A mesh on the device and its acceleration structure.
class Structure {
public:
    Structure(Optix& optix, const Mesh& mesh)
        : optix_(optix), vertices_(mesh.vertices), indices_(mesh.indices), temp_(16), output_(16) {
        vertexBuffer_ = vertices_.address();
        input_.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
        OptixBuildInputTriangleArray& t = input_.triangleArray;
        t.vertexBuffers = &vertexBuffer_;
        t.numVertices = mesh.numVertices();
        t.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
        t.indexBuffer = indices_.address();
        t.numIndexTriplets = mesh.numTriangles();
        t.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
        t.flags = &flags_;
        t.numSbtRecords = 1;
        options_.buildFlags = OPTIX_BUILD_FLAG_ALLOW_COMPACTION;
        options_.operation = OPTIX_BUILD_OPERATION_BUILD;
        CHECK(optixAccelComputeMemoryUsage(optix.context, &options_, &input_, 1, &sizes_));
        temp_ = Buffer(sizes_.tempSizeInBytes);
        output_ = Buffer(sizes_.outputSizeInBytes);
    }

    void build() {
        CHECK(optixAccelBuild(optix_.context, nullptr, &options_, &input_, 1, temp_.address(),
                              sizes_.tempSizeInBytes, output_.address(), sizes_.outputSizeInBytes,
                              &handle, nullptr, 0));
        CHECK(cudaDeviceSynchronize());
    }

    OptixTraversableHandle handle = 0;

private:
    Optix& optix_;
    Buffer vertices_, indices_, temp_, output_;
    CUdeviceptr vertexBuffer_ = 0;
    unsigned flags_ = OPTIX_GEOMETRY_FLAG_NONE;
    OptixBuildInput input_ = {};
    OptixAccelBuildOptions options_ = {};
    OptixAccelBufferSizes sizes_ = {};
};

// The Embree side.
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

// Stores the same results as the device programs do.
void traceEmbree(RTCScene scene, Optix::Kind kind, const std::vector<Ray>& rays,
                 std::vector<BenchHit>& hits) {
    tbb::parallel_for(tbb::blocked_range<size_t>(0, rays.size(), 256), [&](const auto& range) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (size_t i = range.begin(); i < range.end(); ++i) {
            if (kind == Optix::kClosest) {
                RTCRayHit hit;
                hit.ray = embreeRay(rays[i]);
                hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
                hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
                rtcIntersect1(scene, &context, &hit);
                const bool found = hit.hit.geomID != RTC_INVALID_GEOMETRY_ID;
                hits[i] = {found ? hit.ray.tfar : -1.0f, found ? hit.hit.primID : ~0u};
            } else {
                RTCRay ray = embreeRay(rays[i]);
                rtcOccluded1(scene, &context, &ray);
                hits[i].primitive = ray.tfar < 0;
            }
        }
    });
}

struct Row {
    std::string scene, what;
    double ours, embree; // rays per second, or seconds of a build
    double difference;   // share of rays whose hit differs
};

class Bench {
public:
    Bench(bool quick) : quick_(quick), device_(rtcNewDevice(nullptr)) {}
    ~Bench() { rtcReleaseDevice(device_); }

    void scene(bench::SceneKind kind, uint32_t triangles) {
        std::fprintf(stderr, "scene of %u triangles\n", triangles);
        const Mesh mesh = bench::makeScene(kind, triangles);
        Structure structure(optix_, mesh);
        RTCScene peer = nullptr;
        double ours = 1e30, embree = 1e30;
        for (int i = 0; i < (quick_ ? 2 : 4); ++i) {
            ours = std::min(ours, seconds([&] { structure.build(); }));
            if (peer)
                rtcReleaseScene(peer);
            peer = embreeScene(device_, mesh);
            embree = std::min(embree, seconds([&] { rtcCommitScene(peer); }));
        }
        add({mesh.name, "build", ours, embree, 0});

        const std::vector<Ray> primary =
            bench::primaryRays(mesh, quick_ ? 640 : 1920, quick_ ? 360 : 1080);
        std::vector<BenchHit> first(primary.size());
        rays(mesh, structure, peer, Optix::kClosest, primary, "primary", &first);
        std::vector<bench::SurfacePoint> points(primary.size());
        for (size_t i = 0; i < points.size(); ++i)
            points[i] = {first[i].primitive != ~0u, first[i].t, first[i].primitive};
        const auto secondary = [&](bench::RayKind kind) {
            return bench::secondaryRays(mesh, primary, points, kind);
        };
        rays(mesh, structure, peer, Optix::kAny, secondary(bench::RayKind::kShadow), "shadow");
        rays(mesh, structure, peer, Optix::kAny, secondary(bench::RayKind::kAmbientOcclusion),
             "AO");
        rays(mesh, structure, peer, Optix::kClosest, secondary(bench::RayKind::kDiffuse),
             "diffuse");
        rtcReleaseScene(peer);
    }

    const std::vector<Row>& rows() const { return rows_; }

private:
    void rays(const Mesh& mesh, const Structure& structure, RTCScene peer, Optix::Kind kind,
              const std::vector<Ray>& rays, const char* what,
              std::vector<BenchHit>* keep = nullptr) {
        Buffer deviceRays(rays), deviceHits(rays.size() * sizeof(BenchHit));
        std::vector<BenchHit> theirs(rays.size());
        optix_.prepare(deviceRays, deviceHits, structure.handle);
        double ours = 1e30, embree = 1e30;
        for (int i = 0; i < (quick_ ? 3 : 7); ++i) {
            ours = std::min(ours, seconds([&] { optix_.launch(kind, rays.size()); }));
            embree = std::min(embree, seconds([&] { traceEmbree(peer, kind, rays, theirs); }));
        }
        const std::vector<BenchHit> hits = deviceHits.read<BenchHit>(rays.size());
        size_t different = 0;
        for (size_t i = 0; i < hits.size(); ++i)
            different += kind == Optix::kClosest
                             ? (hits[i].primitive == ~0u) != (theirs[i].primitive == ~0u)
                             : hits[i].primitive != theirs[i].primitive;
        add({mesh.name, what, double(rays.size()) / ours, double(rays.size()) / embree,
             double(different) / double(rays.size())});
        if (keep)
            *keep = hits;
    }

    void add(Row row) {
        const bool build = row.what == "build";
        const double scale = build ? 1e3 : 1e-6;
        std::fprintf(stderr, "  %-8s ours %9.2f  Embree %9.2f %s  ratio %.2f  hits that differ %.5f%%\n",
                     row.what.c_str(), row.ours * scale, row.embree * scale,
                     build ? "ms" : "Mrays/s",
                     build ? row.embree / row.ours : row.ours / row.embree, row.difference * 100);
        rows_.push_back(std::move(row));
    }

    bool quick_;
    Optix optix_;
    RTCDevice device_;
    std::vector<Row> rows_;
};

void printTable(const std::vector<Row>& rows) {
    std::printf("| scene | rays | Sunstone | Embree | ratio | hits that differ |\n"
                "|---|---|---|---|---|---|\n");
    for (const Row& r : rows) {
        const bool build = r.what == "build";
        std::printf("| %s | %s | %.2f %s | %.2f | %.2f | %.5f%% |\n", r.scene.c_str(),
                    r.what.c_str(), build ? r.ours * 1e3 : r.ours * 1e-6, build ? "ms" : "Mrays/s",
                    build ? r.embree * 1e3 : r.embree * 1e-6,
                    build ? r.embree / r.ours : r.ours / r.embree, r.difference * 100);
    }
}

void printJson(const std::vector<Row>& rows) {
    std::printf("[");
    for (size_t i = 0; i < rows.size(); ++i)
        std::printf("%s\n  {\"scene\": \"%s\", \"what\": \"%s\", \"ours\": %g, \"embree\": %g, "
                    "\"difference\": %g}",
                    i ? "," : "", rows[i].scene.c_str(), rows[i].what.c_str(), rows[i].ours,
                    rows[i].embree, rows[i].difference);
    std::printf("\n]\n");
}

} // namespace

int main(int argc, char** argv) {
    bool quick = false, json = false;
    int only = -1;
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        if (word == "--quick") {
            quick = true;
        } else if (word == "--json") {
            json = true;
        } else if (word == "--scene" && i + 1 < argc) {
            only = std::atoi(argv[++i]);
        } else {
            std::fprintf(stderr, "usage: bench_launch [--quick] [--json] [--scene 0-3]\n");
            return word == "--help" ? 0 : 2;
        }
    }
    const struct {
        bench::SceneKind kind;
        uint32_t triangles;
    } scenes[] = {{bench::SceneKind::kTerrain, 2000000},
                  {bench::SceneKind::kSoup, 1000000},
                  {bench::SceneKind::kLongThin, 1000000},
                  {bench::SceneKind::kSpheres, 10000000}};
    Bench run(quick);
    for (int i = 0; i < 4; ++i)
        if (only < 0 || only == i)
            run.scene(scenes[i].kind, scenes[i].triangles);
    json ? printJson(run.rows()) : printTable(run.rows());
}
