// SPDX-License-Identifier: Apache-2.0
// `sunstone render`: the samples' path tracer, through the public OptiX API, on any model.
#include "commands.h"
#include "image_files.h"

#include "model/model.h"
#include "path_tracer.h"
#include "progress.h"

#include <optix_function_table_definition.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace sunstone::tool {
namespace {

HostScene convert(const model::Model& source, bool zUp) {
    HostScene scene;
    auto turned = [zUp](const model::Vec3& v) {
        return zUp ? vec(v.x, v.z, -v.y) : vec(v.x, v.y, v.z);
    };
    for (const model::Vec3& position : source.positions)
        scene.positions.push_back(turned(position));
    for (const model::Vec3& normal : source.normals)
        scene.normals.push_back(turned(normal));
    for (const model::Triangle& t : source.triangles) {
        uint3 triangle;
        triangle.x = t.a;
        triangle.y = t.b;
        triangle.z = t.c;
        scene.triangles.push_back(triangle);
    }
    scene.materialOfTriangle = source.materialOfTriangle;
    for (const model::Material& m : source.materials)
        scene.materials.push_back({vec(m.color.x, m.color.y, m.color.z), m.roughness,
                                   vec(m.emission.x, m.emission.y, m.emission.z), m.metallic,
                                   m.opacity, m.cutoff, AlphaMode(m.alpha),
                                   unsigned(m.texture + 1)});
    for (const model::Vec4& c : source.colors)
        scene.colors.push_back({c.x, c.y, c.z, c.w});
    for (const model::Vec2& t : source.texcoords)
        scene.texcoords.push_back({t.x, t.y});
    for (const model::Texture& texture : source.textures) {
        HostTexture& made = scene.textures.emplace_back();
        made.width = texture.width;
        made.height = texture.height;
        made.texels.resize(texture.rgba.size() / 4);
        std::memcpy(made.texels.data(), texture.rgba.data(), made.texels.size() * 4);
    }
    return scene;
}

// The floor has no colours or texture coordinates: it gets white and arbitrary coordinates.
void completeLooks(HostScene& scene) {
    if (!scene.colors.empty())
        scene.colors.resize(scene.positions.size(), {1.0f, 1.0f, 1.0f, 1.0f});
    if (!scene.texcoords.empty())
        scene.texcoords.resize(scene.positions.size(), {0.0f, 0.0f});
}

// Moves the model to the origin and scales it to a radius of one, so that single precision suits
// any units of the file; cameras given on the command line follow.
struct Placement {
    float3 center;
    float scale;
    float3 apply(float3 p) const { return (p - center) * scale; }
};

Placement normalizePlacement(HostScene& scene) {
    Bounds bounds = boundsOf(scene);
    float radius = bounds.radius();
    Placement placement = {bounds.center(), radius > 0.0f ? 1.0f / radius : 1.0f};
    for (float3& position : scene.positions)
        position = placement.apply(position);
    return placement;
}

Camera chooseCamera(const RenderOptions& options, const Placement& placement,
                    const Bounds& bounds) {
    float aspect = float(options.width) / float(options.height);
    auto point = [&](const std::vector<float>& list) {
        return placement.apply(options.zUp ? vec(list[0], list[2], -list[1])
                                           : vec(list[0], list[1], list[2]));
    };
    float3 target = options.lookAt.empty() ? bounds.center() : point(options.lookAt);
    if (!options.eye.empty()) {
        float3 eye = point(options.eye);
        if (!(length(target - eye) > 0.0f))
            throw std::runtime_error("render: --camera and --look-at are the same point");
        return makeCamera(eye, target, vec(0.0f, 1.0f, 0.0f), options.fov, aspect);
    }
    Camera camera = orbitCamera(bounds, options.azimuth, options.elevation, options.zoom, aspect);
    camera.eye += target - bounds.center();
    return camera;
}

void checkOutput(const std::string& output) {
    checkImageName(output);
    std::filesystem::path folder = std::filesystem::path(output).parent_path();
    std::error_code error;
    if (!folder.empty() && !std::filesystem::is_directory(folder, error))
        throw std::runtime_error("render: the folder of " + output + " does not exist");
}

double secondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

} // namespace

int render(const RenderOptions& options) {
    checkOutput(options.output);
    auto start = std::chrono::steady_clock::now();
    model::Model source = model::load(options.model);
    std::fprintf(stderr, "%s: %zu triangles, %zu materials (%.1f s)\n", options.model.c_str(),
                 source.triangles.size(), source.materials.size(), secondsSince(start));
    if (source.skippedTriangles != 0)
        std::fprintf(stderr,
                     "skipped %zu triangles with coordinates that are no numbers or beyond 1e18\n",
                     source.skippedTriangles);
    for (const std::string& file : source.missing)
        std::fprintf(stderr, "%s: %s; rendered without it\n", options.model.c_str(), file.c_str());
    HostScene scene = convert(source, options.zUp);
    source = {};
    Placement placement = normalizePlacement(scene);
    Bounds bounds = boundsOf(scene);
    if (options.ground)
        addGround(scene, bounds, bounds.low.y, {vec(0.36f, 0.35f, 0.34f), 0.5f, vec(0.0f), 0.0f});
    completeLooks(scene);
    Scene studio = makeStudio(bounds);
    studio.maxSegments = options.bounces + 1;

    start = std::chrono::steady_clock::now();
    OptixDeviceContext context = createContext();
    {
        PathTracer tracer(context, scene, studio, chooseCamera(options, placement, bounds),
                          options.width, options.height);
        std::fprintf(stderr, "programs compiled, acceleration structure built (%.1f s)\n",
                     secondsSince(start));
        Progress progress("rendering", options.samples);
        while (tracer.samples() < options.samples) {
            tracer.addSamples(std::min(2u, options.samples - tracer.samples()));
            progress.update(tracer.samples());
        }
        writeImage(options.output, options.width, options.height, tracer.image());
    }
    OPTIX_CHECK(optixDeviceContextDestroy(context));
    std::error_code error;
    std::filesystem::path absolute = std::filesystem::absolute(options.output, error);
    std::printf("wrote %s\n", (error ? options.output : absolute.string()).c_str());
    return 0;
}

} // namespace sunstone::tool
