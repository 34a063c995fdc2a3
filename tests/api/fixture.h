// SPDX-License-Identifier: Apache-2.0
// The fixture of all API tests: a device context on the CPU device whose log is recorded, device
// memory, and checks that a refused call logs its reason. These tests load no CUDA library: a
// CUdeviceptr is an address of this process and stream 0 is the only stream. Read next: rig.h
// (pipelines and launches), scene.h (acceleration structures).
#pragma once

#include "optix.h"
#include "optix_stubs.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace tests::api {

// Device memory of exactly `size` bytes (so that an address sanitizer sees overruns), zeroed.
class Buffer {
public:
    Buffer() = default;
    explicit Buffer(size_t size, size_t alignment = 128);
    template <class T>
    explicit Buffer(const std::vector<T>& values, size_t alignment = 128)
        : Buffer(values.size() * sizeof(T), alignment) {
        if (!values.empty())
            std::memcpy(data_, values.data(), size_);
    }
    Buffer(Buffer&& other) noexcept { *this = std::move(other); }
    Buffer& operator=(Buffer&& other) noexcept;
    ~Buffer();

    CUdeviceptr address() const { return reinterpret_cast<CUdeviceptr>(data_); }
    size_t size() const { return size_; }
    template <class T>
    T* as() const {
        return static_cast<T*>(data_);
    }
    void fill(int byte) const {
        if (size_ != 0)
            std::memset(data_, byte, size_);
    }

private:
    void* data_ = nullptr;
    size_t size_ = 0;
};

struct LogLine {
    unsigned level;
    std::string tag;
    std::string text;
};

// Lines of a context's log; any thread may call the callback.
class LogRecord {
public:
    static void callback(unsigned level, const char* tag, const char* message, void* self);
    void clear();
    std::vector<LogLine> lines() const;
    // A line of level 1 or 2 containing both texts.
    bool hasError(std::string_view first, std::string_view second) const;
    // An error without the text given to expect().
    bool hasUnexpectedError() const;
    void expect(std::string text) { expected_ = std::move(text); }
    std::string all() const;

private:
    mutable std::mutex mutex_;
    std::vector<LogLine> lines_;
    std::string expected_;
};

// Loads the library once per process; throws if it cannot.
void loadLibrary();

class ApiTest : public testing::Test {
public:
    // Adds the reports of ended launches to the log of the running test.
    static void hearReports();

protected:
    static void SetUpTestSuite() { loadLibrary(); }
    void SetUp() override;
    void TearDown() override;

    // Checks that the result is `expected` and that the log has an error line with the function's
    // name and `mention`, a word of the cause.
    void expectRejected(OptixResult expected, OptixResult actual, const char* function,
                        const char* mention);

    LogRecord log_;
    OptixDeviceContext context_ = nullptr;

private:
    static ApiTest* running_;
};

// EXPECT_REJECTED(code, "function", "word of the cause", call)
#define EXPECT_REJECTED(code, function, mention, call)                                             \
    do {                                                                                           \
        SCOPED_TRACE(#call);                                                                       \
        log_.clear();                                                                              \
        OptixResult rejectedResult = (call);                                                       \
        expectRejected(code, rejectedResult, function, mention);                                   \
    } while (false)

#define EXPECT_OK(call) EXPECT_EQ(OPTIX_SUCCESS, (call)) << log_.all()
#define ASSERT_OK(call) ASSERT_EQ(OPTIX_SUCCESS, (call)) << log_.all()

// Addresses that are not handles: small, odd, unmapped, a live object of ours.
std::vector<void*> garbageHandles();

// Options that fit most tests: any graph, `payload` words, "params" as launch parameters.
OptixPipelineCompileOptions compileOptions(int payload = 0);

// PTX text: `body` after the three lines that every module begins with.
std::string ptxModule(std::string_view body);

// PTX of a device program of this folder; toolchain is "clang" or "nvcc".
std::string compiledPtx(const std::string& program, const std::string& toolchain);
std::vector<std::string> toolchains();

} // namespace tests::api
