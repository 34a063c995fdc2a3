// SPDX-License-Identifier: Apache-2.0
// Parts that the programs of the second and the later sets share on the host: pipelines with the
// time that they take, records, structures, textures, CUDA kernels. Each program has launch
// parameters, records and frames of its own.
#pragma once

#include "../job.h"
#include "../scene.h"

#include <cuda.h>

#include <array>
#include <span>

namespace bench {

struct Function {
    OptixModule module = nullptr;
    const char* name = nullptr;
};
// Functions may be empty.
struct HitFunctions {
    Function closestHit, anyHit, intersection;
};
struct Depths {
    unsigned trace = 1, graph = 1, directCallables = 0, continuationCallables = 0;
};

// Modules, program groups and pipelines of one context.
class Programs {
public:
    explicit Programs(OptixDeviceContext context);
    Programs(const Programs&) = delete;
    Programs& operator=(const Programs&) = delete;
    ~Programs();

    // Set these before the first module.
    OptixModuleCompileOptions moduleOptions = {};
    OptixPipelineCompileOptions options = {};

    OptixModule load(std::string_view ptx);
    OptixModule builtin(OptixPrimitiveType type, unsigned buildFlags);
    OptixProgramGroup raygen(Function function);
    OptixProgramGroup miss(Function function, OptixPayloadType* type = nullptr);
    OptixProgramGroup hit(const HitFunctions& functions, OptixPayloadType* type = nullptr);
    OptixProgramGroup direct(Function function);
    OptixProgramGroup continuation(Function function);
    OptixPipeline link(const std::vector<OptixProgramGroup>& groups, const Depths& depths);
    // Milliseconds of all calls above.
    double compileTime() const { return compileTime_; }

private:
    OptixProgramGroup add(const OptixProgramGroupDesc& description, OptixPayloadType* type);

    OptixDeviceContext context_;
    std::vector<OptixModule> modules_;
    std::vector<OptixProgramGroup> groups_;
    std::vector<OptixPipeline> pipelines_;
    double compileTime_ = 0;
};

// A shader binding table. Each kind of records has one type.
class Table {
public:
    template <class T>
    void setRaygen(const SbtRecord<T>& record) {
        raygen_.upload(&record, sizeof(record));
        table_.raygenRecord = raygen_.address();
    }
    template <class T>
    void setMisses(const std::vector<SbtRecord<T>>& records) {
        put(misses_, records, table_.missRecordBase, table_.missRecordStrideInBytes,
            table_.missRecordCount);
    }
    template <class T>
    void setHits(const std::vector<SbtRecord<T>>& records) {
        put(hits_, records, table_.hitgroupRecordBase, table_.hitgroupRecordStrideInBytes,
            table_.hitgroupRecordCount);
    }
    template <class T>
    void setCallables(const std::vector<SbtRecord<T>>& records) {
        put(callables_, records, table_.callablesRecordBase, table_.callablesRecordStrideInBytes,
            table_.callablesRecordCount);
    }
    const OptixShaderBindingTable& get() const { return table_; }

private:
    template <class T>
    static void put(DeviceBuffer& memory, const std::vector<SbtRecord<T>>& records,
                    CUdeviceptr& base, unsigned& stride, unsigned& count) {
        memory.upload(records);
        base = memory.address();
        stride = sizeof(SbtRecord<T>);
        count = unsigned(records.size());
    }
    OptixShaderBindingTable table_ = {};
    DeviceBuffer raygen_, misses_, hits_, callables_;
};

// Launch parameters and their device memory.
template <class T>
class Launch {
public:
    T params = {};
    void run(OptixPipeline pipeline, const Table& table, unsigned width, unsigned height = 1,
             unsigned depth = 1, cudaStream_t stream = nullptr) {
        if (memory_.size() == 0)
            memory_.allocate(sizeof(T));
        CUDA_CHECK(
            cudaMemcpyAsync(memory_.data(), &params, sizeof(T), cudaMemcpyHostToDevice, stream));
        OPTIX_CHECK(optixLaunch(pipeline, stream, memory_.address(), sizeof(T), &table.get(), width,
                                height, depth));
    }

private:
    DeviceBuffer memory_;
};

// Device memory and structures that live as long as a program.
class Scene {
public:
    explicit Scene(OptixDeviceContext context) : context_(context) {}
    OptixDeviceContext context() const { return context_; }

    template <class T>
    T* upload(const std::vector<T>& data) {
        buffers_.emplace_back();
        buffers_.back().upload(data);
        return buffers_.back().as<T>();
    }
    // Zeros.
    template <class T>
    T* allocate(size_t count) {
        buffers_.emplace_back(count * sizeof(T));
        CUDA_CHECK(cudaMemset(buffers_.back().data(), 0, count * sizeof(T)));
        return buffers_.back().as<T>();
    }
    OptixTraversableHandle build(const OptixBuildInput& input, unsigned flags = 0);
    // `flags`: of one record.
    OptixTraversableHandle buildBoxes(const std::vector<OptixAabb>& boxes, unsigned flags);
    OptixTraversableHandle buildInstances(const std::vector<OptixInstance>& instances);

private:
    OptixDeviceContext context_;
    std::vector<DeviceBuffer> buffers_;
    std::vector<Accel> structures_;
};

// A structure that a program builds in memory of its own, again or by updates.
class LiveStructure {
public:
    LiveStructure(OptixDeviceContext context, unsigned flags) : context_(context), flags_(flags) {}
    // Queues the work; the first call allocates memory for the size of the input.
    void build(const OptixBuildInput& input, OptixBuildOperation operation);
    OptixTraversableHandle handle() const { return handle_; }

private:
    OptixDeviceContext context_;
    unsigned flags_;
    DeviceBuffer output_, temporary_;
    OptixTraversableHandle handle_ = 0;
};

struct MeshMemory {
    CUdeviceptr vertices = 0; // float3
    CUdeviceptr indices = 0;  // uint3
    unsigned vertexCount = 0, triangleCount = 0;
};
MeshMemory uploadMesh(Scene& scene, const Mesh& mesh);
// The input refers to the arguments.
OptixBuildInput inputOf(const MeshMemory& mesh, const unsigned& flags);
// One structure of a mesh with a record for each material.
OptixTraversableHandle buildMaterials(Scene& scene, const MaterialMesh& mesh, MeshMemory& memory);
OptixInstance instanceOf(OptixTraversableHandle child, const float* transform, unsigned id = 0,
                         unsigned record = 0);
extern const float kIdentity[12];
OptixBuildInput inputOfInstances(CUdeviceptr instances, size_t count);

// Textures of other kinds than bench::Texture.
struct TextureShape {
    unsigned width = 1, height = 1, depth = 0; // 0: two dimensions
    bool wraps = true;
};
class FloatTexture {
public:
    // One or four channels.
    FloatTexture(const std::vector<float>& texels, unsigned channels, const TextureShape& shape);
    FloatTexture(FloatTexture&& other) noexcept;
    FloatTexture& operator=(FloatTexture&&) = delete;
    ~FloatTexture();
    cudaTextureObject_t object() const { return object_; }

private:
    cudaArray_t array_ = nullptr;
    cudaTextureObject_t object_ = 0;
};
// Spots of two shades, four bytes a texel.
std::vector<unsigned char> spots(unsigned seed, unsigned side);

// Kernels of a PTX module, by functions of the driver that the runtime finds.
class Kernels {
public:
    explicit Kernels(std::string_view ptx);
    Kernels(const Kernels&) = delete;
    Kernels& operator=(const Kernels&) = delete;
    ~Kernels();
    // One thread for each of `count` items; `argument`: the only one.
    template <class T>
    void run(const char* name, size_t count, const T& argument) {
        T copy = argument;
        runWith(name, count, &copy);
    }

private:
    void runWith(const char* name, size_t count, void* argument);
    CUmodule module_ = nullptr;
};

// A kind of a set whose programs are of the class T; the tolerances are those of JobKind.
template <class T>
JobKind applicationJob(const char* set, const char* name, const char* summary, double meanTolerance,
                       double pixelTolerance) {
    JobKind kind = {name, summary, nullptr, meanTolerance, pixelTolerance};
    kind.set = set;
    kind.start = [](OptixDeviceContext context,
                    const JobSettings& settings) -> std::unique_ptr<Application> {
        return std::make_unique<T>(context, settings);
    };
    return kind;
}
template <class T>
JobKind secondJob(const char* name, const char* summary, double meanTolerance,
                  double pixelTolerance) {
    return applicationJob<T>("second", name, summary, meanTolerance, pixelTolerance);
}

Camera cameraOf(const Mesh& mesh, const JobSettings& settings);
float3 vertexOf(const Mesh& mesh, size_t triangle, unsigned corner);

} // namespace bench
