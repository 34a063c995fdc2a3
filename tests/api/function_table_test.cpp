// SPDX-License-Identifier: Apache-2.0
// optixQueryFunctionTable and the error texts (OptiX 7.4, sections 3.3, 4.1).
#include "fixture.h"

#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <set>

namespace tests::api {
namespace {

class FunctionTable : public testing::Test {
protected:
    void SetUp() override {
        library_ = dlopen("libnvoptix.so.1", RTLD_NOW);
        ASSERT_NE(nullptr, library_) << dlerror();
        query_ = reinterpret_cast<OptixQueryFunctionTable_t*>(
            dlsym(library_, "optixQueryFunctionTable"));
        ASSERT_NE(nullptr, query_);
    }
    void TearDown() override {
        if (library_)
            dlclose(library_);
    }

    void* library_ = nullptr;
    OptixQueryFunctionTable_t* query_ = nullptr;
};

constexpr size_t kSlots = 43;
constexpr int kAbi = 55;

TEST_F(FunctionTable, FillsEverySlot) {
    ASSERT_EQ(kSlots * sizeof(void*), sizeof(OptixFunctionTable));
    ASSERT_EQ(kAbi, OPTIX_ABI_VERSION);
    void* table[kSlots + 1] = {};
    ASSERT_EQ(OPTIX_SUCCESS, query_(kAbi, 0, nullptr, nullptr, table, kSlots * sizeof(void*)));
    for (size_t i = 0; i < kSlots; ++i)
        EXPECT_NE(nullptr, table[i]) << "slot " << i;
    EXPECT_EQ(nullptr, table[kSlots]) << "written beyond the table";
}

TEST_F(FunctionTable, ExportsNothingElse) {
    for (const char* name : {"optixInit", "optixLaunch", "optixDeviceContextCreate", "rtContextCreate"})
        EXPECT_EQ(nullptr, dlsym(library_, name)) << name;
}

TEST_F(FunctionTable, ReservedSlotsAreHarmless) {
    void* table[kSlots] = {};
    ASSERT_EQ(OPTIX_SUCCESS, query_(kAbi, 0, nullptr, nullptr, table, sizeof(table)));
    for (int slot : {31, 32})
        reinterpret_cast<void (*)()>(table[slot])();
}

TEST_F(FunctionTable, RejectsBadArguments) {
    void* table[kSlots + 8] = {};
    size_t size = kSlots * sizeof(void*);
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, query_(kAbi, 0, nullptr, nullptr, nullptr, size));
    OptixQueryFunctionTableOptions option = OPTIX_QUERY_FUNCTION_TABLE_OPTION_DUMMY;
    const void* value = nullptr;
    EXPECT_EQ(OPTIX_ERROR_INVALID_ENTRY_FUNCTION_OPTIONS,
              query_(kAbi, 1, &option, &value, table, size));
    EXPECT_EQ(OPTIX_ERROR_INVALID_ENTRY_FUNCTION_OPTIONS,
              query_(kAbi, ~0u, nullptr, nullptr, table, size));
    for (size_t wrong : {size_t(0), size_t(1), size - 8, size - 1, size + 1, size + 8, ~size_t(0)})
        EXPECT_EQ(OPTIX_ERROR_FUNCTION_TABLE_SIZE_MISMATCH,
                  query_(kAbi, 0, nullptr, nullptr, table, wrong))
            << wrong;
    for (void* slot : table)
        EXPECT_EQ(nullptr, slot) << "written by a refused call";
}

TEST_F(FunctionTable, RejectsOtherAbis) {
    void* table[64] = {};
    for (int abi : {0, 1, -1, 21, 23, 22 + 256, 54, 56, 61, 67, 69, 84, 118, 0x7FFFFFFF})
        EXPECT_EQ(OPTIX_ERROR_UNSUPPORTED_ABI_VERSION,
                  query_(abi, 0, nullptr, nullptr, table, kSlots * sizeof(void*)))
            << abi;
}

// The application has no log yet, so the reason goes to stderr, once.
TEST_F(FunctionTable, RefusalsAreLinesOnStderr) {
    void* table[64] = {};
    testing::internal::CaptureStderr();
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(OPTIX_ERROR_UNSUPPORTED_ABI_VERSION,
                  query_(1055, 0, nullptr, nullptr, table, sizeof(table)));
        EXPECT_EQ(OPTIX_ERROR_FUNCTION_TABLE_SIZE_MISMATCH,
                  query_(kAbi, 0, nullptr, nullptr, table, 1055));
    }
    const std::string text = testing::internal::GetCapturedStderr();
    EXPECT_EQ(2, std::count(text.begin(), text.end(), '\n')) << text;
    EXPECT_NE(std::string::npos, text.find("abiId = 1055; this library serves 22 (OptiX 7.0)"))
        << text;
    EXPECT_NE(std::string::npos, text.find("sizeOfTable = 1055")) << text;
}

TEST_F(FunctionTable, OptionsAndTableComeBeforeTheAbi) {
    void* table[kSlots] = {};
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, query_(1, 1, nullptr, nullptr, nullptr, 0));
    EXPECT_EQ(OPTIX_ERROR_INVALID_ENTRY_FUNCTION_OPTIONS, query_(1, 1, nullptr, nullptr, table, 0));
    EXPECT_EQ(OPTIX_ERROR_UNSUPPORTED_ABI_VERSION, query_(1, 0, nullptr, nullptr, table, 0));
}

TEST_F(FunctionTable, StubsLoadAndUnload) {
    void* handle = nullptr;
    ASSERT_EQ(OPTIX_SUCCESS, optixInitWithHandle(&handle));
    ASSERT_NE(nullptr, handle);
    EXPECT_NE(nullptr, g_optixFunctionTable.optixLaunch);
    EXPECT_EQ(OPTIX_SUCCESS, optixUninitWithHandle(handle));
    EXPECT_EQ(nullptr, g_optixFunctionTable.optixLaunch);
    EXPECT_EQ(OPTIX_SUCCESS, optixInit());
}

// Worker threads and compiled code must survive the unloading of the library.
TEST_F(FunctionTable, UnloadAfterWork) {
    void* handle = nullptr;
    ASSERT_EQ(OPTIX_SUCCESS, optixInitWithHandle(&handle));
    OptixDeviceContext context = nullptr;
    ASSERT_EQ(OPTIX_SUCCESS, optixDeviceContextCreate(nullptr, nullptr, &context));
    OptixBuildInput input{};
    input.type = OPTIX_BUILD_INPUT_TYPE_INSTANCES;
    OptixAccelBuildOptions options{OPTIX_BUILD_FLAG_NONE, OPTIX_BUILD_OPERATION_BUILD, {}};
    Buffer temp(1 << 16), output(1 << 16);
    OptixTraversableHandle traversable = 0;
    EXPECT_EQ(OPTIX_SUCCESS,
              optixAccelBuild(context, nullptr, &options, &input, 1, temp.address(), temp.size(),
                              output.address(), output.size(), &traversable, nullptr, 0));
    EXPECT_EQ(OPTIX_SUCCESS, optixDeviceContextDestroy(context));
    dlclose(library_);
    library_ = nullptr;
    EXPECT_EQ(OPTIX_SUCCESS, optixUninitWithHandle(handle));
    usleep(20000); // time for a worker to touch freed memory
    EXPECT_EQ(OPTIX_SUCCESS, optixInit());
}

// All codes of OptiX 7.4 with their numbers.
struct NamedCode {
    int value;
    const char* name;
};
constexpr NamedCode kCodes[] = {
    {0, "OPTIX_SUCCESS"},
    {7001, "OPTIX_ERROR_INVALID_VALUE"},
    {7002, "OPTIX_ERROR_HOST_OUT_OF_MEMORY"},
    {7003, "OPTIX_ERROR_INVALID_OPERATION"},
    {7004, "OPTIX_ERROR_FILE_IO_ERROR"},
    {7005, "OPTIX_ERROR_INVALID_FILE_FORMAT"},
    {7010, "OPTIX_ERROR_DISK_CACHE_INVALID_PATH"},
    {7011, "OPTIX_ERROR_DISK_CACHE_PERMISSION_ERROR"},
    {7012, "OPTIX_ERROR_DISK_CACHE_DATABASE_ERROR"},
    {7013, "OPTIX_ERROR_DISK_CACHE_INVALID_DATA"},
    {7050, "OPTIX_ERROR_LAUNCH_FAILURE"},
    {7051, "OPTIX_ERROR_INVALID_DEVICE_CONTEXT"},
    {7052, "OPTIX_ERROR_CUDA_NOT_INITIALIZED"},
    {7053, "OPTIX_ERROR_VALIDATION_FAILURE"},
    {7200, "OPTIX_ERROR_INVALID_PTX"},
    {7201, "OPTIX_ERROR_INVALID_LAUNCH_PARAMETER"},
    {7202, "OPTIX_ERROR_INVALID_PAYLOAD_ACCESS"},
    {7203, "OPTIX_ERROR_INVALID_ATTRIBUTE_ACCESS"},
    {7204, "OPTIX_ERROR_INVALID_FUNCTION_USE"},
    {7205, "OPTIX_ERROR_INVALID_FUNCTION_ARGUMENTS"},
    {7250, "OPTIX_ERROR_PIPELINE_OUT_OF_CONSTANT_MEMORY"},
    {7251, "OPTIX_ERROR_PIPELINE_LINK_ERROR"},
    {7270, "OPTIX_ERROR_ILLEGAL_DURING_TASK_EXECUTE"},
    {7299, "OPTIX_ERROR_INTERNAL_COMPILER_ERROR"},
    {7300, "OPTIX_ERROR_DENOISER_MODEL_NOT_SET"},
    {7301, "OPTIX_ERROR_DENOISER_NOT_INITIALIZED"},
    {7400, "OPTIX_ERROR_ACCEL_NOT_COMPATIBLE"},
    {7500, "OPTIX_ERROR_PAYLOAD_TYPE_MISMATCH"},
    {7501, "OPTIX_ERROR_PAYLOAD_TYPE_RESOLUTION_FAILED"},
    {7502, "OPTIX_ERROR_PAYLOAD_TYPE_ID_INVALID"},
    {7800, "OPTIX_ERROR_NOT_SUPPORTED"},
    {7801, "OPTIX_ERROR_UNSUPPORTED_ABI_VERSION"},
    {7802, "OPTIX_ERROR_FUNCTION_TABLE_SIZE_MISMATCH"},
    {7803, "OPTIX_ERROR_INVALID_ENTRY_FUNCTION_OPTIONS"},
    {7804, "OPTIX_ERROR_LIBRARY_NOT_FOUND"},
    {7805, "OPTIX_ERROR_ENTRY_SYMBOL_NOT_FOUND"},
    {7806, "OPTIX_ERROR_LIBRARY_UNLOAD_FAILURE"},
    {7900, "OPTIX_ERROR_CUDA_ERROR"},
    {7990, "OPTIX_ERROR_INTERNAL_ERROR"},
    {7999, "OPTIX_ERROR_UNKNOWN"},
};

TEST(ErrorTexts, NamesAreEnumeratorSpellings) {
    loadLibrary();
    for (const NamedCode& code : kCodes)
        EXPECT_STREQ(code.name, optixGetErrorName(OptixResult(code.value))) << code.value;
}

TEST(ErrorTexts, StringsDiffer) {
    loadLibrary();
    EXPECT_STREQ("Success", optixGetErrorString(OPTIX_SUCCESS));
    EXPECT_STREQ("Invalid value", optixGetErrorString(OPTIX_ERROR_INVALID_VALUE));
    std::set<std::string> seen;
    for (const NamedCode& code : kCodes) {
        std::string text = optixGetErrorString(OptixResult(code.value));
        EXPECT_FALSE(text.empty());
        EXPECT_TRUE(seen.insert(text).second) << text << " occurs twice";
    }
}

TEST(ErrorTexts, UnknownCodes) {
    loadLibrary();
    std::set<int> known;
    for (const NamedCode& code : kCodes)
        known.insert(code.value);
    for (int value = 6990; value < 8010; ++value)
        if (!known.count(value)) {
            EXPECT_STREQ("Unrecognized OptixResult code", optixGetErrorName(OptixResult(value)));
            EXPECT_STREQ("Unrecognized OptixResult code", optixGetErrorString(OptixResult(value)));
        }
    for (int value : {1, -1, 0x7FFFFFFF, int(0x80000000)}) {
        EXPECT_STREQ("Unrecognized OptixResult code", optixGetErrorName(OptixResult(value)));
        EXPECT_STREQ("Unrecognized OptixResult code", optixGetErrorString(OptixResult(value)));
    }
}

} // namespace
} // namespace tests::api
