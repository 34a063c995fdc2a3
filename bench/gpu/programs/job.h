// SPDX-License-Identifier: Apache-2.0
// A whole program of bench_programs: its pipeline, its scene and its frame. The makers in
// paths.cpp, surfaces.cpp and so on build one from scratch; run.cpp measures it. The programs of
// the further sets (second/kit.h) are Applications.
#pragma once

#include "device/shared.h"
#include "optix_setup.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace bench {

struct JobSettings {
    double scale = 1; // of the number of primitives, launches and builds
    unsigned width = 1920, height = 1080;

    unsigned some(double count, unsigned least) const {
        const double scaled = count * scale;
        return scaled < least ? least : unsigned(scaled);
    }
    float aspect() const { return float(width) / float(height); }
};

// Functions may be null; `builtin`: an OptixPrimitiveType that OptiX intersects, or 0.
struct HitGroup {
    const char* closestHit = nullptr;
    const char* anyHit = nullptr;
    const char* intersection = nullptr;
    unsigned builtin = 0;
    unsigned payloadType = 0; // for a group without programs: index + 1
};

struct HitRecord {
    unsigned group;
    Look material;
};

class Texture {
public:
    // Four bytes a texel; repeats, filters.
    Texture(const std::vector<unsigned char>& texels, unsigned side);
    Texture(Texture&& other) noexcept;
    Texture& operator=(Texture&&) = delete;
    ~Texture();
    cudaTextureObject_t object() const { return object_; }

private:
    cudaArray_t array_ = nullptr;
    cudaTextureObject_t object_ = 0;
};

struct Job {
    // The parts of the pipeline.
    std::string_view ptx;
    unsigned payloadValues = 3, attributeValues = 2;
    unsigned primitives = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE);
    unsigned graph = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS;
    unsigned traceDepth = 1, graphDepth = 1;
    bool moves = false, micromaps = false;
    std::vector<std::vector<unsigned>> payloadTypes; // semantics of each word
    const char* raygen = nullptr;
    std::vector<const char*> misses;
    std::vector<HitGroup> hits;
    std::vector<std::string> callables;
    std::vector<std::string> closestHits; // names of numbered programs in `hits`
    std::vector<HitRecord> records;

    // A frame: `prepare`, then launches for one tile after the other.
    ProgramParams params = {};
    unsigned launchWidth = 0, launchHeight = 0, launches = 1, tiles = 1;
    std::function<void(Job&)> prepare;
    unsigned frame = 0; // counts

    // The memory of the scene.
    std::vector<DeviceBuffer> buffers;
    std::vector<Accel> structures;
    std::vector<Texture> textures;
    DeviceBuffer image, extra;

    template <class T>
    const T* upload(const std::vector<T>& data) {
        buffers.emplace_back();
        buffers.back().upload(data);
        return buffers.back().as<T>();
    }
    // A picture of the settings' size, a launch index for each pixel.
    void allocatePicture(unsigned width, unsigned height);
};

// A program whose structures exist. Its destructor runs before the context ends.
class Application {
public:
    Application() = default;
    Application(const Application&) = delete;
    Application& operator=(const Application&) = delete;
    virtual ~Application() = default;

    // PTX to pipelines with their tables.
    virtual void compile() = 0;
    // Milliseconds from the text to the stack sizes.
    virtual double compileTime() const = 0;
    // Queues or does the work of a frame; the caller synchronises.
    virtual void renderFrame() = 0;
    // Four floats for each pixel or result; comparisons leave the fourth out.
    virtual std::vector<float> picture() = 0;
};

struct JobKind {
    const char* name;
    const char* summary;
    Job (*make)(OptixDeviceContext, const JobSettings&); // of the first set
    // Tolerances of pictures, relative to the mean: the difference of the means, and the mean
    // difference of pixels. Paths that diverge by rounding make pixels differ, but hardly the
    // means.
    double meanTolerance, pixelTolerance;
    // Of the other sets, in place of `make`.
    std::unique_ptr<Application> (*start)(OptixDeviceContext, const JobSettings&) = nullptr;
    const char* set = "first";
};
// All, in the order of the report.
const std::vector<JobKind>& jobKinds();

std::vector<JobKind> pathJobs();
std::vector<JobKind> surfaceJobs();
std::vector<JobKind> leafJobs();
std::vector<JobKind> motionJobs();
std::vector<JobKind> outdoorJobs();
std::vector<JobKind> shapeJobs();
std::vector<JobKind> listJobs();
std::vector<JobKind> buildJobs();
// The second set; second/list.cpp.
std::vector<JobKind> secondJobs();
// The third set; third/list.cpp.
std::vector<JobKind> thirdJobs();
// The fourth set; fourth/list.cpp.
std::vector<JobKind> fourthJobs();
// The fifth set; fifth/list.cpp.
std::vector<JobKind> fifthJobs();

// The pipeline of a job, with its shader binding table.
class JobPipeline {
public:
    JobPipeline(OptixDeviceContext context, const Job& job);
    JobPipeline(const JobPipeline&) = delete;
    JobPipeline& operator=(const JobPipeline&) = delete;
    ~JobPipeline();

    // Milliseconds from the text to the stack sizes.
    double compileTime() const { return compileTime_; }
    void launch(const ProgramParams& params, unsigned width, unsigned height);

private:
    void createModule(const Job& job);
    void createGroups(const Job& job);
    OptixProgramGroup add(const OptixProgramGroupDesc& description, unsigned payloadType = 0);
    OptixProgramGroup single(OptixProgramGroupKind kind, const char* function);
    OptixModule builtin(unsigned type);
    void link(const Job& job);
    void makeTable(const Job& job);

    OptixDeviceContext context_;
    OptixModuleCompileOptions moduleOptions_ = {};
    OptixPipelineCompileOptions options_ = {};
    std::vector<OptixPayloadType> payloadTypes_;
    OptixModule module_ = nullptr;
    OptixPipeline pipeline_ = nullptr;
    std::vector<OptixProgramGroup> groups_; // raygen, misses, hits, callables
    std::vector<OptixModule> builtins_;
    double compileTime_ = 0;
    DeviceBuffer raygen_, misses_, hits_, callables_, params_;
    OptixShaderBindingTable table_ = {};
};

} // namespace bench
