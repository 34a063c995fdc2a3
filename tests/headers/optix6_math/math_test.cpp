// SPDX-License-Identifier: Apache-2.0
// The classic API's mathematics, compiled for the host and run there, and compiled to PTX and run
// by the CUDA driver of the CPU: each function with many random arguments against judge.h, the
// members of the classes against the manual.
#include "calls.h"
#include "judge.h"
#include "members.h"

#include <optixu/optixu_math_stream.h>

#include <cuda.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <random>
#include <set>
#include <sstream>

namespace math {
namespace {

const int kTrials = 48; // of each function

const std::vector<Case>& cases() {
    static const std::vector<Case> list = {
#include "cases.inc"
    };
    return list;
}

// ---- Arguments ----------------------------------------------------------------------------------

class Arguments {
public:
    explicit Arguments(unsigned seed) : engine_(seed) {}

    Values of(const Case& c) {
        Values values;
        for (const Type& type : c.parameters) {
            Reals components(type.size());
            for (Real& r : components)
                r = component(c, type);
            values.push_back(components);
        }
        adjust(c, values);
        return values;
    }

private:
    Real uniform(double low, double high) {
        return static_cast<float>(std::uniform_real_distribution<>(low, high)(engine_));
    }
    bool coin() { return engine_() % 2 == 0; }

    // No component is 0: each may be a divisor. Products fit into their types and need all bits.
    Real component(const Case& c, const Type& type) {
        const bool truncates = c.name.compare(0, 5, "make_") == 0;
        switch (type.scalar) {
        case Type::kFloat:
            if (unitInterval().count(c.name))
                return uniform(0, 1);
            return uniform(0.25, truncates ? 1000 : 4) *
                   (coin() && c.name.find("make_u") == std::string::npos ? -1 : 1);
        case Type::kInt:
            return Real(1 + engine_() % 40000) * (coin() ? -1 : 1);
        case Type::kUint:
            return Real(1 + engine_() % 65000);
        case Type::kLongLong:
            return Real(1 + engine_() % 3000000000u) * (coin() ? -1 : 1);
        default:
            return Real(1 + engine_() % 4200000000u);
        }
    }

    static const std::set<std::string>& unitInterval() {
        static const std::set<std::string> names = {"cosine_sample_hemisphere", "square_to_disk",
                                                    "temperature", "fresnel_schlick"};
        return names;
    }

    static void makeUnit(Reals& v) {
        Real squares = 0;
        for (Real r : v)
            squares += r * r;
        for (Real& r : v)
            r = static_cast<float>(r / std::sqrt(squares));
    }

    void adjust(const Case& c, Values& v) {
        if (c.name == "getByIndex" || c.name == "setByIndex")
            v[1][0] = Real(engine_() % (v[0].size() + 1)); // one beyond the last too
        if (c.name == "int_as_float")
            v[0][0] = v[0][0] * 50000 + (v[0][0] < 0 ? -10000000 : 0); // finite, of both signs
        if (c.name == "reflect")
            makeUnit(v[1]);
        if (c.name.find("lerp") != std::string::npos)
            for (size_t i = v.size() - (c.name == "bilerp" ? 2 : 1); i < v.size(); ++i)
                v[i][0] = uniform(0, 1);
        if (c.name == "refract") {
            makeUnit(v[1]);
            makeUnit(v[2]);
            v[3][0] = std::fabs(v[3][0]);
        }
        if (c.name == "fresnel_schlick") // minimum below maximum
            for (size_t i = 0; i < v[2].size(); ++i)
                v[3][i] += 1;
        if (c.name == "smoothstep")
            v[1][0] = v[0][0] + std::fabs(v[1][0]);
        if (c.name.compare(0, 18, "intersect_triangle") == 0)
            aim(v);
        if (c.parameters[0].name == "optix::Quaternion")
            makeUnit(v[0]);
        if (c.name == "operator==" || c.name == "operator!=")
            if (coin())
                v[1] = v[0];
    }

    // A ray to a point in or near the triangle; tmin and tmax leave some of the hits out.
    void aim(Values& v) {
        const Real beta = uniform(-0.25, 1), gamma = uniform(-0.25, 1);
        for (int i = 0; i < 3; ++i)
            v[0][3 + i] = static_cast<float>(v[1][i] + beta * (v[2][i] - v[1][i]) +
                                             gamma * (v[3][i] - v[1][i]) - v[0][i]);
        v[0][6] = 1;
        v[0][7] = coin() ? 1.5 : 0;
        v[0][8] = coin() ? 0.5 : 8;
    }

    std::mt19937 engine_;
};

// ---- Comparison
// -----------------------------------------------------------------------------------

Real value(const Type& type, const Number& number) {
    if (type.isFloat())
        return number.real;
    return type.scalar == Type::kUlongLong ? Real(static_cast<unsigned long long>(number.whole))
                                           : Real(number.whole);
}

void store(const Type& type, const Reals& from, Number* to) {
    const bool ray = type.name == "optix::Ray";
    for (size_t i = 0; i < from.size(); ++i) {
        to[i].real = static_cast<double>(from[i]);
        if (!type.isFloat() || (ray && i == 6))
            to[i].whole = type.scalar == Type::kUlongLong
                              ? static_cast<long long>(static_cast<unsigned long long>(from[i]))
                              : static_cast<long long>(from[i]);
    }
}

Real squares(const Reals& v, size_t from, size_t count) {
    Real sum = 0;
    for (size_t i = from; i < from + count; ++i)
        sum += v[i] * v[i];
    return sum;
}

// Whether rounding of the arguments decides, so that both answers are correct.
bool undecided(const Case& c, const Values& v, const Values& want) {
    if (c.name == "refract") {
        Real along = 0;
        for (int i = 0; i < 3; ++i)
            along += v[1][i] * v[2][i];
        const Real eta = along > 0 ? v[3][0] : 1 / v[3][0];
        return std::fabs(along) < 1e-3 || std::fabs(1 - eta * eta * (1 - along * along)) < 1e-2;
    }
    if (c.name.compare(0, 18, "intersect_triangle") != 0)
        return false;
    const Real t = want[2][0], beta = want[3][0], gamma = want[4][0];
    for (Real margin : {beta, gamma, 1 - beta - gamma, t - v[0][7], v[0][8] - t})
        if (std::fabs(margin) < 1e-3)
            return true;
    Real towards = 0; // nearly in the plane of the triangle, or a triangle without an area
    for (int i = 0; i < 3; ++i)
        towards += want[1][i] * v[0][3 + i];
    return towards * towards < 0.05 * squares(want[1], 0, 3) * squares(v[0], 3, 3) ||
           squares(want[1], 0, 3) < 1;
}

// Whether the results of a call are correct; the text names what is wrong.
bool agrees(const Case& c, const Values& want, const Number* out, std::string& text) {
    const bool intersects = c.name.compare(0, 18, "intersect_triangle") == 0;
    const bool early = c.name == "intersect_triangle_earlyexit" && want[0][0] == 0;
    for (size_t i = 0; i < want.size(); ++i)
        for (Real w : want[i]) {
            const Real got = value(c.results[i], *out++);
            const Real relative = intersects ? 4e-5 : 2e-6;
            const Real tolerance =
                c.results[i].isFloat() ? relative * std::max(Real(4), std::fabs(w)) : 0;
            if ((early && i > 1) || std::fabs(got - w) <= tolerance)
                continue;
            text = c.name + " " + c.signature + ", result " + std::to_string(i) + ": " +
                   std::to_string(got) + " instead of " + std::to_string(w);
            return false;
        }
    return true;
}

// All calls of a run: arguments and places for results, kMostNumbers for each call.
struct Calls {
    explicit Calls(unsigned seed) {
        Arguments arguments(seed);
        for (size_t k = 0; k < cases().size(); ++k)
            for (int trial = 0; trial < kTrials; ++trial) {
                indices.push_back(int(k));
                values.push_back(arguments.of(cases()[k]));
                in.resize(in.size() + kMostNumbers);
                Number* to = in.data() + in.size() - kMostNumbers;
                for (size_t i = 0; i < values.back().size(); ++i) {
                    store(cases()[k].parameters[i], values.back()[i], to);
                    to += values.back()[i].size();
                }
            }
        out.resize(in.size());
    }

    void check() const {
        for (size_t k = 0; k < cases().size(); ++k) {
            const Case& c = cases()[k];
            int compared = 0;
            for (int trial = 0; trial < kTrials; ++trial) {
                const size_t i = k * kTrials + trial;
                const Values want = expected(c, values[i]);
                ASSERT_EQ(want.size(), c.results.size()) << c.name;
                for (size_t r = 0; r < want.size(); ++r)
                    ASSERT_EQ(int(want[r].size()), c.results[r].size()) << c.name;
                if (undecided(c, values[i], want))
                    continue;
                ++compared;
                std::string text;
                if (!agrees(c, want, out.data() + i * kMostNumbers, text)) {
                    ADD_FAILURE() << text;
                    break;
                }
            }
            EXPECT_GE(compared, 1) << c.name;
        }
    }

    std::vector<int> indices;
    std::vector<Values> values;
    std::vector<Number> in, out;
};

unsigned seed() {
    const unsigned seed = std::random_device{}();
    std::printf("seed %u\n", seed);
    return seed;
}

// ---- Device
// ---------------------------------------------------------------------------------------

class Device {
public:
    Device() {
        EXPECT_EQ(cuInit(0), CUDA_SUCCESS);
        EXPECT_EQ(cuDevicePrimaryCtxRetain(&context_, 0), CUDA_SUCCESS);
        EXPECT_EQ(cuCtxSetCurrent(context_), CUDA_SUCCESS);
        std::ifstream file(MATH_PTX);
        std::stringstream text;
        text << file.rdbuf();
        EXPECT_EQ(cuModuleLoadData(&module_, text.str().c_str()), CUDA_SUCCESS);
    }
    ~Device() {
        cuModuleUnload(module_);
        cuDevicePrimaryCtxRelease(0);
    }

    void run(const char* name, unsigned threads, std::vector<void*> parameters) {
        CUfunction function = nullptr;
        ASSERT_EQ(cuModuleGetFunction(&function, module_, name), CUDA_SUCCESS);
        ASSERT_EQ(cuLaunchKernel(function, (threads + 63) / 64, 1, 1, 64, 1, 1, 0, nullptr,
                                 parameters.data(), nullptr),
                  CUDA_SUCCESS);
        ASSERT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
    }

private:
    CUcontext context_ = nullptr;
    CUmodule module_ = nullptr;
};

template <typename T>
struct Memory {
    explicit Memory(const std::vector<T>& from) : count(from.size()) {
        EXPECT_EQ(cuMemAlloc(&address, count * sizeof(T)), CUDA_SUCCESS);
        EXPECT_EQ(cuMemcpyHtoD(address, from.data(), count * sizeof(T)), CUDA_SUCCESS);
    }
    ~Memory() { cuMemFree(address); }
    void read(std::vector<T>& to) const {
        EXPECT_EQ(cuMemcpyDtoH(to.data(), address, count * sizeof(T)), CUDA_SUCCESS);
    }

    size_t count;
    CUdeviceptr address = 0;
};

TEST(Optix6Math, EveryFunctionOnTheHost) {
    Calls calls(seed());
    for (size_t i = 0; i < calls.indices.size(); ++i)
        call(calls.indices[i], calls.in.data() + i * kMostNumbers,
             calls.out.data() + i * kMostNumbers);
    calls.check();
}

TEST(Optix6Math, EveryFunctionOnTheDevice) {
    Calls calls(seed());
    Device device;
    Memory<int> indices(calls.indices);
    Memory<Number> in(calls.in), out(calls.out);
    int count = int(calls.indices.size());
    device.run("callAll", count, {&count, &indices.address, &in.address, &out.address});
    out.read(calls.out);
    calls.check();
}

// ---- Classes
// --------------------------------------------------------------------------------------

std::vector<float> memberInputs() {
    std::mt19937 engine(7);
    std::vector<float> in(kMemberInputs);
    for (float& f : in)
        f = std::uniform_real_distribution<float>(0.5f, 2.0f)(engine);
    in[0] = 5.0f; // a matrix with an inverse
    in[10] = -4.0f;
    return in;
}

TEST(Optix6Math, MembersGiveTheSameOnHostAndDevice) {
    const std::vector<float> in = memberInputs();
    std::vector<float> host(kMemberOutputs, -77.0f), device(kMemberOutputs, -77.0f);
    members(in.data(), host.data());
    Device gpu;
    Memory<float> inputs(in), outputs(device);
    gpu.run("callMembers", 1, {&inputs.address, &outputs.address});
    outputs.read(device);
    EXPECT_NE(host[150], -77.0f);
    for (int i = 0; i < kMemberOutputs; ++i)
        EXPECT_NEAR(host[i], device[i], 1e-5f * std::max(1.0f, std::fabs(host[i]))) << i;
}

void expectEqual(const float3& a, const float3& b, float tolerance = 0.0f) {
    EXPECT_NEAR(a.x, b.x, tolerance);
    EXPECT_NEAR(a.y, b.y, tolerance);
    EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(Optix6Math, BoxesGrowAndShrink) {
    Aabb box;
    EXPECT_FALSE(box.valid());
    EXPECT_FALSE(box.contains(make_float3(0.0f)));
    expectEqual(box.m_min, make_float3(1e37f));
    expectEqual(box.m_max, make_float3(-1e37f));
    box.include(make_float3(1.0f, 2.0f, 3.0f));
    EXPECT_TRUE(box.valid());
    EXPECT_TRUE(box.isFlat());
    box.include(make_float3(2.0f, -1.0f, 3.5f));
    EXPECT_TRUE(box == Aabb(make_float3(1.0f, -1.0f, 3.0f), make_float3(2.0f, 2.0f, 3.5f)));
    EXPECT_FALSE(box.isFlat());
    EXPECT_TRUE(box == Aabb(make_float3(1.0f, 2.0f, 3.5f), make_float3(2.0f, -1.0f, 3.0f),
                            make_float3(1.5f, 0.0f, 3.0f)));
    box.enlarge(1.0f);
    EXPECT_TRUE(box == Aabb(make_float3(0.0f, -2.0f, 2.0f), make_float3(3.0f, 3.0f, 4.5f)));
    box.intersection(Aabb(make_float3(1.0f), make_float3(9.0f)));
    EXPECT_TRUE(box == Aabb(make_float3(1.0f, 1.0f, 2.0f), make_float3(3.0f, 3.0f, 4.5f)));
    box.intersection(Aabb(make_float3(7.0f), make_float3(9.0f)));
    EXPECT_FALSE(box.valid());
    box.invalidate();
    EXPECT_TRUE(box == Aabb());
    EXPECT_TRUE(Aabb(make_float3(0.0f), make_float3(1.0f)).contains(box));
}

TEST(Optix6Math, BoxesHaveSizes) {
    const Aabb box(make_float3(1.0f, 2.0f, 3.0f), make_float3(2.0f, 5.0f, 5.0f));
    expectEqual(box.center(), make_float3(1.5f, 3.5f, 4.0f));
    expectEqual(box.extent(), make_float3(1.0f, 3.0f, 2.0f));
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(box.center(i), getByIndex(box.center(), i));
        EXPECT_EQ(box.extent(i), getByIndex(box.extent(), i));
    }
    EXPECT_EQ(box.volume(), 6.0f);
    EXPECT_EQ(box.halfArea(), 11.0f);
    EXPECT_EQ(box.area(), 22.0f);
    EXPECT_EQ(box.longestAxis(), 1);
    EXPECT_EQ(box.maxExtent(), 3.0f);
    EXPECT_EQ(Aabb(make_float3(0.0f), make_float3(1.0f)).longestAxis(), 0);
    EXPECT_EQ(Aabb(make_float3(0.0f), make_float3(1.0f, 2.0f, 2.0f)).longestAxis(), 1);
    EXPECT_EQ(Aabb(make_float3(0.0f), make_float3(1.0f, 1.0f, 2.0f)).longestAxis(), 2);
    expectEqual(box[0], box.m_min);
    expectEqual(box[1], box.m_max);
}

TEST(Optix6Math, BoxesHaveDistances) {
    const Aabb box(make_float3(0.0f), make_float3(4.0f, 6.0f, 8.0f));
    EXPECT_EQ(box.distance(make_float3(7.0f, 10.0f, 1.0f)), 5.0f);
    EXPECT_EQ(box.distance2(make_float3(7.0f, 10.0f, 1.0f)), 25.0f);
    EXPECT_EQ(box.signedDistance(make_float3(7.0f, 10.0f, 1.0f)), 5.0f);
    EXPECT_EQ(box.distance(make_float3(1.0f, 2.0f, 3.0f)), 0.0f);
    EXPECT_EQ(box.signedDistance(make_float3(1.0f, 2.0f, 3.0f)), -1.0f);
    EXPECT_EQ(box.signedDistance(make_float3(2.0f, 3.0f, 7.5f)), -0.5f);
    EXPECT_EQ(box.signedDistance(make_float3(4.0f, 1.0f, 1.0f)), 0.0f);
    EXPECT_TRUE(box.contains(make_float3(4.0f, 6.0f, 8.0f)));
    EXPECT_FALSE(box.contains(make_float3(4.0f, 6.0f, 8.5f)));
    EXPECT_TRUE(box.contains(box));
    const Aabb across(make_float3(3.0f), make_float3(9.0f)),
        touching(make_float3(8.0f), make_float3(9.0f));
    EXPECT_FALSE(box.contains(across));
    EXPECT_TRUE(box.intersects(across));
    EXPECT_FALSE(box.intersects(touching));
    EXPECT_TRUE(box.intersects(Aabb(make_float3(4.0f, 6.0f, 8.0f), make_float3(9.0f))));
}

TEST(Optix6Math, MatricesAreRowMajor) {
    const float data[6] = {1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f};
    Matrix2x3 m(data);
    expectEqual(m.getRow(1), make_float3(4.0f, 5.0f, 6.0f));
    EXPECT_EQ(m.getCol(2).x, 3.0f);
    EXPECT_EQ(m.getCol(2).y, 6.0f);
    EXPECT_EQ(m.transpose()[3], 5.0f);
    m.setRow(0, make_float3(7.0f, 8.0f, 9.0f));
    m.setCol(1, make_float2(-1.0f, -2.0f));
    const float changed[6] = {7.0f, -1.0f, 9.0f, 4.0f, -2.0f, 6.0f};
    EXPECT_TRUE(m == Matrix2x3(changed));
    EXPECT_TRUE(m != Matrix2x3(data));
    EXPECT_TRUE(Matrix2x3(data) < m);
    EXPECT_FALSE(m < m);
    EXPECT_FALSE(m < Matrix2x3(data));
    EXPECT_TRUE(Matrix2x3::identity() == Matrix3x3::identity());
    EXPECT_EQ(m.getData(), &m[0]);
}

TEST(Optix6Math, MatricesHaveInverses) {
    std::mt19937 engine(5);
    for (int round = 0; round < 100; ++round) {
        Matrix4x4 m;
        for (int i = 0; i < 16; ++i)
            m[i] = std::uniform_real_distribution<float>(-1.0f, 1.0f)(engine) + (i % 5 ? 0 : 4.0f);
        const Matrix4x4 one = m * m.inverse();
        for (int i = 0; i < 16; ++i)
            EXPECT_NEAR(one[i], i % 5 ? 0.0f : 1.0f, 1e-5f);
        EXPECT_NEAR(m.inverse().det() * m.det(), 1.0f, 1e-5f);
        Matrix4x4 swapped = m;
        swapped.setRow(0, m.getRow(1));
        swapped.setRow(1, m.getRow(0));
        EXPECT_NEAR(swapped.det(), -m.det(), 1e-4f * std::fabs(m.det()));
    }
    EXPECT_EQ(Matrix4x4::scale(make_float3(2.0f, 3.0f, 4.0f)).det(), 24.0f);
    EXPECT_EQ(make_matrix3x3(Matrix4x4::scale(make_float3(2.0f, 3.0f, 4.0f))).det(), 24.0f);
}

TEST(Optix6Math, MatricesAndQuaternionsTurn) {
    const float4 p = make_float4(1.0f, 2.0f, 3.0f, 1.0f);
    expectEqual(make_float3(Matrix4x4::translate(make_float3(4.0f, 5.0f, 6.0f)) * p),
                make_float3(5.0f, 7.0f, 9.0f));
    expectEqual(make_float3(Matrix4x4::scale(make_float3(4.0f, 5.0f, 6.0f)) * p),
                make_float3(4.0f, 10.0f, 18.0f));
    const float3 u = make_float3(1.0f, 2.0f, 3.0f), v = make_float3(4.0f), w = make_float3(5.0f);
    expectEqual(make_float3(Matrix4x4::fromBasis(u, v, w, v) * make_float4(1.0f, 0.0f, 0.0f, 1.0f)),
                u + v);
    // A quarter turn around z: x to y. Radians for matrices, degrees for quaternions.
    const float3 z = make_float3(0.0f, 0.0f, 3.0f);
    expectEqual(make_float3(Matrix4x4::rotate(1.5707963f, z) * p), make_float3(-2.0f, 1.0f, 3.0f),
                1e-6f);
    expectEqual(Quaternion(z, 90.0f) * make_float3(p), make_float3(-2.0f, 1.0f, 3.0f), 1e-6f);
    const Quaternion turn(make_float3(1.0f, -2.0f, 0.5f), 77.0f);
    float rows[16];
    turn.toMatrix(rows);
    const Matrix4x4 same =
        Matrix4x4::rotate(77.0f * 3.14159265f / 180.0f, make_float3(1.0f, -2.0f, 0.5f));
    for (int i = 0; i < 16; ++i)
        EXPECT_NEAR(rows[i], same[i], 1e-6f) << i;
    expectEqual(make_float3(same * p), turn * make_float3(p), 1e-5f);
    expectEqual(Quaternion() * u, u);
}

TEST(Optix6Math, BasesAreOrthonormal) {
    for (const float3& direction :
         {make_float3(1.0f, 0.0f, 0.0f), make_float3(0.0f, -1.0f, 0.0f),
          make_float3(0.0f, 0.0f, 1.0f), make_float3(-1.0f, 2.0f, 0.5f)}) {
        const Onb basis(normalize(direction));
        expectEqual(cross(basis.m_tangent, basis.m_binormal), basis.m_normal, 1e-6f);
        EXPECT_NEAR(dot(basis.m_tangent, basis.m_normal), 0.0f, 1e-6f);
        EXPECT_NEAR(length(basis.m_tangent), 1.0f, 1e-6f);
        float3 p = make_float3(1.0f, 2.0f, 3.0f);
        basis.inverse_transform(p);
        expectEqual(p, basis.m_tangent + 2.0f * basis.m_binormal + 3.0f * basis.m_normal, 1e-6f);
    }
}

TEST(Optix6Math, RaysHoldTheirNumbers) {
    const Ray ray(make_float3(1.0f), make_float3(2.0f), 3u, 4.0f);
    EXPECT_EQ(ray.tmax, 1.e27f);
    const Ray made = make_Ray(make_float3(1.0f), make_float3(2.0f), 3u, 4.0f, 5.0f);
    expectEqual(made.origin, ray.origin);
    expectEqual(made.direction, ray.direction);
    EXPECT_EQ(made.ray_type, ray.ray_type);
    EXPECT_EQ(made.tmin, ray.tmin);
    EXPECT_EQ(made.tmax, 5.0f);
}

// ---- Streams
// --------------------------------------------------------------------------------------

template <typename V>
std::string written(const V& v) {
    std::ostringstream text;
    text << v;
    return text.str();
}
template <typename V>
V readBack(const std::string& text) {
    std::istringstream stream(text);
    V v = {};
    stream >> v;
    EXPECT_TRUE(stream) << text;
    return v;
}

TEST(Optix6Math, StreamsReadWhatTheyWrite) {
    EXPECT_EQ(written(make_float2(1.5f, -2.0f)), "1.5 -2");
    EXPECT_EQ(written(make_float3(1.5f, -2.0f, 3.0f)), "1.5 -2 3");
    EXPECT_EQ(written(make_float4(1.5f, -2.0f, 3.0f, 0.0f)), "1.5 -2 3 0");
    EXPECT_EQ(written(readBack<float2>("1.5 -2")), "1.5 -2");
    EXPECT_EQ(written(readBack<float3>(" 1.5\n-2 3")), "1.5 -2 3");
    EXPECT_EQ(written(readBack<float4>("1.5 -2 3 4")), "1.5 -2 3 4");
    EXPECT_EQ(written(readBack<int2>("1 -2")), "1 -2");
    EXPECT_EQ(written(readBack<int3>("1 -2 3")), "1 -2 3");
    EXPECT_EQ(written(readBack<int4>("1 -2 3 4")), "1 -2 3 4");
    EXPECT_EQ(written(readBack<uint2>("4000000000 2")), "4000000000 2");
    EXPECT_EQ(written(readBack<uint3>("1 2 3")), "1 2 3");
    EXPECT_EQ(written(readBack<uint4>("1 2 3 4")), "1 2 3 4");
    EXPECT_EQ(written(readBack<Matrix2x3>("1 2 3 4 5 6")), "1 2 3 4 5 6");
    EXPECT_EQ(written(Aabb(make_float3(1.0f, 2.0f, 3.0f), make_float3(4.0f))), "1 2 3 4 4 4");
    std::istringstream bad("1 x 3");
    float3 v;
    EXPECT_FALSE(bad >> v);
}

} // namespace
} // namespace math
