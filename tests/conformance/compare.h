// SPDX-License-Identifier: Apache-2.0
// Compares results of a form with a recording, by the rules of the form's outputs.
#pragma once

#include "forms/forms.h"

#include <cstdint>
#include <string>
#include <vector>

namespace conformance {

// Vectors that differ by more than the rule of their output allows; the first few in words.
struct Difference {
    unsigned vectors = 0;
    std::string text;
    uint32_t digest = 0; // of their numbers and results
};
Difference compare(const Form& form, const std::vector<uint8_t>& recorded,
                   const std::vector<uint8_t>& results);

} // namespace conformance
