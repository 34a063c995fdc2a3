// SPDX-License-Identifier: Apache-2.0
// The runtime libraries that functions of static runtimes are redirected to. The build writes the
// lists from the libraries' exported names (runtime_names.cmake).
#pragma once

#include <cstddef>

namespace sunstone::redirect {

struct Runtime {
    const char* file;         // expanded by the loader
    const char* const* names; // sorted
    size_t count;
};

extern const Runtime kRuntime12, kRuntime13;

} // namespace sunstone::redirect
