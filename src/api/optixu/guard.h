// SPDX-License-Identifier: Apache-2.0
// The guard of every entry point, and refused calls: a line in the log and a code.
#pragma once

#include "base/forked.h"
#include "base/log.h"

#include <optix_host.h>

#include <exception>
#include <new>
#include <string>

#define SUNSTONE_API extern "C" __attribute__((visibility("default")))

namespace sunstone::optixu {

inline RTresult refuse(const char* function, RTresult code, const std::string& text) {
    log(LogLevel::kError, "optixu", std::string(function) + ": " + text);
    return code;
}

// Runs a body that returns a RTresult; no exception leaves it.
template <class Body>
RTresult guarded(const char* function, const Body& body) {
    if (refusesForkedChild())
        return RT_ERROR_UNKNOWN;
    try {
        return body();
    } catch (const std::bad_alloc&) {
        return RT_ERROR_MEMORY_ALLOCATION_FAILED;
    } catch (const std::exception& e) {
        return refuse(function, RT_ERROR_UNKNOWN, e.what());
    }
}

} // namespace sunstone::optixu
