// SPDX-License-Identifier: Apache-2.0
// Progressive photon mapping with the C++ wrapper: several entry points of one context, buffers
// that the host reads and writes between launches. Caustics need few passes.
#include "photon_tree.h"
#include "shapes6.h"

#include <optix_world.h>

#include <cstdio>
#include <string_view>

std::string_view photon_mapping_ptx(); // the PTX of photon_mapping.cu, built into this program

namespace {

using namespace optix;

enum RayType { kCameraRay, kPhotonRay, kRayTypes };
enum Entry { kSee, kShootPhotons, kGather, kEntries };

constexpr unsigned kPhotonsOfPath = 4;

class Renderer {
public:
    explicit Renderer(const ClassicPicture& picture)
        : picture_(picture), context_(Context::create()), group_(context_->createGeometryGroup()) {
        context_->setRayTypeCount(kRayTypes);
        context_->setEntryPointCount(kEntries);
        const char* entries[kEntries] = {"see", "shoot_photons", "gather"};
        for (unsigned i = 0; i < kEntries; ++i) {
            context_->setRayGenerationProgram(i, program(entries[i]));
            context_->setExceptionProgram(i, program("show_exception"));
        }
        context_->setMissProgram(kCameraRay, program("camera_miss"));
        context_->setMissProgram(kPhotonRay, program("photon_miss"));
        group_->setAcceleration(context_->createAcceleration("Trbvh"));
        context_["top_object"]->set(group_);
        context_["scene_epsilon"]->setFloat(1e-3f);
        context_["index_of_refraction"]->setFloat(1.5f);
        context_["max_depth"]->setUint(10);
        context_["photons_of_path"]->setUint(kPhotonsOfPath);
        result_ = context_->createBuffer(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT4, picture.width,
                                         picture.height);
        context_["picture"]->set(result_);
        context_["seen"]->set(userBuffer(sizeof(Seen), picture.width, picture.height));
    }
    ~Renderer() { context_->destroy(); }
    Renderer(const Renderer&) = delete;

    Context context() { return context_; }
    Material material(const char* camera, const char* photon) {
        Material made = context_->createMaterial();
        made->setClosestHitProgram(kCameraRay, program(camera));
        made->setClosestHitProgram(kPhotonRay, program(photon));
        return made;
    }
    void add(Geometry geometry, Material material, float3 albedo) {
        GeometryInstance instance =
            context_->createGeometryInstance(geometry, &material, &material + 1);
        instance["albedo"]->setFloat(albedo);
        group_->addChild(instance);
    }

    void render(unsigned passes, unsigned side, float radius) {
        photons_ = userBuffer(sizeof(Photon), size_t(side) * side * kPhotonsOfPath);
        tree_ = userBuffer(sizeof(Photon), size_t(side) * side * kPhotonsOfPath);
        context_["photons"]->set(photons_);
        context_["tree"]->set(tree_);
        context_["nodes"]->setUint(0);
        context_["first_radius"]->setFloat(radius);
        context_["pass"]->setUint(0);
        context_["paths"]->setFloat(1.0f);
        context_->validate();
        context_->launch(kSee, picture_.width, picture_.height);
        for (unsigned pass = 0; pass < passes; ++pass) {
            context_["pass"]->setUint(pass);
            context_->launch(kShootPhotons, side, side);
            plantTree(size_t(side) * side * kPhotonsOfPath);
            context_["paths"]->setFloat(float(pass + 1) * float(side) * float(side));
            context_->launch(kGather, picture_.width, picture_.height);
        }
        writePicture(picture_, result_->get(), true);
    }

private:
    Program program(const char* name) {
        return context_->createProgramFromPTXString(std::string(photon_mapping_ptx()), name);
    }
    Buffer userBuffer(size_t elementBytes, size_t width, size_t height = 0) {
        Buffer made = context_->createBuffer(RT_BUFFER_INPUT_OUTPUT, RT_FORMAT_USER);
        made->setElementSize(elementBytes);
        if (height)
            made->setSize(width, height);
        else
            made->setSize(width);
        return made;
    }
    void plantTree(size_t places) {
        const std::vector<Photon> nodes =
            buildTree(static_cast<const Photon*>(photons_->map(0, RT_BUFFER_MAP_READ)), places);
        photons_->unmap();
        std::memcpy(tree_->map(0, RT_BUFFER_MAP_WRITE_DISCARD), nodes.data(),
                    nodes.size() * sizeof(Photon));
        tree_->unmap();
        context_["nodes"]->setUint(unsigned(nodes.size()));
        std::printf("%zu photons\n", nodes.size());
    }

    ClassicPicture picture_;
    Context context_;
    GeometryGroup group_;
    Buffer result_, photons_, tree_;
};

void addScene(Renderer& renderer) {
    Context context = renderer.context();
    const float3 x = make_float3(2.4f, 0.0f, 0.0f), y = make_float3(0.0f, 2.0f, 0.0f),
                 z = make_float3(0.0f, 0.0f, 2.0f), low = make_float3(-1.2f, -1.0f, -1.0f),
                 high = make_float3(1.2f, 1.0f, 1.0f);
    Material wall = renderer.material("see_diffuse", "store_photon");
    renderer.add(makeParallelogram(context, low, z, x), wall, make_float3(0.75f));
    renderer.add(makeParallelogram(context, high, -x, -z), wall, make_float3(0.75f));
    renderer.add(makeParallelogram(context, low, x, y), wall, make_float3(0.75f));
    renderer.add(makeParallelogram(context, low, y, z), wall, make_float3(0.7f, 0.35f, 0.15f));
    renderer.add(makeParallelogram(context, high, -y, -z), wall, make_float3(0.2f, 0.45f, 0.5f));
    Material glass = renderer.material("see_through", "pass_photon");
    renderer.add(makeSphere(context, make_float3(-0.5f, -0.5f, -0.1f), 0.45f), glass,
                 make_float3(0.0f));
    renderer.add(makeSphere(context, make_float3(0.55f, -0.65f, 0.35f), 0.3f), glass,
                 make_float3(0.0f));
    renderer.add(makeSphere(context, make_float3(0.55f, -0.2f, -0.5f), 0.35f), wall,
                 make_float3(0.7f, 0.65f, 0.3f));

    const float3 anchor = make_float3(-0.15f, 0.98f, -0.15f), edge1 = make_float3(0.3f, 0.0f, 0.0f),
                 edge2 = make_float3(0.0f, 0.0f, 0.3f);
    const float3 emission = make_float3(34.0f, 31.0f, 27.0f);
    context["light_anchor"]->setFloat(anchor);
    context["light_edge1"]->setFloat(edge1);
    context["light_edge2"]->setFloat(edge2);
    context["emission"]->setFloat(emission);
    context["light_power"]->setFloat(emission * (M_PIf * length(cross(edge1, edge2))));
    renderer.add(makeParallelogram(context, anchor, edge1, edge2),
                 renderer.material("see_light", "absorb_photon"), make_float3(0.0f));
}

} // namespace

int main(int argc, char** argv) {
    ClassicPicture picture = {"photon_mapping.png", 512, 384};
    unsigned passes = 16, side = 256;
    Arguments arguments("Progressive photon mapping.");
    addOptions(arguments, picture);
    arguments.add("--passes", passes, 1, 65536, "passes of photons");
    arguments.add("--side", side, 1, 2048, "square root of the paths in a pass");
    return runClassicSample("photon_mapping", arguments, argc, argv, [&] {
        Renderer renderer(picture);
        addScene(renderer);
        setCamera(renderer.context(), makeCamera(make_float3(0.0f, 0.0f, 3.9f), make_float3(0.0f),
                                                 36.0f, picture.aspect()));
        renderer.render(passes, side, 0.08f);
    });
}
