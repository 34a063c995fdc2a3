// SPDX-License-Identifier: Apache-2.0
// Functions of the C library and of compilers' support libraries that the code generator may call
// for the types of compiled code: integers of up to 128 bits, half, float, double. Which ones it
// calls depends on the processor. library_test.cpp compares the list with LLVM's. The conversions
// of half are in rounding.cpp.
#include "compiler/runtime/runtime.h"

#include <cmath>
#include <cstring>
#include <iterator>

namespace sunstone::compiler {

namespace {

using Wide = __int128;
using UnsignedWide = unsigned __int128;

template <class Function>
const void* addressOf(Function* function) {
    return reinterpret_cast<const void*>(function);
}

// For lambdas without captures.
template <class Lambda>
const void* codeOf(Lambda lambda) {
    return addressOf(+lambda);
}

template <class Real>
Real power(Real base, int exponent) {
    Real result = 1;
    for (auto left = exponent < 0 ? 0u - unsigned(exponent) : unsigned(exponent); left;
         left >>= 1) {
        if (left & 1)
            result *= base;
        base *= base;
    }
    return exponent < 0 ? 1 / result : result;
}

void addWideSymbols(std::vector<RuntimeSymbol>& symbols) {
    const RuntimeSymbol own[] = {
        {"__ashlti3", codeOf([](UnsignedWide a, int by) { return a << by; })},
        {"__lshrti3", codeOf([](UnsignedWide a, int by) { return a >> by; })},
        {"__ashrti3", codeOf([](Wide a, int by) { return a >> by; })},
        {"__multi3", codeOf([](UnsignedWide a, UnsignedWide b) { return a * b; })},
        {"__muloti4", codeOf([](Wide a, Wide b, int* overflows) {
             Wide product = 0;
             *overflows = __builtin_mul_overflow(a, b, &product);
             return product;
         })},
        {"__divti3", codeOf([](Wide a, Wide b) { return a / b; })},
        {"__modti3", codeOf([](Wide a, Wide b) { return a % b; })},
        {"__udivti3", codeOf([](UnsignedWide a, UnsignedWide b) { return a / b; })},
        {"__umodti3", codeOf([](UnsignedWide a, UnsignedWide b) { return a % b; })},
        {"__fixsfti", codeOf([](float a) { return Wide(a); })},
        {"__fixdfti", codeOf([](double a) { return Wide(a); })},
        {"__fixunssfti", codeOf([](float a) { return UnsignedWide(a); })},
        {"__fixunsdfti", codeOf([](double a) { return UnsignedWide(a); })},
        {"__floattisf", codeOf([](Wide a) { return float(a); })},
        {"__floattidf", codeOf([](Wide a) { return double(a); })},
        {"__floatuntisf", codeOf([](UnsignedWide a) { return float(a); })},
        {"__floatuntidf", codeOf([](UnsignedWide a) { return double(a); })},
    };
    symbols.insert(symbols.end(), std::begin(own), std::end(own));
}

#define SUNSTONE_UNARY(name)                                                                       \
    {#name, addressOf<double(double)>(::name)}, {                                                  \
        #name "f", addressOf<float(float)>(::name##f)                                              \
    }
#define SUNSTONE_BINARY(name)                                                                      \
    {#name, addressOf<double(double, double)>(::name)}, {                                          \
        #name "f", addressOf<float(float, float)>(::name##f)                                       \
    }
#define SUNSTONE_INTEGER(type, name)                                                               \
    {#name, addressOf<type(double)>(::name)}, {                                                    \
        #name "f", addressOf<type(float)>(::name##f)                                               \
    }

void addRealSymbols(std::vector<RuntimeSymbol>& symbols) {
    const RuntimeSymbol own[] = {
        SUNSTONE_UNARY(sqrt),
        SUNSTONE_UNARY(cbrt),
        SUNSTONE_UNARY(log),
        SUNSTONE_UNARY(log2),
        SUNSTONE_UNARY(log10),
        SUNSTONE_UNARY(exp),
        SUNSTONE_UNARY(exp2),
        SUNSTONE_UNARY(exp10),
        SUNSTONE_UNARY(sin),
        SUNSTONE_UNARY(cos),
        SUNSTONE_UNARY(tan),
        SUNSTONE_UNARY(sinh),
        SUNSTONE_UNARY(cosh),
        SUNSTONE_UNARY(tanh),
        SUNSTONE_UNARY(asin),
        SUNSTONE_UNARY(acos),
        SUNSTONE_UNARY(atan),
        SUNSTONE_UNARY(ceil),
        SUNSTONE_UNARY(trunc),
        SUNSTONE_UNARY(rint),
        SUNSTONE_UNARY(nearbyint),
        SUNSTONE_UNARY(round),
        SUNSTONE_UNARY(floor),
        SUNSTONE_BINARY(fmod),
        SUNSTONE_BINARY(pow),
        SUNSTONE_BINARY(copysign),
        SUNSTONE_BINARY(fmin),
        SUNSTONE_BINARY(fmax),
        SUNSTONE_INTEGER(long, lround),
        SUNSTONE_INTEGER(long long, llround),
        SUNSTONE_INTEGER(long, lrint),
        SUNSTONE_INTEGER(long long, llrint),
        // With the default rounding mode these have the results of roundeven.
        {"roundeven", addressOf<double(double)>(::nearbyint)},
        {"roundevenf", addressOf<float(float)>(::nearbyintf)},
        {"fma", addressOf<double(double, double, double)>(::fma)},
        {"fmaf", addressOf<float(float, float, float)>(::fmaf)},
        {"ldexp", addressOf<double(double, int)>(::ldexp)},
        {"ldexpf", addressOf<float(float, int)>(::ldexpf)},
        {"frexp", addressOf<double(double, int*)>(::frexp)},
        {"frexpf", addressOf<float(float, int*)>(::frexpf)},
        {"sincos", addressOf<void(double, double*, double*)>(::sincos)},
        {"sincosf", addressOf<void(float, float*, float*)>(::sincosf)},
        {"__powidf2", addressOf(power<double>)},
        {"__powisf2", addressOf(power<float>)},
    };
    symbols.insert(symbols.end(), std::begin(own), std::end(own));
}

#undef SUNSTONE_UNARY
#undef SUNSTONE_BINARY
#undef SUNSTONE_INTEGER

} // namespace

void addLibrarySymbols(std::vector<RuntimeSymbol>& symbols) {
    addWideSymbols(symbols);
    addRealSymbols(symbols);
    symbols.push_back({"memcpy", addressOf<void*(void*, const void*, size_t)>(std::memcpy)});
    symbols.push_back({"memmove", addressOf<void*(void*, const void*, size_t)>(std::memmove)});
    symbols.push_back({"memset", addressOf<void*(void*, int, size_t)>(std::memset)});
}

} // namespace sunstone::compiler
