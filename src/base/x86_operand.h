// SPDX-License-Identifier: Apache-2.0
// The memory operand of an x86-64 instruction. The processor does not report the address of an
// access that is not canonical, or not aligned as the instruction requires; the registers at the
// fault and the instruction's bytes give it. Source: Intel's Software Developer's Manual, volume 2,
// chapter 2 (prefixes, ModR/M, SIB, VEX, EVEX).
#pragma once

#include <cstdint>

namespace sunstone {

// General registers by their number in instructions: rax, rcx, rdx, rbx, rsp, rbp, rsi, rdi, r8 to
// r15.
using X86Registers = uint64_t[16];

// Whether bits 63 to 47 are equal.
bool isCanonical(uint64_t address);

// The address that the instruction at `code` reads, writes, or jumps to. False if registers and
// bytes do not determine it: gathers, scatters, segments with a base, operands relative to the
// instruction, and some scaled displacements of AVX-512. Reads the instruction, and the target's
// address where a jump or return reads it. Signal handlers may call it.
bool accessedAddress(const uint8_t* code, const X86Registers& registers, uint64_t& address);

} // namespace sunstone
