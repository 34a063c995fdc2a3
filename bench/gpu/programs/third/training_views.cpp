// SPDX-License-Identifier: Apache-2.0
// Pictures for machine learning: 64 cameras around a heap that each frame builds anew, in launches
// of 32 views on two streams; device/training_views.cu.
#include "programs.h"

#include "device/training_views.h"

std::string_view bench_third_training_views_ptx();

namespace bench {
namespace {

constexpr unsigned kStreams = 2, kAcross = 8, kViews = kAcross * kAcross;

class TrainingViews : public Renderer {
public:
    TrainingViews(OptixDeviceContext context, const JobSettings& settings)
        : Renderer(context, settings), world_(context, OPTIX_BUILD_FLAG_PREFER_FAST_BUILD) {
        const unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        const float2 bowl[] = {make_float2(0.01f, -0.5f), make_float2(0.7f, -0.3f),
                               make_float2(1, 0.4f),      make_float2(0.92f, 0.4f),
                               make_float2(0.6f, -0.2f),  make_float2(0.01f, -0.4f)};
        const Mesh shapes[kShapes] = {
            makeRock(settings.some(6000, 60)), makeBox(vec(-0.7f), vec(0.7f)),
            makeLathe({std::begin(bowl), std::end(bowl)}, settings.some(96, 12)),
            makeBox(vec(-60, -1, -60), vec(60, 0, 60))};
        for (unsigned i = 0; i < kShapes; ++i) {
            const MeshMemory memory = uploadMesh(scene_, shapes[i]);
            children_[i] = scene_.build(inputOf(memory, flags));
            records_[i] = {viewOf(memory)};
        }
        objects_.resize(settings.some(3000, 40) + 1);
        memory_.allocate(objects_.size() * sizeof(OptixInstance));
        std::vector<Camera> cameras;
        for (unsigned i = 0; i < kViews; ++i)
            cameras.push_back(lookAt(i, settings.aspect()));
        for (unsigned i = 0; i < kStreams; ++i) {
            CUDA_CHECK(cudaStreamCreateWithFlags(&streams_[i], cudaStreamNonBlocking));
            ViewParams& p = launches_[i].params;
            p.cameras = scene_.upload(cameras);
            p.firstView = i * (kViews / kStreams);
            p.viewWidth = std::max(1u, width_ / kAcross);
            p.viewHeight = std::max(1u, height_ / kAcross);
            p.across = kAcross;
            p.sun = normalize(vec(0.4f, 0.9f, -0.3f));
            p.depths = scene_.allocate<float>(size_t(p.viewWidth) * p.viewHeight * kViews);
            p.labels = scene_.allocate<unsigned>(size_t(p.viewWidth) * p.viewHeight * kViews);
        }
        const ViewParams& p = launches_[0].params;
        launches_[1].params.image = launches_[0].params.image =
            allocatePicture(p.viewWidth * kAcross, p.viewHeight * kAcross);
        CUDA_CHECK(cudaEventCreateWithFlags(&built_, cudaEventDisableTiming));
    }
    ~TrainingViews() override {
        for (cudaStream_t stream : streams_)
            cudaStreamDestroy(stream);
        cudaEventDestroy(built_);
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_LEVEL_INSTANCING |
                                  OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS;
        o.numPayloadValues = 5;
        const OptixModule module = programs_.load(bench_third_training_views_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__rg"});
        const auto miss = programs_.miss({module, "__miss__ms"});
        const auto hit = programs_.hit({{module, "__closesthit__ch"}, {}, {}});
        pipeline_ = programs_.link({raygen, miss, hit}, {.trace = 1, .graph = 2});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(miss)});
        std::vector<SbtRecord<ViewRecord>> records;
        for (const ViewRecord& r : records_)
            records.push_back(makeRecord(hit, r));
        table_.setHits(records);
    }
    // The two streams wait for the structure; the next frame waits for them.
    void renderFrame() override {
        drop(0.05f * float(frame_++ % 4));
        CUDA_CHECK(cudaMemcpyAsync(memory_.data(), objects_.data(), memory_.size(),
                                   cudaMemcpyHostToDevice, nullptr));
        world_.build(inputOfInstances(memory_.address(), objects_.size()),
                     OPTIX_BUILD_OPERATION_BUILD);
        CUDA_CHECK(cudaEventRecord(built_, nullptr));
        for (unsigned i = 0; i < kStreams; ++i) {
            CUDA_CHECK(cudaStreamWaitEvent(streams_[i], built_, 0));
            ViewParams& p = launches_[i].params;
            p.world = world_.handle();
            launches_[i].run(pipeline_, table_, p.viewWidth, p.viewHeight, kViews / kStreams,
                             streams_[i]);
        }
        for (cudaStream_t stream : streams_)
            CUDA_CHECK(cudaStreamSynchronize(stream));
    }

private:
    static constexpr unsigned kShapes = 4;

    static Camera lookAt(unsigned view, float aspect) {
        const float2 c = circlePoint(randomOf(view, 0));
        const float r = 9 + 9 * randomOf(view, 1);
        return makeCamera(vec(r * c.x, 4 + 7 * randomOf(view, 2), r * c.y),
                          vec(2 * randomOf(view, 3) - 1, 1, 2 * randomOf(view, 4) - 1),
                          vec(0, 1, 0), 35 + 20 * randomOf(view, 5), aspect);
    }
    // Objects in a heap, which turn as they fall.
    void drop(float time) {
        objects_[0] = instanceOf(children_[3], kIdentity, 0, 3);
        for (unsigned i = 1; i < objects_.size(); ++i) {
            const float2 c = circlePoint(randomOf(i, 0));
            const float r = 6 * std::sqrt(randomOf(i, 1)), height = 4 * std::exp(-0.08f * r * r);
            const float y = 0.3f + height * std::max(0.0f, randomOf(i, 2) - time);
            const Placement to = placed(vec(r * c.x, y, r * c.y), 0.25f + 0.25f * randomOf(i, 3),
                                        randomOf(i, 4) + time);
            objects_[i] = instanceOf(children_[i % 3], to.matrix, i, i % 3);
        }
    }

    Launch<ViewParams> launches_[kStreams];
    LiveStructure world_;
    OptixTraversableHandle children_[kShapes] = {};
    ViewRecord records_[kShapes] = {};
    std::vector<OptixInstance> objects_;
    DeviceBuffer memory_;
    cudaStream_t streams_[kStreams] = {};
    cudaEvent_t built_ = nullptr;
    unsigned frame_ = 0;
};

} // namespace

JobKind trainingViewsJob() {
    return thirdJob<TrainingViews>(
        "training_views", "64 views of a new structure in launches of 32 views on two streams",
        0.002, 0.02);
}

} // namespace bench
