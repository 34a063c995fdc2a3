// SPDX-License-Identifier: Apache-2.0
// `sunstone render` of a model with a texture, a hole in the texture, vertex colours, and invisible
// glass.
#include <png.h>

#include <gtest/gtest.h>

#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <vector>

namespace {

namespace fs = std::filesystem;

// In front a square whose left half is red and whose right half is a hole; before all of it glass
// of opacity 0; behind it a wall, blue by the colours of its vertices.
constexpr const char* kModel = R"(mtllib looks.mtl
v -1 -1 0 1 1 1
v 1 -1 0 1 1 1
v 1 1 0 1 1 1
v -1 1 0 1 1 1
v -3 -3 -1 0 0 1
v 3 -3 -1 0 0 1
v 3 3 -1 0 0 1
v -3 3 -1 0 0 1
v -3 -3 1 1 1 1
v 3 -3 1 1 1 1
v 3 3 1 1 1 1
v -3 3 1 1 1 1
vt 0 0
vt 1 0
vt 1 1
vt 0 1
usemtl square
f 1/1 2/2 3/3 4/4
usemtl white
f 5 6 7 8
usemtl glass
f 9 10 11 12
)";
constexpr const char* kMaterials = "newmtl square\nKd 1 1 1\nmap_Kd square.png\nnewmtl white\n"
                                   "Kd 1 1 1\nnewmtl glass\nKd 0 1 0\nd 0\n";

void writePicture(const fs::path& path) {
    const uint8_t rgba[8] = {255, 0, 0, 255, 0, 255, 0, 0};
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = 2;
    image.height = 1;
    image.format = PNG_FORMAT_RGBA;
    ASSERT_TRUE(png_image_write_to_file(&image, path.c_str(), 0, rgba, 0, nullptr));
}

TEST(RenderLooks, TexturesHolesColorsAndGlass) {
    const fs::path folder =
        fs::path(testing::TempDir()) / ("sunstone_looks_" + std::to_string(getpid()));
    fs::create_directories(folder);
    std::ofstream(folder / "looks.obj") << kModel;
    std::ofstream(folder / "looks.mtl") << kMaterials;
    writePicture(folder / "square.png");
    const std::string command = std::string(SUNSTONE_TOOL) + " render " +
                                (folder / "looks.obj").string() +
                                " --no-ground --camera 0 0 5 --look-at 0 0 0 --fov 30 --width 64"
                                " --height 64 --spp 8 --bounces 1 -o " +
                                (folder / "looks.png").string() + " 2> /dev/null > /dev/null";
    ASSERT_EQ(0, std::system(command.c_str()));
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    ASSERT_TRUE(png_image_begin_read_from_file(&image, (folder / "looks.png").c_str()));
    image.format = PNG_FORMAT_RGB;
    std::vector<uint8_t> pixels(PNG_IMAGE_SIZE(image));
    ASSERT_TRUE(png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr));
    const auto at = [&](unsigned x, unsigned y) {
        const uint8_t* p = &pixels[(y * 64 + x) * 3];
        return std::array<int, 3>{p[0], p[1], p[2]};
    };
    const auto left = at(20, 32), right = at(44, 32), outside = at(4, 32);
    EXPECT_GT(left[0], 2 * left[1]) << "red";
    EXPECT_GT(left[0], 2 * left[2]);
    for (const auto& wall : {right, outside}) {
        EXPECT_GT(wall[2], 2 * wall[0]) << "the blue wall";
        EXPECT_GT(wall[2], 2 * wall[1]);
    }
    fs::remove_all(folder);
}

} // namespace
