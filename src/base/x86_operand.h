// SPDX-License-Identifier: Apache-2.0
// The memory operand of an x86-64 instruction. The processor does not say which address an
// instruction accessed if the address is not canonical or not aligned as the instruction needs; the
// registers at the fault and the instruction's bytes do. Source: Intel's Software Developer's
// Manual, volume 2, chapter 2 (prefixes, ModR/M, SIB, VEX, EVEX).
#pragma once

#include <cstdint>

namespace sunstone {

// General registers by their number in instructions: rax, rcx, rdx, rbx, rsp, rbp, rsi, rdi, r8 to
// r15.
using X86Registers = uint64_t[16];

// Whether bits 63 to 47 are equal.
bool isCanonical(uint64_t address);

// The address that the instruction at `code` reads, writes, or jumps to. False where registers and
// bytes do not tell: gathers, scatters, segments with a base, operands relative to the instruction,
// and some scaled displacements of AVX-512. Reads the instruction, and where a jump or return
// reads its target, that. Signal handlers may call it.
bool accessedAddress(const uint8_t* code, const X86Registers& registers, uint64_t& address);

} // namespace sunstone
