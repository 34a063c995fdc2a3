// SPDX-License-Identifier: Apache-2.0
// The conditions of <nv/target> for code that is compiled for devices alone, as NVRTC's is: each is
// 1 or 0, and NV_IF_TARGET selects one of two pieces of code in parentheses. The include guard
// __NV_TARGET_H disables a toolkit's <nv/target>. Source: CCCL documentation, "nv/target".
#ifndef SUNSTONE_TARGET_H
#define SUNSTONE_TARGET_H
#ifndef __NV_TARGET_H
#define __NV_TARGET_H

#define NV_IS_HOST 0
#define NV_IS_DEVICE 1
#define NV_ANY_TARGET 1
#define NV_NO_TARGET 0
// Features of a single architecture, which code for a family lacks.
#define NV_HAS_FEATURE_SM_90a 0
#define NV_HAS_FEATURE_SM_100a 0
#define NV_HAS_FEATURE_SM_101a 0
#define NV_HAS_FEATURE_SM_103a 0
#define NV_HAS_FEATURE_SM_110a 0
#define NV_HAS_FEATURE_SM_120a 0
#define NV_HAS_FEATURE_SM_100f 0
#define NV_HAS_FEATURE_SM_101f 0
#define NV_HAS_FEATURE_SM_103f 0
#define NV_HAS_FEATURE_SM_110f 0
#define NV_HAS_FEATURE_SM_120f 0

#if __CUDA_ARCH__ >= 350
#define NV_PROVIDES_SM_35 1
#else
#define NV_PROVIDES_SM_35 0
#endif
#if __CUDA_ARCH__ >= 370
#define NV_PROVIDES_SM_37 1
#else
#define NV_PROVIDES_SM_37 0
#endif
#if __CUDA_ARCH__ >= 500
#define NV_PROVIDES_SM_50 1
#else
#define NV_PROVIDES_SM_50 0
#endif
#if __CUDA_ARCH__ >= 520
#define NV_PROVIDES_SM_52 1
#else
#define NV_PROVIDES_SM_52 0
#endif
#if __CUDA_ARCH__ >= 530
#define NV_PROVIDES_SM_53 1
#else
#define NV_PROVIDES_SM_53 0
#endif
#if __CUDA_ARCH__ >= 600
#define NV_PROVIDES_SM_60 1
#else
#define NV_PROVIDES_SM_60 0
#endif
#if __CUDA_ARCH__ >= 610
#define NV_PROVIDES_SM_61 1
#else
#define NV_PROVIDES_SM_61 0
#endif
#if __CUDA_ARCH__ >= 620
#define NV_PROVIDES_SM_62 1
#else
#define NV_PROVIDES_SM_62 0
#endif
#if __CUDA_ARCH__ >= 700
#define NV_PROVIDES_SM_70 1
#else
#define NV_PROVIDES_SM_70 0
#endif
#if __CUDA_ARCH__ >= 720
#define NV_PROVIDES_SM_72 1
#else
#define NV_PROVIDES_SM_72 0
#endif
#if __CUDA_ARCH__ >= 750
#define NV_PROVIDES_SM_75 1
#else
#define NV_PROVIDES_SM_75 0
#endif
#if __CUDA_ARCH__ >= 800
#define NV_PROVIDES_SM_80 1
#else
#define NV_PROVIDES_SM_80 0
#endif
#if __CUDA_ARCH__ >= 860
#define NV_PROVIDES_SM_86 1
#else
#define NV_PROVIDES_SM_86 0
#endif
#if __CUDA_ARCH__ >= 870
#define NV_PROVIDES_SM_87 1
#else
#define NV_PROVIDES_SM_87 0
#endif
#if __CUDA_ARCH__ >= 880
#define NV_PROVIDES_SM_88 1
#else
#define NV_PROVIDES_SM_88 0
#endif
#if __CUDA_ARCH__ >= 890
#define NV_PROVIDES_SM_89 1
#else
#define NV_PROVIDES_SM_89 0
#endif
#if __CUDA_ARCH__ >= 900
#define NV_PROVIDES_SM_90 1
#else
#define NV_PROVIDES_SM_90 0
#endif
#if __CUDA_ARCH__ >= 1000
#define NV_PROVIDES_SM_100 1
#else
#define NV_PROVIDES_SM_100 0
#endif
#if __CUDA_ARCH__ >= 1010
#define NV_PROVIDES_SM_101 1
#else
#define NV_PROVIDES_SM_101 0
#endif
#if __CUDA_ARCH__ >= 1030
#define NV_PROVIDES_SM_103 1
#else
#define NV_PROVIDES_SM_103 0
#endif
#if __CUDA_ARCH__ >= 1100
#define NV_PROVIDES_SM_110 1
#else
#define NV_PROVIDES_SM_110 0
#endif
#if __CUDA_ARCH__ >= 1200
#define NV_PROVIDES_SM_120 1
#else
#define NV_PROVIDES_SM_120 0
#endif
#if __CUDA_ARCH__ >= 1210
#define NV_PROVIDES_SM_121 1
#else
#define NV_PROVIDES_SM_121 0
#endif

#if __CUDA_ARCH__ == 350
#define NV_IS_EXACTLY_SM_35 1
#else
#define NV_IS_EXACTLY_SM_35 0
#endif
#if __CUDA_ARCH__ == 370
#define NV_IS_EXACTLY_SM_37 1
#else
#define NV_IS_EXACTLY_SM_37 0
#endif
#if __CUDA_ARCH__ == 500
#define NV_IS_EXACTLY_SM_50 1
#else
#define NV_IS_EXACTLY_SM_50 0
#endif
#if __CUDA_ARCH__ == 520
#define NV_IS_EXACTLY_SM_52 1
#else
#define NV_IS_EXACTLY_SM_52 0
#endif
#if __CUDA_ARCH__ == 530
#define NV_IS_EXACTLY_SM_53 1
#else
#define NV_IS_EXACTLY_SM_53 0
#endif
#if __CUDA_ARCH__ == 600
#define NV_IS_EXACTLY_SM_60 1
#else
#define NV_IS_EXACTLY_SM_60 0
#endif
#if __CUDA_ARCH__ == 610
#define NV_IS_EXACTLY_SM_61 1
#else
#define NV_IS_EXACTLY_SM_61 0
#endif
#if __CUDA_ARCH__ == 620
#define NV_IS_EXACTLY_SM_62 1
#else
#define NV_IS_EXACTLY_SM_62 0
#endif
#if __CUDA_ARCH__ == 700
#define NV_IS_EXACTLY_SM_70 1
#else
#define NV_IS_EXACTLY_SM_70 0
#endif
#if __CUDA_ARCH__ == 720
#define NV_IS_EXACTLY_SM_72 1
#else
#define NV_IS_EXACTLY_SM_72 0
#endif
#if __CUDA_ARCH__ == 750
#define NV_IS_EXACTLY_SM_75 1
#else
#define NV_IS_EXACTLY_SM_75 0
#endif
#if __CUDA_ARCH__ == 800
#define NV_IS_EXACTLY_SM_80 1
#else
#define NV_IS_EXACTLY_SM_80 0
#endif
#if __CUDA_ARCH__ == 860
#define NV_IS_EXACTLY_SM_86 1
#else
#define NV_IS_EXACTLY_SM_86 0
#endif
#if __CUDA_ARCH__ == 870
#define NV_IS_EXACTLY_SM_87 1
#else
#define NV_IS_EXACTLY_SM_87 0
#endif
#if __CUDA_ARCH__ == 880
#define NV_IS_EXACTLY_SM_88 1
#else
#define NV_IS_EXACTLY_SM_88 0
#endif
#if __CUDA_ARCH__ == 890
#define NV_IS_EXACTLY_SM_89 1
#else
#define NV_IS_EXACTLY_SM_89 0
#endif
#if __CUDA_ARCH__ == 900
#define NV_IS_EXACTLY_SM_90 1
#else
#define NV_IS_EXACTLY_SM_90 0
#endif
#if __CUDA_ARCH__ == 1000
#define NV_IS_EXACTLY_SM_100 1
#else
#define NV_IS_EXACTLY_SM_100 0
#endif
#if __CUDA_ARCH__ == 1010
#define NV_IS_EXACTLY_SM_101 1
#else
#define NV_IS_EXACTLY_SM_101 0
#endif
#if __CUDA_ARCH__ == 1030
#define NV_IS_EXACTLY_SM_103 1
#else
#define NV_IS_EXACTLY_SM_103 0
#endif
#if __CUDA_ARCH__ == 1100
#define NV_IS_EXACTLY_SM_110 1
#else
#define NV_IS_EXACTLY_SM_110 0
#endif
#if __CUDA_ARCH__ == 1200
#define NV_IS_EXACTLY_SM_120 1
#else
#define NV_IS_EXACTLY_SM_120 0
#endif
#if __CUDA_ARCH__ == 1210
#define NV_IS_EXACTLY_SM_121 1
#else
#define NV_IS_EXACTLY_SM_121 0
#endif

// Code may be in parentheses. OPEN is then called; otherwise its name remains, and the prefix NO_
// removes it.
#define SUNSTONE_TARGET_OPEN(...) SUNSTONE_TARGET_OPEN __VA_ARGS__
#define NO_SUNSTONE_TARGET_OPEN
#define SUNSTONE_TARGET_CUT_(...) NO_##__VA_ARGS__
#define SUNSTONE_TARGET_CUT(...) SUNSTONE_TARGET_CUT_(__VA_ARGS__)
#define SUNSTONE_TARGET_BLOCK(...) {SUNSTONE_TARGET_CUT(SUNSTONE_TARGET_OPEN __VA_ARGS__)}
#define SUNSTONE_TARGET_JOINED(a, b) a##b
#define SUNSTONE_TARGET_JOIN(a, b) SUNSTONE_TARGET_JOINED(a, b)
#define SUNSTONE_TARGET_IF_1(yes, ...) SUNSTONE_TARGET_BLOCK(yes)
#define SUNSTONE_TARGET_IF_0(yes, no, ...) SUNSTONE_TARGET_BLOCK(no)

// NV_IF_TARGET(condition, (code), (other code)); the last may be missing.
#define NV_IF_TARGET(condition, ...)                                                               \
    SUNSTONE_TARGET_JOIN(SUNSTONE_TARGET_IF_, condition)(__VA_ARGS__, (), )
#define NV_IF_ELSE_TARGET(condition, yes, no)                                                      \
    SUNSTONE_TARGET_JOIN(SUNSTONE_TARGET_IF_, condition)(yes, no, )

// NV_DISPATCH_TARGET(condition, (code), condition, (code), ...): the code of the first true
// condition. Macros cannot call themselves, so each pair has macros of its own.
#define NV_DISPATCH_TARGET(...) SUNSTONE_TARGET_PAIR_0(__VA_ARGS__, 1, (), )
#define SUNSTONE_TARGET_PAIR_0(condition, code, ...)                                                \
    SUNSTONE_TARGET_JOIN(SUNSTONE_TARGET_TAKE_0_, condition)(code, __VA_ARGS__)
#define SUNSTONE_TARGET_TAKE_0_1(code, ...) SUNSTONE_TARGET_BLOCK(code)
#define SUNSTONE_TARGET_TAKE_0_0(code, ...) SUNSTONE_TARGET_PAIR_1(__VA_ARGS__)
#define SUNSTONE_TARGET_PAIR_1(condition, code, ...)                                                \
    SUNSTONE_TARGET_JOIN(SUNSTONE_TARGET_TAKE_1_, condition)(code, __VA_ARGS__)
#define SUNSTONE_TARGET_TAKE_1_1(code, ...) SUNSTONE_TARGET_BLOCK(code)
#define SUNSTONE_TARGET_TAKE_1_0(code, ...) SUNSTONE_TARGET_PAIR_2(__VA_ARGS__)
#define SUNSTONE_TARGET_PAIR_2(condition, code, ...)                                                \
    SUNSTONE_TARGET_JOIN(SUNSTONE_TARGET_TAKE_2_, condition)(code, __VA_ARGS__)
#define SUNSTONE_TARGET_TAKE_2_1(code, ...) SUNSTONE_TARGET_BLOCK(code)
#define SUNSTONE_TARGET_TAKE_2_0(code, ...) SUNSTONE_TARGET_PAIR_3(__VA_ARGS__)
#define SUNSTONE_TARGET_PAIR_3(condition, code, ...)                                                \
    SUNSTONE_TARGET_JOIN(SUNSTONE_TARGET_TAKE_3_, condition)(code, __VA_ARGS__)
#define SUNSTONE_TARGET_TAKE_3_1(code, ...) SUNSTONE_TARGET_BLOCK(code)
#define SUNSTONE_TARGET_TAKE_3_0(code, ...) SUNSTONE_TARGET_PAIR_4(__VA_ARGS__)
#define SUNSTONE_TARGET_PAIR_4(condition, code, ...)                                                \
    SUNSTONE_TARGET_JOIN(SUNSTONE_TARGET_TAKE_4_, condition)(code, __VA_ARGS__)
#define SUNSTONE_TARGET_TAKE_4_1(code, ...) SUNSTONE_TARGET_BLOCK(code)
#define SUNSTONE_TARGET_TAKE_4_0(code, ...) SUNSTONE_TARGET_PAIR_5(__VA_ARGS__)
#define SUNSTONE_TARGET_PAIR_5(condition, code, ...)                                                \
    SUNSTONE_TARGET_JOIN(SUNSTONE_TARGET_TAKE_5_, condition)(code, __VA_ARGS__)
#define SUNSTONE_TARGET_TAKE_5_1(code, ...) SUNSTONE_TARGET_BLOCK(code)
#define SUNSTONE_TARGET_TAKE_5_0(code, ...) SUNSTONE_TARGET_PAIR_6(__VA_ARGS__)
#define SUNSTONE_TARGET_PAIR_6(condition, code, ...)                                                \
    SUNSTONE_TARGET_JOIN(SUNSTONE_TARGET_TAKE_6_, condition)(code, __VA_ARGS__)
#define SUNSTONE_TARGET_TAKE_6_1(code, ...) SUNSTONE_TARGET_BLOCK(code)
#define SUNSTONE_TARGET_TAKE_6_0(code, ...) SUNSTONE_TARGET_PAIR_7(__VA_ARGS__)
#define SUNSTONE_TARGET_PAIR_7(condition, code, ...)                                                \
    SUNSTONE_TARGET_JOIN(SUNSTONE_TARGET_TAKE_7_, condition)(code, __VA_ARGS__)
#define SUNSTONE_TARGET_TAKE_7_1(code, ...) SUNSTONE_TARGET_BLOCK(code)
#define SUNSTONE_TARGET_TAKE_7_0(code, ...) SUNSTONE_TARGET_PAIR_8(__VA_ARGS__)
#define SUNSTONE_TARGET_PAIR_8(condition, code, ...)                                                \
    SUNSTONE_TARGET_JOIN(SUNSTONE_TARGET_TAKE_8_, condition)(code, __VA_ARGS__)
#define SUNSTONE_TARGET_TAKE_8_1(code, ...) SUNSTONE_TARGET_BLOCK(code)
#define SUNSTONE_TARGET_TAKE_8_0(code, ...) SUNSTONE_TARGET_PAIR_9(__VA_ARGS__)
#define SUNSTONE_TARGET_PAIR_9(condition, code, ...)                                                \
    SUNSTONE_TARGET_JOIN(SUNSTONE_TARGET_TAKE_9_, condition)(code, __VA_ARGS__)
#define SUNSTONE_TARGET_TAKE_9_1(code, ...) SUNSTONE_TARGET_BLOCK(code)
#define SUNSTONE_TARGET_TAKE_9_0(code, ...)

// A name that CUB uses.
#define _NV_TARGET_DISPATCH NV_DISPATCH_TARGET

#endif
#endif
