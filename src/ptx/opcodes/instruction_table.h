// SPDX-License-Identifier: Apache-2.0
// The operands of instructions: one row for each form; instructions.cpp reads it. Each opcode has a
// row in opcode_table.h, too.
//
// opcodes    names that share the form, separated by |
// modifiers  groups separated by spaces: each a choice of modifiers, one of which must stand there,
//            or may if the group ends in ?. "*" stands for anything.
// types      per position the types allowed, separated by |
// operands   in order, separated by spaces:
//            0 1 2  value of that type position        W  value of twice the width of type 0
//            h r d  integer of 16, 32, 64 bits          p  predicate     P  predicate, or p|q
//            a  [address]   t  [texture, ...]   l  label   b  .branchtargets list
//            c  literal     m  operand of mov   x  anything
//            before: = destination, v vector of .vN elements; after: ? may be missing, + register
//            may be wider, | value|predicate allowed, _ may be _, & may be a symbol
#pragma once

namespace sunstone::ptx {

struct FormText {
    const char* opcodes;
    const char* modifiers;
    const char* types;
    const char* operands;
};

// clang-format off
#define INTS "u16|u32|u64|s16|s32|s64"
#define WORDS "u32|s32|u64|s64"
#define BITS "b16|b32|b64"
#define HALVES "f16|f16x2|bf16|bf16x2"
#define ROUND "rn|rz|rm|rp"
#define ROUND_INT "rni|rzi|rmi|rpi"
#define COMPARE "eq|ne|lt|le|gt|ge"
#define COMPARE_FLOAT "eq|ne|lt|le|gt|ge|equ|neu|ltu|leu|gtu|geu|num|nan"
#define BOOL "and|or|xor"
#define SCOPE "cta|cluster|gpu|sys"
#define SPACE "global|shared|shared::cta|shared::cluster|local|const|param|param::entry|param::func"
#define EVICT "L1::evict_normal|L1::evict_unchanged|L1::evict_first|L1::evict_last|L1::no_allocate|evict_normal|evict_first|evict_last"
#define EVICT2 "L2::evict_normal|L2::evict_first|L2::evict_last"
#define STORE_SPACE "global|shared|shared::cta|shared::cluster|local|param|param::func"
#define MEMORY(SPACES) "weak? volatile? mmio? relaxed|acquire|release? " SCOPE "? " SPACES "? v2|v4|v8? " EVICT "? " EVICT2 "? L2::cache_hint? L2::64B|L2::128B|L2::256B?"
#define MEMORY_TYPES "b8|b16|b32|b64|b128|u8|u16|u32|u64|s8|s16|s32|s64|f32|f64"
#define ATOMIC "relaxed|acquire|release|acq_rel? " SCOPE "? global|shared|shared::cta|shared::cluster? L2::cache_hint?"
#define BARRIER_SPACE "shared|shared::cta|shared::cluster?"
#define GEOMETRY "1d|2d|3d|a1d|a2d|cube|acube|2dms|a2dms"
#define CLAMP "trap|clamp|zero"
#define ALTERNATE "e4m3x2|e5m2x2|e4m3x4|e5m2x4|e2m1x2|e2m1x4|e2m3x2|e2m3x4|e3m2x2|e3m2x4|ue8m0x2|s2f6x2|tf32"

inline constexpr FormText kFormTexts[] = {
    // Integer and floating point arithmetic
    {"add|sub", "", "u16|u32|u64|s16|s64", "=0 0 0"},
    {"add|sub", "sat?", "s32", "=0 0 0"},
    {"add|sub", "u16x2|s16x2", "", "=r r r"},
    {"add|sub", "cc", WORDS, "=0 0 0"},
    {"addc|subc", "cc?", WORDS, "=0 0 0"},
    {"add|sub|mul", ROUND "? ftz? sat?", "f32", "=0 0 0"},
    {"add|sub|mul", ROUND "?", "f64", "=0 0 0"},
    {"add|sub|mul", "rn? ftz? sat?", HALVES, "=0 0 0"},
    {"add|sub|mul", ROUND "? ftz? f32x2", "", "=d d d"},
    {"add|sub", ROUND "? sat?", "f32 f16|bf16", "=0 1 0"},
    {"mul", "lo|hi", INTS, "=0 0 0"},
    {"mul", "wide", "u16|s16|u32|s32", "=W 0 0"},
    {"mad", "lo|hi", INTS, "=0 0 0 0"},
    {"mad", "hi sat", "s32", "=0 0 0 0"},
    {"mad", "wide", "u16|s16|u32|s32", "=W 0 0 W"},
    {"mad", "lo|hi cc", WORDS, "=0 0 0 0"},
    {"madc", "lo|hi cc?", WORDS, "=0 0 0 0"},
    {"mad|fma", ROUND " ftz? sat?", "f32", "=0 0 0 0"},
    {"mad|fma", ROUND, "f64", "=0 0 0 0"},
    {"fma", "rn ftz? sat? relu? oob?", HALVES, "=0 0 0 0"},
    {"fma", ROUND " ftz? f32x2", "", "=d d d d"},
    {"fma", ROUND " sat?", "f32 f16|bf16", "=0 1 1 0"},
    {"mul24", "lo|hi", "u32|s32", "=0 0 0"},
    {"mad24", "lo|hi", "u32|s32", "=0 0 0 0"},
    {"mad24", "hi sat", "s32", "=0 0 0 0"},
    {"sad", "", INTS, "=0 0 0 0"},
    {"div|rem", "", INTS, "=0 0 0"},
    {"div", "approx|full ftz?", "f32", "=0 0 0"},
    {"div", ROUND " ftz?", "f32", "=0 0 0"},
    {"div", ROUND, "f64", "=0 0 0"},
    {"abs|neg", "", "s16|s32|s64|f64|bf16|bf16x2", "=0 0"},
    {"abs|neg", "ftz?", "f32|f16|f16x2", "=0 0"},
    {"min|max", "", INTS "|f64", "=0 0 0"},
    {"min|max", "relu", "s32", "=0 0 0"},
    {"min|max", "relu? u16x2|s16x2", "", "=r r r"},
    {"min|max", "ftz? NaN? xorsign? abs?", "f32", "=0 0 0 0?"},
    {"min|max", "ftz? NaN? xorsign? abs?", HALVES, "=0 0 0"},
    {"rcp", "approx ftz?", "f32", "=0 0"},
    {"rcp|sqrt", ROUND " ftz?", "f32", "=0 0"},
    {"rcp|sqrt", ROUND, "f64", "=0 0"},
    {"rcp", "approx ftz", "f64", "=0 0"},
    {"sqrt|sin|cos|lg2", "approx ftz?", "f32", "=0 0"},
    {"rsqrt", "approx ftz?", "f32|f64", "=0 0"},
    {"ex2", "approx ftz?", "f32|f16|f16x2|bf16|bf16x2", "=0 0"},
    {"tanh", "approx", "f32|f16|f16x2|bf16|bf16x2", "=0 0"},
    {"copysign", "", "f32|f64", "=0 0 0"},
    {"testp", "finite|infinite|number|notanumber|normal|subnormal", "f32|f64", "=p 0"},
    {"dp4a", "", "u32|s32 u32|s32", "=r r r r"},
    {"dp2a", "lo|hi", "u32|s32 u32|s32", "=r r r r"},
    // Bits
    {"and|or|xor", "", "pred|" BITS, "=0 0 0"},
    {"not", "", "pred|" BITS, "=0 0"},
    {"cnot", "", BITS, "=0 0"},
    {"lop3", "", "b32", "=0 0 0 0 c"},
    {"lop3", "and|or", "b32", "=0|_ 0 0 0 c p"},
    {"shl", "", BITS, "=0 0 r"},
    {"shr", "", INTS "|" BITS, "=0 0 r"},
    {"shf", "l|r clamp|wrap", "b32", "=0 0 0 r"},
    {"popc|clz", "", "b32|b64", "=r 0"},
    {"bfind", "shiftamt?", WORDS, "=r 0"},
    {"brev", "", "b32|b64", "=0 0"},
    {"fns", "", "b32", "=0 0 0 0"},
    {"bfe", "", WORDS, "=0 0 r r"},
    {"bfi", "", "b32|b64", "=0 0 0 r r"},
    {"bmsk", "clamp|wrap", "b32", "=0 0 0"},
    {"szext", "clamp|wrap", "u32|s32", "=0 0 r"},
    {"prmt", "f4e|b4e|rc8|ecl|ecr|rc16?", "b32", "=0 0 0 0"},
    // Comparison and selection
    {"setp", "eq|ne", BITS, "=P 0 0"},
    {"setp", COMPARE, "s16|s32|s64", "=P 0 0"},
    {"setp", COMPARE "|lo|ls|hi|hs", "u16|u32|u64", "=P 0 0"},
    {"setp", COMPARE_FLOAT " ftz?", "f32|f64|" HALVES, "=P 0 0"},
    {"setp", "eq|ne " BOOL, BITS, "=P 0 0 p"},
    {"setp", COMPARE " " BOOL, "s16|s32|s64", "=P 0 0 p"},
    {"setp", COMPARE "|lo|ls|hi|hs " BOOL, "u16|u32|u64", "=P 0 0 p"},
    {"setp", COMPARE_FLOAT " " BOOL " ftz?", "f32|f64|" HALVES, "=P 0 0 p"},
    {"set", "eq|ne", "u32|s32|f32|u16|s16|" HALVES " " BITS, "=0 1 1"},
    {"set", COMPARE "|lo|ls|hi|hs", "u32|s32|f32|u16|s16|" HALVES " " INTS, "=0 1 1"},
    {"set", COMPARE_FLOAT " ftz?", "u32|s32|f32|u16|s16|" HALVES " f32|f64|" HALVES, "=0 1 1"},
    {"set", "eq|ne " BOOL, "u32|s32|f32|u16|s16|" HALVES " " BITS, "=0 1 1 p"},
    {"set", COMPARE "|lo|ls|hi|hs " BOOL, "u32|s32|f32|u16|s16|" HALVES " " INTS, "=0 1 1 p"},
    {"set", COMPARE_FLOAT " " BOOL " ftz?", "u32|s32|f32|u16|s16|" HALVES " f32|f64|" HALVES, "=0 1 1 p"},
    {"selp", "", INTS "|" BITS "|f32|f64", "=0 0 0 p"},
    {"slct", "ftz?", INTS "|" BITS "|f32|f64 s32|f32", "=0 0 0 1"},
    // Moves and conversions
    {"mov", "v2|v4?", "pred|" INTS "|" BITS "|b128|f32|f64", "=m m"},
    {"cvta", "to? " SPACE, "u32|u64", "=0 0&"},
    {"isspacep", SPACE, "", "=p d"},
    {"cvt", "sat?", "u8|s8|" INTS " u8|s8|" INTS, "=0+ 1+"},
    {"cvt", ROUND_INT " ftz? sat?", "u8|s8|" INTS " f32|f64|f16|bf16", "=0+ 1+"},
    {"cvt", ROUND " ftz? sat?", "f32|f64|f16|bf16 u8|s8|" INTS, "=0+ 1+"},
    {"cvt", ROUND " ftz? sat?", "f32 f64", "=0+ 1+"},
    {"cvt", ROUND " ftz? sat? relu? satfinite?", "f16|bf16 f32|f64", "=0+ 1+"},
    {"cvt", "ftz? sat?", "f64 f32|f16|bf16", "=0+ 1+"},
    {"cvt", "ftz? sat?", "f32 f16|bf16", "=0+ 1+"},
    {"cvt", ROUND_INT "? ftz? sat?", "f32 f32", "=0+ 1+"},
    {"cvt", ROUND_INT "? sat?", "f64 f64", "=0+ 1+"},
    {"cvt", ROUND "|" ROUND_INT "? ftz? sat?", "f16|bf16 f16|bf16", "=0+ 1+"},
    {"cvt", "rn|rz|rs relu? satfinite?", "f16x2|bf16x2 f32", "=0 1 1 r?"},
    {"cvt", ALTERNATE " rn|rz|rna|rp|rs? relu? satfinite? n1|n2? scaled? b?", "f32|f16x2|bf16x2", "=x x x? x?"},
    {"cvt", "rn|rz? relu? satfinite? " ALTERNATE, "f16x2|bf16x2", "=x x"},
    {"cvt", "pack sat", "u16|s16|u8|s8 s32", "=r r r"},
    {"cvt", "pack sat", "u8|s8 s32 b32", "=r r r r"},
    {"cvt", "pack sat u4|s4|u2|s2", "s32 b32", "=r r r r"},
    // Memory
    {"ld", MEMORY(SPACE) " ca|cg|cs|cv|lu? nc? unified?", MEMORY_TYPES, "=v0+_ a d?"},
    {"ldu", "global? v2|v4?", MEMORY_TYPES, "=v0+ a"},
    {"st", MEMORY(STORE_SPACE) " wb|cg|cs|wt?", MEMORY_TYPES, "a v0+ d?"},
    {"st", "async " MEMORY(STORE_SPACE) " mbarrier::complete_tx::bytes?", MEMORY_TYPES, "x x x?"},
    {"st", "bulk weak? shared::cta?", "", "a x x"},
    {"prefetch", "global|local|const|param? L1|L2|L2::evict_last|L2::evict_normal", "", "a"},
    {"prefetch", "tensormap const|param?", "", "a"},
    {"prefetchu", "L1", "", "a"},
    {"discard", "global? L2", "", "a c"},
    {"applypriority", "global? L2::evict_normal", "", "a c"},
    {"atom", ATOMIC " cas", "b16|b32|b64|b128", "=0_ a 0 0 d?"},
    {"atom", ATOMIC " exch", "b32|b64|b128", "=0_ a 0 d?"},
    {"atom", ATOMIC " and|or|xor", "b32|b64", "=0_ a 0 d?"},
    {"atom", ATOMIC " add", "u32|s32|u64|f32|f64", "=0_ a 0 d?"},
    {"atom", ATOMIC " inc|dec", "u32", "=0_ a 0 d?"},
    {"atom", ATOMIC " min|max", WORDS, "=0_ a 0 d?"},
    {"atom", ATOMIC " add noftz", HALVES, "=0_ a 0 d?"},
    {"atom", ATOMIC " add|min|max v2|v4|v8 noftz?", "f32|" HALVES, "=v0_ a v0 d?"},
    {"red", ATOMIC " and|or|xor", "b32|b64", "a 0 d?"},
    {"red", ATOMIC " add", "u32|s32|u64|f32|f64", "a 0 d?"},
    {"red", ATOMIC " inc|dec", "u32", "a 0 d?"},
    {"red", ATOMIC " min|max", WORDS, "a 0 d?"},
    {"red", ATOMIC " add noftz", HALVES, "a 0 d?"},
    {"red", ATOMIC " add|min|max v2|v4|v8 noftz?", "f32|" HALVES, "a v0 d?"},
    {"red", "async relaxed? cluster? shared::cluster? mbarrier::complete_tx::bytes? add|min|max|inc|dec|and|or|xor", "b32|u32|s32|u64", "a 0 a"},
    // Textures and surfaces
    {"tex", "level|grad|base? " GEOMETRY " v2|v4", "u32|s32|f32|f16|f16x2 s32|f32", "=v0| t x? x? x? x?"},
    {"tld4", "r|g|b|a 2d|a2d|cube|acube v4", "u32|s32|f32 s32|f32", "=v0| t x? x?"},
    {"txq", "level? width|height|depth|num_mipmap_levels|num_samples|array_size|channel_data_type|channel_order|normalized_coords|force_unnormalized_coords|filter_mode|addr_mode_0|addr_mode_1|addr_mode_2", "b32", "=0 a r?"},
    {"suq", "width|height|depth|array_size|channel_data_type|channel_order|memory_layout", "b32", "=0 a"},
    {"suld", "b|p " GEOMETRY " ca|cg|cs|cv? v2|v4? " CLAMP, "b8|b16|b32|b64", "=v0+ t"},
    {"sust", "b|p " GEOMETRY " wb|cg|cs|wt? v2|v4? " CLAMP, "b8|b16|b32|b64", "t v0+"},
    {"sured", "b|p add|min|max|and|or " GEOMETRY " " CLAMP, "u32|u64|s32|b32|s64|b64", "t 0"},
    {"istypep", "", "texref|samplerref|surfref", "=p d&"},
    // Control flow
    {"bra", "uni?", "", "l"},
    {"brx", "idx uni?", "", "r b"},
    {"call", "uni?", "", ""},
    {"ret", "uni?", "", ""},
    {"exit|trap|brkpt", "", "", ""},
    {"pmevent", "mask?", "", "c"},
    {"nanosleep", "", "u32", "0"},
    // Threads of a block and of a warp
    {"bar|barrier", "cta? sync aligned?", "", "r r?"},
    {"bar|barrier", "cta? arrive aligned?", "", "r r"},
    {"bar|barrier", "cta? red popc aligned?", "u32", "=0 r p"},
    {"bar|barrier", "cta? red popc aligned?", "u32", "=0 r r p"},
    {"bar|barrier", "cta? red and|or aligned?", "pred", "=0 r p"},
    {"bar|barrier", "cta? red and|or aligned?", "pred", "=0 r r p"},
    {"bar", "warp sync", "", "r"},
    {"barrier", "cluster arrive|wait release|relaxed|acquire? aligned?", "", ""},
    {"membar", "cta|gl|sys", "", ""},
    {"membar", "proxy alias|async|async.global", "", ""},
    {"fence", "sc|acq_rel|acquire|release? " SCOPE, "", ""},
    {"fence", "proxy alias|async|async::generic global|shared::cta|shared::cluster?", "", ""},
    {"fence", "proxy tensormap::generic acquire|release " SCOPE, "", "a? c?"},
    {"fence", "mbarrier_init release cluster", "", ""},
    {"fence", "acquire|release sync_restrict::shared::cluster|sync_restrict::shared::cta cluster", "", ""},
    {"vote", "all|any|uni", "pred", "=0 p"},
    {"vote", "sync all|any|uni", "pred", "=0 p r"},
    {"vote", "ballot", "b32", "=0 p"},
    {"vote", "sync ballot", "b32", "=0 p r"},
    {"match", "any sync", "b32|b64", "=r 0 r"},
    {"match", "all sync", "b32|b64", "=r|_ 0 r"},
    {"shfl", "up|down|bfly|idx", "b32", "=0|_ 0 r r"},
    {"shfl", "sync up|down|bfly|idx", "b32", "=0|_ 0 r r r"},
    {"activemask", "", "b32", "=0"},
    {"redux", "sync and|or|xor", "b32", "=0 0 r"},
    {"redux", "sync add|min|max", "u32|s32", "=0 0 r"},
    {"redux", "sync min|max abs? NaN?", "f32", "=0 0 r"},
    {"elect", "sync", "", "=r|_ r"},
    {"stacksave", "", "u32|u64", "=0"},
    {"stackrestore", "", "u32|u64", "0"},
    {"alloca", "", "u32|u64", "=0 0 c?"},
    // Asynchronous copies and barrier objects
    {"cp", "async ca|cg shared|shared::cta global L2::cache_hint? L2::64B|L2::128B|L2::256B?", "", "a a c x? x?"},
    {"cp", "async commit_group|wait_all", "", ""},
    {"cp", "async wait_group", "", "c"},
    {"cp", "async mbarrier arrive noinc? shared|shared::cta?", "b64", "a"},
    {"cp", "async bulk shared::cluster|shared::cta global mbarrier::complete_tx::bytes L2::cache_hint?", "", "a a r a x?"},
    {"cp", "async bulk shared::cluster shared::cta mbarrier::complete_tx::bytes", "", "a a r a"},
    {"cp", "async bulk global shared::cta bulk_group L2::cache_hint?", "", "a a r x?"},
    {"cp", "async bulk prefetch L2 global L2::cache_hint?", "", "a r x?"},
    {"cp", "async bulk commit_group", "", ""},
    {"cp", "async bulk wait_group read?", "", "c"},
    {"mbarrier", "init shared|shared::cta?", "b64", "a r"},
    {"mbarrier", "inval shared|shared::cta?", "b64", "a"},
    {"mbarrier", "arrive|arrive_drop expect_tx|noComplete? release|relaxed? cta|cluster? " BARRIER_SPACE, "b64", "=d_ a r?"},
    {"mbarrier", "expect_tx|complete_tx relaxed? cta|cluster? " BARRIER_SPACE, "b64", "a r"},
    {"mbarrier", "test_wait|try_wait acquire|relaxed? cta|cluster? shared|shared::cta?", "b64", "=p a d r?"},
    {"mbarrier", "test_wait|try_wait parity acquire|relaxed? cta|cluster? shared|shared::cta?", "b64", "=p a r r?"},
    {"mbarrier", "pending_count", "b64", "=r d"},
    {"griddepcontrol", "launch_dependents|wait", "", ""},
    // Matrices, instructions for GPU-only units, and video instructions: the names are known,
    // operands are unchecked. "=x": the first one is written unless it is an address.
    {"wmma|mma|ldmatrix|stmatrix|movmatrix|createpolicy", "*", "", "=x"},
    {"wgmma|tcgen05|tensormap|multimem|mapa|getctarank|setmaxnreg|clusterlaunchcontrol", "*", "", ""},
    {"vadd|vsub|vabsdiff|vmin|vmax|vshl|vshr|vmad|vset|vadd2|vsub2|vavrg2|vabsdiff2|vmin2|vmax2|vset2|"
     "vadd4|vsub4|vavrg4|vabsdiff4|vmin4|vmax4|vset4", "*", "", "=x"},
};
// clang-format on

} // namespace sunstone::ptx
