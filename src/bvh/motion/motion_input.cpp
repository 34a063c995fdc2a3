// SPDX-License-Identifier: Apache-2.0
#include "bvh/motion/motion_input.h"

#include <algorithm>

namespace sunstone::bvh {
namespace {

// Sums boxes to take their mean.
struct BoxSum {
    double lower[3] = {}, upper[3] = {};

    void add(const float low[3], const float high[3]) {
        for (int a = 0; a < 3; ++a) {
            lower[a] += low[a];
            upper[a] += high[a];
        }
    }
    void mean(uint32_t count, float low[3], float high[3]) const {
        for (int a = 0; a < 3; ++a) {
            low[a] = float(lower[a] / count);
            high[a] = float(upper[a] / count);
        }
    }
};

} // namespace

MotionReader::MotionReader(const BuildInputs& inputs, uint32_t keys) : keys_(keys) {
    triangles_.reserve(inputs.triangles.size() * keys);
    for (TriangleInput input : inputs.triangles)
        for (uint32_t key = 0; key < keys; ++key) {
            input.vertices = input.keyVertices ? input.keyVertices[key] : nullptr;
            triangles_.emplace_back(input);
        }
    customs_.reserve(inputs.customs.size() * keys);
    for (CustomInput input : inputs.customs)
        for (uint32_t key = 0; key < keys; ++key) {
            input.aabbs = input.keyAabbs ? input.keyAabbs[key] : nullptr;
            customs_.emplace_back(input);
        }
}

void TriangleCheck::add(const float vertices[9]) {
    for (int i = 0; i < 9; ++i)
        usable_ = usable_ && usable(vertices[i]);
    if (!usable_ || hasArea_)
        return;
    hasArea_ = hasArea(vertices);
    if (started_ && !hasArea_) {
        float middle[9];
        for (int i = 0; i < 9; ++i)
            middle[i] = between(previous_[i], vertices[i], 0.5f);
        hasArea_ = hasArea(middle);
    }
    std::copy(vertices, vertices + 9, previous_);
    started_ = true;
}

bool MotionReader::triangleBox(uint32_t input, uint32_t triangle, float lower[3],
                               float upper[3]) const {
    TriangleCheck check;
    BoxSum sum;
    for (uint32_t key = 0; key < keys_; ++key) {
        float v[9];
        if (!triangles(input, key).readUnchecked(triangle, v))
            return false;
        check.add(v);
        float low[3], high[3];
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min({v[a], v[3 + a], v[6 + a]});
            high[a] = std::max({v[a], v[3 + a], v[6 + a]});
        }
        sum.add(low, high);
    }
    sum.mean(keys_, lower, upper);
    return check.active();
}

bool MotionReader::customBox(uint32_t input, uint32_t primitive, float lower[3],
                             float upper[3]) const {
    BoxSum sum;
    for (uint32_t key = 0; key < keys_; ++key) {
        if (!customs(input, key).read(primitive, lower, upper))
            return false;
        sum.add(lower, upper);
    }
    sum.mean(keys_, lower, upper);
    return true;
}

void meanBox(const KeyBounds* boxes, uint32_t keys, float lower[3], float upper[3]) {
    BoxSum sum;
    for (uint32_t key = 0; key < keys; ++key)
        sum.add(boxes[key].lower, boxes[key].upper);
    sum.mean(keys, lower, upper);
}

} // namespace sunstone::bvh
