// SPDX-License-Identifier: Apache-2.0
// Texture and surface objects of every shape.
extern "C" __global__ void sample(cudaTextureObject_t t, cudaSurfaceObject_t s, float4* out, float x, float y, float z) {
    float4 v = tex2D<float4>(t, x, y);
    const float4 a = tex2DLod<float4>(t, x, y, z);
    const float4 b = tex2DGrad<float4>(t, x, y, make_float2(x, y), make_float2(y, z));
    const float4 c = tex3D<float4>(t, x, y, z);
    const float4 d = tex2DLayered<float4>(t, x, y, 3);
    const float4 e = texCubemap<float4>(t, x, y, z);
    const float4 f = tex2Dgather<float4>(t, x, y, 2);
    const uchar4 g = tex1Dfetch<uchar4>(t, 7);
    const float h = tex1D<float>(t, x);
    v.x += a.x + b.y + c.z + d.w + e.x + f.y + g.z + h;
    const float4 texel = surf2Dread<float4>(s, 16 * threadIdx.x, threadIdx.y);
    surf2Dwrite(make_float4(v.x + texel.x, v.y, v.z, v.w), s, 16 * threadIdx.x, threadIdx.y);
    surf2Dwrite((unsigned char)3, s, 1, 2, cudaBoundaryModeClamp);
    surf3Dwrite(make_ushort2(1, 2), s, 4, 5, 6, cudaBoundaryModeZero);
    out[threadIdx.x] = v;
}
