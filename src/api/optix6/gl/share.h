// SPDX-License-Identifier: Apache-2.0
// Buffers and texture samplers that share their data with objects of OpenGL. Data is copied: from
// OpenGL before a launch or a map, to OpenGL after a launch that may have written, or an unmap. The
// state of OpenGL is as before after each function here.
#pragma once

#include "api/optix6/context.h"
#include "api/optix6/gl/functions.h"
#include "api/optix6/post/stage.h"

#include <set>

namespace sunstone::optix6::gl {

// Brings registered objects of a context up to date with OpenGL: those that programs can reach, and
// all of them where a launch has to find out which these are. Without such objects it costs
// nothing. Throws Failure.
class Share {
public:
    explicit Share(Context& context);
    // The buffers of a stage that is about to run, too.
    void fetch(const PostProcessingStage& stage);
    // To OpenGL: the elements of buffers that programs or stages may have written.
    void giveBack();

private:
    // Looked up at the first object, since most contexts have none.
    const Functions& gl();

    Context& context_;
    std::optional<Functions> gl_;
    std::set<const Buffer*> fetched_, ofStages_;
};

// Throws Failure if the buffer object behind a buffer does not exist.
void check(const Buffer& buffer);
// Both need room for all elements in the buffer object.
void download(Buffer& buffer);
void upload(const Buffer& buffer);
// Texels and format of the image of a sampler.
void fetch(TextureSampler& sampler);
void fetch(const Functions& gl, TextureSampler& sampler);

} // namespace sunstone::optix6::gl
