// SPDX-License-Identifier: Apache-2.0
#include "calls.h"

Recorder recorder;

#include "calls.inc"

void rtContextGetErrorString(RTcontext context, RTresult code, const char** text) {
    static std::string kept;
    kept = (context ? "context " : "no context ") + std::to_string(code);
    *text = kept.c_str();
}
