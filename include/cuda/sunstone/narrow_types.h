// SPDX-License-Identifier: Apache-2.0
// The types of one 16-bit format and their conversions. Included once for each format, by a header
// that defines
//
//   SUNSTONE_NARROW, SUNSTONE_NARROW2   the types
//   SUNSTONE_WORD, SUNSTONE_WORD2       the words in the names of functions
//   SUNSTONE_FRACTION                   bits of the fraction
//   SUNSTONE_WIDEN                      bits to float
//   SUNSTONE_NEAREST                    float to bits, to nearest
#define SUNSTONE_PASTE_(a, b, c) a##b##c
#define SUNSTONE_PASTE(a, b, c) SUNSTONE_PASTE_(a, b, c)
#define SUNSTONE_RAW SUNSTONE_PASTE(SUNSTONE_NARROW, _raw, )
#define SUNSTONE_RAW2 SUNSTONE_PASTE(SUNSTONE_NARROW2, _raw, )

typedef struct __align__(2) { unsigned short x; } SUNSTONE_RAW;
typedef struct __align__(4) { unsigned short x, y; } SUNSTONE_RAW2;

struct __align__(2) SUNSTONE_NARROW {
    unsigned short __x;

    SUNSTONE_NARROW() = default;
    SUNSTONE_MEMBER constexpr SUNSTONE_NARROW(const SUNSTONE_RAW& raw) : __x(raw.x) {}
    SUNSTONE_MEMBER SUNSTONE_NARROW& operator=(const SUNSTONE_RAW& raw) {
        __x = raw.x;
        return *this;
    }
    SUNSTONE_MEMBER operator SUNSTONE_RAW() const { return SUNSTONE_RAW{__x}; }
    SUNSTONE_MEMBER operator SUNSTONE_RAW() const volatile { return SUNSTONE_RAW{__x}; }
    SUNSTONE_MEMBER operator float() const { return SUNSTONE_WIDEN(__x); }
#define SUNSTONE_FROM(T)                                                                           \
    SUNSTONE_MEMBER SUNSTONE_NARROW(T x)                                                           \
        : __x(sunstone_narrow::roundTo<SUNSTONE_FRACTION>(sunstone_narrow::exactly(x),             \
                                                          sunstone_narrow::Rounding::kNearest)) {} \
    SUNSTONE_MEMBER SUNSTONE_NARROW& operator=(T x) { return *this = SUNSTONE_NARROW(x); }
    SUNSTONE_FROM(float)
    SUNSTONE_FROM(double)
    SUNSTONE_FROM(short)
    SUNSTONE_FROM(unsigned short)
    SUNSTONE_FROM(int)
    SUNSTONE_FROM(unsigned int)
    SUNSTONE_FROM(long)
    SUNSTONE_FROM(unsigned long)
    SUNSTONE_FROM(long long)
    SUNSTONE_FROM(unsigned long long)
#undef SUNSTONE_FROM
    // To integers, towards zero.
#define SUNSTONE_TO(T)                                                                             \
    SUNSTONE_MEMBER operator T() const {                                                           \
        return sunstone_narrow::integerOf<T>(SUNSTONE_WIDEN(__x),                                      \
                                             sunstone_narrow::Rounding::kZero);                    \
    }
    SUNSTONE_TO(char)
    SUNSTONE_TO(signed char)
    SUNSTONE_TO(unsigned char)
    SUNSTONE_TO(short)
    SUNSTONE_TO(unsigned short)
    SUNSTONE_TO(int)
    SUNSTONE_TO(unsigned int)
    SUNSTONE_TO(long)
    SUNSTONE_TO(unsigned long)
    SUNSTONE_TO(long long)
    SUNSTONE_TO(unsigned long long)
#undef SUNSTONE_TO
    SUNSTONE_MEMBER operator bool() const { return (__x & 0x7fff) != 0; }
};

struct __align__(4) SUNSTONE_NARROW2 {
    SUNSTONE_NARROW x, y;

    SUNSTONE_NARROW2() = default;
    SUNSTONE_NARROW2(const SUNSTONE_NARROW2&) = default;
    SUNSTONE_NARROW2& operator=(const SUNSTONE_NARROW2&) = default;
    SUNSTONE_MEMBER constexpr SUNSTONE_NARROW2(const SUNSTONE_NARROW& a, const SUNSTONE_NARROW& b)
        : x(a), y(b) {}
    SUNSTONE_MEMBER SUNSTONE_NARROW2(const SUNSTONE_RAW2& raw)
        : x(SUNSTONE_RAW{raw.x}), y(SUNSTONE_RAW{raw.y}) {}
    SUNSTONE_MEMBER SUNSTONE_NARROW2& operator=(const SUNSTONE_RAW2& raw) {
        return *this = SUNSTONE_NARROW2(raw);
    }
    SUNSTONE_MEMBER operator SUNSTONE_RAW2() const { return SUNSTONE_RAW2{x.__x, y.__x}; }
};

#define SUNSTONE_NAME(before, after) SUNSTONE_PASTE(before, SUNSTONE_WORD, after)
#define SUNSTONE_NAME2(before, after) SUNSTONE_PASTE(before, SUNSTONE_WORD2, after)

namespace sunstone_narrow {

SUNSTONE_BOTH SUNSTONE_NARROW SUNSTONE_NAME(bitsTo_, )(unsigned short bits) {
    return SUNSTONE_NARROW(SUNSTONE_RAW{bits});
}
SUNSTONE_BOTH SUNSTONE_NARROW SUNSTONE_NAME(roundTo_, )(double x,
                                                       Rounding rounding = Rounding::kNearest) {
    return SUNSTONE_NAME(bitsTo_, )(roundTo<SUNSTONE_FRACTION>(x, rounding));
}
SUNSTONE_BOTH SUNSTONE_NARROW SUNSTONE_NAME(nearest_, )(float x) {
    return SUNSTONE_NAME(bitsTo_, )(SUNSTONE_NEAREST(x));
}
SUNSTONE_BOTH float widen(SUNSTONE_NARROW x) { return SUNSTONE_WIDEN(x.__x); }
SUNSTONE_BOTH bool isNan(SUNSTONE_NARROW x) {
    return (x.__x & 0x7fff) > (0x7fff >> SUNSTONE_FRACTION << SUNSTONE_FRACTION);
}

} // namespace sunstone_narrow

// ---- bits, halves and pairs -----------------------------------------------------------------------
SUNSTONE_BOTH short SUNSTONE_NAME(__, _as_short)(const SUNSTONE_NARROW x) { return (short)x.__x; }
SUNSTONE_BOTH unsigned short SUNSTONE_NAME(__, _as_ushort)(const SUNSTONE_NARROW x) {
    return x.__x;
}
SUNSTONE_BOTH SUNSTONE_NARROW SUNSTONE_NAME(__short_as_, )(const short x) {
    return sunstone_narrow::SUNSTONE_NAME(bitsTo_, )((unsigned short)x);
}
SUNSTONE_BOTH SUNSTONE_NARROW SUNSTONE_NAME(__ushort_as_, )(const unsigned short x) {
    return sunstone_narrow::SUNSTONE_NAME(bitsTo_, )(x);
}
SUNSTONE_BOTH SUNSTONE_NARROW2 SUNSTONE_NAME2(make_, )(SUNSTONE_NARROW x, SUNSTONE_NARROW y) {
    return SUNSTONE_NARROW2(x, y);
}
SUNSTONE_BOTH SUNSTONE_NARROW2 SUNSTONE_NAME2(__halves2, )(SUNSTONE_NARROW x, SUNSTONE_NARROW y) {
    return SUNSTONE_NARROW2(x, y);
}
SUNSTONE_BOTH SUNSTONE_NARROW2 SUNSTONE_PASTE(__, SUNSTONE_WORD, SUNSTONE_NAME2(2, ))(
    SUNSTONE_NARROW x) {
    return SUNSTONE_NARROW2(x, x);
}
SUNSTONE_BOTH SUNSTONE_NARROW SUNSTONE_NAME(__low2, )(SUNSTONE_NARROW2 x) { return x.x; }
SUNSTONE_BOTH SUNSTONE_NARROW SUNSTONE_NAME(__high2, )(SUNSTONE_NARROW2 x) { return x.y; }
SUNSTONE_BOTH SUNSTONE_NARROW2 SUNSTONE_NAME2(__low2, )(SUNSTONE_NARROW2 x) {
    return SUNSTONE_NARROW2(x.x, x.x);
}
SUNSTONE_BOTH SUNSTONE_NARROW2 SUNSTONE_NAME2(__high2, )(SUNSTONE_NARROW2 x) {
    return SUNSTONE_NARROW2(x.y, x.y);
}
SUNSTONE_BOTH SUNSTONE_NARROW2 SUNSTONE_NAME2(__lows2, )(SUNSTONE_NARROW2 x, SUNSTONE_NARROW2 y) {
    return SUNSTONE_NARROW2(x.x, y.x);
}
SUNSTONE_BOTH SUNSTONE_NARROW2 SUNSTONE_NAME2(__highs2, )(SUNSTONE_NARROW2 x, SUNSTONE_NARROW2 y) {
    return SUNSTONE_NARROW2(x.y, y.y);
}
SUNSTONE_BOTH SUNSTONE_NARROW2 __lowhigh2highlow(SUNSTONE_NARROW2 x) {
    return SUNSTONE_NARROW2(x.y, x.x);
}

// ---- floats ---------------------------------------------------------------------------------------
SUNSTONE_BOTH float SUNSTONE_NAME(__, 2float)(SUNSTONE_NARROW x) {
    return sunstone_narrow::widen(x);
}
SUNSTONE_BOTH float __low2float(SUNSTONE_NARROW2 x) { return sunstone_narrow::widen(x.x); }
SUNSTONE_BOTH float __high2float(SUNSTONE_NARROW2 x) { return sunstone_narrow::widen(x.y); }
SUNSTONE_BOTH float2 SUNSTONE_NAME2(__, 2float2)(SUNSTONE_NARROW2 x) {
    return make_float2(__low2float(x), __high2float(x));
}
#define SUNSTONE_ROUND(suffix, rounding)                                                           \
    SUNSTONE_BOTH SUNSTONE_NARROW SUNSTONE_NAME(__float2, suffix)(float x) {                       \
        return sunstone_narrow::SUNSTONE_NAME(roundTo_, )(x, sunstone_narrow::Rounding::rounding); \
    }
SUNSTONE_ROUND(_rz, kZero)
SUNSTONE_ROUND(_rd, kDown)
SUNSTONE_ROUND(_ru, kUp)
#undef SUNSTONE_ROUND
SUNSTONE_BOTH SUNSTONE_NARROW SUNSTONE_NAME(__float2, )(float x) {
    return sunstone_narrow::SUNSTONE_NAME(nearest_, )(x);
}
SUNSTONE_BOTH SUNSTONE_NARROW SUNSTONE_NAME(__float2, _rn)(float x) {
    return sunstone_narrow::SUNSTONE_NAME(nearest_, )(x);
}
SUNSTONE_BOTH SUNSTONE_NARROW SUNSTONE_NAME(__double2, )(double x) {
    return sunstone_narrow::SUNSTONE_NAME(roundTo_, )(x);
}
SUNSTONE_BOTH SUNSTONE_NARROW2 SUNSTONE_NAME2(__float2, _rn)(float x) {
    const SUNSTONE_NARROW r = SUNSTONE_NAME(__float2, )(x);
    return SUNSTONE_NARROW2(r, r);
}
SUNSTONE_BOTH SUNSTONE_NARROW2 SUNSTONE_NAME2(__floats2, _rn)(float x, float y) {
    return SUNSTONE_NARROW2(SUNSTONE_NAME(__float2, )(x), SUNSTONE_NAME(__float2, )(y));
}
SUNSTONE_BOTH SUNSTONE_NARROW2 SUNSTONE_NAME2(__float22, _rn)(float2 x) {
    return SUNSTONE_NAME2(__floats2, _rn)(x.x, x.y);
}

// ---- integers -------------------------------------------------------------------------------------
#define SUNSTONE_INTEGER(word, T, suffix, rounding)                                                \
    SUNSTONE_BOTH T SUNSTONE_NAME(__, 2##word##suffix)(SUNSTONE_NARROW x) {                        \
        return sunstone_narrow::integerOf<T>(sunstone_narrow::widen(x),                            \
                                             sunstone_narrow::Rounding::rounding);                 \
    }
#define SUNSTONE_INTEGERS(word, T, suffix, rounding)                                               \
    SUNSTONE_INTEGER(word, T, suffix, rounding)                                                    \
    SUNSTONE_BOTH SUNSTONE_NARROW SUNSTONE_NAME(__##word##2, suffix)(T x) {                        \
        return sunstone_narrow::SUNSTONE_NAME(roundTo_, )(sunstone_narrow::exactly(x),             \
                                                         sunstone_narrow::Rounding::rounding);     \
    }
#define SUNSTONE_ROUNDINGS(word, T)                                                                \
    SUNSTONE_INTEGERS(word, T, _rn, kNearest)                                                      \
    SUNSTONE_INTEGERS(word, T, _rz, kZero)                                                         \
    SUNSTONE_INTEGERS(word, T, _rd, kDown)                                                         \
    SUNSTONE_INTEGERS(word, T, _ru, kUp)
SUNSTONE_ROUNDINGS(short, short)
SUNSTONE_ROUNDINGS(ushort, unsigned short)
SUNSTONE_ROUNDINGS(int, int)
SUNSTONE_ROUNDINGS(uint, unsigned int)
SUNSTONE_ROUNDINGS(ll, long long)
SUNSTONE_ROUNDINGS(ull, unsigned long long)
SUNSTONE_INTEGER(char, signed char, _rz, kZero)
SUNSTONE_INTEGER(uchar, unsigned char, _rz, kZero)
#undef SUNSTONE_INTEGER
#undef SUNSTONE_INTEGERS
#undef SUNSTONE_ROUNDINGS
