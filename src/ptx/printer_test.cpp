// SPDX-License-Identifier: Apache-2.0
// The corpus parses, prints, and parses to the same tree again, within time limits.
#include "ptx/printer.h"

#include "ptx/test_support.h"

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

namespace sunstone::ptx::testing {
namespace {

std::string read(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::stringstream stream;
    stream << file.rdbuf();
    return stream.str();
}

std::vector<std::filesystem::path> corpus() {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(SUNSTONE_PTX_CORPUS))
        if (entry.path().extension() == ".ptx")
            files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

// All of a tree except hidden names and source locations, written without the printer.
class Description {
public:
    static std::string of(const Module& module) {
        Description d;
        d.out_ << module.versionMajor << '.' << module.versionMinor << ' ' << module.target << '\n';
        for (const auto& file : module.files)
            d.out_ << "file " << file << '\n';
        for (const auto& [a, b] : module.aliases)
            d.out_ << "alias " << a << ' ' << b << '\n';
        for (const Variable& variable : module.variables)
            d.variable(variable);
        for (const Function& function : module.functions)
            if (function.hasBody) // declarations move to the front and may be added
                d.function(function);
        std::set<std::string_view> declared;
        for (const Function& function : module.functions)
            declared.insert(function.name);
        for (const std::string_view name : declared)
            d.out_ << "has " << name << '\n';
        return d.out_.str();
    }

private:
    void variable(const Variable& v) {
        out_ << "variable " << v.name << ' ' << int(v.space) << int(v.linkage) << ' ' << int(v.type)
             << " v" << v.vector << " a" << v.alignment << " s" << v.size
             << (v.isArray ? " array" : "") << (v.isPointer ? " pointer" : "")
             << int(v.pointerSpace) << ' ' << v.pointerAlignment << (v.isManaged ? " managed" : "")
             << (v.hasInitializer ? " = " : "");
        for (const uint64_t dimension : v.dimensions)
            out_ << '[' << dimension << ']';
        for (const uint8_t byte : v.initializer)
            out_ << int(byte) << ' ';
        for (const Relocation& r : v.relocations)
            out_ << '@' << r.offset << ' ' << r.symbol << '+' << r.addend << (r.generic ? "g" : "")
                 << int(r.mask) << '/' << r.size;
        out_ << '\n';
    }

    void operand(const Operand& o) {
        const bool numbered = o.kind == OperandKind::kLabel || o.kind == OperandKind::kRegister;
        out_ << int(o.kind) << (o.negated ? "!" : "") << int(o.floatBits) << ',' << o.index << ','
             << int(o.component) << ',' << o.integer << ',' << o.offset << ',' << o.scale << ','
             << (numbered ? std::string_view() : o.name) << '(';
        for (const Operand& element : o.elements)
            operand(element);
        out_ << ')';
    }

    void instruction(const Instruction& i) {
        out_ << i.fullOpcode() << ' ' << i.guard << i.guardNegated << ' ' << i.source.file << ':'
             << i.source.line << ':' << i.source.column << ' ';
        for (const Type type : i.types)
            out_ << int(type) << ' ';
        for (const auto* list : {&i.operands, &i.results, &i.arguments}) {
            out_ << '[';
            for (const Operand& o : *list)
                operand(o);
            out_ << ']';
        }
        operand(i.target);
        out_ << ' ' << i.prototype << '\n';
    }

    void function(const Function& f) {
        out_ << "function " << f.name << ' ' << int(f.linkage) << f.isEntry << f.noreturn << ' '
             << f.minBlocks << ' ' << f.maxRegisters << ' ' << f.explicitCluster << '\n';
        for (int i = 0; i < 3; ++i)
            out_ << f.maxThreads[i] << ' ' << f.requiredThreads[i] << ' ' << f.requiredCluster[i];
        for (const auto* list : {&f.results, &f.parameters, &f.variables})
            for (const Variable& v : *list)
                variable(v);
        for (const auto* list : {&f.resultRegisters, &f.parameterRegisters})
            for (const uint32_t index : *list)
                out_ << index << ' ';
        for (const Register& reg : f.registers)
            out_ << int(reg.type) << 'v' << reg.vector << ' ';
        out_ << f.labels.size() << " labels\n";
        for (const Prototype& prototype : f.prototypes) {
            out_ << "prototype " << prototype.name << '\n';
            for (const auto* list : {&prototype.results, &prototype.parameters})
                for (const Variable& v : *list)
                    variable(v);
        }
        for (const BranchTargets& targets : f.branchTargets) {
            out_ << "targets " << targets.name;
            for (const uint32_t label : targets.labels)
                out_ << ' ' << label;
        }
        for (const CallTargets& targets : f.callTargets) {
            out_ << "callees " << targets.name;
            for (const std::string_view callee : targets.functions)
                out_ << ' ' << callee;
        }
        for (const Statement& statement : f.body) {
            if (statement.kind == StatementKind::kLabel)
                out_ << "label " << statement.label << '\n';
            else
                instruction(statement.instruction);
        }
    }

    std::ostringstream out_;
};

void roundTrip(const std::string& text, const std::string& name) {
    Diagnostics first;
    const auto module = parse(text, first);
    ASSERT_TRUE(module) << name << ":\n" << first.format();
    const std::string printed = print(*module);
    Diagnostics second;
    const auto copy = parse(printed, second);
    ASSERT_TRUE(copy) << name << ":\n" << second.format() << printed;
    EXPECT_EQ(Description::of(*module), Description::of(*copy)) << name;
    EXPECT_EQ(print(*copy), printed) << name;
}

TEST(Corpus, ParsesAndSurvivesPrinting) {
    const auto files = corpus();
    ASSERT_GE(files.size(), 20u);
    for (const auto& file : files)
        roundTrip(read(file), file.filename().string());
}

TEST(Corpus, HoldsWhatCompilersSay) {
    Diagnostics diagnostics;
    const auto module =
        parse(read(std::filesystem::path(SUNSTONE_PTX_CORPUS) / "programs.nvcc.ptx"), diagnostics);
    ASSERT_TRUE(module) << diagnostics.format();
    ASSERT_TRUE(module->findFunction("__raygen__camera"));
    EXPECT_TRUE(module->findFunction("__raygen__camera")->isEntry);
    ASSERT_TRUE(module->findVariable("params"));
    EXPECT_EQ(module->findVariable("params")->space, Space::kConst);
    EXPECT_EQ(module->findVariable("params")->size, 24u);
}

TEST(Corpus, NoPrefixOfAFileCrashes) {
    for (const auto& file : corpus()) {
        const std::string text = read(file);
        for (size_t length = 0; length < text.size(); length += 1 + text.size() / 97) {
            Diagnostics diagnostics;
            const auto module = parse(std::string_view(text).substr(0, length), diagnostics);
            EXPECT_EQ(module == nullptr, diagnostics.failed()) << file << " to " << length;
        }
    }
}

TEST(Printer, ShadowedNamesGetSuffixes) {
    const auto module = mustParseItems(".global .u32 g;\n.entry k() { .reg .b32 x, g; mov.u32 x, "
                                       "1; { .reg .b64 x; mov.u64 x, 2; } "
                                       "L: { L: bra L; } bra L; }\n");
    const std::string text = print(*module);
    EXPECT_NE(text.find("mov.u64 x$1, 2;"), std::string::npos) << text;
    EXPECT_NE(text.find(".reg .b32 x, g$1;"), std::string::npos) << text;
    EXPECT_NE(text.find("bra L$1;"), std::string::npos) << text;
    roundTrip(text, "shadowed names");
}

TEST(Printer, LiteralsKeepTheirBits) {
    const auto module = mustParseBody(
        "mov.u64 %rd1, 0x8000000000000000;\nmov.f32 %f1, 0fFFC00001;\nmov.f64 %d1, 0.1;\n"
        "mov.f32 %f1, 0.1;\nmov.u32 %r1, 0xFFFFFFFF;\nld.u32 %r1, [%rd1+-9223372036854775808];");
    const std::string text = print(*module);
    for (const char* piece : {"-9223372036854775808;", "0fFFC00001", "0d3FB999999999999A",
                              "4294967295", "[%rd1+-9223372036854775808]"})
        EXPECT_NE(text.find(piece), std::string::npos) << piece << " in\n" << text;
    roundTrip(text, "literals");
}

TEST(Printer, UsesOfEveryOperandForm) {
    roundTrip(
        kernel("setp.eq.and.s32 %p1|%p2, %r1, -5, !%p3;\nshfl.sync.up.b32 _|%p2, %r1, 1, 0, -1;\n"
               "mov.f32 %f1, %v1.w;\nvadd.s32.u32.s32 %r1, -%r2.b3, %r3.h1;\n"
               "vadd4.u32.u32.u32 %r1.b310, %r2.b7012, %r3.b0123, %r4;\n"
               "vadd2.u32.u32.u32 %r1.h10, %r2.h31, %r3, %r4;\n"
               "ld.u32 %r1, numbers[%r2+-3];\nmov.u64 %rd1, numbers[%rd2];\nmov.u64 %rd1, "
               "numbers[3];\nld.u32 %r1, [64];\ntex.1d.v4.f32.f32 {%f1,_,_,%f4}|%p1, "
               "[picture, {%f1}];\nred.add.u32 [%rd1+4], 1;\ncall (%r1, %rd1), _optix_f, "
               "(1.5, %r2, numbers, -3);"),
        "operands");
}

// Debug and sanitizer builds are some forty times slower: they use a tenth of the text and no time
// limit.
#if !defined(NDEBUG) || defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSlowBuild = true;
#elif defined(__has_feature)
constexpr bool kSlowBuild = __has_feature(address_sanitizer) || __has_feature(thread_sanitizer);
#else
constexpr bool kSlowBuild = false;
#endif

std::string largeModule(size_t functions, size_t instructionsEach) {
    std::string text = kHeader;
    for (size_t f = 0; f < functions; ++f) {
        text +=
            ".visible .entry kernel" + std::to_string(f) +
            "(.param .u64 p) {\n.reg .pred %p<9>;\n.reg .f32 %f<2000>;\n.reg .b32 %r<2000>;\n.reg "
            ".b64 %rd<99>;\n";
        for (size_t i = 0; i < instructionsEach; ++i) {
            const std::string n = std::to_string(i % 1000), m = std::to_string(i % 1000 + 1);
            switch (i % 6) {
            case 0:
                text += "\tfma.rn.ftz.f32 \t%f" + n + ", %f" + m + ", 0f3F800000, %f1;\n";
                break;
            case 1:
                text += "\tld.global.v4.u32 \t{%r1, %r2, %r3, %r" + n + "}, [%rd4+-16];\n";
                break;
            case 2:
                text += "\tsetp.lt.s32 \t%p1, %r" + n + ", 17;\n";
                break;
            case 3:
                text += "\t@%p1 bra \t$L_" + std::to_string(i) + ";\n";
                break;
            case 4:
                text += "$L_" + std::to_string(i - 1) + ":\n\tmov.u32 \t%r" + n + ", %tid.x;\n";
                break;
            default:
                text += "\tcall (%r" + n + "), _optix_get_payload, (%r" + m + ");\n";
                break;
            }
        }
        if (instructionsEach % 6 == 4) // the last branch still lacks its label
            text += "$L_" + std::to_string(instructionsEach - 1) + ":\n";
        text += "\tret;\n}\n";
    }
    return text;
}

// Processor time of this thread, so that other programs on the machine do not count.
double threadMilliseconds() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return double(time.tv_sec) * 1e3 + double(time.tv_nsec) * 1e-6;
}

double bestMilliseconds(const std::string& text) {
    double best = 1e9;
    for (int i = 0; i < (kSlowBuild ? 1 : 5); ++i) {
        const double start = threadMilliseconds();
        Diagnostics diagnostics;
        const auto module = parse(text, diagnostics);
        EXPECT_TRUE(module) << diagnostics.format();
        best = std::min(best, threadMilliseconds() - start);
    }
    return best;
}

// The limits are ten times the measured times: a busy machine passes, a quadratic step fails.
TEST(Speed, OrdinaryAndHugeModules) {
    const double small = bestMilliseconds(largeModule(1, 500));
    const double large = bestMilliseconds(largeModule(kSlowBuild ? 60 : 600, 84));
    RecordProperty("milliseconds500", std::to_string(small));
    RecordProperty("milliseconds50400", std::to_string(large));
    if (kSlowBuild)
        return;
    EXPECT_LT(small, 20);
    EXPECT_LT(large, 2000);
}

TEST(Speed, WorstCasesGrowLinearly) {
    const auto text = [](size_t n) {
        std::string body;
        for (size_t i = 0; i < n; ++i)
            body += "{ .param .b32 a; bra end; x: .reg .b32 %r1; mov.u32 %r1, %r2; bra x; }\n";
        std::string names;
        for (size_t i = 0; i < n; ++i)
            names += "bra l" + std::to_string(i) + ";\nl" + std::to_string(i) + ":\n";
        return kernel(std::string(500, '{') + body + names + std::string(500, '}') + "end: ret;");
    };
    // Thirty times the text: a quadratic step would take nine hundred times as long.
    const double one = bestMilliseconds(text(kSlowBuild ? 100 : 1000)),
                 thirty = bestMilliseconds(text(kSlowBuild ? 3000 : 30000));
    RecordProperty("millisecondsOne", std::to_string(one));
    RecordProperty("millisecondsThirty", std::to_string(thirty));
    EXPECT_LT(thirty, 300 * one + 20);
}

} // namespace
} // namespace sunstone::ptx::testing
