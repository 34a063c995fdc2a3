// SPDX-License-Identifier: Apache-2.0
// Callable programs as parts of materials, with the C++ wrapper: bound programs for scattering, one
// of which calls another; ids for patterns; a buffer of ids for lights. Read next: motion.
#include "shapes6.h"

#include <optix_world.h>

#include <string_view>

std::string_view callables_ptx(); // of callables.cu and library.cu, built into this program
std::string_view library_ptx();

namespace {

using namespace optix;

enum RayType { kPathRay, kShadowRay, kRayTypes };

class Scene {
public:
    explicit Scene(Context context)
        : context_(context), group_(context->createGeometryGroup()), hit_(program("hit_surface")),
          block_(program("block_light")) {
        group_->setAcceleration(context_->createAcceleration("Trbvh"));
    }

    Program program(const char* name) {
        return context_->createProgramFromPTXString(std::string(callables_ptx()), name);
    }
    Program callable(const char* name) {
        return context_->createProgramFromPTXString(std::string(library_ptx()), name);
    }
    Program pattern(const char* name, float3 color, float3 color2, float2 repeat) {
        Program made = callable(name);
        made["color"]->setFloat(color);
        made["color2"]->setFloat(color2);
        made["repeat"]->setFloat(repeat);
        return made;
    }
    Program plain(float3 color) {
        Program made = callable("pattern_plain");
        made["color"]->setFloat(color);
        return made;
    }
    Material material(Program bsdf) {
        Material made = context_->createMaterial();
        made->setClosestHitProgram(kPathRay, hit_);
        made->setAnyHitProgram(kShadowRay, block_);
        made["bsdf"]->set(bsdf);
        return made;
    }

    void addSphere(float3 centre, float radius, Material material, Program pattern) {
        add(makeSphere(context_, centre, radius), material, pattern);
    }
    void addFloor(Material material, Program pattern) {
        add(makeParallelogram(context_, make_float3(-8.0f, 0.0f, 6.0f),
                              make_float3(16.0f, 0.0f, 0.0f), make_float3(0.0f, 0.0f, -16.0f)),
            material, pattern);
    }
    void setLights(const std::vector<Program>& lights) {
        std::vector<callableProgramId<float3(float3, float2)>> ids;
        for (Program each : lights)
            ids.push_back(each->getId());
        context_["light_programs"]->set(makeBuffer(context_, RT_FORMAT_PROGRAM_ID, ids));
    }
    GeometryGroup group() { return group_; }

private:
    void add(Geometry geometry, Material material, Program pattern) {
        GeometryInstance made =
            context_->createGeometryInstance(geometry, &material, &material + 1);
        made["pattern"]->setProgramId(pattern);
        group_->addChild(made);
    }

    Context context_;
    GeometryGroup group_;
    Program hit_, block_;
};

void addObjects(Scene& scene) {
    Program diffuse = scene.callable("bsdf_diffuse");
    Program polished = scene.callable("bsdf_metal"), brushed = scene.callable("bsdf_metal");
    polished["roughness"]->setFloat(0.02f);
    brushed["roughness"]->setFloat(0.25f);
    Program coated = scene.callable("bsdf_coated"), coatedMetal = scene.callable("bsdf_coated");
    coated["base"]->set(diffuse);
    coatedMetal["base"]->set(brushed);

    const float2 once = make_float2(1.0f, 1.0f);
    scene.addFloor(scene.material(diffuse),
                   scene.pattern("pattern_checks", make_float3(0.55f), make_float3(0.3f),
                                 make_float2(16.0f, 16.0f)));
    const Program patterns[5] = {
        scene.pattern("pattern_checks", make_float3(0.8f, 0.3f, 0.15f),
                      make_float3(0.85f, 0.8f, 0.7f), make_float2(12.0f, 6.0f)),
        scene.plain(make_float3(0.95f, 0.93f, 0.88f)), scene.plain(make_float3(1.0f, 0.7f, 0.3f)),
        scene.pattern("pattern_stripes", make_float3(0.1f, 0.3f, 0.65f), make_float3(0.9f),
                      make_float2(0.0f, 7.0f)),
        scene.pattern("pattern_stripes", make_float3(0.1f, 0.6f, 0.3f),
                      make_float3(0.9f, 0.8f, 0.2f), once * 8.0f)};
    const Program bsdfs[5] = {diffuse, polished, brushed, coated, coatedMetal};
    for (int i = 0; i < 5; ++i)
        scene.addSphere(make_float3(1.25f * float(i - 2), 0.55f, i % 2 ? 0.5f : -0.2f), 0.55f,
                        scene.material(bsdfs[i]), patterns[i]);

    Program lamp = scene.callable("light_sphere"), sun = scene.callable("light_sun");
    lamp["place"]->setFloat(-1.5f, 3.0f, 2.5f);
    lamp["power"]->setFloat(16.0f, 12.0f, 8.0f);
    lamp["size"]->setFloat(0.4f);
    sun["place"]->setFloat(0.5f, 0.7f, 0.3f);
    sun["power"]->setFloat(1.4f, 1.4f, 1.6f);
    sun["size"]->setFloat(0.08f);
    scene.setLights({lamp, sun});
}

void render(const ClassicPicture& picture, unsigned samples, unsigned depth) {
    Context context = Context::create();
    context->setRayTypeCount(kRayTypes);
    context->setEntryPointCount(1);
    context->setMaxCallableProgramDepth(2);
    Scene scene(context);
    context->setRayGenerationProgram(0, scene.program("trace_paths"));
    context->setExceptionProgram(0, scene.program("show_exception"));
    context->setMissProgram(kPathRay, scene.program("miss"));
    Program sky = scene.callable("sky_gradient");
    sky["horizon"]->setFloat(0.7f, 0.7f, 0.72f);
    sky["zenith"]->setFloat(0.15f, 0.3f, 0.6f);
    context["sky"]->set(sky);
    context["scene_epsilon"]->setFloat(1e-3f);
    context["samples"]->setUint(samples);
    context["max_depth"]->setUint(depth);
    Buffer buffer =
        context->createBuffer(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT4, picture.width, picture.height);
    context["picture"]->set(buffer);
    addObjects(scene);
    context["top_object"]->set(scene.group());

    const ClassicCamera camera = makeCamera(make_float3(0.0f, 1.8f, 5.2f),
                                            make_float3(0.0f, 0.5f, 0.0f), 38.0f, picture.aspect());
    setCamera(context, camera);
    context->validate();
    context->launch(0, picture.width, picture.height);
    writePicture(picture, buffer->get(), true);
    context->destroy();
}

} // namespace

int main(int argc, char** argv) {
    ClassicPicture picture = {"callables.png", 640, 360};
    unsigned samples = 32, depth = 5;
    Arguments arguments("Materials and lights of callable programs.");
    addOptions(arguments, picture);
    arguments.add("--samples", samples, 1, 65536, "paths for each pixel");
    arguments.add("--depth", depth, 1, 64, "segments of a path");
    return runClassicSample("callables", arguments, argc, argv,
                            [&] { render(picture, samples, depth); });
}
