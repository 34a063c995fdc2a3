// SPDX-License-Identifier: Apache-2.0
// Operands of instructions against an assembler's text, and of instructions that fault.
#include "base/faults.h"
#include "base/x86_operand.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace sunstone {
namespace {

#ifdef __x86_64__

// Registers of distinct values; rsp at a stack whose top is kTarget.
constexpr uint64_t kTarget = 0x4242424242424242u;
const uint64_t kStack[1] = {kTarget};
uint64_t valueOf(unsigned number) {
    return number == 4 ? uint64_t(kStack) : 0x1111000000000000u * number + 0x100000u * number;
}

struct Form {
    const char* text; // as an assembler reads it
    std::vector<uint8_t> bytes;
    bool isKnown;
    uint64_t address;
};

std::vector<Form> forms() {
    const auto r = valueOf;
    enum { rax, rcx, rdx, rbx, rsp, rbp, rsi, rdi, r8, r9, r10, r11, r12, r13, r14, r15 };
    return {
        {"mov dword ptr [rax], 1", {0xC7, 0x00, 1, 0, 0, 0}, true, r(rax)},
        {"mov ecx, [rbx + 8]", {0x8B, 0x4B, 0x08}, true, r(rbx) + 8},
        {"mov rcx, [r12 - 128]", {0x49, 0x8B, 0x4C, 0x24, 0x80}, true, r(r12) - 128},
        {"mov rcx, [r13]", {0x49, 0x8B, 0x4D, 0x00}, true, r(r13)},
        {"mov eax, [rdx + 4*rsi + 256]",
         {0x8B, 0x84, 0xB2, 0, 1, 0, 0},
         true,
         r(rdx) + 4 * r(rsi) + 256},
        {"mov eax, [8*r9 + 16]", {0x42, 0x8B, 0x04, 0xCD, 16, 0, 0, 0}, true, 8 * r(r9) + 16},
        {"lock inc dword ptr [r8 + r15]", {0xF0, 0x43, 0xFF, 0x04, 0x38}, true, r(r8) + r(r15)},
        {"cmpxchg [rdi], ecx", {0x0F, 0xB1, 0x0F}, true, r(rdi)},
        {"movzx eax, byte ptr [rcx + 1]", {0x0F, 0xB6, 0x41, 0x01}, true, r(rcx) + 1},
        {"prefetcht0 [rbp]", {0x0F, 0x18, 0x4D, 0x00}, true, r(rbp)},
        {"movups xmm0, [rsi + rdi]", {0x0F, 0x10, 0x04, 0x3E}, true, r(rsi) + r(rdi)},
        {"movsd [r10 + 8], xmm1", {0xF2, 0x41, 0x0F, 0x11, 0x4A, 0x08}, true, r(r10) + 8},
        {"pshufb xmm0, [r11]", {0x66, 0x41, 0x0F, 0x38, 0x00, 0x03}, true, r(r11)},
        {"vmovups ymm0, [rax + 32]", {0xC5, 0xFC, 0x10, 0x40, 0x20}, true, r(rax) + 32},
        {"vfmadd213ss xmm0, xmm1, [r9 + 4]", {0xC4, 0xC2, 0x71, 0xA9, 0x41, 0x04}, true, r(r9) + 4},
        {"vmovups zmm16, [rax + 64]",
         {0x62, 0xE1, 0x7C, 0x48, 0x10, 0x40, 0x01},
         true,
         r(rax) + 64},
        {"vmovss xmm16, [rcx + 8]", {0x62, 0xE1, 0x7E, 0x08, 0x10, 0x41, 0x02}, true, r(rcx) + 8},
        {"vaddps zmm0, zmm1, [rdx + 4] {1to16}",
         {0x62, 0xF1, 0x74, 0x58, 0x58, 0x42, 0x01},
         true,
         r(rdx) + 4},
        {"vgatherdps ymm0, [rax + 4*ymm1], ymm2", {0xC4, 0xE2, 0x6D, 0x92, 0x04, 0x88}, false, 0},
        {"mov eax, fs:[rax]", {0x64, 0x8B, 0x00}, false, 0},
        {"mov eax, [rip + 16]", {0x8B, 0x05, 16, 0, 0, 0}, false, 0},
        {"add eax, ecx", {0x01, 0xC8}, false, 0},
        {"ud2", {0x0F, 0x0B}, false, 0},
        {"movabs al, [0x1122334455667788]",
         {0xA0, 0x88, 0x77, 0x66, 0x55, 0x44, 0x33, 0x22, 0x11},
         true,
         0x1122334455667788u},
        {"rep stosb", {0xF3, 0xAA}, true, r(rdi)},
        {"rep movsb", {0xF3, 0xA4}, true, r(rsi)}, // rsi is not canonical
        {"push rax", {0x50}, true, r(rsp)},
        {"ret", {0xC3}, true, kTarget},
        {"call rdx", {0xFF, 0xD2}, true, r(rdx)},
        {"jmp r8", {0x41, 0xFF, 0xE0}, true, r(r8)},
        {"jmp [rsp]", {0xFF, 0x24, 0x24}, true, kTarget},
    };
}

TEST(X86Operand, OfEveryForm) {
    X86Registers registers;
    for (unsigned i = 0; i < 16; ++i)
        registers[i] = valueOf(i);
    for (const Form& form : forms()) {
        SCOPED_TRACE(form.text);
        std::vector<uint8_t> bytes = form.bytes;
        bytes.resize(16, 0x90);
        uint64_t address = 0;
        ASSERT_EQ(form.isKnown, accessedAddress(bytes.data(), registers, address));
        if (form.isKnown)
            EXPECT_EQ(form.address, address);
    }
}

TEST(X86Operand, CanonicalAddresses) {
    for (const unsigned long long yes : {0ull, 0x7FFFFFFFFFFFull, 0xFFFF800000000000ull, ~0ull})
        EXPECT_TRUE(isCanonical(yes)) << yes;
    for (const unsigned long long no :
         {0x800000000000ull, 0xFFFF7FFFFFFFFFFFull, 0xDEAD000000000000ull})
        EXPECT_FALSE(isCanonical(no)) << no;
}

// The processor reports address 0 for these.
TEST(X86Operand, ReportsOfFaults) {
    if (!handlesFaults())
        GTEST_SKIP() << "a sanitizer reports faults";
    static constexpr uint64_t kWild = 0xDEAD000000000010u;
    const auto report = [](void (*body)()) {
        FaultFrame frame;
        EXPECT_FALSE(runFaultable(frame, body));
        return describeFault(frame);
    };
    const auto hasWild = [](const std::string& text) {
        return text.find("invalid memory access to address 0xdead000000000010") !=
               std::string::npos;
    };
    std::string text = report([] { asm volatile("movl $1, (%0)" ::"r"(kWild) : "memory"); });
    EXPECT_TRUE(hasWild(text)) << text;
    text = report([] {
        asm volatile("movups -8(%0,%1,4), %%xmm0" ::"r"(kWild - 8), "r"(uint64_t(4)) : "xmm0");
    });
    EXPECT_TRUE(hasWild(text)) << text;
    text = report([] {
        asm volatile(
            "movq %%rbp, %%r12; movq %0, %%rbp; movl (%%rbp), %%eax; movq %%r12, %%rbp" ::"r"(kWild)
            : "r12", "eax");
    });
    EXPECT_TRUE(hasWild(text)) << "a fault of the stack segment: " << text;
    text = report([] { asm volatile("jmp *%0" ::"r"(kWild)); });
    EXPECT_TRUE(hasWild(text)) << text;
    alignas(16) static char memory[32];
    text = report([] { asm volatile("movaps %%xmm0, (%0)" ::"r"(memory + 4) : "memory"); });
    EXPECT_NE(std::string::npos, text.find("misaligned memory access")) << text;
}

#endif

} // namespace
} // namespace sunstone
