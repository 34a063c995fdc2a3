// SPDX-License-Identifier: Apache-2.0
// Runs a part of a test in a child of the test program.
#pragma once

#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <functional>

namespace tests {

// Whether exit looks for leaks. A child would report the objects of the parent's other threads.
#if defined(__SANITIZE_ADDRESS__)
constexpr bool kFindsLeaks = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
constexpr bool kFindsLeaks = true;
#else
constexpr bool kFindsLeaks = false;
#endif
#else
constexpr bool kFindsLeaks = false;
#endif

// Runs the body in a child, which ends with its result as exit code; -1 if the child hangs or dies.
// exits: the child runs exit handlers and destructors.
inline int inChild(const std::function<int()>& body, bool exits = true) {
    std::fflush(nullptr);
    const pid_t child = fork();
    if (child == 0) {
        constexpr unsigned kSeconds = 20;
        alarm(kSeconds);
        const int code = body();
        if (exits && !kFindsLeaks)
            std::exit(code);
        _exit(code);
    }
    int status = 0;
    EXPECT_EQ(child, waitpid(child, &status, 0));
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

} // namespace tests
