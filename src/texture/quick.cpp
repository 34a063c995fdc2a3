// SPDX-License-Identifier: Apache-2.0
// See quick.h.
#include "texture/quick.h"

#include "texture/fetch.h"

namespace sunstone::texture {

namespace {

// From this size on a position in texels does not fit the integers of the quick functions.
constexpr uint32_t kSizeLimit = 1u << 27;

bool fits(const Texture& texture) {
    for (unsigned i = 0; i < texture.levels; ++i) {
        const Image& image = texture.images[i];
        if (image.width >= kSizeLimit || image.height >= kSizeLimit || image.depth >= kSizeLimit)
            return false;
    }
    return true;
}

bool processorFits() {
    __builtin_cpu_init();
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
           __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") &&
           __builtin_cpu_supports("popcnt");
}

} // namespace

void chooseQuick(Texture& texture) {
    static const bool processor = processorFits();
    const Format& format = texture.format;
    texture.quick = {};
    if (!processor || texture.linearMemory || format.isBlock() || !fits(texture))
        return;
    const bool asFloat = texture.asFloat || format.normalized;
    const bool linear = texture.linear && (asFloat || !format.isInteger());
    const QuickFunctions functions =
        quickFunctions(format, linear, asFloat, texture.srgb || format.srgb);
    texture.quick.image = functions.image;
    texture.quick.call = functions.call;
    texture.quick.fromSrgb = srgbNumbers();
    // With one level the level of detail has no effect; anisotropy takes several samples.
    if (functions.call && texture.levels == 1)
        texture.quick.otherForms =
            kGather | kIntegerCoordinates | (texture.anisotropy > 1 ? kWithGradient : 0);
}

} // namespace sunstone::texture
