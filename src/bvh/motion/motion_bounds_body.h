// SPDX-License-Identifier: Apache-2.0
// Bounds under motion transforms. Time is cut into pieces at the keys; pieces of SRT transforms
// with rotation are cut further. Within a piece of length 1, a corner of the child's box is at p(x)
// = M(x) c(x), where M (except for the rotation) and c are linear. p stays within max|p''| / 8 of
// its chord: for matrices p'' = 2 dM dc exactly; with rotation (R the rotation, w = S c + pv)
//   |p''| <= (omega^2 + omega') |w| + 2 omega |w'| + |w''|,
// omega being the rate of turn. A normalised sum of quaternions turns about one axis at the rate 2
// |q0 ^ q1| / |q(x)|^2. The bounds of a piece are those of all chords, widened by this deviation.
// One pair of linear bounds for all pieces is the line through the ends, shifted until it clears
// every piece.
//
// Compiled for the CPU (motion_bounds.cpp) and in the builder kernels of GPUs
// (gpu/build/instances.h). The caller must have checked that all memory from a handle to the first
// structure is readable.
#pragma once

#if defined(__CUDA__)
#pragma clang force_cuda_host_device begin
#endif

#include "bvh/motion/transforms.h"

// Kernels of a GPU contain each such function once: inlined at each use, they took its compiler ten
// seconds (docs/notes/compile-time.md has figures).
#if defined(__NVPTX__)
#define SUNSTONE_ONCE __attribute__((noinline))
#else
#define SUNSTONE_ONCE
#endif

namespace sunstone::bvh {

// Bounds that move linearly over a range of time, from lower[0], upper[0] to lower[1], upper[1].
// Empty if lower > upper.
struct LinearBounds {
    double lower[2][3], upper[2][3];

    static LinearBounds nothing() {
        LinearBounds r;
        for (int end = 0; end < 2; ++end)
            for (int a = 0; a < 3; ++a) {
                r.lower[end][a] = __builtin_inf();
                r.upper[end][a] = -__builtin_inf();
            }
        return r;
    }
    bool empty() const { return !(lower[0][0] <= upper[0][0]); }
};

namespace moving {

constexpr double kInf = __builtin_inf();
// Pieces with larger rotations, in radians, are cut.
constexpr double kPieceAngle = 0.2;
constexpr unsigned kMaxPieces = 64;

// The times of the keys of a structure of instances.
struct MotionTimes {
    uint32_t keys;
    float begin, end;
};

inline double least(double a, double b) {
    return b < a ? b : a;
}
inline double most(double a, double b) {
    return a < b ? b : a;
}
inline double within(double a, double low, double high) {
    return a < low ? low : high < a ? high : a;
}
template <class From, class To>
inline void copy(const From* from, To* to, int count) {
    for (int i = 0; i < count; ++i)
        to[i] = from[i];
}

// The angle of a cosine, to 0.0001 (Abramowitz and Stegun, Handbook of Mathematical Functions,
// 4.4.45). It only determines the number of pieces of a rotation.
inline double angleOf(double cosine) {
    const double x = __builtin_fabs(cosine);
    const double angle =
        __builtin_sqrt(1 - x) * (1.5707288 + x * (-0.2121144 + x * (0.0742610 - x * 0.0187293)));
    return cosine < 0 ? 3.14159265358979 - angle : angle;
}

struct Corner {
    double at[3];
};

inline double lerp(double a, double b, double x) {
    return a + (b - a) * x;
}

inline double length(const double* v, int n) {
    double sum = 0;
    for (int i = 0; i < n; ++i)
        sum += v[i] * v[i];
    return __builtin_sqrt(sum);
}

// The time range of an object with keys.
class KeyTimes {
public:
    KeyTimes(uint32_t keys, float begin, float end) : keys_(keys), begin_(begin), end_(end) {}

    // Whether the time range is usable; otherwise keySegment() may return any key.
    bool moves() const { return keys_ > 1 && begin_ < end_ && __builtin_isfinite(end_ - begin_); }
    // Key and fraction as one number, 0 .. keys - 1. Only with motion, as in the following
    // functions.
    double place(double time) const {
        return within((time - begin()) / (end() - begin()) * last(), 0.0, double(last()));
    }
    double timeOf(uint32_t key) const { return begin() + (end() - begin()) * key / last(); }
    double begin() const { return begin_; }
    double end() const { return end_; }
    uint32_t last() const { return keys_ > 1 ? keys_ - 1 : 0; }

private:
    uint32_t keys_;
    float begin_, end_;
};

// Grows linear bounds until they contain others that are valid over a part [x0, x1] of the range.
class Hull {
public:
    explicit Hull(const LinearBounds& ends) : bounds_(ends) {}

    void add(double x0, double x1, const LinearBounds& part) {
        for (int end = 0; end < 2; ++end)
            for (int a = 0; a < 3; ++a) {
                const double x = end ? x1 : x0;
                below_[a] = most(below_[a], lerp(bounds_.lower[0][a], bounds_.lower[1][a], x) -
                                                part.lower[end][a]);
                above_[a] = most(above_[a], part.upper[end][a] -
                                                lerp(bounds_.upper[0][a], bounds_.upper[1][a], x));
            }
    }
    LinearBounds result() const {
        LinearBounds r = bounds_;
        for (int end = 0; end < 2; ++end)
            for (int a = 0; a < 3; ++a) {
                r.lower[end][a] -= below_[a];
                r.upper[end][a] += above_[a];
            }
        return r;
    }

private:
    LinearBounds bounds_;
    double below_[3] = {}, above_[3] = {};
};

inline LinearBounds slice(const LinearBounds& b, double x0, double x1) {
    LinearBounds r;
    for (int a = 0; a < 3; ++a) {
        r.lower[0][a] = lerp(b.lower[0][a], b.lower[1][a], x0);
        r.lower[1][a] = lerp(b.lower[0][a], b.lower[1][a], x1);
        r.upper[0][a] = lerp(b.upper[0][a], b.upper[1][a], x0);
        r.upper[1][a] = lerp(b.upper[0][a], b.upper[1][a], x1);
    }
    return r;
}

inline LinearBounds standing(const float lower[3], const float upper[3]) {
    LinearBounds r;
    for (int end = 0; end < 2; ++end)
        for (int a = 0; a < 3; ++a) {
            r.lower[end][a] = lower[a];
            r.upper[end][a] = upper[a];
        }
    return r.empty() ? LinearBounds::nothing() : r;
}

inline Corner cornerOf(const LinearBounds& b, int end, int corner) {
    Corner c;
    for (int a = 0; a < 3; ++a)
        c.at[a] = corner >> a & 1 ? b.upper[end][a] : b.lower[end][a];
    return c;
}

// m times a point (with the translation) or times a vector.
inline Corner apply(const double m[12], const Corner& c, bool point) {
    Corner r;
    for (int i = 0; i < 3; ++i)
        r.at[i] = m[4 * i] * c.at[0] + m[4 * i + 1] * c.at[1] + m[4 * i + 2] * c.at[2] +
                  (point ? m[4 * i + 3] : 0.0);
    return r;
}

inline Corner minus(const Corner& a, const Corner& b) {
    return {{a.at[0] - b.at[0], a.at[1] - b.at[1], a.at[2] - b.at[2]}};
}

// Collects the chords of a piece.
class Chords {
public:
    // Adds the chord from p0 to p1; the path deviates from it by up to `low` below and `high`
    // above.
    void add(const Corner& p0, const Corner& p1, const Corner& low, const Corner& high) {
        for (int a = 0; a < 3; ++a)
            for (int end = 0; end < 2; ++end) {
                const double p = (end ? p1 : p0).at[a];
                r_.lower[end][a] = least(r_.lower[end][a], p - low.at[a]);
                r_.upper[end][a] = most(r_.upper[end][a], p + high.at[a]);
            }
    }
    LinearBounds result() const { return r_; }

private:
    LinearBounds r_ = LinearBounds::nothing();
};

// One piece of a matrix transform: M from m0 to m1, the child's bounds from their first to their
// second end.
inline LinearBounds matrixPiece(const double m0[12], const double m1[12],
                                const LinearBounds& child) {
    double dm[12];
    for (int i = 0; i < 12; ++i)
        dm[i] = m1[i] - m0[i];
    Chords chords;
    for (int corner = 0; corner < 8; ++corner) {
        const Corner c0 = cornerOf(child, 0, corner), c1 = cornerOf(child, 1, corner);
        // p(x) = chord - x (1 - x) d
        const Corner d = apply(dm, minus(c1, c0), false);
        Corner low, high;
        for (int a = 0; a < 3; ++a) {
            low.at[a] = most(d.at[a], 0.0) / 4;
            high.at[a] = most(-d.at[a], 0.0) / 4;
        }
        chords.add(apply(m0, c0, true), apply(m1, c1, true), low, high);
    }
    return chords.result();
}

struct SrtNumbers {
    double v[16];

    explicit SrtNumbers(const SrtKey& key) {
        const float* numbers = &key.sx;
        for (int i = 0; i < 16; ++i)
            v[i] = numbers[i];
    }
    SrtNumbers(const SrtNumbers& a, const SrtNumbers& b, double x) {
        for (int i = 0; i < 16; ++i)
            v[i] = lerp(a.v[i], b.v[i], x);
    }
    const double* quaternion() const { return v + 9; }
    const double* translation() const { return v + 13; }
    // S with the pivot.
    void scale(double m[12]) const {
        const double s[12] = {v[0], v[1], v[2], v[3], 0, v[4], v[5], v[6], 0, 0, v[7], v[8]};
        copy(s, m, 12);
    }
    // T * R
    void rotation(double m[12]) const {
        const double* q = quaternion();
        const double n = 1 / length(q, 4);
        const double x = q[0] * n, y = q[1] * n, z = q[2] * n, w = q[3] * n;
        const double r[12] = {
            1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),     v[13],
            2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),     v[14],
            2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y), v[15]};
        copy(r, m, 12);
    }
};

inline double dot4(const double* a, const double* b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

// The speed of the rotation between two quaternions over a piece of length 1.
struct Turn {
    double rate = 0, change = 0; // bounds of omega and omega'

    Turn(const double* q0, const double* q1) {
        double step[4];
        for (int i = 0; i < 4; ++i)
            step[i] = q1[i] - q0[i];
        const double aa = dot4(q0, q0), bb = dot4(q1, q1), ab = dot4(q0, q1), ss = dot4(step, step);
        const double area = __builtin_sqrt(most(aa * bb - ab * ab, 0.0));
        if (area == 0 && ab >= 0)
            return;
        const double nearest = ss > 0 ? within(-dot4(q0, step) / ss, 0.0, 1.0) : 0.0;
        const double least = aa + 2 * nearest * dot4(q0, step) + nearest * nearest * ss;
        const double slope =
            2 * most(__builtin_fabs(dot4(q0, step)), __builtin_fabs(dot4(q1, step)));
        rate = 2 * area / least;
        change = rate * slope / least;
        if (!(least > 0) || area == 0)
            rate = change = kInf;
    }
};

inline LinearBounds srtPiece(const SrtNumbers& k0, const SrtNumbers& k1,
                             const LinearBounds& child) {
    double s0[12], s1[12], r0[12], r1[12], ds[12];
    k0.scale(s0), k1.scale(s1);
    k0.rotation(r0), k1.rotation(r1);
    for (int i = 0; i < 12; ++i)
        ds[i] = s1[i] - s0[i];
    const Turn turn(k0.quaternion(), k1.quaternion());
    Chords chords;
    for (int corner = 0; corner < 8; ++corner) {
        const Corner c0 = cornerOf(child, 0, corner), c1 = cornerOf(child, 1, corner);
        const Corner w0 = apply(s0, c0, true), w1 = apply(s1, c1, true);
        const Corner dw = minus(w1, w0), bend = apply(ds, minus(c1, c0), false);
        const double curve = length(bend.at, 3); // w'' / 2
        const double reach = most(length(w0.at, 3), length(w1.at, 3)) + curve / 4;
        const double away = ((turn.rate * turn.rate + turn.change) * reach +
                             2 * turn.rate * (length(dw.at, 3) + curve) + 2 * curve) /
                            8;
        if (away < 2 * reach || (turn.rate == 0 && __builtin_isfinite(away))) {
            const Corner margin = {{away, away, away}};
            chords.add(apply(r0, w0, true), apply(r1, w1, true), margin, margin);
        } else { // anywhere around the pivot's image
            const Corner margin = {{reach, reach, reach}};
            const double *t0 = k0.translation(), *t1 = k1.translation();
            chords.add({{t0[0], t0[1], t0[2]}}, {{t1[0], t1[1], t1[2]}}, margin, margin);
        }
    }
    return chords.result();
}

// The pieces of a motion transform between two places among its keys.
class TransformPieces {
public:
    explicit TransformPieces(uint64_t transform)
        : isSrt_((transform & devlib::kTagMask) == devlib::kTagSrtMotion),
          address_(transform & ~devlib::kTagMask) {}

    // Calls visit(place0, place1, bounds) for every piece, where child(place0, place1) gives the
    // child's bounds over it.
    template <class Child, class Visit>
    void forEach(double from, double to, const Child& child, const Visit& visit) const {
        double at = from;
        do {
            const double next = least(__builtin_floor(at) + 1, to);
            const uint32_t key = uint32_t(at);
            // At the last key there is no next key.
            const uint32_t second = to > at ? key + 1 : key;
            const unsigned pieces = second != key ? piecesOf(key) : 1;
            for (unsigned i = 0; i < pieces; ++i) {
                const double a = lerp(at, next, double(i) / pieces);
                const double b = i + 1 == pieces ? next : lerp(at, next, double(i + 1) / pieces);
                visit(a, b, piece(key, second, a - key, b - key, child(a, b)));
            }
            at = next;
        } while (at < to);
    }

    bool isSrt() const { return isSrt_; }

    // The number of pieces from a key to the next one.
    unsigned piecesOf(uint32_t key) const {
        if (!isSrt_)
            return 1;
        const SrtNumbers a(srt(key)), b(srt(key + 1));
        const double product = length(a.quaternion(), 4) * length(b.quaternion(), 4);
        const double cosine = dot4(a.quaternion(), b.quaternion()) / product;
        const double angle = 2 * angleOf(within(cosine, -1.0, 1.0));
        const double pieces = __builtin_ceil(angle / kPieceAngle);
        return pieces >= 1 ? unsigned(least(pieces, kMaxPieces)) : 1;
    }

    // The transform between two keys.
    SrtNumbers srtAt(uint32_t key, uint32_t second, double x) const {
        return SrtNumbers(SrtNumbers(srt(key)), SrtNumbers(srt(second)), x);
    }
    void matrixAt(uint32_t key, uint32_t second, double x, double m[12]) const {
        const float* keys = reinterpret_cast<const MatrixMotionTransform*>(address_)->matrices[0];
        for (int i = 0; i < 12; ++i)
            m[i] = lerp(keys[12 * key + i], keys[12 * second + i], x);
    }

private:
    const SrtKey& srt(uint32_t key) const {
        return reinterpret_cast<const SrtMotionTransform*>(address_)->keys[key];
    }

    SUNSTONE_ONCE LinearBounds piece(uint32_t key, uint32_t second, double x0, double x1,
                                     const LinearBounds& child) const {
        if (isSrt_)
            return srtPiece(srtAt(key, second, x0), srtAt(key, second, x1), child);
        double m0[12], m1[12];
        matrixAt(key, second, x0, m0);
        matrixAt(key, second, x1, m1);
        return matrixPiece(m0, m1, child);
    }

    bool isSrt_;
    uint64_t address_;
};

inline KeyTimes timesOf(uint64_t transform) {
    const MotionRange& motion = motionOf(transform);
    return {motion.keys, motion.begin, motion.end};
}
inline KeyTimes timesOf(const BlockHeader& header) {
    return {header.motionKeys, header.motionBegin, header.motionEnd};
}

inline const KeyBounds* keyBoundsOf(const BlockHeader& header) {
    return reinterpret_cast<const KeyBounds*>(reinterpret_cast<const uint8_t*>(&header) +
                                              header.keyBoundsOffset);
}

// Bounds at a place among the keys of a structure.
inline void boundsAt(const BlockHeader& header, double place, double lower[3], double upper[3]) {
    const uint32_t last = header.motionKeys - 2;
    const uint32_t key = uint32_t(place) < last ? uint32_t(place) : last;
    const KeyBounds* keys = keyBoundsOf(header) + key;
    for (int a = 0; a < 3; ++a) {
        lower[a] = lerp(keys[0].lower[a], keys[1].lower[a], place - key);
        upper[a] = lerp(keys[0].upper[a], keys[1].upper[a], place - key);
    }
}

inline LinearBounds blockBounds(const BlockHeader& header, double begin, double end) {
    const KeyTimes times = timesOf(header);
    if (!isMoving(header.type) || header.numActive == 0 || !times.moves())
        return standing(header.lower, header.upper);
    const auto at = [&](double time) SUNSTONE_ONCE {
        LinearBounds here;
        for (int side = 0; side < 2; ++side)
            boundsAt(header, times.place(time), here.lower[side], here.upper[side]);
        return here;
    };
    LinearBounds ends = at(begin);
    boundsAt(header, times.place(end), ends.lower[1], ends.upper[1]);
    Hull hull(ends);
    const auto add = [&](double time) {
        if (time > begin && time < end) {
            const double x = (time - begin) / (end - begin);
            hull.add(x, x, at(time));
        }
    };
    add(times.begin()); // before and after, bounds are constant
    add(times.end());
    const double last = times.place(end);
    for (uint32_t key = uint32_t(times.place(begin)) + 1; key < last; ++key)
        add(times.timeOf(key));
    return hull.result();
}

// Bounds valid at any time, for a transform whose keys have no usable range.
SUNSTONE_ONCE inline LinearBounds throughAllKeys(uint64_t transform, const LinearBounds& child) {
    LinearBounds still = child;
    for (int a = 0; a < 3; ++a) {
        still.lower[0][a] = still.lower[1][a] = least(child.lower[0][a], child.lower[1][a]);
        still.upper[0][a] = still.upper[1][a] = most(child.upper[0][a], child.upper[1][a]);
    }
    LinearBounds all = LinearBounds::nothing();
    TransformPieces(transform).forEach(
        0, timesOf(transform).last(), [&](double, double) { return still; },
        [&](double, double, const LinearBounds& part) {
            for (int end = 0; end < 2; ++end)
                for (int a = 0; a < 3; ++a) {
                    all.lower[end][a] =
                        least(all.lower[end][a], least(part.lower[0][a], part.lower[1][a]));
                    all.upper[end][a] =
                        most(all.upper[end][a], most(part.upper[0][a], part.upper[1][a]));
                }
        });
    return all;
}

// Bounds under a motion transform, valid over [begin, end], from those of its child.
SUNSTONE_ONCE inline LinearBounds throughMotion(uint64_t transform, double begin, double end,
                                                const LinearBounds& child) {
    const KeyTimes times = timesOf(transform);
    if (!times.moves())
        return throughAllKeys(transform, child);
    const TransformPieces pieces(transform);
    const auto share = [&](double time) {
        return end > begin ? within((time - begin) / (end - begin), 0.0, 1.0) : 0.0;
    };
    // Calls visit(x0, x1, bounds) for each piece of [time0, time1], in which the keys are constant
    // or change from `from` to `to`.
    const auto walkPart = [&](double time0, double time1, const auto& visit) {
        const double from = times.place(time0), to = times.place(time1);
        const double x0 = share(time0), x1 = share(time1);
        const auto shareOf = [&](double place, double otherwise) {
            return to > from ? lerp(x0, x1, (place - from) / (to - from)) : otherwise;
        };
        pieces.forEach(
            from, to,
            [&](double a, double b) { return slice(child, shareOf(a, x0), shareOf(b, x1)); },
            [&](double a, double b, const LinearBounds& part) {
                visit(shareOf(a, x0), shareOf(b, x1), part);
            });
    };
    const double first = within(times.begin(), begin, end);
    const double second = within(times.end(), first, end);
    const double parts[] = {begin, first, second, end};
    const auto walk = [&](const auto& visit) {
        for (int i = 0; i < 3; ++i)
            if (i == 1 || parts[i] < parts[i + 1])
                walkPart(parts[i], parts[i + 1], visit);
    };
    LinearBounds ends = LinearBounds::nothing();
    bool started = false;
    walk([&](double, double, const LinearBounds& part) {
        if (!started)
            ends = part;
        started = true;
        copy(part.lower[1], ends.lower[1], 3);
        copy(part.upper[1], ends.upper[1], 3);
    });
    Hull hull(ends);
    walk([&](double x0, double x1, const LinearBounds& part) { hull.add(x0, x1, part); });
    return hull.result();
}

SUNSTONE_ONCE inline LinearBounds throughMatrix(const float m[12], const LinearBounds& child) {
    double matrix[12];
    copy(m, matrix, 12);
    return matrixPiece(matrix, matrix, child);
}

// Bounds of the handle's object, in its space, at all times of [begin, end]; or of a part of the
// structure below, in which it does not move.
SUNSTONE_ONCE inline LinearBounds boundsOf(uint64_t handle, double begin, double end,
                                           const LinearBounds* part = nullptr) {
    uint64_t chain[kMaxTransformChain];
    int length = 0;
    for (; isTransformTag(handle & devlib::kTagMask); handle = childOf(handle)) {
        if (length == kMaxTransformChain)
            return LinearBounds::nothing();
        chain[length++] = handle;
    }
    const uint64_t tag = handle & devlib::kTagMask;
    if (tag != devlib::kTagGas && tag != devlib::kTagIas)
        return LinearBounds::nothing();
    LinearBounds b =
        part ? *part
             : blockBounds(*reinterpret_cast<const BlockHeader*>(handle & ~devlib::kTagMask), begin,
                           end);
    while (length-- > 0 && !b.empty()) {
        const uint64_t transform = chain[length];
        b = (transform & devlib::kTagMask) == devlib::kTagStatic
                ? throughMatrix(
                      reinterpret_cast<const StaticTransform*>(transform & ~devlib::kTagMask)
                          ->transform,
                      b)
                : throughMotion(transform, begin, end, b);
    }
    return b;
}

// Widens a range of time to the ranges of all motion below the handle.
inline void addTimes(uint64_t handle, double& begin, double& end) {
    for (int depth = 0; depth < kMaxTransformChain; ++depth) {
        const uint64_t tag = handle & devlib::kTagMask;
        const auto include = [&](const KeyTimes& times) {
            if (!times.moves())
                return;
            begin = least(begin, times.begin());
            end = most(end, times.end());
        };
        if (tag == devlib::kTagGas || tag == devlib::kTagIas) {
            const auto& header = *reinterpret_cast<const BlockHeader*>(handle & ~devlib::kTagMask);
            if (isMoving(header.type))
                include(timesOf(header));
            return;
        }
        if (!isTransformTag(tag))
            return;
        if (tag != devlib::kTagStatic)
            include(timesOf(handle));
        handle = childOf(handle);
    }
}

// Extends a key's bounds, in floats, with a margin for the rounding of transformed rays.
inline void extend(KeyBounds& key, const LinearBounds& b, int end) {
    for (int a = 0; a < 3; ++a) {
        const double margin =
            most(__builtin_fabs(b.lower[end][a]), __builtin_fabs(b.upper[end][a])) * 0x1p-20;
        key.lower[a] = float(least(key.lower[a], float(b.lower[end][a] - margin)));
        key.upper[a] = float(most(key.upper[a], float(b.upper[end][a] + margin)));
    }
}

// Bounds of a box through a motion transform, at all times.
inline KeyBounds atAllTimes(uint64_t transform, const float lower[3], const float upper[3]) {
    KeyBounds key = kNoBounds;
    const LinearBounds box = standing(lower, upper);
    if (!box.empty())
        extend(key, throughAllKeys(transform, box), 0);
    return key;
}

// Whether a transform between the handle and the first structure, or that structure, has motion.
inline bool moves(uint64_t handle) {
    double earliest = kInf, latest = -kInf;
    addTimes(handle, earliest, latest);
    return earliest <= latest;
}

// Unites bounds with others.
inline void unite(LinearBounds& to, const LinearBounds& with) {
    for (int end = 0; end < 2; ++end)
        for (int a = 0; a < 3; ++a) {
            to.lower[end][a] = least(to.lower[end][a], with.lower[end][a]);
            to.upper[end][a] = most(to.upper[end][a], with.upper[end][a]);
        }
}

// The bounds of an instance at each key of its structure, see describeMotion in motion_bounds.h.
// forEachPart(visit) calls visit(part) for the parts of the instance: constant bounds in its
// structure, or once null for all of it.
template <class ForEachPart>
SUNSTONE_ONCE inline void describeParts(const InstanceRecord& record, const MotionTimes& motion,
                                        KeyBounds* keys, const ForEachPart& forEachPart) {
    for (uint32_t k = 0; k < motion.keys; ++k)
        keys[k] = kNoBounds;
    double earliest = motion.begin, latest = motion.end;
    addTimes(record.child, earliest, latest);
    const auto over = [&](double begin, double end) SUNSTONE_ONCE {
        LinearBounds all = LinearBounds::nothing();
        forEachPart([&](const LinearBounds* part) {
            unite(all,
                  throughMatrix(record.objectToWorld, boundsOf(record.child, begin, end, part)));
        });
        return all;
    };
    const uint32_t last = motion.keys - 1;
    const auto timeOf = [&](uint32_t key) {
        return motion.begin + (double(motion.end) - motion.begin) * key / last;
    };
    for (uint32_t k = 0; k < last; ++k) {
        const LinearBounds part = over(timeOf(k), timeOf(k + 1));
        extend(keys[k], part, 0);
        extend(keys[k + 1], part, 1);
    }
    // Outside its range the structure uses the outermost keys, but its children keep moving.
    if (earliest < motion.begin) {
        const LinearBounds part = over(earliest, motion.begin);
        extend(keys[0], part, 0);
        extend(keys[0], part, 1);
    }
    if (latest > motion.end) {
        const LinearBounds part = over(motion.end, latest);
        extend(keys[last], part, 0);
        extend(keys[last], part, 1);
    }
}
inline void describe(const InstanceRecord& record, const MotionTimes& motion, KeyBounds* keys) {
    describeParts(record, motion, keys, [](const auto& visit) { visit(nullptr); });
}

} // namespace moving
} // namespace sunstone::bvh

#if defined(__CUDA__)
#pragma clang force_cuda_host_device end
#endif
