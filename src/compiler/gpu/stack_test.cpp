// SPDX-License-Identifier: Apache-2.0
#include "compiler/gpu/stack.h"

#include <gtest/gtest.h>

#include <locale>
#include <string>

namespace sunstone::compiler {
namespace {

class Grouping : public std::numpunct<char> {
    char do_thousands_sep() const override { return ' '; }
    std::string do_grouping() const override { return "\3"; }
};

TEST(GpuCalls, TextDoesNotFollowTheLocaleOfTheProcess) {
    const std::string text = "first 123456 1 1\nsecond 4096 0\n";
    const std::locale before =
        std::locale::global(std::locale(std::locale::classic(), new Grouping));
    const std::string copy = GpuCalls::fromText(text).text();
    std::locale::global(before);
    EXPECT_EQ(copy, text);
}

} // namespace
} // namespace sunstone::compiler
