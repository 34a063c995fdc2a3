// SPDX-License-Identifier: Apache-2.0
// Range and point queries on an index of four million keys; device/key_queries.cu.
#include "programs.h"

#include "device/key_queries.h"
#include "sampling.h"

std::string_view bench_second_key_queries_ptx();

namespace bench {
namespace {

class KeyQueries : public Application {
public:
    KeyQueries(OptixDeviceContext context, const JobSettings& settings)
        : scene_(context), programs_(context), count_(settings.some(1.5e6, 300)) {
        const unsigned numKeys = settings.some(4e6, 2000), keySpace = 4 * numKeys;
        std::vector<unsigned> rows(numKeys);
        addKeys(numKeys, keySpace, rows);
        for (Launch<KeyParams>* launch : {&ranges_, &points_}) {
            launch->params.index = index_;
            launch->params.rows = rowMemory_;
            launch->params.numQueries = count_;
        }
        answers_.allocate(2 * sizeof(float4) * count_);
        ranges_.params.answers = answers_.as<float4>();
        points_.params.answers = answers_.as<float4>() + count_;
        std::vector<KeyRange> ranges(count_), points(count_);
        for (unsigned i = 0; i < count_; ++i) {
            const unsigned first = hashPcg(i + 77) % keySpace;
            ranges[i] = {first, std::min(first + hashPcg(i + 78) % 200, keySpace - 1)};
            points[i] = {hashPcg(i + 79) % keySpace, 0};
        }
        ranges_.params.queries = scene_.upload(ranges);
        points_.params.queries = scene_.upload(points);
    }
    void compile() override {
        programs_.options.numPayloadValues = 4;
        const OptixModule module = programs_.load(bench_second_key_queries_ptx());
        const auto range = programs_.raygen({module, "__raygen__lookup"});
        const auto point = programs_.raygen({module, "__raygen__exists"});
        const auto miss = programs_.miss({module, "__miss__nothing"});
        const auto hit = programs_.hit({{}, {module, "__anyhit__match"}, {}});
        pipeline_ = programs_.link({range, point, miss, hit}, {});
        rangeTable_.setRaygen(makeRecord(range));
        pointTable_.setRaygen(makeRecord(point));
        for (Table* table : {&rangeTable_, &pointTable_}) {
            table->setMisses(std::vector{makeRecord(miss)});
            table->setHits(std::vector{makeRecord(hit)});
        }
    }
    double compileTime() const override { return programs_.compileTime(); }
    void renderFrame() override {
        ranges_.run(pipeline_, rangeTable_, count_);
        points_.run(pipeline_, pointTable_, count_);
    }
    std::vector<float> picture() override { return answers_.download<float>(); }

private:
    // Triangles that rays along x and along z meet in their middles.
    void addKeys(unsigned numKeys, unsigned keySpace, std::vector<unsigned>& rows) {
        Mesh mesh;
        mesh.vertices.reserve(9 * size_t(numKeys));
        for (unsigned i = 0; i < numKeys; ++i) {
            const float3 p = placeOfKey(hashPcg(i) % keySpace);
            rows[i] = hashPcg(i + 5) % numKeys;
            for (const float3 v : {p + vec(0.4f, -0.1f, -0.3f), p + vec(-0.3f, 0.4f, -0.1f),
                                   p + vec(-0.1f, -0.3f, 0.4f)})
                mesh.vertices.insert(mesh.vertices.end(), {v.x, v.y, v.z});
        }
        // Without indices, as the triangles share no vertices.
        const CUdeviceptr vertices = reinterpret_cast<CUdeviceptr>(scene_.upload(mesh.vertices));
        const unsigned flags = OPTIX_GEOMETRY_FLAG_REQUIRE_SINGLE_ANYHIT_CALL;
        OptixBuildInput input = {};
        input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
        input.triangleArray.vertexBuffers = &vertices;
        input.triangleArray.numVertices = 3 * numKeys;
        input.triangleArray.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
        input.triangleArray.flags = &flags;
        input.triangleArray.numSbtRecords = 1;
        index_ = scene_.build(input);
        rowMemory_ = scene_.upload(rows);
    }

    Scene scene_;
    Programs programs_;
    Table rangeTable_, pointTable_;
    Launch<KeyParams> ranges_, points_;
    OptixPipeline pipeline_ = nullptr;
    OptixTraversableHandle index_ = 0;
    const unsigned* rowMemory_ = nullptr;
    DeviceBuffer answers_;
    unsigned count_;
};

} // namespace

JobKind keyQueriesJob() {
    return secondJob<KeyQueries>("key_queries",
                                 "a database index: rays along keys, any-hit programs that count",
                                 1e-5, 1e-4);
}

} // namespace bench
