// SPDX-License-Identifier: Apache-2.0
// Writes pictures of every format and reads them again.
#include "image_files.h"
#include "png_image.h"

#include <ImfRgbaFile.h>
#include <jpeglib.h>
#include <png.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>

namespace sunstone::tool {
namespace {

struct Size {
    unsigned width, height;
};
// Sizes for which the Radiance format has plain rows, marked rows, and rows of several runs.
constexpr Size kSizes[] = {{1, 1}, {5, 3}, {8, 2}, {300, 7}};

std::string pathOf(const char* name) {
    return testing::TempDir() + "sunstone_picture" + name;
}

// Smooth, so that JPEG keeps it; from black to far above one.
std::vector<float> pictureOf(Size size) {
    std::vector<float> linear;
    for (unsigned y = 0; y < size.height; ++y)
        for (unsigned x = 0; x < size.width; ++x) {
            const float u = float(x) / 300.0f, v = float(y) / 7.0f;
            linear.insert(linear.end(), {u * 4.0f, 0.25f + v * 0.5f, 1.0f - u, 1.0f});
        }
    return linear;
}

TEST(ImageFiles, Png) {
    for (const Size size : kSizes) {
        const auto linear = pictureOf(size);
        writeImage(pathOf(".png"), size.width, size.height, linear);
        png_image image{};
        image.version = PNG_IMAGE_VERSION;
        ASSERT_TRUE(png_image_begin_read_from_file(&image, pathOf(".png").c_str()));
        image.format = PNG_FORMAT_RGBA;
        std::vector<uint8_t> pixels(PNG_IMAGE_SIZE(image));
        ASSERT_TRUE(png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr));
        EXPECT_EQ(size.width, image.width);
        EXPECT_EQ(toSrgb(linear, true), pixels);
    }
}

TEST(ImageFiles, Jpeg) {
    for (const char* name : {".jpg", ".JPEG"})
        for (const Size size : kSizes) {
            const auto linear = pictureOf(size);
            writeImage(pathOf(name), size.width, size.height, linear);
            std::FILE* const file = std::fopen(pathOf(name).c_str(), "rb");
            ASSERT_NE(nullptr, file);
            jpeg_decompress_struct jpeg{};
            jpeg_error_mgr errors{};
            jpeg.err = jpeg_std_error(&errors);
            jpeg_create_decompress(&jpeg);
            jpeg_stdio_src(&jpeg, file);
            jpeg_read_header(&jpeg, TRUE);
            jpeg_start_decompress(&jpeg);
            ASSERT_EQ(size.width, jpeg.output_width);
            ASSERT_EQ(size.height, jpeg.output_height);
            ASSERT_EQ(3, jpeg.output_components);
            const std::vector<uint8_t> wanted = toSrgb(linear, true);
            std::vector<uint8_t> row(size.width * 3);
            for (unsigned y = 0; y < size.height; ++y) {
                JSAMPROW start = row.data();
                jpeg_read_scanlines(&jpeg, &start, 1);
                for (unsigned x = 0; x < size.width; ++x)
                    for (unsigned c = 0; c < 3; ++c)
                        ASSERT_NEAR(wanted[(y * size.width + x) * 4 + c], row[x * 3 + c], 12)
                            << x << " " << y;
            }
            jpeg_finish_decompress(&jpeg);
            jpeg_destroy_decompress(&jpeg);
            std::fclose(file);
        }
}

TEST(ImageFiles, Exr) {
    for (const Size size : kSizes) {
        const auto linear = pictureOf(size);
        writeImage(pathOf(".exr"), size.width, size.height, linear);
        Imf::RgbaInputFile file(pathOf(".exr").c_str());
        ASSERT_EQ(int(size.width) - 1, file.dataWindow().max.x);
        ASSERT_EQ(int(size.height) - 1, file.dataWindow().max.y);
        std::vector<Imf::Rgba> pixels(size_t(size.width) * size.height);
        file.setFrameBuffer(pixels.data(), 1, size.width);
        file.readPixels(0, int(size.height) - 1);
        for (size_t i = 0; i < pixels.size(); ++i) {
            EXPECT_NEAR(linear[i * 4], float(pixels[i].r), 2e-3f);
            EXPECT_NEAR(linear[i * 4 + 2], float(pixels[i].b), 2e-3f);
        }
    }
}

// Decodes the form that this library writes: literal runs, or plain rows.
std::vector<uint8_t> readRadiance(const std::string& path, Size size) {
    std::ifstream file(path, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(file), {}};
    const std::string head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " +
                             std::to_string(size.height) + " +X " + std::to_string(size.width) +
                             "\n";
    EXPECT_EQ(0u, text.find(head));
    size_t at = head.size();
    const auto next = [&] { return at < text.size() ? uint8_t(text[at++]) : uint8_t(0); };
    std::vector<uint8_t> rgbe(size_t(size.width) * size.height * 4);
    for (unsigned y = 0; y < size.height; ++y) {
        uint8_t* const row = &rgbe[size_t(y) * size.width * 4];
        if (size.width < 8) {
            for (unsigned i = 0; i < size.width * 4; ++i)
                row[i] = next();
            continue;
        }
        EXPECT_EQ(2, next());
        EXPECT_EQ(2, next());
        EXPECT_EQ(size.width >> 8, next());
        EXPECT_EQ(size.width & 255, next());
        for (unsigned c = 0; c < 4; ++c)
            for (unsigned x = 0; x < size.width;)
                for (unsigned run = next(), i = 0; i < std::max(run, 1u); ++i, ++x)
                    row[std::min(x, size.width - 1) * 4 + c] = next();
    }
    EXPECT_EQ(text.size(), at);
    return rgbe;
}

TEST(ImageFiles, Radiance) {
    for (const Size size : kSizes) {
        auto linear = pictureOf(size);
        linear[0] = std::numeric_limits<float>::quiet_NaN();
        linear[1] = linear[2] = -1.0f; // a black pixel
        writeImage(pathOf(".hdr"), size.width, size.height, linear);
        const auto rgbe = readRadiance(pathOf(".hdr"), size);
        for (size_t i = 0; i < linear.size(); i += 4) {
            const float scale = std::ldexp(1.0f, rgbe[i + 3] - 136);
            const float largest = i == 0 ? 0 : std::max({linear[i], linear[i + 1], linear[i + 2]});
            for (size_t c = 0; c < 3; ++c)
                EXPECT_NEAR(i == 0 ? 0 : linear[i + c], float(rgbe[i + c]) * scale, largest / 128)
                    << i;
        }
    }
}

TEST(ImageFiles, Refused) {
    for (const char* name : {"picture.gif", "picture", "picture.png.txt", ".png"})
        try {
            checkImageName(name);
            ADD_FAILURE() << name;
        } catch (const std::runtime_error& error) {
            EXPECT_STREQ((std::string("cannot write ") + name +
                          ": its name ends with none of .png, .jpg, .jpeg, .hdr, .exr")
                             .c_str(),
                         error.what());
        }
    for (const char* ending : {".png", ".jpg", ".hdr", ".exr"})
        EXPECT_THROW(
            writeImage(std::string("/no/such/folder/picture") + ending, 1, 1, pictureOf({1, 1})),
            std::runtime_error);
}

} // namespace
} // namespace sunstone::tool
