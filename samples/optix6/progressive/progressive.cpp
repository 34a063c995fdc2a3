// SPDX-License-Identifier: Apache-2.0
// Progressive rendering without a window: a buffer accumulates the sum of all launches, the program
// writes pictures at the frames 1, 2, 4, 8 and so on, and rendering ends after a number of frames
// or when the estimated error is small. With --stream 1 the library accumulates: a progressive
// launch runs in the background, and the program writes the pictures that arrive in a stream
// buffer.
#include "mesh.h"
#include "png_image.h"
#include "shapes6.h"

#include <optix_world.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <thread>

std::string_view progressive_ptx(); // the PTX of progressive.cu, built into this program

namespace {

using namespace optix;

enum RayType { kPathRay, kShadowRay, kRayTypes };
enum Entry { kAddPath, kOnePath, kEntries };

struct Options {
    unsigned frames = 64, depth = 5, errorPerMille = 0, intermediate = 0, stream = 0;
};

class Renderer {
public:
    explicit Renderer(const ClassicPicture& picture)
        : picture_(picture), context_(Context::create()), top_(context_->createGeometryGroup()) {
        context_->setRayTypeCount(kRayTypes);
        context_->setEntryPointCount(kEntries);
        context_->setRayGenerationProgram(kAddPath, program("add_path"));
        context_->setRayGenerationProgram(kOnePath, program("one_path"));
        for (unsigned entry = 0; entry < kEntries; ++entry)
            context_->setExceptionProgram(entry, program("show_exception"));
        context_->setMissProgram(kPathRay, program("miss"));
        material_ = context_->createMaterial();
        material_->setClosestHitProgram(kPathRay, program("hit"));
        material_->setAnyHitProgram(kShadowRay, program("block_light"));
        top_->setAcceleration(context_->createAcceleration("Trbvh"));
        context_["top_object"]->set(top_);
        // Only the device accesses the sum; the host reads the picture.
        const unsigned onDevice = unsigned(RT_BUFFER_INPUT_OUTPUT) | unsigned(RT_BUFFER_GPU_LOCAL);
        context_["sum"]->set(
            context_->createBuffer(onDevice, RT_FORMAT_FLOAT4, picture.width, picture.height));
        result_ = context_->createBuffer(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT4, picture.width,
                                         picture.height);
        context_["picture"]->set(result_);
        noise_ = context_->createBuffer(RT_BUFFER_INPUT_OUTPUT, RT_FORMAT_FLOAT, picture.height);
        context_["noise"]->set(noise_);
    }
    ~Renderer() { context_->destroy(); }
    Renderer(const Renderer&) = delete;

    void add(const PlainMesh& mesh, float3 albedo, float gloss) {
        Buffer triangles = makeBuffer(context_, RT_FORMAT_UNSIGNED_INT3, mesh.triangles);
        GeometryTriangles made = context_->createGeometryTriangles();
        made->setPrimitiveCount(unsigned(mesh.triangles.size()));
        made->setVertices(unsigned(mesh.positions.size()),
                          makeBuffer(context_, RT_FORMAT_FLOAT3, mesh.positions), RT_FORMAT_FLOAT3);
        made->setTriangleIndices(triangles, RT_FORMAT_UNSIGNED_INT3);
        made->setAttributeProgram(program("triangle_attributes"));
        made["normals"]->set(makeBuffer(context_, RT_FORMAT_FLOAT3, mesh.normals));
        made["triangles"]->set(triangles);
        GeometryInstance instance = context_->createGeometryInstance(made, material_);
        instance["albedo"]->setFloat(albedo);
        instance["gloss"]->setFloat(gloss);
        top_->addChild(instance);
    }
    void setScale(float radius) {
        context_["scene_epsilon"]->setFloat(radius * 1e-4f);
        context_["lamp_place"]->setFloat(make_float3(-1.3f, 2.2f, 1.1f) * radius);
        context_["lamp_radius"]->setFloat(0.35f * radius);
        context_["lamp_power"]->setFloat(make_float3(9.0f, 7.5f, 5.5f) * (radius * radius));
        setCamera(context_, makeCamera(make_float3(1.2f, 1.1f, 2.2f) * radius, make_float3(0.0f),
                                       40.0f, picture_.aspect()));
    }

    void render(const Options& options) {
        context_["max_depth"]->setUint(options.depth);
        unsigned frame = 0;
        float error = 1.0f;
        while (frame < options.frames && error * 1000.0f > float(options.errorPerMille)) {
            clearNoise();
            context_["frame"]->setUint(frame);
            context_->launch(kAddPath, picture_.width, picture_.height);
            ++frame;
            error = meanError(frame);
            const bool isPower = (frame & (frame - 1)) == 0;
            if (isPower && frame < options.frames) {
                std::printf("frame %u, estimated error %.4f\n", frame, error);
                if (options.intermediate)
                    writeFrame(frame);
            }
        }
        std::printf("%u frames, estimated error %.4f\n", frame, error);
        writePicture(picture_, result_->get(), true);
    }

    // A viewer without a window: the launch continues while pictures are written.
    void stream(const Options& options) {
        context_["max_depth"]->setUint(options.depth);
        context_["frame"]->setUint(0);
        Buffer stream =
            context_->createBuffer(RT_BUFFER_PROGRESSIVE_STREAM, RT_FORMAT_UNSIGNED_BYTE4,
                                   picture_.width, picture_.height);
        stream->bindProgressiveStream(result_);
        const float gamma = 2.2f;
        stream->setAttribute(RT_BUFFER_ATTRIBUTE_STREAM_GAMMA, sizeof gamma, &gamma);
        unsigned frame = 0, shown = 0;
        while (frame < options.frames) {
            context_->launchProgressive(kOnePath, picture_.width, picture_.height, options.frames);
            if (!stream->getProgressiveUpdateReady(frame)) {
                std::this_thread::sleep_for(std::chrono::milliseconds(2));
                continue;
            }
            if (frame < 2 * shown && frame < options.frames)
                continue; // pictures that look the same
            shown = frame;
            std::printf("%u frames\n", frame);
            if (options.intermediate || frame == options.frames)
                writeStream(stream, frame == options.frames ? picture_.output : fileOf(frame));
        }
        context_->stopProgressive();
    }

private:
    void writeStream(Buffer stream, const std::string& file) {
        const auto* bytes = static_cast<const uint8_t*>(stream->map(0, RT_BUFFER_MAP_READ));
        const std::vector<uint8_t> pixels(bytes,
                                          bytes + size_t(picture_.width) * picture_.height * 4);
        stream->unmap();
        writePng(file, picture_.width, picture_.height, pixels);
        std::printf("wrote %s\n", file.c_str());
    }
    Program program(const char* name) {
        return context_->createProgramFromPTXString(std::string(progressive_ptx()), name);
    }
    void clearNoise() {
        std::memset(noise_->map(0, RT_BUFFER_MAP_WRITE_DISCARD), 0,
                    picture_.height * sizeof(float));
        noise_->unmap();
    }
    // The standard deviation of the mean, by the paths of this launch.
    float meanError(unsigned frames) {
        const float* rows = static_cast<const float*>(noise_->map(0, RT_BUFFER_MAP_READ));
        double variance = 0.0;
        for (unsigned y = 0; y < picture_.height; ++y)
            variance += rows[y];
        noise_->unmap();
        variance /= double(picture_.width) * picture_.height;
        return frames < 2 ? 1.0f : float(std::sqrt(variance / frames));
    }
    std::string fileOf(unsigned frame) const {
        std::string file = picture_.output;
        const size_t dot = file.rfind('.');
        return file.insert(dot == std::string::npos ? file.size() : dot,
                           "-" + std::to_string(frame));
    }
    void writeFrame(unsigned frame) {
        ClassicPicture one = picture_;
        one.output = fileOf(frame);
        writePicture(one, result_->get(), true);
    }

    ClassicPicture picture_;
    Context context_;
    GeometryGroup top_;
    Material material_;
    Buffer result_, noise_;
};

void render(const ClassicPicture& picture, const Options& options, const std::string& model) {
    const Model scene = loadModel(model);
    Renderer renderer(picture);
    renderer.add(scene.object, make_float3(0.8f, 0.35f, 0.15f), 0.06f);
    renderer.add(scene.ground, make_float3(0.55f), 0.0f);
    renderer.setScale(scene.radius);
    if (options.stream)
        renderer.stream(options);
    else
        renderer.render(options);
}

} // namespace

int main(int argc, char** argv) {
    ClassicPicture picture = {"progressive.png", 640, 480};
    Options options;
    std::string model;
    Arguments arguments("A picture that gets better launch by launch.");
    arguments.addPositional("model.obj", model, "model to render; none: a generated one");
    addOptions(arguments, picture);
    arguments.add("--frames", options.frames, 1, 1 << 20, "launches at most");
    arguments.add("--depth", options.depth, 1, 64, "segments of a path");
    arguments.add("--error", options.errorPerMille, 0, 1000, "thousandths of white to end at");
    arguments.add("--intermediate", options.intermediate, 0, 1, "1: write frames 1, 2, 4 ...");
    arguments.add("--stream", options.stream, 0, 1, "1: one progressive launch, shown as it grows");
    return runClassicSample("progressive", arguments, argc, argv,
                            [&] { render(picture, options, model); });
}
