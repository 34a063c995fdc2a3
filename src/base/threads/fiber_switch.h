// SPDX-License-Identifier: Apache-2.0
// Switches between the stacks of a thread. The compiler saves only the registers in use that a
// function must preserve, so a switch takes a few cycles. Its jump has one target, which the
// processor predicts. The floating-point modes stay those of the thread.
#pragma once

#include "base/inline.h"

#include <cstdint>

namespace sunstone {

// The stack pointer of a suspended fiber. Its next instruction's address is on top of its stack.
using FiberContext = void*;

// A fiber that starts at `entry`, which never returns. `stackTop`: the end of its stack.
inline FiberContext makeFiber(void* stackTop, void (*entry)()) {
    auto* const top = reinterpret_cast<uint64_t*>(reinterpret_cast<uint64_t>(stackTop) & ~15ull);
    top[-1] = 0; // the return address at which unwinders stop
    top[-2] = reinterpret_cast<uint64_t>(entry);
    return top - 2;
}

// Suspends the caller, sets *from to its context and resumes `to`. Returns when another switch
// resumes *from.
#if defined(__x86_64__)
SUNSTONE_INLINE void switchFiber(FiberContext* from, FiberContext to) {
    asm volatile("leaq -128(%%rsp), %%rsp\n\t" // the red zone
                 "pushq %%rbp\n\t"
                 "pushq %%rbx\n\t"
                 "leaq 1f(%%rip), %%rax\n\t"
                 "pushq %%rax\n\t"
                 "movq %%rsp, (%%rdi)\n\t"
                 "movq %%rsi, %%rsp\n\t"
                 "popq %%rax\n\t"
                 "jmpq *%%rax\n"
                 "1:\n\t"
                 "popq %%rbx\n\t"
                 "popq %%rbp\n\t"
                 "leaq 128(%%rsp), %%rsp"
                 : "+D"(from), "+S"(to)
                 :
                 : "rax", "rcx", "rdx", "r8", "r9", "r10", "r11", "r12", "r13", "r14", "r15",
                   "xmm0", "xmm1", "xmm2", "xmm3", "xmm4", "xmm5", "xmm6", "xmm7", "xmm8", "xmm9",
                   "xmm10", "xmm11", "xmm12", "xmm13", "xmm14", "xmm15",
#if defined(__AVX512F__)
                   "xmm16", "xmm17", "xmm18", "xmm19", "xmm20", "xmm21", "xmm22", "xmm23", "xmm24",
                   "xmm25", "xmm26", "xmm27", "xmm28", "xmm29", "xmm30", "xmm31", "k1", "k2", "k3",
                   "k4", "k5", "k6", "k7",
#endif
                   "memory", "cc");
}
#else
#error "switches between stacks are not written for this processor"
#endif

} // namespace sunstone
