// SPDX-License-Identifier: Apache-2.0
// Payload types: two types in one pipeline, groups that name or deduce theirs, equal types of other
// modules, mismatches at run time, and every mistake that the manual forbids.
#include "device/payload_types.h"
#include "rig.h"
#include "scene.h"

namespace tests::api {
namespace {

constexpr OptixPayloadSemantics kCallerRead = OPTIX_PAYLOAD_SEMANTICS_TRACE_CALLER_READ;
constexpr unsigned kCallerWrite = OPTIX_PAYLOAD_SEMANTICS_TRACE_CALLER_WRITE;
constexpr unsigned kCaller = OPTIX_PAYLOAD_SEMANTICS_TRACE_CALLER_READ_WRITE;
constexpr unsigned kHitRead = OPTIX_PAYLOAD_SEMANTICS_CH_READ;
constexpr unsigned kHitWrite = OPTIX_PAYLOAD_SEMANTICS_CH_WRITE;
constexpr unsigned kMissWrite = OPTIX_PAYLOAD_SEMANTICS_MS_WRITE;
constexpr unsigned kAnyHitRead = OPTIX_PAYLOAD_SEMANTICS_AH_READ;
constexpr unsigned kAnyHitWrite = OPTIX_PAYLOAD_SEMANTICS_AH_WRITE;
constexpr unsigned kFirstWord = kCaller | kHitRead | kMissWrite | kAnyHitRead | kAnyHitWrite;

// Types, with the arrays they point to.
struct Types {
    std::vector<std::vector<unsigned>> words;
    std::vector<OptixPayloadType> list;
    explicit Types(std::vector<std::vector<unsigned>> all) : words(std::move(all)) {
        for (const auto& type : words)
            list.push_back({unsigned(type.size()), type.data()});
    }
};

class PayloadTypes : public DeviceTest {
protected:
    OptixResult create(const std::string& ptx, Types& types, OptixModule& module,
                       int numPayloadValues = 0) {
        OptixModuleCompileOptions options{};
        options.debugLevel = debugLevel_;
        options.numPayloadTypes = unsigned(types.list.size());
        options.payloadTypes = types.list.data();
        OptixPipelineCompileOptions pipeline = compileOptions(numPayloadValues);
        pipeline.exceptionFlags = flags_;
        return optixModuleCreateFromPTX(context_, &options, &pipeline, ptx.data(), ptx.size(),
                                        nullptr, nullptr, &module);
    }
    OptixResult group(const OptixProgramGroupDesc& desc, const OptixPayloadType* type,
                      OptixProgramGroup& out) {
        OptixProgramGroupOptions options{};
        options.payloadType = const_cast<OptixPayloadType*>(type);
        const OptixResult result =
            optixProgramGroupCreate(context_, &desc, 1, &options, nullptr, nullptr, &out);
        if (result == OPTIX_SUCCESS)
            groups_.push_back(out);
        return result;
    }
    static OptixProgramGroupDesc single(OptixProgramGroupKind kind, OptixModule module,
                                        const char* name) {
        OptixProgramGroupDesc desc{};
        desc.kind = kind;
        desc.raygen = {module, name}; // the three kinds share a form
        return desc;
    }
    static OptixProgramGroupDesc hit(OptixModule module, const char* closestHit,
                                     OptixModule anyHitModule, const char* anyHit) {
        OptixProgramGroupDesc desc{};
        desc.kind = OPTIX_PROGRAM_GROUP_KIND_HITGROUP;
        desc.hitgroup.moduleCH = module;
        desc.hitgroup.entryFunctionNameCH = closestHit;
        desc.hitgroup.moduleAH = anyHitModule;
        desc.hitgroup.entryFunctionNameAH = anyHit;
        return desc;
    }
    void runTwoTypes(const std::string& ptx);
    void TearDown() override {
        for (OptixProgramGroup each : groups_)
            optixProgramGroupDestroy(each);
        DeviceTest::TearDown();
    }

    unsigned flags_ = OPTIX_EXCEPTION_FLAG_NONE;
    OptixCompileDebugLevel debugLevel_ = OPTIX_COMPILE_DEBUG_LEVEL_DEFAULT;
    std::vector<OptixProgramGroup> groups_;
    // As payload_types.cu uses them, and the same in another order.
    Types types_{{{kFirstWord, kCallerRead | kHitWrite},
                  {kFirstWord, kCaller, kCallerWrite | kHitRead, kCallerRead | kHitWrite}}};
    Types swapped_{{types_.words[1], types_.words[0]}};
};

void PayloadTypes::runTwoTypes(const std::string& ptx) {
    flags_ = OPTIX_EXCEPTION_FLAG_DEBUG;
    OptixModule module = nullptr;
    ASSERT_OK(create(ptx, types_, module));
    OptixProgramGroup raygen, miss[2], hits[2], exception, refused = nullptr;
    ASSERT_OK(
        group(single(OPTIX_PROGRAM_GROUP_KIND_RAYGEN, module, "__raygen__typed"), nullptr, raygen));
    ASSERT_OK(group(single(OPTIX_PROGRAM_GROUP_KIND_EXCEPTION, module, "__exception__typed"),
                    nullptr, exception));
    // A miss program for all types does not serve a single one.
    const auto missDesc = single(OPTIX_PROGRAM_GROUP_KIND_MISS, module, "__miss__all");
    EXPECT_REJECTED(OPTIX_ERROR_PAYLOAD_TYPE_RESOLUTION_FAILED, "optixProgramGroupCreate",
                    "2 payload types", group(missDesc, nullptr, refused));
    EXPECT_EQ(nullptr, refused);
    for (int i = 0; i < 2; ++i)
        ASSERT_OK(group(missDesc, &types_.list[i], miss[i]));
    // Deduced: the one type that both programs have.
    ASSERT_OK(
        group(hit(module, "__closesthit__first", module, "__anyhit__both"), nullptr, hits[0]));
    ASSERT_OK(
        group(hit(module, "__closesthit__second", module, "__anyhit__both"), nullptr, hits[1]));
    EXPECT_REJECTED(
        OPTIX_ERROR_PAYLOAD_TYPE_MISMATCH, "optixProgramGroupCreate", "__closesthit__first",
        group(hit(module, "__closesthit__first", nullptr, nullptr), &types_.list[1], refused));
    Types foreign({{kCaller}});
    EXPECT_REJECTED(
        OPTIX_ERROR_PAYLOAD_TYPE_MISMATCH, "optixProgramGroupCreate", "__anyhit__both",
        group(hit(nullptr, nullptr, module, "__anyhit__both"), &foreign.list[0], refused));

    OptixPipelineCompileOptions options = compileOptions(0);
    options.exceptionFlags = flags_;
    OptixPipelineLinkOptions link{};
    link.maxTraceDepth = 1;
    link.debugLevel = debugLevel_;
    OptixPipeline pipeline = nullptr;
    ASSERT_OK(optixPipelineCreate(context_, &options, &link, groups_.data(),
                                  unsigned(groups_.size()), nullptr, nullptr, &pipeline));
    Buffer records(8 * OPTIX_SBT_RECORD_HEADER_SIZE);
    const OptixProgramGroup order[] = {raygen, exception, miss[0], miss[1], hits[0], hits[1]};
    for (size_t i = 0; i < std::size(order); ++i)
        ASSERT_OK(optixSbtRecordPackHeader(order[i],
                                           records.as<char>() + i * OPTIX_SBT_RECORD_HEADER_SIZE));
    const auto recordAt = [&](unsigned i) {
        return records.address() + i * OPTIX_SBT_RECORD_HEADER_SIZE;
    };
    OptixShaderBindingTable sbt{};
    sbt.raygenRecord = recordAt(0);
    sbt.exceptionRecord = recordAt(1);
    sbt.missRecordBase = recordAt(2);
    sbt.missRecordStrideInBytes = OPTIX_SBT_RECORD_HEADER_SIZE;
    sbt.missRecordCount = 2;
    sbt.hitgroupRecordBase = recordAt(4);
    sbt.hitgroupRecordStrideInBytes = OPTIX_SBT_RECORD_HEADER_SIZE;
    sbt.hitgroupRecordCount = 2;
    TriangleMesh mesh({{-50, -50, 1}, {50, -50, 1}, {0, 80, 1}}, {0, 1, 2});
    log_.clear();
    Accel accel = buildAccel(context_, log_, {mesh.input});
    constexpr unsigned kIndices = 64;
    Buffer results(kIndices * sizeof(TypedResult)), params(sizeof(TypedParams));
    auto* result = results.as<TypedResult>();
    for (unsigned shift : {0u, 1u}) { // 1: each type gets the other's hit group
        *params.as<TypedParams>() = {result, accel.handle, {shift, 1 - shift}};
        ASSERT_OK(optixLaunch(pipeline, nullptr, params.address(), sizeof(TypedParams), &sbt,
                              kIndices, 1, 1));
        waitForDevice();
        for (unsigned i = 0; i < kIndices; ++i) {
            SCOPED_TRACE(i);
            const TypedResult& r = result[i];
            if (i & 2) { // misses
                ASSERT_EQ(7u, r.words[0]);
                ASSERT_EQ(1000, r.code);
            } else if (shift) {
                ASSERT_EQ(OPTIX_EXCEPTION_CODE_PAYLOAD_TYPE_MISMATCH, r.code);
            } else if (i & 1) {
                ASSERT_EQ(15 + i, r.words[0]);
                ASSERT_EQ(20 + i, r.words[1]) << "words nobody writes pass through";
                ASSERT_EQ(15 + i + 30 + i + 2000, r.words[3]);
            } else {
                ASSERT_EQ(15 + i, r.words[0]);
                ASSERT_EQ(1015 + i, r.words[1]);
            }
        }
    }
    optixPipelineDestroy(pipeline);
    optixModuleDestroy(module);
}

TEST_P(PayloadTypes, TwoTypesInOnePipeline) {
    runTwoTypes(program("payload_types"));
}

// nvcc -G, and the least optimisation at which clang passes types of traces as constants.
TEST_P(PayloadTypes, CodeForDebuggers) {
    debugLevel_ = OPTIX_COMPILE_DEBUG_LEVEL_FULL;
    runTwoTypes(program("payload_types_G"));
}

// Types with equal words are equal, also with different numbers in their modules.
TEST_P(PayloadTypes, TypesOfTwoModules) {
    const std::string ptx = program("payload_types");
    OptixModule module = nullptr, other = nullptr;
    ASSERT_OK(create(ptx, types_, module));
    // One word less in each type: programs of the first module do not fit.
    const std::string hitPtx = ptxModule(".visible .entry __anyhit__other() { ret; }");
    ASSERT_OK(create(hitPtx, swapped_, other));
    OptixProgramGroup made = nullptr;
    EXPECT_OK(group(hit(module, "__closesthit__first", other, "__anyhit__other"), nullptr, made));
    EXPECT_OK(group(hit(module, "__closesthit__second", other, "__anyhit__other"), &types_.list[1],
                    made));
    optixModuleDestroy(other);
    Types longer({{kFirstWord, kCallerRead | kHitWrite, kCaller}});
    ASSERT_OK(create(hitPtx, longer, other));
    EXPECT_REJECTED(
        OPTIX_ERROR_PAYLOAD_TYPE_RESOLUTION_FAILED, "optixProgramGroupCreate", "0 payload types",
        group(hit(module, "__closesthit__first", other, "__anyhit__other"), nullptr, made));
    optixModuleDestroy(other);
    optixModuleDestroy(module);
}

TEST_P(PayloadTypes, BadOptions) {
    const std::string ptx = ptxModule(".visible .entry __miss__m() { ret; }");
    OptixModule module = nullptr;
    const auto refused = [&](const char* mention, Types types, int values = 0) {
        EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixModuleCreateFromPTX", mention,
                        create(ptx, types, module, values));
        EXPECT_EQ(nullptr, module);
    };
    refused("numPayloadValues = 1", types_, 1);
    refused("nobody may write", Types({{kCallerRead}}));
    refused("nobody may read", Types({{kCaller}, {kCallerWrite | kHitWrite}}));
    refused("payloadSemantics[1] = 0", Types({{kCaller, 0}}));
    refused("unknown bits", Types({{kCaller | 1024}}));
    refused("is above 32", Types({std::vector<unsigned>(33, kCaller)}));
    refused("numPayloadTypes = 9", Types(std::vector<std::vector<unsigned>>(9, {kCaller})));
    Types null({{kCaller}});
    null.list[0].payloadSemantics = nullptr;
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixModuleCreateFromPTX",
                    "payloadSemantics is null", create(ptx, null, module));
    OptixModuleCompileOptions options{};
    options.numPayloadTypes = 1;
    OptixPipelineCompileOptions pipeline = compileOptions();
    EXPECT_REJECTED(OPTIX_ERROR_INVALID_VALUE, "optixModuleCreateFromPTX", "payloadTypes is null",
                    optixModuleCreateFromPTX(context_, &options, &pipeline, ptx.data(), ptx.size(),
                                             nullptr, nullptr, &module));
    // The limits themselves are legal.
    Types most(std::vector<std::vector<unsigned>>(
        OPTIX_COMPILE_DEFAULT_MAX_PAYLOAD_TYPE_COUNT,
        std::vector<unsigned>(OPTIX_COMPILE_DEFAULT_MAX_PAYLOAD_VALUE_COUNT, kCaller)));
    ASSERT_OK(create(ptx, most, module));
    optixModuleDestroy(module);
}

TEST_P(PayloadTypes, BadPrograms) {
    const auto refused = [&](OptixResult code, const char* mention, const std::string& body,
                             Types types) {
        OptixModule module = nullptr;
        SCOPED_TRACE(body);
        EXPECT_REJECTED(code, "optixModuleCreateFromPTX", mention,
                        create(ptxModule(body), types, module));
        EXPECT_EQ(nullptr, module);
    };
    const auto entry = [](const std::string& name, const std::string& code) {
        return ".visible .entry " + name + "() {\n .reg .b32 %r<9>; .reg .pred %p;\n" + code +
               "\n ret; }\n";
    };
    const std::string set1 = "mov.u32 %r1, 1; call _optix_set_payload, (%r1, %r2);";
    const std::string get0 = "mov.u32 %r1, 0; call (%r2), _optix_get_payload, (%r1);";
    const auto types = [](unsigned mask) {
        return "call _optix_set_payload_types, (" + std::to_string(mask) + ");\n";
    };
    // Words that a type lacks, and accesses that its semantics forbid; with the line.
    refused(OPTIX_ERROR_INVALID_PAYLOAD_ACCESS, "payload slot 1 of 1", entry("__miss__m", set1),
            Types({{kCaller}}));
    refused(OPTIX_ERROR_INVALID_PAYLOAD_ACCESS, "line 6", entry("__miss__m", set1),
            Types({{kCaller}}));
    refused(OPTIX_ERROR_INVALID_PAYLOAD_ACCESS, "__closesthit__ program write payload slot 1",
            entry("__closesthit__c", set1), Types({{kCaller, kCaller | kHitRead}}));
    refused(OPTIX_ERROR_INVALID_PAYLOAD_ACCESS, "__anyhit__ program read payload slot 0",
            entry("__anyhit__a", get0), Types({{kCaller | kAnyHitWrite}}));
    // One of two types suffices, unless the program excludes it.
    Types two({{kCaller | kHitWrite, kCaller | kHitWrite}, {kCaller}});
    refused(OPTIX_ERROR_INVALID_PAYLOAD_ACCESS, "payload type 1", entry("__closesthit__c", set1),
            two);
    OptixModule module = nullptr;
    ASSERT_OK(create(ptxModule(entry("__closesthit__c", types(1) + set1)), two, module));
    optixModuleDestroy(module);
    // Through memory: found by compiling.
    const std::string hidden = ".local .align 4 .b8 box[4];\n st.local.u32 [box], 1;\n"
                               " ld.local.u32 %r1, [box];\n call _optix_set_payload, (%r1, %r2);";
    refused(OPTIX_ERROR_INVALID_PAYLOAD_ACCESS, "line 9", entry("__closesthit__c", hidden), two);
    ASSERT_OK(create(ptxModule(entry("__closesthit__c", types(1) + hidden)), two, module));
    optixModuleDestroy(module);
    refused(
        OPTIX_ERROR_INVALID_FUNCTION_ARGUMENTS, "not a constant",
        entry("__closesthit__c",
              "call (%r3), _optix_get_launch_index_x, (); call _optix_set_payload, (%r3, %r2);"),
        two);
    // optixSetPayloadTypes: known ids, once, at the top, constant, where there are payloads.
    refused(OPTIX_ERROR_PAYLOAD_TYPE_ID_INVALID, "payload types 4", entry("__miss__m", types(4)),
            two);
    refused(OPTIX_ERROR_PAYLOAD_TYPE_ID_INVALID, "payload types 1", entry("__miss__m", types(1)),
            Types({}));
    refused(OPTIX_ERROR_INVALID_FUNCTION_USE, "twice", entry("__miss__m", types(1) + types(1)),
            two);
    refused(OPTIX_ERROR_INVALID_FUNCTION_USE, "at the top",
            entry("__miss__m", "@%p bra end;\n" + types(1) + "end:"), two);
    refused(OPTIX_ERROR_INVALID_FUNCTION_ARGUMENTS, "not a constant",
            entry("__miss__m", "call (%r3), _optix_get_launch_index_x, ();\n"
                               "call _optix_set_payload_types, (%r3);"),
            two);
    refused(OPTIX_ERROR_INVALID_FUNCTION_USE, "__raygen__", entry("__raygen__r", types(1)), two);
}

// The two bits of a kind of program determine its access rights.
TEST_P(PayloadTypes, SemanticsOfEveryKind) {
    struct Row {
        const char* name;
        unsigned none, read, write, both;
    };
    const Row rows[] = {
        {"__closesthit__p", OPTIX_PAYLOAD_SEMANTICS_CH_NONE, OPTIX_PAYLOAD_SEMANTICS_CH_READ,
         OPTIX_PAYLOAD_SEMANTICS_CH_WRITE, OPTIX_PAYLOAD_SEMANTICS_CH_READ_WRITE},
        {"__miss__p", OPTIX_PAYLOAD_SEMANTICS_MS_NONE, OPTIX_PAYLOAD_SEMANTICS_MS_READ,
         OPTIX_PAYLOAD_SEMANTICS_MS_WRITE, OPTIX_PAYLOAD_SEMANTICS_MS_READ_WRITE},
        {"__anyhit__p", OPTIX_PAYLOAD_SEMANTICS_AH_NONE, OPTIX_PAYLOAD_SEMANTICS_AH_READ,
         OPTIX_PAYLOAD_SEMANTICS_AH_WRITE, OPTIX_PAYLOAD_SEMANTICS_AH_READ_WRITE},
        {"__intersection__p", OPTIX_PAYLOAD_SEMANTICS_IS_NONE, OPTIX_PAYLOAD_SEMANTICS_IS_READ,
         OPTIX_PAYLOAD_SEMANTICS_IS_WRITE, OPTIX_PAYLOAD_SEMANTICS_IS_READ_WRITE},
    };
    const unsigned others = OPTIX_PAYLOAD_SEMANTICS_TRACE_CALLER_NONE | kCaller;
    for (const Row& row : rows)
        for (unsigned bits : {row.none, row.read, row.write, row.both})
            for (bool writes : {false, true}) {
                SCOPED_TRACE(testing::Message() << row.name << " " << bits << " " << writes);
                const std::string body = ".visible .entry " + std::string(row.name) +
                                         "() { .reg .b32 %r<3>;\n" +
                                         (writes ? "call _optix_set_payload, (0, %r2);"
                                                 : "call (%r2), _optix_get_payload, (0);") +
                                         " ret; }\n";
                Types types({{others | bits}});
                OptixModule module = nullptr;
                const bool allowed = bits == row.both || bits == (writes ? row.write : row.read);
                EXPECT_EQ(allowed ? OPTIX_SUCCESS : OPTIX_ERROR_INVALID_PAYLOAD_ACCESS,
                          create(ptxModule(body), types, module));
                if (module)
                    optixModuleDestroy(module);
            }
}

TEST_P(PayloadTypes, BadTraces) {
    const auto traceWith = [](unsigned type, unsigned count) {
        std::string text = ".visible .entry __raygen__r() {\n .reg .b32 %r<40>; .reg .b32 %t<32>; "
                           ".reg .f32 %f1; .reg .b64 %h;\n mov.u32 %r1, " +
                           std::to_string(type) + "; mov.u32 %r2, " + std::to_string(count) +
                           ";\n call (%t0";
        for (int i = 1; i < 32; ++i)
            text += ",%t" + std::to_string(i);
        text += "),_optix_trace_typed_32,(%r1,%h,%f1,%f1,%f1,%f1,%f1,%f1,%f1,%f1,%f1,%r3,%r3,%r3,"
                "%r3,%r3,%r2";
        for (int i = 0; i < 32; ++i)
            text += ",%r4";
        return ptxModule(text + ");\n ret; }\n");
    };
    Types two({{kCaller, kCaller}, {kCaller}}), one({{kCaller}}), none({});
    OptixModule module = nullptr;
    EXPECT_REJECTED(OPTIX_ERROR_PAYLOAD_TYPE_RESOLUTION_FAILED, "optixModuleCreateFromPTX",
                    "names no payload type", create(traceWith(0, 1), two, module));
    EXPECT_REJECTED(OPTIX_ERROR_PAYLOAD_TYPE_ID_INVALID, "optixModuleCreateFromPTX",
                    "payload type 3", create(traceWith(3, 1), two, module));
    EXPECT_REJECTED(OPTIX_ERROR_PAYLOAD_TYPE_ID_INVALID, "optixModuleCreateFromPTX",
                    "payload type 4", create(traceWith(4, 1), two, module));
    EXPECT_REJECTED(OPTIX_ERROR_PAYLOAD_TYPE_ID_INVALID, "optixModuleCreateFromPTX",
                    "has no payload types", create(traceWith(1, 1), none, module, 1));
    EXPECT_REJECTED(OPTIX_ERROR_PAYLOAD_TYPE_MISMATCH, "optixModuleCreateFromPTX",
                    "payload type 1 has 1", create(traceWith(2, 2), two, module));
    for (unsigned type : {unsigned(OPTIX_PAYLOAD_TYPE_DEFAULT), 1u}) {
        ASSERT_OK(create(traceWith(type, 1), one, module));
        optixModuleDestroy(module);
    }
    Types all(std::vector<std::vector<unsigned>>(OPTIX_COMPILE_DEFAULT_MAX_PAYLOAD_TYPE_COUNT,
                                                 {kCaller}));
    for (OptixPayloadTypeID type :
         {OPTIX_PAYLOAD_TYPE_ID_0, OPTIX_PAYLOAD_TYPE_ID_1, OPTIX_PAYLOAD_TYPE_ID_2,
          OPTIX_PAYLOAD_TYPE_ID_3, OPTIX_PAYLOAD_TYPE_ID_4, OPTIX_PAYLOAD_TYPE_ID_5,
          OPTIX_PAYLOAD_TYPE_ID_6, OPTIX_PAYLOAD_TYPE_ID_7}) {
        ASSERT_OK(create(traceWith(type, 1), all, module));
        optixModuleDestroy(module);
    }
}

INSTANTIATE_DEVICE_TEST(PayloadTypes);

} // namespace
} // namespace tests::api
