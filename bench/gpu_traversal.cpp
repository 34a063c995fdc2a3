// SPDX-License-Identifier: Apache-2.0
// Builds and traversal on a GPU with Sunstone's kernels alone: build times, sizes, rays per second
// of each kernel, and the number of hits that differ from the CPU's.
//   bench_gpu_kernels [--scenes terrain,soup,thin,spheres] [--triangles N] [--width 1920]
//                     [--repeats 6] [--all-flags 1] [--driver libcuda.so.1] [--one-block 0]
// --one-block 0: builds of few triangles take the kernels of large ones.
// Reads gpu_traversal.ptx beside the program.
#include "gpu_traversal.h"
#include "bvh/gpu/build/builder.h"
#include "bvh/walk/kernels.h"
#include "scenes.h"

#include "base/error.h"
#include "bvh/layout.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <dlfcn.h>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <string>

namespace {

using namespace bench;
using namespace sunstone;

device::cuda::Driver gpu;

void check(CUresult result, const char* what) {
    if (result == CUDA_SUCCESS)
        return;
    const char* name = "";
    gpu.getErrorName(result, &name);
    std::fprintf(stderr, "%s: %s\n", what, name);
    std::exit(1);
}
#define GPU(member, ...) check(gpu.member(__VA_ARGS__), #member)

void openDriver(const char* path) {
    void* const library = dlopen(path, RTLD_NOW);
    if (!library) {
        std::fprintf(stderr, "%s\n", dlerror());
        std::exit(1);
    }
#define SUNSTONE_CUDA_MEMBER(member, function)                                                     \
    gpu.member =                                                                                   \
        reinterpret_cast<decltype(gpu.member)>(dlsym(library, device::cuda::DriverNames::member));
    SUNSTONE_CUDA_FUNCTIONS(SUNSTONE_CUDA_MEMBER)
#undef SUNSTONE_CUDA_MEMBER
    const auto retain = reinterpret_cast<decltype(&cuDevicePrimaryCtxRetain)>(
        dlsym(library, "cuDevicePrimaryCtxRetain"));
    CUcontext context = nullptr;
    check(gpu.init(0), "cuInit");
    check(retain(&context, 0), "cuDevicePrimaryCtxRetain");
    GPU(ctxPushCurrent, context);
}

struct Buffer {
    CUdeviceptr address = 0;
    size_t size;
    explicit Buffer(size_t bytes) : size(bytes) { GPU(memAlloc, &address, bytes ? bytes : 16); }
    template <class T>
    explicit Buffer(const std::vector<T>& data) : Buffer(data.size() * sizeof(T)) {
        GPU(memcpyHtoD, address, data.data(), size);
    }
    ~Buffer() { gpu.memFree(address); }
    Buffer(const Buffer&) = delete;
    template <class T>
    std::vector<T> read() const {
        std::vector<T> data(size / sizeof(T));
        GPU(memcpyDtoH, data.data(), address, data.size() * sizeof(T));
        return data;
    }
};

struct Timer {
    CUevent begin, end;
    Timer() {
        GPU(eventCreate, &begin, 0);
        GPU(eventCreate, &end, 0);
    }
    template <class Work>
    double milliseconds(const Work& work) {
        GPU(eventRecord, begin, nullptr);
        work();
        GPU(eventRecord, end, nullptr);
        GPU(eventSynchronize, end);
        float ms = 0;
        GPU(eventElapsedTime, &ms, begin, end);
        return double(ms);
    }
};

// The time of each kernel of a build.
struct StageTimes {
    std::vector<std::pair<const char*, CUevent>> marks;
    static void mark(void* self, const char* name) {
        CUevent event;
        GPU(eventCreate, &event, 0);
        GPU(eventRecord, event, nullptr);
        static_cast<StageTimes*>(self)->marks.push_back({name, event});
    }
    void print() const {
        std::printf("   stages, us:");
        for (size_t i = 1; i < marks.size(); ++i) {
            float ms = 0;
            GPU(eventElapsedTime, &ms, marks[i - 1].second, marks[i].second);
            std::printf(" %s %.0f", marks[i].first, double(ms) * 1e3);
        }
        std::printf("\n");
    }
};

struct Hit {
    float t;
    uint32_t primitive;
};

class Bench {
public:
    explicit Bench(const std::string& folder) : builder_(gpu) {
        std::ifstream file(folder + "/gpu_traversal.ptx");
        const std::string ptx{std::istreambuf_iterator<char>(file), {}};
        GPU(moduleLoadDataEx, &module_, ptx.c_str(), 0, nullptr, nullptr);
        CUdevice device = 0;
        GPU(ctxGetDevice, &device);
        GPU(deviceGetAttribute, &multiprocessors_, CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT,
            device);
    }

    void buildAsLarge() { builder_.setMostInBlock(0); }

    void scene(const Mesh& mesh) {
        std::printf("== %s, %u triangles\n", mesh.name.c_str(), mesh.numTriangles());
        const Buffer vertices(mesh.vertices), indices(mesh.indices);
        bvh::TriangleInput input = inputOf(mesh, mesh.vertices.data(), mesh.indices.data());
        const auto reference = buildOnCpu(input);
        input = inputOf(mesh, reinterpret_cast<const void*>(vertices.address),
                        reinterpret_cast<const void*>(indices.address));
        const std::vector<Ray> primary = primaryRays(mesh, width, width * 9 / 16);
        const std::vector<Hit> first = answer(reference.get(), primary, false);
        std::vector<SurfacePoint> points(primary.size());
        for (size_t i = 0; i < points.size(); ++i)
            points[i] = {first[i].primitive != ~0u, first[i].t, first[i].primitive};
        update(mesh, input);
        for (const char* prefer : {"nothing", "fast trace", "fast build"}) {
            bvh::BuildOptions options;
            options.preferFastTrace = prefer == std::string("fast trace");
            options.preferFastBuild = prefer == std::string("fast build");
            if ((options.preferFastTrace || options.preferFastBuild) && !allFlags)
                break;
            const uint64_t handle = build(mesh, input, options);
            rays(reference, handle, primary, "primary", false);
            const auto secondary = [&](RayKind kind) {
                return secondaryRays(mesh, primary, points, kind);
            };
            rays(reference, handle, secondary(RayKind::kShadow), "shadow", true);
            rays(reference, handle, secondary(RayKind::kAmbientOcclusion), "AO", true);
            rays(reference, handle, secondary(RayKind::kDiffuse), "diffuse", false);
        }
    }

    uint32_t width = 1920;
    bool allFlags = false;

private:
    struct Free {
        void operator()(void* p) const { std::free(p); }
    };
    using Block = std::unique_ptr<void, Free>;

    static bvh::TriangleInput inputOf(const Mesh& mesh, const void* vertices, const void* indices) {
        bvh::TriangleInput in;
        in.vertices = vertices;
        in.numVertices = mesh.numVertices();
        in.indices = indices;
        in.indexFormat = bvh::IndexFormat::kUint3;
        in.numTriangles = mesh.numTriangles();
        return in;
    }

    static Block buildOnCpu(const bvh::TriangleInput& input) {
        bvh::BuildInputs inputs;
        inputs.triangles = {&input, 1};
        const bvh::MemoryUsage usage = bvh::computeMemoryUsage(inputs, {});
        const Block temp(std::aligned_alloc(128, usage.temp));
        Block output(std::aligned_alloc(128, usage.output));
        bvh::build(inputs, {}, temp.get(), usage.temp, output.get(), usage.output);
        return output;
    }

    static std::vector<Hit> answer(const void* block, const std::vector<Ray>& rays, bool any) {
        std::vector<Hit> hits(rays.size());
        const bvh::Kernels& kernels = bvh::kernels(bvh::chosenIsa());
        tbb::parallel_for(size_t(0), rays.size(), [&](size_t i) {
            bvh::QueryRay ray;
            static_assert(sizeof ray == sizeof(Ray));
            std::memcpy(&ray, &rays[i], sizeof ray);
            bvh::QueryHit hit;
            if (any)
                hits[i] = {0, kernels.occluded(block, ray) ? 1u : ~0u};
            else if (kernels.closest(block, ray, hit))
                hits[i] = {hit.t, hit.primitive};
            else
                hits[i] = {-1, ~0u};
        });
        return hits;
    }

    uint64_t build(const Mesh& mesh, const bvh::TriangleInput& input,
                   const bvh::BuildOptions& options) {
        bvh::BuildInputs inputs;
        inputs.triangles = {&input, 1};
        const bvh::MemoryUsage usage = bvh::gpu::Builder::computeMemoryUsage(inputs, options);
        const Buffer temp(usage.temp), output(usage.output), size(8);
        double best = 1e30;
        for (int i = 0; i < 8; ++i)
            best = std::min(best, timer_.milliseconds([&] {
                builder_.build(nullptr, inputs, options, temp.address, usage.temp, output.address,
                               usage.output);
            }));
        StageTimes stages;
        builder_.observe(StageTimes::mark, &stages);
        builder_.build(nullptr, inputs, options, temp.address, usage.temp, output.address,
                       usage.output);
        builder_.observe(nullptr, nullptr);
        builder_.emitCompactedSize(nullptr, output.address, size.address);
        const uint64_t compacted = size.read<uint64_t>()[0];
        structure_ = std::make_unique<Buffer>(compacted);
        const double compaction = timer_.milliseconds(
            [&] { builder_.compact(nullptr, output.address, structure_->address, compacted); });
        const auto header = structure_->read<bvh::BlockHeader>()[0];
        const double n = mesh.numTriangles();
        std::printf(
            "build %s: %.3f ms, compaction %.3f ms; bytes a triangle: temp %.1f, output %.1f, "
            "compacted %.1f; %u nodes (%.2f triangles each)\n",
            options.preferFastTrace   ? "fast trace"
            : options.preferFastBuild ? "fast build"
                                      : "default",
            best, compaction, double(usage.temp) / n, double(usage.output) / n,
            double(compacted) / n, header.numNodes, n / header.numNodes);
        stages.print();
        return structure_->address | devlib::kTagGas;
    }

    void update(const Mesh& mesh, const bvh::TriangleInput& input) {
        bvh::BuildInputs inputs;
        inputs.triangles = {&input, 1};
        bvh::BuildOptions options;
        options.allowUpdate = true;
        const bvh::MemoryUsage usage = bvh::gpu::Builder::computeMemoryUsage(inputs, options);
        const Buffer temp(usage.temp), output(usage.output);
        builder_.build(nullptr, inputs, options, temp.address, usage.temp, output.address,
                       usage.output);
        double best = 1e30;
        for (int i = 0; i < 8; ++i)
            best = std::min(best, timer_.milliseconds([&] {
                builder_.update(nullptr, inputs, options, temp.address, usage.temp, output.address,
                                usage.output);
            }));
        StageTimes stages;
        builder_.observe(StageTimes::mark, &stages);
        builder_.update(nullptr, inputs, options, temp.address, usage.temp, output.address,
                        usage.output);
        builder_.observe(nullptr, nullptr);
        GPU(ctxSynchronize);
        std::printf("update: %.3f ms; temp %.1f bytes a triangle\n", best,
                    double(usage.tempUpdate) / mesh.numTriangles());
        stages.print();
        for (const std::string& failure : builder_.takeFailures())
            std::printf("FAILED: %s\n", failure.c_str());
    }

    void rays(const Block& reference, uint64_t handle, const std::vector<Ray>& rays,
              const char* what, bool any) {
        if (rays.empty())
            return;
        const std::vector<Hit> expected = answer(reference.get(), rays, any);
        const Buffer deviceRays(rays), hits(rays.size() * sizeof(Hit)), counter(16);
        GpuBenchJob job{deviceRays.address, hits.address,          handle,
                        counter.address,    uint32_t(rays.size()), 0};
        std::printf(" %-8s %u rays:", what, job.count);
        const std::string kind = any ? "any_" : "nearest_";
        run(job, kind + "plain", 0, expected, hits);
        for (const char* variant : {"persistent", "persistent_8"})
            for (uint32_t wanted : {20u})
                run(job, kind + variant, wanted, expected, hits);
        std::printf("\n");
        std::fflush(stdout);
    }

    void run(GpuBenchJob job, const std::string& name, uint32_t wanted,
             const std::vector<Hit>& expected, const Buffer& hits) {
        CUfunction kernel;
        GPU(moduleGetFunction, &kernel, module_, name.c_str());
        job.wanted = wanted;
        uint32_t blocks = (job.count + 127) / 128;
        if (wanted) {
            int perMultiprocessor = 1;
            GPU(occupancyMaxActiveBlocksPerMultiprocessor, &perMultiprocessor, kernel, 128, 0);
            blocks = std::min(blocks, uint32_t(perMultiprocessor * multiprocessors_));
        }
        void* arguments[] = {&job};
        double best = 1e30;
        GPU(memsetD8Async, hits.address, 0xEE, hits.size, nullptr);
        for (int i = 0; i < repeats; ++i) {
            GPU(memsetD8Async, job.counter, 0, 16, nullptr);
            best = std::min(best, timer_.milliseconds([&] {
                GPU(launchKernel, kernel, blocks, 1, 1, 128, 1, 1, 0, nullptr, arguments, nullptr);
            }));
        }
        const std::vector<Hit> found = hits.read<Hit>();
        size_t different = 0;
        for (size_t i = 0; i < found.size(); ++i)
            different += found[i].primitive != expected[i].primitive ||
                         (expected[i].t > 0 && found[i].t != expected[i].t);
        std::printf(" | %s/%u %.0f", name.c_str() + name.find('_') + 1, wanted,
                    job.count / best * 1e-3);
        if (different)
            std::printf(" DIFFERENT %zu", different);
    }

    bvh::gpu::Builder builder_;
    CUmodule module_ = nullptr;
    int multiprocessors_ = 1;
    Timer timer_;
    std::unique_ptr<Buffer> structure_;

public:
    int repeats = 6;
};

} // namespace

int main(int argc, char** argv) {
    std::string scenes = "terrain,soup,thin,spheres", driverPath = "libcuda.so.1", folder = argv[0];
    folder = folder.find('/') == std::string::npos ? "." : folder.substr(0, folder.rfind('/'));
    uint32_t triangles = 0, width = 1920;
    int repeats = 6;
    bool allFlags = false, oneBlock = true;
    for (int i = 1; i + 1 < argc; i += 2) {
        const std::string option = argv[i];
        if (option == "--scenes")
            scenes = argv[i + 1];
        else if (option == "--driver")
            driverPath = argv[i + 1];
        else if (option == "--triangles")
            triangles = uint32_t(std::stoul(argv[i + 1]));
        else if (option == "--width")
            width = uint32_t(std::stoul(argv[i + 1]));
        else if (option == "--repeats")
            repeats = std::stoi(argv[i + 1]);
        else if (option == "--all-flags")
            allFlags = std::stoi(argv[i + 1]) != 0;
        else if (option == "--one-block")
            oneBlock = std::stoi(argv[i + 1]) != 0;
    }
    openDriver(driverPath.c_str());
    try {
        Bench bench(folder);
        bench.width = width;
        bench.repeats = repeats;
        bench.allFlags = allFlags;
        if (!oneBlock)
            bench.buildAsLarge();
        const std::map<std::string, std::pair<SceneKind, uint32_t>> known = {
            {"terrain", {SceneKind::kTerrain, 2000000}},
            {"soup", {SceneKind::kSoup, 1000000}},
            {"thin", {SceneKind::kLongThin, 1000000}},
            {"spheres", {SceneKind::kSpheres, 10000000}}};
        for (size_t at = 0; at < scenes.size();) {
            const size_t end = std::min(scenes.find(',', at), scenes.size());
            const auto& [kind, count] = known.at(scenes.substr(at, end - at));
            bench.scene(makeScene(kind, triangles ? triangles : count));
            at = end + 1;
        }
    } catch (const Error& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
    return 0;
}
