// SPDX-License-Identifier: Apache-2.0
// A baker of ambient occlusion: no pictures, but launches of one dimension over records of the
// application, in batches that are smaller than the list. Blockers are balls over a floor. How much
// of the sky a ball hides from a point has a closed formula.
#include "device/light_baking.h"
#include "common.h"

#include <optixu/optixu_math_namespace.h>

#include <cmath>
#include <cstring>
#include <vector>

using namespace optix;

namespace {

constexpr unsigned kPoints = 700, kBatch = 256, kRays = 1024;

// The part of the light of a uniform sky that a whole ball above the horizon hides from a surface
// that looks up.
float hidden(const BakePoint& point, const BakeBall& ball) {
    const float3 way = ball.center - point.position;
    const float square = dot(way, way);
    return ball.radius * ball.radius / square * dot(point.normal, way) / std::sqrt(square);
}

class Baker {
public:
    explicit Baker(const std::vector<BakeBall>& balls) : balls_(balls) {
        context_->setRayTypeCount(1);
        context_->setEntryPointCount(2);
        context_->setRayGenerationProgram(kBake, program("bake"));
        context_->setRayGenerationProgram(kMean, program("mean"));
        context_["rays"]->setUint(kRays);
        context_["far_away"]->setFloat(RT_DEFAULT_MAX);
        makeScene();
        points_ = context_->createBuffer(RT_BUFFER_INPUT_OUTPUT, RT_FORMAT_USER);
        points_->setElementSize(sizeof(BakePoint));
        points_->setSize(kPoints);
        context_["points"]->set(points_);
        means_ = context_->createBuffer(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT, 2);
        context_["means"]->set(means_);
        placePoints();
    }
    ~Baker() { rtContextDestroy(context_->get()); }
    Baker(const Baker&) = delete;

    void bake() {
        RTsize size = 0;
        points_->getSize(size);
        for (unsigned first = 0; first < size; first += kBatch) {
            context_["first"]->setUint(first);
            context_->launch(kBake, std::min<RTsize>(kBatch, size - first));
        }
    }
    void check(const std::string& what) {
        const auto* points = static_cast<const BakePoint*>(points_->map(0, RT_BUFFER_MAP_READ));
        double sum = 0, worst = 0;
        for (unsigned i = 0; i < kPoints; ++i) {
            float open = 1;
            for (const BakeBall& ball : balls_)
                open -= hidden(points[i], ball);
            worst = std::max(worst, double(std::fabs(open - points[i].open)));
            sum += double(points[i].open);
            require(points[i].hits + int(points[i].open * kRays + 0.5f) == int(kRays),
                    what + ": hits and misses are not all rays");
            require(points[i].id == i * 3 + 1, what + ": a record has lost what it held");
        }
        points_->unmap();
        require(worst < 0.04, what + ": off by " + std::to_string(worst));
        context_->launch(kMean, 1);
        const float mean = static_cast<const float*>(means_->map())[0];
        means_->unmap();
        require(std::fabs(double(mean) - sum / kPoints) < 1e-5, what + ": another mean");
    }
    // The ball moves; its geometry is dirty through the acceleration.
    void moveBall(size_t index, float3 to) {
        balls_[index].center = to;
        fillBalls();
        instance_->getGeometry()->setPrimitiveCount(unsigned(balls_.size()));
        group_->getAcceleration()->markDirty();
    }
    void addBall(const BakeBall& ball) {
        balls_.push_back(ball);
        ballBuffer_->setSize(balls_.size());
        fillBalls();
        instance_->getGeometry()->setPrimitiveCount(unsigned(balls_.size()));
        group_->getAcceleration()->markDirty();
    }

private:
    enum Entry { kBake, kMean };
    Program program(const char* name) {
        return context_->createProgramFromPTXString(device_ptx, name);
    }
    void fillBalls() {
        std::memcpy(ballBuffer_->map(), balls_.data(), balls_.size() * sizeof(BakeBall));
        ballBuffer_->unmap();
    }
    void makeScene() {
        ballBuffer_ = context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_USER);
        ballBuffer_->setElementSize(sizeof(BakeBall));
        ballBuffer_->setSize(balls_.size());
        fillBalls();
        Geometry geometry = context_->createGeometry();
        geometry->setPrimitiveCount(unsigned(balls_.size()));
        geometry->setBoundingBoxProgram(program("ball_bounds"));
        geometry->setIntersectionProgram(program("ball_intersect"));
        geometry["balls"]->setBuffer(ballBuffer_);
        Material material = context_->createMaterial();
        material->setAnyHitProgram(0, program("count_hit"));
        instance_ = context_->createGeometryInstance(geometry, &material, &material + 1);
        group_ = context_->createGeometryGroup();
        group_->setChildCount(1);
        group_->setChild(0, instance_);
        group_->setAcceleration(context_->createAcceleration("Sbvh"));
        context_["blockers"]->set(group_);
    }
    void placePoints() {
        auto* points = static_cast<BakePoint*>(points_->map());
        for (unsigned i = 0; i < kPoints; ++i) {
            points[i] = {};
            points[i].position = make_float3(float(i % 28) / 14 - 1, 0, float(i / 28) / 12 - 1);
            points[i].normal = make_float3(0, 1, 0);
            points[i].id = i * 3 + 1;
        }
        points_->unmap();
    }

    std::vector<BakeBall> balls_;
    Context context_ = Context::create();
    Buffer points_, means_, ballBuffer_;
    GeometryInstance instance_;
    GeometryGroup group_;
};

} // namespace

int main() {
    return runProgram([] {
        Baker baker({{make_float3(0, 1.5f, 0), 0.5f}});
        baker.bake();
        baker.check("one ball");
        baker.moveBall(0, make_float3(0.5f, 1.2f, -0.5f));
        baker.bake();
        baker.check("moved");
        // Far enough from the other that no point sees one behind the other.
        baker.addBall({make_float3(-8, 3, -8), 1.0f});
        baker.bake();
        baker.check("two balls");
    });
}
