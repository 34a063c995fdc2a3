// SPDX-License-Identifier: Apache-2.0
// A landscape of voxels in bricks, which are custom primitives, with trees and lit houses;
// device/voxels.cu.
#include "programs.h"

#include "device/voxels.h"

std::string_view bench_fourth_voxels_ptx();

namespace bench {
namespace {

enum Paint : unsigned char {
    kEmpty,
    kGrass,
    kDirt,
    kStone,
    kSnow,
    kWater,
    kTrunk,
    kLeaf,
    kWall,
    kRoof,
    kWindow,
    kPaints
};

// The world: a height for each column, and things on it in cells of 16 x 16 columns.
class Land {
public:
    explicit Land(int side) : side_(side), heights_(size_t(side) * side) {
        for (int z = 0; z < side; ++z)
            for (int x = 0; x < side; ++x)
                heights_[size_t(z) * side + x] = std::max(kSea, riseOf(float(x), float(z)));
    }
    int side() const { return side_; }
    int heightAt(int x, int z) const {
        return heights_[size_t(std::clamp(z, 0, side_ - 1)) * side_ + std::clamp(x, 0, side_ - 1)];
    }
    Paint at(int x, int y, int z) const {
        const int height = heightAt(x, z);
        if (y < height)
            return groundAt(y, height);
        const int left = x & ~15, low = z & ~15, foot = heightAt(left + 8, low + 8);
        const auto cell = unsigned(left * 64 + low);
        if (foot <= kSea + 1 || foot > 120)
            return kEmpty;
        return randomOf(cell, 1) < 0.6f    ? treeAt(cell, x - left - 8, y - foot, z - low - 8)
               : randomOf(cell, 1) < 0.75f ? houseAt(x - left - 8, y - foot, z - low - 8)
                                           : kEmpty;
    }

private:
    static constexpr int kSea = 30;

    static int riseOf(float x, float z) {
        const float wide = std::sin(0.011f * x + 0.4f) * std::cos(0.009f * z) +
                           0.6f * std::sin(0.023f * z + 0.013f * x);
        const float fine = std::sin(0.07f * x) * std::sin(0.083f * z + 0.02f * x) +
                           0.4f * std::sin(0.19f * x + 0.17f * z);
        return int(48 + 42 * wide + 7 * fine);
    }
    static Paint groundAt(int y, int height) {
        if (height == kSea)
            return kWater;
        if (y + 1 == height)
            return height > 95 ? kSnow : height > 75 ? kStone : kGrass;
        return y + 4 > height ? kDirt : kStone;
    }
    static Paint treeAt(unsigned cell, int x, int y, int z) {
        const int top = 7 + int(6 * randomOf(cell, 2));
        if (x == 0 && z == 0 && y < top)
            return kTrunk;
        const int up = y - top;
        const bool isCrown = x * x + z * z + up * up < 18;
        return isCrown && hashPcg(unsigned(x * 31 + y * 997 + z * 71)) % 4 ? kLeaf : kEmpty;
    }
    static Paint houseAt(int x, int y, int z) {
        const int out = std::max(std::abs(x), std::abs(z));
        if (y < -4 || out > 6)
            return kEmpty;
        if (y >= 6)
            return out <= 12 - y ? kRoof : kEmpty;
        if (out < 5 || out == 6)
            return kEmpty;
        return y >= 2 && y <= 3 && std::abs(std::min(std::abs(x), std::abs(z)) - 2) < 1 ? kWindow
                                                                                        : kWall;
    }

    int side_;
    std::vector<int> heights_;
};

// Bricks that rays can meet: they have full and empty voxels, or a full one at a side.
std::vector<Brick> makeBricks(const Land& land) {
    std::vector<Brick> bricks;
    for (int z = 0; z < land.side(); z += kBrickSide)
        for (int x = 0; x < land.side(); x += kBrickSide) {
            int low = 1000, high = 0;
            for (int i = 0; i < (kBrickSide + 2) * (kBrickSide + 2); ++i) {
                const int height =
                    land.heightAt(x - 1 + i % (kBrickSide + 2), z - 1 + i / (kBrickSide + 2));
                low = std::min(low, height);
                high = std::max(high, height);
            }
            for (int y = (low - 1) / kBrickSide * kBrickSide; y < high + 26; y += kBrickSide) {
                Brick brick = {x, y, z, {}};
                unsigned full = 0;
                for (int i = 0; i < kBrickVoxels; ++i) {
                    brick.voxels[i] = land.at(x + i % kBrickSide, y + i / (kBrickSide * kBrickSide),
                                              z + i / kBrickSide % kBrickSide);
                    full += brick.voxels[i] != kEmpty;
                }
                if (full > 0)
                    bricks.push_back(brick);
            }
        }
    return bricks;
}

class Voxels : public Renderer {
public:
    Voxels(OptixDeviceContext context, const JobSettings& settings) : Renderer(context, settings) {
        const Land land(int(std::sqrt(settings.some(1024 * 1024, 128 * 128))) & ~15);
        const std::vector<Brick> bricks = makeBricks(land);
        std::vector<OptixAabb> boxes;
        for (const Brick& b : bricks)
            boxes.push_back({float(b.x), float(b.y), float(b.z), float(b.x + kBrickSide),
                             float(b.y + kBrickSide), float(b.z + kBrickSide)});
        std::vector<VoxelPaint> palette(kPaints);
        const float3 colors[kPaints] = {vec(0),
                                        vec(0.3f, 0.5f, 0.18f),
                                        vec(0.42f, 0.3f, 0.2f),
                                        vec(0.45f),
                                        vec(0.9f),
                                        vec(0.12f, 0.3f, 0.5f),
                                        vec(0.3f, 0.2f, 0.12f),
                                        vec(0.18f, 0.4f, 0.12f),
                                        vec(0.75f, 0.7f, 0.6f),
                                        vec(0.6f, 0.22f, 0.15f),
                                        vec(0.8f)};
        for (unsigned i = 0; i < kPaints; ++i)
            palette[i] = {colors[i], i == kWindow ? vec(5, 3.6f, 1.8f) : vec(0)};
        VoxelParams& p = launch_.params;
        p.world = scene_.buildBoxes(boxes, OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT);
        p.bricks = scene_.upload(bricks);
        p.palette = scene_.upload(palette);
        const auto middle = 0.5f * float(land.side());
        p.camera = makeCamera(vec(0.22f * middle, 130, 0.1f * middle), vec(middle, 40, middle),
                              vec(0, 1, 0), 52, settings.aspect());
        p.sun = normalize(vec(-0.55f, 0.5f, 0.35f));
        p.samples = 2;
        p.bounces = 2;
        p.image = allocatePicture();
    }
    void compile() override {
        OptixPipelineCompileOptions& o = programs_.options;
        o.usesPrimitiveTypeFlags = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM);
        o.numPayloadValues = 3;
        o.numAttributeValues = 1;
        const OptixModule module = programs_.load(bench_fourth_voxels_ptx());
        const auto raygen = programs_.raygen({module, "__raygen__world"});
        const auto sky = programs_.miss({module, "__miss__sky"});
        const auto hit =
            programs_.hit({{module, "__closesthit__voxel"}, {}, {module, "__intersection__brick"}});
        pipeline_ = programs_.link({raygen, sky, hit}, {});
        table_.setRaygen(makeRecord(raygen));
        table_.setMisses(std::vector{makeRecord(sky)});
        table_.setHits(std::vector{makeRecord(hit)});
    }
    void renderFrame() override { launch_.run(pipeline_, table_, width_, height_); }

private:
    Launch<VoxelParams> launch_;
};

} // namespace

JobKind voxelsJob() {
    return fourthJob<Voxels>(
        "voxels", "bricks of voxels that an intersection program walks through", 0.005, 0.05);
}

} // namespace bench
