// SPDX-License-Identifier: Apache-2.0
// The command line of nvcc: common forms, and random words, which are parsed or refused.
#include "options.h"

#include <gtest/gtest.h>

#include <random>
#include <stdexcept>

using namespace sunstone::nvcc;

namespace {

using Words = std::vector<std::string>;

TEST(NvccOptions, LinesOfBuildSystems) {
    const CommandLine line = parse({"-forward-unknown-to-host-compiler",
                                    "-DA=1",
                                    "-I/a",
                                    "-isystem=/b",
                                    "-O3",
                                    "-DNDEBUG",
                                    "--generate-code=arch=compute_80,code=[compute_80,sm_80]",
                                    "--generate-code=arch=compute_75,code=[sm_75]",
                                    "-std=c++14",
                                    "-Xcompiler=-fPIC,-Wall",
                                    "-pthread",
                                    "-x",
                                    "cu",
                                    "-rdc=true",
                                    "-c",
                                    "a.cu",
                                    "-o",
                                    "a.o",
                                    "-MD",
                                    "-MT",
                                    "a.o",
                                    "-MF",
                                    "a.o.d"});
    EXPECT_EQ(line.phase, Phase::kCompile);
    EXPECT_EQ(line.common, (Words{"-DA=1", "-I/a", "-isystem", "/b", "-DNDEBUG"}));
    EXPECT_EQ(line.host, (Words{"-O3", "-fPIC", "-Wall", "-pthread"}));
    EXPECT_EQ(line.architectures, (std::vector<int>{75, 80}));
    EXPECT_EQ(line.device.standard, "c++17");
    EXPECT_TRUE(line.device.relocatable);
    EXPECT_EQ(line.sources, Words{"a.cu"});
    EXPECT_EQ(line.output, "a.o");
    EXPECT_EQ(line.language, "cu");
    EXPECT_EQ(line.dependency, (Words{"-MD", "-MT", "a.o", "-MF", "a.o.d"}));
}

TEST(NvccOptions, LinkLines) {
    const CommandLine line =
        parse({"-cudart", "shared", "a.o", "-L/lib", "-lfoo", "libbar.a", "-Xlinker", "-rpath",
               "-Xlinker", "/x", "b.cu", "--shared", "-arch", "sm_120"});
    EXPECT_EQ(line.phase, Phase::kLink);
    EXPECT_EQ(line.linked, (Words{"a.o", "-L/lib", "-lfoo", "libbar.a", "-Xlinker", "-rpath",
                                  "-Xlinker", "/x"}));
    EXPECT_EQ(line.runtime, "shared");
    EXPECT_TRUE(line.isShared);
    EXPECT_EQ(line.architectures, std::vector<int>{90}); // the newest that clang knows
}

TEST(NvccOptions, LastArchitecture) {
    EXPECT_EQ(parse({"-arch=compute_60", "a.cu", "-arch", "sm_80"}).architectures,
              std::vector<int>{80});
    EXPECT_EQ(parse({"-arch=sm_80", "-gencode", "arch=compute_75,code=sm_75"}).architectures,
              (std::vector<int>{75, 80}));
}

TEST(NvccOptions, OptionsWithoutEffectAndOfClang) {
    const CommandLine line = parse(
        {"-allow-unsupported-compiler", "--brief-diagnostics=true", "--Wext-lambda-captures-this",
         "-ftemplate-depth", "1024", "--ftemplate-backtrace-limit=10", "-noeh", "--no-align-double",
         "-device-stack-protector=false", "-split-compile-extended", "2", "-jtd=50",
         "-Wno-deprecated-declarations", "-static-global-template-stub=false", "a.cu"});
    EXPECT_EQ(line.sources, Words{"a.cu"});
    EXPECT_EQ(line.common, (Words{"-ftemplate-depth=1024", "-ftemplate-backtrace-limit=10"}));
    EXPECT_EQ(line.host, (Words{"-fno-exceptions", "-Wno-deprecated-declarations"}));
}

// FindCUDA passes quoted words; macros and folders also apply to device code.
TEST(NvccOptions, WordsForTheHostCompiler) {
    const CommandLine line =
        parse({"-Xcompiler", ",\"-g\",\"-DA=\\\"x y\\\"\"", "-Xcompiler", "-O2 -DW=1", "-Xcompiler",
               "\"-Wall\",\"\"", "-Xcompiler=-Ifolder", "a.cu"});
    EXPECT_EQ(line.host, (Words{"-g", "-O2", "-Wall"}));
    EXPECT_EQ(line.common, (Words{"-DA=\"x y\"", "-DW=1", "-Ifolder"}));
}

TEST(NvccOptions, Refused) {
    for (const Words& words : {Words{"--nonsense"},
                               {"-arch=nothing"},
                               {"-arch=sm_5"},
                               {"-gencode", "code=sm_75"},
                               {"-o"},
                               {"-rdc=perhaps"},
                               {"-cudart=dynamic"},
                               {"--options-file", "/nowhere"},
                               {"-dlto"},
                               {"--optix-ir"},
                               {"-ptx=3"}})
        EXPECT_THROW(parse(words), std::runtime_error) << words[0];
}

TEST(NvccOptions, RandomWords) {
    const unsigned seed = std::random_device()();
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const char* const words[] = {"-",       "--",    "-o",       "x",      "a.cu",       "-arch",
                                 "=",       "sm_75", "-gencode", "arch=",  "-Xcompiler", ",",
                                 "-I",      "-D",    "-optf",    "-optf=", "-x",         "cu",
                                 "",        "-MF",   "-std",     "c++",    "-l",         "-O",
                                 "-code=[", "-rdc",  "true",     "\xff"};
    int accepted = 0;
    for (int round = 0; round < 20000; ++round) {
        Words line;
        for (unsigned i = random() % 6; i < 6; ++i)
            line.push_back(words[random() % std::size(words)]);
        try {
            parse(line);
            ++accepted;
        } catch (const std::runtime_error&) {
        }
    }
    EXPECT_GT(accepted, 50);
}

} // namespace
