// SPDX-License-Identifier: Apache-2.0
// The functions of nvrtc.h. Error codes of wrong calls are those of the toolkit's library (13.0).
#include "api/nvrtc/program.h"
#include "base/error.h"
#include "base/handles.h"
#include "base/log.h"

#include <cstring>
#include <new>

namespace sunstone::nvrtc {

namespace {

constexpr int kDefaultArchitecture = kMajor == 12 ? 52 : 75;

HandleTable<Program>& programs() {
    static auto* table = new HandleTable<Program>;
    return *table;
}

// Runs a body that may throw.
template <class Body>
nvrtcResult guarded(const char* function, Body&& body) {
    try {
        return body();
    } catch (const std::bad_alloc&) {
        return NVRTC_ERROR_OUT_OF_MEMORY;
    } catch (const std::exception& error) {
        log(LogLevel::kError, "nvrtc", message(function, ": ", error.what()));
        return NVRTC_ERROR_BUILTIN_OPERATION_FAILURE;
    }
}

// The same for a function of a program.
template <class Body>
nvrtcResult withProgram(const char* function, nvrtcProgram handle, Body&& body) {
    return guarded(function, [&] {
        const std::shared_ptr<Program> program = programs().find(handle);
        return program ? body(*program) : NVRTC_ERROR_INVALID_PROGRAM;
    });
}

nvrtcResult giveSize(const char* function, nvrtcProgram handle, size_t* size,
                     std::string (Program::*text)(), bool isText) {
    return withProgram(function, handle, [&](Program& program) {
        if (!size)
            return NVRTC_ERROR_INVALID_INPUT;
        const size_t length = (program.*text)().size();
        *size = length || isText ? length + 1 : 0;
        return NVRTC_SUCCESS;
    });
}

nvrtcResult giveText(const char* function, nvrtcProgram handle, char* to,
                     std::string (Program::*text)(), bool isText) {
    return withProgram(function, handle, [&](Program& program) {
        if (!to)
            return NVRTC_ERROR_INVALID_INPUT;
        const std::string from = (program.*text)();
        if (!from.empty() || isText)
            std::memcpy(to, from.c_str(), from.size() + 1);
        return NVRTC_SUCCESS;
    });
}

// For formats that do not exist here.
nvrtcResult giveNoSize(const char* function, nvrtcProgram handle, size_t* size) {
    return withProgram(function, handle, [&](Program&) {
        if (!size)
            return NVRTC_ERROR_INVALID_INPUT;
        *size = 0;
        return NVRTC_SUCCESS;
    });
}
nvrtcResult giveNothing(const char* function, nvrtcProgram handle, const char* to) {
    return withProgram(function, handle,
                       [&](Program&) { return to ? NVRTC_SUCCESS : NVRTC_ERROR_INVALID_INPUT; });
}

size_t pchHeapSize = 256u << 20;

} // namespace

} // namespace sunstone::nvrtc

using namespace sunstone::nvrtc;

#define SUNSTONE_NVRTC extern "C" __attribute__((visibility("default")))

SUNSTONE_NVRTC const char* nvrtcGetErrorString(nvrtcResult result) {
    static constexpr const char* kNames[] = {
        "NVRTC_SUCCESS",
        "NVRTC_ERROR_OUT_OF_MEMORY",
        "NVRTC_ERROR_PROGRAM_CREATION_FAILURE",
        "NVRTC_ERROR_INVALID_INPUT",
        "NVRTC_ERROR_INVALID_PROGRAM",
        "NVRTC_ERROR_INVALID_OPTION",
        "NVRTC_ERROR_COMPILATION",
        "NVRTC_ERROR_BUILTIN_OPERATION_FAILURE",
        "NVRTC_ERROR_NO_NAME_EXPRESSIONS_AFTER_COMPILATION",
        "NVRTC_ERROR_NO_LOWERED_NAMES_BEFORE_COMPILATION",
        "NVRTC_ERROR_NAME_EXPRESSION_NOT_VALID",
        "NVRTC_ERROR_INTERNAL_ERROR",
        "NVRTC_ERROR_TIME_FILE_WRITE_FAILED",
        "NVRTC_ERROR_NO_PCH_CREATE_ATTEMPTED",
        "NVRTC_ERROR_PCH_CREATE_HEAP_EXHAUSTED",
        "NVRTC_ERROR_PCH_CREATE",
        "NVRTC_ERROR_CANCELLED",
        "NVRTC_ERROR_TIME_TRACE_FILE_WRITE_FAILED",
    };
    const auto number = static_cast<unsigned>(result);
    return number < std::size(kNames) ? kNames[number] : "NVRTC_ERROR unknown";
}

SUNSTONE_NVRTC nvrtcResult nvrtcVersion(int* major, int* minor) {
    if (!major || !minor)
        return NVRTC_ERROR_INVALID_INPUT;
    *major = kMajor;
    *minor = kMinor;
    return NVRTC_SUCCESS;
}

SUNSTONE_NVRTC nvrtcResult nvrtcGetNumSupportedArchs(int* count) {
    if (!count)
        return NVRTC_ERROR_INVALID_INPUT;
    *count = int(architectures().size());
    return NVRTC_SUCCESS;
}

SUNSTONE_NVRTC nvrtcResult nvrtcGetSupportedArchs(int* list) {
    if (!list)
        return NVRTC_ERROR_INVALID_INPUT;
    for (const int architecture : architectures())
        *list++ = architecture;
    return NVRTC_SUCCESS;
}

SUNSTONE_NVRTC nvrtcResult nvrtcCreateProgram(nvrtcProgram* program, const char* source,
                                              const char* name, int headerCount,
                                              const char* const* headers,
                                              const char* const* includeNames) {
    if (!program)
        return NVRTC_ERROR_INVALID_PROGRAM;
    return guarded("nvrtcCreateProgram", [&] {
        if (!source || headerCount < 0 || (headerCount > 0 && (!headers || !includeNames)))
            return NVRTC_ERROR_INVALID_INPUT;
        std::vector<Header> list;
        for (int i = 0; i < headerCount; ++i) {
            if (!headers[i] || !includeNames[i] || !*includeNames[i])
                return NVRTC_ERROR_INVALID_INPUT;
            list.push_back({includeNames[i], headers[i]});
        }
        auto made = std::make_shared<Program>(source, name && *name ? name : "default_program",
                                              std::move(list));
        *program = static_cast<nvrtcProgram>(programs().add(std::move(made)));
        return NVRTC_SUCCESS;
    });
}

SUNSTONE_NVRTC nvrtcResult nvrtcDestroyProgram(nvrtcProgram* program) {
    if (!program)
        return NVRTC_ERROR_INVALID_PROGRAM;
    return guarded("nvrtcDestroyProgram", [&] {
        if (!programs().remove(*program))
            return NVRTC_ERROR_INVALID_PROGRAM;
        *program = nullptr;
        return NVRTC_SUCCESS;
    });
}

SUNSTONE_NVRTC nvrtcResult nvrtcCompileProgram(nvrtcProgram handle, int count,
                                               const char* const* options) {
    return withProgram("nvrtcCompileProgram", handle, [&](Program& program) {
        if (count < 0)
            return NVRTC_ERROR_INVALID_INPUT;
        std::vector<std::string> words;
        for (int i = 0; i < count; ++i) {
            if (!options || !options[i])
                return NVRTC_ERROR_INVALID_OPTION;
            words.emplace_back(options[i]);
        }
        return program.compile(words, kDefaultArchitecture);
    });
}

SUNSTONE_NVRTC nvrtcResult nvrtcSetFlowCallback(nvrtcProgram handle, int (*callback)(void*, void*),
                                                void*) {
    // clang cannot be stopped between phases, so the function is never called.
    return withProgram("nvrtcSetFlowCallback", handle, [&](Program&) {
        return callback ? NVRTC_SUCCESS : NVRTC_ERROR_INVALID_INPUT;
    });
}

#define SUNSTONE_RESULT(name, text, isText)                                                        \
    SUNSTONE_NVRTC nvrtcResult name##Size(nvrtcProgram program, size_t* size) {                    \
        return giveSize(#name "Size", program, size, &Program::text, isText);                      \
    }                                                                                              \
    SUNSTONE_NVRTC nvrtcResult name(nvrtcProgram program, char* to) {                              \
        return giveText(#name, program, to, &Program::text, isText);                               \
    }
SUNSTONE_RESULT(nvrtcGetProgramLog, log, true)
SUNSTONE_RESULT(nvrtcGetPTX, ptx, true)
SUNSTONE_RESULT(nvrtcGetCUBIN, image, false)

#define SUNSTONE_NO_RESULT(name)                                                                   \
    SUNSTONE_NVRTC nvrtcResult name##Size(nvrtcProgram program, size_t* size) {                    \
        return giveNoSize(#name "Size", program, size);                                            \
    }                                                                                              \
    SUNSTONE_NVRTC nvrtcResult name(nvrtcProgram program, char* to) {                              \
        return giveNothing(#name, program, to);                                                    \
    }
SUNSTONE_NO_RESULT(nvrtcGetLTOIR)
SUNSTONE_NO_RESULT(nvrtcGetOptiXIR)
#ifdef SUNSTONE_NVRTC_12
SUNSTONE_NO_RESULT(nvrtcGetNVVM)
#endif

SUNSTONE_NVRTC nvrtcResult nvrtcAddNameExpression(nvrtcProgram handle, const char* expression) {
    return withProgram("nvrtcAddNameExpression", handle, [&](Program& program) {
        return expression ? program.addName(expression) : NVRTC_ERROR_INVALID_INPUT;
    });
}

SUNSTONE_NVRTC nvrtcResult nvrtcGetLoweredName(nvrtcProgram handle, const char* expression,
                                               const char** name) {
    return withProgram("nvrtcGetLoweredName", handle, [&](Program& program) {
        return expression && name ? program.loweredName(expression, name)
                                  : NVRTC_ERROR_INVALID_INPUT;
    });
}

SUNSTONE_NVRTC nvrtcResult nvrtcGetPCHHeapSize(size_t* size) {
    if (!size)
        return NVRTC_ERROR_INVALID_INPUT;
    *size = __atomic_load_n(&pchHeapSize, __ATOMIC_RELAXED);
    return NVRTC_SUCCESS;
}
SUNSTONE_NVRTC nvrtcResult nvrtcSetPCHHeapSize(size_t size) {
    __atomic_store_n(&pchHeapSize, size, __ATOMIC_RELAXED);
    return NVRTC_SUCCESS;
}
SUNSTONE_NVRTC nvrtcResult nvrtcGetPCHCreateStatus(nvrtcProgram handle) {
    return withProgram("nvrtcGetPCHCreateStatus", handle,
                       [](Program&) { return NVRTC_ERROR_NO_PCH_CREATE_ATTEMPTED; });
}
SUNSTONE_NVRTC nvrtcResult nvrtcGetPCHHeapSizeRequired(nvrtcProgram handle, size_t* size) {
    return giveNoSize("nvrtcGetPCHHeapSizeRequired", handle, size);
}
