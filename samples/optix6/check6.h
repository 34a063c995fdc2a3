// SPDX-License-Identifier: Apache-2.0
// Error checks for samples of the classic API: each call is wrapped in RT_CHECK, which throws
// std::runtime_error with the call, its place and the library's own description.
#pragma once

#include <optix.h>

#include <stdexcept>
#include <string>

[[noreturn]] inline void classicFail(RTcontext context, RTresult result, const char* call,
                                     const char* file, int line) {
    const char* reason = "";
    rtContextGetErrorString(context, result, &reason);
    throw std::runtime_error(std::string(call) + " failed: " + reason + " (" + file + ":" +
                             std::to_string(line) + ")");
}

#define RT_CHECK(context, call)                                                                    \
    do {                                                                                           \
        RTresult result_ = (call);                                                                 \
        if (result_ != RT_SUCCESS)                                                                 \
            classicFail(context, result_, #call, __FILE__, __LINE__);                              \
    } while (0)
