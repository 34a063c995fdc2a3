// SPDX-License-Identifier: Apache-2.0
// Linked into tests of the classic API: each function of the API, in front of the library's own.
//
// SUNSTONE_CLASSIC_CALLS names a folder: each test that passes leaves a file there, named after the
// test, with a line for each function: its name and one letter for each call, S (success) or F.
//
// SUNSTONE_CLASSIC_DROP is "function letters", as in such a line: calls with the letter S, and
// calls beyond the letters, return success and do nothing. check.cpp uses this to prove that a test
// detects a missing effect of the function.
#include "optix.h"
#include "optix_cuda_interop.h"
#include "optix_gl_interop.h"
#include "optixu/optixu.h"

#include <gtest/gtest.h>

#include <dlfcn.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <mutex>
#include <string>

namespace {

struct Calls {
    std::mutex mutex;
    std::map<std::string, std::string> letters; // of the running test
    std::string dropped, pattern;
    size_t next = 0; // call of the dropped function

    Calls() {
        const char* drop = std::getenv("SUNSTONE_CLASSIC_DROP");
        const std::string text = drop ? drop : "";
        const size_t blank = text.find(' ');
        dropped = text.substr(0, blank);
        pattern = blank == std::string::npos ? "" : text.substr(blank + 1);
    }
    bool drops(const char* function) {
        if (dropped != function)
            return false;
        std::lock_guard lock(mutex);
        const size_t number = next++;
        return number >= pattern.size() || pattern[number] == 'S';
    }
    RTresult noted(const char* function, RTresult result) {
        std::lock_guard lock(mutex);
        letters[function] += result == RT_SUCCESS ? 'S' : 'F';
        return result;
    }
};

Calls& calls() {
    static Calls instance;
    return instance;
}

template <class Function>
Function* realOf(Function*, const char* name) {
    void* const found = dlsym(RTLD_NEXT, name);
    if (!found)
        std::abort();
    return reinterpret_cast<Function*>(found);
}

class Writer : public testing::EmptyTestEventListener {
public:
    explicit Writer(std::string folder) : folder_(std::move(folder)) {}

private:
    void OnTestStart(const testing::TestInfo&) override {
        std::lock_guard lock(calls().mutex);
        calls().letters.clear();
    }
    void OnTestEnd(const testing::TestInfo& test) override {
        if (!test.result()->Passed())
            return;
        const std::string path =
            folder_ + "/" + std::string(test.test_suite_name()) + "." + test.name();
        std::lock_guard lock(calls().mutex);
        std::ofstream file(path);
        for (const auto& [function, letters] : calls().letters)
            file << function << " " << letters << "\n";
        if (!file.flush())
            ADD_FAILURE() << "cannot write " << path;
    }
    std::string folder_;
};

const bool gWrites = [] {
    const char* folder = std::getenv("SUNSTONE_CLASSIC_CALLS");
    if (folder && *folder)
        testing::UnitTest::GetInstance()->listeners().Append(new Writer(folder));
    return folder != nullptr;
}();

} // namespace

#define API6_DEFINITION(name, parameters, ...)                                                     \
    RTresult name parameters {                                                                     \
        static const auto real_ = realOf(&name, #name);                                            \
        return calls().drops(#name) ? RT_SUCCESS : calls().noted(#name, real_(__VA_ARGS__));       \
    }
#include "calls.inc"

void rtContextGetErrorString(RTcontext context, RTresult code, const char** text) {
    static const auto real = realOf(&rtContextGetErrorString, "rtContextGetErrorString");
    if (calls().drops("rtContextGetErrorString"))
        return;
    real(context, code, text);
    calls().noted("rtContextGetErrorString", RT_SUCCESS);
}
