// SPDX-License-Identifier: Apache-2.0
// Code that the C++ programs of this folder share: main() around a program that throws.
#pragma once

#include <optixu/optixpp_namespace.h>

#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>

extern "C" const char device_ptx[]; // of the program, which the build embeds

inline void require(bool holds, const std::string& what) {
    if (!holds)
        throw std::runtime_error(what);
}

template <class Body>
int runProgram(const Body& body) {
    try {
        body();
        std::printf("ok\n");
        return 0;
    } catch (const std::exception& failure) {
        std::printf("failed: %s\n", failure.what());
        return 1;
    }
}
