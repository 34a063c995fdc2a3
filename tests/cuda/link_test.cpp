// SPDX-License-Identifier: Apache-2.0
// Linking pieces of PTX: symbols across pieces, the linker's errors, damaged linked images.
#include <cuda.h>
#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

namespace {

const std::string kHead = ".version 7.0\n.target sm_60\n.address_size 64\n";
const std::string kMain = kHead + R"(
.extern .func (.param .b32 result) triple(.param .b32 x);
.extern .global .align 4 .u32 total;
.visible .entry run(.param .u64 out, .param .u32 x)
{
    .reg .b32 %r<6>;
    .reg .b64 %rd<2>;
    ld.param.u64 %rd1, [out];
    ld.param.u32 %r1, [x];
    {
        .param .b32 argument;
        .param .b32 value;
        st.param.b32 [argument], %r1;
        call.uni (value), triple, (argument);
        ld.param.b32 %r2, [value];
    }
    ld.global.u32 %r3, [total];
    add.u32 %r4, %r2, %r3;
    st.global.u32 [%rd1], %r4;
    ret;
}
)";
const std::string kLibrary = kHead + R"(
.visible .global .align 4 .u32 total = 1000;
.weak .global .align 4 .u32 shared = 5;
.visible .func (.param .b32 result) triple(.param .b32 x)
{
    .reg .b32 %r<3>;
    ld.param.u32 %r1, [x];
    mul.lo.u32 %r2, %r1, 3;
    st.param.b32 [result], %r2;
    ret;
}
.weak .entry common(.param .u64 out)
{
    .reg .b64 %rd<2>;
    ld.param.u64 %rd1, [out];
    st.global.u32 [%rd1], 77;
    ret;
}
)";

class Link : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(cuInit(0), CUDA_SUCCESS);
        ASSERT_EQ(cuDevicePrimaryCtxRetain(&context, 0), CUDA_SUCCESS);
        ASSERT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
        ASSERT_EQ(cuLinkCreate(0, nullptr, nullptr, &link), CUDA_SUCCESS);
    }
    void TearDown() override {
        EXPECT_EQ(cuLinkDestroy(link), CUDA_SUCCESS);
        EXPECT_EQ(cuCtxSetCurrent(nullptr), CUDA_SUCCESS);
        EXPECT_EQ(cuDevicePrimaryCtxRelease(0), CUDA_SUCCESS);
    }
    CUresult add(const std::string& text) {
        return cuLinkAddData(link, CU_JIT_INPUT_PTX, const_cast<char*>(text.c_str()),
                             text.size() + 1, "piece", 0, nullptr, nullptr);
    }
    CUcontext context = nullptr;
    CUlinkState link = nullptr;
};

TEST_F(Link, SymbolsAcrossPieces) {
    ASSERT_EQ(add(kMain), CUDA_SUCCESS);
    ASSERT_EQ(add(kLibrary), CUDA_SUCCESS);
    // The same weak symbols once more, as templates leave them in every piece.
    std::string weak = kLibrary.substr(kLibrary.find(".weak .entry"));
    ASSERT_EQ(add(kHead + ".weak .global .align 4 .u32 shared = 5;\n" + weak), CUDA_SUCCESS);
    void* image = nullptr;
    size_t size = 0;
    ASSERT_EQ(cuLinkComplete(link, &image, &size), CUDA_SUCCESS);
    const std::vector<char> copy(static_cast<char*>(image), static_cast<char*>(image) + size);

    CUmodule module = nullptr;
    ASSERT_EQ(cuModuleLoadData(&module, copy.data()), CUDA_SUCCESS);
    CUfunction run = nullptr, common = nullptr;
    ASSERT_EQ(cuModuleGetFunction(&run, module, "run"), CUDA_SUCCESS);
    ASSERT_EQ(cuModuleGetFunction(&common, module, "common"), CUDA_SUCCESS);
    unsigned count = 0;
    EXPECT_EQ(cuModuleGetFunctionCount(&count, module), CUDA_SUCCESS);
    EXPECT_EQ(count, 2u);
    CUdeviceptr total = 0, out = 0;
    size_t bytes = 0;
    ASSERT_EQ(cuModuleGetGlobal(&total, &bytes, module, "total"), CUDA_SUCCESS);
    ASSERT_EQ(cuMemAllocManaged(&out, 4, CU_MEM_ATTACH_GLOBAL), CUDA_SUCCESS);
    const unsigned hundred = 100;
    ASSERT_EQ(cuMemcpyHtoD(total, &hundred, 4), CUDA_SUCCESS);
    unsigned x = 7;
    void* params[] = {&out, &x};
    ASSERT_EQ(cuLaunchKernel(run, 1, 1, 1, 1, 1, 1, 0, nullptr, params, nullptr), CUDA_SUCCESS);
    ASSERT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
    EXPECT_EQ(*reinterpret_cast<unsigned*>(out), 121u);
    EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
    EXPECT_EQ(cuMemFree(out), CUDA_SUCCESS);
}

// A block of the kernel declares the function that another piece defines.
TEST_F(Link, FunctionsDeclaredInBodies) {
    const size_t declaration = kMain.find(".extern .func"), end = kMain.find('\n', declaration);
    const size_t block = kMain.find("        .param .b32 argument;");
    const auto declaring = [&](const std::string& text) {
        return kMain.substr(0, declaration) + kMain.substr(end, block - end) + text +
               kMain.substr(block);
    };
    ASSERT_EQ(add(declaring(kMain.substr(declaration, end - declaration))), CUDA_SUCCESS);
    ASSERT_EQ(add(kLibrary), CUDA_SUCCESS);
    void* image = nullptr;
    CUmodule module = nullptr;
    CUfunction run = nullptr;
    CUdeviceptr out = 0;
    ASSERT_EQ(cuLinkComplete(link, &image, nullptr), CUDA_SUCCESS);
    ASSERT_EQ(cuModuleLoadData(&module, image), CUDA_SUCCESS);
    ASSERT_EQ(cuModuleGetFunction(&run, module, "run"), CUDA_SUCCESS);
    ASSERT_EQ(cuMemAllocManaged(&out, 4, CU_MEM_ATTACH_GLOBAL), CUDA_SUCCESS);
    unsigned x = 7;
    void* params[] = {&out, &x};
    ASSERT_EQ(cuLaunchKernel(run, 1, 1, 1, 1, 1, 1, 0, nullptr, params, nullptr), CUDA_SUCCESS);
    ASSERT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
    EXPECT_EQ(*reinterpret_cast<unsigned*>(out), 1021u);
    EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
    EXPECT_EQ(cuMemFree(out), CUDA_SUCCESS);
    // Declared with other parameters than the other piece, or the same one, defines it with.
    const std::string other = ".func (.param .b32 result) triple(.param .b64 x);";
    EXPECT_EQ(cuModuleLoadData(&module, (declaring(other) + kLibrary.substr(kHead.size())).c_str()),
              CUDA_ERROR_INVALID_PTX);
    CUlinkState second = nullptr;
    ASSERT_EQ(cuLinkCreate(0, nullptr, nullptr, &second), CUDA_SUCCESS);
    std::swap(link, second);
    EXPECT_EQ(cuLinkDestroy(second), CUDA_SUCCESS);
    std::string wide = declaring(other);
    wide.replace(wide.find(".param .b32 argument"), 20, ".param .b64 argument");
    ASSERT_EQ(add(wide), CUDA_SUCCESS);
    ASSERT_EQ(add(kLibrary), CUDA_SUCCESS);
    CUresult result = cuLinkComplete(link, &image, nullptr);
    if (result == CUDA_SUCCESS)
        result = cuModuleLoadData(&module, image);
    EXPECT_EQ(result, CUDA_ERROR_INVALID_PTX);
}

// In any order, a strong kernel replaces weak ones of its name, and only one is allowed.
TEST_F(Link, StrongKernelsWin) {
    const auto storing = [](const char* linkage, int value) {
        return kHead + linkage +
               " .entry pick(.param .u64 out)\n{\n    .reg .b64 %rd<2>;\n"
               "    ld.param.u64 %rd1, [out];\n    st.global.u32 [%rd1], " +
               std::to_string(value) + ";\n    ret;\n}\n";
    };
    CUdeviceptr out = 0;
    ASSERT_EQ(cuMemAllocManaged(&out, 4, CU_MEM_ATTACH_GLOBAL), CUDA_SUCCESS);
    const auto valueOf = [&](const std::vector<std::string>& pieces) {
        CUlinkState state = nullptr;
        EXPECT_EQ(cuLinkCreate(0, nullptr, nullptr, &state), CUDA_SUCCESS);
        for (const std::string& piece : pieces)
            EXPECT_EQ(cuLinkAddData(state, CU_JIT_INPUT_PTX, const_cast<char*>(piece.c_str()),
                                    piece.size() + 1, "", 0, nullptr, nullptr),
                      CUDA_SUCCESS);
        void* image = nullptr;
        size_t size = 0;
        unsigned result = 0;
        if (const CUresult error = cuLinkComplete(state, &image, &size)) {
            result = 1000u + error;
        } else {
            CUmodule module = nullptr;
            CUfunction pick = nullptr;
            unsigned count = 0;
            EXPECT_EQ(cuModuleLoadData(&module, image), CUDA_SUCCESS);
            EXPECT_EQ(cuModuleGetFunctionCount(&count, module), CUDA_SUCCESS);
            EXPECT_EQ(count, 1u);
            EXPECT_EQ(cuModuleGetFunction(&pick, module, "pick"), CUDA_SUCCESS);
            void* params[] = {&out};
            EXPECT_EQ(cuLaunchKernel(pick, 1, 1, 1, 1, 1, 1, 0, nullptr, params, nullptr),
                      CUDA_SUCCESS);
            EXPECT_EQ(cuCtxSynchronize(), CUDA_SUCCESS);
            result = *reinterpret_cast<unsigned*>(out);
            EXPECT_EQ(cuModuleUnload(module), CUDA_SUCCESS);
        }
        EXPECT_EQ(cuLinkDestroy(state), CUDA_SUCCESS);
        return result;
    };
    const std::string weak1 = storing(".weak", 1), weak2 = storing(".weak", 2);
    const std::string strong = storing(".visible", 3), other = storing(".visible", 4);
    EXPECT_EQ(valueOf({weak1, weak2}), 1u);
    EXPECT_EQ(valueOf({weak1, strong, weak2}), 3u);
    EXPECT_EQ(valueOf({strong, weak1}), 3u);
    EXPECT_EQ(valueOf({strong, other}), 1000u + CUDA_ERROR_INVALID_PTX);
    EXPECT_EQ(valueOf({strong, weak1, other}), 1000u + CUDA_ERROR_INVALID_PTX);
    EXPECT_EQ(valueOf({weak1, strong, other}), 1000u + CUDA_ERROR_INVALID_PTX);
    EXPECT_EQ(cuMemFree(out), CUDA_SUCCESS);
}

// A fat binary without PTX is an error: ignoring it would cause missing symbols later.
TEST_F(Link, RefusesMachineCodeInFatBinaries) {
    struct {
        uint32_t magic = 0xBA55ED50;
        uint16_t version = 1, headerSize = 16;
        uint64_t size = 64 + 8;
        uint16_t kind = 2, unknown1 = 0x0101; // machine code
        uint32_t entryHeader = 64;
        uint64_t payload = 8;
        uint32_t compressed = 0, unknown2 = 0;
        uint16_t minor = 0, major = 7;
        uint32_t architecture = 75;
        char rest[32] = {}, code[8] = {};
    } binary;
    EXPECT_EQ(cuLinkAddData(link, CU_JIT_INPUT_FATBINARY, &binary, sizeof binary, "", 0, nullptr,
                            nullptr),
              CUDA_ERROR_NO_BINARY_FOR_GPU);
    ASSERT_EQ(add(kLibrary), CUDA_SUCCESS); // the linker can still be used
    void* image = nullptr;
    EXPECT_EQ(cuLinkComplete(link, &image, nullptr), CUDA_SUCCESS);
}

TEST_F(Link, RefusesMissingAndDoubleSymbols) {
    void* image = nullptr;
    ASSERT_EQ(add(kMain), CUDA_SUCCESS);
    EXPECT_EQ(cuLinkComplete(link, &image, nullptr), CUDA_ERROR_INVALID_PTX);
    ASSERT_EQ(add(kLibrary), CUDA_SUCCESS);
    ASSERT_EQ(add(kHead + ".visible .global .align 4 .u32 total = 2;\n"), CUDA_SUCCESS);
    EXPECT_EQ(cuLinkComplete(link, &image, nullptr), CUDA_ERROR_INVALID_PTX);
    EXPECT_EQ(image, nullptr);
}

TEST_F(Link, RefusesWhatTheManualForbids) {
    void* image = nullptr;
    size_t size = 0;
    char cubin[64] = "\x7f"
                     "ELF";
    CUlinkState none = nullptr, garbage = reinterpret_cast<CUlinkState>(0x5550);
    EXPECT_EQ(cuLinkCreate(0, nullptr, nullptr, nullptr), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuLinkCreate(2, nullptr, nullptr, &none), CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuLinkComplete(link, &image, &size), CUDA_ERROR_INVALID_VALUE); // nothing in it
    EXPECT_EQ(add("this is no PTX"), CUDA_ERROR_INVALID_PTX);
    EXPECT_EQ(cuLinkAddData(link, CU_JIT_INPUT_PTX, nullptr, 5, "", 0, nullptr, nullptr),
              CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuLinkAddData(link, CU_JIT_INPUT_PTX, cubin, 0, "", 0, nullptr, nullptr),
              CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuLinkAddData(link, CUjitInputType(50), cubin, 64, "", 0, nullptr, nullptr),
              CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuLinkAddData(link, CU_JIT_INPUT_CUBIN, cubin, 64, "", 0, nullptr, nullptr),
              CUDA_ERROR_NO_BINARY_FOR_GPU);
    EXPECT_EQ(cuLinkAddData(link, CU_JIT_INPUT_LIBRARY, cubin, 64, "", 0, nullptr, nullptr),
              CUDA_ERROR_NOT_SUPPORTED);
    EXPECT_EQ(cuLinkAddFile(link, CU_JIT_INPUT_PTX, "/no/such/file", 0, nullptr, nullptr),
              CUDA_ERROR_FILE_NOT_FOUND);
    EXPECT_EQ(cuLinkAddFile(link, CU_JIT_INPUT_PTX, nullptr, 0, nullptr, nullptr),
              CUDA_ERROR_INVALID_VALUE);
    EXPECT_EQ(cuLinkComplete(garbage, &image, &size), CUDA_ERROR_INVALID_HANDLE);
    EXPECT_EQ(cuLinkDestroy(garbage), CUDA_ERROR_INVALID_HANDLE);
    ASSERT_EQ(add(kLibrary), CUDA_SUCCESS);
    EXPECT_EQ(cuLinkComplete(link, nullptr, &size), CUDA_ERROR_INVALID_VALUE);
    ASSERT_EQ(cuLinkComplete(link, &image, &size), CUDA_SUCCESS);
    EXPECT_EQ(add(kMain), CUDA_ERROR_INVALID_VALUE); // it is complete
}

TEST_F(Link, ErrorsGoToTheLogBuffer) {
    char buffer[512] = "";
    CUjit_option options[] = {CU_JIT_ERROR_LOG_BUFFER, CU_JIT_ERROR_LOG_BUFFER_SIZE_BYTES};
    void* values[] = {buffer, reinterpret_cast<void*>(sizeof buffer)};
    CUlinkState logged = nullptr;
    ASSERT_EQ(cuLinkCreate(2, options, values, &logged), CUDA_SUCCESS);
    ASSERT_EQ(cuLinkAddData(logged, CU_JIT_INPUT_PTX, const_cast<char*>(kMain.c_str()),
                            kMain.size() + 1, "main", 0, nullptr, nullptr),
              CUDA_SUCCESS);
    void* image = nullptr;
    EXPECT_EQ(cuLinkComplete(logged, &image, nullptr), CUDA_ERROR_INVALID_PTX);
    EXPECT_TRUE(std::strstr(buffer, "triple") || std::strstr(buffer, "total")) << buffer;
    EXPECT_EQ(cuLinkDestroy(logged), CUDA_SUCCESS);
}

TEST_F(Link, DamagedImagesAreRefused) {
    ASSERT_EQ(add(kLibrary), CUDA_SUCCESS);
    void* image = nullptr;
    size_t size = 0;
    ASSERT_EQ(cuLinkComplete(link, &image, &size), CUDA_SUCCESS);
    const std::string whole(static_cast<char*>(image), size);
    const auto load = [](std::string bytes, size_t at, uint64_t value, size_t width) {
        std::memcpy(&bytes[at], &value, width);
        CUmodule module = nullptr;
        return cuModuleLoadData(&module, bytes.data());
    };
    EXPECT_EQ(load(whole, 4, 2, 4), CUDA_ERROR_INVALID_IMAGE);            // more texts
    EXPECT_EQ(load(whole, 8, ~uint64_t(0), 8), CUDA_ERROR_INVALID_IMAGE); // endless
    EXPECT_EQ(load(whole, 8, size - 17, 8), CUDA_ERROR_INVALID_IMAGE);    // no NUL
    EXPECT_EQ(load(whole, 8, 0, 8), CUDA_ERROR_INVALID_IMAGE);            // nothing
    EXPECT_EQ(load(whole, 20, 0x2121212121, 4), CUDA_ERROR_INVALID_PTX);
}

} // namespace
