// SPDX-License-Identifier: Apache-2.0
#include "base/error.h"

#include <gtest/gtest.h>

#include <string>

namespace sunstone {
namespace {

// As in "1.234.567,5".
class Grouping : public std::numpunct<char> {
    char do_thousands_sep() const override { return '.'; }
    char do_decimal_point() const override { return ','; }
    std::string do_grouping() const override { return "\3"; }
};

TEST(Message, NumbersDoNotFollowTheLocaleOfTheProcess) {
    const std::locale before =
        std::locale::global(std::locale(std::locale::classic(), new Grouping));
    const std::string text = message(1234567, " bytes at ", 0.5);
    std::locale::global(before);
    EXPECT_EQ(text, "1234567 bytes at 0.5");
}

} // namespace
} // namespace sunstone
