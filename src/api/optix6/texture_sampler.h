// SPDX-License-Identifier: Apache-2.0
// Texture samplers: the state that applications set, and the texture that programs sample. On CPUs
// the texture reads the buffer's own memory, on GPUs it has a copy. Elements of three components
// are copied on CPUs, too.
#pragma once

#include "api/optix6/buffer.h"

#include <array>
#include <optional>

namespace sunstone::optix6 {

class TextureSampler : public Object {
public:
    static constexpr Kind kKind = Kind::kTextureSampler;
    explicit TextureSampler(const std::shared_ptr<Context>& context);
    // Throws RT_ERROR_INVALID_CONTEXT if something is missing or does not fit.
    void validate() const;
    ~TextureSampler() override;
    // Makes the texture if its state or its buffer has changed. True: the handle is another one.
    bool update();
    void noteChange() { changed_ = true; }
    // The next texture is one of another device.
    void moveTo(const std::shared_ptr<engine::Backend>& backend);

    RTwrapmode wrap[3] = {RT_WRAP_REPEAT, RT_WRAP_REPEAT, RT_WRAP_REPEAT};
    RTfiltermode minFilter = RT_FILTER_LINEAR, magFilter = RT_FILTER_LINEAR,
                 mipFilter = RT_FILTER_NONE;
    float anisotropy = 1, levelMin = 0, levelMax = 1000, levelBias = 0;
    RTtexturereadmode readMode = RT_TEXTURE_READ_NORMALIZED_FLOAT;
    RTtextureindexmode indexMode = RT_TEXTURE_INDEX_NORMALIZED_COORDINATES;
    Ref<Buffer> buffer;
    // Whose texels are those of an image of OpenGL (gl/share.h), in a buffer without a handle.
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
    SharedMemory expanded_; // texels of four components, where the buffer's have three
    bool changed_ = true;
    // Of the buffer when the texture was made.
    const void* data_ = nullptr;
    std::array<uint64_t, 6> shape_{}; // of the buffer: format, sizes, levels, kind
    uint64_t version_ = 0;
};

} // namespace sunstone::optix6
