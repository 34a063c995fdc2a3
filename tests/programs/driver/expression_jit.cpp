// SPDX-License-Identifier: Apache-2.0
// A compiler for formulas: writes PTX with literal register numbers, a module for each formula, as
// programs with small languages of their own do.
#include "host.h"

#include <cmath>
#include <memory>
#include <string>
#include <vector>

namespace {

struct Node {
    char operation; // x y, c (constant), + - * / m (min) s (square root of the absolute value)
    float value = 0;
    std::shared_ptr<Node> left, right;
};
using Tree = std::shared_ptr<Node>;

unsigned state = 12345;
unsigned draw(unsigned limit) {
    state = state * 1664525u + 1013904223u;
    return (state >> 8) % limit;
}

Tree grow(int depth) {
    if (depth == 0 || draw(6) == 0) {
        const unsigned kind = draw(3);
        return std::make_shared<Node>(
            Node{"xyc"[kind], float(draw(64)) / 8.0f - 4.0f, nullptr, nullptr});
    }
    const char operation = "+-*/ms"[draw(6)];
    Tree left = grow(depth - 1);
    return std::make_shared<Node>(
        Node{operation, 0, left, operation == 's' ? nullptr : grow(depth - 1)});
}

float evaluate(const Node& n, float x, float y) {
    switch (n.operation) {
    case 'x':
        return x;
    case 'y':
        return y;
    case 'c':
        return n.value;
    case 's':
        return std::sqrt(std::fabs(evaluate(*n.left, x, y)));
    }
    const float a = evaluate(*n.left, x, y), b = evaluate(*n.right, x, y);
    switch (n.operation) {
    case '+':
        return a + b;
    case '-':
        return a - b;
    case '*':
        return a * b;
    case '/':
        return a / b;
    default:
        return std::fmin(a, b);
    }
}

// Appends the code of a node; returns its register.
int emit(const Node& n, std::string& code, int& next) {
    char line[128];
    if (n.operation == 'x')
        return 1;
    if (n.operation == 'y')
        return 2;
    if (n.operation == 'c') {
        unsigned bits;
        __builtin_memcpy(&bits, &n.value, 4);
        std::snprintf(line, sizeof(line), "mov.f32 %%f%d, 0f%08X;\n", next, bits);
        code += line;
        return next++;
    }
    const int a = emit(*n.left, code, next);
    if (n.operation == 's') {
        std::snprintf(line, sizeof(line), "abs.f32 %%f%d, %%f%d;\nsqrt.rn.f32 %%f%d, %%f%d;\n",
                      next, a, next + 1, next);
        code += line;
        next += 2;
        return next - 1;
    }
    const int b = emit(*n.right, code, next);
    const char* name = n.operation == '+'   ? "add.rn.f32"
                       : n.operation == '-' ? "sub.rn.f32"
                       : n.operation == '*' ? "mul.rn.f32"
                       : n.operation == '/' ? "div.rn.f32"
                                            : "min.f32";
    std::snprintf(line, sizeof(line), "%s %%f%d, %%f%d, %%f%d;\n", name, next, a, b);
    code += line;
    return next++;
}

std::string moduleOf(const Node& tree, int number) {
    std::string body;
    int next = 3;
    const int result = emit(tree, body, next);
    char head[1024];
    std::snprintf(head, sizeof(head),
                  "//\n// formula %d\n//\n.version 6.0\n.target sm_50\n.address_size 64\n"
                  ".visible .entry formula(.param .u64 out, .param .u32 width)\n{\n"
                  ".reg .f32 %%f<%d>;\n.reg .b32 %%r<6>;\n.reg .b64 %%rd<4>;\n.reg .pred %%p0;\n"
                  "mov.u32 %%r0, %%tid.x;\nmov.u32 %%r1, %%ctaid.x;\nld.param.u32 %%r2, [width];\n"
                  "setp.ge.u32 %%p0, %%r0, %%r2;\n@%%p0 bra DONE;\n"
                  "cvt.rn.f32.u32 %%f1, %%r0;\nmul.f32 %%f1, %%f1, 0f3E000000;\n"
                  "cvt.rn.f32.u32 %%f2, %%r1;\nadd.f32 %%f2, %%f2, 0fC0A00000;\n",
                  number, next);
    char tail[512];
    std::snprintf(tail, sizeof(tail),
                  "mad.lo.u32 %%r3, %%r1, %%r2, %%r0;\nld.param.u64 %%rd0, [out];\n"
                  "cvta.to.global.u64 %%rd1, %%rd0;\nmul.wide.u32 %%rd2, %%r3, 4;\n"
                  "add.s64 %%rd3, %%rd1, %%rd2;\nst.global.f32 [%%rd3], %%f%d;\nDONE:\nret;\n}\n",
                  result);
    return head + body + tail;
}

} // namespace

int main() {
    CU(cuInit(0));
    CUdevice device;
    CU(cuDeviceGet(&device, 0));
    CUcontext context;
    CU(cuDevicePrimaryCtxRetain(&context, device));
    CU(cuCtxSetCurrent(context));
    constexpr unsigned kWidth = 50, kHeight = 11;
    CUdeviceptr out;
    CU(cuMemAlloc(&out, kWidth * kHeight * sizeof(float)));
    int wrong = 0;
    for (int number = 0; number < 24; ++number) {
        const Tree tree = grow(2 + number % 6);
        CUmodule module;
        CUfunction function;
        char info[256] = "", error[256] = "";
        CUjit_option options[] = {CU_JIT_INFO_LOG_BUFFER, CU_JIT_INFO_LOG_BUFFER_SIZE_BYTES,
                                  CU_JIT_ERROR_LOG_BUFFER, CU_JIT_ERROR_LOG_BUFFER_SIZE_BYTES};
        void* values[] = {info, reinterpret_cast<void*>(sizeof(info)), error,
                          reinterpret_cast<void*>(sizeof(error))};
        CU(cuModuleLoadDataEx(&module, moduleOf(*tree, number).c_str(), 4, options, values));
        CU(cuModuleGetFunction(&function, module, "formula"));
        unsigned width = kWidth;
        void* arguments[] = {&out, &width};
        CU(cuLaunchKernel(function, kHeight, 1, 1, 64, 1, 1, 0, nullptr, arguments, nullptr));
        std::vector<float> result(kWidth * kHeight);
        CU(cuMemcpyDtoH(result.data(), out, result.size() * sizeof(float)));
        CU(cuModuleUnload(module));
        for (unsigned y = 0; y < kHeight; ++y)
            for (unsigned x = 0; x < kWidth; ++x) {
                const float expected = evaluate(*tree, float(x) * 0.125f, float(y) - 5.0f);
                const float value = result[y * kWidth + x];
                wrong += !(value == expected || (std::isnan(value) && std::isnan(expected)));
            }
    }
    CU(cuMemFree(out));
    CU(cuDevicePrimaryCtxRelease(device));
    std::printf("24 formulas, %d values wrong\n", wrong);
    return finish(wrong == 0);
}
