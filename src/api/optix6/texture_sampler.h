// SPDX-License-Identifier: Apache-2.0
// Texture samplers: the state that applications set, and the texture that programs sample. On CPUs
// the texture reads the buffer's own memory, except for elements of three components, which are
// copied. On GPUs the texture is always a copy.
#pragma once

#include "api/optix6/buffer.h"

#include <array>
#include <optional>

namespace sunstone::optix6 {

class TextureSampler : public Object {
public:
    static constexpr Kind kKind = Kind::kTextureSampler;
    explicit TextureSampler(const std::shared_ptr<Context>& context);
    // Throws RT_ERROR_INVALID_CONTEXT if a property is missing or does not fit.
    void validate() const;
    ~TextureSampler() override;
    // Makes the texture if its state or its buffer has changed. True: there is a new handle.
    // `variable`: its name, for errors; null for a sampler that programs reach by its id.
    bool update(const std::string* variable);
    void noteChange() { changed_ = true; }
    // Makes the next texture on another device.
    void moveTo(const std::shared_ptr<engine::Backend>& backend);

    RTwrapmode wrap[3] = {RT_WRAP_REPEAT, RT_WRAP_REPEAT, RT_WRAP_REPEAT};
    RTfiltermode minFilter = RT_FILTER_LINEAR, magFilter = RT_FILTER_LINEAR,
                 mipFilter = RT_FILTER_NONE;
    float anisotropy = 1, levelMin = 0, levelMax = 1000, levelBias = 0;
    RTtexturereadmode readMode = RT_TEXTURE_READ_NORMALIZED_FLOAT;
    RTtextureindexmode indexMode = RT_TEXTURE_INDEX_NORMALIZED_COORDINATES;
    Ref<Buffer> buffer;
    // An OpenGL image that provides the texels (gl/share.h), in a buffer without a handle.
    struct GlImage {
        unsigned id;
        RTgltarget target;
        bool isRegistered;
        std::shared_ptr<Buffer> texels;
    };
    std::optional<GlImage> gl;
    int id = 0;
    uint64_t texture = 0; // handle; 0: not made yet

private:
    std::shared_ptr<engine::Backend> backend_;
    SharedMemory expanded_; // texels of four components, if the buffer's have three
    bool changed_ = true;
    // State of the buffer when the texture was made.
    const void* data_ = nullptr;
    std::array<uint64_t, 6> shape_{}; // of the buffer: format, sizes, levels, kind
    uint64_t version_ = 0;
};

} // namespace sunstone::optix6
