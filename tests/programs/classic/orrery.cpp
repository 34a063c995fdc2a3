// SPDX-License-Identifier: Apache-2.0
// A model of planets: transforms with matrix and SRT keys below other transforms, one geometry
// group below several of them, selectors that choose by time and by place, visibility of nodes.
// Rays have many times; the host computes the places of the spheres itself.
#include "common.h"

#include <optixu/optixu_math_namespace.h>
#include <optixu/optixu_matrix_namespace.h>

#include <cmath>
#include <vector>

using namespace optix;

namespace {

struct Query {
    float3 origin, direction;
    float time;
    unsigned int mask;
};
struct Seen {
    int body;
    float distance;
    float3 center, normal;
    int any;
};

enum Body { kSun, kPlanet, kMoon, kTwinLeft, kTwinRight, kEarly, kLate, kHigh, kLow };

struct Ball {
    int body;
    float3 center;
    float radius;
};

float between(float a, float b, float t) {
    return a + (b - a) * t;
}

// Where the bodies are, at a time. The keys are those of makeScene().
std::vector<Ball> ballsAt(float time, bool high) {
    const float t = std::fmin(std::fmax(time, 0.0f), 1.0f);
    std::vector<Ball> balls;
    balls.push_back({kSun, make_float3(0), 1});
    // The planet's orbit: an SRT that turns about y by 90 degrees, 5 away from the sun.
    const float angle = t * float(M_PI) / 2;
    const float3 planet = make_float3(5 * std::cos(angle), 0, -5 * std::sin(angle));
    balls.push_back({kPlanet, planet, 0.5f});
    // The moon: a matrix moves it along y below the same orbit; it is half as large.
    balls.push_back({kMoon, planet + make_float3(0, between(1, 2, t), 0), 0.25f});
    // Twins share a group and stand left and right of a place that moves along z.
    const float z = between(-4, 4, t);
    balls.push_back({kTwinLeft, make_float3(-10, 0, z), 0.5f});
    balls.push_back({kTwinRight, make_float3(-12, 0, z), 1.0f});
    balls.push_back({time < 0.5f ? kEarly : kLate, make_float3(20, 0, 0), 1});
    if (high)
        balls.push_back({kHigh, make_float3(30, 0, 0), 1});
    balls.push_back({kLow, make_float3(30, 0, -5), 1});
    return balls;
}

class Orrery {
public:
    Orrery() {
        context_ = Context::create();
        context_->setRayTypeCount(1);
        context_->setEntryPointCount(1);
        context_->setRayGenerationProgram(0, program("ask"));
        geometry_ = context_->createGeometry();
        geometry_->setPrimitiveCount(1);
        geometry_->setBoundingBoxProgram(program("ball_bounds"));
        geometry_->setIntersectionProgram(program("ball"));
        material_ = context_->createMaterial();
        material_->setClosestHitProgram(0, program("note"));
        material_->setAnyHitProgram(0, program("pass"));
        makeScene();
        queries_ = context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_USER);
        queries_->setElementSize(sizeof(Query));
        answers_ = context_->createBuffer(RT_BUFFER_OUTPUT, RT_FORMAT_USER);
        answers_->setElementSize(sizeof(Seen));
        context_["queries"]->set(queries_);
        context_["answers"]->set(answers_);
    }
    ~Orrery() { context_->destroy(); }
    Orrery(const Orrery&) = delete;

    std::vector<Seen> ask(const std::vector<Query>& questions) {
        queries_->setSize(questions.size());
        answers_->setSize(questions.size());
        auto* to = static_cast<Query*>(queries_->map(0, RT_BUFFER_MAP_WRITE_DISCARD));
        std::copy(questions.begin(), questions.end(), to);
        queries_->unmap();
        context_->launch(0, questions.size());
        const auto* from = static_cast<const Seen*>(answers_->map(0, RT_BUFFER_MAP_READ));
        std::vector<Seen> result(from, from + questions.size());
        answers_->unmap();
        return result;
    }
    void hideMoon(bool hide) { moonGroup_->setVisibilityMask(hide ? 2 : 255); }

private:
    Program program(const char* name) {
        return context_->createProgramFromPTXString(device_ptx, name);
    }
    Acceleration acceleration() { return context_->createAcceleration("Trbvh"); }
    GeometryGroup ball(int body, float radius) {
        GeometryInstance instance = context_->createGeometryInstance();
        instance->setGeometry(geometry_);
        instance->setMaterialCount(1);
        instance->setMaterial(0, material_);
        if (body >= 0)
            instance["body"]->setInt(body);
        instance["radius"]->setFloat(radius);
        GeometryGroup group = context_->createGeometryGroup();
        group->addChild(instance);
        group->setAcceleration(acceleration());
        return group;
    }
    template <class Child>
    Transform placed(Child child, const Matrix4x4& matrix) {
        Transform transform = context_->createTransform();
        transform->setChild(child);
        transform->setMatrix(false, matrix.getData(), nullptr);
        return transform;
    }
    // A group with one child and more: transforms have one child.
    template <class Child>
    void add(Group group, Child child) {
        group->addChild(child);
    }
    Transform orbit(Group content) {
        // Scale, shear and pivot as identity; a quaternion about y; a shift after it.
        std::vector<float> keys;
        constexpr unsigned kKeys = 9; // the quaternions are far enough apart to be exact enough
        for (unsigned k = 0; k < kKeys; ++k) {
            const float half = float(k) / (kKeys - 1) * float(M_PI) / 4;
            const float key[16] = {1, 0, 0, 0, 1, 0, 0, 1, 0, 0, std::sin(half), 0, std::cos(half),
                                   0, 0, 0};
            keys.insert(keys.end(), key, key + 16);
        }
        Transform transform = context_->createTransform();
        transform->setMotionRange(0, 1);
        transform->setMotionBorderMode(RT_MOTIONBORDERMODE_CLAMP, RT_MOTIONBORDERMODE_CLAMP);
        transform->setMotionKeys(kKeys, RT_MOTIONKEYTYPE_SRT_FLOAT16, keys.data());
        transform->setChild(content);
        return transform;
    }
    template <class Child>
    Transform moving(Child child, float3 from, float3 to, float scale) {
        const float keys[24] = {scale, 0, 0, from.x, 0, scale, 0, from.y, 0, 0, scale, from.z,
                                scale, 0, 0, to.x,   0, scale, 0, to.y,   0, 0, scale, to.z};
        Transform transform = context_->createTransform();
        transform->setMotionRange(0, 1);
        transform->setMotionKeys(2, RT_MOTIONKEYTYPE_MATRIX_FLOAT12, keys);
        transform->setChild(child);
        return transform;
    }
    Selector selector(const char* visit, Transform first, Transform second) {
        Selector made = context_->createSelector();
        made->setVisitProgram(program(visit));
        made->setChildCount(2);
        made->setChild(0, first);
        made->setChild(1, second);
        return made;
    }
    Group groupOf() {
        Group group = context_->createGroup();
        group->setAcceleration(acceleration());
        return group;
    }
    void makeScene() {
        Group sky = groupOf();
        add(sky, ball(kSun, 1));
        Group system = groupOf();
        add(system, placed(ball(kPlanet, 0.5f), Matrix4x4::translate(make_float3(5, 0, 0))));
        moonGroup_ = ball(kMoon, 0.5f);
        add(system, placed(moving(moonGroup_, make_float3(0, 1, 0), make_float3(0, 2, 0), 0.5f),
                           Matrix4x4::translate(make_float3(5, 0, 0))));
        add(sky, orbit(system));

        // Both twins are one group; the right one is scaled by its transform.
        GeometryGroup twin = ball(-1, 0.5f);
        Group twins = groupOf();
        add(twins, placed(twin, Matrix4x4::translate(make_float3(-10, 0, 0))));
        add(twins, placed(twin, Matrix4x4::translate(make_float3(-12, 0, 0)) *
                                    Matrix4x4::scale(make_float3(2))));
        add(sky, moving(twins, make_float3(0, 0, -4), make_float3(0, 0, 4), 1));

        const auto at = [&](int body, float3 place) {
            return placed(ball(body, 1), Matrix4x4::translate(place));
        };
        Selector byTime = selector("by_time", at(kEarly, make_float3(20, 0, 0)),
                                   at(kLate, make_float3(20, 0, 0)));
        byTime->getVisitProgram()["switch_time"]->setFloat(0.5f);
        add(sky, byTime);
        add(sky, selector("by_height", at(kHigh, make_float3(30, 0, 0)),
                          at(kLow, make_float3(30, 0, -5))));
        context_["sky"]->set(sky);
    }

    Context context_;
    Geometry geometry_;
    Material material_;
    GeometryGroup moonGroup_;
    Buffer queries_, answers_;
};

// Rays from above along -y, and from far away along -x, -z, at a grid of places and times.
std::vector<Query> questions() {
    std::vector<Query> list;
    for (int step = 0; step <= 8; ++step)
        for (const Ball& ball : ballsAt(float(step) / 8, true))
            for (const float offset : {0.0f, 0.4f, 0.9f}) {
                const float3 aside = make_float3(0, 0, offset * ball.radius);
                const float time = float(step) / 8;
                list.push_back({ball.center + aside + make_float3(0, 20, 0), make_float3(0, -1, 0),
                                time, 255});
                list.push_back({ball.center + aside + make_float3(0, -20, 0), make_float3(0, 1, 0),
                                time, 255});
            }
    for (int i = 0; i < 200; ++i) {
        const float a = float(i) * 0.37f;
        list.push_back({make_float3(40 * std::cos(a), float(i % 5) - 2, 40 * std::sin(a)),
                        normalize(make_float3(-std::cos(a), 0.03f * float(i % 3), -std::sin(a))),
                        float(i % 11) / 10, 1});
    }
    return list;
}

void compare(Orrery& orrery, bool moonIsHidden, const std::string& what) {
    const std::vector<Query> list = questions();
    const std::vector<Seen> answers = orrery.ask(list);
    int hits = 0;
    for (size_t i = 0; i < list.size(); ++i) {
        const Query& query = list[i];
        float nearest = 1e30f, margin = 1;
        Ball wanted{-1, {}, 0};
        for (const Ball& ball : ballsAt(query.time, query.origin.y > 0)) {
            if (moonIsHidden && ball.body == kMoon && query.mask == 1)
                continue;
            const float3 o = query.origin - ball.center;
            const float b = dot(o, query.direction),
                        d = b * b - dot(o, o) + ball.radius * ball.radius;
            margin = std::fmin(margin, std::fabs(d));
            if (d < 0 || -b - std::sqrt(d) < 0 || -b - std::sqrt(d) > nearest)
                continue;
            nearest = -b - std::sqrt(d);
            wanted = ball;
        }
        if (margin < 0.01f) // grazes a body
            continue;
        const Seen& seen = answers[i];
        const int body = wanted.body == kTwinLeft || wanted.body == kTwinRight ? -2 : wanted.body;
        const std::string where = what + ": ray " + std::to_string(i) + " meets body " +
                                  std::to_string(seen.body) + " in place of " +
                                  std::to_string(body);
        require(seen.body == (wanted.body < 0 ? -1 : body), where);
        if (wanted.body < 0)
            continue;
        ++hits;
        require(std::fabs(seen.distance - nearest) < 2e-3f, where + ": distance");
        require(length(seen.center - wanted.center) < 2e-3f, where + ": centre");
        const float3 normal =
            (query.origin + nearest * query.direction - wanted.center) / wanted.radius;
        require(length(seen.normal - normal) < 5e-3f, where + ": normal");
        require(seen.any >= 1, where + ": no any-hit program ran");
    }
    require(hits > 250, what + ": only " + std::to_string(hits) + " hits");
}

void run() {
    Orrery orrery;
    compare(orrery, false, "all bodies");
    orrery.hideMoon(true);
    compare(orrery, true, "without the moon");
    orrery.hideMoon(false);
    compare(orrery, false, "all bodies again");
}

} // namespace

int main() {
    return runProgram(run);
}
