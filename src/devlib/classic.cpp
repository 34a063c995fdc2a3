// SPDX-License-Identifier: Apache-2.0
#include "devlib/classic.h"

#include "base/threads/worker_object.h"
#include "bvh/motion/transforms.h"
#include "math/matrix.h"
#include "math/product.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sunstone::devlib {
namespace {

const ClassicLaunch& classicOf(const RayState& state) {
    return *static_cast<const ClassicLaunch*>(state.launch->params);
}

struct Scratch {
    std::vector<uint64_t> words;
};

// Loads from the result give zeros; stores are discarded.
void* outside(RayState* state, uint32_t bytes, uint32_t code) {
    if (code != 0 && (classicOf(*state).exceptions & switchOf(code)))
        state->launch->raise(state, int32_t(code), nullptr);
    std::vector<uint64_t>& scratch = workerObject<Scratch>().words;
    const size_t words = std::max<size_t>(16, (size_t(bytes) + 7) / 8);
    if (scratch.size() < words)
        scratch.resize(words);
    std::fill_n(scratch.begin(), words, 0);
    return scratch.data();
}

void checkRay(RayState* state, RayState* ray) {
    for (int i = 0; i < 3; ++i)
        if (!std::isfinite(ray->worldOrigin[i]) || !std::isfinite(ray->worldDirection[i]))
            state->launch->raise(state, kCodeInvalidRay, nullptr);
}

// The matrices of an entry of a transform list.
void matricesOf(uint64_t handle, float time, float toWorld[12], float toObject[12]) {
    const HandleTag tag = tagOf(handle);
    if (tag == kTagInstance) {
        const auto* record = reinterpret_cast<const InstanceRecord*>(addressOf(handle));
        std::copy_n(record->objectToWorld, 12, toWorld);
        std::copy_n(record->worldToObject, 12, toObject);
        return;
    }
    if (tag == kTagStatic) {
        const auto* transform = reinterpret_cast<const bvh::StaticTransform*>(addressOf(handle));
        std::copy_n(transform->transform, 12, toWorld);
        std::copy_n(transform->inverse, 12, toObject);
        return;
    }
    bvh::worldToObjectAt(handle, time, toObject);
    math::invert(toObject, toWorld);
}

void matrix(RayState* state, uint32_t toWorld, float rows[12]) {
    constexpr float kIdentity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    std::copy_n(kIdentity, 12, rows);
    for (uint32_t i = 0; i < std::min(state->hit.transformCount, kMaxGraphDepth); ++i) {
        float world[12], object[12];
        matricesOf(state->hit.transforms[i], state->time, world, object);
        if (toWorld)
            math::multiply(rows, world, rows);
        else
            math::multiply(object, rows, rows);
    }
}

} // namespace

void bindClassic(ClassicLaunch& launch) {
    launch.outside = outside;
    launch.checkRay = checkRay;
    launch.matrix = matrix;
}

} // namespace sunstone::devlib
