// SPDX-License-Identifier: Apache-2.0
// See image_files.h. Source of the Radiance format: Ward, "Real Pixels" (Graphics Gems II), and the
// file format page of the Radiance documentation.
#include "image_files.h"

#include "png_image.h"

#include <ImfRgbaFile.h>
#include <jpeglib.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <csetjmp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>

namespace sunstone::tool {
namespace {

using Pixels = std::vector<float>;

struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Close>;

[[noreturn]] void failWriting(const std::string& path, const std::string& cause) {
    throw std::runtime_error("cannot write " + path + ": " + cause);
}

File create(const std::string& path) {
    File file(std::fopen(path.c_str(), "wb"));
    if (!file)
        failWriting(path, "the file cannot be created");
    return file;
}

void close(const std::string& path, File file) {
    const bool isWhole = !std::ferror(file.get());
    if (std::fclose(file.release()) != 0 || !isWhole)
        failWriting(path, "not all bytes could be written");
}

void writePngImage(const std::string& path, unsigned width, unsigned height, const Pixels& linear) {
    writePng(path, width, height, toSrgb(linear, true));
}

// ---- JPEG ---------------------------------------------------------------------------------------

struct JpegErrors {
    jpeg_error_mgr manager;
    std::jmp_buf jump;
    char text[JMSG_LENGTH_MAX];
};

// Writes all rows. False, with the text, if the library reports an error. Owns no objects, because
// errors leave it by longjmp.
bool compress(JpegErrors& errors, std::FILE* file, unsigned width, unsigned height,
              const uint8_t* rgb) {
    constexpr int kQuality = 95;
    jpeg_compress_struct jpeg{};
    jpeg.err = jpeg_std_error(&errors.manager);
    errors.manager.error_exit = [](j_common_ptr common) {
        auto* const all = reinterpret_cast<JpegErrors*>(common->err);
        common->err->format_message(common, all->text);
        std::longjmp(all->jump, 1);
    };
    if (setjmp(errors.jump) != 0) {
        jpeg_destroy_compress(&jpeg);
        return false;
    }
    jpeg_create_compress(&jpeg);
    jpeg_stdio_dest(&jpeg, file);
    jpeg.image_width = width;
    jpeg.image_height = height;
    jpeg.input_components = 3;
    jpeg.in_color_space = JCS_RGB;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, kQuality, TRUE);
    for (int i = 0; i < jpeg.num_components; ++i) // no chroma subsampling
        jpeg.comp_info[i].h_samp_factor = jpeg.comp_info[i].v_samp_factor = 1;
    jpeg_start_compress(&jpeg, TRUE);
    while (jpeg.next_scanline < height) {
        JSAMPROW row = const_cast<uint8_t*>(rgb + size_t(jpeg.next_scanline) * width * 3);
        jpeg_write_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    return true;
}

void writeJpeg(const std::string& path, unsigned width, unsigned height, const Pixels& linear) {
    const std::vector<uint8_t> rgba = toSrgb(linear, true);
    std::vector<uint8_t> rgb;
    for (size_t i = 0; i < rgba.size(); i += 4)
        rgb.insert(rgb.end(), {rgba[i], rgba[i + 1], rgba[i + 2]});
    File file = create(path);
    JpegErrors errors{};
    if (!compress(errors, file.get(), width, height, rgb.data()))
        failWriting(path, errors.text);
    close(path, std::move(file));
}

// ---- Radiance and OpenEXR -----------------------------------------------------------------------

// Three mantissas of eight bits and their common exponent.
void putRgbe(uint8_t* to, const float* color) {
    float value[3];
    for (int i = 0; i < 3; ++i)
        value[i] = color[i] > 0.0f ? std::min(color[i], 1e37f) : 0.0f; // also NaN
    const float largest = std::max({value[0], value[1], value[2]});
    int exponent = 0;
    const float scale = std::frexp(largest, &exponent) * 256.0f / largest;
    const bool isBlack = largest < 1e-32f;
    for (int i = 0; i < 3; ++i)
        to[i] = isBlack ? 0 : uint8_t(value[i] * scale);
    to[3] = isBlack ? 0 : uint8_t(exponent + 128);
}

// Rows of widths from 8 to 32767 have a mark and store one component after another in runs. A run
// of at most 128 bytes begins with its length. Other rows are plain pixels.
void writeRow(std::FILE* file, unsigned width, const std::vector<uint8_t>& rgbe) {
    if (width < 8 || width > 32767) {
        std::fwrite(rgbe.data(), 1, rgbe.size(), file);
        return;
    }
    std::vector<uint8_t> row = {2, 2, uint8_t(width >> 8), uint8_t(width)};
    for (unsigned component = 0; component < 4; ++component)
        for (unsigned begin = 0; begin < width; begin += 128) {
            const unsigned end = std::min(width, begin + 128);
            row.push_back(uint8_t(end - begin));
            for (unsigned x = begin; x < end; ++x)
                row.push_back(rgbe[x * 4 + component]);
        }
    std::fwrite(row.data(), 1, row.size(), file);
}

void writeRadiance(const std::string& path, unsigned width, unsigned height, const Pixels& linear) {
    File file = create(path);
    std::fprintf(file.get(), "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %u +X %u\n", height, width);
    std::vector<uint8_t> rgbe(size_t(width) * 4);
    for (unsigned y = 0; y < height; ++y) {
        for (unsigned x = 0; x < width; ++x)
            putRgbe(&rgbe[size_t(x) * 4], &linear[(size_t(y) * width + x) * 4]);
        writeRow(file.get(), width, rgbe);
    }
    close(path, std::move(file));
}

void writeExr(const std::string& path, unsigned width, unsigned height, const Pixels& linear) {
    std::vector<Imf::Rgba> pixels(size_t(width) * height);
    for (size_t i = 0; i < pixels.size(); ++i)
        pixels[i] = Imf::Rgba(linear[i * 4], linear[i * 4 + 1], linear[i * 4 + 2]);
    try {
        Imf::RgbaOutputFile file(path.c_str(), int(width), int(height), Imf::WRITE_RGB);
        file.setFrameBuffer(pixels.data(), 1, width);
        file.writePixels(int(height));
    } catch (const std::exception& error) {
        failWriting(path, error.what());
    }
}

struct Format {
    const char* ending;
    void (*write)(const std::string& path, unsigned width, unsigned height, const Pixels& linear);
};
constexpr Format kFormats[] = {{".png", writePngImage},
                               {".jpg", writeJpeg},
                               {".jpeg", writeJpeg},
                               {".hdr", writeRadiance},
                               {".exr", writeExr}};

const Format* formatOf(const std::string& path) {
    std::string ending = std::filesystem::path(path).extension().string();
    for (char& c : ending)
        c = char(std::tolower(static_cast<unsigned char>(c)));
    const auto found = std::find_if(std::begin(kFormats), std::end(kFormats),
                                    [&](const Format& f) { return ending == f.ending; });
    return found == std::end(kFormats) ? nullptr : found;
}

} // namespace

void checkImageName(const std::string& path) {
    if (formatOf(path))
        return;
    std::string known;
    for (const Format& format : kFormats)
        known += std::string(known.empty() ? "" : ", ") + format.ending;
    throw std::runtime_error("cannot write " + path + ": its name ends with none of " + known);
}

void writeImage(const std::string& path, unsigned width, unsigned height,
                const std::vector<float>& linear) {
    checkImageName(path);
    if (linear.size() != size_t(width) * height * 4)
        failWriting(path, "the picture's size is wrong");
    formatOf(path)->write(path, width, height, linear);
}

} // namespace sunstone::tool
