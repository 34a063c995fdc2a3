// SPDX-License-Identifier: Apache-2.0
// Instructions that need a newer PTX or an architecture-specific target: a GPU with these
// instructions runs them; for other devices, the log names the instruction and its line.
#include "device_memory.h"
#include "rig.h"

namespace tests::api {
namespace {

class NewerPtx : public ApiTest {
protected:
    // A ray generation program with the launch parameters' pointer in %rd1.
    static std::string program(const std::string& top, const std::string& body) {
        return top +
               "\n.address_size 64\n.const .align 8 .b8 params[8];\n"
               ".visible .entry __raygen__main()\n{\n.reg .b64 %rd<8>;\n.reg .b32 %r<8>;\n"
               "ld.const.u64 %rd1, [params];\n" +
               body + "ret;\n}\n";
    }
    std::unique_ptr<Rig> rig(const std::string& text) {
        auto rig = std::make_unique<Rig>(context_, log_, text, compileOptions(0));
        rig->raygenRecord(rig->raygen("__raygen__main"));
        return rig;
    }
};

// Architecture 9.0 has an instruction that writes fields of the descriptions of tensors in memory.
TEST_F(NewerPtx, TargetsOfAnArchitecture) {
    const std::string text =
        program(".version 8.3\n.target sm_90a",
                "add.u64 %rd2, %rd1, 128;\nmov.u64 %rd3, 0x123456789ab0;\n"
                "tensormap.replace.tile.global_address.global.b1024.b64 [%rd2], %rd3;\n");
    std::unique_ptr<Rig> one;
    if (computeCapability() != 90) {
        try {
            one = rig(text);
            one->link();
            FAIL() << "who has tensormap.replace here?";
        } catch (const std::runtime_error& error) {
            const std::string what = error.what();
            EXPECT_NE(std::string::npos, what.find("line 12: ")) << what;
            EXPECT_NE(std::string::npos, what.find("tensormap.replace.tile.")) << what;
        }
        GTEST_SKIP() << "runs on GPUs of compute capability 9.0; here it is refused";
    }
    one = rig(text);
    one->link();
    Buffer map(256);
    one->run(map.address(), 1);
    const auto* const fields = map.as<uint64_t>();
    for (int i = 0; i < 16; ++i)
        EXPECT_EQ(0u, fields[i]) << i;
    int found = 0;
    for (int i = 16; i < 32; ++i)
        found += fields[i] == 0x123456789ab0;
    EXPECT_EQ(1, found) << "the address that the program writes into the description";
}

// A fence of PTX 8.6, which LLVM 19 and Sunstone's table lack, between a store and a load.
TEST_F(NewerPtx, VersionsThatLlvmDoesNotWrite) {
    const std::string text =
        program(".version 8.6\n.target sm_90",
                "st.global.u32 [%rd1], 41;\n"
                "fence.proxy.async::generic.acquire.sync_restrict::shared::cluster.cluster;\n"
                "ld.global.u32 %r1, [%rd1];\nadd.u32 %r1, %r1, 1;\nst.global.u32 [%rd1+4], %r1;\n");
    constexpr int kDriverOfPtx86 = 12070;
    if (computeCapability() < 90 || driverVersion() < kDriverOfPtx86) {
        OptixModule module = nullptr;
        const OptixModuleCompileOptions moduleOptions{};
        const OptixPipelineCompileOptions options = compileOptions(0);
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_PTX, "optixModuleCreateFromPTX", "line 11:",
                        optixModuleCreateFromPTX(context_, &moduleOptions, &options, text.data(),
                                                 text.size(), nullptr, nullptr, &module));
        GTEST_SKIP() << "runs on GPUs from compute capability 9.0 on; here it is refused";
    }
    const auto one = rig(text);
    one->link();
    Buffer out(8);
    one->run(out.address(), 1);
    EXPECT_EQ(42u, out.as<uint32_t>()[1]);
}

// Modules for another GPU's target run here if they use none of its features.
TEST_F(NewerPtx, WhatIsDeclaredAndNotUsed) {
    for (const char* top : {".version 9.0\n.target sm_90", ".version 9.0\n.target sm_120a"}) {
        SCOPED_TRACE(top);
        const auto one = rig(program(top, "st.global.u32 [%rd1], 43;\n"));
        one->link();
        Buffer out(4);
        one->run(out.address(), 1);
        EXPECT_EQ(43u, out.as<uint32_t>()[0]);
    }
}

// Before PTX 6.4 warp functions needed no list of members.
TEST_F(NewerPtx, OlderWarpFunctions) {
    const auto one =
        rig(program(".version 6.0\n.target sm_60", ".reg .pred %p;\nsetp.ne.u64 %p, %rd1, 0;\n"
                                                   "vote.ballot.b32 %r1, %p;\npopc.b32 %r1, %r1;\n"
                                                   "st.global.u32 [%rd1], %r1;\n"));
    one->link();
    Buffer out(4);
    one->run(out.address(), 1);
    EXPECT_EQ(1u, out.as<uint32_t>()[0]) << "the only ray generation program";
}

// Addresses of local and constant memory may be words.
TEST_F(NewerPtx, AddressesOfAWord) {
    const auto one = rig(program(
        ".version 7.8\n.target sm_70",
        ".local .align 4 .b8 l[64];\nmov.u32 %r1, l;\nadd.u32 %r2, %r1, 4;\n"
        "st.local.u32 [%r2], 77;\n"
        "ld.local.u32 %r3, [l+4];\nst.global.u32 [%rd1], %r3;\n"
        "mov.u32 %r4, params;\nld.const.u64 %rd2, [%r4];\nst.global.u64 [%rd1+8], %rd2;\n"));
    one->link();
    Buffer out(16);
    one->run(out.address(), 1);
    EXPECT_EQ(77u, out.as<uint32_t>()[0]);
    EXPECT_EQ(out.address(), out.as<uint64_t>()[1]);
    const auto two = rig(program(".version 7.8\n.target sm_70\n.const .u32 c = 5;",
                                 "mov.u32 %r4, c;\nmov.u32 %r5, params;\n"
                                 "ld.const.u32 %r6, [%r4];\nst.global.u32 [%rd1], %r6;\n"));
    log_.clear();
    EXPECT_NE(OPTIX_SUCCESS, two->tryLink(1));
    EXPECT_TRUE(log_.hasError("line 13: ld.const.u32: ", "several variables in .const"))
        << log_.all();
}

// A block of a program declares the function that it calls and the module defines after it.
TEST_F(NewerPtx, FunctionsDeclaredInBodies) {
    const auto text = [](const std::string& declaration) {
        return program(".version 7.8\n.target sm_70",
                       "ld.global.u32 %r1, [%rd1];\n{ " + declaration +
                           "\ncall.uni (%r2), tripled, (%r1);\n}\nst.global.u32 [%rd1], %r2;\n") +
               ".func (.reg .b32 r) tripled(.param .b32 a)\n{\n.reg .b32 %r;\n"
               "ld.param.u32 %r, [a];\nmul.lo.u32 r, %r, 3;\nret;\n}\n";
    };
    const auto one = rig(text(".func (.reg .b32 r) tripled(.param .b32 a);"));
    one->link();
    Buffer out(4);
    out.as<uint32_t>()[0] = 14;
    one->run(out.address(), 1);
    EXPECT_EQ(42u, out.as<uint32_t>()[0]);
    OptixModule module = nullptr;
    const OptixModuleCompileOptions moduleOptions{};
    const OptixPipelineCompileOptions options = compileOptions(0);
    const std::string other = text(".func (.reg .b32 r) tripled(.param .b64 a);");
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_PTX, "optixModuleCreateFromPTX",
                    "function 'tripled' has parameter 1 of 4 bytes here, of 8 bytes at line 11",
                    optixModuleCreateFromPTX(context_, &moduleOptions, &options, other.data(),
                                             other.size(), nullptr, nullptr, &module));
}

} // namespace
} // namespace tests::api
