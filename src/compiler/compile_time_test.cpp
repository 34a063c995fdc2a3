// SPDX-License-Identifier: Apache-2.0
// Compile time of modules of ordinary size, on several threads at once, and of long functions,
// whose compile time grows with their length and not with its square.
#include "compiler/kernels/kernel_module.h"
#include "compiler/long_functions.h"
#include "compiler/testing.h"

#include <chrono>
#include <cstdio>
#include <ctime>
#include <thread>

namespace sunstone::compiler::testing {
namespace {

// A module of about `lines` instructions: closest-hit programs with branches, loops and traces of
// arithmetic, like shading code.
std::string makeModule(unsigned lines) {
    std::string text = kHeader;
    text += ".const .align 8 .b8 params[64];\n";
    for (unsigned program = 0; program * 50 < lines; ++program) {
        const std::string n = std::to_string(program);
        text += ".visible .entry __closesthit__p" + n +
                "() {\n"
                ".reg .f32 %f<64>; .reg .b32 %r<16>; .reg .b64 %rd<8>; .reg .pred %p<4>;\n"
                "call (%f0, %f1), _optix_get_triangle_barycentrics, ();\n"
                "call (%f2), _optix_get_world_ray_direction_x, ();\n"
                "ld.const.u64 %rd1, [params];\nld.const.u32 %r1, [params+8];\nmov.u32 %r2, 0;\n"
                "L0:\nmul.wide.u32 %rd2, %r2, 16;\nadd.u64 %rd3, %rd1, %rd2;\n"
                "ld.global.v4.f32 {%f3, %f4, %f5, %f6}, [%rd3];\n";
        for (unsigned i = 0; i < 30; ++i) {
            const std::string d = std::to_string(7 + i), a = std::to_string(i % 7 + i / 7),
                              b = std::to_string(3 + i);
            text += (i % 3 == 0   ? "fma.rn.f32 %f" + d + ", %f" + a + ", %f" + b + ", %f2;\n"
                     : i % 3 == 1 ? "add.ftz.f32 %f" + d + ", %f" + a + ", %f" + b + ";\n"
                                  : "max.f32 %f" + d + ", %f" + a + ", %f" + b + ";\n");
        }
        text += "setp.lt.f32 %p1, %f36, %f20;\n@%p1 mov.f32 %f2, %f36;\nadd.u32 %r2, %r2, 1;\n"
                "setp.lt.u32 %p2, %r2, %r1;\n@%p2 bra L0;\n"
                "mov.b32 %r3, %f2;\ncall _optix_set_payload, (0, %r3);\nret;\n}\n";
    }
    return text;
}

double compileMilliseconds(const std::string& text, unsigned programs) {
    const auto start = std::chrono::steady_clock::now();
    PipelineRequest request;
    request.rules.launchParams = "params";
    request.rules.optix7.numPayloadValues = 1;
    const auto module = source(text);
    inspect(module->tree(), request.rules);
    for (unsigned i = 0; i < programs; ++i)
        request.programs.push_back(
            {module, "__closesthit__p" + std::to_string(i), ProgramKind::kClosestHit});
    const auto code = compilePipeline(request);
    EXPECT_EQ(code->programs().size(), programs);
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
        .count();
}

TEST(CompileTime, FiveHundredLines) {
    const double first = compileMilliseconds(makeModule(500), 10);
    const double second = compileMilliseconds(makeModule(500), 10);
    std::printf("500 instructions, 10 programs: %.1f ms first, %.1f ms again\n", first, second);
    EXPECT_LT(std::min(first, second), 3000.0); // generous: the machine may be busy
}

TEST(CompileTime, SeveralThreads) {
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i)
        threads.emplace_back([] {
            for (int repeat = 0; repeat < 3; ++repeat)
                compileMilliseconds(makeModule(100), 2);
        });
    for (std::thread& thread : threads)
        thread.join();
}

double processorSeconds() {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return double(time.tv_sec) + double(time.tv_nsec) * 1e-9;
}

enum class Target { kProgram, kKernel, kDebugProgram, kDebugKernel };

// Returns the processor time from PTX to linked code.
double compileSeconds(Shape shape, Target target, unsigned statements) {
    const bool debug = target == Target::kDebugProgram || target == Target::kDebugKernel;
    const bool isKernel = target == Target::kKernel || target == Target::kDebugKernel;
    const LongFunction function(shape, statements, debug);
    const std::string text = isKernel ? function.kernel(debug) : function.program();
    const double start = processorSeconds();
    const auto module = parse(text);
    if (isKernel) {
        KernelOptions options;
        options.debugLevel = debugLevelOf(*module);
        const auto code = openKernels(module, options);
        code->prepare(0);
        EXPECT_TRUE(code->kernels()[0].address) << code->kernels()[0].unsupported;
    } else {
        PipelineRequest request;
        request.rules.launchParams = "params";
        inspect(*module, request.rules);
        ProgramRequest program;
        program.module = std::make_shared<const Source>(module);
        program.function = "__raygen__long";
        program.kind = ProgramKind::kRaygen;
        program.debugLevel = debug ? DebugLevel::kFull : DebugLevel::kMinimal;
        request.programs.push_back(program);
        EXPECT_TRUE(compilePipeline(request)->programs()[0].address);
    }
    return processorSeconds() - start;
}

class LongFunctions : public ::testing::TestWithParam<Shape> {};

TEST_P(LongFunctions, TakeTimeByTheirLength) {
    const Shape shape = GetParam();
    const bool heavy = shape == Shape::kLive || shape == Shape::kLoops || shape == Shape::kFlushed;
    const unsigned few = heavy ? 500 : 1500;
    constexpr double kMostRatio = 9, kMostSeconds = 4, kTooShort = 0.3;
    for (const Target target :
         {Target::kProgram, Target::kKernel, Target::kDebugProgram, Target::kDebugKernel}) {
        const bool isKernel = target == Target::kKernel || target == Target::kDebugKernel;
        if (shape == Shape::kIntrinsics && isKernel)
            continue;
        double one = 0, four = 0;
        for (int tries = 0; tries < 3; ++tries) { // the machine may be busy
            one = compileSeconds(shape, target, few);
            four = compileSeconds(shape, target, few * 4);
            if (four < kTooShort || four < std::min(kMostSeconds, one * kMostRatio))
                break;
        }
        std::printf("%s, target %d: %u statements %.2f s, %u statements %.2f s\n", nameOf(shape),
                    int(target), few, one, few * 4, four);
        EXPECT_LT(four, std::max(kTooShort, std::min(kMostSeconds, one * kMostRatio)));
    }
}

std::vector<Shape> allShapes() {
    std::vector<Shape> shapes;
    for (unsigned i = 0; i < unsigned(Shape::kCount); ++i)
        shapes.push_back(Shape(i));
    return shapes;
}

INSTANTIATE_TEST_SUITE_P(Shapes, LongFunctions, ::testing::ValuesIn(allShapes()),
                         [](const auto& info) { return nameOf(info.param); });

} // namespace
} // namespace sunstone::compiler::testing
