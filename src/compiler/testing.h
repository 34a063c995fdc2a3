// SPDX-License-Identifier: Apache-2.0
// Runs short PTX texts, for tests of the compiler. A case is one or more instructions, up to four
// 64-bit inputs and the expected value of the result register. All cases of a table become kernels
// of one module. Inputs are in %rd1.. and, truncated, in %r1.. %rs1.. %f1.. %fd1.. %p1.. The result
// register is number 0 of the class in `result`: r, d (%rd), s (%rs), f, F (%fd), p.
#pragma once

#include "base/error.h"
#include "compiler/compiler.h"
#include "ptx/parse/parser.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

namespace sunstone::compiler::testing {

constexpr const char* kHeader = ".version 7.8\n.target sm_75\n.address_size 64\n";

inline std::shared_ptr<const ptx::Module> parse(const std::string& text) {
    ptx::Diagnostics diagnostics;
    std::shared_ptr<const ptx::Module> module = ptx::parse(text, diagnostics);
    if (!module)
        throw Error(sunstone::Code::kInvalidPtx, diagnostics.format() + "\n" + text);
    return module;
}

inline std::shared_ptr<const Source> source(const std::string& text) {
    return std::make_shared<const Source>(parse(text));
}

struct Case {
    const char* text;
    std::vector<uint64_t> inputs;
    char result;
    uint64_t expected;
};

inline uint64_t bits(float value) {
    return std::bit_cast<uint32_t>(value);
}
inline uint64_t bits(double value) {
    return std::bit_cast<uint64_t>(value);
}

// Enough .ftz arithmetic to make the kernel run with results flushed by the processor (flush.h).
constexpr unsigned kManyFlushes = 60;
inline std::string manyFlushes() {
    std::string text = "mov.f32 %f18, %f1; mov.f32 %f19, %f2;\n";
    for (unsigned i = 0; i < kManyFlushes; ++i)
        text += "fma.rn.ftz.f32 %f19, %f19, %f18, %f18;\n";
    return text + "st.f32 [%out+8], %f19;\n";
}

inline std::string kernelOf(const Case& test, size_t number, bool flushed) {
    std::string text = ".visible .entry k" + std::to_string(number) +
                       "(.param .u64 p0, .param .u64 p1) {\n"
                       ".reg .b32 %r<20>; .reg .b64 %rd<20>; .reg .b16 %rs<20>; .reg .f32 %f<20>;\n"
                       ".reg .f64 %fd<20>; .reg .pred %p<20>; .reg .b64 %in, %out;\n"
                       "ld.param.u64 %in, [p0]; ld.param.u64 %out, [p1];\n";
    for (size_t i = 1; i <= test.inputs.size(); ++i) {
        const std::string n = std::to_string(i);
        text += "ld.u64 %rd" + n + ", [%in+" + std::to_string((i - 1) * 8) + "];\n";
        text += "cvt.u32.u64 %r" + n + ", %rd" + n + "; cvt.u16.u64 %rs" + n + ", %rd" + n + ";\n";
        text += "mov.b32 %f" + n + ", %r" + n + "; mov.b64 %fd" + n + ", %rd" + n + ";\n";
        text += "setp.ne.u32 %p" + n + ", %r" + n + ", 0;\n";
    }
    if (flushed)
        text += manyFlushes();
    text += std::string(test.text) + "\n";
    switch (test.result) {
    case 'r':
        text += "st.u32 [%out], %r0;";
        break;
    case 'd':
        text += "st.u64 [%out], %rd0;";
        break;
    case 's':
        text += "st.u16 [%out], %rs0;";
        break;
    case 'f':
        text += "st.f32 [%out], %f0;";
        break;
    case 'F':
        text += "st.f64 [%out], %fd0;";
        break;
    case 'p':
        text += "selp.u32 %r0, 1, 0, %p0; st.u32 [%out], %r0;";
        break;
    }
    return text + "\nret;\n}\n";
}

inline bool isNan(char type, uint64_t value) {
    return type == 'f' ? std::isnan(std::bit_cast<float>(uint32_t(value)))
                       : type == 'F' && std::isnan(std::bit_cast<double>(value));
}

// Compares bits; any NaN equals any NaN. flushed: adds other .ftz arithmetic, so that the kernel
// runs in flush mode.
inline void run(const std::vector<Case>& cases, bool flushed) {
    std::string text = kHeader;
    for (size_t i = 0; i < cases.size(); ++i)
        text += kernelOf(cases[i], i, flushed);
    std::unique_ptr<KernelCode> code;
    try {
        code = compileKernels(parse(text));
    } catch (const Error& error) {
        FAIL() << error.what();
    }
    ASSERT_EQ(code->kernels().size(), cases.size());
    for (size_t i = 0; i < cases.size(); ++i) {
        const KernelInfo& kernel = code->kernels()[i];
        ASSERT_TRUE(kernel.address) << cases[i].text << ": " << kernel.unsupported;
        std::vector<uint64_t> inputs = cases[i].inputs;
        inputs.resize(4);
        uint64_t results[2] = {};
        const void* parameters[2] = {inputs.data(), results};
        devlib::KernelThread thread{};
        reinterpret_cast<devlib::KernelFn>(const_cast<void*>(kernel.address))(&thread, parameters);
        const uint64_t out = results[0];
        if (isNan(cases[i].result, cases[i].expected) && isNan(cases[i].result, out))
            continue;
        EXPECT_EQ(out, cases[i].expected)
            << cases[i].text << std::hex << " inputs " << inputs[0] << " " << inputs[1] << " "
            << inputs[2] << " " << inputs[3] << ": got " << out << ", want " << cases[i].expected
            << (flushed ? " (flushed by the processor)" : "");
    }
}

inline void run(const std::vector<Case>& cases) {
    run(cases, false);
    run(cases, true);
}

} // namespace sunstone::compiler::testing
