// SPDX-License-Identifier: Apache-2.0
// Buffers and texture samplers that share their data with OpenGL objects. Data is copied: from
// OpenGL before a launch or a map, to OpenGL after an unmap or a launch that may have written. Each
// function here restores the state of OpenGL.
#pragma once

#include "api/optix6/context.h"
#include "api/optix6/gl/functions.h"
#include "api/optix6/post/stage.h"

#include <set>

namespace sunstone::optix6::gl {

// Updates registered objects of a context from OpenGL: those that programs can reach, or all of
// them if only the launch can determine these. Costs nothing without such objects. Throws Failure.
class Share {
public:
    explicit Share(Context& context);
    // Also updates the buffers of a stage that runs next.
    void fetch(const PostProcessingStage& stage);
    // Copies to OpenGL: the elements of buffers that programs or stages may have written.
    void giveBack();

private:
    // Looked up for the first object, because most contexts have none.
    const Functions& gl();

    Context& context_;
    std::optional<Functions> gl_;
    std::set<const Buffer*> fetched_, ofStages_;
};

// Throws Failure if the buffer object behind a buffer does not exist.
void check(const Buffer& buffer);
// Both functions need room for all elements in the buffer object.
void download(Buffer& buffer);
void upload(const Buffer& buffer);
// Fetches texels and format of a sampler's image.
void fetch(TextureSampler& sampler);
void fetch(const Functions& gl, TextureSampler& sampler);

} // namespace sunstone::optix6::gl
