// SPDX-License-Identifier: Apache-2.0
// The handle tables of texture.h, and the entry of sampling calls, which looks a handle up. The
// tables are never destroyed, because device code may run until the process ends.
#include "texture/texture.h"

#include "base/handles.h"
#include "base/log.h"
#include "texture/device_functions.h"
#include "texture/quick.h"

#include <algorithm>

namespace sunstone::texture {

namespace {

HandleTable<const Texture>& textures() {
    static auto* table = new HandleTable<const Texture>;
    return *table;
}
HandleTable<const Surface>& surfaces() {
    static auto* table = new HandleTable<const Surface>;
    return *table;
}

const void* pointer(uint64_t handle) {
    return reinterpret_cast<const void*>(handle);
}

} // namespace

uint64_t add(std::unique_ptr<Texture> texture) {
    chooseQuick(*texture);
    return reinterpret_cast<uint64_t>(textures().add(std::move(texture)));
}
uint64_t add(std::unique_ptr<Surface> surface) {
    return reinterpret_cast<uint64_t>(surfaces().add(std::move(surface)));
}
const Texture* findTexture(uint64_t handle) {
    return textures().peek(handle);
}
const Surface* findSurface(uint64_t handle) {
    return surfaces().peek(handle);
}
const void* linearMemory(uint64_t handle) {
    const Texture* texture = findTexture(handle);
    return texture && texture->arrays.empty() ? texture->images[0].data : nullptr;
}
void sample(uint64_t handle, uint32_t form, const SampleOperands* operands, uint32_t result[4]) {
    const Texture* texture = textures().peek(handle);
    if (!texture) {
        std::fill_n(result, 4, 0u);
        logOnce(LogLevel::kError, "texture", "a program reads a texture whose handle is not alive");
    } else if (form & texture->quick.otherForms) {
        sampleSlowly(*texture, form, *operands, true, result);
    } else {
        texture->quick.call(*texture, form, *operands, result);
    }
}
bool removeTexture(uint64_t handle) {
    return textures().remove(pointer(handle)) != nullptr;
}
bool removeSurface(uint64_t handle) {
    return surfaces().remove(pointer(handle)) != nullptr;
}

} // namespace sunstone::texture
