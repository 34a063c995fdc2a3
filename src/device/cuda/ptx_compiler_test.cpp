// SPDX-License-Identifier: Apache-2.0
// The PTX compiler on its stand-in (ptx_compiler_stand_in.cpp), and without a library.
#include "device/cuda/ptx_compiler.h"

#include <gtest/gtest.h>

#include <dlfcn.h>

#include <cstdlib>

namespace sunstone::device::cuda {
namespace {

TEST(PtxCompiler, GivesMachineCodeAndLog) {
    // A library loaded by its path is found by its name.
    ASSERT_TRUE(dlopen(TEST_PTX_COMPILER, RTLD_NOW)) << dlerror();
    const auto made = compilePtx("the text", 90, 72);
    ASSERT_TRUE(made);
    EXPECT_STREQ(made->cubin.c_str(),
                 "// --gpu-name=sm_90\n// --maxrregcount=72\n// --verbose\nthe text");
    EXPECT_NE(made->log.find("48 bytes stack frame"), std::string::npos);
    EXPECT_EQ(made->log.find('\0'), std::string::npos);
    EXPECT_FALSE(compilePtx("refused", 90, 72));
    EXPECT_TRUE(compilePtx("", 120, 255));
}

TEST(PtxCompiler, IsNotNeeded) {
    // In a process without the library, unless the machine has a GPU's driver.
    void* const there = dlopen(kPtxCompilerLibrary, RTLD_NOW | RTLD_LOCAL);
    if (!there)
        EXPECT_FALSE(compilePtx("the text", 90, 72));
    else
        dlclose(there);
}

} // namespace
} // namespace sunstone::device::cuda
