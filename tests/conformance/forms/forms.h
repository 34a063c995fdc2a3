// SPDX-License-Identifier: Apache-2.0
// Conformance vectors of PTX instructions: the forms, their inputs and outputs, and the required
// agreement of two implementations. A form is one instruction with its modifiers and types, in the
// few lines of PTX that make its results visible. The forms_*.cpp files enumerate them,
// module_writer.cpp makes kernels of them. Source: PTX ISA manual, chapter "Instruction Set".
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace conformance {

// Vectors per form: threads of a launch, a multiple of 32.
constexpr unsigned kVectors = 512;

// The comparison of results. For all rules except kExact, all NaNs are equal, because the manual
// leaves the payload open. Results that must be the canonical NaN use kExact.
struct Rule {
    enum Kind : uint8_t {
        kExact,    // bit by bit
        kNumber,   // bit by bit, but for NaNs
        kUlp,      // at most `bound` units of the last place apart
        kAbsolute, // at most `bound` apart
        kRelative, // at most `bound` times the recorded magnitude apart
        kMixed,    // likewise, where the magnitude is below 1 as if it were 1
    };
    Kind kind = kExact;
    double bound = 0;
    // Vectors are skipped if the operand of this number is outside +-limit, where the manual states
    // no bound.
    int limited = -1;
    double limit = 0;
    // A result near the flush limit may be zero or the smallest normal number, because the manual
    // does not specify whether flushing is before or after rounding.
    bool flushEdge = false;
};

// Types of inputs: i16 i32 i64 (integers with their edges), f16 bf16 f16x2 bf16x2 f32 f64, p (a
// predicate), and 32-bit ones with a purpose: sh (shift amounts), len (positions and lengths, some
// past the end), lane (0..40), nth (-40..40), arg (floats of moderate size).
// Types of outputs: p b8 b16 b32 b64 f16 bf16 f16x2 bf16x2 f32 f64.
struct Output {
    Output(const char* type) : type(type) {} // implicit, so that lists of types are text
    Output(std::string type) : type(std::move(type)) {}
    Output(const char* type, Rule rule) : type(type), rule(rule) {}
    std::string type;
    Rule rule;
};

struct Form {
    std::string name;
    // PTX. Operands are a0, a1, ...; results d0, d1, ...; free registers t0..t3 (b32), u0..u3
    // (b64), h0..h3 (b16), q0..q1 (predicates); m: 64 bytes of global, sm: of shared, lm: of local
    // memory of the thread, as 64-bit addresses.
    std::string code;
    std::vector<std::string> inputs;
    std::vector<Output> outputs;
    bool warp = false; // exchanges data with other threads: kept separate
};

class Forms {
public:
    // One form for each expansion of `pattern`, where {a|b|} means a, b or empty. `code`: the PTX
    // with @ (and a space) for the instruction; empty: "@ d0, a0, a1, ...;". `note` makes the name
    // unique if one instruction has several forms.
    void add(const std::string& pattern, const std::vector<std::string>& inputs,
             const std::vector<Output>& outputs, const std::string& code = "",
             const std::string& note = "");
    void addWarp(const std::string& pattern, const std::vector<std::string>& inputs,
                 const std::vector<Output>& outputs, const std::string& code,
                 const std::string& note = "");

    std::vector<Form> list;
};

inline Rule number() {
    return {Rule::kNumber, 0, -1, 0, false};
}
inline Rule within(Rule::Kind kind, double bound, int limited = -1, double limit = 0) {
    return {kind, bound, limited, limit, false};
}

// The width of a register for a type, in bits; 1 for predicates.
unsigned widthOf(const std::string& type);

void addIntegerForms(Forms& forms);
void addBitForms(Forms& forms);
void addFloatForms(Forms& forms);
void addComparisonForms(Forms& forms);
void addConversionForms(Forms& forms);
void addMemoryForms(Forms& forms);
void addWarpForms(Forms& forms);
void addVideoForms(Forms& forms);

std::vector<Form> allForms();

} // namespace conformance
