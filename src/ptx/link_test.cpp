// SPDX-License-Identifier: Apache-2.0
// Linked modules parse, and their symbols follow the rules of C.
#include "ptx/link.h"

#include "base/error.h"
#include "ptx/test_support.h"

namespace sunstone::ptx::testing {
namespace {

std::unique_ptr<Module> linked(const std::vector<std::string>& items, bool sharesAll = false) {
    std::vector<std::unique_ptr<Module>> modules;
    std::vector<const Module*> list;
    for (const std::string& each : items)
        list.push_back(modules.emplace_back(mustParseItems(each)).get());
    return mustParse(link(list, [&](const Module&, const Variable&) { return sharesAll; }));
}

const char* const kCaller = ".extern .func helper (.param .b32 a);\n"
                            ".extern .global .u32 total;\n"
                            ".visible .entry kernel() { .param .b32 p; st.param.b32 [p], 1; "
                            "call helper, (p); .reg .b32 %r; ld.global.u32 %r, [total]; ret; }\n";
const char* const kCallee = ".visible .global .u32 total = 7;\n"
                            ".visible .func helper (.param .b32 a) { ret; }\n";

TEST(Link, GlobalSymbolsAreFoundInOtherModules) {
    for (const bool swapped : {false, true}) {
        const auto module = swapped ? linked({kCallee, kCaller}) : linked({kCaller, kCallee});
        ASSERT_TRUE(module->findFunction("helper"));
        EXPECT_TRUE(module->findFunction("helper")->hasBody);
        ASSERT_TRUE(module->findVariable("total"));
        EXPECT_EQ(module->findVariable("total")->linkage, Linkage::kVisible);
        EXPECT_EQ(module->findVariable("total")->initializer[0], 7);
        EXPECT_EQ(module->variables.size(), 1u);
    }
}

TEST(Link, InternalSymbolsStayApart) {
    const std::string items = ".global .u32 own = 1;\n.func local () { .reg .b32 %r; "
                              "ld.global.u32 %r, [own]; ret; }\n";
    const auto module = linked({items + ".visible .entry a() { call local, (); ret; }",
                                items + ".visible .entry b() { call local, (); ret; }"});
    EXPECT_EQ(module->variables.size(), 2u);
    EXPECT_EQ(module->functions.size(), 4u);
    const auto& call = module->findFunction("b")->body[0].instruction;
    ASSERT_TRUE(module->findFunction(call.target.name));
    EXPECT_NE(call.target.name, "local");
    const auto& load = module->findFunction(call.target.name)->body[0].instruction;
    EXPECT_NE(load.operands[1].name, "own");
    EXPECT_TRUE(module->findVariable(load.operands[1].name));
    EXPECT_EQ(linked({items, ".global .u32 own = 1;"}, true)->variables.size(), 1u);
}

TEST(Link, TwoDefinitionsAreAnError) {
    const std::string kernel = ".visible .entry kernel() { ret; }";
    EXPECT_EQ(linked({kernel, kernel})->functions.size(), 1u) << "they are equal";
    EXPECT_THROW(linked({kernel, ".visible .entry kernel() { bar.sync 0; ret; }"}), Error);
    EXPECT_THROW(linked({".visible .global .u32 x = 1;", ".visible .global .u32 x = 2;"}), Error);
    EXPECT_EQ(linked({".weak .global .u32 x = 1;", ".weak .global .u32 x = 2;"})
                  ->findVariable("x")
                  ->initializer[0],
              1);
}

} // namespace
} // namespace sunstone::ptx::testing
