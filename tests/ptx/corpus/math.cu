// SPDX-License-Identifier: Apache-2.0
// Mathematical functions of single and double precision, with and without fast math.
extern "C" __global__ void single(float* v, int n) {
    float x = v[0], y = v[1];
    x = sinf(x) + cosf(y) * tanf(x);
    y = powf(x, y) + expf(x) - logf(y) + exp2f(x) * log2f(y);
    x += sqrtf(y) + rsqrtf(x) / cbrtf(y) + atan2f(x, y) + acosf(x) + asinf(y);
    y += fmaf(x, y, 1.5f) + floorf(x) + ceilf(y) + rintf(x) + truncf(y) + roundf(x);
    x += fminf(x, y) + fmaxf(x, 2.0f) + fabsf(y) + copysignf(x, y) + fmodf(x, y);
    y += __fadd_rz(x, y) + __fmul_ru(x, y) + __fdiv_rd(x, y) + __fsqrt_rn(x) + __frcp_rn(y);
    x += __sinf(y) + __expf(x) + __logf(y) + __powf(x, y) + __saturatef(x) + tanhf(y) + erff(x);
    int e;
    y += frexpf(x, &e) + ldexpf(y, n) + (isnan(x) ? 1.0f : isinf(y) ? 2.0f : 3.0f) + e;
    v[2] = x;
    v[3] = y;
}

extern "C" __global__ void twice(double* v, float* f, int n) {
    double x = v[0], y = v[1];
    x = sin(x) * cos(y) + exp(x) - log(y) + sqrt(x) / y + pow(x, y) + atan(x);
    y = fma(x, y, 2.5) + floor(y) + fmin(x, y) + (double)n + (double)f[0] + rint(x);
    v[2] = x;
    f[1] = (float)y;
    f[2] = __double2float_rz(x);
    v[3] = __longlong_as_double((long long)y);
}

extern "C" __global__ void integers(unsigned* v, unsigned long long* w, int n) {
    unsigned a = v[0], b = v[1];
    int s = (int)v[2];
    unsigned long long c = w[0];
    a = __popc(a) + __clz(b) + __ffs(s) + __brev(a) + __byte_perm(a, b, 0x3210);
    b = a / 7 + b % 10 + __umulhi(a, b) + __funnelshift_l(a, b, n) + min(a, b) + max(s, n) + abs(s);
    c = c / 3 + __clzll(c) + __popcll(c) + __umul64hi(c, w[1]) + (c << n) + ((long long)c >> n) + __brevll(c);
    v[3] = a ^ ~b | (a & b) + __vadd4(a, b) + __dp4a(a, b, 3u) + __sad(s, n, a);
    w[2] = c * a + (unsigned char)b + (short)s + (c > 5 ? a : b);
    w[3] = __mul24(s, n) + __float2int_rn((float)a) + __float_as_uint((float)s) + __mulhi(s, n);
}
