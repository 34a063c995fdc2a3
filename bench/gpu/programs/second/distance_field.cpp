// SPDX-License-Identifier: Apache-2.0
// Fractals and other distance fields; device/distance_field.cu.
#include "programs.h"

#include "device/distance_field.h"

std::string_view bench_second_distance_field_ptx();

namespace bench {
namespace {

std::vector<Field> makeFields(unsigned across) {
    std::vector<Field> fields;
    const float step = 8.0f / float(across);
    for (unsigned i = 0; i < across * across; ++i) {
        const float x = (float(i % across) + 0.5f) * step - 4,
                    z = (float(i / across) + 0.5f) * step;
        const float r = step * (0.3f + 0.19f * randomOf(i, 1));
        const unsigned kind = i % 3;
        const float parameter = kind == kBulb ? 5 + float(i % 4) : 7 + 4 * randomOf(i, 2);
        fields.push_back({vec(x, r, z - 4), r, kind, parameter, colorOf(i)});
    }
    fields.push_back({vec(0, 5.3f, 0), 5.5f, kRipples, 0, vec(0.55f, 0.5f, 0.45f)});
    return fields;
}

class DistanceField : public Application {
public:
    DistanceField(OptixDeviceContext context, const JobSettings& settings)
        : scene_(context), programs_(context) {
        const std::vector<Field> fields = makeFields(settings.scale < 0.1 ? 3 : 8);
        std::vector<OptixAabb> boxes;
        for (const Field& f : fields) {
            const float r = f.radius, top = f.kind == kRipples ? -5.2f : r; // ripples are flat
            boxes.push_back({f.center.x - r, f.center.y - r, f.center.z - r, f.center.x + r,
                             f.center.y + top, f.center.z + r});
        }
        fields_ = scene_.upload(fields);
        FieldParams& p = launch_.params;
        p.root = scene_.buildBoxes(boxes, OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT);
        p.width = settings.width;
        p.height = settings.height;
        p.camera = makeCamera(vec(-2.6f, 2.4f, -4.6f), vec(0, 0.3f, 0), vec(0, 1, 0), 50,
                              settings.aspect());
        p.sun = normalize(vec(-0.6f, 0.7f, -0.3f));
        image_.allocate(sizeof(float4) * p.width * p.height);
        p.frame = image_.as<float4>();
    }
    void compile() override {
        programs_.options.usesPrimitiveTypeFlags = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM);
        const OptixModule module = programs_.load(bench_second_distance_field_ptx());
        const Function intersection = {module, "__intersection__field"};
        const auto raygen = programs_.raygen({module, "__raygen__field"});
        const auto viewMiss = programs_.miss({module, "__miss__view"});
        const auto occlusionMiss = programs_.miss({module, "__miss__occlusion"});
        const auto view = programs_.hit({{module, "__closesthit__field"}, {}, intersection});
        const auto occlusion = programs_.hit({{}, {}, intersection});
        pipeline_ =
            programs_.link({raygen, viewMiss, occlusionMiss, view, occlusion}, {.trace = 2});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(viewMiss), makeRecord(occlusionMiss)});
        const FieldRecord data = {fields_, 4e-4f};
        table_.setHits(std::vector{makeRecord(view, data), makeRecord(occlusion, data)});
    }
    double compileTime() const override { return programs_.compileTime(); }
    void renderFrame() override {
        launch_.run(pipeline_, table_, launch_.params.width, launch_.params.height);
    }
    std::vector<float> picture() override { return image_.download<float>(); }

private:
    Scene scene_;
    Programs programs_;
    Table table_;
    Launch<FieldParams> launch_;
    OptixPipeline pipeline_ = nullptr;
    const Field* fields_ = nullptr;
    DeviceBuffer image_;
};

} // namespace

JobKind distanceFieldJob() {
    return secondJob<DistanceField>(
        "distance_field", "intersection programs that step through distance fields", 0.002, 0.02);
}

} // namespace bench
