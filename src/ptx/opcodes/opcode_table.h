// SPDX-License-Identifier: Apache-2.0
// The table of opcodes: one row for each opcode, or for several that differ only within their
// operation. Columns: opcode.h explains their values; columns that are missing at the end of a row
// have the first value. The operands of each opcode are in instruction_table.h, one row for each
// form.
#pragma once

#include "ptx/opcodes/opcode.h"

namespace sunstone::ptx {

namespace opcode_columns {
using O = Operation;
using N = Native;
using A = Age;
using L = Lockstep;
using S = Syntax;

// clang-format off
inline constexpr OpcodeText kOpcodeTexts[] = {
    // opcodes       operation                   on GPUs          version         lockstep           operands       flags
    // Integer and floating point arithmetic
    {"add",          O::kAdd,                    N::kInexact,     A::kSingles,    L::kAlone,         S::kValues,    kPacked},
    {"sub",          O::kSubtract,               N::kInexact,     A::kSingles,    L::kAlone,         S::kValues,    kPacked},
    {"addc",         O::kAdd},
    {"subc",         O::kSubtract},
    {"mul",          O::kMultiply,               N::kInexact,     A::kSingles},
    {"mad",          O::kMultiplyAdd,            N::kInexact,     A::kSingles},
    {"madc",         O::kMultiplyAdd},
    {"fma",          O::kFusedMultiplyAdd,       N::kInexact,     A::kSingles},
    {"mul24|mad24",  O::kMultiply24,             N::kValue,       A::kOld},
    {"sad",          O::kSumAbsoluteDifference,  N::kValue,       A::kOld},
    {"div",          O::kDivide,                 N::kInexact,     A::kSingles},
    {"rem",          O::kRemainder},
    {"abs",          O::kAbsolute,               N::kInexact,     A::kSingles},
    {"neg",          O::kNegate,                 N::kInexact,     A::kSingles},
    {"min|max",      O::kMinimum,                N::kFloats,      A::kTwoSingles, L::kAlone,         S::kValues,    kPacked},
    {"rcp",          O::kReciprocal,             N::kValue,       A::kOld},
    {"sqrt",         O::kSquareRoot,             N::kValue,       A::kOld},
    {"sin|cos|lg2",  O::kTranscendental,         N::kValue,       A::kOld},
    {"rsqrt",        O::kReciprocalSquareRoot,   N::kValue,       A::kOld},
    {"ex2|tanh",     O::kTranscendental,         N::kValue,       A::kOld},
    {"copysign",     O::kCopySign,               N::kValue,       A::kOld},
    {"testp",        O::kTestProperty,           N::kValue,       A::kOld},
    {"dp4a|dp2a",    O::kDotProduct,             N::kValue,       A::kOld},
    // Bits
    {"and|or|xor",   O::kLogic},
    {"not|cnot",     O::kLogicNot},
    {"lop3",         O::kLookup3,                N::kValue,       A::kOld},
    {"shl|shr",      O::kShift},
    {"shf",          O::kFunnelShift,            N::kValue,       A::kOld},
    {"popc|clz",     O::kCountBits},
    {"bfind",        O::kFindBit,                N::kValue,       A::kOld},
    {"brev",         O::kCountBits,              N::kValue,       A::kOld},
    {"fns",          O::kFindNthSet,             N::kValue,       A::kOld},
    {"bfe",          O::kExtractField,           N::kValue,       A::kOld},
    {"bfi",          O::kInsertField,            N::kValue,       A::kOld},
    {"bmsk",         O::kFieldMask,              N::kValue,       A::kOld},
    {"szext",        O::kExtractField,           N::kValue,       A::kOld},
    {"prmt",         O::kPermute,                N::kValue,       A::kOld},
    // Comparison and selection
    {"setp",         O::kSetPredicate,           N::kCompares,    A::kSingles},
    {"set",          O::kSetValue,               N::kFloats,      A::kSingles},
    {"selp",         O::kSelect,                 N::kNever,       A::kNew,        L::kAlone,         S::kValues,    kCopies},
    {"slct",         O::kSelectBySign,           N::kCompares,    A::kSingles},
    // Moves and conversions
    {"mov",          O::kMove,                   N::kNever,       A::kNew,        L::kAlone,         S::kAddresses, kCopies},
    {"cvta",         O::kConvertAddress,         N::kNever,       A::kNew,        L::kAlone,         S::kAddresses},
    {"isspacep",     O::kTestAddressSpace,       N::kValue,       A::kNew,        L::kFrames},
    {"cvt",          O::kConvert,                N::kFloats,      A::kHalves},
    // Memory
    {"ld",           O::kLoad,                   N::kOrders,      A::kNew,        L::kSpin,          S::kValues,    kAccesses | kCopies},
    {"ldu",          O::kLoad,                   N::kNever,       A::kNew,        L::kSpin,          S::kValues,    kAccesses},
    {"st",           O::kStore,                  N::kOrders,      A::kNew,        L::kAlone,         S::kValues,    kAccesses | kCopies},
    {"prefetch",     O::kNothing,                N::kEffects},
    {"prefetchu",    O::kNothing,                N::kEffects,     A::kOld},
    {"discard|applypriority", O::kNothing,        N::kEffects},
    {"atom|red",     O::kAtomic,                 N::kEffects,     A::kSingles,    L::kSpin,          S::kValues,    kAccesses},
    // Textures and surfaces
    {"tex|tld4",     O::kSampleTexture,          N::kValue,       A::kOld},
    {"txq|suq",      O::kQueryTexture,           N::kValue,       A::kOld},
    {"suld",         O::kLoadSurface,            N::kEffects,     A::kOld},
    {"sust",         O::kStoreSurface,           N::kEffects,     A::kOld},
    {"sured",        O::kReduceSurface,          N::kEffects,     A::kOld},
    {"istypep",      O::kUnknown},
    // Control flow
    {"bra",          O::kBranch,                 N::kNever,       A::kNew,        L::kAlone,         S::kLabel},
    {"brx",          O::kBranchIndexed,          N::kNever,       A::kNew,        L::kAlone,         S::kTargets},
    {"call",         O::kCall,                   N::kNever,       A::kNew,        L::kAlone,         S::kCall},
    {"ret",          O::kReturn},
    {"exit",         O::kExit,                   N::kNever,       A::kNew,        L::kExit},
    {"trap",         O::kTrap,                   N::kNever,       A::kNew,        L::kTrap},
    {"brkpt",        O::kNothing},
    {"pmevent",      O::kNothing,                N::kEffects,     A::kOld},
    {"nanosleep",    O::kSleep,                  N::kEffects,     A::kOld,        L::kSpin},
    // Threads of a block and of a warp
    {"bar",          O::kBarrier,                N::kWarpSync,    A::kOld,        L::kBarrier},
    {"barrier",      O::kBarrier,                N::kWarpSync,    A::kNew,        L::kBarrier},
    {"membar",       O::kFence,                  N::kEffects,     A::kOld},
    {"fence",        O::kFence,                  N::kEffects},
    {"vote",         O::kVote,                   N::kWarp,        A::kOld,        L::kVote},
    {"match",        O::kMatch,                  N::kWarp,        A::kOld,        L::kMatch},
    {"shfl",         O::kShuffle,                N::kWarp,        A::kOld,        L::kShuffle},
    {"activemask",   O::kActiveMask,             N::kWarp,        A::kOld,        L::kActiveLanes},
    {"redux",        O::kReduceWarp,             N::kWarp,        A::kIntegers,   L::kReduce},
    {"elect",        O::kElect,                  N::kWarp},
    {"stacksave",    O::kSaveStack,              N::kWarpMemory},
    {"stackrestore", O::kRestoreStack,           N::kWarpMemory},
    {"alloca",       O::kAllocateStack,          N::kStack},
    // Asynchronous copies and barrier objects
    {"cp",           O::kCopyAsync,              N::kEffects},
    {"mbarrier",     O::kBarrierObject,          N::kEffects,     A::kNew,        L::kWait},
    {"griddepcontrol|setmaxnreg", O::kNothing,    N::kEffects},
    // Matrices of a warp
    {"wmma",         O::kWideMatrices,           N::kWarpMemory,  A::kOld,        L::kMatrix},
    {"mma",          O::kMultiplyMatrices,       N::kWarpMemory,  A::kNew,        L::kMatrix},
    {"ldmatrix|stmatrix", O::kMoveMatrixRows,    N::kWarpMemory,  A::kNew,        L::kMatrix},
    {"movmatrix",    O::kTransposeMatrix,        N::kWarpMemory,  A::kNew,        L::kMatrix},
    {"createpolicy", O::kNothing,                N::kEffects},
    // Units that only GPUs have
    {"wgmma|tcgen05|tensormap|multimem|mapa|getctarank|clusterlaunchcontrol",
                     O::kUnknown},
    // Video
    {"vadd|vsub|vabsdiff|vmin|vmax|vshl|vshr",
                     O::kVideoScalar,            N::kValue,       A::kOld},
    {"vmad",         O::kVideoMultiplyAdd,       N::kValue,       A::kOld},
    {"vset",         O::kVideoScalar,            N::kValue,       A::kOld},
    {"vadd2|vsub2|vavrg2|vabsdiff2|vmin2|vmax2|vset2",
                     O::kVideoPacked,            N::kValue,       A::kOld},
    {"vadd4|vsub4|vavrg4|vabsdiff4|vmin4|vmax4|vset4",
                     O::kVideoPacked,            N::kValue,       A::kOld},
};
// clang-format on
} // namespace opcode_columns

using opcode_columns::kOpcodeTexts;

} // namespace sunstone::ptx
