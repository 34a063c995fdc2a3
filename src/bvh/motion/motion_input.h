// SPDX-License-Identifier: Apache-2.0
// Reads build inputs with motion keys. A primitive is active if it is usable at all keys and, if it
// is a triangle, has an area at some time (at a key, or between two: the area's normal is a
// quadratic function of time, which is zero everywhere if it is at both ends and in the middle).
#pragma once

#include "bvh/input/build_input.h"
#include "bvh/motion/motion.h"

#include <vector>

namespace sunstone::bvh {

class MotionReader {
public:
    MotionReader(const BuildInputs& inputs, uint32_t keys);

    uint32_t keys() const { return keys_; }

    const TriangleReader& triangles(uint32_t input, uint32_t key) const {
        return triangles_[size_t(input) * keys_ + key];
    }
    const CustomReader& customs(uint32_t input, uint32_t key) const {
        return customs_[size_t(input) * keys_ + key];
    }

    // Whether the primitive is active. If so, computes the mean of its boxes at the keys, which
    // tree builders use as the primitive's box.
    bool triangleBox(uint32_t input, uint32_t triangle, float lower[3], float upper[3]) const;
    bool customBox(uint32_t input, uint32_t primitive, float lower[3], float upper[3]) const;

private:
    uint32_t keys_;
    std::vector<TriangleReader> triangles_;
    std::vector<CustomReader> customs_;
};

// The mean of boxes at `keys` keys.
void meanBox(const KeyBounds* boxes, uint32_t keys, float lower[3], float upper[3]);

// Collects a triangle's vertices key by key and decides whether it is active.
class TriangleCheck {
public:
    void add(const float vertices[9]);
    bool active() const { return usable_ && hasArea_; }

private:
    float previous_[9];
    bool started_ = false, usable_ = true, hasArea_ = false;
};

} // namespace sunstone::bvh
