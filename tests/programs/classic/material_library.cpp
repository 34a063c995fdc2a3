// SPDX-License-Identifier: Apache-2.0
// A material library: 200 materials share a few programs, and each square of a board has two of
// them. A material sets some of the variables, its instance overrides others, the context and the
// device code's initialisers have the rest. Lights are records with ids of callables and buffers.
#include "device/material_library.h"
#include "common.h"

#include <optixu/optixu_math_namespace.h>
#include <optixu/optixu_matrix_namespace.h>

#include <cmath>
#include <cstddef>
#include <cstring>
#include <vector>

using namespace optix;

namespace {

constexpr unsigned kMaterials = 200, kColumns = 10, kRows = kMaterials / kColumns / 2;

struct Values { // of one material, as the host computes them
    float3 color = make_float3(0.25f, 0.5f, 0.75f);
    float roughness = 0.125f, scale = 1;
    int layer = -3;
    uint2 tile = make_uint2(11, 22);
    Matrix3x3 tint = Matrix3x3::identity();
    Swatch swatch = {{0, 10, 0, 0}, 100, {0, 0, 1}};
    unsigned light = 0;
    bool striped = false;
};

class Library {
public:
    Library() {
        context_ = Context::create();
        context_->setRayTypeCount(1);
        context_->setEntryPointCount(1);
        context_->setStackSize(1200);
        context_["columns"]->setUint(kColumns);
        context_["tile"]->setUint(11, 22);
        const Values common;
        context_["tint"]->setMatrix3x3fv(false, common.tint.getData());
        context_["swatch"]->setUserData(sizeof(Swatch), &common.swatch);
        output_ = context_->createBuffer(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT4, 2 * kColumns, kRows);
        context_["output"]->set(output_);
        makeTables();
        makeBoard();
        context_->setRayGenerationProgram(0, program("look_at_all"));
        context_->setMissProgram(0, program("no_hit"));
    }
    ~Library() { context_->destroy(); }
    Library(const Library&) = delete;

    void check(const std::string& what) {
        context_->validate();
        context_->launch(0, 2 * kColumns, kRows);
        const auto* seen = static_cast<const float4*>(output_->map());
        const std::vector<float4> pixels(seen, seen + kMaterials);
        output_->unmap();
        for (unsigned i = 0; i < kMaterials; ++i) {
            const unsigned x = i % (2 * kColumns), y = i / (2 * kColumns);
            const float4 wanted = shade(i) * (x % 2 ? -1.0f : 1.0f);
            const float4 difference = pixels[i] - wanted;
            const float worst = fmaxf(fmaxf(std::fabs(difference.x), std::fabs(difference.y)),
                                      fmaxf(std::fabs(difference.z), std::fabs(difference.w)));
            require(worst < 1e-3f, what + ": material " + std::to_string(i) + " in row " +
                                       std::to_string(y) + " differs by " + std::to_string(worst));
        }
    }
    void overrideColor(unsigned square, float3 color) {
        instances_[square]["base_color"]->setFloat(color);
        values_[2 * square].color = values_[2 * square + 1].color = color;
    }
    void dropOverride(unsigned square) {
        instances_[square]->removeVariable(instances_[square]["base_color"]);
        for (unsigned i = 2 * square; i < 2 * square + 2; ++i)
            values_[i].color = own_[i].color;
    }
    void exchangeMixers() {
        auto* ids = static_cast<int*>(mixers_->map());
        std::swap(ids[0], ids[1]);
        mixers_->unmap();
        exchanged_ = !exchanged_;
    }
    void removeSquare(unsigned square) {
        group_->removeChild(instances_[square]);
        group_->getAcceleration()->markDirty();
        context_->launch(0, 2 * kColumns, kRows);
        const auto* seen = static_cast<const float4*>(output_->map());
        require(seen[2 * square].x == -7.0f, "a removed square is still there");
        output_->unmap();
        group_->addChild(instances_[square]);
        group_->getAcceleration()->markDirty();
    }

private:
    Program program(const char* name) {
        return context_->createProgramFromPTXString(device_ptx, name);
    }
    float mix(int id, float a, float b) const {
        const bool square = id == (exchanged_ ? 0 : 1);
        return id == 2 ? mix(0, a, b) * mix(1, a, b) : square ? a * a + b : a + b;
    }
    // The ids in the records name programs; those in the table change places.
    float call(int program, float a, float b) const {
        return program == 2 ? mix(2, a, b) : program == 1 ? a * a + b : a + b;
    }
    float4 shade(unsigned i) const {
        const Values& v = values_[i];
        float sum = 0;
        for (unsigned k = 0; k <= v.light; ++k)
            sum += 0.25f * float(k + 1);
        sum = call(int(v.light) % 3, sum, 0.5f * float(v.light));
        sum = call(int(v.light + 1) % 3, sum, 0.5f * float(v.light));
        float3 pattern = v.scale * v.color;
        if (v.striped && !(v.layer & 1))
            pattern = make_float3(v.color.z, v.color.y, v.color.x);
        const float3 color =
            v.tint * pattern * sum + make_float3(float(v.tile.x), float(v.tile.y), v.roughness);
        return make_float4(color, float(v.swatch.rgba[1] + v.swatch.gloss + v.swatch.flags[2]) +
                                      (v.layer & 1 ? 2.5f : 0.25f));
    }
    void makeTables() {
        const char* const names[] = {"mix_linear", "mix_square", "mix_chain"};
        mixers_ = context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_PROGRAM_ID, 3);
        auto* ids = static_cast<int*>(mixers_->map());
        for (int i = 0; i < 3; ++i)
            ids[i] = mixerIds_[i] = program(names[i])->getId();
        mixers_->unmap();
        context_["mixers"]->set(mixers_);
        constexpr unsigned kLights = 4;
        Buffer lights = context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_USER, kLights);
        lights->setElementSize(sizeof(Light));
        auto* records = static_cast<Light*>(lights->map());
        for (unsigned i = 0; i < kLights; ++i) {
            Light light = {};
            light.curve = floats(i + 1)->getId();
            light.count = i + 1;
            light.falloff[0] = mixerIds_[i % 3];
            light.falloff[1] = mixerIds_[(i + 1) % 3];
            light.weight = 0.5f * float(i);
            records[i] = light;
        }
        lights->unmap();
        context_["lights"]->set(lights);
        Buffer curves = context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_BUFFER_ID, 2);
        auto* curve = static_cast<int*>(curves->map());
        curve[0] = floats(1)->getId();
        curve[1] = floats(1, 10)->getId();
        curves->unmap();
        context_["curves"]->set(curves);
    }
    Buffer floats(unsigned count, float factor = 1) {
        Buffer buffer = context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_FLOAT, count);
        auto* data = static_cast<float*>(buffer->map());
        for (unsigned i = 0; i < count; ++i)
            data[i] = 0.25f * float(i + 1) * factor;
        buffer->unmap();
        return buffer;
    }
    // Sets what material i has of its own.
    void fillMaterial(unsigned i, Material material) {
        Values& v = values_[i];
        if (i % 3 == 0)
            material["base_color"]->setFloat(v.color = make_float3(float(i), 1, float(i % 7)));
        if (i % 5 == 0)
            material["roughness"]->setFloat(v.roughness = float(i) / 16);
        if (i % 7 == 0)
            material["layer"]->setInt(v.layer = int(i));
        v.striped = i % 4 < 2;
        v.scale = v.striped ? 3.0f : 2.0f;
        material["pattern"]->set(v.striped ? striped_ : plain_);
        material["light_index"]->setUint(v.light = i / 4 % 4);
    }
    void makeBoard() {
        plain_ = program("plain_pattern");
        striped_ = program("striped_pattern");
        plain_["pattern_scale"]->setFloat(2);
        striped_["pattern_scale"]->setFloat(3);
        group_ = context_->createGeometryGroup();
        group_->setAcceleration(context_->createAcceleration("Bvh", "Bvh"));
        values_.resize(kMaterials);
        for (unsigned square = 0; square < kMaterials / 2; ++square) {
            Geometry geometry = context_->createGeometry();
            geometry->setPrimitiveCount(1);
            geometry->setBoundingBoxProgram(program("square_bounds"));
            geometry->setIntersectionProgram(program("square_intersect"));
            geometry["corner"]->setFloat(float(square % kColumns), float(square / kColumns));
            Material materials[2];
            for (unsigned side = 0; side < 2; ++side) {
                materials[side] = context_->createMaterial();
                materials[side]->setClosestHitProgram(0,
                                                      program(side ? "shade_back" : "shade_front"));
                fillMaterial(2 * square + side, materials[side]);
            }
            GeometryInstance instance =
                context_->createGeometryInstance(geometry, materials, materials + 2);
            overrideOf(square, instance);
            group_->addChild(instance);
            instances_.push_back(instance);
        }
        own_ = values_;
        context_["top_object"]->set(group_);
    }
    // What the instance of a square has for both its materials.
    void overrideOf(unsigned square, GeometryInstance instance) {
        Values& first = values_[2 * square];
        Values& second = values_[2 * square + 1];
        if (square % 2 == 0) {
            first.tile = second.tile = make_uint2(square, square + 1);
            instance["tile"]->setUint(first.tile);
        }
        if (square % 3 == 0) {
            Matrix3x3 tint = Matrix3x3::identity();
            tint[1] = 0.5f; // row 0, column 1
            first.tint = second.tint = tint;
            instance["tint"]->setMatrix3x3fv(false, tint.getData());
        }
        if (square % 5 == 0) {
            const Swatch swatch = {{1, (unsigned char)(square), 3, 4}, -7, {5, 6, 200}};
            first.swatch = second.swatch = swatch;
            instance["swatch"]->setUserData(sizeof swatch, &swatch);
        }
    }

    Context context_;
    Buffer output_, mixers_;
    Program plain_, striped_;
    GeometryGroup group_;
    std::vector<GeometryInstance> instances_;
    std::vector<Values> values_, own_; // own_: without later overrides
    int mixerIds_[3] = {};
    bool exchanged_ = false;
};

void run() {
    Library library;
    library.check("at first");
    library.overrideColor(7, make_float3(1, 2, 3));
    library.overrideColor(50, make_float3(0.5f, 0.25f, 4));
    library.check("with two overrides");
    library.dropOverride(7);
    library.check("with one override");
    library.exchangeMixers();
    library.check("with other mixers");
    library.removeSquare(33);
    library.check("with all squares again");
}

} // namespace

int main() {
    return runProgram(run);
}
