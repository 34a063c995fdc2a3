// SPDX-License-Identifier: Apache-2.0
// A server with a context for each of its threads, and one more that two threads use by turns. Each
// samples volumes beyond their borders in all wrap modes, changes its scene, and is destroyed while
// others launch. A context must refuse objects of another.
#include "common.h"

#include <optixu/optixu_math_namespace.h>

#include <cmath>
#include <mutex>
#include <thread>
#include <vector>

using namespace optix;

namespace {

constexpr unsigned kVoxels = 12, kTexels = 4;
constexpr RTwrapmode kModes[] = {RT_WRAP_REPEAT, RT_WRAP_CLAMP_TO_EDGE, RT_WRAP_MIRROR,
                                 RT_WRAP_CLAMP_TO_BORDER};

float texel(int x, int y, int z, int seed) {
    return float(seed + x + 10 * y + 100 * z);
}

// The nearest texel's place along an axis, or below 0 beyond a border.
int placeOf(float u, RTwrapmode mode) {
    if (mode == RT_WRAP_REPEAT)
        u -= std::floor(u);
    if (mode == RT_WRAP_MIRROR) {
        const float whole = std::floor(u);
        u -= whole;
        u = int(whole) % 2 ? 1 - u : u;
    }
    const int place = int(std::floor(u * kTexels));
    if (mode == RT_WRAP_CLAMP_TO_BORDER && (place < 0 || place >= int(kTexels)))
        return -1;
    return std::min(std::max(place, 0), int(kTexels) - 1);
}

class Studio {
public:
    explicit Studio(int seed) : seed_(seed) {
        context_ = Context::create();
        context_->setRayTypeCount(1);
        context_->setEntryPointCount(1);
        context_->setRayGenerationProgram(0, program("sample"));
        samples_ =
            context_->createBuffer(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT4, kVoxels, kVoxels, kVoxels);
        context_["samples"]->set(samples_);
        Buffer volumes = context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_INT, 4);
        auto* ids = static_cast<int*>(volumes->map());
        for (int mode = 0; mode < 4; ++mode)
            ids[mode] = volume(mode)->getId();
        volumes->unmap();
        context_["volumes"]->set(volumes);
        Geometry geometry = context_->createGeometry();
        geometry->setPrimitiveCount(1);
        geometry->setBoundingBoxProgram(program("plane_bounds"));
        geometry->setIntersectionProgram(program("plane"));
        Material material = context_->createMaterial();
        material->setClosestHitProgram(0, program("hit"));
        group_ = context_->createGeometryGroup();
        group_->addChild(context_->createGeometryInstance(geometry, &material, &material + 1));
        group_->setAcceleration(context_->createAcceleration("Trbvh"));
        context_["top"]->set(group_);
    }
    ~Studio() { context_->destroy(); }
    Studio(const Studio&) = delete;

    void check(int round) {
        const float scale = float(round) + 0.5f, height = -float(seed_ + round);
        const int mode = round % 4;
        context_["scale"]->setFloat(scale);
        context_["height"]->setFloat(height);
        context_["volume"]->setInt(mode);
        group_->getAcceleration()->markDirty();
        context_->launch(0, kVoxels, kVoxels, kVoxels);
        const auto* data = static_cast<const float4*>(samples_->map());
        for (unsigned i = 0; i < kVoxels * kVoxels * kVoxels; ++i) {
            int places[3];
            for (int axis = 0; axis < 3; ++axis) {
                const unsigned at = axis == 0   ? i % kVoxels
                                    : axis == 1 ? i / kVoxels % kVoxels
                                                : i / kVoxels / kVoxels;
                places[axis] = placeOf((float(at) + 0.5f) / kVoxels * 3 - 1, kModes[mode]);
            }
            const bool outside = places[0] < 0 || places[1] < 0 || places[2] < 0;
            const float4 wanted =
                make_float4(outside ? 0 : texel(places[0], places[1], places[2], seed_), scale,
                            1 - height, texel(1, 2, 3, seed_));
            const float4 off = data[i] - wanted;
            require(dot(off, off) < 1e-5f,
                    "studio " + std::to_string(seed_) + ", round " + std::to_string(round) +
                        ": voxel " + std::to_string(i) + " is " + std::to_string(data[i].x) +
                        " in place of " + std::to_string(wanted.x));
        }
        samples_->unmap();
    }
    Buffer samples() const { return samples_; }
    // Whether a variable of this context takes an object of another.
    bool takes(const Studio& other) {
        return rtVariableSetObject(context_["samples"]->get(), other.samples()->get()) ==
               RT_SUCCESS;
    }

private:
    Program program(const char* name) {
        return context_->createProgramFromPTXString(device_ptx, name);
    }
    TextureSampler volume(int mode) {
        Buffer texels =
            context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_FLOAT, kTexels, kTexels, kTexels);
        auto* to = static_cast<float*>(texels->map());
        for (int i = 0; i < int(kTexels * kTexels * kTexels); ++i)
            to[i] = texel(i % 4, i / 4 % 4, i / 16, seed_);
        texels->unmap();
        TextureSampler sampler = context_->createTextureSampler();
        sampler->setBuffer(texels);
        for (unsigned axis = 0; axis < 3; ++axis)
            sampler->setWrapMode(axis, kModes[mode]);
        sampler->setFilteringModes(RT_FILTER_NEAREST, RT_FILTER_NEAREST, RT_FILTER_NONE);
        sampler->setReadMode(RT_TEXTURE_READ_ELEMENT_TYPE);
        return sampler;
    }

    const int seed_;
    Context context_;
    Buffer samples_;
    GeometryGroup group_;
};

void run() {
    std::mutex mutex;
    std::string failure;
    Studio shared(500);
    const auto work = [&](int seed) {
        try {
            for (int life = 0; life < 2; ++life) {
                Studio own(seed + 10 * life);
                for (int round = 0; round < 5; ++round) {
                    own.check(round);
                    std::lock_guard lock(mutex);
                    shared.check(round + seed);
                    require(!own.takes(shared), "a variable takes an object of another context");
                }
            }
        } catch (const std::exception& fault) {
            std::lock_guard lock(mutex);
            failure = fault.what();
        }
    };
    std::vector<std::thread> threads;
    for (int i = 1; i <= 3; ++i)
        threads.emplace_back(work, 100 * i);
    for (std::thread& thread : threads)
        thread.join();
    require(failure.empty(), failure);
}

} // namespace

int main() {
    return runProgram(run);
}
