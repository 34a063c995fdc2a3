// SPDX-License-Identifier: Apache-2.0
// Stored module summaries: serialisation, keys, and reuse without a tree.
#include "compiler/optix7/program_kind.h"
#include "compiler/testing.h"

#include <map>
#include <random>

namespace sunstone::compiler::testing {
namespace {

ModuleSummary some() {
    ModuleSummary summary;
    summary.programs = {
        {"__raygen__a", ProgramKind::kRaygen, 3, true, false, 0, 5, 100, 48},
        {"__direct_callable__b", ProgramKind::kDirectCallable, 0, false, true, 7, 0, 12, 32}};
    summary.launchParamsSize = uint64_t(1) << 33;
    summary.constantBytes = 17;
    summary.selfContained = true;
    summary.mayRecurse = false;
    summary.mayWaitForOthers = true;
    summary.remarks = "warning: line 3\n";
    return summary;
}

void expectSame(const ModuleSummary& a, const ModuleSummary& b) {
    ASSERT_EQ(a.programs.size(), b.programs.size());
    for (size_t i = 0; i < a.programs.size(); ++i) {
        const auto& x = a.programs[i];
        const auto& y = b.programs[i];
        EXPECT_EQ(x.name, y.name);
        EXPECT_EQ(x.kind, y.kind);
        EXPECT_EQ(x.payloadWords, y.payloadWords);
        EXPECT_EQ(x.traces, y.traces);
        EXPECT_EQ(x.callsContinuation, y.callsContinuation);
        EXPECT_EQ(x.parameterWords, y.parameterWords);
        EXPECT_EQ(x.payloadTypes, y.payloadTypes);
        EXPECT_EQ(x.statements, y.statements);
        EXPECT_EQ(x.estimatedStack, y.estimatedStack);
    }
    EXPECT_EQ(a.launchParamsSize, b.launchParamsSize);
    EXPECT_EQ(a.constantBytes, b.constantBytes);
    EXPECT_EQ(a.selfContained, b.selfContained);
    EXPECT_EQ(a.mayRecurse, b.mayRecurse);
    EXPECT_EQ(a.mayWaitForOthers, b.mayWaitForOthers);
    EXPECT_EQ(a.remarks, b.remarks);
}

TEST(Summary, BytesAndBack) {
    ModuleSummary again;
    ASSERT_TRUE(again.deserialize(some().serialize()));
    expectSame(some(), again);
    ASSERT_TRUE(again.deserialize(ModuleSummary().serialize()));
    expectSame(ModuleSummary(), again);
}

TEST(Summary, RefusesOtherBytes) {
    const std::string bytes = some().serialize();
    ModuleSummary again;
    for (size_t size = 0; size < bytes.size(); ++size)
        EXPECT_FALSE(again.deserialize(std::string_view(bytes).substr(0, size))) << size;
    EXPECT_FALSE(again.deserialize(bytes + "x"));
    EXPECT_FALSE(again.deserialize(std::string(64, '\xff')));
    // For any bytes, reading terminates.
    const unsigned seed = std::random_device()();
    SCOPED_TRACE(message("seed ", seed));
    std::mt19937 random(seed);
    for (unsigned round = 0; round < 20'000; ++round) {
        std::string damaged = bytes;
        for (unsigned i = 0; i <= round % 5; ++i)
            damaged[random() % damaged.size()] = char(random());
        again.deserialize(damaged);
    }
}

TEST(Summary, KeysDependOnEverything) {
    const Source source(std::string_view("one")), same(std::string_view("one\0 and more", 13)),
        other(std::string_view("two"));
    PipelineRules rules;
    ModuleRules moduleRules;
    const std::string key = summaryKeyOf(source, rules, moduleRules);
    EXPECT_EQ(16u, key.size());
    EXPECT_EQ(key, summaryKeyOf(same, rules, moduleRules)) << "up to the first NUL";
    EXPECT_NE(key, summaryKeyOf(other, rules, moduleRules));
    rules.optix7.numPayloadValues = 1;
    EXPECT_NE(key, summaryKeyOf(source, rules, moduleRules));
    rules = {};
    moduleRules.payloadTypes = {{{1, 2}}};
    EXPECT_NE(key, summaryKeyOf(source, rules, moduleRules));
    moduleRules = {};
    moduleRules.boundValues = {{0, {1, 2, 3}, ""}};
    EXPECT_NE(key, summaryKeyOf(source, rules, moduleRules));
}

TEST(Summary, SaysWhatTheTreeSays) {
    const auto module = parse(std::string(kHeader) + R"(
.const .align 8 .b8 params[24];
.const .align 4 .b8 table[100];
.extern .const .align 4 .u32 elsewhere;
.visible .entry __raygen__a() { .local .align 4 .b8 room[40]; .reg .b32 %r<3>;
    ld.const.u32 %r1, [elsewhere]; ret; }
)");
    PipelineRules rules;
    rules.launchParams = "params";
    const ModuleSummary summary = inspect(*module, rules);
    EXPECT_EQ(24u, summary.launchParamsSize);
    EXPECT_EQ(100u, summary.constantBytes);
    EXPECT_FALSE(summary.selfContained);
    EXPECT_TRUE(summary.mayRecurse) << "through functions that the module does not have";
    ASSERT_EQ(1u, summary.programs.size());
    EXPECT_EQ(2u, summary.programs[0].statements);
    EXPECT_EQ(80u, summary.programs[0].estimatedStack); // 32 and 40, in units of 16
}

TEST(Summary, RecursionOfFunctions) {
    const auto mayRecurse = [](const std::string& functions, const char* call) {
        const auto module = parse(std::string(kHeader) + functions +
                                  ".visible .entry __raygen__a() {" + call + " ret; }\n");
        return inspect(*module, {}).mayRecurse;
    };
    const std::string leaf = ".func leaf() { ret; }\n";
    EXPECT_FALSE(mayRecurse(leaf, "call.uni leaf; call.uni leaf;"));
    EXPECT_FALSE(mayRecurse(leaf + ".func b() { call.uni leaf; ret; }\n"
                                   ".func a() { call.uni leaf; call.uni b; ret; }\n",
                            "call.uni a;"));
    EXPECT_TRUE(mayRecurse(".func a() { call.uni a; ret; }\n", "call.uni a;"));
    EXPECT_TRUE(mayRecurse(".func b();\n.func a() { call.uni b; ret; }\n"
                           ".func b() { call.uni a; ret; }\n",
                           "call.uni a;"));
    EXPECT_TRUE(mayRecurse(leaf, ".reg .b64 %rd<2>; mov.u64 %rd1, leaf; p: .callprototype _ ();"
                                 " call %rd1, (), p;"))
        << "by address";
}

TEST(Summary, WaysToWait) {
    const auto mayWait = [](const char* body) {
        const auto module = parse(std::string(kHeader) +
                                  ".visible .entry __raygen__a() { .reg .b32 %r<4>; "
                                  ".reg .b64 %rd<2>; mov.u64 %rd1, 0; " +
                                  body + " ret; }\n");
        return inspect(*module, {}).mayWaitForOthers;
    };
    EXPECT_FALSE(mayWait("ld.global.u32 %r1, [%rd1]; atom.global.add.u32 %r1, [%rd1], 1;"));
    for (const char* body :
         {"atom.global.cas.b32 %r1, [%rd1], 0, 1;", "atom.global.exch.b32 %r1, [%rd1], 0;",
          "ld.volatile.u32 %r1, [%rd1];", "ld.acquire.gpu.u32 %r1, [%rd1];",
          "ld.relaxed.gpu.global.u32 %r1, [%rd1];"})
        EXPECT_TRUE(mayWait(body)) << body;
}

class MapStore : public ObjectStore {
public:
    bool find(const std::string& key, std::string& value) override {
        const auto found = values.find(key);
        if (found != values.end())
            value = found->second;
        return found != values.end();
    }
    void insert(const std::string& key, const std::string& value) override {
        std::lock_guard lock(mutex);
        values[key] = value;
    }
    std::map<std::string, std::string> values;
    std::mutex mutex;
};

TEST(Source, WhatIsKeptSparesTheTree) {
    const std::string text = std::string(kHeader) +
                             ".global .align 4 .u32 counter = 100;\n"
                             ".visible .entry __miss__a() { .reg .b32 %r<3>;\n"
                             "ld.global.u32 %r1, [counter]; st.global.u32 [counter], %r1; ret; }\n";
    const std::string other = std::string(kHeader) + ".visible .entry __miss__b() { ret; }\n";
    MapStore store;
    for (const bool kept : {false, true}) {
        const auto one = std::make_shared<const Source>(std::string_view(text)),
                   two = std::make_shared<const Source>(std::string_view(other));
        PipelineRequest request;
        for (const auto& [module, name] : {std::pair(one, "__miss__a"), {two, "__miss__b"}}) {
            ProgramRequest program{module, name, programKind(name)};
            program.selfContained = true;
            request.programs.push_back(program);
        }
        const auto code = compilePipeline(request, &store);
        EXPECT_EQ(2u, code->programs().size());
        EXPECT_EQ(kept, !one->isParsed());
        EXPECT_EQ(kept, !two->isParsed());
        void* address = nullptr;
        uint64_t size = 0;
        ASSERT_TRUE(code->variable("counter", &address, &size));
        EXPECT_EQ(100u, *static_cast<uint32_t*>(address));
    }
}

TEST(Source, TextsThatAreNotRight) {
    const Source source(std::string_view("no PTX"));
    for (int repeat = 0; repeat < 2; ++repeat)
        try {
            source.tree();
            FAIL() << "no error";
        } catch (const Error& error) {
            EXPECT_EQ(sunstone::Code::kInvalidPtx, error.code());
        }
    EXPECT_FALSE(source.isParsed());
}

} // namespace
} // namespace sunstone::compiler::testing
