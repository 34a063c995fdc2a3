// SPDX-License-Identifier: Apache-2.0
// Runs texture cases on the device, and stores and compares their results.
#pragma once

#include "forms/run_forms.h"
#include "names.h"
#include "textures/texture_cases.h"

#include <set>

namespace conformance {

struct TextureResults {
    std::string device;
    std::vector<Status> status;               // by case
    std::vector<std::vector<uint32_t>> words; // by case: four of each vector; empty unless done
};

// Runs the cases with `only` in their names, in a separate process.
TextureResults runTextures(const std::string& only);

void saveTextures(const std::string& file, const TextureResults& results);
// Compares with a recording; the lists are those for instructions. Prints; returns the process's
// exit code.
int compareTextures(const std::string& file, const TextureResults& results,
                    const std::set<std::string>& gaps, const Deviations& deviations,
                    const std::string& only);

} // namespace conformance
