// SPDX-License-Identifier: Apache-2.0
// Tests with an OpenGL context from EGL; without EGL they are skipped.
#pragma once

#include "egl.h"
#include "post_support.h"

#include "optix_gl_interop.h"

namespace sunstone::api6 {

using namespace enums;

inline Egl& egl() {
    static auto* made = new Egl;
    return *made;
}

class Gl : public Post {
protected:
    void SetUp() override {
        Post::SetUp();
        if (!egl().reason.empty())
            GTEST_SKIP() << egl().reason;
        ASSERT_TRUE(egl().makeCurrent());
    }
    void TearDown() override {
        Post::TearDown();
        if (egl().reason.empty()) {
            EXPECT_EQ(egl().GetError(), 0u) << "an error of OpenGL is left";
            egl().release();
        }
    }

    template <class T>
    unsigned glBuffer(const std::vector<T>& items) {
        unsigned made = 0;
        egl().GenBuffers(1, &made);
        egl().BindBuffer(kArrayBuffer, made);
        egl().BufferData(kArrayBuffer, ptrdiff_t(items.size() * sizeof(T)), items.data(),
                         kStaticDraw);
        egl().BindBuffer(kArrayBuffer, 0);
        return made;
    }
    void write(unsigned buffer, const std::vector<float>& items) {
        egl().BindBuffer(kArrayBuffer, buffer);
        egl().BufferSubData(kArrayBuffer, 0, ptrdiff_t(items.size() * 4), items.data());
        egl().BindBuffer(kArrayBuffer, 0);
    }
    std::vector<float> read(unsigned buffer, size_t count) {
        std::vector<float> items(count);
        egl().BindBuffer(kArrayBuffer, buffer);
        egl().GetBufferSubData(kArrayBuffer, 0, ptrdiff_t(count * 4), items.data());
        egl().BindBuffer(kArrayBuffer, 0);
        return items;
    }
    RTbuffer shared(unsigned type, unsigned glId, RTformat format, RTsize width, RTsize height) {
        RTbuffer made = nullptr;
        ok(rtBufferCreateFromGLBO(context_, type, glId, &made));
        ok(rtBufferSetFormat(made, format));
        ok(rtBufferSetSize2D(made, width, height));
        return made;
    }
    void setEntries() {
        ok(rtVariableSet1f(variable("scoped"), 0.5f));
        ok(rtContextSetEntryPointCount(context_, 2));
        ok(rtContextSetRayGenerationProgram(context_, 0, program("paint_image")));
        ok(rtContextSetRayGenerationProgram(context_, 1, program("halve_image")));
    }
    unsigned texture(unsigned target) {
        unsigned made = 0;
        egl().GenTextures(1, &made);
        egl().BindTexture(target, made);
        return made;
    }
    RTtexturesampler sampler(unsigned glId, RTgltarget target) {
        RTtexturesampler made = nullptr;
        ok(rtTextureSamplerCreateFromGLImage(context_, glId, target, &made));
        ok(rtTextureSamplerSetFilteringModes(made, RT_FILTER_NEAREST, RT_FILTER_NEAREST,
                                             RT_FILTER_NONE));
        ok(rtTextureSamplerSetReadMode(made, RT_TEXTURE_READ_ELEMENT_TYPE));
        for (unsigned i = 0; i < 3; ++i)
            ok(rtTextureSamplerSetWrapMode(made, i, RT_WRAP_CLAMP_TO_EDGE));
        int id = 0;
        ok(rtTextureSamplerGetId(made, &id));
        ok(rtVariableSet1i(variable("texture_id"), id));
        return made;
    }
};

} // namespace sunstone::api6
