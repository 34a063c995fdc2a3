// SPDX-License-Identifier: Apache-2.0
// Texture footprints at random places of textures of several kinds.
#include "footprints.h"
#include "lab.h"

#include <cmath>
#include <cstdio>

std::string_view differential_footprints_ptx(); // footprints.cu, built into this program

namespace differential {
namespace {

// The request of a case. The driver's library takes the size of the groups, minus one, from bits 8
// to 11 of the texture info, where the manual has the address mode of x and reserved bits, and the
// size of the tile elsewhere. In all cases both readings agree: `granularity` numbers the size of
// the tile, and `wrap` is (granularity + 1) % 4.
struct FootprintKind {
    unsigned width, height, levels;
    cudaTextureAddressMode wrap; // numbered as in the texture info
    bool linearLevels;
    unsigned granularity, tileWidth, tileHeight; // log2 of width and height
    unsigned info() const {
        return levels << 24 | tileWidth << 20 | tileHeight << 16 | (granularity + 1) << 8 |
               unsigned(wrap) << 6 | unsigned(linearLevels) << 5 | 1;
    }
};

// A texture of floats whose texels are never read.
class TestTexture {
public:
    explicit TestTexture(const FootprintKind& kind) {
        const cudaChannelFormatDesc format = {32, 0, 0, 0, cudaChannelFormatKindFloat};
        CUDA_CHECK(cudaMallocMipmappedArray(&array_, &format, {kind.width, kind.height, 0},
                                            kind.levels));
        cudaResourceDesc resource = {};
        resource.resType = cudaResourceTypeMipmappedArray;
        resource.res.mipmap.mipmap = array_;
        cudaTextureDesc texture = {};
        texture.addressMode[0] = texture.addressMode[1] = kind.wrap;
        texture.filterMode = cudaFilterModeLinear;
        texture.mipmapFilterMode = kind.linearLevels ? cudaFilterModeLinear : cudaFilterModePoint;
        texture.normalizedCoords = 1;
        texture.maxMipmapLevelClamp = float(kind.levels - 1);
        CUDA_CHECK(cudaCreateTextureObject(&texture_, &resource, &texture, nullptr));
    }
    TestTexture(const TestTexture&) = delete;
    ~TestTexture() {
        cudaDestroyTextureObject(texture_);
        cudaFreeMipmappedArray(array_);
    }
    cudaTextureObject_t object() const { return texture_; }

private:
    cudaMipmappedArray_t array_ = nullptr;
    cudaTextureObject_t texture_ = 0;
};

const char* const kForms[] = {"plain", "lod", "grad"};

// Calls away from the edges, because the driver's library continues counting beyond them.
std::vector<FootprintCall> randomCalls(const TestTexture& texture, const FootprintKind& kind,
                                       unsigned form, uint64_t seed) {
    Random random(seed);
    std::vector<FootprintCall> calls(100);
    for (FootprintCall& call : calls) {
        call.texture = texture.object();
        call.info = kind.info();
        call.form = form;
        call.coarse = random.next() & 1;
        call.x = 0.5f + 0.3f * random.symmetric();
        call.y = 0.5f + 0.3f * random.symmetric();
        const float last = float(kind.levels - 1);
        call.level = (last + 0.6f) * random.unit() - 0.3f;
        // Between a hundredth of a texel and a texel of the last level.
        const float length = std::exp2((last + 6.5f) * random.unit() - 6.5f),
                    ratio = random.unit(), a = random.symmetric(), b = std::sqrt(1 - a * a);
        call.dx[0] = length * a / float(kind.width);
        call.dx[1] = length * b / float(kind.height);
        call.dy[0] = -length * ratio * b / float(kind.width);
        call.dy[1] = length * ratio * a / float(kind.height);
    }
    return calls;
}

class FootprintRig {
public:
    explicit FootprintRig(const Lab& lab)
        : program_(lab.context(), differential_footprints_ptx(), 0, 0,
                   unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE)) {
        const OptixProgramGroup raygen = program_.addRaygen("__raygen__footprints");
        pipeline_ = program_.link(0);
        records_.upload(std::vector{makeRecord(raygen)});
        table_.raygenRecord = table_.missRecordBase = records_.address();
        table_.missRecordStrideInBytes = sizeof(SbtRecord<NoData>);
        table_.missRecordCount = 1;
    }
    std::vector<FootprintSeen> run(const std::vector<FootprintCall>& calls) {
        DeviceBuffer deviceCalls, params, seen(calls.size() * sizeof(FootprintSeen));
        deviceCalls.upload(calls);
        const FootprintParams given = {deviceCalls.as<FootprintCall>(), seen.as<FootprintSeen>()};
        params.upload(&given, sizeof(given));
        OPTIX_CHECK(optixLaunch(pipeline_, nullptr, params.address(), sizeof(given), &table_,
                                unsigned(calls.size()), 1, 1));
        CUDA_CHECK(cudaDeviceSynchronize());
        return seen.download<FootprintSeen>();
    }

private:
    Program program_;
    OptixPipeline pipeline_ = nullptr;
    DeviceBuffer records_;
    OptixShaderBindingTable table_ = {};
};

// A line for each part of a result, named by form and part. The result for a missing coarser level
// is unspecified.
void tell(const FootprintSeen& seen, const FootprintCall& call, size_t number, std::string& text) {
    const bool isOpen = call.form != kPlain && call.coarse && seen.single;
    const auto add = [&](const char* part, unsigned long long value) {
        char line[80];
        std::snprintf(line, sizeof line, "%s_%s %zu: %llx\n", kForms[call.form], part, number,
                      isOpen ? 0 : value);
        text += line;
    };
    const unsigned* w = seen.words;
    add("mask", (unsigned long long)(w[1]) << 32 | w[0]);
    add("tile", (w[3] & 0xFFF) << 12 | (w[2] & 0xFFF));
    add("rotation", w[2] >> 16 & 63);
    add("granularity", w[2] >> 24 & 15);
    add("level", w[3] >> 12 & 15);
    add("single", !seen.single);
}

void footprints(const Lab& lab, Answer& answer, const FootprintKind& kind, uint64_t seed) {
    const TestTexture texture(kind);
    FootprintRig rig(lab);
    for (unsigned form = kPlain; form <= kGrad; ++form) {
        const auto calls = randomCalls(texture, kind, form, seed + form);
        const auto seen = rig.run(calls);
        for (size_t i = 0; i < seen.size(); ++i)
            tell(seen[i], calls[i], i, answer.text);
    }
}

} // namespace

std::vector<Case> footprintCases() {
    const auto of = [](const FootprintKind& kind, uint64_t seed) {
        return [=](const Lab& lab, Answer& answer) { footprints(lab, answer, kind, seed); };
    };
    constexpr auto kWrap = cudaAddressModeWrap, kClamp = cudaAddressModeClamp,
                   kMirror = cudaAddressModeMirror, kBorder = cudaAddressModeBorder;
    return {{"footprints.2x2", of({1024, 512, 7, kMirror, true, 1, 1, 1}, 401)},
            {"footprints.4x2", of({100, 200, 4, kBorder, true, 2, 2, 1}, 402)},
            {"footprints.8x4", of({512, 512, 5, kClamp, true, 4, 3, 2}, 403)},
            {"footprints.16x16", of({2048, 2048, 8, kWrap, true, 7, 4, 4}, 404)},
            {"footprints.64x64", of({4096, 4096, 7, kWrap, true, 11, 6, 6}, 405)},
            {"footprints.64x64_nearest_level", of({4096, 2048, 6, kWrap, false, 11, 6, 6}, 406)},
            {"footprints.256x128", of({8192, 4096, 5, kBorder, true, 14, 8, 7}, 407)}};
}

} // namespace differential
