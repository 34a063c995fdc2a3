// SPDX-License-Identifier: Apache-2.0
// Program groups, stack sizes and record headers (OptiX 7.4, sections 3.8, 3.9.2.2, 5.29 to 5.32).
#include "fixture.h"

namespace tests::api {
namespace {

constexpr const char* kFunction = "optixProgramGroupCreate";

class ProgramGroup : public ApiTest {
protected:
    void SetUp() override {
        ApiTest::SetUp();
        module_ = create(ptxModule(R"(
.visible .entry __raygen__a() { ret; }
.visible .entry __miss__a() { ret; }
.visible .entry __exception__a() { ret; }
.visible .entry __closesthit__a() { ret; }
.visible .entry __anyhit__a() { ret; }
.visible .entry __intersection__a() { ret; }
.visible .func __direct_callable__a() { ret; }
.visible .func __continuation_callable__a() { ret; }
.visible .func helper() { ret; }
)"));
    }
    OptixModule create(const std::string& text) {
        OptixModule module = nullptr;
        EXPECT_OK(optixModuleCreateFromPTX(context_, &moduleOptions_, &options_, text.data(),
                                           text.size(), nullptr, nullptr, &module));
        return module;
    }
    static OptixProgramGroupDesc single(OptixProgramGroupKind kind, OptixModule module,
                                        const char* name) {
        OptixProgramGroupDesc desc{};
        desc.kind = kind;
        desc.raygen = {module, name}; // raygen, miss and exception share their place in the union
        return desc;
    }
    OptixProgramGroupDesc hit(const char* ch, const char* ah, const char* is) const {
        OptixProgramGroupDesc desc{};
        desc.kind = OPTIX_PROGRAM_GROUP_KIND_HITGROUP;
        desc.hitgroup = {ch ? module_ : nullptr, ch, ah ? module_ : nullptr, ah,
                         is ? module_ : nullptr, is};
        return desc;
    }
    OptixProgramGroupDesc callables(const char* dc, const char* cc) const {
        OptixProgramGroupDesc desc{};
        desc.kind = OPTIX_PROGRAM_GROUP_KIND_CALLABLES;
        desc.callables = {dc ? module_ : nullptr, dc, cc ? module_ : nullptr, cc};
        return desc;
    }
    OptixResult create(const OptixProgramGroupDesc& desc) {
        group_ = reinterpret_cast<OptixProgramGroup>(1);
        return optixProgramGroupCreate(context_, &desc, 1, &groupOptions_, nullptr, nullptr,
                                       &group_);
    }
    void expectGood(const OptixProgramGroupDesc& desc) {
        ASSERT_OK(create(desc));
        ASSERT_NE(nullptr, group_);
        OptixStackSizes sizes;
        std::memset(&sizes, 0xAB, sizeof(sizes));
        EXPECT_OK(optixProgramGroupGetStackSize(group_, &sizes));
        char header[OPTIX_SBT_RECORD_HEADER_SIZE + 1];
        std::memset(header, 0x5A, sizeof(header));
        EXPECT_OK(optixSbtRecordPackHeader(group_, header));
        EXPECT_EQ(0x5A, header[OPTIX_SBT_RECORD_HEADER_SIZE]) << "header longer than 32 bytes";
        EXPECT_OK(optixProgramGroupDestroy(group_));
    }
    void expectRefused(const char* mention, const OptixProgramGroupDesc& desc) {
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, mention, create(desc));
        EXPECT_EQ(nullptr, group_);
    }

    OptixModuleCompileOptions moduleOptions_{};
    OptixPipelineCompileOptions options_ = compileOptions();
    OptixProgramGroupOptions groupOptions_{};
    OptixModule module_ = nullptr;
    OptixProgramGroup group_ = nullptr;
};

constexpr auto kRaygen = OPTIX_PROGRAM_GROUP_KIND_RAYGEN;
constexpr auto kMiss = OPTIX_PROGRAM_GROUP_KIND_MISS;
constexpr auto kException = OPTIX_PROGRAM_GROUP_KIND_EXCEPTION;

TEST_F(ProgramGroup, EveryKind) {
    expectGood(single(kRaygen, module_, "__raygen__a"));
    expectGood(single(kMiss, module_, "__miss__a"));
    expectGood(single(kMiss, nullptr, nullptr));
    expectGood(single(kException, module_, "__exception__a"));
    for (int bits = 0; bits < 8; ++bits)
        expectGood(hit(bits & 1 ? "__closesthit__a" : nullptr, bits & 2 ? "__anyhit__a" : nullptr,
                       bits & 4 ? "__intersection__a" : nullptr));
    expectGood(callables("__direct_callable__a", nullptr));
    expectGood(callables(nullptr, "__continuation_callable__a"));
    expectGood(callables("__direct_callable__a", "__continuation_callable__a"));
}

TEST_F(ProgramGroup, ProgramsThatMustBeThere) {
    expectRefused("raygen", single(kRaygen, nullptr, nullptr));
    expectRefused("exception", single(kException, nullptr, nullptr));
    expectRefused("callable", callables(nullptr, nullptr));
}

TEST_F(ProgramGroup, HalfGivenPrograms) {
    for (OptixProgramGroupKind kind : {kRaygen, kMiss, kException}) {
        expectRefused("without", single(kind, module_, nullptr));
        expectRefused("without", single(kind, nullptr, "__raygen__a"));
    }
    OptixProgramGroupDesc desc = hit("__closesthit__a", nullptr, nullptr);
    desc.hitgroup.moduleCH = nullptr;
    expectRefused("closest-hit", desc);
    desc = hit("__closesthit__a", nullptr, nullptr);
    desc.hitgroup.entryFunctionNameCH = nullptr;
    expectRefused("closest-hit", desc);
    desc = hit(nullptr, "__anyhit__a", nullptr);
    desc.hitgroup.moduleAH = nullptr;
    expectRefused("any-hit", desc);
    desc = hit(nullptr, nullptr, "__intersection__a");
    desc.hitgroup.entryFunctionNameIS = nullptr;
    expectRefused("intersection", desc);
    desc = callables("__direct_callable__a", nullptr);
    desc.callables.moduleDC = nullptr;
    expectRefused("direct", desc);
    desc = callables("__direct_callable__a", "__continuation_callable__a");
    desc.callables.moduleCC = nullptr;
    expectRefused("continuation", desc);
}

TEST_F(ProgramGroup, NamesMustBeInTheModule) {
    expectRefused("__raygen__b", single(kRaygen, module_, "__raygen__b"));
    expectRefused("__raygen__", single(kRaygen, module_, "__raygen__"));
    expectRefused("__anyhit__b", hit("__closesthit__a", "__anyhit__b", nullptr));
    expectRefused("__direct_callable__b", callables("__direct_callable__b", nullptr));
}

TEST_F(ProgramGroup, NamesMustHaveTheirPrefix) {
    expectRefused("__raygen__", single(kRaygen, module_, "__miss__a"));
    expectRefused("__raygen__", single(kRaygen, module_, "helper"));
    expectRefused("__raygen__", single(kRaygen, module_, ""));
    expectRefused("__miss__", single(kMiss, module_, "__raygen__a"));
    expectRefused("__exception__", single(kException, module_, "__raygen__a"));
    expectRefused("__closesthit__", hit("__anyhit__a", nullptr, nullptr));
    expectRefused("__anyhit__", hit(nullptr, "__closesthit__a", nullptr));
    expectRefused("__intersection__", hit(nullptr, nullptr, "__closesthit__a"));
    expectRefused("__direct_callable__", callables("__continuation_callable__a", nullptr));
    expectRefused("__continuation_callable__", callables(nullptr, "__direct_callable__a"));
}

TEST_F(ProgramGroup, UnknownKinds) {
    for (unsigned kind : {0u, 0x2420u, 0x2426u, 0xFFFFFFFFu}) {
        OptixProgramGroupDesc desc = single(kRaygen, module_, "__raygen__a");
        std::memcpy(&desc.kind, &kind, sizeof(kind));
        expectRefused("kind", desc);
    }
}

TEST_F(ProgramGroup, NullAndZeroArguments) {
    OptixProgramGroupDesc desc = single(kRaygen, module_, "__raygen__a");
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, "programDescriptions",
                    optixProgramGroupCreate(context_, nullptr, 1, &groupOptions_, nullptr, nullptr,
                                            &group_));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, "programGroups",
                    optixProgramGroupCreate(context_, &desc, 1, &groupOptions_, nullptr, nullptr,
                                            nullptr));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, "numProgramGroups",
                    optixProgramGroupCreate(context_, &desc, 0, &groupOptions_, nullptr, nullptr,
                                            &group_));
    EXPECT_OK(optixProgramGroupCreate(context_, &desc, 1, nullptr, nullptr, nullptr, &group_))
        << "no options stand for all zero";
}

TEST_F(ProgramGroup, AllOrNothing) {
    OptixProgramGroupDesc descs[] = {single(kRaygen, module_, "__raygen__a"),
                                     single(kMiss, module_, "__miss__a"),
                                     single(kMiss, module_, "__miss__wrong"),
                                     hit("__closesthit__a", nullptr, nullptr)};
    OptixProgramGroup made[4];
    std::memset(made, 1, sizeof(made));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, "programDescriptions[2]",
                    optixProgramGroupCreate(context_, descs, 4, &groupOptions_, nullptr, nullptr,
                                            made));
    for (OptixProgramGroup group : made)
        EXPECT_EQ(nullptr, group);
    descs[2].miss.entryFunctionName = "__miss__a";
    ASSERT_OK(optixProgramGroupCreate(context_, descs, 4, &groupOptions_, nullptr, nullptr, made));
    for (size_t i = 0; i < 4; ++i)
        for (size_t j = 0; j < i; ++j)
            EXPECT_NE(made[i], made[j]);
}

TEST_F(ProgramGroup, LogString) {
    OptixProgramGroupDesc desc = single(kRaygen, module_, "__raygen__missing");
    char text[512];
    size_t size = sizeof(text);
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE,
              optixProgramGroupCreate(context_, &desc, 1, &groupOptions_, text, &size, &group_));
    EXPECT_EQ(std::strlen(text) + 1, size);
    EXPECT_NE(nullptr, std::strstr(text, "__raygen__missing"));
    char small[4] = {'#', '#', '#', '#'};
    size_t smallSize = 3;
    EXPECT_EQ(OPTIX_ERROR_INVALID_VALUE, optixProgramGroupCreate(context_, &desc, 1, &groupOptions_,
                                                                 small, &smallSize, &group_));
    EXPECT_EQ(size, smallSize);
    EXPECT_EQ('\0', small[2]);
    EXPECT_EQ('#', small[3]);
    desc.raygen.entryFunctionName = "__raygen__a";
    size = sizeof(text);
    ASSERT_OK(optixProgramGroupCreate(context_, &desc, 1, &groupOptions_, text, &size, &group_));
    EXPECT_EQ(std::strlen(text) + 1, size);
}

// Sizes come from machine code: local memory counts, including that of called functions.
TEST_F(ProgramGroup, StackSizesAreMeasured) {
    const auto entry = [](const std::string& name, const std::string& locals,
                          const std::string& code) {
        return ".visible .entry " + name + "() {\n .reg .b64 %rd<4>; .reg .b32 %r<4>;\n" + locals +
               code + "\n ret; }\n";
    };
    // Written at a computed place, so that the array stays.
    const std::string touch = "call (%r1), _optix_get_launch_index_x, ();\n"
                              "and.b32 %r1, %r1, 60; cvt.u64.u32 %rd1, %r1;\n"
                              "mov.u64 %rd2, box; add.u64 %rd2, %rd2, %rd1;\n"
                              "st.local.u32 [%rd2], %r1; ld.volatile.local.u32 %r2, [box];\n"
                              "st.global.u32 [out], %r2;\n";
    const std::string text = ptxModule(
        ".visible .global .align 4 .u32 out;\n" + entry("__raygen__small", "", "") +
        entry("__raygen__large", ".local .align 4 .b8 box[9000];\n", touch));
    OptixModule module = nullptr;
    OptixModuleCompileOptions moduleOptions{};
    ASSERT_OK(optixModuleCreateFromPTX(context_, &moduleOptions, &options_, text.data(),
                                       text.size(), nullptr, nullptr, &module));
    OptixStackSizes small{}, large{};
    ASSERT_OK(create(single(kRaygen, module, "__raygen__small")));
    ASSERT_OK(optixProgramGroupGetStackSize(group_, &small));
    ASSERT_OK(create(single(kRaygen, module, "__raygen__large")));
    ASSERT_OK(optixProgramGroupGetStackSize(group_, &large));
    EXPECT_LT(small.cssRG, 1024u);
    EXPECT_GE(large.cssRG, 9000u);
    EXPECT_LE(large.cssRG, small.cssRG + 10000);
    optixModuleDestroy(module);
}

TEST_F(ProgramGroup, StackSizesBelongToTheKind) {
    auto sizesOf = [&](const OptixProgramGroupDesc& desc) {
        OptixStackSizes sizes;
        std::memset(&sizes, 0xAB, sizeof(sizes));
        EXPECT_OK(create(desc));
        EXPECT_OK(optixProgramGroupGetStackSize(group_, &sizes));
        return sizes;
    };
    OptixStackSizes s = sizesOf(single(kRaygen, module_, "__raygen__a"));
    EXPECT_GT(s.cssRG, 0u);
    EXPECT_EQ(0u, s.cssMS + s.cssCH + s.cssAH + s.cssIS + s.cssCC + s.dssDC);
    s = sizesOf(single(kMiss, module_, "__miss__a"));
    EXPECT_GT(s.cssMS, 0u);
    EXPECT_EQ(0u, s.cssRG + s.cssCH + s.cssAH + s.cssIS + s.cssCC + s.dssDC);
    s = sizesOf(single(kMiss, nullptr, nullptr));
    EXPECT_EQ(0u, s.cssMS);
    s = sizesOf(hit("__closesthit__a", nullptr, "__intersection__a"));
    EXPECT_GT(s.cssCH, 0u);
    EXPECT_GT(s.cssIS, 0u);
    EXPECT_EQ(0u, s.cssRG + s.cssMS + s.cssAH + s.cssCC + s.dssDC);
    s = sizesOf(hit(nullptr, "__anyhit__a", nullptr));
    EXPECT_GT(s.cssAH, 0u);
    EXPECT_EQ(0u, s.cssCH + s.cssIS);
    s = sizesOf(callables("__direct_callable__a", nullptr));
    EXPECT_GT(s.dssDC, 0u);
    EXPECT_EQ(0u, s.cssCC);
    s = sizesOf(callables(nullptr, "__continuation_callable__a"));
    EXPECT_GT(s.cssCC, 0u);
    EXPECT_EQ(0u, s.dssDC);
    s = sizesOf(single(kException, module_, "__exception__a"));
    EXPECT_EQ(0u, s.cssRG + s.cssMS + s.cssCH + s.cssAH + s.cssIS + s.cssCC + s.dssDC);
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixProgramGroupGetStackSize", "stackSizes",
                    optixProgramGroupGetStackSize(group_, nullptr));
}

TEST_F(ProgramGroup, HeadersAreStableAndDistinct) {
    OptixProgramGroupDesc descs[] = {single(kRaygen, module_, "__raygen__a"),
                                     single(kRaygen, module_, "__raygen__a")};
    OptixProgramGroup made[2];
    ASSERT_OK(optixProgramGroupCreate(context_, descs, 2, &groupOptions_, nullptr, nullptr, made));
    char first[32], again[32], second[33];
    std::memset(first, 0, 32);
    std::memset(again, 0xFF, 32);
    ASSERT_OK(optixSbtRecordPackHeader(made[0], first));
    ASSERT_OK(optixSbtRecordPackHeader(made[0], again));
    ASSERT_OK(optixSbtRecordPackHeader(made[1], second + 1)); // host memory needs no alignment
    EXPECT_EQ(0, std::memcmp(first, again, 32));
    EXPECT_NE(0, std::memcmp(first, second + 1, 32));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixSbtRecordPackHeader", "null",
                    optixSbtRecordPackHeader(made[0], nullptr));
}

} // namespace
} // namespace tests::api
