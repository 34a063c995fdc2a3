// SPDX-License-Identifier: Apache-2.0
// Type names and sizes, look-ups, messages.
#include "ptx/test_support.h"

namespace sunstone::ptx::testing {
namespace {

TEST(Types, EveryNameLeadsBackToItsType) {
    for (unsigned i = 1; i <= static_cast<unsigned>(Type::kSurfref); ++i) {
        const Type type = static_cast<Type>(i);
        Type found = Type::kNone;
        EXPECT_TRUE(typeFromName(ptx::nameOf(type), found)) << ptx::nameOf(type);
        EXPECT_EQ(found, type) << ptx::nameOf(type);
    }
}

TEST(Types, OtherNamesAreNotTypes) {
    for (const char* name : {"", "u", "u3", "u33", "u128", "s128", "f8", "f128", "b", "b1", "none",
                             "pred2", "bf32", "f16x4", "global", "U32", "u32 "}) {
        Type type = Type::kNone;
        EXPECT_FALSE(typeFromName(name, type)) << name;
    }
}

TEST(Types, Sizes) {
    EXPECT_EQ(sizeOf(Type::kNone), 0u);
    EXPECT_EQ(sizeOf(Type::kPred), 1u);
    EXPECT_EQ(sizeOf(Type::kU8), 1u);
    EXPECT_EQ(sizeOf(Type::kBF16), 2u);
    EXPECT_EQ(sizeOf(Type::kF16x2), 4u);
    EXPECT_EQ(sizeOf(Type::kS32), 4u);
    EXPECT_EQ(sizeOf(Type::kF64), 8u);
    EXPECT_EQ(sizeOf(Type::kB128), 16u);
    EXPECT_EQ(sizeOf(Type::kTexref), 8u);
}

TEST(Types, Classes) {
    EXPECT_TRUE(isFloat(Type::kF16) && isFloat(Type::kBF16x2) && isFloat(Type::kF64));
    EXPECT_FALSE(isFloat(Type::kB32) || isFloat(Type::kS64) || isFloat(Type::kTexref));
    EXPECT_TRUE(isSigned(Type::kS8) && isSigned(Type::kS64));
    EXPECT_FALSE(isSigned(Type::kU64) || isSigned(Type::kF32));
}

TEST(Module, FindsDefinitionsBeforeDeclarations) {
    const auto module = mustParseItems(".func f(.param .u32 a);\n.func g() { ret; }\n"
                                       ".func f(.param .u32 a) { ret; }\n.func f(.param .u32 a);\n"
                                       ".extern .global .u32 v;\n.global .u32 v = 5;\n");
    ASSERT_TRUE(module->findFunction("f"));
    EXPECT_TRUE(module->findFunction("f")->hasBody);
    EXPECT_EQ(module->findFunction("f")->location.line, 6u);
    EXPECT_EQ(module->findFunction("h"), nullptr);
    ASSERT_TRUE(module->findVariable("v"));
    EXPECT_TRUE(module->findVariable("v")->hasInitializer);
    EXPECT_EQ(module->findVariable("f"), nullptr);
    // The look-ups without the index.
    module->functionIndex.clear();
    module->variableIndex.clear();
    EXPECT_EQ(module->findFunction("f")->location.line, 6u);
    EXPECT_TRUE(module->findVariable("v")->hasInitializer);
    EXPECT_EQ(module->findVariable("w"), nullptr);
    EXPECT_EQ(module->findFunction("w"), nullptr);
}

TEST(Diagnostics, ErrorsComeFirstAndCarryTheirPlace) {
    Diagnostics diagnostics;
    EXPECT_FALSE(diagnostics.failed());
    EXPECT_EQ(diagnostics.format(), "");
    diagnostics.warning({3, 4}, "odd");
    EXPECT_FALSE(diagnostics.failed());
    diagnostics.error({12, 5}, "wrong");
    diagnostics.error({}, "no place");
    EXPECT_TRUE(diagnostics.failed());
    EXPECT_EQ(diagnostics.format(),
              "error: line 12:5: wrong\nerror: no place\nwarning: line 3:4: odd\n");
}

TEST(Diagnostics, CountsWhatItDoesNotKeep) {
    Diagnostics diagnostics;
    for (uint32_t i = 0; i < 30; ++i)
        diagnostics.error({i + 1, 1}, "e");
    EXPECT_EQ(diagnostics.errorCount(), 30u);
    EXPECT_EQ(diagnostics.all().size(), Diagnostics::kMaxErrors);
    EXPECT_NE(diagnostics.format().find("error: 10 more errors\n"), std::string::npos);
}

TEST(Nearest, FindsWhatWasMeant) {
    const auto hint = [](const char* name, std::initializer_list<const char*> known) {
        Nearest nearest(name);
        for (const char* candidate : known)
            nearest.offer(candidate);
        return nearest.hint();
    };
    EXPECT_EQ(hint("globl", {"local", "global", "shared"}), " (did you mean 'global'?)");
    EXPECT_EQ(hint("ab", {"ba"}), " (did you mean 'ba'?)");
    EXPECT_EQ(hint("xyz", {"abc", "abcdef"}), "");
    EXPECT_EQ(hint("", {"a"}), "");
    EXPECT_EQ(hint("same", {"same"}), "");
}

TEST(Quoted, ShortensAndReplacesUnprintableBytes) {
    EXPECT_EQ(ptx::quoted("abc"), "'abc'");
    EXPECT_EQ(ptx::quoted("a\x01\xFF"), "'a?"
                                        "?'");
    EXPECT_EQ(ptx::quoted(std::string(100, 'x')).size(), 65u);
}

} // namespace
} // namespace sunstone::ptx::testing
