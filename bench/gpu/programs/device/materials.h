// SPDX-License-Identifier: Apache-2.0
// MATERIAL(n) for all n below MATERIALS, which is 2, 4, 8, 16 or 200.
#define FOUR(a, b, c, d) MATERIAL(a) MATERIAL(b) MATERIAL(c) MATERIAL(d)
#define TEN(t)                                                                                     \
    FOUR(t##0, t##1, t##2, t##3) FOUR(t##4, t##5, t##6, t##7) MATERIAL(t##8) MATERIAL(t##9)
MATERIAL(0)
MATERIAL(1)
#if MATERIALS > 2
MATERIAL(2)
MATERIAL(3)
#endif
#if MATERIALS > 4
FOUR(4, 5, 6, 7)
#endif
#if MATERIALS > 8
MATERIAL(8)
MATERIAL(9)
FOUR(10, 11, 12, 13)
MATERIAL(14)
MATERIAL(15)
#endif
#if MATERIALS > 16
FOUR(16, 17, 18, 19)
TEN(2)
TEN(3)
TEN(4)
TEN(5)
TEN(6)
TEN(7)
TEN(8)
TEN(9)
TEN(10)
TEN(11)
TEN(12)
TEN(13)
TEN(14)
TEN(15)
TEN(16)
TEN(17)
TEN(18)
TEN(19)
#endif
