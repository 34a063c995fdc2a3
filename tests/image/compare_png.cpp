// SPDX-License-Identifier: Apache-2.0
// Compares two PNG images: compare_png A B MAX MEAN. Prints the largest and the mean difference of
// the colour channels (0 to 255) and succeeds if neither exceeds its limit. The mean alone would
// miss a small wrong spot, the maximum alone a faint overall shift.
#include <png.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

namespace {

struct Picture {
    unsigned width = 0, height = 0;
    std::vector<unsigned char> rgb;
};

bool read(const char* path, Picture& picture) {
    png_image image;
    std::memset(&image, 0, sizeof(image));
    image.version = PNG_IMAGE_VERSION;
    if (!png_image_begin_read_from_file(&image, path)) {
        std::fprintf(stderr, "compare_png: %s: %s\n", path, image.message);
        return false;
    }
    image.format = PNG_FORMAT_RGB;
    picture.width = image.width;
    picture.height = image.height;
    picture.rgb.resize(PNG_IMAGE_SIZE(image));
    if (!png_image_finish_read(&image, nullptr, picture.rgb.data(), 0, nullptr)) {
        std::fprintf(stderr, "compare_png: %s: %s\n", path, image.message);
        return false;
    }
    return true;
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 5) {
        std::fprintf(stderr, "usage: compare_png A.png B.png MAX MEAN\n");
        return 2;
    }
    Picture a, b;
    if (!read(argv[1], a) || !read(argv[2], b))
        return 2;
    if (a.width != b.width || a.height != b.height) {
        std::fprintf(stderr, "compare_png: %u x %u against %u x %u pixels\n", a.width, a.height,
                     b.width, b.height);
        return 1;
    }
    int largest = 0;
    size_t largestAt = 0;
    double sum = 0.0;
    for (size_t i = 0; i < a.rgb.size(); ++i) {
        int difference = std::abs(int(a.rgb[i]) - int(b.rgb[i]));
        sum += difference;
        if (difference > largest) {
            largest = difference;
            largestAt = i / 3;
        }
    }
    double mean = a.rgb.empty() ? 0.0 : sum / double(a.rgb.size());
    bool same = largest <= std::atoi(argv[3]) && mean <= std::atof(argv[4]);
    std::printf("%s: largest difference %d at (%zu, %zu), mean %.4f; limits %s and %s\n",
                same ? "alike" : "DIFFERENT", largest, largestAt % a.width, largestAt / a.width,
                mean, argv[3], argv[4]);
    return same ? 0 : 1;
}
