// SPDX-License-Identifier: Apache-2.0
// Model loaders: well-formed files of each format, and malformed ones. Each case writes its file
// into a separate folder.
#include "model/model.h"

#include <gtest/gtest.h>

#include <png.h>

#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>

namespace model {
namespace {

class ModelTest : public testing::Test {
protected:
    void SetUp() override {
        folder_ = std::filesystem::temp_directory_path() /
                  ("sunstone_models_" + std::to_string(getpid()));
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::string write(const std::string& name, const std::string& bytes) {
        std::string path = (folder_ / name).string();
        std::ofstream(path, std::ios::binary) << bytes;
        return path;
    }
    Model loadText(const std::string& name, const std::string& bytes) {
        return load(write(name, bytes));
    }
    // The text of the ModelError that loading must throw.
    std::string fault(const std::string& name, const std::string& bytes) {
        std::string path = write(name, bytes);
        try {
            load(path);
        } catch (const ModelError& error) {
            std::string text = error.what();
            EXPECT_EQ(text.find('\n'), std::string::npos) << "one line: " << text;
            EXPECT_EQ(text.rfind(path, 0), 0u) << "begins with the path: " << text;
            return text;
        }
        ADD_FAILURE() << name << " was accepted";
        return "";
    }

    std::filesystem::path folder_;
};

#define EXPECT_CONTAINS(text, part)                                                                \
    do {                                                                                           \
        std::string text_ = (text);                                                                \
        EXPECT_NE(text_.find(part), std::string::npos) << text_;                                   \
    } while (0)

const char* kAsciiPly = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                        "property float y\nproperty float z\nelement face 1\n"
                        "property list uchar int vertex_indices\nend_header\n"
                        "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";

template <class T>
void append(std::string& bytes, T value, bool bigEndian) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    for (size_t i = 0; i < sizeof(T); ++i)
        bytes.push_back(raw[bigEndian ? sizeof(T) - 1 - i : i]);
}

std::string binaryPly(bool bigEndian) {
    std::string bytes = std::string("ply\nformat ") +
                        (bigEndian ? "binary_big_endian" : "binary_little_endian") +
                        " 1.0\nelement vertex 3\nproperty double x\nproperty float y\n"
                        "property short z\nelement face 1\n"
                        "property list uint ushort vertex_index\nend_header\n";
    for (int i = 0; i < 3; ++i) {
        append(bytes, double(i), bigEndian);
        append(bytes, float(i * i), bigEndian);
        append(bytes, int16_t(-i), bigEndian);
    }
    append(bytes, uint32_t(3), bigEndian);
    for (uint16_t i = 0; i < 3; ++i)
        append(bytes, i, bigEndian);
    return bytes;
}

TEST_F(ModelTest, PlyAsciiSplitsPolygonsAndComputesNormals) {
    Model model = loadText("a.ply", kAsciiPly);
    EXPECT_EQ(model.triangles.size(), 2u);
    ASSERT_EQ(model.normals.size(), 4u);
    for (const Vec3& normal : model.normals)
        EXPECT_FLOAT_EQ(normal.z, 1.0f);
    EXPECT_EQ(model.materialOfTriangle.size(), 2u);
    EXPECT_FALSE(model.materials.empty());
}

TEST_F(ModelTest, PlyBinaryOfBothByteOrders) {
    for (bool bigEndian : {false, true}) {
        Model model = loadText("b.ply", binaryPly(bigEndian));
        ASSERT_EQ(model.triangles.size(), 1u);
        EXPECT_FLOAT_EQ(model.positions[2].x, 2.0f);
        EXPECT_FLOAT_EQ(model.positions[2].y, 4.0f);
        EXPECT_FLOAT_EQ(model.positions[2].z, -2.0f);
    }
}

TEST_F(ModelTest, PlyLies) {
    std::string text = kAsciiPly;
    auto replaced = [&](const std::string& from, const std::string& to) {
        std::string copy = text;
        copy.replace(copy.find(from), from.size(), to);
        return copy;
    };
    EXPECT_CONTAINS(fault("1.ply", replaced("vertex 4", "vertex 4000000000")), "ends before");
    EXPECT_CONTAINS(fault("2.ply", replaced("face 1", "face 999999999999")), "ends before");
    EXPECT_CONTAINS(fault("3.ply", replaced("4 0 1 2 3", "4000000000 0 1 2")), "claims more");
    EXPECT_CONTAINS(fault("4.ply", replaced("4 0 1 2 3", "4 0 1 2 77")), "refers to vertex 77");
    EXPECT_CONTAINS(fault("5.ply", replaced("4 0 1 2 3", "4 0 1 2 -3")), "does not exist");
    EXPECT_CONTAINS(fault("6.ply", replaced("4 0 1 2 3", "-4 0 1 2 3")), "claims more");
    EXPECT_CONTAINS(fault("7.ply", replaced("property float x", "property quad x")),
                    "unknown type");
    EXPECT_CONTAINS(fault("8.ply", replaced("ascii", "morse")), "unknown format");
    EXPECT_CONTAINS(fault("9.ply", replaced("1 0 0", "one 0 0")), "is not a number");
    EXPECT_CONTAINS(fault("10.ply", replaced("end_header", "")), "no end_header");
    EXPECT_CONTAINS(fault("11.ply", replaced("property float z\n", "")), "without x, y and z");
    EXPECT_CONTAINS(fault("12.ply", "solid"), "not a PLY file");
    EXPECT_CONTAINS(fault("13.ply", ""), "not a PLY file");
}

TEST_F(ModelTest, TrianglesThatAreNotFiniteAreDropped) {
    Model model = loadText("n.ply", "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                                    "property float y\nproperty float z\nelement face 2\n"
                                    "property list uchar int vertex_indices\nend_header\n"
                                    "0 0 0\n1 0 0\n0 1 0\nnan inf 1e39\n3 0 1 2\n3 1 2 3\n");
    EXPECT_EQ(model.triangles.size(), 1u);
    EXPECT_EQ(model.skippedTriangles, 1u);
    for (const Vec3& position : model.positions)
        EXPECT_TRUE(std::isfinite(position.x + position.y + position.z));
}

TEST_F(ModelTest, ObjCoordinatesThatAreNoNumbers) {
    for (const char* word : {"nan", "-inf", "Infinity", "1e19"}) {
        const Model model = loadText("n.obj", std::string("v 0 0 0\nv 1 0 0\nv 0 1 0\n v\t") +
                                                  word + " 0 0\r\nf 1 2 3\nf 2 3 4\n");
        EXPECT_EQ(model.triangles.size(), 1u) << word;
        EXPECT_EQ(model.skippedTriangles, 1u) << word;
    }
    EXPECT_CONTAINS(fault("x.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), "within 1e18");
}

TEST_F(ModelTest, ObjWithMaterials) {
    write("m.mtl", "newmtl red\nKd 1 0 0\nKe 8 4 0.5\nPr 0.25\n");
    Model model = loadText("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                                    "usemtl red\nf 1 2 3 4\n");
    ASSERT_EQ(model.triangles.size(), 2u);
    const Material& material = model.materials[model.materialOfTriangle[0]];
    EXPECT_FLOAT_EQ(material.color.x, 1.0f);
    EXPECT_FLOAT_EQ(material.color.y, 0.0f);
    EXPECT_FLOAT_EQ(material.roughness, 0.25f);
    EXPECT_FLOAT_EQ(material.emission.x, 8.0f);
    EXPECT_FLOAT_EQ(material.emission.y, 4.0f);
}

// Two squares meeting at a right angle: the edge between them stays sharp; at a shallow angle it is
// smoothed.
TEST_F(ModelTest, MissingNormalsKeepCreases) {
    auto fold = [&](const char* last) {
        return loadText("f.obj", std::string("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n") + last +
                                     "f 1 2 3 4\nf 2 5 6 3\n");
    };
    Model sharp = fold("v 1 0 -1\nv 1 1 -1\n");
    EXPECT_EQ(sharp.positions.size(), 8u);
    for (const Triangle& t : sharp.triangles)
        for (uint32_t v : {t.a, t.b, t.c})
            EXPECT_NEAR(std::max(sharp.normals[v].x, sharp.normals[v].z), 1.0f, 1e-6f);
    Model smooth = fold("v 2 0 -0.2\nv 2 1 -0.2\n");
    EXPECT_EQ(smooth.positions.size(), 6u);
}

TEST_F(ModelTest, ObjFaults) {
    EXPECT_CONTAINS(fault("1.obj", "v 0 0 0\nv 1 0 0\nf 1 2 99\n"), "refers to vertex");
    for (const char* number : {"4000000000", "-4000000000", "99999999999999999999"})
        EXPECT_CONTAINS(fault("9.obj", std::string("v 0 0 0\nv 1 0 0\nf 1/1 2 ") + number + "/3\n"),
                        std::string("refers to vertex ") + number + " of 2");
    fault("2.obj", "v 0 0 0\nf 0 0 0\n");
    EXPECT_CONTAINS(fault("3.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"), "no triangles");
    EXPECT_CONTAINS(fault("4.obj", std::string("\x7f"
                                               "ELF\0\1\2\3",
                                               8)),
                    "no triangles");
}

std::string base64(const std::string& bytes) {
    static const char kDigits[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t group = 0;
        for (size_t k = 0; k < 3; ++k)
            group = group << 8 | (i + k < bytes.size() ? uint8_t(bytes[i + k]) : 0);
        for (int k = 0; k < 4; ++k)
            text.push_back(i + size_t(k) > bytes.size() ? '='
                                                        : kDigits[group >> (18 - 6 * k) & 63]);
    }
    return text;
}

// A file with one triangle; the parts under test can be replaced.
std::string gltf(const std::string& nodes = "[{\"mesh\":0,\"translation\":[5,0,0]}]",
                 const std::string& count = "3", const std::string& extra = "",
                 uint16_t lastIndex = 2) {
    std::string bytes;
    for (float value : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f})
        append(bytes, value, false);
    for (uint16_t index : {uint16_t(0), uint16_t(1), lastIndex})
        append(bytes, index, false);
    return "{\"asset\":{\"version\":\"2.0\"}," + extra +
           "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":" + nodes +
           ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,"
           "\"material\":0}]}],\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":"
           "[0,1,0,1],\"metallicFactor\":0.5}}],\"accessors\":[{\"bufferView\":0,\"componentType\":"
           "5126,\"count\":" +
           count +
           ",\"type\":\"VEC3\"},{\"bufferView\":1,\"componentType\":5123,"
           "\"count\":3,\"type\":\"SCALAR\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},"
           "{\"buffer\":0,\"byteOffset\":36,\"byteLength\":6}],\"buffers\":[{\"byteLength\":42,"
           "\"uri\":"
           "\"data:application/octet-stream;base64," +
           base64(bytes) + "\"}]}";
}

TEST_F(ModelTest, GltfWithNodesAndMaterials) {
    Model model = loadText("a.gltf", gltf());
    ASSERT_EQ(model.triangles.size(), 1u);
    EXPECT_FLOAT_EQ(model.positions[1].x, 6.0f);
    EXPECT_FLOAT_EQ(model.materials[model.materialOfTriangle[0]].color.y, 1.0f);
    EXPECT_FLOAT_EQ(model.materials[model.materialOfTriangle[0]].metallic, 0.5f);
    EXPECT_FLOAT_EQ(model.normals[0].z, 1.0f);
}

TEST_F(ModelTest, GltfFaults) {
    EXPECT_CONTAINS(fault("1.gltf", "{"), "malformed");
    EXPECT_CONTAINS(fault("2.gltf", "{\"asset\":{\"version\":\"1.0\"}}"), "not glTF 2.0");
    EXPECT_CONTAINS(fault("3.gltf", gltf("[{\"mesh\":0,\"children\":[0]}]")), "circular");
    EXPECT_CONTAINS(fault("4.gltf", gltf("[{\"mesh\":7}]")), "does not exist");
    EXPECT_CONTAINS(fault("5.gltf", gltf("[{\"mesh\":0}]", "4000000000")), "claims");
    EXPECT_CONTAINS(fault("6.gltf", gltf("[{\"mesh\":0}]", "18446744073709551615")), "claims");
    EXPECT_CONTAINS(fault("7.gltf", gltf("[{\"mesh\":0}]", "-1")), "whole number");
    EXPECT_CONTAINS(fault("8.gltf", gltf("[{\"mesh\":0}]", "3", "", 9)), "refers to vertex 9");
    EXPECT_CONTAINS(
        fault("9.gltf", gltf("[{\"mesh\":0}]", "3",
                             "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],")),
        "KHR_draco_mesh_compression");
    EXPECT_CONTAINS(fault("10.gltf", gltf("[{\"mesh\":0,\"rotation\":[\"a\",0,0,0]}]")),
                    "no number");
    std::string outside = gltf();
    size_t uri = outside.find("data:");
    outside.replace(uri, outside.find('"', uri) - uri, "../../etc/passwd");
    EXPECT_CONTAINS(fault("11.gltf", outside), "not a file beside it");
    EXPECT_CONTAINS(fault("12.glb", std::string("glTF\2\0\0\0\xff\0\0\0\xff\xff\xff\x7fJSON", 20)),
                    "cut short");
    EXPECT_CONTAINS(fault("13.glb", "glTF"), "cut short");
    fault("14.gltf", std::string(100000, '['));
}

TEST_F(ModelTest, OtherFaults) {
    EXPECT_CONTAINS(fault("a.stl", "solid"), "unknown format");
    EXPECT_THROW(load((folder_ / "missing.ply").string()), ModelError);
    std::filesystem::create_directory(folder_ / "folder.obj");
    EXPECT_THROW(load((folder_ / "folder.obj").string()), ModelError);
}

// With any single byte changed, loading ends with a valid model or with an error.
TEST_F(ModelTest, DamagedFilesNeverBreakAPromise) {
    const unsigned seed = 20240607;
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const std::pair<const char*, std::string> files[] = {
        {"d.ply", kAsciiPly},
        {"d.ply", binaryPly(false)},
        {"d.gltf", gltf()},
        {"d.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\nf -1 -2 -3\n"}};
    int accepted = 0, refused = 0;
    for (const auto& [name, original] : files)
        for (int round = 0; round < 250; ++round) {
            std::string bytes = original;
            for (int change = 0; change < 1 + round % 3; ++change)
                bytes[random() % bytes.size()] = char(random());
            if (round % 5 == 0)
                bytes.resize(random() % bytes.size());
            try {
                Model model = loadText(name, bytes);
                ++accepted;
                ASSERT_FALSE(model.triangles.empty());
                ASSERT_EQ(model.normals.size(), model.positions.size());
                ASSERT_EQ(model.materialOfTriangle.size(), model.triangles.size());
                for (const Triangle& t : model.triangles)
                    ASSERT_LT(std::max({t.a, t.b, t.c}), model.positions.size());
                for (const Vec3& p : model.positions)
                    ASSERT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
            } catch (const ModelError&) {
                ++refused;
            }
        }
    EXPECT_GT(accepted, 0);
    EXPECT_GT(refused, 0);
}

// ---- looks: textures, vertex colours, opacity ----

// A PNG of 2 x 1 texels: opaque red and transparent green.
std::string twoTexels() {
    const uint8_t rgba[8] = {255, 0, 0, 255, 0, 255, 0, 0};
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = 2;
    image.height = 1;
    image.format = PNG_FORMAT_RGBA;
    png_alloc_size_t size = 0;
    png_image_write_to_memory(&image, nullptr, &size, 0, rgba, 0, nullptr);
    std::string bytes(size, 0);
    png_image_write_to_memory(&image, bytes.data(), &size, 0, rgba, 0, nullptr);
    return bytes;
}

const char* kTexturedObj = "mtllib looks.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
                           "usemtl leaf\nf 1/1 2/2 3/3\nusemtl glass\nf 1/1 3/3 2/2\n";
const char* kLooksMtl =
    "newmtl leaf\nKd 1 0.5 1\nmap_Kd leaf.png\nnewmtl glass\nKd 1 1 1\nd 0.25\n";

TEST_F(ModelTest, ObjTexturesAndOpacity) {
    write("leaf.png", twoTexels());
    write("looks.mtl", kLooksMtl);
    const Model model = loadText("looks.obj", kTexturedObj);
    EXPECT_TRUE(model.missing.empty());
    ASSERT_EQ(1u, model.textures.size());
    EXPECT_EQ(2u, model.textures[0].width);
    EXPECT_EQ((std::vector<uint8_t>{255, 0, 0, 255, 0, 255, 0, 0}), model.textures[0].rgba);
    ASSERT_EQ(model.positions.size(), model.texcoords.size());
    const Triangle& t = model.triangles[0];
    EXPECT_EQ(1.0f, model.texcoords[t.a].y) << "OBJ counts from the bottom";
    EXPECT_EQ(1.0f, model.texcoords[t.b].x);
    EXPECT_EQ(0.0f, model.texcoords[t.c].y);
    const Material& leaf = model.materials[model.materialOfTriangle[0]];
    EXPECT_EQ(0, leaf.texture);
    EXPECT_EQ(Alpha::kCutOut, leaf.alpha) << "the texture has a hole";
    const Material& glass = model.materials[model.materialOfTriangle[1]];
    EXPECT_EQ(-1, glass.texture);
    EXPECT_EQ(Alpha::kBlend, glass.alpha);
    EXPECT_EQ(0.25f, glass.opacity);
}

TEST_F(ModelTest, MissingFilesAreNamed) {
    Model model = loadText("looks.obj", kTexturedObj);
    ASSERT_EQ(1u, model.missing.size());
    EXPECT_EQ("refers to \"looks.mtl\", which cannot be opened", model.missing[0]);
    write("looks.mtl", kLooksMtl);
    model = loadText("looks.obj", kTexturedObj);
    ASSERT_EQ(1u, model.missing.size());
    EXPECT_EQ("refers to \"leaf.png\", which cannot be opened", model.missing[0]);
    EXPECT_EQ(-1, model.materials[0].texture);
    for (const char* bytes : {"no picture", "\x89PNG\r\n\x1a\n", "\xFF\xD8\xFF"}) {
        write("leaf.png", bytes);
        model = loadText("looks.obj", kTexturedObj);
        ASSERT_EQ(1u, model.missing.size());
        EXPECT_CONTAINS(model.missing[0], "refers to \"leaf.png\", which is ");
    }
    write("looks.mtl", "newmtl leaf\nmap_Kd ../leaf.png\n");
    model = loadText("looks.obj", kTexturedObj);
    ASSERT_EQ(1u, model.missing.size());
    EXPECT_CONTAINS(model.missing[0], "is not a file beside it");
}

TEST_F(ModelTest, VertexColors) {
    Model model =
        loadText("colors.obj", "v 0 0 0 1 0 0.5\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n");
    ASSERT_EQ(model.positions.size(), model.colors.size());
    EXPECT_EQ(1.0f, model.colors[0].x);
    EXPECT_NEAR(0.2140f, model.colors[0].z, 1e-3f) << "sRGB";
    EXPECT_EQ(1.0f, model.materials[model.materialOfTriangle[0]].color.x);
    model = loadText("colors.ply",
                     "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                     "property float y\nproperty float z\nproperty uchar red\n"
                     "property uchar green\nproperty uchar blue\nproperty uchar alpha\n"
                     "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
                     "0 0 0 255 0 0 255\n1 0 0 0 255 0 51\n0 1 0 0 0 255 255\n3 0 1 2\n");
    ASSERT_EQ(model.positions.size(), model.colors.size());
    EXPECT_EQ(1.0f, model.colors[0].x);
    EXPECT_NEAR(0.2f, model.colors[1].w, 1e-6f);
    EXPECT_EQ(Alpha::kBlend, model.materials[0].alpha);
}

TEST_F(ModelTest, GltfLooks) {
    std::string buffer;
    for (float value : {0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f}) // POSITION
        append(buffer, value, false);
    for (float value : {0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 1.0f}) // TEXCOORD_0
        append(buffer, value, false);
    for (int i = 0; i < 3; ++i) // COLOR_0
        buffer += std::string("\xFF\x80\x00\x40", 4);
    write("looks.bin", buffer);
    write("leaf.png", twoTexels());
    const std::string text = R"({"asset":{"version":"2.0"},
        "buffers":[{"uri":"looks.bin","byteLength":72}],
        "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24},
                       {"buffer":0,"byteOffset":60,"byteLength":12}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
                     {"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"},
                     {"bufferView":2,"componentType":5121,"normalized":true,"count":3,"type":"VEC4"}],
        "images":[{"uri":"leaf.png"},{"uri":"none%20such.png"}],
        "textures":[{"source":0},{"source":1}],
        "materials":[{"alphaMode":"MASK","alphaCutoff":0.3,"pbrMetallicRoughness":
            {"baseColorFactor":[1,1,1,0.5],"baseColorTexture":{"index":0}}},
            {"alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorTexture":{"index":1}}}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1,"COLOR_0":2},
                                  "material":0}]}]})";
    const Model model = loadText("looks.gltf", text);
    ASSERT_EQ(1u, model.textures.size());
    const Material& material = model.materials[0];
    EXPECT_EQ(0, material.texture);
    EXPECT_EQ(Alpha::kCutOut, material.alpha);
    EXPECT_EQ(0.5f, material.opacity);
    EXPECT_NEAR(0.3f, material.cutoff, 1e-6f);
    ASSERT_EQ(model.positions.size(), model.colors.size());
    EXPECT_NEAR(128.0f / 255, model.colors[0].y, 1e-6f) << "linear";
    EXPECT_NEAR(64.0f / 255, model.colors[0].w, 1e-6f);
    EXPECT_EQ(1.0f, model.texcoords[model.triangles[0].c].y);
    ASSERT_EQ(1u, model.missing.size());
    EXPECT_EQ("refers to \"none such.png\", which cannot be opened", model.missing[0]);
    EXPECT_EQ(-1, model.materials[1].texture);
    EXPECT_EQ(Alpha::kBlend, model.materials[1].alpha);
}

} // namespace
} // namespace model
