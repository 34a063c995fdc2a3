// SPDX-License-Identifier: Apache-2.0
// Operations with directed rounding. One assembly statement sets the rounding mode, computes, and
// restores the mode, so that a compiler cannot move or fold the operation. fma needs FMA3; without
// it the library's fma is used, which follows the mode.
#include "compiler/runtime/runtime.h"

#include <cfenv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <immintrin.h>

namespace sunstone::compiler {

namespace {

// Bits 13-14 of MXCSR.
enum Mode : unsigned { kDown = 1u << 13, kUp = 2u << 13, kZero = 3u << 13 };

// Sets the mode during the object's lifetime. The changes of mode and the operations between them
// are asm volatile, and volatile statements keep their order.
class ScopedMode {
public:
    explicit ScopedMode(unsigned mode) {
        asm volatile("stmxcsr %0" : "=m"(saved_));
        const unsigned changed = (saved_ & ~(3u << 13 | 1u << 15 | 1u << 6)) | mode;
        asm volatile("ldmxcsr %0" : : "m"(changed));
    }
    ~ScopedMode() { asm volatile("ldmxcsr %0" : : "m"(saved_)); }
    ScopedMode(const ScopedMode&) = delete;
    ScopedMode& operator=(const ScopedMode&) = delete;

private:
    unsigned saved_;
};

#define SUNSTONE_BINARY(name, mnemonic)                                                            \
    template <unsigned mode>                                                                       \
    float name(float a, float b) {                                                                 \
        ScopedMode scope(mode);                                                                    \
        asm volatile(mnemonic "ss %1, %0" : "+x"(a) : "x"(b));                                     \
        return a;                                                                                  \
    }                                                                                              \
    template <unsigned mode>                                                                       \
    double name(double a, double b) {                                                              \
        ScopedMode scope(mode);                                                                    \
        asm volatile(mnemonic "sd %1, %0" : "+x"(a) : "x"(b));                                     \
        return a;                                                                                  \
    }
SUNSTONE_BINARY(addRounded, "add")
SUNSTONE_BINARY(subRounded, "sub")
SUNSTONE_BINARY(mulRounded, "mul")
SUNSTONE_BINARY(divRounded, "div")
#undef SUNSTONE_BINARY

template <unsigned mode>
float sqrtRounded(float a) {
    ScopedMode scope(mode);
    asm volatile("sqrtss %0, %0" : "+x"(a));
    return a;
}
template <unsigned mode>
double sqrtRounded(double a) {
    ScopedMode scope(mode);
    asm volatile("sqrtsd %0, %0" : "+x"(a));
    return a;
}

template <unsigned mode, class T>
T fmaByLibrary(T a, T b, T c) {
    const int direction = mode == kDown ? FE_DOWNWARD : mode == kUp ? FE_UPWARD : FE_TOWARDZERO;
    const int saved = std::fegetround();
    std::fesetround(direction);
    volatile T x = a, y = b, z = c;
    volatile T result = std::fma(x, y, z);
    std::fesetround(saved);
    return result;
}

bool hasFma() {
    static const bool has = __builtin_cpu_supports("fma");
    return has;
}

template <unsigned mode>
float fmaRounded(float a, float b, float c) {
    if (!hasFma())
        return fmaByLibrary<mode>(a, b, c);
    ScopedMode scope(mode);
    asm volatile("vfmadd213ss %2, %1, %0" : "+x"(a) : "x"(b), "x"(c));
    return a;
}
template <unsigned mode>
double fmaRounded(double a, double b, double c) {
    if (!hasFma())
        return fmaByLibrary<mode>(a, b, c);
    ScopedMode scope(mode);
    asm volatile("vfmadd213sd %2, %1, %0" : "+x"(a) : "x"(b), "x"(c));
    return a;
}

template <unsigned mode>
float narrow(double a) {
    ScopedMode scope(mode);
    float result = 0;
    asm volatile("cvtsd2ss %1, %0" : "+x"(result) : "x"(a));
    return result;
}

template <unsigned mode>
float fromSigned32(int64_t a) {
    ScopedMode scope(mode);
    float result = 0;
    asm volatile("cvtsi2ssq %1, %0" : "+x"(result) : "r"(a));
    return result;
}
template <unsigned mode>
double fromSigned64(int64_t a) {
    ScopedMode scope(mode);
    double result = 0;
    asm volatile("cvtsi2sdq %1, %0" : "+x"(result) : "r"(a));
    return result;
}
// Halves; the lost bit stays sticky, so the rounding does not change, and doubling the result is
// exact.
uint64_t halved(uint64_t a) {
    return (a >> 1) | (a & 1);
}

template <unsigned mode>
float fromUnsigned32(uint64_t a) {
    return int64_t(a) >= 0 ? fromSigned32<mode>(int64_t(a))
                           : 2.0f * fromSigned32<mode>(int64_t(halved(a)));
}
template <unsigned mode>
double fromUnsigned64(uint64_t a) {
    return int64_t(a) >= 0 ? fromSigned64<mode>(int64_t(a))
                           : 2.0 * fromSigned64<mode>(int64_t(halved(a)));
}

// Rounds a number to half precision by integer arithmetic on its double representation, which holds
// every float exactly. mode 0: to nearest even.
uint16_t toHalf(double value, unsigned mode) {
    uint64_t bits = 0;
    std::memcpy(&bits, &value, 8);
    const uint16_t sign = uint16_t(bits >> 48 & 0x8000);
    const uint64_t magnitude = bits & 0x7fffffffffffffffull;
    if (magnitude > 0x7ff0000000000000ull)
        return 0x7fff;
    if (magnitude == 0x7ff0000000000000ull)
        return uint16_t(sign | 0x7c00);
    if (magnitude == 0)
        return sign;
    const bool away = (mode == kUp && !sign) || (mode == kDown && sign);
    const int exponent = int(magnitude >> 52) - 1023;
    uint16_t overflow = uint16_t(mode == 0 || away ? 0x7c00 : 0x7bff);
    if (exponent > 15)
        return uint16_t(sign | overflow);
    // Units of the last place: 2^(e-10), or 2^-24 below the normal range.
    uint64_t mantissa = magnitude & 0xfffffffffffffull;
    mantissa |= magnitude >> 52 ? 1ull << 52 : 0;
    int drop = 42 + (exponent < -14 ? -14 - exponent : 0);
    if (drop > 63)
        drop = 63;
    const uint64_t kept = mantissa >> drop;
    const uint64_t rest = mantissa & ((1ull << drop) - 1);
    const uint64_t middle = 1ull << (drop - 1);
    bool increment = away && rest != 0;
    if (mode == 0)
        increment = rest > middle || (rest == middle && (kept & 1));
    uint64_t result = kept + (increment ? 1 : 0);
    if (exponent >= -14)
        result += uint64_t(exponent + 14) << 10; // the implicit bit adds the remaining one
    return uint16_t(sign | (result >= 0x7c00 ? overflow : uint16_t(result)));
}

template <unsigned mode>
uint16_t halfFromFloat(float a) {
    return toHalf(a, mode);
}
template <unsigned mode>
uint16_t halfFromDouble(double a) {
    return toHalf(a, mode);
}

uint16_t brainFromFloat(float a, bool nearest) {
    uint32_t bits = 0;
    std::memcpy(&bits, &a, 4);
    if ((bits & 0x7fffffffu) > 0x7f800000u)
        return 0x7fff;
    if (nearest)
        bits += 0x7fff + (bits >> 16 & 1);
    return uint16_t(bits >> 16);
}
uint16_t brainNearest(float a) {
    return brainFromFloat(a, true);
}
uint16_t brainZero(float a) {
    return brainFromFloat(a, false);
}

template <class Function>
const void* addressOf(Function* function) {
    return reinterpret_cast<const void*>(function);
}

template <unsigned mode>
void addMode(std::vector<RuntimeSymbol>& symbols, const char* const (&names)[19]) {
    size_t i = 0;
    const auto add = [&](const void* address) { symbols.push_back({names[i++], address}); };
    add(addressOf<float(float, float)>(addRounded<mode>));
    add(addressOf<double(double, double)>(addRounded<mode>));
    add(addressOf<float(float, float)>(subRounded<mode>));
    add(addressOf<double(double, double)>(subRounded<mode>));
    add(addressOf<float(float, float)>(mulRounded<mode>));
    add(addressOf<double(double, double)>(mulRounded<mode>));
    add(addressOf<float(float, float)>(divRounded<mode>));
    add(addressOf<double(double, double)>(divRounded<mode>));
    add(addressOf<float(float)>(sqrtRounded<mode>));
    add(addressOf<double(double)>(sqrtRounded<mode>));
    add(addressOf<float(float, float, float)>(fmaRounded<mode>));
    add(addressOf<double(double, double, double)>(fmaRounded<mode>));
    add(addressOf<float(double)>(narrow<mode>));
    add(addressOf<float(int64_t)>(fromSigned32<mode>));
    add(addressOf<float(uint64_t)>(fromUnsigned32<mode>));
    add(addressOf<double(int64_t)>(fromSigned64<mode>));
    add(addressOf<double(uint64_t)>(fromUnsigned64<mode>));
    add(addressOf<uint16_t(float)>(halfFromFloat<mode>));
    add(addressOf<uint16_t(double)>(halfFromDouble<mode>));
}

#define SUNSTONE_MODE_NAMES(mode)                                                                  \
    {                                                                                              \
        "sunstone_add_" mode "_f32", "sunstone_add_" mode "_f64", "sunstone_sub_" mode "_f32",     \
            "sunstone_sub_" mode "_f64", "sunstone_mul_" mode "_f32", "sunstone_mul_" mode "_f64", \
            "sunstone_div_" mode "_f32", "sunstone_div_" mode "_f64",                              \
            "sunstone_sqrt_" mode "_f32", "sunstone_sqrt_" mode "_f64",                            \
            "sunstone_fma_" mode "_f32", "sunstone_fma_" mode "_f64",                              \
            "sunstone_cvt_" mode "_f32_f64", "sunstone_cvt_" mode "_f32_s64",                      \
            "sunstone_cvt_" mode "_f32_u64", "sunstone_cvt_" mode "_f64_s64",                      \
            "sunstone_cvt_" mode "_f64_u64", "sunstone_cvt_" mode "_f16_f32",                      \
            "sunstone_cvt_" mode "_f16_f64"                                                        \
    }

// The function that the code generator calls for `fptrunc` to half; half travels in an SSE
// register.
typedef float __attribute__((vector_size(16))) Lanes;
Lanes asLanes(uint16_t half) {
    const __m128i lanes = _mm_cvtsi32_si128(half);
    Lanes result;
    std::memcpy(&result, &lanes, 16);
    return result;
}
Lanes truncSingle(float a) {
    return asLanes(toHalf(a, 0));
}
Lanes truncDouble(double a) {
    return asLanes(toHalf(a, 0));
}

float extendHalf(Lanes half) {
    uint16_t bits = 0;
    std::memcpy(&bits, &half, 2);
    const uint32_t sign = uint32_t(bits & 0x8000) << 16;
    const uint32_t exponent = bits >> 10 & 31;
    const uint32_t mantissa = bits & 1023;
    uint32_t result = 0;
    if (exponent == 31) {
        result = sign | 0x7f800000u | mantissa << 13;
    } else if (exponent != 0) {
        result = sign | (exponent + 112) << 23 | mantissa << 13;
    } else {
        const float value = float(mantissa) * 0x1p-24f;
        std::memcpy(&result, &value, 4);
        result |= sign;
    }
    float value = 0;
    std::memcpy(&value, &result, 4);
    return value;
}

} // namespace

void addRoundingSymbols(std::vector<RuntimeSymbol>& symbols) {
    static const char* const kDownNames[19] = SUNSTONE_MODE_NAMES("rm");
    static const char* const kUpNames[19] = SUNSTONE_MODE_NAMES("rp");
    static const char* const kZeroNames[19] = SUNSTONE_MODE_NAMES("rz");
    addMode<kDown>(symbols, kDownNames);
    addMode<kUp>(symbols, kUpNames);
    addMode<kZero>(symbols, kZeroNames);
    symbols.push_back({"sunstone_bf16_rn_f32", addressOf(brainNearest)});
    symbols.push_back({"sunstone_bf16_rz_f32", addressOf(brainZero)});
    symbols.push_back({"__truncsfhf2", addressOf(truncSingle)});
    symbols.push_back({"__truncdfhf2", addressOf(truncDouble)});
    symbols.push_back({"__extendhfsf2", addressOf(extendHalf)});
}

} // namespace sunstone::compiler
