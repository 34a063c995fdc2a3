// SPDX-License-Identifier: Apache-2.0
// The facts about an opcode that the parser, the verifier and the compiler use. The table in
// opcode_table.h has one row for each opcode, and no other file lists opcodes.
//
// The parser looks each opcode up once and stores the row in Instruction::facts, which all later
// steps use.
#pragma once

#include "ptx/opcodes/instructions.h"

#include <deque>
#include <memory>
#include <span>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace sunstone::ptx {

// The translation to LLVM IR. Opcodes of one operation differ within it (min and max).
enum class Operation : uint8_t {
    kUnknown, // none: an error on the CPU, inline PTX with unknown effects on a GPU
    // memory
    kMove,
    kLoad,
    kStore,
    kAtomic,
    kConvertAddress,
    kTestAddressSpace,
    kFence,
    kSleep,
    kNothing,
    // arithmetic, integer and floating point
    kAdd,
    kSubtract,
    kMultiply,
    kMultiplyAdd,
    kMultiply24,
    kFusedMultiplyAdd,
    kDivide,
    kRemainder,
    kNegate,
    kAbsolute,
    kMinimum,
    kSumAbsoluteDifference,
    kDotProduct,
    kReciprocal,
    kSquareRoot,
    kReciprocalSquareRoot,
    kTranscendental,
    kCopySign,
    kTestProperty,
    // bits
    kLogic,
    kLogicNot,
    kLookup3,
    kShift,
    kFunnelShift,
    kExtractField,
    kInsertField,
    kFindBit,
    kCountBits,
    kFindNthSet,
    kFieldMask,
    kPermute,
    // comparison, conversion
    kSetPredicate,
    kSetValue,
    kSelect,
    kSelectBySign,
    kConvert,
    // textures and surfaces
    kSampleTexture,
    kQueryTexture,
    kLoadSurface,
    kStoreSurface,
    kReduceSurface,
    // control
    kBranch,
    kBranchIndexed,
    kCall,
    kReturn,
    kExit,
    kTrap,
    // threads
    kBarrier,
    kVote,
    kMatch,
    kShuffle,
    kActiveMask,
    kReduceWarp,
    kElect,
    kSaveStack,
    kRestoreStack,
    kAllocateStack,
    kCopyAsync,
    kBarrierObject,
    // matrices of a warp
    kWideMatrices,
    kMultiplyMatrices,
    kMoveMatrixRows,
    kTransposeMatrix,
    // video
    kVideoScalar,
    kVideoMultiplyAdd,
    kVideoPacked,
    kCount,
};

// Which forms stay inline PTX on a GPU: those without an exact LLVM equivalent.
enum class Native : uint8_t {
    kNever,
    kValue,      // all; the result depends only on the operands
    kInexact,    // of floating point numbers, unless LLVM's operation is exact: plain f32 and f64
    kFloats,     // of floating point numbers
    kCompares,   // of floating point numbers, unless f32 or f64 without .ftz
    kOrders,     // loads and stores that order others or are asynchronous, and atomic 128-bit ones
    kEffects,    // all; they have effects on memory or time
    kWarp,       // all; lanes of a warp exchange values
    kWarpMemory, // all; the same, with effects on memory
    kWarpSync,   // those with .warp, at which lanes of a warp meet
    kStack,      // all; memory that is freed when the function returns
};

// The forms that are older than PTX 7.9 and valid for plain targets, so that their text passes
// through LLVM without the module's own .version and .target.
enum class Age : uint8_t {
    kNew,        // perhaps none
    kOld,        // all
    kIntegers,   // of integers with old modifiers
    kSingles,    // the same, or of f32 and f64
    kTwoSingles, // the same with two operands
    kHalves,     // the same as kSingles, or of f16
};

// The joint action of a warp's lanes at a call of the run-time (compiler/runtime/lane_functions.h).
enum class Lockstep : uint8_t {
    kAlone, // nothing
    kBarrier,
    kVote,
    kShuffle,
    kMatch,
    kReduce,
    kMatrix,
    kActiveLanes, // a lane asks which others are active
    kWait,        // at a barrier object
    kSpin,        // lets other lanes run after a read of memory that they may write
    kFrames,      // a thread asks whether an address is in its own frames
    kExit,
    kTrap,
    kAssertion, // no opcode's: after a failed assertion
    kPause,     // no opcode's: at the ends of loops (lockstep/plan.h)
};

// The syntax of operands.
enum class Syntax : uint8_t {
    kValues,
    kAddresses, // a variable's name means its address
    kLabel,     // operands are labels
    kTargets,   // the second operand is a .branchtargets list
    kCall,
};

// Further facts, one bit each.
constexpr uint8_t kPacked = 1;   // has forms of .u16x2 and .s16x2
constexpr uint8_t kAccesses = 2; // its [address] has 64 bits in the generic and the global space
constexpr uint8_t kCopies = 4;   // copies bits: its type says little about their use

struct Opcode {
    std::string_view name;
    Operation operation = Operation::kUnknown;
    Native native = Native::kNever;
    Age age = Age::kNew;
    Lockstep lockstep = Lockstep::kAlone;
    Syntax syntax = Syntax::kValues;
    uint8_t flags = 0;
    bool hasResult = false;  // some form writes its first operand
    std::vector<Form> forms; // empty for an unknown opcode

    bool isPacked() const { return flags & kPacked; }
    bool isAccess() const { return flags & kAccesses; }
    bool isCopy() const { return flags & kCopies; }
    bool isJump() const { return syntax == Syntax::kLabel || syntax == Syntax::kTargets; }
};

// Rows of opcode_table.h.
struct OpcodeText {
    const char* opcodes; // separated by |
    Operation operation;
    Native native = Native::kNever;
    Age age = Age::kNew;
    Lockstep lockstep = Lockstep::kAlone;
    Syntax syntax = Syntax::kValues;
    uint8_t flags = 0;
};

struct FormText;

class OpcodeTable {
public:
    // Each form is added to the rows of its opcodes, which must exist.
    OpcodeTable(std::span<const OpcodeText> rows, std::span<const FormText> forms);
    OpcodeTable(const OpcodeTable&) = delete;
    OpcodeTable& operator=(const OpcodeTable&) = delete;

    // kUnknownOpcode for other names. Rows keep their addresses for the lifetime of the table.
    const Opcode& find(std::string_view name) const {
        const auto found = index_.find(name);
        return found == index_.end() ? kUnknownOpcode : *found->second;
    }
    const std::deque<Opcode>& all() const { return opcodes_; }

private:
    std::deque<Opcode> opcodes_;
    std::unordered_map<std::string_view, const Opcode*> index_;
};

// The opcodes of PTX.
const OpcodeTable& opcodeTable();
// The rows of opcodeTable(), for tables that extend it.
std::span<const OpcodeText> opcodeRows();
std::span<const FormText> formRows();

} // namespace sunstone::ptx
