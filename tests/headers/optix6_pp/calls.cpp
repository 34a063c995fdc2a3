// SPDX-License-Identifier: Apache-2.0
#include "calls.h"

Recorder recorder;

#define API6_DEFINITION(name, parameters, ...)                                                     \
    RTresult name parameters {                                                                     \
        Call call(#name);                                                                          \
        call.addAll(__VA_ARGS__);                                                                  \
        return call.finish();                                                                      \
    }
#include "calls.inc"

void rtContextGetErrorString(RTcontext context, RTresult code, const char** text) {
    static std::string kept;
    kept = (context ? "context " : "no context ") + std::to_string(code);
    *text = kept.c_str();
}
