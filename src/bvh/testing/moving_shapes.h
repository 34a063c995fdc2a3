// SPDX-License-Identifier: Apache-2.0
// Curves and spheres with motion keys, for tests of builders on CPUs and GPUs.
#pragma once

#include "bvh/motion/motion.h"
#include "bvh/shapes/curves.h"
#include "bvh/shapes/shapes.h"
#include "bvh/shapes/spheres.h"
#include "bvh/testing/meshes.h"

namespace sunstone::bvh::testing {

inline constexpr uint32_t kMovingKinds[] = {0x2501, 0x2502, 0x2503, 0x2504, kSphereShape};
inline constexpr uint32_t kMovingCount = 150;

// Points of primitives that share none, once for each key. Points are those of spheres or curves.
struct MovingShapes {
    uint32_t shape, keys;
    std::vector<std::vector<Vec3>> positions;
    std::vector<std::vector<float>> radii;
    std::vector<uint32_t> indices;
    uint32_t flags = 0;
    MotionOptions motion;

    MovingShapes(uint32_t kind, uint32_t numKeys, uint32_t seed) : shape(kind), keys(numKeys) {
        Random random(seed);
        const uint32_t points = shape == kSphereShape ? 1 : degreeOf(CurveBasis(shape)) + 1;
        for (uint32_t i = 0; i < kMovingCount; ++i)
            indices.push_back(i * points);
        positions.resize(keys);
        radii.resize(keys);
        for (uint32_t key = 0; key < keys; ++key)
            for (uint32_t i = 0; i < kMovingCount; ++i) {
                const Vec3 place = random.point(1);
                for (uint32_t k = 0; k < points; ++k) {
                    positions[key].push_back(place + random.point(0.4f));
                    radii[key].push_back(random(0.03f, 0.12f));
                }
            }
        motion = {keys, 0, -1, 3};
    }

    // The primitives between keys, without motion.
    MovingShapes at(float time, float (*interpolate)(float, float, float) = between) const {
        MovingShapes still = *this;
        const KeySegment s = keySegment(keys, motion.begin, motion.end, time);
        still.keys = 1;
        still.motion = {};
        still.positions = {positions[s.key]};
        still.radii = {radii[s.key]};
        for (size_t i = 0; i < radii[0].size(); ++i) {
            for (int a = 0; a < 3; ++a)
                still.positions[0][i][a] =
                    interpolate(positions[s.key][i][a], positions[s.key + 1][i][a], s.fraction);
            still.radii[0][i] = interpolate(radii[s.key][i], radii[s.key + 1][i], s.fraction);
        }
        return still;
    }

    // Calls with inputs that live as long as the call.
    template <class F>
    auto with(F&& use) const {
        std::vector<const void*> p, r;
        for (uint32_t key = 0; key < keys; ++key) {
            p.push_back(positions[key].data());
            r.push_back(radii[key].data());
        }
        CurveInput curve;
        SphereInput sphere;
        BuildInputs inputs;
        if (shape == kSphereShape) {
            sphere.centres = p[0], sphere.keyCentres = p.data();
            sphere.radii = r[0], sphere.keyRadii = r.data();
            sphere.numSpheres = kMovingCount;
            sphere.sbt.flags = &flags;
            inputs.spheres = {&sphere, 1};
        } else {
            curve.basis = shape;
            curve.vertices = p[0], curve.keyVertices = p.data();
            curve.radii = r[0], curve.keyRadii = r.data();
            curve.numVertices = uint32_t(radii[0].size());
            curve.indices = indices.data();
            curve.numSegments = kMovingCount;
            curve.caps = shape != 0x2503;
            curve.sbt.flags = &flags;
            inputs.curves = {&curve, 1};
        }
        return use(inputs);
    }
    Structure structure(BuildOptions options) const {
        options.motion = motion;
        return with([&](const BuildInputs& inputs) { return makeStructure(inputs, options); });
    }
};

inline ShapeRay randomShapeRay(Random& random, float time) {
    const Vec3 o = random.point(1.8f), d = random.unit() * random(0.5f, 2);
    return {{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, random.below(3) ? 1e30f : random(0.6f, 2), time};
}

} // namespace sunstone::bvh::testing
