// SPDX-License-Identifier: Apache-2.0
// An acoustics program: three-dimensional launches by direction and source, energies by band in the
// payload, receivers whose any-hit program adds to a histogram and lets the ray go on.
#include "common.h"

#include <optixu/optixu_math_namespace.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <vector>

using namespace optix;

namespace {

struct Wall {
    float plane[4];
    int absorption;
    int padding[3];
};
struct Ball {
    float place[3];
    float radius;
};

constexpr int kTimes = 120, kBands = 8, kRays = 256, kOrder = 5;
constexpr float kSize[3] = {8, 6, 4}, kBin = 0.0005f;
constexpr double kReach = 340.0 * kTimes * kBin;
constexpr float kSources[2][3] = {{2, 2, 1.5f}, {6.5f, 1, 2}};
constexpr Ball kReceivers[] = {
    {{5, 4, 1.7f}, 0.4f}, {{1, 5, 2}, 0.4f}, {{6.5f, 5, 2.5f}, 0.4f}, {{4, 3, 1}, 0.4f}};
constexpr int kPairs = 2 * 4;

// Of the walls at 0 and at the far end of each axis; even and odd bands.
float absorption(int wall, int band) {
    constexpr float kOf[6][2] = {{0.1f, 0.3f},  {0.2f, 0.1f}, {0.15f, 0.5f},
                                 {0.05f, 0.2f}, {0.4f, 0.6f}, {0.25f, 0.35f}};
    return kOf[wall][band % 2];
}

class Room {
public:
    Room() {
        context_ = Context::create();
        context_->setRayTypeCount(2);
        context_->setEntryPointCount(1);
        context_->setMaxTraceDepth(1);
        context_->setRayGenerationProgram(0, program("emit"));
        context_["bin"]->setFloat(kBin);
        context_["order"]->setInt(kOrder);
        context_["size"]->set3fv(kSize);
        fill("sources", context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_FLOAT3, 2), kSources,
             sizeof kSources);
        fill("receivers", context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_FLOAT4, 4), kReceivers,
             sizeof kReceivers);
        makeWalls();
        Material wall = context_->createMaterial(), ear = context_->createMaterial();
        wall->setClosestHitProgram(0, program("wall_hit"));
        ear->setAnyHitProgram(1, program("ear_heard"));
        context_["room"]->set(group(6, "wall_intersect", "wall_bounds", wall));
        context_["ears"]->set(group(4, "ear_intersect", "ear_bounds", ear));
    }
    ~Room() { context_->destroy(); }
    Room(const Room&) = delete;

    std::vector<float> listen() {
        const std::vector<float> silence(kTimes * kBands * kPairs);
        Buffer arrivals =
            context_->createBuffer(RT_BUFFER_INPUT_OUTPUT, RT_FORMAT_FLOAT, kTimes, kBands, kPairs);
        Buffer lost = context_->createBuffer(RT_BUFFER_INPUT_OUTPUT, RT_FORMAT_INT, 1);
        fill("arrivals", arrivals, silence.data(), silence.size() * sizeof(float));
        fill("lost", lost, silence.data(), sizeof(int));
        context_->launch(0, kRays, kRays, 2);
        require(*static_cast<int*>(lost->map()) < kRays * kRays / 500, "rays leave the room");
        lost->unmap();
        const auto* const heard = static_cast<float*>(arrivals->map());
        std::vector<float> all(heard, heard + silence.size());
        arrivals->unmap();
        return all;
    }

private:
    Program program(const char* name) {
        return context_->createProgramFromPTXString(device_ptx, name);
    }
    void fill(const char* variable, Buffer buffer, const void* data, size_t bytes) {
        std::memcpy(buffer->map(), data, bytes);
        buffer->unmap();
        context_[variable]->setBuffer(buffer);
    }
    void makeWalls() {
        Wall walls[6] = {};
        for (int i = 0; i < 6; ++i) {
            walls[i].plane[i / 2] = 1;
            walls[i].plane[3] = i % 2 ? -kSize[i / 2] : 0;
            Buffer bands = context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_FLOAT, kBands);
            auto* const values = static_cast<float*>(bands->map());
            for (int band = 0; band < kBands; ++band)
                values[band] = absorption(i, band);
            bands->unmap();
            walls[i].absorption = bands->getId();
        }
        Buffer buffer = context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_USER, 6);
        buffer->setElementSize(sizeof(Wall));
        fill("walls", buffer, walls, sizeof walls);
    }
    GeometryGroup group(unsigned count, const char* intersect, const char* bounds,
                        Material material) {
        Geometry geometry = context_->createGeometry();
        geometry->setPrimitiveCount(count);
        geometry->setIntersectionProgram(program(intersect));
        geometry->setBoundingBoxProgram(program(bounds));
        GeometryInstance instance =
            context_->createGeometryInstance(geometry, &material, &material + 1);
        GeometryGroup made = context_->createGeometryGroup(&instance, &instance + 1);
        made->setAcceleration(context_->createAcceleration("Trbvh"));
        return made;
    }

    Context context_;
};

// The energy of one image of the source: `image` counts the reflections along each axis, with sign.
double energyOf(const int image[3], const float source[3], const float place[3], int band) {
    double square = 0, energy = 1;
    for (int k = 0; k < 3; ++k) {
        const int n = image[k], near = n > 0 ? n / 2 : (1 - n) / 2, far = std::abs(n) - near;
        const double from = n * kSize[k] + (n % 2 ? kSize[k] - source[k] : source[k]);
        square += (from - place[k]) * (from - place[k]);
        energy *= std::pow(1 - absorption(2 * k, band), near) *
                  std::pow(1 - absorption(2 * k + 1, band), far);
    }
    return std::sqrt(square) < kReach ? energy / (4 * M_PI * square) : 0;
}

// All images of the source that the launches follow.
double energyOf(const float source[3], const float place[3], int band) {
    double sum = 0;
    for (int x = -kOrder; x <= kOrder; ++x)
        for (int y = -kOrder; y <= kOrder; ++y)
            for (int z = -kOrder; z <= kOrder; ++z)
                if (std::abs(x) + std::abs(y) + std::abs(z) <= kOrder) {
                    const int image[3] = {x, y, z};
                    sum += energyOf(image, source, place, band);
                }
    return sum;
}

} // namespace

int main() {
    return runProgram([] {
        const std::vector<float> arrivals = Room().listen();
        for (int pair = 0; pair < kPairs; ++pair)
            for (int band = 0; band < kBands; ++band) {
                const float* const times = &arrivals[size_t(kTimes * (band + kBands * pair))];
                double heard = 0;
                for (int time = 0; time < kTimes; ++time)
                    heard += times[time];
                const double wanted =
                    energyOf(kSources[pair / 4], kReceivers[pair % 4].place, band);
                const std::string what =
                    "pair " + std::to_string(pair) + ", band " + std::to_string(band);
                require(times[0] == 0, what + ": sound before its time");
                require(std::fabs(heard - wanted) < 0.05 * wanted,
                        what + ": " + std::to_string(heard) + " in place of " +
                            std::to_string(wanted));
            }
    });
}
