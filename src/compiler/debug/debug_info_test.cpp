// SPDX-License-Identifier: Apache-2.0
// Lines of compiled code, and malformed debug sections. tests/gdb checks what gdb shows.
#include "compiler/debug/dwarf.h"
#include "compiler/debug/inlined_calls.h"
#include "compiler/debug/place.h"
#include "compiler/testing.h"

#include <algorithm>
#include <random>

namespace sunstone::compiler::testing {
namespace {

const std::string kProgram = std::string(kHeader) +
                             ".file 1 \"/src/shade.cu\"\n"
                             ".visible .entry __miss__a()\n{\n"
                             "\t.local .align 4 .b8 __local_depot0[8];\n"
                             "\t.reg .b32 %r<3>; .reg .b64 %SP;\n"
                             "\t.loc 1 41 7\n"
                             "$L__begin: mov.u64 %SP, __local_depot0;\n"
                             "\t.loc 1 42 9\n"
                             "\tcall (%r1), _optix_get_launch_index_x, ();\n"
                             "\tst.volatile.u32 [%SP], %r1;\n"
                             "\t.loc 1 43 3\n"
                             "\tret;\n$L__end:\n}\n";

std::unique_ptr<Code> compile(const std::string& text, DebugLevel level, OptLevel opt) {
    PipelineRequest request;
    ProgramRequest program{source(text), "__miss__a", ProgramKind::kMiss, opt, level};
    program.moduleRules = std::make_shared<ModuleRules>();
    request.programs.push_back(program);
    return compilePipeline(request);
}

// The lines found in the first bytes of the program.
std::vector<unsigned> linesOf(const Code& code, unsigned bytes) {
    std::vector<unsigned> lines;
    const auto* begin = static_cast<const char*>(code.programs()[0].address);
    for (unsigned i = 0; i < bytes; ++i) {
        SourceLocation location;
        if (!sourceLocation(begin + i, location))
            continue;
        EXPECT_EQ("/src/shade.cu", location.file);
        if (!location.function.empty()) // line tables alone have no functions
            EXPECT_EQ("__miss__a", location.function);
        if (lines.empty() || lines.back() != location.line)
            lines.push_back(location.line);
    }
    return lines;
}

TEST(SourceLocation, LinesOfAProgram) {
    for (const DebugLevel level : {DebugLevel::kMinimal, DebugLevel::kModerate, DebugLevel::kFull})
        for (const OptLevel opt : {OptLevel::k0, OptLevel::k3}) {
            const auto code = compile(kProgram, level, opt);
            const std::vector<unsigned> lines = linesOf(*code, 24);
            EXPECT_NE(lines.end(), std::find(lines.begin(), lines.end(), 42u))
                << unsigned(level) << " " << unsigned(opt);
        }
}

// A program that runs with the processor's flush mode is split in two functions.
TEST(SourceLocation, ProgramsThatTheProcessorFlushes) {
    const std::string text =
        std::string(kHeader) +
        ".file 1 \"/src/shade.cu\"\n.const .align 8 .b8 params[8];\n"
        ".visible .entry __miss__a()\n{\n.reg .f32 %f<20>; .reg .b64 %out;\n.loc 1 42 7\n"
        "ld.const.u64 %out, [params];\nld.global.f32 %f1, [%out];\nld.global.f32 %f2, [%out+4];\n"
        "add.f32 %f3, %f1, %f2;\nst.f32 [%out+12], %f3;\n" +
        manyFlushes() + "ret;\n}\n";
    for (const DebugLevel level : {DebugLevel::kMinimal, DebugLevel::kFull})
        for (const OptLevel opt : {OptLevel::k0, OptLevel::k3})
            EXPECT_NO_THROW(compile(text, level, opt));
}

TEST(SourceLocation, NothingIsKnownOf) {
    SourceLocation location;
    EXPECT_FALSE(sourceLocation(nullptr, location));
    EXPECT_FALSE(sourceLocation(&location, location));
    EXPECT_FALSE(sourceLocation(reinterpret_cast<void*>(~uintptr_t(0)), location));
    EXPECT_TRUE(linesOf(*compile(kProgram, DebugLevel::kNone, OptLevel::k3), 16).empty());
    const std::string plain =
        std::string(kHeader) + ".visible .entry __miss__a() { ret; }\n"; // without .loc
    EXPECT_TRUE(linesOf(*compile(plain, DebugLevel::kFull, OptLevel::k3), 1).empty());
    const auto nameless = compile(plain, DebugLevel::kNone, OptLevel::k3);
    EXPECT_FALSE(sourceLocation(nameless->programs()[0].address, location));
    EXPECT_EQ(", in __miss__a", placeText(nameless->programs()[0].address)) << "its name is known";
    EXPECT_TRUE(isLoadedCode(nameless->programs()[0].address));
    EXPECT_FALSE(isLoadedCode(&location));
    EXPECT_EQ("", placeText(&location));
    const void* gone = compile(kProgram, DebugLevel::kMinimal, OptLevel::k3)->programs()[0].address;
    EXPECT_FALSE(sourceLocation(gone, location)) << "code that was freed";
}

// ---- functions inlined before the PTX was written (in gdb: tests/gdb)
// ----------------------------

TEST(InlinedCalls, WithinInlinedCalls) {
    const std::string text =
        std::string(kHeader) + ".visible .entry __miss__a()\n{\n" // kHeader has three lines
                               ".loc 1 5 9\nbar.sync 0;\n"
                               ".loc 1 30 2, function_name $A, inlined_at 1 5 9\nbar.sync 1;\n"
                               ".loc 1 40 4, function_name $B+7, inlined_at 1 30 2\nbar.sync 2;\n"
                               ".loc 1 31 2, function_name $A, inlined_at 1 5 9\nbar.sync 3;\n"
                               ".loc 1 6 1, inlined_at 1 99 9\nret;\n}\n.func f()\n{\n"
                               ".loc 1 50 4, function_name $B, inlined_at 1 30 2\nret;\n}\n";
    const auto module = parse(text);
    const InlinedCalls calls(*module);
    std::vector<uint32_t> numbers;
    for (const ptx::Function& function : module->functions)
        for (const ptx::Statement& statement : function.body)
            if (statement.kind == ptx::StatementKind::kInstruction)
                numbers.push_back(calls.at(statement.instruction.location.line));
    EXPECT_EQ((std::vector<uint32_t>{0, 1, 2, 1, 3, 4}), numbers);
    EXPECT_EQ("$A", calls.call(1).name);
    EXPECT_EQ(5u, calls.call(1).at.line);
    EXPECT_EQ(0u, calls.call(1).within);
    EXPECT_EQ("$B", calls.call(2).name);
    EXPECT_EQ(7u, calls.call(2).nameOffset);
    EXPECT_EQ(1u, calls.call(2).within);
    EXPECT_EQ(0u, calls.call(3).within) << "no such .loc";
    EXPECT_EQ("", calls.call(3).name);
    EXPECT_EQ(0u, calls.call(4).within) << ".loc of another function";
    EXPECT_EQ(0u, calls.at(0));
}

// Inlined calls that contain themselves; text cut at any byte.
TEST(InlinedCalls, Nonsense) {
    std::string text = std::string(kHeader) + ".file 1 \"/src/shade.cu\"\n"
                                              ".visible .entry __miss__a()\n{\n";
    for (int i = 0; i < 500; ++i)
        text += ".loc 1 5 9, function_name $A, inlined_at 1 5 9\nbar.warp.sync 0;\n";
    const auto module = parse(text + "ret;\n}\n");
    const InlinedCalls calls(*module);
    for (uint32_t line = 0; line < 1100; ++line)
        if (const uint32_t call = calls.at(line))
            EXPECT_LE(calls.call(call).depth, 64u);
    for (const char* end : {".loc", ".loc 1", ".loc 1 2 3, inlined_at", ".loc 1 2 3, function_name",
                            ".loc 1 2 3, function_name $A+, inlined_at 9999999999999 x -1"}) {
        ptx::Module broken;
        broken.text = std::string("inlined_at\n") + end;
        EXPECT_LE(InlinedCalls(broken).at(5), 1u);
    }
}

TEST(SourceLocation, InlinedFunctions) {
    const std::string text =
        std::string(kHeader) +
        ".file 1 \"/src/shade.cu\"\n.visible .entry __miss__a()\n{\n"
        ".local .align 4 .b8 depot[8];\n.reg .b32 %r<3>; .reg .b64 %SP;\n"
        ".loc 1 41 7\nmov.u64 %SP, depot;\n"
        ".loc 1 20 3, function_name $outer, inlined_at 1 41 7\n"
        "call (%r1), _optix_get_launch_index_x, ();\n"
        ".loc 1 10 3, function_name $names+2, inlined_at 1 20 3\n"
        "st.volatile.u32 [%SP], %r1;\n.loc 1 43 3\nret;\n}\n"
        ".section .debug_str {\n$names: .b8 65,0, 105,110,110,101,114,0\n" // A, inner
        "$outer: .b8 95,90,53,111,117,116,101,114,106,0\n}\n";             // _Z5outerj
    EXPECT_EQ("inner", debugString(*parse(text), "$names", 2));
    EXPECT_EQ("", debugString(*parse(text), "$nowhere", 0));
    for (const DebugLevel level : {DebugLevel::kMinimal, DebugLevel::kModerate, DebugLevel::kFull})
        for (const OptLevel opt : {OptLevel::k0, OptLevel::k3}) {
            SCOPED_TRACE(message(unsigned(level), " ", unsigned(opt)));
            const auto code = compile(text, level, opt);
            const auto* begin = static_cast<const char*>(code->programs()[0].address);
            bool seen = false;
            for (unsigned i = 0; i < 64; ++i) {
                SourceLocation location;
                if (!sourceLocation(begin + i, location) || location.line != 10)
                    continue;
                seen = true;
                EXPECT_EQ("/src/shade.cu", location.file);
                EXPECT_EQ("__miss__a", location.function) << "the program, not what is inlined";
            }
            EXPECT_TRUE(seen);
        }
}

// The device functions of the API are inlined from its headers.
TEST(SourceLocation, OfApplicationsAndNotOfHeaders) {
    const std::string text =
        std::string(kHeader) +
        ".file 1 \"/src/shade.cu\"\n.file 2 \"/sdk/internal/optix_7_device_impl.h\"\n"
        ".visible .entry __miss__a()\n{\n.local .align 4 .b8 depot[8];\n"
        ".reg .b32 %r<3>; .reg .b64 %SP;\nmov.u64 %SP, depot;\n"
        ".loc 2 366 5, function_name $names, inlined_at 1 41 7\n"
        "call (%r1), _optix_get_launch_index_x, ();\nst.volatile.u32 [%SP], %r1;\n"
        ".loc 1 43 3\nret;\n}\n.section .debug_str {\n$names: .b8 65,0\n}\n";
    const std::vector<unsigned> lines =
        linesOf(*compile(text, DebugLevel::kMinimal, OptLevel::k3), 64);
    EXPECT_TRUE(std::ranges::count(lines, 41u)) << "the call in the application";
    EXPECT_FALSE(std::ranges::count(lines, 366u));
}

// One unit, one function with a variable of type int in the depot.
const char* const kSections = R"(
.section .debug_abbrev
{
.b8 1, 17, 1, 0, 0
.b8 2, 46, 1, 135, 64, 8, 3, 8, 17, 1, 18, 1, 0, 0
.b8 3, 52, 0, 2, 10, 3, 8, 58, 11, 59, 11, 73, 19, 0, 0
.b8 4, 36, 0, 3, 8, 62, 11, 11, 11, 0, 0
.b8 0
}
.section .debug_info
{
.b32 74 // length
.b8 2
.b8 0
.b32 .debug_abbrev
.b8 8
.b8 1
.b8 4, 105, 110, 116, 0, 5, 4 // int at 12
.b8 2, 95, 95, 109, 105, 115, 115, 95, 95, 97, 0, 109, 105, 115, 115, 0
.b64 $L__begin
.b64 $L__end
.b8 3, 11, 3
.b64 __local_depot0
.b8 35, 4
.b8 99, 111, 117, 110, 116, 0, 1, 42
.b32 12
.b8 0
.b8 0
}
)";

TEST(Dwarf, VariableInADepot) {
    const auto module = parse(kProgram + kSections);
    const DwarfInfo info = readDwarf(*module);
    ASSERT_EQ(1u, info.functions.count("__miss__a"));
    const DwarfFunction& function = info.functions.at("__miss__a");
    EXPECT_EQ("miss", function.name);
    ASSERT_EQ(1u, function.scope.variables.size());
    const DwarfVariable& variable = function.scope.variables[0];
    EXPECT_EQ("count", variable.name);
    EXPECT_EQ(42u, variable.line);
    ASSERT_EQ(1u, variable.places.size());
    EXPECT_EQ("__local_depot0", variable.places[0].name);
    EXPECT_EQ(4u, variable.places[0].offset);
    ASSERT_EQ(1u, info.types.count(variable.type));
    EXPECT_EQ("int", info.types.at(variable.type).name);
    EXPECT_EQ(4u, info.types.at(variable.type).size);
    compile(kProgram + kSections, DebugLevel::kFull, OptLevel::k0);
}

TEST(Dwarf, NonsenseDoesNoHarm) {
    const unsigned seed = std::random_device()();
    SCOPED_TRACE(message("seed ", seed));
    std::mt19937 random(seed);
    const std::string sections = kSections;
    const std::string digits = "0123456789";
    for (unsigned round = 0; round < 300; ++round) {
        std::string damaged = sections;
        for (unsigned i = 0; i < 1 + round % 8; ++i) {
            const size_t at = random() % damaged.size();
            if (isdigit(uint8_t(damaged[at])))
                damaged[at] = digits[random() % digits.size()];
        }
        ptx::Diagnostics diagnostics;
        if (const auto module = ptx::parse(kProgram + damaged, diagnostics)) {
            readDwarf(*module);
            if (round % 10 == 0)
                compile(kProgram + damaged, DebugLevel::kFull, OptLevel::k0);
        }
    }
    for (const char* text : {".section .debug_info { }", ".section .debug_info { .b8 }",
                             ".section .debug_info { .b32 4294967295 .b8 2 }",
                             ".section .debug_info { rubbish }"}) {
        ptx::Diagnostics diagnostics;
        if (const auto module = ptx::parse(kProgram + text, diagnostics))
            EXPECT_TRUE(readDwarf(*module).functions.empty());
    }
}

// Two functions with the name "call" in one file, as overloads and call operators have. The first
// call lists only one of the function's parameters.
const char* const kCalls = R"(
.file 1 "/src/shade.cu"
.visible .entry __miss__a()
{
.local .align 8 .b8 __local_depot0[16];
.reg .b32 %r<4>; .reg .b64 %SP;
.loc 1 42 9
$L__0: mov.u64 %SP, __local_depot0;
.loc 1 2 1
$L__1: call (%r1), _optix_get_launch_index_x, (); st.volatile.u32 [%SP], %r1;
$L__2: call (%r2), _optix_get_launch_index_y, (); st.volatile.u32 [%SP], %r2;
.loc 1 3 1
$L__3: call (%r3), _optix_get_launch_index_z, (); st.volatile.u32 [%SP], %r3;
.loc 1 43 3
$L__4: ret;
$L__5:
}
.section .debug_abbrev
{
.b8 1, 17, 1, 0, 0
.b8 2, 46, 1, 3, 8, 58, 11, 59, 11, 0, 0 // function: name, file, line
.b8 3, 5, 0, 3, 8, 59, 11, 73, 19, 0, 0 // parameter: name, line, type
.b8 4, 36, 0, 3, 8, 62, 11, 11, 11, 0, 0 // type: name, encoding, size
.b8 5, 46, 1, 3, 8, 17, 1, 18, 1, 0, 0 // function: name, begin, end
.b8 6, 29, 1, 49, 19, 17, 1, 18, 1, 88, 11, 89, 11, 0, 0 // call: function, begin, end, file, line
.b8 7, 5, 0, 2, 10, 49, 19, 0, 0 // parameter: place, declaration
.b8 0
}
.section .debug_info
{
.b32 247 // length
.b8 2, 0
.b32 .debug_abbrev
.b8 8
.b8 1
.b8 4, 105, 110, 116, 0, 5, 4 // int at 12
.b8 2, 99, 97, 108, 108, 0, 1, 2 // call at 19
.b8 3, 116, 104, 105, 115, 0, 0 // this at 27
.b32 12
.b8 3, 97, 0, 2 // a at 38
.b32 12
.b8 0
.b8 2, 99, 97, 108, 108, 0, 1, 3 // call at 47
.b8 3, 116, 104, 105, 115, 0, 0 // this at 55
.b32 12
.b8 3, 98, 0, 3 // b at 66
.b32 12
.b8 0
.b8 5, 95, 95, 109, 105, 115, 115, 95, 95, 97, 0
.b64 $L__0
.b64 $L__5
.b8 6
.b32 19
.b64 $L__1
.b64 $L__2
.b8 1, 42
.b8 7, 9, 3
.b64 __local_depot0
.b32 38
.b8 0
.b8 6
.b32 19
.b64 $L__2
.b64 $L__3
.b8 1, 42
.b8 7, 9, 3
.b64 __local_depot0
.b32 27
.b8 7, 9, 3
.b64 __local_depot0
.b32 38
.b8 0
.b8 6
.b32 47
.b64 $L__3
.b64 $L__4
.b8 1, 42
.b8 7, 9, 3
.b64 __local_depot0
.b32 55
.b8 7, 9, 3
.b64 __local_depot0
.b32 66
.b8 0
.b8 0
.b8 0
}
)";

TEST(Dwarf, InlinedFunctionsOfOneName) {
    const std::string text = std::string(kHeader) + kCalls;
    const DwarfInfo info = readDwarf(*parse(text));
    ASSERT_EQ(1u, info.functions.count("__miss__a"));
    const std::vector<DwarfScope>& calls = info.functions.at("__miss__a").scope.scopes;
    ASSERT_EQ(3u, calls.size());
    std::vector<std::string> parameters;
    for (const DwarfScope& call : calls) {
        ASSERT_TRUE(call.inlined);
        EXPECT_EQ("call", call.inlined->name);
        for (const DwarfVariable& variable : call.variables)
            parameters.push_back(variable.name);
    }
    EXPECT_EQ((std::vector<std::string>{"a", "this", "a", "this", "b"}), parameters);
    EXPECT_EQ(calls[0].inlined->origin, calls[1].inlined->origin);
    EXPECT_NE(calls[0].inlined->origin, calls[2].inlined->origin);
    for (const OptLevel opt : {OptLevel::k0, OptLevel::k3}) {
        const std::vector<unsigned> lines = linesOf(*compile(text, DebugLevel::kFull, opt), 256);
        for (const unsigned line : {2u, 3u})
            EXPECT_NE(lines.end(), std::find(lines.begin(), lines.end(), line)) << unsigned(opt);
    }
}

// A function with two references to its own definition: missing attributes are searched twice at
// every step.
TEST(Dwarf, EntriesThatLeadToThemselvesEnd) {
    const auto module = parse(kProgram + std::string(R"(
.section .debug_abbrev
{
.b8 1, 17, 1, 0, 0
.b8 2, 46, 0, 17, 1, 49, 19, 71, 19, 0, 0
.b8 0
}
.section .debug_info
{
.b32 26 // length
.b8 2
.b8 0
.b32 .debug_abbrev
.b8 8
.b8 1
.b8 2
.b64 $L__begin
.b32 12
.b32 12
.b8 0
}
)"));
    EXPECT_EQ(1u, readDwarf(*module).functions.size());
}

} // namespace
} // namespace sunstone::compiler::testing
