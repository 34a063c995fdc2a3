// SPDX-License-Identifier: Apache-2.0
// A command list: a launch that traces few paths, the denoiser with its guides, the predictor of
// noise, and the tone mapper for the picture before and after. The left half of the PNG is noisy,
// the right half denoised.
#include "png_image.h"
#include "shapes6.h"

#include <algorithm>
#include <cstdio>
#include <string_view>

std::string_view post_processing_ptx(); // the PTX of post_processing.cu, built into this program

namespace {

using namespace optix;

enum RayType { kPathRay, kShadowRay, kRayTypes };

class Renderer {
public:
    explicit Renderer(const ClassicPicture& picture)
        : picture_(picture), context_(Context::create()), top_(context_->createGeometryGroup()) {
        context_->setRayTypeCount(kRayTypes);
        context_->setEntryPointCount(1);
        context_->setRayGenerationProgram(0, program("trace_paths"));
        context_->setMissProgram(kPathRay, program("miss"));
        context_["scene_epsilon"]->setFloat(1e-3f);
        top_->setAcceleration(context_->createAcceleration("Trbvh"));
        context_["top_object"]->set(top_);
        surface_ = material("hit_diffuse", "block_light");
        setCamera(context_, makeCamera(make_float3(0.0f, 0.0f, 3.9f), make_float3(0.0f), 40.0f,
                                       picture.aspect()));
        addBox();
        addSpheres();
    }
    ~Renderer() { context_->destroy(); }
    Renderer(const Renderer&) = delete;

    void render(unsigned samples, unsigned depth, float exposure) {
        context_["samples"]->setUint(samples);
        context_["max_depth"]->setUint(depth);
        Buffer noisy = buffer(), albedo = buffer(), normal = buffer(), denoised = buffer(),
               before = buffer(), after = buffer();
        Buffer similarity =
            context_->createBuffer(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT3, (picture_.width + 15) / 16,
                                   (picture_.height + 15) / 16);
        context_["noisy"]->set(noisy);
        context_["albedo_guide"]->set(albedo);
        context_["normal_guide"]->set(normal);

        CommandList commands = context_->createCommandList();
        const auto append = [&](PostprocessingStage stage) {
            commands->appendPostprocessingStage(stage, picture_.width, picture_.height);
        };
        commands->appendLaunch(0, picture_.width, picture_.height);
        append(guided("DLDenoiser", noisy, denoised, albedo, normal));
        append(guided("DLSSIMPredictor", noisy, similarity, albedo, normal));
        append(toneMapper(noisy, before, exposure));
        append(toneMapper(denoised, after, exposure));
        commands->finalize();
        commands->execute();
        commands->destroy();
        printMean(similarity);
        write(before, after);
    }

private:
    Program program(const char* name) {
        return context_->createProgramFromPTXString(std::string(post_processing_ptx()), name);
    }
    Material material(const char* hit, const char* shadow) {
        Material made = context_->createMaterial();
        made->setClosestHitProgram(kPathRay, program(hit));
        if (shadow)
            made->setAnyHitProgram(kShadowRay, program(shadow));
        return made;
    }
    Buffer buffer() {
        return context_->createBuffer(RT_BUFFER_INPUT_OUTPUT, RT_FORMAT_FLOAT4, picture_.width,
                                      picture_.height);
    }
    void add(Geometry geometry, float3 albedo, float checks = 0.0f) {
        GeometryInstance instance = context_->createGeometryInstance();
        instance->setGeometry(geometry);
        instance->addMaterial(surface_);
        instance["albedo"]->setFloat(albedo);
        instance["checks"]->setFloat(checks);
        top_->addChild(instance);
    }

    // A box from -1 to 1, open to the eye, with a light below its ceiling.
    void addBox() {
        const float3 white = make_float3(0.75f), x = make_float3(2.0f, 0.0f, 0.0f),
                     y = make_float3(0.0f, 2.0f, 0.0f), z = make_float3(0.0f, 0.0f, 2.0f),
                     low = make_float3(-1.0f), high = make_float3(1.0f);
        add(makeParallelogram(context_, low, z, x), white, 10.0f);
        add(makeParallelogram(context_, high, -x, -z), white);
        add(makeParallelogram(context_, low, x, y), white);
        add(makeParallelogram(context_, low, y, z), make_float3(0.6f, 0.13f, 0.08f));
        add(makeParallelogram(context_, high, -y, -z), make_float3(0.1f, 0.28f, 0.55f));
        const float3 anchor = make_float3(-0.3f, 0.99f, -0.3f),
                     edge1 = make_float3(0.6f, 0.0f, 0.0f), edge2 = make_float3(0.0f, 0.0f, 0.6f);
        context_["light_anchor"]->setFloat(anchor);
        context_["light_edge1"]->setFloat(edge1);
        context_["light_edge2"]->setFloat(edge2);
        context_["emission"]->setFloat(make_float3(14.0f, 12.0f, 9.5f));
        GeometryInstance light = context_->createGeometryInstance();
        light->setGeometry(makeParallelogram(context_, anchor, edge1, edge2));
        light->addMaterial(material("hit_light", nullptr));
        top_->addChild(light);
    }
    void addSpheres() {
        add(makeSphere(context_, make_float3(-0.45f, -0.58f, -0.1f), 0.42f),
            make_float3(0.8f, 0.65f, 0.2f));
        add(makeSphere(context_, make_float3(0.42f, -0.68f, 0.35f), 0.32f),
            make_float3(0.3f, 0.6f, 0.35f), 16.0f);
        add(makeSphere(context_, make_float3(0.35f, -0.05f, -0.5f), 0.35f), make_float3(0.7f));
    }

    // A stage that takes guides, for colours without a limit.
    PostprocessingStage guided(const char* name, Buffer input, Buffer output, Buffer albedo,
                               Buffer normal) {
        PostprocessingStage made = context_->createBuiltinPostProcessingStage(name);
        made->declareVariable("input_buffer")->set(input);
        made->declareVariable("output_buffer")->set(output);
        made->declareVariable("input_albedo_buffer")->set(albedo);
        made->declareVariable("input_normal_buffer")->set(normal);
        made->declareVariable("hdr")->setUint(1);
        return made;
    }
    PostprocessingStage toneMapper(Buffer input, Buffer output, float exposure) {
        PostprocessingStage made = context_->createBuiltinPostProcessingStage("TonemapperSimple");
        made->declareVariable("input_buffer")->set(input);
        made->declareVariable("output_buffer")->set(output);
        made->declareVariable("exposure")->setFloat(exposure);
        made->declareVariable("gamma")->setFloat(2.2f);
        return made;
    }

    void printMean(Buffer similarity) {
        RTsize width = 0, height = 0;
        similarity->getSize(width, height);
        const float* blocks = static_cast<const float*>(similarity->map(0, RT_BUFFER_MAP_READ));
        double sum = 0.0;
        for (RTsize i = 0; i < width * height; ++i)
            sum += blocks[3 * i];
        similarity->unmap();
        std::printf("similarity to a picture without noise, predicted: %.2f\n",
                    sum / double(width * height));
    }
    // The tone mapper's values are screen values.
    void write(Buffer before, Buffer after) {
        std::vector<uint8_t> bytes;
        const float* left = static_cast<const float*>(before->map(0, RT_BUFFER_MAP_READ));
        const float* right = static_cast<const float*>(after->map(0, RT_BUFFER_MAP_READ));
        for (size_t i = 0; i < size_t(picture_.width) * picture_.height; ++i) {
            const float* pixel = i % picture_.width < picture_.width / 2 ? left : right;
            for (size_t c = 0; c < 3; ++c)
                bytes.push_back(uint8_t(pixel[4 * i + c] * 255.0f + 0.5f));
            bytes.push_back(255);
        }
        before->unmap();
        after->unmap();
        writePng(picture_.output, picture_.width, picture_.height, bytes);
        std::printf("wrote %s\n", picture_.output.c_str());
    }

    ClassicPicture picture_;
    Context context_;
    GeometryGroup top_;
    Material surface_;
};

} // namespace

int main(int argc, char** argv) {
    ClassicPicture picture = {"post_processing.png", 512, 512};
    unsigned samples = 8, depth = 5, exposure = 100;
    Arguments arguments("A command list with a launch, the denoiser and the tone mapper.");
    addOptions(arguments, picture);
    arguments.add("--samples", samples, 1, 65536, "paths for each pixel");
    arguments.add("--depth", depth, 1, 64, "segments of a path");
    arguments.add("--exposure", exposure, 1, 100000, "percent");
    return runClassicSample("post_processing", arguments, argc, argv, [&] {
        Renderer(picture).render(samples, depth, float(exposure) / 100.0f);
    });
}
