// SPDX-License-Identifier: Apache-2.0
// See gpu/header.h.
#include "compiler/gpu/header.h"

#include "base/error.h"

#include <algorithm>
#include <charconv>
#include <set>

namespace sunstone::compiler {

namespace {

// The newest value that LLVM 19 knows up to `wanted`: drivers also compile PTX for older devices
// and of older versions.
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

// 'a': this device only; 'f': its family from this device on (PTX ISA 9.0, .target).
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
    // An architecture includes its family's features, and a family those of all.
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

// Decides by opcode: the set has opcodes whose table forms are all older than PTX 7.9 and valid for
// plain targets. Plain arithmetic on words, the bulk of most programs, needs no header either.
bool mayNeedHeader(const ptx::Instruction& instruction) {
    using Names = std::set<std::string_view>;
    static const auto& kOld =
        *new Names{"rcp",        "sqrt",   "rsqrt",    "sin",       "cos",     "lg2",       "ex2",
                   "tanh",       "testp",  "lop3",     "prmt",      "bfe",     "bfi",       "bfind",
                   "shf",        "fns",    "bmsk",     "szext",     "dp4a",    "dp2a",      "sad",
                   "mul24",      "mad24",  "brev",     "copysign",  "tex",     "tld4",      "txq",
                   "suq",        "suld",   "sust",     "sured",     "vote",    "shfl",      "match",
                   "activemask", "membar", "bar",      "nanosleep", "pmevent", "prefetchu", "wmma",
                   "vadd",       "vsub",   "vabsdiff", "vmin",      "vmax",    "vshl",      "vshr",
                   "vset",       "vmad",   "vadd2",    "vsub2",     "vavrg2",  "vabsdiff2", "vmin2",
                   "vmax2",      "vset2",  "vadd4",    "vsub4",     "vavrg4",  "vabsdiff4", "vmin4",
                   "vmax4",      "vset4"};
    static const auto& kOldOfWords =
        *new Names{"add", "sub", "mul", "mad",  "fma",  "div",  "neg", "abs",  "min",
                   "max", "cvt", "set", "setp", "slct", "atom", "red", "redux"};
    static const auto& kOldModifiers = *new Names{
        "rn",      "rz",      "rm",      "rp",  "rni", "rzi", "rmi",    "rpi",    "ftz",
        "sat",     "approx",  "full",    "NaN", "eq",  "ne",  "lt",     "le",     "gt",
        "ge",      "equ",     "neu",     "ltu", "leu", "gtu", "geu",    "num",    "nan",
        "lo",      "ls",      "hi",      "hs",  "and", "or",  "xor",    "sync",   "relaxed",
        "acquire", "release", "acq_rel", "cta", "gpu", "sys", "global", "shared", "add",
        "inc",     "dec",     "min",     "max", "cas", "exch"};
    const std::string_view op = instruction.opcode;
    if (instruction.isForeign)
        return true;
    if (kOld.count(op))
        return false;
    if (!kOldOfWords.count(op))
        return true;
    if ((op == "min" || op == "max") && instruction.operands.size() > 3)
        return true;
    for (const std::string_view modifier : instruction.modifiers)
        if (ptx::Type type; !ptx::typeFromName(modifier, type) && !kOldModifiers.count(modifier))
            return true;
    return std::any_of(instruction.types.begin(), instruction.types.end(), [&](ptx::Type type) {
        if (!ptx::isFloat(type))
            return ptx::sizeOf(type) > 8;
        return op == "redux" || !(type == ptx::Type::kF32 || type == ptx::Type::kF64 ||
                                  (type == ptx::Type::kF16 && op == "cvt"));
    });
}

} // namespace sunstone::compiler
