// SPDX-License-Identifier: Apache-2.0
// Pictures of textures, through libpng and libjpeg.
#include "model.h"

#include <cstdio>

#include <jpeglib.h>
#include <png.h>

#include <csetjmp>

namespace model {
namespace {

constexpr unsigned kMostSide = 16384;

void checkSize(unsigned width, unsigned height) {
    if (width == 0 || height == 0 || width > kMostSide || height > kMostSide)
        throw ModelError("is a picture of " + std::to_string(width) + " x " +
                         std::to_string(height) + " pixels");
}

Texture decodePng(const std::string& bytes) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    if (!png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()))
        throw ModelError(std::string("is no PNG picture: ") + image.message);
    Texture texture = {image.width, image.height, {}};
    try {
        checkSize(image.width, image.height);
        image.format = PNG_FORMAT_RGBA;
        texture.rgba.resize(PNG_IMAGE_SIZE(image));
    } catch (...) {
        png_image_free(&image);
        throw;
    }
    if (!png_image_finish_read(&image, nullptr, texture.rgba.data(), 0, nullptr))
        throw ModelError(std::string("is a damaged PNG picture: ") + image.message);
    return texture;
}

struct JpegErrors {
    jpeg_error_mgr manager;
    std::jmp_buf jump;
    char text[JMSG_LENGTH_MAX];
};

// Reads the size, and with `rgba` the texels. False, with the text, if the library reports an
// error. Owns no objects, because errors leave it by longjmp.
bool decompress(JpegErrors& errors, const std::string& bytes, unsigned& width, unsigned& height,
                uint8_t* rgba) {
    jpeg_decompress_struct jpeg{};
    jpeg.err = jpeg_std_error(&errors.manager);
    errors.manager.output_message = [](j_common_ptr) {};
    errors.manager.error_exit = [](j_common_ptr common) {
        auto* const all = reinterpret_cast<JpegErrors*>(common->err);
        common->err->format_message(common, all->text);
        std::longjmp(all->jump, 1);
    };
    if (setjmp(errors.jump) != 0) {
        jpeg_destroy_decompress(&jpeg);
        return false;
    }
    jpeg_create_decompress(&jpeg);
    jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
    jpeg_read_header(&jpeg, TRUE);
    width = jpeg.image_width;
    height = jpeg.image_height;
    if (rgba) {
        jpeg.out_color_space = JCS_EXT_RGBA; // alpha is 255
        jpeg_start_decompress(&jpeg);
        while (jpeg.output_scanline < jpeg.output_height) {
            JSAMPROW row = rgba + size_t(jpeg.output_scanline) * width * 4;
            jpeg_read_scanlines(&jpeg, &row, 1);
        }
    }
    jpeg_destroy_decompress(&jpeg);
    return true;
}

Texture decodeJpeg(const std::string& bytes) {
    JpegErrors errors{};
    Texture texture;
    if (!decompress(errors, bytes, texture.width, texture.height, nullptr))
        throw ModelError(std::string("is no JPEG picture: ") + errors.text);
    checkSize(texture.width, texture.height);
    texture.rgba.resize(size_t(texture.width) * texture.height * 4);
    if (!decompress(errors, bytes, texture.width, texture.height, texture.rgba.data()))
        throw ModelError(std::string("is a damaged JPEG picture: ") + errors.text);
    return texture;
}

} // namespace

Texture decodePicture(const std::string& bytes) {
    if (bytes.rfind("\x89PNG", 0) == 0)
        return decodePng(bytes);
    if (bytes.rfind("\xFF\xD8", 0) == 0)
        return decodeJpeg(bytes);
    throw ModelError("is neither a PNG nor a JPEG picture");
}

} // namespace model
