// SPDX-License-Identifier: Apache-2.0
// Inline assembly as in headers: intrinsic calls, scopes with their own registers.
extern "C" __global__ void assembly(unsigned* out, unsigned long long address, float x) {
    unsigned a, b, c;
    asm("call (%0), _optix_get_launch_index_x, ();" : "=r"(a) :);
    asm volatile("call (%0, %1, %2), _optix_get_some_values, (%3, %4);"
                 : "=r"(a), "=r"(b), "=r"(c) : "l"(address), "r"(a));
    asm volatile("call _optix_terminate_ray, ();");
    asm volatile("{ .reg .pred p; .reg .b32 t; setp.ne.u32 p, %1, 0; selp.b32 t, 0x1f, -2, p; @!p mov.u32 t, %2; mov.u32 %0, t; }"
                 : "=r"(b) : "r"(a), "r"(c));
    asm volatile("{\n .reg .pred p;\n elsewhere:\n setp.lt.and.s32 p, %1, 5, p; @p bra done;\n bra.uni elsewhere;\n done:\n }"
                 : "=r"(c) : "r"(b));
    unsigned long long g;
    asm("cvta.to.global.u64 %0, %1;" : "=l"(g) : "l"(address));
    asm("ld.global.v4.u32 {%0,%1,%2,_}, [%3+-16];" : "=r"(a), "=r"(b), "=r"(c) : "l"(g));
    asm volatile("atom.add.relaxed.gpu.s32 %0, [%1], %2;" : "=r"(a) : "l"(g), "r"(b));
    asm volatile("mov.u32 %0, %%lanemask_lt;" : "=r"(c));
    out[0] = a + b + c;
}
