// SPDX-License-Identifier: Apache-2.0
// Errors of the engine. A caller's mistake is thrown as Error with a code; each API shell turns it
// into its API's code in one place (its `guarded` function). SUNSTONE_CHECK guards our own
// invariants. Read next: log.h.
#pragma once

#include <cstdint>
#include <locale>
#include <sstream>
#include <stdexcept>
#include <string>

namespace sunstone {

// The kind of error, in terms that every shell can translate.
enum class Code : uint32_t {
    kOk = 0,
    kInvalidValue,
    kOutOfMemory,
    kInvalidOperation,
    kNotSupported,
    kInvalidPtx,
    kInvalidLaunchParameter,
    kInvalidPayloadAccess,
    kInvalidAttributeAccess,
    kInvalidFunctionUse,
    kInvalidFunctionArguments,
    kLinkError,
    kOutOfConstantMemory,
    kInvalidContext,
    kNotInitialized,
    kLaunchFailure,
    kCudaError, // reported by a GPU's driver
    kAccelNotCompatible,
    kPayloadTypeMismatch,
    kPayloadTypeResolution,
    kPayloadTypeId,
    kNotFound,
    kFileError,
    kIllegalDuringTask,
    kCacheInvalidPath,
    kCachePermission,
    kCacheDatabase,
    kInternal,
};

class Error : public std::runtime_error {
public:
    Error(Code code, const std::string& text) : std::runtime_error(text), code_(code) {}
    Code code() const { return code_; }

private:
    Code code_;
};

// Builds a message from its parts: message("size ", size, " is not a multiple of ", 16). The
// process's locale has no effect on numbers.
template <class... Parts>
std::string message(const Parts&... parts) {
    std::ostringstream stream;
    stream.imbue(std::locale::classic());
    (stream << ... << parts);
    return stream.str();
}

// Throws Error(code, message(parts...)).
template <class... Parts>
[[noreturn]] void fail(Code code, const Parts&... parts) {
    throw Error(code, message(parts...));
}

// Reports a broken invariant of ours: aborts a debug build, throws Error(kInternal) in a release
// build.
[[noreturn]] void checkFailed(const char* file, int line, const std::string& text);

} // namespace sunstone

#define SUNSTONE_CHECK(cond)                                                                       \
    ((cond) ? (void)0 : ::sunstone::checkFailed(__FILE__, __LINE__, #cond))
#define SUNSTONE_CHECK_EQ(a, b)                                                                    \
    ((a) == (b) ? (void)0                                                                          \
                : ::sunstone::checkFailed(__FILE__, __LINE__,                                      \
                                          ::sunstone::message(#a " == " #b ", but ", (a),          \
                                                              " != ", (b))))
