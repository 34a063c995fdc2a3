// SPDX-License-Identifier: Apache-2.0
// For tests and benchmarks of compile time: PTX of long functions of several shapes that code
// generators produce. A statement is an instruction, or the few that make up one construct.
#pragma once

#include <cstdint>
#include <string>

namespace sunstone::compiler::testing {

enum class Shape : uint8_t {
    kArithmetic, // one block; few values live
    kFlushed,    // the same with .ftz
    kLive,       // one block; every value is used again at the end
    kMemory,     // loads and stores of one buffer, between arithmetic
    kTables,     // stores of sums of loads from another buffer
    kLocals,     // variables in local memory, as -O0 writes them
    kBranches,   // short branches one after another
    kGuards,     // guarded instructions
    kLoops,      // loops one after another
    kCalls,      // calls of functions of the module
    kIntrinsics, // calls of OptiX functions, for programs alone
    kCount,
};

inline const char* nameOf(Shape shape) {
    constexpr const char* kNames[] = {"arithmetic", "flushed", "live",      "memory",
                                      "tables",     "locals",  "branches",  "guards",
                                      "loops",      "calls",   "intrinsics"};
    return kNames[size_t(shape)];
}

// Writes functions; `lines` adds a .loc directive to each statement.
class LongFunction {
public:
    LongFunction(Shape shape, unsigned statements, bool lines)
        : shape_(shape), statements_(statements), lines_(lines) {}

    // A module with a kernel "long_kernel", whose parameter is the address of a buffer, or with a
    // program "__raygen__long", which reads the address from the launch parameters "params".
    std::string kernel(bool debug = false) const {
        return header(debug) + ".visible .entry long_kernel(.param .u64 p) {\n" + registers() +
               "ld.param.u64 %p, [p];\n" + body() + "}\n";
    }
    std::string program() const {
        return header(false) +
               ".const .align 8 .b8 params[8];\n.visible .entry __raygen__long() {\n" +
               registers() + "ld.const.u64 %p, [params];\n" + body() + "}\n";
    }

private:
    static std::string text(unsigned number) { return std::to_string(number); }

    std::string header(bool debug) const {
        std::string out = std::string(".version 7.8\n.target sm_75") + (debug ? ", debug" : "") +
                          "\n.address_size 64\n";
        if (lines_)
            out += ".file 1 \"long.cu\"\n";
        if (shape_ == Shape::kCalls)
            for (unsigned i = 0; i < statements_ / 100 + 1; ++i)
                out +=
                    ".func (.param .f32 r) f" + text(i) +
                    "(.param .f32 a, .param .f32 b) {\n.reg .f32 %a, %b;\nld.param.f32 %a, [a];\n"
                    "ld.param.f32 %b, [b];\nfma.rn.f32 %a, %a, %b, 0f3F80" +
                    (i % 2 ? "0000" : "1000") + ";\nst.param.f32 [r], %a;\nret;\n}\n";
        return out;
    }
    std::string registers() const {
        const std::string count = text(statements_ + 20);
        return ".reg .f32 %f<" + count + ">; .reg .b32 %r<" + count + ">; .reg .b64 %p, %l, %rd<" +
               count + ">; .reg .f64 %d<" + count + ">; .reg .pred %c<" + count +
               ">;\n.local .align 8 .b8 depot[" + text(8 * statements_ + 64) + "];\n";
    }
    std::string body() const {
        std::string out = "ld.global.f32 %f0, [%p]; ld.global.f32 %f1, [%p+4];\n"
                          "ld.global.u32 %r0, [%p+8]; ld.global.u32 %r1, [%p+12];\n"
                          "ld.global.f64 %d0, [%p+16]; ld.global.f64 %d1, [%p+24];\n"
                          "ld.global.u64 %rd0, [%p+32]; mov.u64 %l, depot;\n";
        for (unsigned i = 2; i < statements_ + 2; ++i) {
            if (lines_)
                out += ".loc 1 " + text(i) + " 3\n";
            statement(out, i);
        }
        if (shape_ == Shape::kLive)
            for (unsigned i = statements_; i-- > 2;)
                out += "add.f32 %f" + text(statements_ + 2) + ", %f" + text(i) + ", %f" +
                       text(i + 1 == statements_ ? i + 1 : statements_ + 2) + ";\n";
        const std::string last = text(statements_ + (shape_ == Shape::kLive ? 2 : 1));
        return out + "st.global.f32 [%p+40], %f" + last + ";\nret;\n";
    }

    void statement(std::string& out, unsigned i) const {
        const std::string d = text(i), a = text(i - 1), b = text(i - 2);
        const std::string ftz = shape_ == Shape::kFlushed ? ".ftz" : "";
        const std::string sum = "add" + ftz + ".f32 %f" + d + ", %f" + a + ", %f" + b + ";\n";
        switch (shape_) {
        case Shape::kArithmetic:
        case Shape::kFlushed:
        case Shape::kLive:
            return arithmetic(out, i, ftz);
        case Shape::kMemory:
            if (i % 4 == 0)
                out += "ld.global.f32 %f" + d + ", [%p+" + text(64 + i * 4) + "];\n";
            else if (i % 4 == 3)
                out += sum + "st.global.f32 [%p+" + text(64 + i * 4) + "], %f" + d + ";\n";
            else
                out += sum;
            return;
        case Shape::kTables:
            out += "ld.global.f32 %f" + d + ", [%rd0+" + text(i * 4) + "];\nadd.f32 %f" + d +
                   ", %f" + d + ", %f" + a + ";\nst.global.f32 [%p+" + text(64 + i * 4) + "], %f" +
                   d + ";\n";
            return;
        case Shape::kLocals:
            out += i < 4 ? sum
                         : "ld.local.f32 %f" + d + ", [%l+" + text((i - 1) * 8) + "];\n" +
                               "add.f32 %f" + d + ", %f" + d + ", %f1;\n";
            out += "st.local.f32 [%l+" + text(i * 8) + "], %f" + d + ";\n";
            return;
        case Shape::kBranches:
            out += "setp.lt.f32 %c" + d + ", %f" + a + ", %f" + b + ";\nmov.f32 %f" + d + ", %f" +
                   a + ";\n@%c" + d + " bra L" + d + ";\nmul.f32 %f" + d + ", %f" + a + ", %f" + b +
                   ";\nL" + d + ":\n";
            return;
        case Shape::kGuards:
            out += "setp.lt.f32 %c" + d + ", %f" + a + ", %f" + b + ";\nmov.f32 %f" + d + ", %f" +
                   a + ";\n@%c" + d + " fma.rn.f32 %f" + d + ", %f" + a + ", %f" + b + ", %f" + a +
                   ";\n";
            return;
        case Shape::kLoops:
            out += "mov.u32 %r" + d + ", 0;\nmov.f32 %f" + d + ", %f" + a + ";\nL" + d +
                   ":\nfma.rn.f32 %f" + d + ", %f" + d + ", %f" + b + ", %f1;\nadd.u32 %r" + d +
                   ", %r" + d + ", 1;\nsetp.lt.u32 %c" + d + ", %r" + d + ", %r0;\n@%c" + d +
                   " bra L" + d + ";\n";
            return;
        case Shape::kCalls:
            out += "{ .param .f32 a; .param .f32 b; .param .f32 r;\nst.param.f32 [a], %f" + a +
                   ";\nst.param.f32 [b], %f" + b + ";\ncall.uni (r), f" +
                   text(i * 7 % (statements_ / 100 + 1)) + ", (a, b);\nld.param.f32 %f" + d +
                   ", [r]; }\n";
            return;
        default:
            out += "call (%r" + d + "), _optix_get_launch_index_x, ();\ncvt.rn.f32.u32 %f" + d +
                   ", %r" + d + ";\nadd.f32 %f" + d + ", %f" + d + ", %f" + a + ";\n";
        }
    }

    static void arithmetic(std::string& out, unsigned i, const std::string& ftz) {
        const std::string d = text(i), a = text(i - 1), b = text(i - 2);
        switch (i % 8) {
        case 0:
            out += "fma.rn" + ftz + ".f32 %f" + d + ", %f" + a + ", %f" + b + ", %f" + a + ";\n";
            break;
        case 1:
            out += "max" + ftz + ".f32 %f" + d + ", %f" + a + ", %f" + b + ";\n";
            break;
        case 2:
            out += "mul" + ftz + ".f32 %f" + d + ", %f" + a + ", %f0;\n";
            break;
        case 3: // through an integer
            out += "mov.b32 %r" + d + ", %f" + a + ";\nxor.b32 %r" + d + ", %r" + d +
                   ", %r0;\nmov.b32 %f" + d + ", %r" + d + ";\n";
            break;
        case 4: // through a double
            out += "cvt" + ftz + ".f64.f32 %d" + d + ", %f" + a + ";\nfma.rn.f64 %d" + d + ", %d" +
                   d + ", %d0, %d1;\n" + "cvt.rn" + ftz + ".f32.f64 %f" + d + ", %d" + d + ";\n";
            break;
        case 5:
            out += "div.rn" + ftz + ".f32 %f" + d + ", %f" + a + ", %f1;\n";
            break;
        case 6:
            out += "setp.lt" + ftz + ".f32 %c" + d + ", %f" + a + ", %f" + b + ";\nselp.f32 %f" +
                   d + ", %f" + a + ", %f0, %c" + d + ";\n";
            break;
        default:
            out += "add" + ftz + ".f32 %f" + d + ", %f" + a + ", %f" + b + ";\n";
        }
    }

    Shape shape_;
    unsigned statements_;
    bool lines_;
};

} // namespace sunstone::compiler::testing
