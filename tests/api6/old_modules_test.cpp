// SPDX-License-Identifier: Apache-2.0
// Whole tracers in PTX as compilers of their time wrote it: by the first CUDA compilers (PTX 1.4,
// local variables addressed by name, `exit` at the end of programs), and by those of CUDA 4 to 8
// (PTX 3.2, a depot for local variables, cvta before every access through a pointer).
#include "support.h"

#include <cmath>

namespace sunstone::api6 {
namespace {

// Declarations that both texts have: a variable, and what the headers declare with it.
std::string declared(const std::string& name, const std::string& declaration,
                     const std::string& semantic) {
    const std::string mangled = std::to_string(name.size()) + name + "E";
    std::string bytes;
    for (const char c : semantic)
        bytes += std::to_string(int(c)) + ",";
    return declaration + ";\n.global .align 4 .b8 _ZN21rti_internal_typeinfo" + mangled +
           "[8] = {82,97,121,0,4,0,0,0};\n.global .align 1 .b8 _ZN21rti_internal_semantic" +
           mangled + "[" + std::to_string(semantic.size() + 1) + "] = {" + bytes +
           "0x0};\n.global .align 1 .b8 _ZN23rti_internal_annotation" + mangled + "[1] = {0x0};\n";
}

std::string declarations() {
    return declared("launch_index", ".global .align 8 .b8 launch_index[8]", "rtLaunchIndex") +
           declared("ray", ".global .align 4 .b8 ray[36]", "rtCurrentRay") +
           declared("t_hit", ".global .f32 t_hit", "rtIntersectionDistance") +
           declared("prd", ".global .align 4 .b8 prd[20]", "rtPayload") +
           declared("normal", ".global .align 4 .b8 normal[12]", "attribute normal") +
           declared("eye", ".global .align 4 .b8 eye[12]", "") +
           declared("sphere", ".global .align 16 .b8 sphere[16]", "") +
           declared("scene_epsilon", ".global .f32 scene_epsilon", "") +
           declared("top_object", ".global .u32 top_object", "") +
           declared("max_depth", ".global .s32 max_depth", "");
}

// Rays along -z at the pixels of 8 x 8; red is the distance, green the normal's z, blue the depth
// of the deepest ray, alpha the sum of what shadow rays met.
const char* const kFirst = R"(
	.version 1.4
	.target sm_10, map_f64_to_f32
	// compiled with /usr/local/cuda/open64/lib//be
	.reg .u32 %ra<17>;
	.reg .u64 %rda<17>;
	.reg .f32 %fa<17>;
	.file	1	"<command-line>"
	.file	4	"tracer.cu"
)";
const char* const kFirstPrograms = R"(
	.global .align 1 .b8 output_buffer[1];
	.entry _Z6camerav
	{
	.reg .u32 %r<20>;
	.reg .u64 %rd<20>;
	.reg .f32 %f<40>;
	.local .align 4 .b8 __cuda___cuda_local_var_40017_24_prd_16[20];
	.loc	4	31	0
$LDWbegin__Z6camerav:
	ld.global.v2.u32 	{%r1,%r2}, [launch_index+0];
	cvt.rn.f32.u32 	%f1, %r1;
	cvt.rn.f32.u32 	%f2, %r2;
	ld.global.f32 	%f3, [eye+0];
	ld.global.f32 	%f4, [eye+4];
	ld.global.f32 	%f5, [eye+8];
	mad.f32 	%f6, %f1, 0f3e800000, %f3;
	mad.f32 	%f7, %f2, 0f3e800000, %f4;
	mov.f32 	%f8, 0f00000000;     	// 0
	st.local.f32 	[__cuda___cuda_local_var_40017_24_prd_16+0], %f8;
	st.local.f32 	[__cuda___cuda_local_var_40017_24_prd_16+4], %f8;
	st.local.f32 	[__cuda___cuda_local_var_40017_24_prd_16+8], %f8;
	st.local.f32 	[__cuda___cuda_local_var_40017_24_prd_16+12], %f8;
	mov.s32 	%r3, 1;
	st.local.s32 	[__cuda___cuda_local_var_40017_24_prd_16+16], %r3;
	ld.global.u32 	%r4, [top_object];
	mov.f32 	%f9, 0fbf800000;
	mov.f32 	%f10, 0f6c4ecb8f;
	mov.u32 	%r5, 0;
	mov.u64 	%rd1, __cuda___cuda_local_var_40017_24_prd_16;
	mov.u32 	%r6, 20;
	.loc	2	77	0
	// #asm
	call _rt_trace_64, (%r4, %f6, %f7, %f5, %f8, %f8, %f9, %r5, %f8, %f10, %rd1, %r6);
	// #endasm
	ld.local.f32 	%f11, [__cuda___cuda_local_var_40017_24_prd_16+0];
	ld.local.f32 	%f12, [__cuda___cuda_local_var_40017_24_prd_16+4];
	ld.local.f32 	%f13, [__cuda___cuda_local_var_40017_24_prd_16+8];
	ld.local.f32 	%f14, [__cuda___cuda_local_var_40017_24_prd_16+12];
	cvt.u64.u32 	%rd2, %r1;
	cvt.u64.u32 	%rd3, %r2;
	mov.u64 	%rd4, 0;
	mov.u64 	%rd5, output_buffer;
	mov.s32 	%r7, 2;
	mov.s32 	%r8, 16;
	call (%rd6), _rt_buffer_get_64, (%rd5, %r7, %r8, %rd2, %rd3, %rd4, %rd4);
	st.global.v4.f32 	[%rd6+0], {%f11,%f12,%f13,%f14};
	.loc	4	39	0
	exit;
$LDWend__Z6camerav:
	} // _Z6camerav

	.entry _Z10hit_spherev
	{
	.reg .u32 %r<20>;
	.reg .u64 %rd<20>;
	.reg .f32 %f<40>;
	.reg .pred %p<4>;
	.local .align 4 .b8 __cuda___cuda_local_var_40044_19_shadow_0[4];
	.local .align 4 .b8 __cuda___cuda_local_var_40051_24_next_4[20];
$LDWbegin__Z10hit_spherev:
	ld.global.f32 	%f1, [t_hit];
	st.global.f32 	[prd+0], %f1;
	ld.global.f32 	%f2, [normal+8];
	st.global.f32 	[prd+4], %f2;
	ld.global.s32 	%r1, [prd+16];
	cvt.rn.f32.s32 	%f3, %r1;
	st.global.f32 	[prd+8], %f3;
	ld.global.f32 	%f4, [ray+0];
	ld.global.f32 	%f5, [ray+4];
	ld.global.f32 	%f6, [ray+8];
	ld.global.f32 	%f7, [ray+20];
	mad.f32 	%f8, %f1, %f7, %f6;
	ld.global.f32 	%f9, [scene_epsilon];
	mov.f32 	%f10, 0f00000000;
	mov.f32 	%f11, 0f3f800000;
	mov.f32 	%f12, 0f42c80000;
	mov.s32 	%r2, 1;
	st.local.f32 	[__cuda___cuda_local_var_40044_19_shadow_0+0], %f10;
	mov.u64 	%rd1, __cuda___cuda_local_var_40044_19_shadow_0;
	mov.u32 	%r3, 4;
	ld.global.u32 	%r4, [top_object];
	call _rt_trace_64, (%r4, %f4, %f5, %f8, %f10, %f10, %f11, %r2, %f9, %f12, %rd1, %r3);
	ld.local.f32 	%f13, [__cuda___cuda_local_var_40044_19_shadow_0+0];
	ld.global.f32 	%f14, [prd+12];
	add.f32 	%f15, %f14, %f13;
	st.global.f32 	[prd+12], %f15;
	ld.global.s32 	%r5, [max_depth];
	setp.ge.s32 	%p1, %r1, %r5;
	@%p1 bra 	$Lt_1_1026;
	add.s32 	%r6, %r1, 1;
	st.local.s32 	[__cuda___cuda_local_var_40051_24_next_4+16], %r6;
	st.local.f32 	[__cuda___cuda_local_var_40051_24_next_4+8], %f10;
	st.local.f32 	[__cuda___cuda_local_var_40051_24_next_4+12], %f15;
	mov.u64 	%rd2, __cuda___cuda_local_var_40051_24_next_4;
	mov.u32 	%r7, 20;
	mov.s32 	%r8, 0;
	call _rt_trace_64, (%r4, %f4, %f5, %f8, %f10, %f10, %f7, %r8, %f9, %f12, %rd2, %r7);
	ld.local.f32 	%f16, [__cuda___cuda_local_var_40051_24_next_4+8];
	st.global.f32 	[prd+8], %f16;
	ld.local.f32 	%f17, [__cuda___cuda_local_var_40051_24_next_4+12];
	st.global.f32 	[prd+12], %f17;
$Lt_1_1026:
	exit;
$LDWend__Z10hit_spherev:
	} // _Z10hit_spherev

	.entry _Z9in_shadowv
	{
	.reg .f32 %f<4>;
	ld.global.f32 	%f1, [prd+0];
	add.f32 	%f2, %f1, 0f3f800000;
	st.global.f32 	[prd+0], %f2;
	call _rt_ignore_intersection, ();
	exit;
	} // _Z9in_shadowv

	.entry _Z5emptyv
	{
	.reg .f32 %f<4>;
	.reg .u32 %r<4>;
	mov.f32 	%f1, 0fbf800000;
	st.global.f32 	[prd+0], %f1;
	ld.global.s32 	%r1, [prd+16];
	cvt.rn.f32.s32 	%f2, %r1;
	st.global.f32 	[prd+8], %f2;
	exit;
	} // _Z5emptyv

	.func (.reg .f32 %fv1) _Z4rootf (.reg .f32 %fa1)
	{
	.reg .f32 %f<4>;
	mov.f32 	%f1, %fa1;
	sqrt.f32 	%f2, %f1;
	mov.f32 	%fv1, %f2;
	ret;
	} // _Z4rootf

	.entry _Z4meeti (
		.param .s32 __cudaparm__Z4meeti_primIdx)
	{
	.reg .u32 %r<8>;
	.reg .u64 %rd<4>;
	.reg .f32 %f<40>;
	.reg .pred %p<8>;
	ld.global.v4.f32 	{%f1,%f2,%f3,%f4}, [sphere+0];
	ld.param.s32 	%r1, [__cudaparm__Z4meeti_primIdx];
	cvt.rn.f32.s32 	%f5, %r1;
	mul.f32 	%f6, %f5, 0f40800000;
	sub.f32 	%f7, %f3, %f6;
	ld.global.f32 	%f8, [ray+0];
	sub.f32 	%f9, %f8, %f1;
	ld.global.f32 	%f10, [ray+4];
	sub.f32 	%f11, %f10, %f2;
	ld.global.f32 	%f12, [ray+8];
	sub.f32 	%f13, %f12, %f7;
	ld.global.f32 	%f14, [ray+20];
	mul.f32 	%f15, %f9, %f9;
	mad.f32 	%f16, %f11, %f11, %f15;
	mul.f32 	%f17, %f4, %f4;
	sub.f32 	%f18, %f17, %f16;
	mov.f32 	%f19, 0f00000000;
	setp.lt.f32 	%p1, %f18, %f19;
	@%p1 bra 	$Lt_4_2050;
	call (%f20), _Z4rootf, (%f18);
	mul.f32 	%f21, %f13, %f14;
	neg.f32 	%f22, %f21;
	sub.f32 	%f23, %f22, %f20;
	call (%r2), _rt_potential_intersection, (%f23);
	mov.u32 	%r3, 0;
	setp.eq.s32 	%p2, %r2, %r3;
	@%p2 bra 	$Lt_4_2306;
	mad.f32 	%f24, %f23, %f14, %f13;
	div.full.f32 	%f25, %f24, %f4;
	st.global.f32 	[normal+8], %f25;
	mov.u32 	%r4, 0;
	call (%r5), _rt_report_intersection, (%r4);
	setp.ne.s32 	%p3, %r5, %r3;
	@%p3 bra 	$Lt_4_2050;
$Lt_4_2306:
	add.f32 	%f26, %f22, %f20;
	call (%r2), _rt_potential_intersection, (%f26);
	setp.eq.s32 	%p4, %r2, %r3;
	@%p4 bra 	$Lt_4_2050;
	mad.f32 	%f24, %f26, %f14, %f13;
	div.full.f32 	%f25, %f24, %f4;
	st.global.f32 	[normal+8], %f25;
	call (%r5), _rt_report_intersection, (%r4);
$Lt_4_2050:
	exit;
	} // _Z4meeti

	.entry _Z6boundsiPf (
		.param .s32 __cudaparm__Z6boundsiPf___val_paramprimIdx,
		.param .u64 __cudaparm__Z6boundsiPf_result)
	{
	.reg .u32 %r<4>;
	.reg .u64 %rd<4>;
	.reg .f32 %f<20>;
	ld.param.u64 	%rd1, [__cudaparm__Z6boundsiPf_result];
	ld.param.s32 	%r1, [__cudaparm__Z6boundsiPf___val_paramprimIdx];
	cvt.rn.f32.s32 	%f5, %r1;
	ld.global.v4.f32 	{%f1,%f2,%f3,%f4}, [sphere+0];
	mul.f32 	%f6, %f5, 0f40800000;
	sub.f32 	%f3, %f3, %f6;
	sub.f32 	%f7, %f1, %f4;
	st.global.f32 	[%rd1+0], %f7;
	sub.f32 	%f7, %f2, %f4;
	st.global.f32 	[%rd1+4], %f7;
	sub.f32 	%f7, %f3, %f4;
	st.global.f32 	[%rd1+8], %f7;
	add.f32 	%f7, %f1, %f4;
	st.global.f32 	[%rd1+12], %f7;
	add.f32 	%f7, %f2, %f4;
	st.global.f32 	[%rd1+16], %f7;
	add.f32 	%f7, %f3, %f4;
	st.global.f32 	[%rd1+20], %f7;
	exit;
	} // _Z6boundsiPf
)";

const char* const kLater = R"(
//
// Generated by NVIDIA NVVM Compiler
//
.version 3.2
.target sm_20
.address_size 64

	.file	1 "/tmp/tmpxft_00000abc_00000000-9_tracer.cpp3.i", 1396000000, 12345
	.file	2 "tracer.cu", 1396000000, 4321
.visible .global .align 8 .u64 _ZN21rti_internal_register20reg_bitness_detectorE;
.visible .global .align 8 .u64 _ZN21rti_internal_register24reg_exception_64_detail0E;
.visible .global .align 4 .u32 _ZN21rti_internal_register14reg_rayIndex_xE;
)";
const char* const kLaterPrograms = R"(
.visible .global .align 1 .b8 output_buffer[1];

.visible .entry _Z6camerav(

)
{
	.local .align 4 .b8 	__local_depot0[20];
	.reg .b64 	%SP;
	.reg .b64 	%SPL;
	.reg .s32 	%r<12>;
	.reg .f32 	%f<20>;
	.reg .s64 	%rd<16>;

	mov.u64 	%SPL, __local_depot0;
	cvta.local.u64 	%SP, %SPL;
	ld.global.v2.u32 	{%r1, %r2}, [launch_index];
	cvt.rn.f32.u32	%f1, %r1;
	cvt.rn.f32.u32	%f2, %r2;
	ld.global.f32 	%f3, [eye];
	ld.global.f32 	%f4, [eye+4];
	fma.rn.f32 	%f6, %f1, 0f3E800000, %f3;
	fma.rn.f32 	%f7, %f2, 0f3E800000, %f4;
	ld.global.f32 	%f8, [eye+8];
	add.u64 	%rd9, %SP, 0;
	cvta.to.local.u64 	%rd1, %rd9;
	mov.u32 	%r3, 0;
	st.local.u32 	[%rd1], %r3;
	st.local.u32 	[%rd1+4], %r3;
	st.local.u32 	[%rd1+8], %r3;
	st.local.u32 	[%rd1+12], %r3;
	mov.u32 	%r4, 1;
	st.local.u32 	[%rd1+16], %r4;
	ld.global.u32 	%r5, [top_object];
	mov.f32 	%f9, 0f00000000;
	mov.f32 	%f10, 0fBF800000;
	mov.f32 	%f11, 0f6C4ECB8F;
	mov.u32 	%r6, 20;
	// inline asm
	call _rt_trace_64, (%r5, %f6, %f7, %f8, %f9, %f9, %f10, %r3, %f9, %f11, %rd9, %r6);
	// inline asm
	cvt.u64.u32	%rd3, %r1;
	cvt.u64.u32	%rd4, %r2;
	mov.u64 	%rd8, output_buffer;
	cvta.global.u64 	%rd2, %rd8;
	mov.u64 	%rd6, 0;
	mov.u32 	%r7, 2;
	mov.u32 	%r8, 16;
	// inline asm
	call (%rd7), _rt_buffer_get_64, (%rd2, %r7, %r8, %rd3, %rd4, %rd6, %rd6);
	// inline asm
	cvta.to.global.u64 	%rd10, %rd7;
	ld.local.f32 	%f12, [%rd1];
	ld.local.f32 	%f13, [%rd1+4];
	ld.local.f32 	%f14, [%rd1+8];
	ld.local.f32 	%f15, [%rd1+12];
	st.global.v4.f32 	[%rd10], {%f12, %f13, %f14, %f15};
	ret;
}

.visible .entry _Z10hit_spherev(

)
{
	.local .align 4 .b8 	__local_depot1[24];
	.reg .b64 	%SP;
	.reg .b64 	%SPL;
	.reg .pred 	%p<2>;
	.reg .s32 	%r<12>;
	.reg .f32 	%f<24>;
	.reg .s64 	%rd<8>;

	mov.u64 	%SPL, __local_depot1;
	cvta.local.u64 	%SP, %SPL;
	add.u64 	%rd1, %SP, 0;
	cvta.to.local.u64 	%rd2, %rd1;
	add.u64 	%rd3, %SP, 4;
	cvta.to.local.u64 	%rd4, %rd3;
	ld.global.f32 	%f1, [t_hit];
	st.global.f32 	[prd], %f1;
	ld.global.f32 	%f2, [normal+8];
	st.global.f32 	[prd+4], %f2;
	ld.global.u32 	%r1, [prd+16];
	cvt.rn.f32.s32	%f3, %r1;
	st.global.f32 	[prd+8], %f3;
	ld.global.v2.f32 	{%f4, %f5}, [ray];
	ld.global.f32 	%f6, [ray+8];
	ld.global.f32 	%f7, [ray+20];
	fma.rn.f32 	%f8, %f1, %f7, %f6;
	mov.u32 	%r2, 0;
	st.local.u32 	[%rd2], %r2;
	ld.global.u32 	%r4, [top_object];
	ld.global.f32 	%f9, [scene_epsilon];
	mov.f32 	%f10, 0f00000000;
	mov.f32 	%f11, 0f3F800000;
	mov.f32 	%f12, 0f42C80000;
	mov.u32 	%r5, 1;
	mov.u32 	%r6, 4;
	// inline asm
	call _rt_trace_64, (%r4, %f4, %f5, %f8, %f10, %f10, %f11, %r5, %f9, %f12, %rd1, %r6);
	// inline asm
	ld.local.f32 	%f13, [%rd2];
	ld.global.f32 	%f14, [prd+12];
	add.f32 	%f15, %f14, %f13;
	st.global.f32 	[prd+12], %f15;
	ld.global.u32 	%r7, [max_depth];
	setp.ge.s32	%p1, %r1, %r7;
	@%p1 bra 	BB1_2;

	add.s32 	%r8, %r1, 1;
	st.local.u32 	[%rd4+16], %r8;
	st.local.u32 	[%rd4+8], %r2;
	st.local.f32 	[%rd4+12], %f15;
	mov.u32 	%r9, 20;
	// inline asm
	call _rt_trace_64, (%r4, %f4, %f5, %f8, %f10, %f10, %f7, %r2, %f9, %f12, %rd3, %r9);
	// inline asm
	ld.local.f32 	%f16, [%rd4+8];
	st.global.f32 	[prd+8], %f16;
	ld.local.f32 	%f17, [%rd4+12];
	st.global.f32 	[prd+12], %f17;

BB1_2:
	ret;
}

.visible .entry _Z9in_shadowv(

)
{
	.reg .f32 	%f<3>;
	.reg .s64 	%rd<3>;

	mov.u64 	%rd1, prd;
	ld.global.f32 	%f1, [%rd1];
	add.f32 	%f2, %f1, 0f3F800000;
	st.global.f32 	[%rd1], %f2;
	// inline asm
	call _rt_ignore_intersection, ();
	// inline asm
	ret;
}

.visible .entry _Z5emptyv(

)
{
	.reg .s32 	%r<3>;
	.reg .f32 	%f<2>;

	mov.u32 	%r1, -1082130432;
	st.global.u32 	[prd], %r1;
	ld.global.u32 	%r2, [prd+16];
	cvt.rn.f32.s32	%f1, %r2;
	st.global.f32 	[prd+8], %f1;
	ret;
}

.func  (.param .b32 func_retval0) _Z4rootf(
	.param .b32 _Z4rootf_param_0
)
{
	.reg .f32 	%f<3>;

	ld.param.f32 	%f1, [_Z4rootf_param_0];
	sqrt.rn.f32 	%f2, %f1;
	st.param.f32	[func_retval0+0], %f2;
	ret;
}

.visible .entry _Z4meeti(
	.param .u32 _Z4meeti_param_0
)
{
	.reg .pred 	%p<5>;
	.reg .s32 	%r<9>;
	.reg .f32 	%f<30>;

	ld.param.u32 	%r1, [_Z4meeti_param_0];
	ld.global.v4.f32 	{%f1, %f2, %f3, %f4}, [sphere];
	cvt.rn.f32.s32	%f5, %r1;
	fma.rn.f32 	%f7, %f5, 0fC0800000, %f3;
	ld.global.f32 	%f8, [ray];
	sub.f32 	%f9, %f8, %f1;
	ld.global.f32 	%f10, [ray+4];
	sub.f32 	%f11, %f10, %f2;
	ld.global.f32 	%f12, [ray+8];
	sub.f32 	%f13, %f12, %f7;
	ld.global.f32 	%f14, [ray+20];
	mul.f32 	%f15, %f9, %f9;
	fma.rn.f32 	%f16, %f11, %f11, %f15;
	mul.f32 	%f17, %f4, %f4;
	sub.f32 	%f18, %f17, %f16;
	setp.lt.f32	%p1, %f18, 0f00000000;
	@%p1 bra 	BB5_4;

	{
	.reg .b32 temp_param_reg;
	.param .b32 param0;
	st.param.f32	[param0+0], %f18;
	.param .b32 retval0;
	call.uni (retval0), 
	_Z4rootf, 
	(
	param0
	);
	ld.param.f32	%f20, [retval0+0];
	}
	mul.f32 	%f21, %f13, %f14;
	neg.f32 	%f22, %f21;
	sub.f32 	%f23, %f22, %f20;
	// inline asm
	call (%r2), _rt_potential_intersection, (%f23);
	// inline asm
	setp.eq.s32	%p2, %r2, 0;
	@%p2 bra 	BB5_3;

	fma.rn.f32 	%f24, %f23, %f14, %f13;
	div.rn.f32 	%f25, %f24, %f4;
	st.global.f32 	[normal+8], %f25;
	mov.u32 	%r4, 0;
	// inline asm
	call (%r5), _rt_report_intersection, (%r4);
	// inline asm
	setp.ne.s32	%p3, %r5, 0;
	@%p3 bra 	BB5_4;

BB5_3:
	add.f32 	%f26, %f20, %f22;
	// inline asm
	call (%r6), _rt_potential_intersection, (%f26);
	// inline asm
	setp.eq.s32	%p4, %r6, 0;
	@%p4 bra 	BB5_4;

	fma.rn.f32 	%f27, %f26, %f14, %f13;
	div.rn.f32 	%f28, %f27, %f4;
	st.global.f32 	[normal+8], %f28;
	mov.u32 	%r8, 0;
	// inline asm
	call (%r7), _rt_report_intersection, (%r8);
	// inline asm

BB5_4:
	ret;
}

.visible .entry _Z6boundsiPf(
	.param .u32 _Z6boundsiPf_param_0,
	.param .u64 _Z6boundsiPf_param_1
)
{
	.reg .s32 	%r<2>;
	.reg .f32 	%f<14>;
	.reg .s64 	%rd<3>;

	ld.param.u32 	%r1, [_Z6boundsiPf_param_0];
	ld.param.u64 	%rd1, [_Z6boundsiPf_param_1];
	cvta.to.global.u64 	%rd2, %rd1;
	ld.global.v4.f32 	{%f1, %f2, %f3, %f4}, [sphere];
	cvt.rn.f32.s32	%f5, %r1;
	fma.rn.f32 	%f6, %f5, 0fC0800000, %f3;
	sub.f32 	%f7, %f1, %f4;
	sub.f32 	%f8, %f2, %f4;
	sub.f32 	%f9, %f6, %f4;
	add.f32 	%f10, %f1, %f4;
	add.f32 	%f11, %f2, %f4;
	add.f32 	%f12, %f6, %f4;
	st.global.f32 	[%rd2], %f7;
	st.global.f32 	[%rd2+4], %f8;
	st.global.f32 	[%rd2+8], %f9;
	st.global.f32 	[%rd2+12], %f10;
	st.global.f32 	[%rd2+16], %f11;
	st.global.f32 	[%rd2+20], %f12;
	ret;
}
)";

class OldModules : public Classic {
protected:
    void SetUp() override {
        Classic::SetUp();
        ok(rtVariableSet3f(variable("eye"), -0.875f, -0.875f, 5));
        ok(rtVariableSet4f(variable("sphere"), 0, 0, 0, 1));
        ok(rtVariableSet1f(variable("scene_epsilon"), 1e-3f));
        ok(rtVariableSet1i(variable("max_depth"), 3));
        ok(rtBufferCreate(context_, RT_BUFFER_OUTPUT, &picture_));
        ok(rtBufferSetFormat(picture_, RT_FORMAT_FLOAT4));
        ok(rtBufferSetSize2D(picture_, 8, 8));
        ok(rtVariableSetObject(variable("output_buffer"), picture_));
    }
    RTprogram named(const std::string& text, const char* name) {
        RTprogram made = nullptr;
        ok(rtProgramCreateFromPTXString(context_, text.c_str(), name, &made));
        return made;
    }
    // Two spheres, 4 apart along z.
    void makeScene(const std::string& text) {
        RTgeometry geometry = nullptr;
        ok(rtGeometryCreate(context_, &geometry));
        ok(rtGeometrySetPrimitiveCount(geometry, 2));
        ok(rtGeometrySetBoundingBoxProgram(geometry, named(text, "bounds")));
        ok(rtGeometrySetIntersectionProgram(geometry, named(text, "meet")));
        RTmaterial material = nullptr;
        ok(rtMaterialCreate(context_, &material));
        ok(rtMaterialSetClosestHitProgram(material, 0, named(text, "hit_sphere")));
        ok(rtMaterialSetAnyHitProgram(material, 1, named(text, "in_shadow")));
        RTgeometryinstance instance = nullptr;
        ok(rtGeometryInstanceCreate(context_, &instance));
        ok(rtGeometryInstanceSetGeometry(instance, geometry));
        ok(rtGeometryInstanceSetMaterialCount(instance, 1));
        ok(rtGeometryInstanceSetMaterial(instance, 0, material));
        RTgeometrygroup group = nullptr;
        ok(rtGeometryGroupCreate(context_, &group));
        ok(rtGeometryGroupSetChildCount(group, 1));
        ok(rtGeometryGroupSetChild(group, 0, instance));
        RTacceleration acceleration = nullptr;
        ok(rtAccelerationCreate(context_, &acceleration));
        ok(rtAccelerationSetBuilder(acceleration, "Sbvh"));
        ok(rtAccelerationSetTraverser(acceleration, "Bvh"));
        ok(rtGeometryGroupSetAcceleration(group, acceleration));
        ok(rtVariableSetObject(variable("top_object"), group));
        ok(rtContextSetRayGenerationProgram(context_, 0, named(text, "camera")));
        ok(rtContextSetMissProgram(context_, 0, named(text, "_Z5emptyv")));
    }
    void expectPicture(const std::string& text) {
        makeScene(text);
        ok(rtContextValidate(context_));
        ok(rtContextCompile(context_));
        ok(rtContextLaunch2D(context_, 0, 8, 8));
        void* data = nullptr;
        ok(rtBufferMap(picture_, &data));
        const auto* pixel = static_cast<const float*>(data);
        for (int y = 0; y < 8; ++y)
            for (int x = 0; x < 8; ++x, pixel += 4)
                expectPixel(pixel, -0.875f + 0.25f * float(x), -0.875f + 0.25f * float(y));
        ok(rtBufferUnmap(picture_));
    }
    static void expectPixel(const float* pixel, float x, float y) {
        const float inside = 1 - x * x - y * y;
        if (inside < 0) {
            EXPECT_EQ(pixel[0], -1);
            EXPECT_EQ(pixel[2], 1);
            EXPECT_EQ(pixel[3], 0);
            return;
        }
        EXPECT_NEAR(pixel[0], 5 - std::sqrt(inside), 1e-4);
        EXPECT_NEAR(pixel[1], std::sqrt(inside), 1e-4);
        EXPECT_EQ(pixel[2], 3) << "the first sphere's two sides, the second's front";
        // Rays back up: none above the front, the front above the back, both above the second
        // front.
        EXPECT_EQ(pixel[3], 0 + 1 + 2) << x << ' ' << y;
    }
    RTbuffer picture_ = nullptr;
};

TEST_F(OldModules, OfTheFirstCompilers) {
    expectPicture(kFirst + declarations() + kFirstPrograms);
}

TEST_F(OldModules, OfLaterCompilers) {
    expectPicture(kLater + declarations() + kLaterPrograms);
}

} // namespace
} // namespace sunstone::api6
