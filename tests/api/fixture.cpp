// SPDX-License-Identifier: Apache-2.0
#include "fixture.h"

#include "coverage/call_record.h"
#include "device_memory.h"

#include "optix_function_table_definition.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace tests::api {

Buffer::Buffer(size_t size, size_t alignment) : size_(size) {
    data_ = allocateDevice(size == 0 ? 1 : size, alignment);
    std::memset(data_, 0, size);
}

Buffer& Buffer::operator=(Buffer&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
}

Buffer::~Buffer() {
    freeDevice(data_);
}

void LogRecord::callback(unsigned level, const char* tag, const char* message, void* self) {
    auto* record = static_cast<LogRecord*>(self);
    std::lock_guard lock(record->mutex_);
    record->lines_.push_back({level, tag ? tag : "(null)", message ? message : "(null)"});
}

void LogRecord::clear() {
    std::lock_guard lock(mutex_);
    lines_.clear();
}

std::vector<LogLine> LogRecord::lines() const {
    std::lock_guard lock(mutex_);
    return lines_;
}

bool LogRecord::hasError(std::string_view first, std::string_view second) const {
    for (const LogLine& line : lines())
        if (line.level <= 2 && line.text.find(first) != std::string::npos &&
            line.text.find(second) != std::string::npos)
            return true;
    return false;
}

bool LogRecord::hasUnexpectedError() const {
    const std::vector<LogLine> all = lines();
    return std::any_of(all.begin(), all.end(), [&](const LogLine& line) {
        return line.level <= 2 &&
               (expected_.empty() || line.text.find(expected_) == std::string::npos);
    });
}

std::string LogRecord::all() const {
    std::string text;
    for (const LogLine& line : lines())
        text += "[" + std::to_string(line.level) + "][" + line.tag + "] " + line.text + "\n";
    return text;
}

void loadLibrary() {
    // Disables the disk cache unless the environment sets its size, as the tests of the back end
    // for GPUs do; tests of the disk cache set its folder.
    setenv("OPTIX_CACHE_MAXSIZE", "0", 0);
    prepareDevice();
    OptixResult result = optixInit();
    if (result != OPTIX_SUCCESS)
        throw std::runtime_error("optixInit failed with " + std::to_string(int(result)));
    recordCalls();
}

ApiTest* ApiTest::running_ = nullptr;

void ApiTest::hearReports() {
    if (running_ && running_->context_)
        optixDeviceContextSetLogCallback(running_->context_, LogRecord::callback, &running_->log_,
                                         4);
}

void ApiTest::SetUp() {
    running_ = this;
    recordCalls(); // a test may have reloaded the library
    OptixDeviceContextOptions options{};
    options.logCallbackFunction = LogRecord::callback;
    options.logCallbackData = &log_;
    options.logCallbackLevel = 4;
    ASSERT_OK(optixDeviceContextCreate(nullptr, &options, &context_));
}

void ApiTest::TearDown() {
    running_ = nullptr;
    if (context_)
        EXPECT_OK(optixDeviceContextDestroy(context_));
}

void ApiTest::expectRejected(OptixResult expected, OptixResult actual, const char* function,
                             const char* mention) {
    EXPECT_EQ(expected, actual) << "got " << optixGetErrorName(actual) << ", wanted "
                                << optixGetErrorName(expected) << "; log:\n"
                                << log_.all();
    if (actual == expected)
        EXPECT_TRUE(log_.hasError(function, mention))
            << "no error line with '" << function << "' and '" << mention << "'; log:\n"
            << log_.all();
}

std::vector<void*> garbageHandles() {
    static int alive = 0;
    return {reinterpret_cast<void*>(1), reinterpret_cast<void*>(0x1000),
            reinterpret_cast<void*>(~uintptr_t(0)),
            reinterpret_cast<void*>(uintptr_t(0xDEADBEEFDEADBEE0u)), &alive};
}

OptixPipelineCompileOptions compileOptions(int payload) {
    OptixPipelineCompileOptions options{};
    options.traversableGraphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY;
    options.numPayloadValues = payload;
    options.numAttributeValues = 2;
    options.pipelineLaunchParamsVariableName = "params";
    return options;
}

std::string ptxModule(std::string_view body) {
    return ".version 6.5\n.target sm_60\n.address_size 64\n" + std::string(body);
}

std::string compiledPtx(const std::string& program, const std::string& toolchain) {
    const char* folder = std::getenv("SUNSTONE_TEST_PTX"); // where the build folder is not
    std::string path = std::string(folder ? folder : SUNSTONE_TEST_PTX_DIR) + "/" + program +
                       (toolchain == "nvcc" ? ".nvcc.ptx" : ".ptx");
    std::ifstream file(path);
    if (!file)
        throw std::runtime_error("cannot read " + path);
    std::ostringstream text;
    text << file.rdbuf();
    const bool isOfThisFolder = program.find('/') == program.npos; // others name their folder
    const std::filesystem::path source =
        (isOfThisFolder ? "tests/api/device/" : "tests/api/") + program + ".cu";
    recordProgram(text.str(), source.lexically_normal().string());
    return text.str();
}

std::vector<std::string> toolchains() {
    if (SUNSTONE_TEST_HAS_NVCC)
        return {"clang", "nvcc"};
    return {"clang"};
}

} // namespace tests::api
