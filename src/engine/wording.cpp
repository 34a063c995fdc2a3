// SPDX-License-Identifier: Apache-2.0
#include "engine/wording.h"

#include "base/error.h"

namespace sunstone::engine {

const Wording& plainWording() {
    static const Wording wording = {
        [](int32_t) -> const char* { return nullptr; },
        "a ray has a record offset or stride above 15: on processors that use four bits of them it "
        "finds other records",
        "a ray came to a traversable that the pipeline's graph flags exclude, and passed it by",
        "a ray came to motion keys or a motion transform, which the pipeline excludes, and passed "
        "them by",
        [](unsigned declared) {
            return message("a traversable graph has more than the ", declared, " levels declared");
        },
        [](unsigned limit) {
            return message("a ray was traced below depth ", limit,
                           ", the limit of the pipeline; no program ran for it");
        },
        [](uint64_t note, const devlib::SbtView&) {
            return message("record ", uint32_t(note),
                           " is missing or wrong; no program ran for it");
        },
        "the context's API"};
    return wording;
}

} // namespace sunstone::engine
