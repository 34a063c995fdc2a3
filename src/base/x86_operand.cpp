// SPDX-License-Identifier: Apache-2.0
// See x86_operand.h.
#include "base/x86_operand.h"

#include <cstring>

namespace sunstone {

namespace {

enum Register { kRsp = 4, kRbp = 5, kRsi = 6, kRdi = 7 };

// The information of the bytes before ModR/M.
struct Prefixes {
    uint8_t map = 0; // 0: one-byte opcodes, 1: 0F, 2: 0F 38, 3: 0F 3A
    uint8_t opcode = 0;
    uint8_t mandatory = 0;        // 0, or 0x66, 0xF3, 0xF2, as in the prefix
    bool wide = false;            // REX.W, VEX.W
    unsigned base = 0, index = 0; // bits to add to the registers' numbers
    bool isEvex = false;
    bool broadcasts = false;
    unsigned vectorBytes = 16;
    bool hasSegment = false;
};

template <class T>
T read(const uint8_t*& at) {
    T value;
    std::memcpy(&value, at, sizeof value);
    at += sizeof value;
    return value;
}

constexpr uint8_t kMandatory[4] = {0, 0x66, 0xF3, 0xF2};

void readVex(const uint8_t*& at, uint8_t first, Prefixes& p) {
    const uint8_t one = *at++;
    p.map = 1;
    uint8_t last = one;
    if (first == 0xC4) {
        p.map = one & 31;
        p.index = one & 0x40 ? 0 : 8;
        p.base = one & 0x20 ? 0 : 8;
        last = *at++;
        p.wide = last & 0x80;
    }
    p.mandatory = kMandatory[last & 3];
    p.vectorBytes = last & 4 ? 32 : 16;
}

void readEvex(const uint8_t*& at, Prefixes& p) {
    const uint8_t zero = *at++, one = *at++, two = *at++;
    p.isEvex = true;
    p.map = zero & 7;
    p.index = zero & 0x40 ? 0 : 8;
    p.base = zero & 0x20 ? 0 : 8;
    p.wide = one & 0x80;
    p.mandatory = kMandatory[one & 3];
    p.broadcasts = two & 0x10;
    p.vectorBytes = 16u << (two >> 5 & 3);
}

Prefixes readPrefixes(const uint8_t*& at) {
    Prefixes p;
    for (;; ++at) {
        if (*at == 0x64 || *at == 0x65)
            p.hasSegment = true;
        else if (*at == 0x66 || *at == 0xF2 || *at == 0xF3)
            p.mandatory = *at;
        else if (*at != 0x67 && *at != 0xF0 && *at != 0x2E && *at != 0x36 && *at != 0x3E &&
                 *at != 0x26)
            break;
    }
    if ((*at & 0xF0) == 0x40) {
        p.wide = *at & 8;
        p.index = *at & 2 ? 8 : 0;
        p.base = *at & 1 ? 8 : 0;
        ++at;
    }
    const uint8_t first = *at++;
    if (first == 0xC4 || first == 0xC5)
        readVex(at, first, p);
    else if (first == 0x62)
        readEvex(at, p);
    else if (first != 0x0F) {
        p.opcode = first;
        return p;
    } else if (*at == 0x38 || *at == 0x3A)
        p.map = *at++ == 0x38 ? 2 : 3;
    else
        p.map = 1;
    p.opcode = *at++;
    return p;
}

bool hasModRm(const Prefixes& p) {
    const uint8_t code = p.opcode;
    if (p.map > 1)
        return true;
    if (p.map == 1) // system calls, jumps, and instructions on registers alone
        return !((code >= 0x05 && code <= 0x0B) || (code & 0xF0) == 0x30 || code == 0x77 ||
                 (code & 0xF0) == 0x80 || (code >= 0xA0 && code <= 0xA2) ||
                 (code >= 0xA8 && code <= 0xAA) || (code >= 0xC8 && code <= 0xCF));
    if (code < 0x40)
        return (code & 7) < 4;
    return code == 0x63 || code == 0x69 || code == 0x6B || (code >= 0x80 && code < 0x90) ||
           code == 0xC0 || code == 0xC1 || code == 0xC6 || code == 0xC7 ||
           (code >= 0xD0 && code < 0xD4) || (code >= 0xD8 && code < 0xE0) || code == 0xF6 ||
           code == 0xF7 || code == 0xFE || code == 0xFF;
}

// The factor of an 8-bit displacement in EVEX, in bytes; 0 if this table has no entry.
unsigned displacementScale(const Prefixes& p) {
    if (!p.isEvex)
        return 1;
    const unsigned element = p.wide ? 8 : 4;
    if (p.broadcasts)
        return element;
    const uint8_t code = p.opcode;
    if (p.map == 1) {
        if (p.mandatory == 0xF3 && (code == 0x10 || code == 0x11 || (code >= 0x51 && code < 0x60)))
            return 4;
        if (p.mandatory == 0xF2 && (code == 0x10 || code == 0x11 || (code >= 0x51 && code < 0x60)))
            return 8;
        if (code == 0x6E || (code == 0x7E && p.mandatory == 0x66))
            return element;
        if (code == 0xD6 || (code == 0x7E && p.mandatory == 0xF3))
            return 8;
        const bool isWhole = code == 0x10 || code == 0x11 || code == 0x28 || code == 0x29 ||
                             code == 0x6F || code == 0x7F || (code >= 0x51 && code < 0x60) ||
                             code >= 0xD0;
        return isWhole ? p.vectorBytes : 0;
    }
    const bool isFused = p.map == 2 && code >= 0x96 && code < 0xC0; // fused multiply-add
    if (isFused)
        return code & 1 && (code & 15) >= 9 ? element : p.vectorBytes;
    return 0;
}

bool isGather(const Prefixes& p) {
    return p.map == 2 && p.opcode >= 0x90 && p.opcode <= 0x93;
}
bool isScatter(const Prefixes& p) {
    return p.map == 2 && p.opcode >= 0xA0 && p.opcode <= 0xA3;
}

bool modRmAddress(const uint8_t* at, const Prefixes& p, const X86Registers& r, uint64_t& address) {
    const uint8_t modRm = *at++;
    const unsigned mode = modRm >> 6, part = modRm >> 3 & 7, low = modRm & 7;
    const bool isJump = p.map == 0 && p.opcode == 0xFF && (part == 2 || part == 4);
    if (mode == 3) { // the target of a jump or call, else no memory
        address = r[low + p.base];
        return isJump;
    }
    if (p.hasSegment || isGather(p) || isScatter(p) || (mode == 0 && low == 5))
        return false;
    address = 0;
    bool hasBase = true;
    unsigned base = low;
    if (low == 4) {
        const uint8_t sib = *at++;
        const unsigned index = (sib >> 3 & 7) + p.index;
        base = sib & 7;
        hasBase = mode != 0 || base != 5;
        if (index != kRsp)
            address += r[index] << (sib >> 6);
    }
    if (hasBase)
        address += r[base + p.base];
    if (mode == 1) {
        const unsigned scale = displacementScale(p);
        const auto displacement = read<int8_t>(at);
        address += uint64_t(int64_t(displacement) * int64_t(scale));
        if (scale == 0 && displacement != 0)
            return false;
    }
    if (mode == 2 || !hasBase)
        address += uint64_t(int64_t(read<int32_t>(at)));
    if (isJump && isCanonical(address)) // the processor has read the target
        std::memcpy(&address, reinterpret_cast<const void*>(address), sizeof address);
    return true;
}

// One-byte opcodes whose operands are not in ModR/M.
bool impliedAddress(const uint8_t* at, const Prefixes& p, const X86Registers& r,
                    uint64_t& address) {
    const uint8_t code = p.opcode;
    const bool copies = code >= 0xA4 && code <= 0xA7;
    if (copies || code == 0xAC || code == 0xAD) {
        address = r[kRsi];
        if (copies && isCanonical(address))
            address = r[kRdi];
        return true;
    }
    if (code == 0xAA || code == 0xAB || code == 0xAE || code == 0xAF) {
        address = r[kRdi];
        return true;
    }
    if (code >= 0xA0 && code <= 0xA3) {
        address = read<uint64_t>(at);
        return !p.hasSegment;
    }
    if (code == 0xC9) {
        address = r[kRbp];
        return true;
    }
    const bool isReturn = code == 0xC2 || code == 0xC3;
    address = r[kRsp];
    if (isReturn && isCanonical(address))
        std::memcpy(&address, reinterpret_cast<const void*>(address), sizeof address);
    return isReturn || (code >= 0x50 && code < 0x60) || code == 0x68 || code == 0x6A ||
           code == 0xE8;
}

} // namespace

bool isCanonical(uint64_t address) {
    return uint64_t(int64_t(address << 16) >> 16) == address;
}

bool accessedAddress(const uint8_t* code, const X86Registers& registers, uint64_t& address) {
    const Prefixes prefixes = readPrefixes(code);
    if (hasModRm(prefixes))
        return modRmAddress(code, prefixes, registers, address);
    return prefixes.map == 0 && impliedAddress(code, prefixes, registers, address);
}

} // namespace sunstone
