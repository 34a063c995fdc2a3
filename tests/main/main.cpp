// SPDX-License-Identifier: Apache-2.0
// main() of all GoogleTest programs. A filter that names a test that does not exist is an error:
// each pattern of --gtest_filter, the excluding ones too, must match a test of the program. Without
// that, a renamed test silently leaves the selections of scripts and of ctest.
#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace {

// GoogleTest's patterns: * matches any text, ? any character.
bool matches(std::string_view pattern, std::string_view name) {
    if (pattern.empty())
        return name.empty();
    if (pattern[0] == '*')
        return matches(pattern.substr(1), name) ||
               (!name.empty() && matches(pattern, name.substr(1)));
    return !name.empty() && (pattern[0] == '?' || pattern[0] == name[0]) &&
           matches(pattern.substr(1), name.substr(1));
}

std::vector<std::string> testNames() {
    std::vector<std::string> names;
    const testing::UnitTest& program = *testing::UnitTest::GetInstance();
    for (int s = 0; s < program.total_test_suite_count(); ++s) {
        const testing::TestSuite& suite = *program.GetTestSuite(s);
        for (int t = 0; t < suite.total_test_count(); ++t)
            names.push_back(std::string(suite.name()) + "." + suite.GetTestInfo(t)->name());
    }
    return names;
}

// Patterns are separated by colons, and the first minus begins those that exclude.
std::vector<std::string> patternsOf(const std::string& filter) {
    std::vector<std::string> patterns(1);
    for (const char c : filter)
        if (c == ':' || c == '-')
            patterns.emplace_back();
        else
            patterns.back() += c;
    std::erase(patterns, "");
    return patterns;
}

bool isStale(const std::string& pattern, const std::vector<std::string>& names) {
    for (const std::string& name : names)
        if (matches(pattern, name))
            return false;
    std::fprintf(stderr, "--gtest_filter: no test of this program matches \"%s\"\n",
                 pattern.c_str());
    return true;
}

} // namespace

int main(int argc, char** argv) {
    testing::InitGoogleTest(&argc, argv);
    const std::vector<std::string> names = testNames();
    bool stale = false;
    for (const std::string& pattern : patternsOf(testing::GTEST_FLAG(filter)))
        stale |= isStale(pattern, names);
    if (stale)
        return 2;
    const int result = RUN_ALL_TESTS();
    const bool lists = testing::GTEST_FLAG(list_tests);
    if (lists || testing::UnitTest::GetInstance()->test_to_run_count() != 0)
        return result;
    std::fprintf(stderr, "--gtest_filter: no test is left\n");
    return 2;
}
