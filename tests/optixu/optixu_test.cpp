// SPDX-License-Identifier: Apache-2.0
// The exported functions of optixu.h: names, sizes, and CUDA sources compiled to PTX.
#include <optixu/optixu.h>

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace {

std::string nameOf(unsigned type, size_t size = 64) {
    std::vector<char> buffer(size + 1, '#');
    EXPECT_EQ(rtuNameForType(static_cast<RTobjecttype>(type), buffer.data(), size), RT_SUCCESS);
    EXPECT_EQ(buffer[size], '#');
    return buffer.data();
}

TEST(Optixu, NamesOfTypes) {
    EXPECT_EQ(nameOf(RT_OBJECTTYPE_UNKNOWN), "UNKNOWN");
    EXPECT_EQ(nameOf(RT_OBJECTTYPE_GROUP), "GROUP");
    EXPECT_EQ(nameOf(RT_OBJECTTYPE_GEOMETRY_GROUP), "GEOMETRY_GROUP");
    EXPECT_EQ(nameOf(RT_OBJECTTYPE_OBJECT), "OBJECT");
    EXPECT_EQ(nameOf(RT_OBJECTTYPE_MATRIX_FLOAT3x4), "MATRIX_FLOAT3x4");
    EXPECT_EQ(nameOf(RT_OBJECTTYPE_FLOAT), "FLOAT");
    EXPECT_EQ(nameOf(RT_OBJECTTYPE_FLOAT3), "FLOAT3");
    EXPECT_EQ(nameOf(RT_OBJECTTYPE_UNSIGNED_INT4), "UNSIGNED_INT4");
    EXPECT_EQ(nameOf(RT_OBJECTTYPE_POSTPROCESSINGSTAGE), "POSTPROCESSINGSTAGE");
    EXPECT_EQ(nameOf(RT_OBJECTTYPE_UNSIGNED_LONG_LONG4), "UNSIGNED_LONG_LONG4");
    for (unsigned type = RT_OBJECTTYPE_UNKNOWN; type <= RT_OBJECTTYPE_UNSIGNED_LONG_LONG4; ++type)
        EXPECT_GE(nameOf(type).size(), 3u) << type;
    EXPECT_EQ(nameOf(RT_OBJECTTYPE_GROUP, 4), "GRO");
    EXPECT_EQ(nameOf(RT_OBJECTTYPE_GROUP, 1), "");
    char buffer[8];
    EXPECT_EQ(rtuNameForType(RT_OBJECTTYPE_GROUP, buffer, 0), RT_ERROR_INVALID_VALUE);
    EXPECT_EQ(rtuNameForType(RT_OBJECTTYPE_GROUP, nullptr, 8), RT_ERROR_INVALID_VALUE);
    for (unsigned bad :
         {0u, RT_OBJECTTYPE_UNKNOWN - 1u, RT_OBJECTTYPE_UNSIGNED_LONG_LONG4 + 1u, ~0u})
        EXPECT_EQ(rtuNameForType(static_cast<RTobjecttype>(bad), buffer, 8),
                  RT_ERROR_INVALID_VALUE);
}

size_t sizeOf(unsigned format) {
    size_t size = 99;
    EXPECT_EQ(rtuGetSizeForRTformat(static_cast<RTformat>(format), &size), RT_SUCCESS) << format;
    return size;
}

TEST(Optixu, SizesOfFormats) {
    EXPECT_EQ(sizeOf(RT_FORMAT_UNKNOWN), 0u);
    EXPECT_EQ(sizeOf(RT_FORMAT_USER), 0u);
    EXPECT_EQ(sizeOf(RT_FORMAT_BUFFER_ID), 4u);
    EXPECT_EQ(sizeOf(RT_FORMAT_PROGRAM_ID), 4u);
    for (unsigned n = 0; n < 4; ++n) {
        EXPECT_EQ(sizeOf(RT_FORMAT_FLOAT + n), 4 * (n + 1));
        EXPECT_EQ(sizeOf(RT_FORMAT_BYTE + n), n + 1);
        EXPECT_EQ(sizeOf(RT_FORMAT_UNSIGNED_BYTE + n), n + 1);
        EXPECT_EQ(sizeOf(RT_FORMAT_SHORT + n), 2 * (n + 1));
        EXPECT_EQ(sizeOf(RT_FORMAT_UNSIGNED_SHORT + n), 2 * (n + 1));
        EXPECT_EQ(sizeOf(RT_FORMAT_INT + n), 4 * (n + 1));
        EXPECT_EQ(sizeOf(RT_FORMAT_UNSIGNED_INT + n), 4 * (n + 1));
        EXPECT_EQ(sizeOf(RT_FORMAT_HALF + n), 2 * (n + 1));
        EXPECT_EQ(sizeOf(RT_FORMAT_LONG_LONG + n), 8 * (n + 1));
        EXPECT_EQ(sizeOf(RT_FORMAT_UNSIGNED_LONG_LONG + n), 8 * (n + 1));
    }
    for (unsigned small : {RT_FORMAT_UNSIGNED_BC1, RT_FORMAT_UNSIGNED_BC4, RT_FORMAT_BC4})
        EXPECT_EQ(sizeOf(small), 8u);
    for (unsigned large :
         {RT_FORMAT_UNSIGNED_BC2, RT_FORMAT_UNSIGNED_BC3, RT_FORMAT_UNSIGNED_BC5, RT_FORMAT_BC5,
          RT_FORMAT_UNSIGNED_BC6H, RT_FORMAT_BC6H, RT_FORMAT_UNSIGNED_BC7})
        EXPECT_EQ(sizeOf(large), 16u);
    size_t size;
    for (unsigned bad : {0u, RT_FORMAT_UNKNOWN - 1u, RT_FORMAT_UNSIGNED_BC7 + 1u, ~0u})
        EXPECT_EQ(rtuGetSizeForRTformat(static_cast<RTformat>(bad), &size), RT_ERROR_INVALID_VALUE);
    EXPECT_EQ(rtuGetSizeForRTformat(RT_FORMAT_INT, nullptr), RT_ERROR_INVALID_VALUE);
}

// ---- Compilation
// ----------------------------------------------------------------------------------

const char* const kSource = "#include <optixu/optixu_math_namespace.h>\n"
                            "using namespace optix;\n"
                            "__device__ int kept;\n"
                            "extern \"C\" __global__ void run(float3* p) {\n"
                            "    *p = normalize(*p) * FACTOR;\n"
                            "}\n";
const char* const kInclude = "-I" OPTIX6_INCLUDE;

struct Sizes {
    RTsize result = 99, error = 99;
};

// The texts of the latest compilation, which must have these sizes.
std::pair<std::string, std::string> texts(const Sizes& sizes) {
    std::vector<char> result(sizes.result + 1, '#'), error(sizes.error + 1, '#');
    EXPECT_EQ(rtuCUDAGetCompileResult(result.data(), error.data()), RT_SUCCESS);
    EXPECT_EQ(result[sizes.result], '#');
    EXPECT_EQ(error[sizes.error], '#');
    EXPECT_EQ(std::strlen(error.data()) + 1, sizes.error);
    if (sizes.result)
        EXPECT_EQ(std::strlen(result.data()) + 1, sizes.result);
    return {sizes.result ? result.data() : "", error.data()};
}

TEST(Optixu, StringsBecomePtx) {
    const char* arguments[] = {kInclude, "-DFACTOR=2.0f"};
    Sizes sizes;
    ASSERT_EQ(rtuCUDACompileString(kSource, arguments, 2, &sizes.result, &sizes.error), RT_SUCCESS)
        << texts(sizes).second;
    const auto [ptx, messages] = texts(sizes);
    EXPECT_NE(ptx.find(".entry run"), std::string::npos) << ptx;
    EXPECT_NE(ptx.find("kept"), std::string::npos);
    EXPECT_EQ(messages, "");
    EXPECT_EQ(rtuCUDAGetCompileResult(nullptr, nullptr), RT_SUCCESS);
}

// These functions date from the time when nvcc was the compiler.
TEST(Optixu, OptionsAreThoseOfNvcc) {
    const char* arguments[] = {kInclude,
                               "-D",
                               "FACTOR=2.0f",
                               "-arch=sm_30",
                               "--gpu-architecture",
                               "compute_50",
                               "-m64",
                               "-ptx",
                               "-lineinfo",
                               "-rdc=true",
                               "--use_fast_math",
                               "-Xptxas",
                               "-v",
                               "-G",
                               "-std=c++11",
                               "-gencode",
                               "arch=compute_30,code=sm_30",
                               "-maxrregcount=32"};
    Sizes sizes;
    ASSERT_EQ(
        rtuCUDACompileString(kSource, arguments, std::size(arguments), &sizes.result, &sizes.error),
        RT_SUCCESS)
        << texts(sizes).second;
    EXPECT_NE(texts(sizes).first.find(".entry run"), std::string::npos);
    const char* wrong[] = {kInclude, "-DFACTOR=2.0f", "--no-such-option"};
    EXPECT_EQ(rtuCUDACompileString(kSource, wrong, 3, &sizes.result, &sizes.error),
              RT_ERROR_INVALID_SOURCE);
    EXPECT_NE(texts(sizes).second.find("no-such-option"), std::string::npos);
}

// As nvcc compiles it: memory may be read as another type, and a lane may pass a variable that only
// another lane has set.
TEST(Optixu, SourcesMeanWhatNvccMeans) {
    const char* const source =
        "extern \"C\" __device__ __noinline__ int both(float* f, unsigned short* half) {\n"
        "    f[0] = 1.5f;\n"
        "    half[1] = 0x4000;\n"
        "    return f[0] == 2.0f;\n"
        "}\n"
        "template <class T> __device__ __noinline__ T first(T value) {\n"
        "    return __shfl_sync(__activemask(), value, 0);\n"
        "}\n"
        "extern \"C\" __device__ int once(int* to) {\n"
        "    int base;\n"
        "    if (threadIdx.x == 0)\n"
        "        base = atomicAdd(to, both(nullptr, nullptr));\n"
        "    return first(base);\n"
        "}\n";
    Sizes sizes;
    ASSERT_EQ(rtuCUDACompileString(source, nullptr, 0, &sizes.result, &sizes.error), RT_SUCCESS)
        << texts(sizes).second;
    const std::string ptx = texts(sizes).first;
    EXPECT_NE(ptx.find("setp.eq.f32"), std::string::npos) << ptx;
    EXPECT_NE(ptx.find("bra"), std::string::npos) << ptx;
}

TEST(Optixu, WrongSourcesHaveMessages) {
    const char* arguments[] = {kInclude};
    Sizes sizes;
    EXPECT_EQ(rtuCUDACompileString(kSource, arguments, 1, &sizes.result, &sizes.error),
              RT_ERROR_INVALID_SOURCE);
    EXPECT_EQ(sizes.result, 0u);
    EXPECT_NE(texts(sizes).second.find("FACTOR"), std::string::npos);
    // Results belong to the thread: another thread has compiled nothing.
    std::thread([] {
        char result[1] = {'#'}, error[1] = {'#'};
        EXPECT_EQ(rtuCUDAGetCompileResult(result, error), RT_SUCCESS);
        EXPECT_EQ(result[0], '#');
        EXPECT_EQ(error[0], '\0');
    }).join();
    EXPECT_EQ(rtuCUDACompileString("__global__ void f(", nullptr, 0, nullptr, nullptr),
              RT_ERROR_INVALID_SOURCE);
}

TEST(Optixu, FilesBecomePtx) {
    const std::string folder = ::testing::TempDir() + "optixu_" + std::to_string(getpid());
    const std::string source = folder + ".cu", header = folder + ".h";
    std::ofstream(header) << "#define FACTOR 3.0f\n";
    std::ofstream(source) << "#include \"" << header.substr(header.rfind('/') + 1) << "\"\n"
                          << kSource;
    const char* arguments[] = {kInclude};
    Sizes sizes;
    EXPECT_EQ(rtuCUDACompileFile(source.c_str(), arguments, 1, &sizes.result, &sizes.error),
              RT_SUCCESS);
    EXPECT_NE(texts(sizes).first.find(".entry run"), std::string::npos);
    std::remove(source.c_str());
    std::remove(header.c_str());
    EXPECT_EQ(rtuCUDACompileFile(source.c_str(), arguments, 1, &sizes.result, &sizes.error),
              RT_ERROR_FILE_NOT_FOUND);
    EXPECT_EQ(rtuCUDACompileFile("/", arguments, 1, nullptr, nullptr), RT_ERROR_FILE_NOT_FOUND);
}

TEST(Optixu, WrongArgumentsAreRefused) {
    const char* holes[] = {kInclude, nullptr};
    EXPECT_EQ(rtuCUDACompileString(nullptr, nullptr, 0, nullptr, nullptr), RT_ERROR_INVALID_VALUE);
    EXPECT_EQ(rtuCUDACompileString("", nullptr, 1, nullptr, nullptr), RT_ERROR_INVALID_VALUE);
    EXPECT_EQ(rtuCUDACompileString("", holes, 2, nullptr, nullptr), RT_ERROR_INVALID_VALUE);
    EXPECT_EQ(rtuCUDACompileFile(nullptr, nullptr, 0, nullptr, nullptr), RT_ERROR_INVALID_VALUE);
    EXPECT_EQ(rtuCUDACompileFile("x.cu", nullptr, 1, nullptr, nullptr), RT_ERROR_INVALID_VALUE);
}

// Fills a folder with links to all programs in PATH but clang; returns a PATH of nvcc's own folder,
// beside which its headers are, and this folder.
std::string pathWithoutClang(const std::filesystem::path& folder) {
    namespace fs = std::filesystem;
    std::string result = folder;
    fs::create_directories(folder);
    std::stringstream path(std::getenv("PATH"));
    for (std::string part; std::getline(path, part, ':');) {
        std::error_code error; // folders that are not there, names that an earlier folder has
        for (const auto& entry : fs::directory_iterator(part, error)) {
            const std::string name = entry.path().filename();
            const fs::path home = fs::weakly_canonical(entry.path(), error).parent_path();
            if (name == "nvcc" && !fs::exists(home / "clang++-19"))
                result = home.string() + ":" + result;
            else if (name.compare(0, 5, "clang") != 0)
                fs::create_symlink(entry.path(), folder / name, error);
        }
    }
    return result;
}

TEST(Optixu, NvccIsTheOtherCompiler) {
    const std::filesystem::path folder = ::testing::TempDir() + "bin_" + std::to_string(getpid());
    const std::string path = std::getenv("PATH"), without = pathWithoutClang(folder);
    const char* arguments[] = {kInclude, "-DFACTOR=2.0f"};
    Sizes sizes;
    setenv("PATH", without.c_str(), 1);
    const RTresult result =
        rtuCUDACompileString(kSource, arguments, 2, &sizes.result, &sizes.error);
    setenv("PATH", path.c_str(), 1);
    std::filesystem::remove_all(folder);
    if (result == RT_ERROR_NOT_SUPPORTED)
        GTEST_SKIP() << "no nvcc in a folder of its own";
    const auto [ptx, messages] = texts(sizes);
    EXPECT_EQ(result, RT_SUCCESS) << messages;
    EXPECT_NE(ptx.find(".entry run"), std::string::npos);
    EXPECT_NE(ptx.find("kept"), std::string::npos);
}

TEST(Optixu, WithoutACompilerNothingIsSupported) {
    const std::string path = std::getenv("PATH");
    setenv("PATH", "/nonexistent", 1);
    Sizes sizes;
    EXPECT_EQ(rtuCUDACompileString(kSource, nullptr, 0, &sizes.result, &sizes.error),
              RT_ERROR_NOT_SUPPORTED);
    setenv("PATH", path.c_str(), 1);
    EXPECT_EQ(sizes.result, 0u);
    EXPECT_NE(texts(sizes).second.find("clang++-19"), std::string::npos);
}

} // namespace
