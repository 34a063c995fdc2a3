// SPDX-License-Identifier: Apache-2.0
#include "api/nvrtc/asm_text.h"

#include <gtest/gtest.h>

using sunstone::nvrtc::defineVariables;
using sunstone::nvrtc::doublePercents;
using sunstone::nvrtc::referToStaticVariables;

TEST(AsmText, NamesOfRegistersGetASecondPercent) {
    EXPECT_EQ(doublePercents("asm(\"mov.u32 %0, %laneid;\" : \"=r\"(x));"),
              "asm(\"mov.u32 %0, %%laneid;\" : \"=r\"(x));");
    EXPECT_EQ(doublePercents("asm volatile (\"mov.u32 %0, \"\n\"%tid.x;\\n\" : \"=r\"(x));"),
              "asm volatile (\"mov.u32 %0, \"\n\"%%tid.x;\\n\" : \"=r\"(x));");
    EXPECT_EQ(doublePercents("__asm__ __volatile__(\"a %rd1, % x\"::);"),
              "__asm__ __volatile__(\"a %%rd1, %% x\"::);");
}

TEST(AsmText, WhatClangAcceptsStays) {
    for (const char* text : {
             "asm(\"mov.u32 %0, %%laneid; {%1, %[name]} %r1 %{ %= %| %}\" : \"=r\"(x));",
             "asm(\"mov.u32 a, %laneid;\");",         // without operands there are no escapes
             "printf(\"%smid asm(\", \"%laneid:\");", // no statement
             "const char* s = R\"(asm(\"%laneid\":))\";",
             "char q = '\"', r = '\\''; int n = 1'000; asmx(\"%laneid\" :",
             "# 1 \"asm(\"\nint asm_;\n",
             "asm",
             "asm(",
             "asm(\"%laneid",
             "\"",
             "'",
             "R\"x(",
             "",
         })
        EXPECT_EQ(doublePercents(text), text);
}

TEST(AsmText, DeclaredVariablesBecomeDefinitions) {
    EXPECT_EQ(defineVariables("\n.extern .const .align 4 .b8 k[16];\n.extern .global .u32 g;\n"),
              "\n.const .align 4 .b8 k[16];\n.global .u32 g;\n");
    for (const char* text :
         {"\n.extern .shared .align 4 .b8 s[];\n", "\n.extern .global .b8 a[];\n",
          "\n.extern .func f;\n", "\n.visible .const .u32 k;\n", ""})
        EXPECT_EQ(defineVariables(text), text);
}

TEST(AsmText, StaticVariablesHaveOneName) {
    EXPECT_EQ(referToStaticVariables("\n.extern .global .align 4 .u32 v;"
                                     "\n.extern .const .align 4 .b8 w[8];"
                                     "\n.extern .global .u32 _v;"
                                     "\n.visible .global .align 4 .u32 v__static__a1 = 4;"
                                     "\n.visible .const .align 4 .b8 w__static__a1[8];"
                                     "\n\tmov.u64 %rd1, v;\n\tld.const.u32 %r1, [w+4];"
                                     "\n\tmov.u64 %rd2, _v;\n"),
              "\n.extern .global .u32 _v;"
              "\n.visible .global .align 4 .u32 v__static__a1 = 4;"
              "\n.visible .const .align 4 .b8 w__static__a1[8];"
              "\n\tmov.u64 %rd1, v__static__a1;\n\tld.const.u32 %r1, [w__static__a1+4];"
              "\n\tmov.u64 %rd2, _v;\n");
    for (const char* text : {"\n.extern .global .u32 v;\n", "\n.visible .u32 v__static__a = 1;\nv",
                             "__static__", "\n.extern .v__static__", ""})
        EXPECT_EQ(referToStaticVariables(text), text);
}
