// SPDX-License-Identifier: Apache-2.0
// optixModuleCreateFromPTX and optixModuleDestroy (OptiX 7.4, sections 3.6, 5.25, 5.27).
#include "fixture.h"

#include <functional>

namespace tests::api {
namespace {

constexpr const char* kFunction = "optixModuleCreateFromPTX";

const std::string& goodPtx() {
    static const std::string text = ptxModule(R"(
.const .align 8 .b8 params[16];
.visible .entry __raygen__a()
{
    .reg .b32 %r<3>;
    .reg .b64 %rd<3>;
    ld.const.u64 %rd1, [params];
    cvta.to.global.u64 %rd2, %rd1;
    call (%r1), _optix_get_launch_index_x, ();
    st.global.u32 [%rd2], %r1;
    ret;
}
.visible .entry __miss__a() { ret; }
)");
    return text;
}

// A raygen program around some instructions; the first of them is in line kBodyLine.
constexpr int kBodyLine = 6;
std::string raygenOf(const std::string& instructions) {
    return ptxModule(".visible .entry __raygen__a() {\n"
                     ".reg .b32 %r<40>; .reg .b64 %rd<9>; .reg .f32 %f<20>; .reg .pred %p<4>;\n" +
                     instructions + "\nret;\n}\n");
}

class Module : public ApiTest {
protected:
    OptixResult create(std::string_view text) {
        module_ = reinterpret_cast<OptixModule>(1);
        return optixModuleCreateFromPTX(context_, &moduleOptions_, &options_, text.data(),
                                        text.size(), nullptr, nullptr, &module_);
    }
    void expectGood(std::string_view text) {
        log_.clear();
        ASSERT_OK(create(text)) << text;
        ASSERT_NE(nullptr, module_);
        EXPECT_OK(optixModuleDestroy(module_));
    }
    // Checks that the call is refused with a log line that contains `mention`, and returns no
    // handle.
    void expectRefused(OptixResult result, const char* mention, std::string_view text) {
        EXPECT_REJECTED(result, kFunction, mention, create(text));
        EXPECT_EQ(nullptr, module_);
    }

    OptixModuleCompileOptions moduleOptions_{};
    OptixPipelineCompileOptions options_ = compileOptions();
    OptixModule module_ = nullptr;
};

TEST_F(Module, GoodText) {
    expectGood(goodPtx());
}

TEST_F(Module, TextEndsAtSizeOrAtTheFirstNul) {
    // Without a terminating NUL, in a buffer of exactly this size.
    std::vector<char> exact(goodPtx().begin(), goodPtx().end());
    expectGood({exact.data(), exact.size()});
    // With the NUL counted, with rubbish after the NUL, and with a size beyond the NUL.
    expectGood({goodPtx().c_str(), goodPtx().size() + 1});
    std::string rubbish = goodPtx() + '\0' + "rubbish \xff after the end";
    expectGood(rubbish);
    std::string cut = goodPtx() + "rubbish";
    expectGood({cut.data(), goodPtx().size()});
}

TEST_F(Module, LaterPtxVersionsAndTargets) {
    for (const char* header :
         {".version 9.0\n.target sm_75\n.address_size 64\n",
          ".version 9.0\n.target sm_90a\n.address_size 64\n",
          ".version 6.0\n.target sm_50\n.address_size 64\n",
          ".version 7.4\n.target sm_86, debug\n.address_size 64\n"})
        expectGood(std::string(header) + ".visible .entry __raygen__a() { ret; }\n");
}

TEST_F(Module, WithoutPrograms) {
    expectGood(ptxModule(".visible .global .align 4 .u32 counter;\n"));
}

TEST_F(Module, NullArguments) {
    OptixModule module = nullptr;
    const char* text = goodPtx().data();
    size_t size = goodPtx().size();
    auto call = [&](const OptixModuleCompileOptions* moduleOptions,
                    const OptixPipelineCompileOptions* options, const char* ptx, OptixModule* out) {
        return optixModuleCreateFromPTX(context_, moduleOptions, options, ptx, size, nullptr,
                                        nullptr, out);
    };
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, "moduleCompileOptions",
                    call(nullptr, &options_, text, &module));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, "pipelineCompileOptions",
                    call(&moduleOptions_, nullptr, text, &module));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, "PTX",
                    call(&moduleOptions_, &options_, nullptr, &module));
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, kFunction, "module",
                    call(&moduleOptions_, &options_, text, nullptr));
}

// ---- Input that is not valid PTX ----------------------------------------------------------------

TEST_F(Module, EmptyText) {
    expectRefused(OPTIX_ERROR_INVALID_PTX, "", "");
    expectRefused(OPTIX_ERROR_INVALID_PTX, "", std::string_view("\0abc", 4));
    expectRefused(OPTIX_ERROR_INVALID_PTX, "", "   \n\t\n");
    expectRefused(OPTIX_ERROR_INVALID_PTX, "", "// only a comment\n");
}

TEST_F(Module, BinaryInput) {
    using namespace std::string_view_literals;
    for (std::string_view input :
         {"\x7f"
          "ELF\x02\x01\x01\x33\0\0\0\0\0"sv,
          "BC\xC0\xDE\x35\x14\0\0"sv, "\xED\x43\x4E\x7F\x01\0\0\0"sv, "\x50\xED\x55\xBA\x01\0"sv,
          "\xff\xfe.\0v\0"sv, "\x1f\x8b\x08\0\0"sv, "\x80\x81\x82\x83\x84"sv, "{}()<>%$@!"sv})
        expectRefused(OPTIX_ERROR_INVALID_PTX, "", input);
    std::string noise(4096, 0);
    uint32_t state = 1;
    for (char& byte : noise)
        byte = char((state = state * 1664525u + 1013904223u) >> 24 | 1);
    expectRefused(OPTIX_ERROR_INVALID_PTX, "", noise);
}

TEST_F(Module, WrongHeader) {
    const char* program = ".visible .entry __raygen__a() { ret; }\n";
    for (const char* header :
         {"", ".target sm_60\n.address_size 64\n", ".version 6.5\n",
          ".version six\n.target sm_60\n.address_size 64\n",
          ".version 6.5\n.target gfx90a\n.address_size 64\n",
          ".version 6.5\n.target sm_60\n.address_size 32\n",
          ".version 6.5\n.version 6.5\n.target sm_60\n.address_size 64\n",
          ".version 6.5\n.target sm_60, sm_70\n.address_size 64\n"})
        expectRefused(OPTIX_ERROR_INVALID_PTX, "", std::string(header) + program);
}

TEST_F(Module, TruncatedAnywhere) {
    // Every prefix that ends inside a program is an error; no prefix may cause a crash or a hang.
    const std::string& text = goodPtx();
    size_t lastProgram = text.rfind("ret;");
    for (size_t size = 1; size < lastProgram; ++size) {
        std::vector<char> exact(text.begin(), text.begin() + ptrdiff_t(size));
        OptixResult result = create({exact.data(), exact.size()});
        if (result == OPTIX_SUCCESS)
            optixModuleDestroy(module_);
        else
            EXPECT_EQ(OPTIX_ERROR_INVALID_PTX, result) << "cut after " << size;
        size_t open = 0;
        for (size_t i = 0; i < size; ++i)
            open += text[i] == '{' ? 1 : text[i] == '}' ? -1 : 0;
        if (open != 0)
            EXPECT_EQ(OPTIX_ERROR_INVALID_PTX, result) << "cut after " << size;
    }
}

TEST_F(Module, OneByteChanged) {
    const std::string& text = goodPtx();
    for (size_t i = 0; i < text.size(); i += 3)
        for (char byte : {'\0', '}', ';', '\xff'}) {
            std::string changed = text;
            changed[i] = byte;
            if (create(changed) == OPTIX_SUCCESS)
                optixModuleDestroy(module_);
            else
                EXPECT_EQ(nullptr, module_);
        }
}

TEST_F(Module, FaultsNameTheirLine) {
    struct {
        const char* instructions;
        const char* mention;
    } const faults[] = {
        {"frobnicate.u32 %r1, %r2;", "frobnicate"},
        {"add.u33 %r1, %r2, %r3;", ""},
        {"add.s32 %r1, %r2;", ""},
        {"add.s32 %r1, %r2, %undeclared;", "undeclared"},
        {"add.f32 %r1, %r2, %p1;", ""},
        {"mov.u32 %r1, %rd1;", ""},
        {"ld.global.u32 %r1, [nowhere];", "nowhere"},
        {"bra nowhere;", "nowhere"},
        {"add.s32 %r1 %r2 %r3;", ""},
        {"call (%r1), not_declared, ();", "not_declared"},
        {"call (%r1), _optix_get_launch_indx_x, ();", "_optix_get_launch_indx_x"},
        {"call (%r1), _optix_get_launch_index_x, (%r2);", "_optix_get_launch_index_x"},
        {"call (%rd1), _optix_get_launch_index_x, ();", ""},
        {"call _optix_get_launch_index_x, ();", ""},
    };
    std::string where = "line " + std::to_string(kBodyLine);
    for (const auto& fault : faults) {
        std::string text = raygenOf(fault.instructions);
        expectRefused(OPTIX_ERROR_INVALID_PTX, fault.mention, text);
        EXPECT_TRUE(log_.hasError(kFunction, where)) << fault.instructions << "\n" << log_.all();
    }
}

TEST_F(Module, UnclosedProgram) {
    expectRefused(OPTIX_ERROR_INVALID_PTX, "",
                  ptxModule(".visible .entry __raygen__a() {\n.reg .b32 %r<3>;\nret;\n"));
}

TEST_F(Module, DuplicateDefinitions) {
    expectRefused(OPTIX_ERROR_INVALID_PTX, "__raygen__a",
                  ptxModule(".visible .entry __raygen__a() { ret; }\n"
                            ".visible .entry __raygen__a() { ret; }\n"));
}

// ---- Misuse of device functions -----------------------------------------------------------------

std::string programOf(const char* name, const char* instructions) {
    return ptxModule(std::string(".visible .entry ") + name +
                     "() {\n.reg .b32 %r<40>; .reg .b64 %rd<9>; .reg .f32 %f<20>;\n" +
                     instructions + "\nret;\n}\n");
}

TEST_F(Module, FunctionsInIllegalProgramKinds) {
    struct {
        const char* program;
        const char* call;
        const char* name;
    } const cases[] = {
        {"__raygen__a", "call _optix_ignore_intersection, ();", "_optix_ignore_intersection"},
        {"__raygen__a", "call _optix_terminate_ray, ();", "_optix_terminate_ray"},
        {"__closesthit__a", "call _optix_ignore_intersection, ();", "_optix_ignore_intersection"},
        {"__miss__a", "call (%r1), _optix_read_primitive_idx, ();", "_optix_read_primitive_idx"},
        {"__raygen__a", "call (%r1), _optix_get_attribute_0, ();", "_optix_get_attribute_0"},
        {"__miss__a", "call (%r1), _optix_get_hit_kind, ();", "_optix_get_hit_kind"},
        {"__closesthit__a", "call (%f1), _optix_get_object_ray_origin_x, ();",
         "_optix_get_object_ray_origin_x"},
        {"__raygen__a", "call (%f1), _optix_get_ray_tmin, ();", "_optix_get_ray_tmin"},
        {"__anyhit__a", "call (%r1), _optix_report_intersection_0, (%f1, %r2);",
         "_optix_report_intersection_0"},
        {"__raygen__a", "mov.u32 %r2, 0;\ncall (%r1), _optix_get_payload, (%r2);",
         "_optix_get_payload"},
        {"__raygen__a", "call (%r1), _optix_get_exception_code, ();", "_optix_get_exception_code"},
    };
    options_.numPayloadValues = 4;
    for (const auto& c : cases)
        expectRefused(OPTIX_ERROR_INVALID_FUNCTION_USE, c.name, programOf(c.program, c.call));
}

TEST_F(Module, PayloadBeyondTheCount) {
    const char* read = "mov.u32 %r2, 2;\ncall (%r1), _optix_get_payload, (%r2);";
    const char* write = "mov.u32 %r2, 2;\ncall _optix_set_payload, (%r2, %r1);";
    for (const char* instructions : {read, write}) {
        options_.numPayloadValues = 2;
        expectRefused(OPTIX_ERROR_INVALID_PAYLOAD_ACCESS, "payload",
                      programOf("__miss__a", instructions));
        options_.numPayloadValues = 3;
        expectGood(programOf("__miss__a", instructions));
    }
}

TEST_F(Module, AttributeBeyondTheCount) {
    const char* read = "call (%r1), _optix_get_attribute_3, ();";
    options_.numAttributeValues = 3;
    expectRefused(OPTIX_ERROR_INVALID_ATTRIBUTE_ACCESS, "attribute",
                  programOf("__closesthit__a", read));
    options_.numAttributeValues = 4;
    expectGood(programOf("__closesthit__a", read));
    const char* report =
        "call (%r1), _optix_report_intersection_3, (%f1, %r2, %r3, %r4, %r5);";
    options_.numAttributeValues = 2;
    expectRefused(OPTIX_ERROR_INVALID_ATTRIBUTE_ACCESS, "attribute",
                  programOf("__intersection__a", report));
    options_.numAttributeValues = 3;
    expectGood(programOf("__intersection__a", report));
}

TEST_F(Module, AtLeastTwoAttributesAlways) {
    options_.numAttributeValues = 0;
    expectGood(programOf("__closesthit__a", "call (%r1), _optix_get_attribute_1, ();"));
}

// Only compilation may show that an operand is not constant, so either the module or the pipeline
// is refused.
TEST_F(Module, PayloadSlotMustBeConstant) {
    options_.numPayloadValues = 32;
    std::string text = programOf("__miss__a", "call (%r2), _optix_get_launch_index_x, ();\n"
                                              "call _optix_set_payload, (%r2, %r1);");
    log_.clear();
    OptixResult result = create(text);
    if (result == OPTIX_SUCCESS) {
        OptixProgramGroupDesc desc{};
        desc.kind = OPTIX_PROGRAM_GROUP_KIND_MISS;
        desc.miss = {module_, "__miss__a"};
        OptixProgramGroupOptions groupOptions{};
        OptixProgramGroup group = nullptr;
        ASSERT_OK(optixProgramGroupCreate(context_, &desc, 1, &groupOptions, nullptr, nullptr,
                                          &group));
        OptixPipelineLinkOptions link{1, OPTIX_COMPILE_DEBUG_LEVEL_DEFAULT};
        OptixPipeline pipeline = nullptr;
        result = optixPipelineCreate(context_, &options_, &link, &group, 1, nullptr, nullptr,
                                     &pipeline);
    }
    EXPECT_EQ(OPTIX_ERROR_INVALID_FUNCTION_ARGUMENTS, result) << log_.all();
    EXPECT_TRUE(log_.hasError("optix", "_optix_set_payload")) << log_.all();
}

// ---- Options -------------------------------------------------------------------------------------

TEST_F(Module, OptLevels) {
    for (unsigned level : {0u, 0x2340u, 0x2341u, 0x2342u, 0x2343u}) {
        moduleOptions_.optLevel = OptixCompileOptimizationLevel(level);
        expectGood(goodPtx());
    }
    for (unsigned level : {1u, 3u, 0x233Fu, 0x2344u, 0x2350u, 0xFFFFFFFFu}) {
        std::memcpy(&moduleOptions_.optLevel, &level, sizeof(level));
        expectRefused(OPTIX_ERROR_INVALID_VALUE, "optLevel", goodPtx());
    }
}

TEST_F(Module, DebugLevels) {
    for (unsigned level : {0u, 0x2350u, 0x2351u, 0x2352u, 0x2353u}) {
        moduleOptions_.debugLevel = OptixCompileDebugLevel(level);
        expectGood(goodPtx());
    }
    for (unsigned level : {1u, 2u, 0x234Fu, 0x2354u, 0xFFFFFFFFu}) {
        std::memcpy(&moduleOptions_.debugLevel, &level, sizeof(level));
        expectRefused(OPTIX_ERROR_INVALID_VALUE, "debugLevel", goodPtx());
    }
}

// Functions of later releases are refused here, as a pipeline would.
TEST_F(Module, FunctionsThatAreNotAvailable) {
    for (const char* name :
         {"_optix_get_cluster_id", "_optix_hitobject_traverse", "_optix_reorder"}) {
        const std::string mention = std::string("line 6: \"") + name + "\" is not available";
        expectRefused(OPTIX_ERROR_NOT_SUPPORTED, mention.c_str(),
                      raygenOf(std::string("call (%r1), ") + name + ", ();"));
    }
    // It is harmless in a function that no program calls.
    expectGood(goodPtx() + ".func unused() { .reg .b32 %r<2>;\n"
                           "call (%r1), _optix_get_cluster_id, (); ret; }\n");
}

TEST_F(Module, RegisterCount) {
    for (int count : {0, 1, 64, 0x7FFFFFFF}) {
        moduleOptions_.maxRegisterCount = count;
        expectGood(goodPtx());
    }
}

TEST_F(Module, PayloadAndAttributeCounts) {
    for (int count : {0, 1, 31, 32}) {
        options_.numPayloadValues = count;
        expectGood(goodPtx());
    }
    for (int count : {-1, 33, 0x7FFFFFFF}) {
        options_.numPayloadValues = count;
        expectRefused(OPTIX_ERROR_INVALID_VALUE, "numPayloadValues", goodPtx());
    }
    options_.numPayloadValues = 0;
    for (int count : {0, 1, 2, 8}) {
        options_.numAttributeValues = count;
        expectGood(goodPtx());
    }
    for (int count : {-1, 9, 0x7FFFFFFF}) {
        options_.numAttributeValues = count;
        expectRefused(OPTIX_ERROR_INVALID_VALUE, "numAttributeValues", goodPtx());
    }
}

TEST_F(Module, FlagWords) {
    for (unsigned flags : {0u, 1u, 2u, 3u}) {
        options_.traversableGraphFlags = flags;
        expectGood(goodPtx());
    }
    for (unsigned flags : {4u, 5u, 0x80000000u, ~0u}) {
        options_.traversableGraphFlags = flags;
        expectRefused(OPTIX_ERROR_INVALID_VALUE, "traversableGraphFlags", goodPtx());
    }
    options_.traversableGraphFlags = 0;
    for (unsigned flags : {0u, 1u, 15u}) {
        options_.exceptionFlags = flags;
        expectGood(goodPtx());
    }
    for (unsigned flags : {16u, ~0u}) {
        options_.exceptionFlags = flags;
        expectRefused(OPTIX_ERROR_INVALID_VALUE, "exceptionFlags", goodPtx());
    }
    options_.exceptionFlags = 0;
    for (unsigned flags : {0u, 1u, 0x80000000u, 0x80000001u}) {
        options_.usesPrimitiveTypeFlags = flags;
        expectGood(goodPtx());
    }
    for (unsigned flags : {32u, 0x40000000u, ~0u}) {
        options_.usesPrimitiveTypeFlags = flags;
        expectRefused(OPTIX_ERROR_INVALID_VALUE, "usesPrimitiveTypeFlags", goodPtx());
    }
}

TEST_F(Module, LaunchParameterNames) {
    for (const char* name : {static_cast<const char*>(nullptr), "", "params", "no_such_variable"}) {
        options_.pipelineLaunchParamsVariableName = name;
        expectGood(goodPtx());
    }
}

TEST_F(Module, LaunchParametersMustBeConstant) {
    expectRefused(OPTIX_ERROR_INVALID_LAUNCH_PARAMETER, "params",
                  ptxModule(".global .align 8 .b8 params[16];\n"
                            ".visible .entry __raygen__a() { .reg .b64 %rd<2>; "
                            "ld.global.u64 %rd1, [params]; ret; }\n"));
}

TEST_F(Module, LaunchParametersWithoutASize) {
    expectRefused(OPTIX_ERROR_INVALID_LAUNCH_PARAMETER, "has no size",
                  ptxModule(".extern .const .align 8 .b8 params[];\n"
                            ".visible .entry __raygen__a() { ret; }\n"));
}

TEST_F(Module, BoundValues) {
    uint32_t value = 7;
    OptixModuleCompileBoundValueEntry entries[2] = {};
    moduleOptions_.boundValues = entries;
    auto set = [&](int i, size_t offset, size_t size) {
        entries[i].pipelineParamOffsetInBytes = offset;
        entries[i].sizeInBytes = size;
        entries[i].boundValuePtr = &value;
        entries[i].annotation = i ? nullptr : "first";
    };
    moduleOptions_.numBoundValues = 2;
    set(0, 4, 4);
    set(1, 0, 4);
    expectGood(goodPtx());
    set(1, 12, 4);
    expectGood(goodPtx());
    struct {
        size_t offset, size;
    } const wrong[] = {{4, 4}, {6, 4}, {2, 4}, {14, 4}, {16, 4}, {0, 0}, {~size_t(0), 4},
                       {0, ~size_t(0)}, {~size_t(0) - 3, 4}};
    for (const auto& w : wrong) {
        set(1, w.offset, w.size);
        expectRefused(OPTIX_ERROR_INVALID_VALUE, "ound", goodPtx());
    }
    set(1, 0, 4);
    entries[1].boundValuePtr = nullptr;
    expectRefused(OPTIX_ERROR_INVALID_VALUE, "boundValues[1]", goodPtx());
    moduleOptions_.boundValues = nullptr;
    expectRefused(OPTIX_ERROR_INVALID_VALUE, "boundValues", goodPtx());
}

// ---- The log string ------------------------------------------------------------------------------

struct LogString {
    std::vector<char> text;
    size_t size;
};

class ModuleLog : public Module {
protected:
    // Calls with a buffer of this capacity, followed by guard bytes.
    LogString call(std::string_view ptx, size_t capacity, OptixResult expected) {
        LogString out{std::vector<char>(capacity + 8, '#'), capacity};
        EXPECT_EQ(expected, optixModuleCreateFromPTX(context_, &moduleOptions_, &options_,
                                                     ptx.data(), ptx.size(), out.text.data(),
                                                     &out.size, &module_));
        if (expected == OPTIX_SUCCESS)
            EXPECT_OK(optixModuleDestroy(module_));
        for (size_t i = capacity; i < out.text.size(); ++i)
            EXPECT_EQ('#', out.text[i]) << "written beyond the capacity " << capacity;
        return out;
    }
};

TEST_F(ModuleLog, TruncatesAndTerminates) {
    std::string faulty = raygenOf("frobnicate.u32 %r1, %r2;");
    LogString whole = call(faulty, 4096, OPTIX_ERROR_INVALID_PTX);
    std::string text = whole.text.data();
    EXPECT_NE(std::string::npos, text.find("frobnicate")) << text;
    ASSERT_EQ(text.size() + 1, whole.size);
    EXPECT_TRUE(log_.hasError(kFunction, "frobnicate")) << "the context's log gets it too";

    LogString exact = call(faulty, text.size() + 1, OPTIX_ERROR_INVALID_PTX);
    EXPECT_EQ(text, exact.text.data());
    EXPECT_EQ(text.size() + 1, exact.size);
    for (size_t capacity : {text.size(), size_t(10), size_t(2), size_t(1)}) {
        LogString cut = call(faulty, capacity, OPTIX_ERROR_INVALID_PTX);
        EXPECT_EQ(text.substr(0, capacity - 1), cut.text.data()) << capacity;
        EXPECT_EQ(text.size() + 1, cut.size) << "the full length, whatever the capacity";
    }
    LogString none = call(faulty, 0, OPTIX_ERROR_INVALID_PTX);
    EXPECT_EQ('#', none.text[0]);
    EXPECT_EQ(text.size() + 1, none.size);
}

TEST_F(ModuleLog, EitherPointerMayBeNull) {
    std::string faulty = raygenOf("frobnicate.u32 %r1, %r2;");
    char text[16] = "untouched";
    EXPECT_EQ(OPTIX_ERROR_INVALID_PTX,
              optixModuleCreateFromPTX(context_, &moduleOptions_, &options_, faulty.data(),
                                       faulty.size(), text, nullptr, &module_));
    EXPECT_STREQ("untouched", text);
    size_t size = 1000;
    EXPECT_EQ(OPTIX_ERROR_INVALID_PTX,
              optixModuleCreateFromPTX(context_, &moduleOptions_, &options_, faulty.data(),
                                       faulty.size(), nullptr, &size, &module_));
    EXPECT_GT(size, 1u);
    EXPECT_NE(1000u, size);
}

TEST_F(ModuleLog, SuccessLeavesATerminatedString) {
    LogString out = call(goodPtx(), 256, OPTIX_SUCCESS);
    EXPECT_EQ(std::strlen(out.text.data()) + 1, out.size);
}

TEST_F(ModuleLog, OnlyThisCallsFeedback) {
    call(raygenOf("frobnicate.u32 %r1, %r2;"), 4096, OPTIX_ERROR_INVALID_PTX);
    LogString second = call(raygenOf("mumble.u32 %r1, %r2;"), 4096, OPTIX_ERROR_INVALID_PTX);
    EXPECT_EQ(nullptr, std::strstr(second.text.data(), "frobnicate")) << second.text.data();
}

TEST_F(ModuleLog, AlsoForBadArguments) {
    moduleOptions_.numPayloadTypes = 99;
    LogString out = call(goodPtx(), 256, OPTIX_ERROR_INVALID_VALUE);
    EXPECT_NE(nullptr, std::strstr(out.text.data(), "numPayloadTypes")) << out.text.data();
}

TEST_F(Module, ManyModules) {
    std::vector<OptixModule> modules;
    for (int i = 0; i < 200; ++i) {
        ASSERT_OK(create(goodPtx()));
        modules.push_back(module_);
    }
    for (size_t i = 0; i < modules.size(); i += 2)
        EXPECT_OK(optixModuleDestroy(modules[i]));
    // The context destroys the rest.
}

} // namespace
} // namespace tests::api
