// SPDX-License-Identifier: Apache-2.0
#include "denoise/model.h"

#include "base/error.h"

#include <cmath>
#include <cstring>

namespace sunstone::denoise {
namespace {

constexpr char kMagic[8] = {'S', 'U', 'N', 'D', 'E', 'N', 'O', 'I'};
constexpr uint32_t kVersion = 1;
constexpr uint32_t kGuidedFilter = 1; // the only content known to version 1

struct Container {
    char magic[8];
    uint32_t version;
    uint32_t size;           // of the whole container
    uint32_t weightSetCount; // must be 1
    uint32_t content;
    uint32_t kind;   // 0 LDR, 1 HDR, 2 AOV, 3 temporal, 4 temporal AOV
    uint32_t guides; // 1 albedo, 2 normal
    uint32_t passes;
    float colorTolerance, albedoTolerance, normalTolerance, historyWeight;
    uint32_t checksum; // FNV-1a of everything before it
};
static_assert(sizeof(Container) == 56);

uint32_t checksumOf(const uint8_t* bytes, size_t size) {
    uint32_t hash = 2166136261u;
    for (size_t i = 0; i < size; ++i)
        hash = (hash ^ bytes[i]) * 16777619u;
    return hash;
}

bool isTolerance(float value) {
    return value >= 1e-3f && value <= 1e3f;
}

std::string faultOf(const Container& c) {
    if (std::memcmp(c.magic, kMagic, sizeof(kMagic)) != 0)
        return "it does not begin with the magic of a Sunstone denoiser model";
    if (c.version != kVersion)
        return message("its version ", c.version, " is not ", kVersion);
    if (c.size != sizeof(Container))
        return message("it says it has ", c.size, " bytes instead of ", sizeof(Container));
    if (checksumOf(reinterpret_cast<const uint8_t*>(&c), offsetof(Container, checksum)) !=
        c.checksum)
        return "its checksum does not fit its contents";
    if (c.weightSetCount != 1)
        return message("it exports ", c.weightSetCount, " weight sets instead of 1");
    if (c.content != kGuidedFilter)
        return message("its content ", c.content, " is unknown");
    if (c.kind > uint32_t(Kind::kTemporalLayers))
        return message("its kind ", c.kind, " is unknown");
    if (c.guides > 3)
        return message("its guides ", c.guides, " are unknown");
    if (c.passes < 1 || c.passes > kMaxPasses)
        return message("its number of passes ", c.passes, " is not 1 to ", kMaxPasses);
    if (!isTolerance(c.colorTolerance) || !isTolerance(c.albedoTolerance) ||
        !isTolerance(c.normalTolerance))
        return "a tolerance is not between 0.001 and 1000";
    if (!(c.historyWeight >= 0.0f && c.historyWeight < 1.0f))
        return message("its history weight ", c.historyWeight, " is not in [0, 1)");
    return {};
}

} // namespace

std::unique_ptr<Filter> makeFilter(const Model& model) {
    return std::make_unique<GuidedFilter>(model.settings, isTwice(model.kind) ? 2 : 1);
}

bool parseModel(const void* bytes, size_t size, Model& model, std::string& reason) {
    Container container;
    if (size != sizeof(container)) {
        reason =
            message("it has ", size, " bytes, a Sunstone denoiser model has ", sizeof(container));
        return false;
    }
    std::memcpy(&container, bytes, size);
    reason = faultOf(container);
    if (!reason.empty())
        return false;
    model.kind = Kind(container.kind);
    model.usesAlbedo = (container.guides & 1) != 0;
    model.usesNormal = (container.guides & 2) != 0;
    model.settings = {container.passes, container.colorTolerance, container.albedoTolerance,
                      container.normalTolerance, container.historyWeight};
    return true;
}

} // namespace sunstone::denoise
