// SPDX-License-Identifier: Apache-2.0
// The syntax tree of a PTX module. The parser makes the tree, the verifier checks it, the compiler
// reads it.
//
// The parser resolves scoped names: a register operand holds an index into its function's
// `registers` (scopes are braces; the index is unique, names may repeat), a label operand an index
// into `labels`. Symbols (functions, variables, parameters, local and shared variables) remain
// names; the compiler looks them up. Instructions keep their opcode split at the dots, without loss
// of text. All string_views point into Module::text. No LLVM here. Source: PTX ISA manual, versions
// up to 9.0. Read next: parse/parser.h, verifier.h.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace sunstone::ptx {

// Line and column in the PTX text, both from 1; line 0 means unknown.
struct Location {
    uint32_t line = 0;
    uint32_t column = 0;
};

enum class Type : uint8_t {
    kNone,
    kPred,
    kB8,
    kB16,
    kB32,
    kB64,
    kB128,
    kU8,
    kU16,
    kU32,
    kU64,
    kS8,
    kS16,
    kS32,
    kS64,
    kF16,
    kF16x2,
    kBF16,
    kBF16x2,
    kF32,
    kF64,
    kTexref,
    kSamplerref,
    kSurfref,
};

unsigned sizeOf(Type type);    // bytes; kPred 1, opaque references 8, kNone 0
const char* nameOf(Type type); // "u32", "pred", ...
bool typeFromName(std::string_view name, Type& type); // without the dot
inline bool isFloat(Type t) {
    return t >= Type::kF16 && t <= Type::kF64;
}
inline bool isSigned(Type t) {
    return t >= Type::kS8 && t <= Type::kS64;
}

enum class Space : uint8_t { kNone, kReg, kConst, kGlobal, kLocal, kParam, kShared };

enum class Linkage : uint8_t { kInternal, kVisible, kExtern, kWeak, kCommon };

// A word of an initialiser that holds the address of a symbol.
struct Relocation {
    uint64_t offset = 0; // bytes from the variable's start
    std::string_view symbol;
    int64_t addend = 0;
    bool generic = false; // generic(sym): address in generic space
    uint8_t mask = 0;     // 0, or bit k set: only byte k of the address, the 0xFF(...) form
                          // (runs of all bytes of one address are merged into one word)
    unsigned size = 8;    // bytes the address takes
};

// A module, function-local or parameter variable.
struct Variable {
    std::string_view name;
    Space space = Space::kNone;
    Linkage linkage = Linkage::kInternal;
    Type type = Type::kNone;
    unsigned vector = 1;              // elements of .v2/.v4
    unsigned alignment = 0;           // bytes; never 0 after parsing (natural if not given)
    std::vector<uint64_t> dimensions; // array sizes; 0 = not given: name[]
    uint64_t size = 0;                // bytes in all; 0 for unsized arrays
    bool isArray = false;
    bool isPointer = false;            // kernel parameter marked .ptr
    bool isManaged = false;            // .attribute(.managed)
    Space pointerSpace = Space::kNone; // .ptr.global and the like; kNone = generic
    unsigned pointerAlignment = 0;     // .ptr ... .align N; 0 = not given
    bool hasInitializer = false;
    std::vector<uint8_t> initializer; // may be shorter than size: the rest is zero
    std::vector<Relocation> relocations;
    Location location;
};

struct Register {
    std::string_view name; // base name; parametrised ranges (%r<10>) are expanded by number
    uint32_t number = ~0u; // number within a range, ~0u if declared singly
    Type type = Type::kNone;
    unsigned vector = 1;
    Location location;
};

enum class OperandKind : uint8_t {
    kRegister, // index = register; `negated` for !p
    kInteger,  // integer = value (two's complement)
    kFloat,    // integer = bits: 32 or 64 as floatBits says (0f..., 0d..., decimal = 64)
    kSymbol,   // name of a variable, function, parameter or .branchtargets list, maybe with
               // `offset`, maybe indexed by a register (see scale)
    kSpecial,  // name of a special register, "%tid.x"
    kAddress,  // [base + offset]: base register (index) or symbol (name) or neither; both for
               // sym[%r], see scale
    kVector,   // {a, b, ...}: elements
    kLabel,    // index = label
    kSink,     // _
    kPair,     // d|p of setp, shfl, match...: elements[0], elements[1]
    kTexture,  // [tex, {coords}] or [tex, sampler, {coords}]: elements in order
};

struct Operand {
    OperandKind kind = OperandKind::kSink;
    bool negated = false; // !p or a leading minus before a register
    uint8_t floatBits = 0;
    uint32_t index = ~0u;  // register or label
    int8_t component = -1; // .x .y .z .w (0..3) of a vector register; 4..7 = .b0 .. .b3 and
                           // 8, 9 = .h0 .h1 of a video instruction's operand; kPicked
    static constexpr int8_t kPicked = 10; // several of its parts: `name` is b7301, h20 ...
    int64_t integer = 0;
    int64_t offset = 0;    // kSymbol, kAddress: bytes
    uint32_t scale = 0;    // kSymbol, kAddress with name and index, the sym[%r] form: the
                           // address is name + register * scale + offset. 0 otherwise
    std::string_view name; // kSymbol, kSpecial, kAddress on a symbol; see kPicked
    std::vector<Operand> elements;
    Location location;
};

// Source position from .loc, for messages and debug information.
struct SourcePosition {
    uint32_t file = 0; // index into Module::files; 0 = none
    uint32_t line = 0;
    uint32_t column = 0;
};

struct Opcode;
extern const Opcode kUnknownOpcode;

struct Instruction {
    std::string_view opcode;                 // "ld"
    const Opcode* facts = &kUnknownOpcode;   // opcodes/opcode.h; never null
    std::vector<std::string_view> modifiers; // "global", "v4", "u32": in order, without dots
    std::vector<Type> types;                 // those modifiers that are types, in order
    int32_t guard = -1;                      // register index of @p, -1 if none
    bool guardNegated = false;
    std::vector<Operand> operands; // destinations first, as written (except `call`)
    // call: results, target and arguments are separate; `operands` is empty.
    std::vector<Operand> results;
    std::vector<Operand> arguments;
    Operand target;
    std::string_view prototype; // label of .callprototype / .calltargets, or empty
    // The instruction table lacks this form, but the compiler's Judge accepts it (parse/parser.h).
    bool isForeign = false;
    Location location;
    SourcePosition source;

    bool has(std::string_view modifier) const {
        for (std::string_view m : modifiers)
            if (m == modifier)
                return true;
        return false;
    }
    std::string fullOpcode() const; // "ld.global.v4.u32"
};

enum class StatementKind : uint8_t { kInstruction, kLabel };

struct Statement {
    StatementKind kind = StatementKind::kInstruction;
    uint32_t label = ~0u;    // kLabel
    Instruction instruction; // kInstruction
};

// The prototype of an indirect call's target.
struct Prototype {
    std::string_view name;
    std::vector<Variable> results;
    std::vector<Variable> parameters;
    Location location;
};

struct BranchTargets {
    std::string_view name;
    std::vector<uint32_t> labels;
};

// The functions that an indirect call may reach, from .calltargets.
struct CallTargets {
    std::string_view name;
    std::vector<std::string_view> functions;
};

struct Function {
    std::string_view name;
    Linkage linkage = Linkage::kInternal;
    bool isEntry = false;
    bool hasBody = false;
    bool noreturn = false;
    std::vector<Variable> results;    // space kParam or kReg
    std::vector<Variable> parameters; // space kParam or kReg; kReg ones are also in `registers`
    std::vector<uint32_t> resultRegisters;    // register index per result, ~0u for a .param
    std::vector<uint32_t> parameterRegisters; // same for parameters
    std::vector<Register> registers;          // of a range only the registers that are used
    std::vector<std::string_view> labels;
    std::vector<Variable> variables; // .local, .shared, .param, .global, .const declared in the
                                     // body; names made unique within the function
    std::vector<Prototype> prototypes;
    std::vector<BranchTargets> branchTargets;
    std::vector<CallTargets> callTargets;
    std::vector<Statement> body;             // braces flattened
    uint32_t maxThreads[3] = {0, 0, 0};      // .maxntid
    uint32_t requiredThreads[3] = {0, 0, 0}; // .reqntid
    uint32_t minBlocks = 0;                  // .minnctapersm
    uint32_t maxBlocks = 0;                  // .maxnctapersm
    uint32_t maxRegisters = 0;               // .maxnreg
    uint32_t requiredCluster[3] = {0, 0, 0}; // .reqnctapercluster
    uint32_t maxClusterRank = 0;             // .maxclusterrank
    bool explicitCluster = false;            // .explicitcluster
    Location location;
};

// Text between the braces of a .section: debug information as data directives, not parsed.
struct Section {
    std::string_view name; // "debug_info"
    std::string_view text;
};

struct Module {
    std::string text;                                    // owns every name below
    std::vector<std::unique_ptr<std::string>> generated; // names made by the parser
    unsigned versionMajor = 0, versionMinor = 0;
    std::string_view target;                     // "sm_75"
    std::vector<std::string_view> targetOptions; // "debug", "texmode_independent", ...
    unsigned addressSize = 64;
    std::vector<std::string> files;  // .file table, index as in .loc; [0] unused
    std::vector<Section> sections;
    std::vector<Variable> variables; // module scope
    std::vector<Function> functions; // declarations and definitions
    std::vector<std::pair<std::string_view, std::string_view>> aliases;

    // Maps from name to index, filled by the parser. Code that adds functions or variables to a
    // parsed module must add them here, too. If the maps are empty, the look-ups search the
    // vectors.
    std::unordered_map<std::string_view, uint32_t> functionIndex;
    std::unordered_map<std::string_view, uint32_t> variableIndex;

    Module() = default;
    Module(const Module&) = delete;
    Module& operator=(const Module&) = delete;

    const Function* findFunction(std::string_view name) const; // a definition before a declaration
    const Variable* findVariable(std::string_view name) const;
};

} // namespace sunstone::ptx
