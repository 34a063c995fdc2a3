// SPDX-License-Identifier: Apache-2.0
#include "device/cuda/ptx_parts.h"

#include "base/error.h"

#include <gtest/gtest.h>

namespace sunstone::device::cuda {
namespace {

constexpr std::string_view kHead = ".version 7.8\n.target sm_75\n.address_size 64\n";

std::string functionOf(const std::string& name, const std::string& body) {
    return ".func  (.param .b32 func_retval0) " + name + "(\n\t.param .b64 " + name +
           "_param_0\n)\n{\n" + body + "\tret;\n\n}\n";
}
std::string callOf(const std::string& name) {
    return "\t{ // callseq\n\t.param .b64 param0;\n\tst.param.b64 [param0], %rd1;\n\tcall.uni "
           "(retval0), \n\t" +
           name + ", \n\t(\n\tparam0\n\t);\n\t}\n";
}
std::string addressOf(const std::string& name) {
    return "\tmov.u64 \t%rd2, " + name + ";\n";
}
std::string filler(size_t bytes) {
    std::string text;
    while (text.size() < bytes)
        text += "\tadd.s32 \t%r1, %r1, 1;\n";
    return text;
}

// A kernel that calls `walk` and takes the addresses of `count` large functions; all call `common`,
// the first two read `table`.
std::string programOf(size_t count, const std::string& variables = "") {
    std::string text(kHead), kernel = callOf("walk");
    text +=
        "\n.extern .func  (.param .b32 func_retval0) vprintf\n(\n\t.param .b64 vprintf_param_0\n)"
        "\n;\n" +
        variables + "\n";
    text += functionOf("walk", callOf("common"));
    text += functionOf("common", filler(100));
    for (size_t i = 0; i < count; ++i) {
        const std::string name = "f_$___direct_callable__" + std::to_string(i);
        text += functionOf(name, filler(40 << 10) + callOf("common") +
                                     (i < 2 ? "\tmov.u64 \t%rd3, table;\n" : ""));
        kernel += addressOf(name);
    }
    return text +
           ".visible .entry sunstone_launch(\n\t.param .u64 sunstone_launch_param_0\n)\n{\n" +
           kernel + "\tret;\n\n}\n";
}

size_t countOf(const std::vector<std::string>& texts, const std::string& what) {
    size_t count = 0;
    for (const std::string& text : texts)
        for (size_t at = text.find(what); at != text.npos; at = text.find(what, at + 1))
            ++count;
    return count;
}

TEST(PtxParts, EachFunctionIsDefinedOnce) {
    const std::vector<std::string> parts =
        splitPtx(programOf(5, ".global .align 4 .b8 table[16] = {1, 2};"));
    ASSERT_EQ(parts.size(), 4u); // two functions are more than a part's share
    EXPECT_EQ(countOf(parts, ".visible .entry sunstone_launch("), 1u);
    EXPECT_NE(parts[0].find(".visible .entry sunstone_launch("), std::string::npos);
    for (const char* name :
         {"walk", "common", "f_$___direct_callable__0", "f_$___direct_callable__4"}) {
        SCOPED_TRACE(name);
        const std::string head =
            std::string(") ") + name + "(\n\t.param .b64 " + name + "_param_0\n)\n";
        EXPECT_EQ(countOf(parts, head + "{"), 1u);
    }
    for (const std::string& part : parts)
        EXPECT_TRUE(part.starts_with(kHead)) << part.substr(0, 80);
}

TEST(PtxParts, PartsDeclareWhatTheyUse) {
    const std::vector<std::string> parts =
        splitPtx(programOf(5, ".global .align 4 .b8 table[16] = {1, 2};"));
    ASSERT_EQ(parts.size(), 4u);
    constexpr const char* kCommon = ".extern .func  (.param .b32 func_retval0) common(";
    EXPECT_EQ(parts[0].find(kCommon), std::string::npos) << "it is defined there";
    EXPECT_EQ(countOf(parts, ".extern .func  (.param .b32 func_retval0) f_$___direct_callable__"),
              5u)
        << "the kernel takes the addresses";
    for (size_t i = 1; i < parts.size(); ++i)
        EXPECT_NE(parts[i].find(kCommon), std::string::npos);
}

TEST(PtxParts, VariablesHaveOneOwner) {
    const auto partsWith = [](const std::string& variable) {
        return splitPtx(programOf(3, variable));
    };
    const std::vector<std::string> together = partsWith(".global .align 4 .b8 table[16] = {1, 2};");
    EXPECT_EQ(countOf(together, "\n.global .align 4 .b8 table[16] = {1, 2};\n"), 1u)
        << "both functions that use it are in one part";
    EXPECT_EQ(countOf(together, "table[16]"), 1u);
    const std::string far = programOf(5, ".global .align 4 .b8 table[16] = {1, 2};");
    std::string apart = far;
    const size_t last = apart.find("\tret;", apart.find("f_$___direct_callable__4(\n"));
    apart.insert(last, "\tmov.u64 \t%rd3, table;\n");
    const std::vector<std::string> two = splitPtx(apart);
    EXPECT_EQ(countOf(two, "\n.visible .global .align 4 .b8 table[16] = {1, 2};\n"), 1u);
    EXPECT_EQ(countOf(two, "\n.extern .global .align 4 .b8 table[16] ;\n") +
                  countOf(two, "\n.extern .global .align 4 .b8 table[16];\n"),
              1u);
    EXPECT_TRUE(splitPtx(programOf(5, ".global .align 8 .u64 table[1] = {common};")).empty())
        << "a kernel may call it by what the variable holds";
    // Memory of a block cannot be shared between linked programs.
    std::string shared = apart;
    shared.replace(shared.find(".global .align 4 .b8 table[16] = {1, 2};"), 40,
                   ".shared .align 4 .b8 table[16];");
    EXPECT_TRUE(splitPtx(shared).empty());
}

// Their stacks are not known to the linker.
TEST(PtxParts, FunctionsThatCallByAddressStayTogether) {
    const std::string program = programOf(5);
    ASSERT_FALSE(splitPtx(program).empty());
    for (const std::string& call :
         {std::string("prototype_0 : .callprototype ()_ (.param .b64 _);\n"), callOf("vprintf")}) {
        std::string changed = program;
        changed.insert(changed.find("\tret;", changed.find("f_$___direct_callable__2(\n")), call);
        EXPECT_TRUE(splitPtx(changed).empty()) << call;
    }
}

TEST(PtxParts, FewFunctionsStayTogether) {
    EXPECT_TRUE(splitPtx(programOf(0)).empty());
    EXPECT_TRUE(splitPtx(programOf(1)).empty());
    EXPECT_FALSE(splitPtx(programOf(2)).empty());
    EXPECT_TRUE(splitPtx("").empty());
    EXPECT_TRUE(splitPtx("no PTX {").empty());
}

} // namespace
} // namespace sunstone::device::cuda
