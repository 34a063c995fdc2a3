// SPDX-License-Identifier: Apache-2.0
// Random options: each list is refused with an error, or the arguments for clang that it gives all
// look like options.
#include "api/nvrtc/options.h"

#include <gtest/gtest.h>

#include <random>

using namespace sunstone::nvrtc;

namespace {

TEST(NvrtcOptions, RandomWords) {
    const unsigned seed = std::random_device()();
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const char* const names[] = {"arch",
                                 "gpu-architecture",
                                 "D",
                                 "U",
                                 "I",
                                 "include",
                                 "std",
                                 "ftz",
                                 "G",
                                 "rdc",
                                 "dc",
                                 "use_fast_math",
                                 "lineinfo",
                                 "w",
                                 "maxrregcount",
                                 "default-device",
                                 "Xptxas",
                                 "prec-div",
                                 "fmad",
                                 "optix-ir",
                                 "time"};
    const char* const values[] = {"",         "true",     "false",        "sm_75",
                                  "compute_", "sm_75a",   "sm_90a",       "compute_99999999999999",
                                  "c++20",    "c++",      "@/etc/passwd", "-",
                                  "=",        "x y",      "\n",           "\xff\xfe",
                                  "32",       "-o/tmp/x", "sm_-1",        "sm_0"};
    const char* const dashes[] = {"", "-", "--", "---"};
    const char* const joints[] = {"=", "", " ", "=="};
    const auto pick = [&](const auto& list) {
        return std::string(list[random() % std::size(list)]);
    };
    int accepted = 0;
    for (int round = 0; round < 50000; ++round) {
        std::vector<std::string> words;
        for (unsigned i = random() % 4; i < 4; ++i)
            words.push_back(random() % 8 ? pick(dashes) + pick(names) + pick(joints) + pick(values)
                                         : pick(values));
        const Options options = parseOptions(words, 75);
        if (!options.errors.empty())
            continue;
        ++accepted;
        EXPECT_GE(options.architecture, 50);
        EXPECT_LE(options.architecture, 90);
        // A value cannot become an option of clang or a response file.
        for (const std::string& argument : options.preprocessor)
            EXPECT_TRUE(argument.starts_with("-D") || argument.starts_with("-U") ||
                        argument.starts_with("-I") || argument.starts_with("--include="))
                << argument;
        for (const std::string& argument : clangArguments(options))
            EXPECT_NE(argument[0], '@');
    }
    EXPECT_GT(accepted, 100);
}

TEST(NvrtcOptions, FormsOfValues) {
    const Options options =
        parseOptions({"-DA", "-D", "B=1", "-D C=2", "--define-macro=D=3", "-U=E", "-I", "/a",
                      "-I/b", "--include-path=/c", "--pre-include=d.h", "-arch", "sm_80"},
                     75);
    EXPECT_TRUE(options.errors.empty());
    const std::vector<std::string> expected = {"-DA",  "-DB=1", "-DC=2", "-DD=3",        "-UE",
                                               "-I/a", "-I/b",  "-I/c",  "--include=d.h"};
    EXPECT_EQ(options.preprocessor, expected);
    EXPECT_EQ(options.architecture, 80);
    EXPECT_TRUE(options.isReal);
}

// Applications of OptiX 4 to 6 name the lowest target of their time.
TEST(NvrtcOptions, ArchitecturesOfOldReleases) {
    for (const char* old : {"compute_20", "compute_30", "sm_35"}) {
        const Options options = parseOptions({"-arch", old}, 75);
        EXPECT_TRUE(options.errors.empty()) << old;
        EXPECT_EQ(options.architecture, 50) << old;
        ASSERT_EQ(options.remarks.size(), 1u);
        EXPECT_NE(options.remarks[0].find(old), std::string::npos) << options.remarks[0];
    }
    EXPECT_FALSE(parseOptions({"-arch=compute_13"}, 75).errors.empty());
}

} // namespace
