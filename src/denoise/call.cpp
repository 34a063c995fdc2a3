// SPDX-License-Identifier: Apache-2.0
#include "denoise/call.h"

#include "base/error.h"

namespace sunstone::denoise {

std::string describe(const CallInputs& inputs, const CallFinding& finding) {
    const auto unusable = [&](const char* name) {
        return message(name, " gives a factor of ", finding.factor,
                       ", which is not a positive number of usable size");
    };
    switch (finding.fault) {
    case CallFault::kOverwritten:
        return message("the denoiser's state memory at ", inputs.state,
                       " was overwritten since its setup");
    case CallFault::kTooSmall:
        return message("the denoiser's state memory at ", inputs.state, " was set up for ",
                       finding.state.width, " x ", finding.state.height, " pixels, inputs have ",
                       inputs.width, " x ", inputs.height);
    case CallFault::kAverageColor:
        return unusable("hdrAverageColor");
    case CallFault::kIntensity:
        return unusable("hdrIntensity");
    case CallFault::kNone:
        break;
    }
    return {};
}

} // namespace sunstone::denoise
