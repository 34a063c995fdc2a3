// SPDX-License-Identifier: Apache-2.0
// Cloth simulation: each frame the vertices move. One cloth is built and compacted anew, one is
// refitted in place, one is refitted from one buffer into another. The launch parameters lead to a
// struct of arrays.
#include "common.h"

#include <optix_function_table_definition.h>

#include <algorithm>
#include <cmath>

#include "device/refit_frames.h"

namespace {

constexpr unsigned kSide = 24, kFrames = 12;

float heightOf(int cloth, int frame, float x, float y) {
    return 0.3f * std::sin(5 * x + 0.4f * frame + cloth) * std::cos(3 * y - 0.2f * frame);
}

std::vector<uint3> gridTriangles() {
    std::vector<uint3> triangles;
    for (unsigned y = 0; y + 1 < kSide; ++y)
        for (unsigned x = 0; x + 1 < kSide; ++x) {
            const unsigned a = y * kSide + x;
            triangles.push_back({a, a + 1, a + kSide});
            triangles.push_back({a + kSide, a + 1, a + kSide + 1});
        }
    return triangles;
}

class DynamicMesh {
public:
    enum class Mode { kRebuild, kInPlace, kPingPong };
    DynamicMesh(OptixDeviceContext context, int number, Mode mode, CUdeviceptr triangles,
                unsigned count)
        : context_(context), number_(number), mode_(mode),
          vertices_(kSide * kSide * sizeof(float3)) {
        address_ = vertices_.ptr();
        input_.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
        auto& array = input_.triangleArray;
        array.vertexBuffers = &address_;
        array.numVertices = kSide * kSide;
        array.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
        array.vertexStrideInBytes = sizeof(float3);
        array.indexBuffer = triangles;
        array.numIndexTriplets = count;
        array.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
        array.indexStrideInBytes = sizeof(uint3);
        array.flags = &flag_;
        array.numSbtRecords = 1;
    }

    void step(int frame, cudaStream_t stream) {
        std::vector<float3> corners;
        for (unsigned i = 0; i < kSide * kSide; ++i) {
            const float x = float(i % kSide) / (kSide - 1), y = float(i / kSide) / (kSide - 1);
            corners.push_back({x, y, heightOf(number_, frame, x, y)});
        }
        vertices_.upload(corners.data(), corners.size() * sizeof(float3));
        OptixAccelBuildOptions options = {};
        options.buildFlags =
            OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS | OPTIX_BUILD_FLAG_ALLOW_COMPACTION;
        if (mode_ != Mode::kRebuild)
            options.buildFlags |= OPTIX_BUILD_FLAG_ALLOW_UPDATE;
        const bool updates = mode_ != Mode::kRebuild && handle_ != 0;
        options.operation = updates ? OPTIX_BUILD_OPERATION_UPDATE : OPTIX_BUILD_OPERATION_BUILD;
        updates ? update(options, stream) : build(options, stream);
    }

    OptixTraversableHandle handle() const { return handle_; }
    const float3* corners() const { return vertices_.as<float3>(); }
    size_t bytes() const { return current_.size; }
    size_t built() const { return built_; }

private:
    void build(const OptixAccelBuildOptions& options, cudaStream_t stream) {
        OptixAccelBufferSizes sizes = {};
        OPTIX_TRY(optixAccelComputeMemoryUsage(context_, &options, &input_, 1, &sizes));
        built_ = sizes.outputSizeInBytes;
        temporary_.resize(std::max(sizes.tempSizeInBytes, sizes.tempUpdateSizeInBytes));
        Buffer full(sizes.outputSizeInBytes), size(8);
        const OptixAccelEmitDesc emit = {size.ptr(), OPTIX_PROPERTY_TYPE_COMPACTED_SIZE};
        OptixTraversableHandle wide = 0;
        OPTIX_TRY(optixAccelBuild(context_, stream, &options, &input_, 1, temporary_.ptr(),
                                  temporary_.size, full.ptr(), full.size, &wide, &emit, 1));
        size_t compacted = 0;
        CUDA_TRY(cudaMemcpyAsync(&compacted, size.data, 8, cudaMemcpyDeviceToHost, stream));
        CUDA_TRY(cudaStreamSynchronize(stream));
        Buffer small(compacted);
        OPTIX_TRY(optixAccelCompact(context_, stream, wide, small.ptr(), compacted, &handle_));
        CUDA_TRY(cudaStreamSynchronize(stream));
        current_ = std::move(small);
    }
    void update(const OptixAccelBuildOptions& options, cudaStream_t stream) {
        if (mode_ == Mode::kPingPong) { // the copy is refitted, the old one freed afterwards
            Buffer next(current_.size);
            OptixTraversableHandle moved = 0;
            OptixAccelRelocationInfo info = {};
            OPTIX_TRY(optixAccelGetRelocationInfo(context_, handle_, &info));
            CUDA_TRY(cudaMemcpyAsync(next.data, current_.data, current_.size,
                                     cudaMemcpyDeviceToDevice, stream));
            OPTIX_TRY(
                optixAccelRelocate(context_, stream, &info, 0, 0, next.ptr(), next.size, &moved));
            CUDA_TRY(cudaStreamSynchronize(stream));
            current_ = std::move(next);
            handle_ = moved;
        }
        OPTIX_TRY(optixAccelBuild(context_, stream, &options, &input_, 1, temporary_.ptr(),
                                  temporary_.size, current_.ptr(), current_.size, &handle_, nullptr,
                                  0));
    }

    OptixDeviceContext context_;
    const int number_;
    const Mode mode_;
    const unsigned flag_ = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
    Buffer vertices_, current_, temporary_;
    CUdeviceptr address_ = 0;
    OptixBuildInput input_ = {};
    OptixTraversableHandle handle_ = 0;
    size_t built_ = 0;
};

unsigned wrongProbes(const Params& state, int frame) {
    unsigned wrong = 0;
    for (int c = 0; c < kCloths; ++c)
        for (int i = 0; i < kProbes; ++i) {
            const float x = (i % 16 + 0.53f) / 16, y = (i / 16 + 0.47f) / 16;
            const float seen = state.heights[0][c][i] - state.cloths[c].tint[frame & 1];
            wrong += std::fabs(seen - heightOf(c, frame, x, y)) > 0.01f;
            wrong += std::fabs(seen - state.heights[1][c][i]) > 1e-4f;
        }
    return wrong;
}

bool run() {
    OptixDeviceContext context = makeContext();
    auto options = pipelineOptions(2, 2, OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS);
    OptixModule module = makeModule(context, options);
    const std::vector<OptixProgramGroup> groups = {
        raygenGroup(context, module, "__raygen__probe"),
        missGroup(context, module, "__miss__probe"),
        hitGroup(context, module, "__closesthit__probe", nullptr, nullptr)};
    OptixPipeline pipeline = makePipeline(context, options, groups);
    Buffer table(std::vector<Record<Nothing>>{
        packed(groups[0], Nothing()), packed(groups[1], Nothing()), packed(groups[2], Nothing())});
    OptixShaderBindingTable sbt = {};
    constexpr unsigned kStride = sizeof(Record<Nothing>);
    sbt.raygenRecord = table.ptr();
    sbt.missRecordBase = table.ptr() + kStride;
    sbt.hitgroupRecordBase = table.ptr() + 2 * kStride;
    sbt.missRecordStrideInBytes = sbt.hitgroupRecordStrideInBytes = kStride;
    sbt.missRecordCount = sbt.hitgroupRecordCount = 1;

    const std::vector<uint3> triangles = gridTriangles();
    Buffer indices(triangles), state(sizeof(Params));
    using Mode = DynamicMesh::Mode;
    std::vector<DynamicMesh> meshes;
    meshes.reserve(kCloths);
    for (const Mode mode : {Mode::kRebuild, Mode::kInPlace, Mode::kPingPong})
        meshes.emplace_back(context, int(meshes.size()), mode, indices.ptr(),
                            unsigned(triangles.size()));
    struct {
        void* state;
        unsigned long long cookie;
    } launch = {state.data, 0x1234};
    Buffer launchBuffer(sizeof launch);
    launchBuffer.upload(&launch, sizeof launch);
    cudaStream_t stream = nullptr;
    CUDA_TRY(cudaStreamCreate(&stream));
    unsigned wrong = 0;
    for (int frame = 0; frame < int(kFrames); ++frame) {
        Params params = {};
        params.frame = frame;
        for (int c = 0; c < kCloths; ++c) {
            meshes[c].step(frame, stream);
            params.cloths[c] = {
                meshes[c].handle(), meshes[c].corners(), indices.as<uint3>(), {1.0f + c, 2.0f + c}};
        }
        CUDA_TRY(
            cudaMemcpyAsync(state.data, &params, sizeof params, cudaMemcpyHostToDevice, stream));
        OPTIX_TRY(optixLaunch(pipeline, stream, launchBuffer.ptr(), sizeof launch, &sbt, kProbes,
                              kCloths, 1));
        CUDA_TRY(
            cudaMemcpyAsync(&params, state.data, sizeof params, cudaMemcpyDeviceToHost, stream));
        CUDA_TRY(cudaStreamSynchronize(stream));
        wrong += wrongProbes(params, frame);
    }
    std::printf("%u wrong; compacted to %s\n", wrong,
                meshes[0].bytes() < meshes[0].built() ? "less" : "the same");
    CUDA_TRY(cudaStreamDestroy(stream));
    meshes.clear();
    OPTIX_TRY(optixDeviceContextDestroy(context));
    return wrong == 0;
}

} // namespace

int main() {
    return runChecked(run);
}
