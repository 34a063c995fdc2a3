// SPDX-License-Identifier: Apache-2.0
// Assertions in device code, compiled at several levels.
#include "device/asserts.h"
#include "rig.h"

namespace tests::api {
namespace {

// The level at which the compiler worked is a part of the name.
class Assertions : public DeviceTest {
protected:
    void check(const char* name) {
        Rig rig(context_, log_, program(name), compileOptions(0));
        rig.raygenRecord(rig.raygen("__raygen__rg"));
        rig.link();
        Buffer out(16 * 4);
        rig.run(AssertParams{out.as<unsigned>(), 16}, 16);
        for (unsigned i = 0; i < 16; ++i)
            EXPECT_EQ(3 * i, out.as<unsigned>()[i]);
        testing::internal::CaptureStderr();
        EXPECT_THROW(rig.run(AssertParams{out.as<unsigned>(), 15}, 16), std::runtime_error);
        std::fflush(stderr);
        const std::string text = testing::internal::GetCapturedStderr();
        EXPECT_NE(std::string::npos, text.find("asserts.cu:12: ")) << text;
        EXPECT_NE(std::string::npos, text.find("value < params.limit")) << text;
        // The stream's next call returns the error once more.
        EXPECT_THROW(rig.run(AssertParams{out.as<unsigned>(), 16}, 16), std::runtime_error);
    }
};

TEST_P(Assertions, Optimised) {
    check("asserts");
}

TEST_P(Assertions, OptimisedALittle) {
    if (GetParam() == "nvcc")
        GTEST_SKIP() << "clang alone has this level";
    check("asserts_O1");
}

TEST_P(Assertions, NotOptimised) {
    if (GetParam() == "nvcc")
        GTEST_SKIP() << "clang alone has this level";
    check("asserts_O0");
}

INSTANTIATE_DEVICE_TEST(Assertions);

} // namespace
} // namespace tests::api
