// SPDX-License-Identifier: Apache-2.0
// Writes pictures in the format that the file's name ends with: .png and .jpg (sRGB, bright colours
// compressed softly), .hdr and .exr (linear values as rendered).
#pragma once

#include <string>
#include <vector>

namespace sunstone::tool {

// Throws std::runtime_error with the known endings if the name has none of them.
void checkImageName(const std::string& path);

// `linear` has 4 floats a pixel, top row first, the fourth ignored. Throws std::runtime_error that
// names the file.
void writeImage(const std::string& path, unsigned width, unsigned height,
                const std::vector<float>& linear);

} // namespace sunstone::tool
