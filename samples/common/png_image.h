// SPDX-License-Identifier: Apache-2.0
// Writes pictures as PNG files.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

// `rgba` has width * height pixels of 4 bytes, top row first. Throws std::runtime_error if the
// sizes do not agree or the file cannot be written.
void writePng(const std::string& path, unsigned width, unsigned height,
              const std::vector<uint8_t>& rgba);

// Linear colours (4 floats a pixel, the fourth ignored) to sRGB bytes. `filmic` compresses bright
// colours softly; without it they are cut at one.
std::vector<uint8_t> toSrgb(const std::vector<float>& linear, bool filmic);
