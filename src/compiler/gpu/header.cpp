// SPDX-License-Identifier: Apache-2.0
// See gpu/header.h.
#include "compiler/gpu/header.h"

#include "base/error.h"
#include "ptx/opcodes/opcode.h"

#include <algorithm>
#include <charconv>

namespace sunstone::compiler {

namespace {

// The newest value up to `wanted` that LLVM 19 knows. An older value works, because drivers also
// compile PTX for older devices and of older versions.
unsigned newestUpTo(std::initializer_list<unsigned> known, unsigned wanted) {
    unsigned newest = *known.begin();
    for (unsigned each : known)
        if (each <= wanted)
            newest = std::max(newest, each);
    return newest;
}

// sm_90a: 90 and 'a'. `letter` is 0 if the name has none.
struct Target {
    unsigned number = 0;
    char letter = 0;
};

Target targetOf(std::string_view name) {
    Target target;
    const char *begin = name.data() + std::min<size_t>(3, name.size()),
               *end = name.data() + name.size();
    const char* const rest = std::from_chars(begin, end, target.number).ptr;
    target.letter = rest == end ? 0 : *rest;
    return target;
}

// 'a': this device only; 'f': this device and the later ones of its family (PTX ISA 9.0, .target).
bool runs(const Target& target, unsigned computeCapability) {
    if (target.letter == 'a')
        return target.number == computeCapability;
    if (target.letter == 'f')
        return target.number / 10 == computeCapability / 10 && target.number <= computeCapability;
    return target.letter == 0;
}

} // namespace

GpuHeader plainHeader(const GpuTarget& target) {
    const unsigned device = newestUpTo({70, 72, 75, 80, 86, 87, 89, 90}, target.computeCapability);
    const unsigned version =
        newestUpTo({63, 64, 65, 70, 71, 72, 73, 74, 75, 76, 77, 78, 80, 81, 82, 83, 84, 85},
                   target.ptxVersion);
    return {version, message("sm_", device)};
}

bool runsTarget(std::string_view target, unsigned computeCapability) {
    return runs(targetOf(target), computeCapability);
}

void widen(GpuHeader& header, const ptx::Module& module, const GpuTarget& target) {
    const unsigned declared = 10 * module.versionMajor + std::min(module.versionMinor, 9u);
    header.version = std::max(header.version, std::min(declared, target.ptxVersion));
    const Target old = targetOf(header.target), wanted = targetOf(module.target);
    if (!runs(wanted, target.computeCapability) || wanted.number > target.computeCapability)
        return;
    // An architecture ('a') includes its family's features, and a family ('f') those of the plain
    // target.
    const auto rank = [](char letter) { return letter == 'a' ? 2 : letter == 'f' ? 1 : 0; };
    const char letter = rank(wanted.letter) > rank(old.letter) ? wanted.letter : old.letter;
    header.target = message("sm_", std::max(old.number, wanted.number));
    if (letter)
        header.target += letter;
}

std::string withHeader(std::string text, const GpuHeader& header) {
    const auto replace = [&](std::string_view directive, const std::string& value) {
        size_t at = 0;
        while (text.compare(at, directive.size(), directive) != 0) {
            at = text.find('\n', at);
            if (at++ == text.npos)
                fail(sunstone::Code::kInternal, "a PTX text without ", directive);
        }
        at += directive.size();
        text.replace(at, text.find_first_of(",\n", at) - at, value);
    };
    replace(".version ", message(header.version / 10, ".", header.version % 10));
    replace(".target ", header.target);
    return text;
}

namespace {

constexpr std::string_view kOldModifiers[] = {
    "NaN",  "acq_rel", "acquire", "add",     "and",     "approx", "cas", "cta", "dec", "eq",  "equ",
    "exch", "ftz",     "full",    "ge",      "geu",     "global", "gpu", "gt",  "gtu", "hi",  "hs",
    "inc",  "le",      "leu",     "lo",      "ls",      "lt",     "ltu", "max", "min", "nan", "ne",
    "neu",  "num",     "or",      "relaxed", "release", "rm",     "rmi", "rn",  "rni", "rp",  "rpi",
    "rz",   "rzi",     "sat",     "shared",  "sync",    "sys",    "xor"};
static_assert(std::is_sorted(std::begin(kOldModifiers), std::end(kOldModifiers)));

bool isOldModifier(std::string_view modifier) {
    ptx::Type type;
    return ptx::typeFromName(modifier, type) ||
           std::binary_search(std::begin(kOldModifiers), std::end(kOldModifiers), modifier);
}

bool isOldType(ptx::Type type, ptx::Age age) {
    if (!ptx::isFloat(type))
        return ptx::sizeOf(type) <= 8;
    if (type == ptx::Type::kF16)
        return age == ptx::Age::kHalves;
    return (type == ptx::Type::kF32 || type == ptx::Type::kF64) && age != ptx::Age::kIntegers;
}

} // namespace

// Decides by the PTX version of the opcode's forms. Plain arithmetic on words, the bulk of most
// programs, needs no header.
bool mayNeedHeader(const ptx::Instruction& instruction) {
    const ptx::Age age = instruction.facts->age;
    if (instruction.isForeign || age == ptx::Age::kNew)
        return true;
    if (age == ptx::Age::kOld)
        return false;
    if (age == ptx::Age::kTwoSingles && instruction.operands.size() > 3)
        return true;
    const auto isOld = [&](ptx::Type type) { return isOldType(type, age); };
    return !std::all_of(instruction.modifiers.begin(), instruction.modifiers.end(),
                        isOldModifier) ||
           !std::all_of(instruction.types.begin(), instruction.types.end(), isOld);
}

} // namespace sunstone::compiler
