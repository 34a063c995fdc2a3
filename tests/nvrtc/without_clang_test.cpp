// SPDX-License-Identifier: Apache-2.0
// If no clang is found, the message of the compilation names the remedy. ctest sets SUNSTONE_CLANG
// to another program.
#include <gtest/gtest.h>
#include <nvrtc.h>

#include <string>

TEST(NvrtcWithoutClang, SaysSo) {
    nvrtcProgram program = nullptr;
    ASSERT_EQ(nvrtcCreateProgram(&program, "", nullptr, 0, nullptr, nullptr), NVRTC_SUCCESS);
    EXPECT_EQ(nvrtcCompileProgram(program, 0, nullptr), NVRTC_ERROR_BUILTIN_OPERATION_FAILURE);
    char log[4096] = {};
    size_t size = 0;
    ASSERT_EQ(nvrtcGetProgramLogSize(program, &size), NVRTC_SUCCESS);
    ASSERT_LE(size, sizeof log);
    EXPECT_EQ(nvrtcGetProgramLog(program, log), NVRTC_SUCCESS);
    EXPECT_NE(std::string(log).find("SUNSTONE_CLANG"), std::string::npos) << log;
    EXPECT_EQ(nvrtcDestroyProgram(&program), NVRTC_SUCCESS);
}
