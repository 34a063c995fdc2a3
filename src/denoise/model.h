// SPDX-License-Identifier: Apache-2.0
// The kind of a denoiser, and the container for users' own settings. docs/denoiser.md describes the
// container (all values little-endian, no padding).
#pragma once

#include "denoise/filter.h"
#include "denoise/guided_filter.h"

#include <memory>
#include <string>

namespace sunstone::denoise {

enum class Kind : uint8_t {
    kLimited,
    kHighRange,
    kLayers,
    kTemporal,
    kTemporalLayers,
    kTwice, // outputs are twice as wide and high
    kTemporalTwice,
};

inline bool isTwice(Kind kind) {
    return kind == Kind::kTwice || kind == Kind::kTemporalTwice;
}
inline bool takesLayers(Kind kind) {
    return kind == Kind::kLayers || kind == Kind::kTemporalLayers || isTwice(kind);
}
inline bool isTemporal(Kind kind) {
    return kind == Kind::kTemporal || kind == Kind::kTemporalLayers || kind == Kind::kTemporalTwice;
}

struct Model {
    Kind kind = Kind::kHighRange;
    bool usesAlbedo = false;
    bool usesNormal = false;
    FilterSettings settings;
};

// Planes of guides in its frames.
inline int guidePlanesOf(const Model& model) {
    return (model.usesAlbedo ? 3 : 0) + (model.usesNormal ? isTemporal(model.kind) ? 3 : 2 : 0);
}

std::unique_ptr<Filter> makeFilter(const Model& model);

// Reads a container. False, with the reason, if the bytes are not one.
bool parseModel(const void* bytes, size_t size, Model& model, std::string& reason);

} // namespace sunstone::denoise
