/* SPDX-License-Identifier: Apache-2.0 */
/* Texture and surface references: variables of a module (.texref, .surfref) that the host binds to
   memory. Included by cuda.h. */
#ifndef SUNSTONE_DRIVER_REFERENCES_H
#define SUNSTONE_DRIVER_REFERENCES_H

#define CU_PARAM_TR_DEFAULT (-1)

#define cuTexRefSetAddress cuTexRefSetAddress_v2
#define cuTexRefSetAddress2D cuTexRefSetAddress2D_v3
#define cuTexRefGetAddress cuTexRefGetAddress_v2

#ifdef __cplusplus
extern "C" {
#endif

CUresult cuModuleGetTexRef(CUtexref* reference, CUmodule module, const char* name);
CUresult cuModuleGetSurfRef(CUsurfref* reference, CUmodule module, const char* name);
CUresult cuTexRefCreate(CUtexref* reference);
CUresult cuTexRefDestroy(CUtexref reference);

/* flags: 0 or CU_TRSA_OVERRIDE_FORMAT */
CUresult cuTexRefSetArray(CUtexref reference, CUarray array, unsigned int flags);
CUresult cuTexRefSetMipmappedArray(CUtexref reference, CUmipmappedArray mipmap, unsigned int flags);
/* Binds memory from the address rounded down to a multiple of 512 bytes; *offset receives the
   difference in bytes. */
CUresult cuTexRefSetAddress(size_t* offset, CUtexref reference, CUdeviceptr address, size_t bytes);
CUresult cuTexRefSetAddress2D(CUtexref reference, const CUDA_ARRAY_DESCRIPTOR* shape,
                              CUdeviceptr address, size_t pitch);
CUresult cuTexRefSetFormat(CUtexref reference, CUarray_format format, int channels);
CUresult cuTexRefSetAddressMode(CUtexref reference, int dimension, CUaddress_mode mode);
CUresult cuTexRefSetFilterMode(CUtexref reference, CUfilter_mode mode);
CUresult cuTexRefSetMipmapFilterMode(CUtexref reference, CUfilter_mode mode);
CUresult cuTexRefSetMipmapLevelBias(CUtexref reference, float bias);
CUresult cuTexRefSetMipmapLevelClamp(CUtexref reference, float least, float most);
CUresult cuTexRefSetMaxAnisotropy(CUtexref reference, unsigned int most);
CUresult cuTexRefSetBorderColor(CUtexref reference, float* color);
CUresult cuTexRefSetFlags(CUtexref reference, unsigned int flags);

CUresult cuTexRefGetAddress(CUdeviceptr* address, CUtexref reference);
CUresult cuTexRefGetArray(CUarray* array, CUtexref reference);
CUresult cuTexRefGetMipmappedArray(CUmipmappedArray* mipmap, CUtexref reference);
CUresult cuTexRefGetFormat(CUarray_format* format, int* channels, CUtexref reference);
CUresult cuTexRefGetAddressMode(CUaddress_mode* mode, CUtexref reference, int dimension);
CUresult cuTexRefGetFilterMode(CUfilter_mode* mode, CUtexref reference);
CUresult cuTexRefGetMipmapFilterMode(CUfilter_mode* mode, CUtexref reference);
CUresult cuTexRefGetMipmapLevelBias(float* bias, CUtexref reference);
CUresult cuTexRefGetMipmapLevelClamp(float* least, float* most, CUtexref reference);
CUresult cuTexRefGetMaxAnisotropy(int* most, CUtexref reference);
CUresult cuTexRefGetBorderColor(float* color, CUtexref reference);
CUresult cuTexRefGetFlags(unsigned int* flags, CUtexref reference);

CUresult cuSurfRefSetArray(CUsurfref reference, CUarray array, unsigned int flags);
CUresult cuSurfRefGetArray(CUarray* array, CUsurfref reference);
/* Has no effect: the kernel's code names the references it uses. */
CUresult cuParamSetTexRef(CUfunction function, int unit, CUtexref reference);

#ifdef __cplusplus
}
#endif

#endif
