// SPDX-License-Identifier: Apache-2.0
// A rendering service: threads take requests from a queue, each has streams of its own, and all
// launch one pipeline with one shader binding table. A thread keeps several launches in flight, in
// pinned memory; events say when an answer may be read, and one stream waits for another's event.
#include "common.h"

#include <optix_function_table_definition.h>

#include <atomic>
#include <memory>
#include <thread>

#include "device/many_streams.h"

namespace {

constexpr unsigned kSide = 16, kThreads = 4, kStreams = 3, kRequests = 120;

struct Service {
    OptixPipeline pipeline = nullptr;
    OptixShaderBindingTable table = {};
    OptixTraversableHandle scene = 0;
    std::atomic<unsigned> next{0}, wrong{0};
};

// Quads on the squares whose coordinates have an even sum.
OptixTraversableHandle makeScene(OptixDeviceContext context, Buffer& memory) {
    std::vector<float2> corners; // two coordinates
    for (unsigned y = 0; y < kSide; ++y)
        for (unsigned x = y % 2; x < kSide; x += 2)
            for (const float2 c : {float2{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}})
                corners.push_back({x + c.x, y + c.y});
    Buffer buffer(corners);
    const CUdeviceptr address = buffer.ptr();
    const unsigned flags = OPTIX_GEOMETRY_FLAG_NONE;
    std::vector<OptixBuildInput> input(1);
    input[0].type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    input[0].triangleArray.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT2;
    input[0].triangleArray.vertexBuffers = &address;
    input[0].triangleArray.numVertices = unsigned(corners.size());
    input[0].triangleArray.flags = &flags;
    input[0].triangleArray.numSbtRecords = 1;
    return buildAccel(context, input, memory);
}

unsigned expected(unsigned x, unsigned y, unsigned request) {
    if ((x + y) % 2)
        return 7000000 + request;
    // Above the diagonal of its square lies the second triangle.
    const unsigned quad = y * (kSide / 2) + x / 2;
    return 1000 * (2 * quad + 1) + request;
}

class Lane {
public:
    explicit Lane(Service& service)
        : service_(service), image_(kSide * kSide * 4), params_(sizeof(Tile)) {
        CUDA_TRY(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking));
        CUDA_TRY(cudaStreamCreateWithFlags(&copies_, cudaStreamNonBlocking));
        CUDA_TRY(cudaEventCreateWithFlags(&rendered_, cudaEventDisableTiming));
        CUDA_TRY(
            cudaEventCreateWithFlags(&copied_, cudaEventDisableTiming | cudaEventBlockingSync));
        CUDA_TRY(cudaHostAlloc(reinterpret_cast<void**>(&answer_), kSide * kSide * 4,
                               cudaHostAllocDefault));
        CUDA_TRY(cudaHostAlloc(reinterpret_cast<void**>(&tile_), sizeof(Tile),
                               cudaHostAllocWriteCombined));
    }
    ~Lane() {
        cudaStreamDestroy(stream_);
        cudaStreamDestroy(copies_);
        cudaEventDestroy(rendered_);
        cudaEventDestroy(copied_);
        cudaFreeHost(answer_);
        cudaFreeHost(tile_);
    }
    void begin(unsigned request) {
        request_ = request;
        busy_ = true;
        *tile_ = {service_.scene, image_.as<unsigned>(), request, 0.3f};
        CUDA_TRY(
            cudaMemcpyAsync(params_.data, tile_, sizeof *tile_, cudaMemcpyHostToDevice, stream_));
        OPTIX_TRY(optixLaunch(service_.pipeline, stream_, params_.ptr(), sizeof(Tile),
                              &service_.table, kSide, kSide, 1));
        CUDA_TRY(cudaEventRecord(rendered_, stream_));
        CUDA_TRY(cudaStreamWaitEvent(copies_, rendered_, 0));
        CUDA_TRY(cudaMemcpyAsync(answer_, image_.data, kSide * kSide * 4, cudaMemcpyDeviceToHost,
                                 copies_));
        CUDA_TRY(cudaEventRecord(copied_, copies_));
    }
    void end() {
        if (!busy_)
            return;
        CUDA_TRY(cudaEventSynchronize(copied_));
        for (unsigned i = 0; i < kSide * kSide; ++i)
            service_.wrong += answer_[i] != expected(i % kSide, i / kSide, request_);
        busy_ = false;
    }

private:
    Service& service_;
    Buffer image_, params_;
    cudaStream_t stream_ = nullptr, copies_ = nullptr;
    cudaEvent_t rendered_ = nullptr, copied_ = nullptr;
    unsigned* answer_ = nullptr;
    Tile* tile_ = nullptr;
    unsigned request_ = 0;
    bool busy_ = false;
};

void work(Service& service) {
    CUDA_TRY(cudaSetDevice(0));
    std::vector<std::unique_ptr<Lane>> lanes;
    for (unsigned i = 0; i < kStreams; ++i)
        lanes.push_back(std::make_unique<Lane>(service));
    for (unsigned i = 0;; i = (i + 1) % kStreams) {
        const unsigned request = service.next++;
        if (request >= kRequests)
            break;
        lanes[i]->end();
        lanes[i]->begin(request);
    }
    for (auto& lane : lanes)
        lane->end();
}

bool run() {
    OptixDeviceContext context = makeContext();
    const auto options = pipelineOptions(1, 2, OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS);
    OptixModule module = makeModule(context, options);
    const std::vector<OptixProgramGroup> groups = {
        raygenGroup(context, module, "__raygen__tile"), missGroup(context, module, "__miss__tile"),
        hitGroup(context, module, "__closesthit__tile", nullptr, nullptr)};
    Service service;
    service.pipeline = makePipeline(context, options, groups);
    Buffer memory, table(std::vector<Record<Nothing>>{packed(groups[0], Nothing()),
                                                      packed(groups[1], Nothing()),
                                                      packed(groups[2], Nothing())});
    service.scene = makeScene(context, memory);
    constexpr unsigned kStride = sizeof(Record<Nothing>);
    service.table.raygenRecord = table.ptr();
    service.table.missRecordBase = table.ptr() + kStride;
    service.table.hitgroupRecordBase = table.ptr() + 2 * kStride;
    service.table.missRecordStrideInBytes = service.table.hitgroupRecordStrideInBytes = kStride;
    service.table.missRecordCount = service.table.hitgroupRecordCount = 1;
    std::vector<std::thread> threads;
    for (unsigned i = 0; i < kThreads; ++i)
        threads.emplace_back([&service] {
            try {
                work(service);
            } catch (const std::exception& error) {
                std::printf("%s\n", error.what());
                ++service.wrong;
            }
        });
    for (std::thread& thread : threads)
        thread.join();
    std::printf("%u values wrong\n", service.wrong.load());
    OPTIX_TRY(optixDeviceContextDestroy(context));
    return service.wrong == 0;
}

} // namespace

int main() {
    return runChecked(run);
}
