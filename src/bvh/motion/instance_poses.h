// SPDX-License-Identifier: Apache-2.0
// Poses of an instance below motion transforms, for the bounds of instances in structures without
// motion keys. The box around a moving box that is then rotated is several times as large as the
// geometry needs; the boxes of the parts of a structure in each pose are tighter.
//
// A point c of the structure is at outer * M(x) * inner * c, where only M moves. At each end of a
// piece of M (motion_bounds_body.h) this is one matrix, a pose. Between two poses a point stays
// within the distance |p''| / 8 of its chord, which is 0 unless M turns.
//
// Compiled for the CPU (build/instance_bounds.cpp) and in the builder kernels of GPUs
// (gpu/build/instances.h).
#pragma once

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

#include "bvh/motion/motion_bounds_body.h"

namespace sunstone::bvh::moving {

// to = to * m
template <class Number>
SUNSTONE_ONCE inline void multiplyBy(double to[12], const Number m[12]) {
    for (int i = 0; i < 3; ++i) {
        double* const row = to + 4 * i;
        const double x = row[0], y = row[1], z = row[2];
        for (int j = 0; j < 4; ++j)
            row[j] = x * m[j] + y * m[4 + j] + z * m[8 + j] + (j == 3 ? row[3] : 0.0);
    }
}
inline void setIdentity(double m[12]) {
    for (int i = 0; i < 12; ++i)
        m[i] = i % 5 == 0 ? 1 : 0;
}

// The largest magnitudes of a matrix times points with these magnitudes, without cancellation.
SUNSTONE_ONCE inline Corner magnitudesOf(const double m[12], const Corner& of) {
    Corner r;
    for (int i = 0; i < 3; ++i)
        r.at[i] = __builtin_fabs(m[4 * i]) * of.at[0] + __builtin_fabs(m[4 * i + 1]) * of.at[1] +
                  __builtin_fabs(m[4 * i + 2]) * of.at[2] + __builtin_fabs(m[4 * i + 3]);
    return r;
}

class Poses {
public:
    // Structures of more poses keep the box of all of them: their parts would take too long.
    static constexpr unsigned kMost = 32;

    // From the instance's matrix through the transforms at `child`, which must be readable.
    Poses(const float objectToWorld[12], uint64_t child) {
        copy(objectToWorld, outer_, 12);
        setIdentity(inner_);
        for (int i = 0; isTransformTag(child & devlib::kTagMask); child = childOf(child), ++i) {
            const bool still = (child & devlib::kTagMask) == devlib::kTagStatic;
            known_ = i < kMaxTransformChain && (still || !motion_);
            if (!known_)
                return;
            if (still)
                multiplyBy(motion_ ? inner_ : outer_, staticMatrix(child));
            else
                motion_ = child;
        }
        structure_ = child;
    }

    // The handle of the structure; 0 if there are two motion transforms above it, or too many poses.
    uint64_t structure() const { return known_ && count() <= kMost ? structure_ : 0; }

    // Calls visit(pose) for each pose, a matrix of 12 floats, for a structure in the box from
    // `lower` to `upper`. `margin` gets the distance by which, along each axis, the instance may
    // leave the boxes of its parts in the poses; it includes rounding. False: there is no limit.
    template <class Visit>
    bool forEach(const float lower[3], const float upper[3], float margin[3],
                 const Visit& visit) const {
        const LinearBounds box = standing(lower, upper);
        Corner size = {{0, 0, 0}};
        double away = 0;
        Stage from = stageAt(0, 0, 0);
        show(from, box, size, visit);
        for (uint32_t key = 0; key < lastKey(); ++key) {
            const unsigned pieces = TransformPieces(motion_).piecesOf(key);
            for (unsigned i = 1; i <= pieces; ++i) {
                const Stage to = stageAt(key, key + 1, double(i) / pieces);
                away = most(away, deviation(from, to, box));
                show(to, box, size, visit);
                from = to;
            }
        }
        for (int i = 0; i < 3; ++i)
            margin[i] = float(away * length(outer_ + 4 * i, 3) + size.at[i] * 0x1p-19);
        return away < kInf;
    }

private:
    // M = turn * scale, and the quaternion of the turn.
    struct Stage {
        double turn[12], scale[12], quaternion[4];
    };

    static const float* staticMatrix(uint64_t handle) {
        return reinterpret_cast<const StaticTransform*>(handle & ~devlib::kTagMask)->transform;
    }
    uint32_t lastKey() const { return motion_ ? timesOf(motion_).last() : 0; }

    unsigned count() const {
        unsigned sum = 1;
        for (uint32_t key = 0; key < lastKey() && sum <= kMost; ++key)
            sum += TransformPieces(motion_).piecesOf(key);
        return sum;
    }

    SUNSTONE_ONCE Stage stageAt(uint32_t key, uint32_t second, double x) const {
        Stage s;
        setIdentity(s.turn);
        setIdentity(s.scale);
        for (double& each : s.quaternion)
            each = 0;
        if (!motion_)
            return s;
        const TransformPieces pieces(motion_);
        if (!pieces.isSrt()) {
            pieces.matrixAt(key, second, x, s.scale);
            return s;
        }
        const SrtNumbers numbers = pieces.srtAt(key, second, x);
        numbers.scale(s.scale);
        numbers.rotation(s.turn);
        copy(numbers.quaternion(), s.quaternion, 4);
        return s;
    }

    // Shows the pose, and adds the magnitudes of the numbers that rays are transformed with.
    template <class Visit>
    void show(const Stage& s, const LinearBounds& box, Corner& size, const Visit& visit) const {
        double m[12];
        copy(outer_, m, 12);
        multiplyBy(m, s.turn);
        multiplyBy(m, s.scale);
        multiplyBy(m, inner_);
        Corner of;
        for (int a = 0; a < 3; ++a)
            of.at[a] = most(__builtin_fabs(box.lower[0][a]), __builtin_fabs(box.upper[0][a]));
        of = magnitudesOf(inner_, of);
        of = magnitudesOf(s.scale, of);
        of = magnitudesOf(s.turn, of);
        of = magnitudesOf(outer_, of);
        float pose[12];
        for (int i = 0; i < 12; ++i)
            pose[i] = float(m[i]);
        for (int a = 0; a < 3; ++a)
            size.at[a] = most(size.at[a], of.at[a]);
        visit(pose);
    }

    // How far a point may leave its chord between two stages: |p''| / 8 for a constant c. Infinite
    // for rotations without a limited speed.
    SUNSTONE_ONCE double deviation(const Stage& from, const Stage& to,
                                   const LinearBounds& box) const {
        if (!TransformPieces(motion_).isSrt())
            return 0;
        const Turn turn(from.quaternion, to.quaternion);
        if (turn.rate == 0)
            return 0;
        double reach = 0, stretch = 0;
        for (int corner = 0; corner < 8; ++corner) {
            const Corner c = apply(inner_, cornerOf(box, 0, corner), true);
            const Corner w0 = apply(from.scale, c, true), w1 = apply(to.scale, c, true);
            reach = most(reach, most(length(w0.at, 3), length(w1.at, 3)));
            stretch = most(stretch, length(minus(w1, w0).at, 3));
        }
        const double away =
            ((turn.rate * turn.rate + turn.change) * reach + 2 * turn.rate * stretch) / 8;
        return away < 2 * reach ? away : kInf;
    }

    double outer_[12], inner_[12];
    uint64_t motion_ = 0, structure_ = 0; // handles
    bool known_ = true;
};

} // namespace sunstone::bvh::moving

#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
