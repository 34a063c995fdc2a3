// SPDX-License-Identifier: Apache-2.0
// The functions of sunstone/rays.h. A scene is a structure of engine/queries and its device: a CUDA
// device if the vertices are in the memory of one, else the CPU.
#include "base/error.h"
#include "base/forked.h"
#include "base/handles.h"
#include "base/log.h"
#include "base/threads/thread_object.h"
#include "base/threads/threads.h"
#include "device/cuda/driver.h"
#include "engine/queries/queries.h"

#include "sunstone/rays.h"

#include <dlfcn.h>
#include <link.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <map>
#include <string>

namespace sunstone::door {
namespace {

struct Scene : Handled {
    std::shared_ptr<engine::QueryDevice> device;
    engine::StructurePtr structure;
    void* cudaContext = nullptr; // null: on the CPU
};
using ScenePtr = std::shared_ptr<Scene>;

HandleTable<Scene>& scenes() {
    static auto* table = new HandleTable<Scene>;
    return *table;
}

// A buffer of results is too small.
struct TooSmall : std::runtime_error {
    using std::runtime_error::runtime_error;
};

SunstoneResult resultOf(Code code) {
    switch (code) {
    case Code::kOk:
        return SUNSTONE_OK;
    case Code::kInvalidValue:
        return SUNSTONE_INVALID_VALUE;
    case Code::kNotFound:
        return SUNSTONE_INVALID_HANDLE;
    case Code::kOutOfMemory:
        return SUNSTONE_OUT_OF_MEMORY;
    case Code::kNotSupported:
        return SUNSTONE_NOT_SUPPORTED;
    default:
        return SUNSTONE_FAILED;
    }
}

SunstoneResult guarded(const char* function, const std::function<void()>& body) {
    if (refusesForkedChild())
        return SUNSTONE_FAILED;
    SunstoneResult result = SUNSTONE_FAILED;
    std::string cause;
    try {
        body();
        return SUNSTONE_OK;
    } catch (const Error& error) {
        result = resultOf(error.code());
        cause = error.what();
    } catch (const TooSmall& error) {
        result = SUNSTONE_TOO_SMALL;
        cause = error.what();
    } catch (const std::bad_alloc&) {
        result = SUNSTONE_OUT_OF_MEMORY;
        cause = "no host memory";
    } catch (const std::exception& error) {
        cause = error.what();
    }
    std::string& text = threadObject<std::string>();
    text = message(function, ": ", cause);
    log(LogLevel::kError, "rays", text);
    return result;
}

ScenePtr sceneOf(SunstoneScene handle, const char* parameter) {
    if (!handle)
        fail(Code::kInvalidValue, parameter, " is null");
    const ScenePtr scene = scenes().find(handle);
    if (!scene)
        fail(Code::kNotFound, parameter, " = ", static_cast<void*>(handle), " is not a live scene");
    return scene;
}

// Functions of the loaded libcuda.so.1 that distinguish device memory from host memory. This
// library opens no driver: device arrays exist only if the application has one.
struct Cuda {
    decltype(&::cuPointerGetAttribute) pointerGetAttribute = nullptr;
    decltype(&::cuCtxPushCurrent) ctxPushCurrent = nullptr;
    decltype(&::cuCtxPopCurrent) ctxPopCurrent = nullptr;
    bool operator==(const Cuda&) const = default;
};

// Counts loads and unloads of libraries.
uint64_t libraryChanges() {
    uint64_t changes = 0;
    dl_iterate_phdr(
        [](dl_phdr_info* info, size_t, void* to) {
            *static_cast<uint64_t*>(to) = info->dlpi_adds + info->dlpi_subs;
            return 1;
        },
        &changes);
    return changes;
}

Cuda findCuda() {
    void* const library = dlopen("libcuda.so.1", RTLD_LAZY | RTLD_NOLOAD);
    if (!library)
        return {};
    Cuda made;
    const auto find = [&](auto& member, const char* name) {
        member = reinterpret_cast<std::remove_reference_t<decltype(member)>>(dlsym(library, name));
    };
    find(made.pointerGetAttribute, device::cuda::DriverNames::pointerGetAttribute);
    find(made.ctxPushCurrent, device::cuda::DriverNames::ctxPushCurrent);
    find(made.ctxPopCurrent, device::cuda::DriverNames::ctxPopCurrent);
    dlclose(library);
    const bool complete = made.pointerGetAttribute && made.ctxPushCurrent && made.ctxPopCurrent;
    return complete ? made : Cuda();
}

// Queries the loader only after a change, because an unsuccessful search takes longer than a query
// of few rays.
const Cuda* loadedCuda() {
    static auto* const mutex = new std::mutex;
    static uint64_t asked = ~uint64_t(0);
    static auto* const all = new std::deque<Cuda>; // never freed: other threads may be in a call
    static const Cuda* found = nullptr;
    const uint64_t changes = libraryChanges();
    std::lock_guard lock(*mutex);
    if (asked != changes) {
        asked = changes;
        const Cuda now = findCuda();
        const auto known = std::find(all->begin(), all->end(), now);
        found = now == Cuda()         ? nullptr
                : known != all->end() ? &*known
                                      : &all->emplace_back(now);
    }
    return found;
}

// The CUDA context of device memory; null for memory of the host.
void* contextOf(const void* address) {
    const Cuda* const cuda = address ? loadedCuda() : nullptr;
    unsigned type = 0;
    CUcontext context = nullptr;
    const auto ask = [&](void* to, CUpointer_attribute attribute) {
        return cuda->pointerGetAttribute(to, attribute, CUdeviceptr(address)) == CUDA_SUCCESS;
    };
    if (!cuda || !ask(&type, CU_POINTER_ATTRIBUTE_MEMORY_TYPE) || type != CU_MEMORYTYPE_DEVICE ||
        !ask(&context, CU_POINTER_ATTRIBUTE_CONTEXT))
        return nullptr;
    return context;
}

class CurrentContext {
public:
    explicit CurrentContext(void* context) : pushed_(context != nullptr) {
        const Cuda* const cuda = pushed_ ? loadedCuda() : nullptr;
        if (pushed_ && (!cuda || cuda->ctxPushCurrent(CUcontext(context)) != CUDA_SUCCESS))
            fail(Code::kCudaError, "the scene's CUDA context does not exist any more");
    }
    ~CurrentContext() {
        CUcontext popped = nullptr;
        if (const Cuda* const cuda = pushed_ ? loadedCuda() : nullptr)
            cuda->ctxPopCurrent(&popped);
    }
    CurrentContext(const CurrentContext&) = delete;
    CurrentContext& operator=(const CurrentContext&) = delete;

private:
    bool pushed_;
};

// One for each CUDA context, and one for the CPU (null).
std::shared_ptr<engine::QueryDevice> deviceOf(void* context) {
    static auto* const mutex = new std::mutex;
    static auto* const devices = new std::map<void*, std::shared_ptr<engine::QueryDevice>>;
    std::lock_guard lock(*mutex);
    std::shared_ptr<engine::QueryDevice>& device = (*devices)[context];
    if (!device && !context)
        device = engine::cpuQueries();
    else if (!device)
        device = device::cuda::loadedDriver() == device::cuda::LoadedDriver::kGpu
                     ? engine::gpuQueries(context)
                     : engine::cpuStreamQueries();
    return device;
}

// Checks that the bytes are readable (or also writable). Returns whether they are host memory.
bool isHostArray(const Scene& scene, const void* address, uint64_t bytes, const char* name,
                 bool written) {
    if (bytes == 0)
        return true;
    void* const context = contextOf(address);
    if (context && context != scene.cudaContext)
        fail(Code::kNotSupported, name, " is memory of a CUDA device, but the scene is not there");
    const bool usable = context   ? scene.device->isDeviceMemory(address, bytes)
                        : written ? engine::isHostWritable(const_cast<void*>(address), bytes)
                                  : engine::isHostReadable(address, bytes);
    if (!usable)
        fail(Code::kInvalidValue, name, ": the ", bytes, " bytes at ", address,
             " are not all memory that can be ", written ? "written" : "read");
    return !context;
}

uint64_t bytesOf(size_t count, size_t size, const char* name) {
    if (count > (size_t(1) << 47) / size)
        fail(Code::kInvalidValue, name, " = ", count, " is beyond the address space");
    return uint64_t(count) * size;
}

template <class T>
void requireNonNull(const T* pointer, const char* name) {
    if (!pointer)
        fail(Code::kInvalidValue, name, " is null");
}

SunstoneScene publish(const ScenePtr& scene) {
    watchForks();
    return static_cast<SunstoneScene>(scenes().add(scene));
}

void createScene(const SunstoneMesh& mesh, SunstoneScene& out) {
    constexpr size_t kMost = size_t(1) << 31;
    if (mesh.vertexCount > kMost || mesh.triangleCount > kMost)
        fail(Code::kInvalidValue, "more than ", kMost, " vertices or triangles");
    if (!mesh.triangles && mesh.vertexCount % 3 != 0)
        fail(Code::kInvalidValue, "vertexCount = ", mesh.vertexCount,
             ", but without triangles every three vertices are one");
    const auto scene = std::make_shared<Scene>();
    scene->cudaContext = mesh.vertexCount ? contextOf(mesh.vertices) : nullptr;
    scene->device = deviceOf(scene->cudaContext);
    CurrentContext current(scene->cudaContext);
    engine::ModelTriangles triangles;
    triangles.vertices = {mesh.vertices, mesh.vertexCount, 12, true};
    triangles.vertices.onHost = isHostArray(
        *scene, mesh.vertices, bytesOf(mesh.vertexCount, 12, "vertexCount"), "vertices", false);
    if (mesh.triangles) {
        triangles.indices = {mesh.triangles, mesh.triangleCount, 12, true};
        triangles.indices.onHost =
            isHostArray(*scene, mesh.triangles, bytesOf(mesh.triangleCount, 12, "triangleCount"),
                        "triangles", false);
    }
    scene->structure = scene->device->build(triangles);
    out = publish(scene);
}

void createInstances(const SunstoneInstance* instances, size_t count, SunstoneScene& out) {
    if (count > size_t(1) << 28)
        fail(Code::kInvalidValue, "count = ", count, " is more than 2^28 instances");
    const auto top = std::make_shared<Scene>();
    top->device = deviceOf(nullptr);
    if (count && !engine::isHostReadable(instances, count * sizeof(*instances)))
        fail(Code::kInvalidValue, "instances are not memory that can be read");
    engine::ModelInstances input;
    std::vector<float> rows;
    for (size_t i = 0; i < count; ++i) {
        const std::string name = message("instances[", i, "].scene");
        const ScenePtr scene = sceneOf(instances[i].scene, name.c_str());
        if (scene->structure->isInstances)
            fail(Code::kInvalidValue, name, " has instances itself");
        if (i != 0 && scene->cudaContext != top->cudaContext)
            fail(Code::kInvalidValue, name, " is on another device than instances[0].scene");
        top->cudaContext = scene->cudaContext;
        top->device = scene->device;
        input.models.push_back(scene->structure);
        rows.insert(rows.end(), instances[i].transform, instances[i].transform + 12);
    }
    input.transforms = {rows.data(), count, 48, true};
    CurrentContext current(top->cudaContext);
    top->structure = top->device->build(input);
    out = publish(top);
}

void trace(SunstoneScene handle, const SunstoneRay* rays, size_t count, SunstoneHit* hits,
           bool any) {
    const ScenePtr scene = sceneOf(handle, "scene");
    engine::TraceRequest request;
    request.structure = scene->structure;
    request.rays = rays;
    request.hits = hits;
    request.count = count;
    request.hitFormat = bvh::HitFormat::kTTriangleInstanceUv;
    request.any = any;
    CurrentContext current(scene->cudaContext);
    request.raysOnHost =
        isHostArray(*scene, rays, bytesOf(count, sizeof(*rays), "count"), "rays", false);
    request.hitsOnHost =
        isHostArray(*scene, hits, bytesOf(count, sizeof(*hits), "count"), "hits", true);
    scene->device->trace(request)->wait();
}

// The structure and the arrays must be the host's.
void requireCpu(const Scene& scene) {
    if (!scene.device->usesCpuLayout())
        fail(Code::kNotSupported, "the function does not exist on GPUs yet");
}

void allHits(SunstoneScene handle, const SunstoneRay* rays, size_t count, SunstoneHit* hits,
             size_t capacity, size_t* offsets) {
    const ScenePtr scene = sceneOf(handle, "scene");
    requireCpu(*scene);
    requireNonNull(offsets, "offsets");
    isHostArray(*scene, rays, bytesOf(count, sizeof(*rays), "count"), "rays", false);
    isHostArray(*scene, offsets, bytesOf(count + 1, sizeof(*offsets), "count"), "offsets", true);
    isHostArray(*scene, hits, bytesOf(capacity, sizeof(*hits), "capacity"), "hits", true);
    engine::TraceRequest request;
    request.structure = scene->structure;
    request.rays = rays;
    request.count = count;
    const bvh::RayBatch batch = request.batch();
    constexpr size_t kBlock = 1024;
    std::vector<std::vector<bvh::ListedHit>> blocks((count + kBlock - 1) / kBlock);
    const bvh::BatchKernels& kernels = bvh::batchKernels(bvh::chosenIsa());
    parallelFor(blocks.size(), 1, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i)
            kernels.all(batch, i * kBlock, std::min(count, (i + 1) * kBlock), blocks[i]);
    });
    std::fill_n(offsets, count + 1, size_t(0));
    for (const auto& block : blocks)
        for (const bvh::ListedHit& hit : block)
            ++offsets[hit.ray + 1];
    for (size_t i = 0; i < count; ++i)
        offsets[i + 1] += offsets[i];
    if (offsets[count] > capacity)
        throw TooSmall(message("capacity = ", capacity, " is less than the ", offsets[count],
                               " hits of all rays"));
    SunstoneHit* to = hits;
    for (const auto& block : blocks)
        for (const bvh::ListedHit& hit : block)
            *to++ = {hit.hit.t, int32_t(hit.hit.triangle), int32_t(hit.hit.instance), hit.hit.u,
                     hit.hit.v};
}

void nearestPoints(SunstoneScene handle, const float* points, size_t count, float farthest,
                   SunstoneNearest* nearest) {
    const ScenePtr scene = sceneOf(handle, "scene");
    requireCpu(*scene);
    if (!(farthest >= 0))
        fail(Code::kInvalidValue, "farthest = ", farthest, " is not a distance");
    isHostArray(*scene, points, bytesOf(count, 12, "count"), "points", false);
    isHostArray(*scene, nearest, bytesOf(count, sizeof(*nearest), "count"), "nearest", true);
    static_assert(sizeof(SunstoneNearest) == sizeof(bvh::NearestPoint));
    const bvh::BatchKernels& kernels = bvh::batchKernels(bvh::chosenIsa());
    const uint64_t block = scene->structure->handle;
    constexpr size_t kGrain = 64;
    parallelFor(count, kGrain, [&](size_t begin, size_t end) {
        kernels.nearest(block, points, farthest, reinterpret_cast<bvh::NearestPoint*>(nearest),
                        begin, end);
    });
}

} // namespace

extern "C" SunstoneResult sunstoneSceneCreate(const SunstoneMesh* mesh, SunstoneScene* scene) {
    return guarded("sunstoneSceneCreate", [&] {
        requireNonNull(mesh, "mesh");
        requireNonNull(scene, "scene");
        createScene(*mesh, *scene);
    });
}

extern "C" SunstoneResult sunstoneSceneCreateInstances(const SunstoneInstance* instances,
                                                       size_t count, SunstoneScene* scene) {
    return guarded("sunstoneSceneCreateInstances", [&] {
        requireNonNull(scene, "scene");
        createInstances(instances, count, *scene);
    });
}

extern "C" SunstoneResult sunstoneSceneDestroy(SunstoneScene scene) {
    return guarded("sunstoneSceneDestroy", [&] {
        sceneOf(scene, "scene");
        scenes().remove(scene);
    });
}

extern "C" SunstoneResult sunstoneClosestHits(SunstoneScene scene, const SunstoneRay* rays,
                                              size_t count, SunstoneHit* hits) {
    return guarded("sunstoneClosestHits", [&] { trace(scene, rays, count, hits, false); });
}

extern "C" SunstoneResult sunstoneAnyHits(SunstoneScene scene, const SunstoneRay* rays,
                                          size_t count, SunstoneHit* hits) {
    return guarded("sunstoneAnyHits", [&] { trace(scene, rays, count, hits, true); });
}

extern "C" SunstoneResult sunstoneAllHits(SunstoneScene scene, const SunstoneRay* rays,
                                          size_t count, SunstoneHit* hits, size_t capacity,
                                          size_t* offsets) {
    return guarded("sunstoneAllHits",
                   [&] { allHits(scene, rays, count, hits, capacity, offsets); });
}

extern "C" SunstoneResult sunstoneNearestPoints(SunstoneScene scene, const float* points,
                                                size_t count, float farthest,
                                                SunstoneNearest* nearest) {
    return guarded("sunstoneNearestPoints",
                   [&] { nearestPoints(scene, points, count, farthest, nearest); });
}

extern "C" const char* sunstoneLastError(void) {
    if (isForkedChild())
        return kForkedChildText;
    return threadObject<std::string>().c_str();
}

} // namespace sunstone::door
