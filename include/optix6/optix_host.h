// SPDX-License-Identifier: Apache-2.0
// The host functions of the classic API. Source: OptiX 6.0 API reference, chapter 5 and
// section 8.17.
#ifndef SUNSTONE_OPTIX6_HOST_H
#define SUNSTONE_OPTIX6_HOST_H

#include "internal/optix_declarations.h"

#include <stddef.h>

#ifndef RTAPI
#define RTAPI
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef size_t RTsize;

typedef struct RTacceleration_api* RTacceleration;
typedef struct RTbuffer_api* RTbuffer;
typedef struct RTcontext_api* RTcontext;
typedef struct RTgeometry_api* RTgeometry;
typedef struct RTgeometrytriangles_api* RTgeometrytriangles;
typedef struct RTgeometryinstance_api* RTgeometryinstance;
typedef struct RTgeometrygroup_api* RTgeometrygroup;
typedef struct RTgroup_api* RTgroup;
typedef struct RTmaterial_api* RTmaterial;
typedef struct RTprogram_api* RTprogram;
typedef struct RTselector_api* RTselector;
typedef struct RTtexturesampler_api* RTtexturesampler;
typedef struct RTtransform_api* RTtransform;
typedef struct RTvariable_api* RTvariable;
typedef struct RTpostprocessingstage_api* RTpostprocessingstage;
typedef struct RTcommandlist_api* RTcommandlist;
typedef struct RTremotedevice_api* RTremotedevice;
typedef void* RTobject;

typedef int (*RTtimeoutcallback)(void);
typedef void (*RTusagereportcallback)(int, const char*, const char*, void*);

RTresult RTAPI rtGetVersion(unsigned int* version);

RTresult RTAPI rtGlobalSetAttribute(RTglobalattribute attrib, RTsize size, const void* p);
RTresult RTAPI rtGlobalGetAttribute(RTglobalattribute attrib, RTsize size, void* p);

RTresult RTAPI rtDeviceGetDeviceCount(unsigned int* count);
RTresult RTAPI rtDeviceGetAttribute(int ordinal, RTdeviceattribute attrib, RTsize size, void* p);

RTresult RTAPI rtContextCreate(RTcontext* context);
RTresult RTAPI rtContextDestroy(RTcontext context);
RTresult RTAPI rtContextValidate(RTcontext context);
void RTAPI rtContextGetErrorString(RTcontext context, RTresult code, const char** stringReturn);
RTresult RTAPI rtContextSetAttribute(RTcontext context, RTcontextattribute attrib, RTsize size,
                                     const void* p);
RTresult RTAPI rtContextGetAttribute(RTcontext context, RTcontextattribute attrib, RTsize size,
                                     void* p);
RTresult RTAPI rtContextSetDevices(RTcontext context, unsigned int count, const int* devices);
RTresult RTAPI rtContextGetDevices(RTcontext context, int* devices);
RTresult RTAPI rtContextGetDeviceCount(RTcontext context, unsigned int* count);
RTresult RTAPI rtContextSetStackSize(RTcontext context, RTsize bytes);
RTresult RTAPI rtContextGetStackSize(RTcontext context, RTsize* bytes);
RTresult RTAPI rtContextSetMaxCallableProgramDepth(RTcontext context, unsigned int maxDepth);
RTresult RTAPI rtContextGetMaxCallableProgramDepth(RTcontext context, unsigned int* maxDepth);
RTresult RTAPI rtContextSetMaxTraceDepth(RTcontext context, unsigned int maxDepth);
RTresult RTAPI rtContextGetMaxTraceDepth(RTcontext context, unsigned int* maxDepth);
RTresult RTAPI rtContextSetTimeoutCallback(RTcontext context, RTtimeoutcallback callback,
                                           double minPollingSeconds);
RTresult RTAPI rtContextSetUsageReportCallback(RTcontext context, RTusagereportcallback callback,
                                               int verbosity, void* cbdata);
RTresult RTAPI rtContextSetEntryPointCount(RTcontext context, unsigned int count);
RTresult RTAPI rtContextGetEntryPointCount(RTcontext context, unsigned int* count);
RTresult RTAPI rtContextSetRayGenerationProgram(RTcontext context, unsigned int entryPointIndex,
                                                RTprogram program);
RTresult RTAPI rtContextGetRayGenerationProgram(RTcontext context, unsigned int entryPointIndex,
                                                RTprogram* program);
RTresult RTAPI rtContextSetExceptionProgram(RTcontext context, unsigned int entryPointIndex,
                                            RTprogram program);
RTresult RTAPI rtContextGetExceptionProgram(RTcontext context, unsigned int entryPointIndex,
                                            RTprogram* program);
RTresult RTAPI rtContextSetExceptionEnabled(RTcontext context, RTexception exception, int enabled);
RTresult RTAPI rtContextGetExceptionEnabled(RTcontext context, RTexception exception, int* enabled);
RTresult RTAPI rtContextSetRayTypeCount(RTcontext context, unsigned int rayTypeCount);
RTresult RTAPI rtContextGetRayTypeCount(RTcontext context, unsigned int* rayTypeCount);
RTresult RTAPI rtContextSetMissProgram(RTcontext context, unsigned int rayTypeIndex,
                                       RTprogram program);
RTresult RTAPI rtContextGetMissProgram(RTcontext context, unsigned int rayTypeIndex,
                                       RTprogram* program);
RTresult RTAPI rtContextGetTextureSamplerFromId(RTcontext context, int samplerId,
                                                RTtexturesampler* sampler);
RTresult RTAPI rtContextCompile(RTcontext context);
RTresult RTAPI rtContextLaunch1D(RTcontext context, unsigned int entryPointIndex, RTsize width);
RTresult RTAPI rtContextLaunch2D(RTcontext context, unsigned int entryPointIndex, RTsize width,
                                 RTsize height);
RTresult RTAPI rtContextLaunch3D(RTcontext context, unsigned int entryPointIndex, RTsize width,
                                 RTsize height, RTsize depth);
RTresult RTAPI rtContextGetRunningState(RTcontext context, int* running);
RTresult RTAPI rtContextLaunchProgressive2D(RTcontext context, unsigned int entryIndex,
                                            RTsize width, RTsize height, unsigned int maxSubframes);
RTresult RTAPI rtContextStopProgressive(RTcontext context);
RTresult RTAPI rtContextSetPrintEnabled(RTcontext context, int enabled);
RTresult RTAPI rtContextGetPrintEnabled(RTcontext context, int* enabled);
RTresult RTAPI rtContextSetPrintBufferSize(RTcontext context, RTsize bufferSizeBytes);
RTresult RTAPI rtContextGetPrintBufferSize(RTcontext context, RTsize* bufferSizeBytes);
RTresult RTAPI rtContextSetPrintLaunchIndex(RTcontext context, int x, int y, int z);
RTresult RTAPI rtContextGetPrintLaunchIndex(RTcontext context, int* x, int* y, int* z);
RTresult RTAPI rtContextDeclareVariable(RTcontext context, const char* name, RTvariable* v);
RTresult RTAPI rtContextQueryVariable(RTcontext context, const char* name, RTvariable* v);
RTresult RTAPI rtContextRemoveVariable(RTcontext context, RTvariable v);
RTresult RTAPI rtContextGetVariableCount(RTcontext context, unsigned int* count);
RTresult RTAPI rtContextGetVariable(RTcontext context, unsigned int index, RTvariable* v);
RTresult RTAPI rtContextGetProgramFromId(RTcontext context, int programId, RTprogram* program);
RTresult RTAPI rtContextGetBufferFromId(RTcontext context, int bufferId, RTbuffer* buffer);

RTresult RTAPI rtProgramCreateFromPTXString(RTcontext context, const char* ptx,
                                            const char* programName, RTprogram* program);
RTresult RTAPI rtProgramCreateFromPTXStrings(RTcontext context, unsigned int n,
                                             const char** ptxStrings, const char* programName,
                                             RTprogram* program);
RTresult RTAPI rtProgramCreateFromPTXFile(RTcontext context, const char* filename,
                                          const char* programName, RTprogram* program);
RTresult RTAPI rtProgramCreateFromPTXFiles(RTcontext context, unsigned int n,
                                           const char** filenames, const char* programName,
                                           RTprogram* program);
RTresult RTAPI rtProgramDestroy(RTprogram program);
RTresult RTAPI rtProgramValidate(RTprogram program);
RTresult RTAPI rtProgramGetContext(RTprogram program, RTcontext* context);
RTresult RTAPI rtProgramDeclareVariable(RTprogram program, const char* name, RTvariable* v);
RTresult RTAPI rtProgramQueryVariable(RTprogram program, const char* name, RTvariable* v);
RTresult RTAPI rtProgramRemoveVariable(RTprogram program, RTvariable v);
RTresult RTAPI rtProgramGetVariableCount(RTprogram program, unsigned int* count);
RTresult RTAPI rtProgramGetVariable(RTprogram program, unsigned int index, RTvariable* v);
RTresult RTAPI rtProgramGetId(RTprogram program, int* programId);
RTresult RTAPI rtProgramCallsiteSetPotentialCallees(RTprogram program, const char* name,
                                                    const int* ids, int numIds);

RTresult RTAPI rtVariableSetObject(RTvariable v, RTobject object);
RTresult RTAPI rtVariableSetUserData(RTvariable v, RTsize size, const void* ptr);
RTresult RTAPI rtVariableGetObject(RTvariable v, RTobject* object);
RTresult RTAPI rtVariableGetUserData(RTvariable v, RTsize size, void* ptr);
RTresult RTAPI rtVariableGetName(RTvariable v, const char** nameReturn);
RTresult RTAPI rtVariableGetAnnotation(RTvariable v, const char** annotationReturn);
RTresult RTAPI rtVariableGetType(RTvariable v, RTobjecttype* typeReturn);
RTresult RTAPI rtVariableGetContext(RTvariable v, RTcontext* context);
RTresult RTAPI rtVariableGetSize(RTvariable v, RTsize* size);
RTresult RTAPI rtVariableSet1f(RTvariable v, float f1);
RTresult RTAPI rtVariableSet2f(RTvariable v, float f1, float f2);
RTresult RTAPI rtVariableSet3f(RTvariable v, float f1, float f2, float f3);
RTresult RTAPI rtVariableSet4f(RTvariable v, float f1, float f2, float f3, float f4);
RTresult RTAPI rtVariableSet1fv(RTvariable v, const float* f);
RTresult RTAPI rtVariableSet2fv(RTvariable v, const float* f);
RTresult RTAPI rtVariableSet3fv(RTvariable v, const float* f);
RTresult RTAPI rtVariableSet4fv(RTvariable v, const float* f);
RTresult RTAPI rtVariableSet1i(RTvariable v, int i1);
RTresult RTAPI rtVariableSet2i(RTvariable v, int i1, int i2);
RTresult RTAPI rtVariableSet3i(RTvariable v, int i1, int i2, int i3);
RTresult RTAPI rtVariableSet4i(RTvariable v, int i1, int i2, int i3, int i4);
RTresult RTAPI rtVariableSet1iv(RTvariable v, const int* i);
RTresult RTAPI rtVariableSet2iv(RTvariable v, const int* i);
RTresult RTAPI rtVariableSet3iv(RTvariable v, const int* i);
RTresult RTAPI rtVariableSet4iv(RTvariable v, const int* i);
RTresult RTAPI rtVariableSet1ui(RTvariable v, unsigned int u1);
RTresult RTAPI rtVariableSet2ui(RTvariable v, unsigned int u1, unsigned int u2);
RTresult RTAPI rtVariableSet3ui(RTvariable v, unsigned int u1, unsigned int u2, unsigned int u3);
RTresult RTAPI rtVariableSet4ui(RTvariable v, unsigned int u1, unsigned int u2, unsigned int u3,
                                unsigned int u4);
RTresult RTAPI rtVariableSet1uiv(RTvariable v, const unsigned int* u);
RTresult RTAPI rtVariableSet2uiv(RTvariable v, const unsigned int* u);
RTresult RTAPI rtVariableSet3uiv(RTvariable v, const unsigned int* u);
RTresult RTAPI rtVariableSet4uiv(RTvariable v, const unsigned int* u);
RTresult RTAPI rtVariableSet1ll(RTvariable v, long long ll1);
RTresult RTAPI rtVariableSet2ll(RTvariable v, long long ll1, long long ll2);
RTresult RTAPI rtVariableSet3ll(RTvariable v, long long ll1, long long ll2, long long ll3);
RTresult RTAPI rtVariableSet4ll(RTvariable v, long long ll1, long long ll2, long long ll3,
                                long long ll4);
RTresult RTAPI rtVariableSet1llv(RTvariable v, const long long* ll);
RTresult RTAPI rtVariableSet2llv(RTvariable v, const long long* ll);
RTresult RTAPI rtVariableSet3llv(RTvariable v, const long long* ll);
RTresult RTAPI rtVariableSet4llv(RTvariable v, const long long* ll);
RTresult RTAPI rtVariableSet1ull(RTvariable v, unsigned long long ull1);
RTresult RTAPI rtVariableSet2ull(RTvariable v, unsigned long long ull1, unsigned long long ull2);
RTresult RTAPI rtVariableSet3ull(RTvariable v, unsigned long long ull1, unsigned long long ull2,
                                 unsigned long long ull3);
RTresult RTAPI rtVariableSet4ull(RTvariable v, unsigned long long ull1, unsigned long long ull2,
                                 unsigned long long ull3, unsigned long long ull4);
RTresult RTAPI rtVariableSet1ullv(RTvariable v, const unsigned long long* ull);
RTresult RTAPI rtVariableSet2ullv(RTvariable v, const unsigned long long* ull);
RTresult RTAPI rtVariableSet3ullv(RTvariable v, const unsigned long long* ull);
RTresult RTAPI rtVariableSet4ullv(RTvariable v, const unsigned long long* ull);
RTresult RTAPI rtVariableSetMatrix2x2fv(RTvariable v, int transpose, const float* m);
RTresult RTAPI rtVariableSetMatrix2x3fv(RTvariable v, int transpose, const float* m);
RTresult RTAPI rtVariableSetMatrix2x4fv(RTvariable v, int transpose, const float* m);
RTresult RTAPI rtVariableSetMatrix3x2fv(RTvariable v, int transpose, const float* m);
RTresult RTAPI rtVariableSetMatrix3x3fv(RTvariable v, int transpose, const float* m);
RTresult RTAPI rtVariableSetMatrix3x4fv(RTvariable v, int transpose, const float* m);
RTresult RTAPI rtVariableSetMatrix4x2fv(RTvariable v, int transpose, const float* m);
RTresult RTAPI rtVariableSetMatrix4x3fv(RTvariable v, int transpose, const float* m);
RTresult RTAPI rtVariableSetMatrix4x4fv(RTvariable v, int transpose, const float* m);
RTresult RTAPI rtVariableGet1f(RTvariable v, float* f1);
RTresult RTAPI rtVariableGet2f(RTvariable v, float* f1, float* f2);
RTresult RTAPI rtVariableGet3f(RTvariable v, float* f1, float* f2, float* f3);
RTresult RTAPI rtVariableGet4f(RTvariable v, float* f1, float* f2, float* f3, float* f4);
RTresult RTAPI rtVariableGet1fv(RTvariable v, float* f);
RTresult RTAPI rtVariableGet2fv(RTvariable v, float* f);
RTresult RTAPI rtVariableGet3fv(RTvariable v, float* f);
RTresult RTAPI rtVariableGet4fv(RTvariable v, float* f);
RTresult RTAPI rtVariableGet1i(RTvariable v, int* i1);
RTresult RTAPI rtVariableGet2i(RTvariable v, int* i1, int* i2);
RTresult RTAPI rtVariableGet3i(RTvariable v, int* i1, int* i2, int* i3);
RTresult RTAPI rtVariableGet4i(RTvariable v, int* i1, int* i2, int* i3, int* i4);
RTresult RTAPI rtVariableGet1iv(RTvariable v, int* i);
RTresult RTAPI rtVariableGet2iv(RTvariable v, int* i);
RTresult RTAPI rtVariableGet3iv(RTvariable v, int* i);
RTresult RTAPI rtVariableGet4iv(RTvariable v, int* i);
RTresult RTAPI rtVariableGet1ui(RTvariable v, unsigned int* u1);
RTresult RTAPI rtVariableGet2ui(RTvariable v, unsigned int* u1, unsigned int* u2);
RTresult RTAPI rtVariableGet3ui(RTvariable v, unsigned int* u1, unsigned int* u2, unsigned int* u3);
RTresult RTAPI rtVariableGet4ui(RTvariable v, unsigned int* u1, unsigned int* u2, unsigned int* u3,
                                unsigned int* u4);
RTresult RTAPI rtVariableGet1uiv(RTvariable v, unsigned int* u);
RTresult RTAPI rtVariableGet2uiv(RTvariable v, unsigned int* u);
RTresult RTAPI rtVariableGet3uiv(RTvariable v, unsigned int* u);
RTresult RTAPI rtVariableGet4uiv(RTvariable v, unsigned int* u);
RTresult RTAPI rtVariableGet1ll(RTvariable v, long long* ll1);
RTresult RTAPI rtVariableGet2ll(RTvariable v, long long* ll1, long long* ll2);
RTresult RTAPI rtVariableGet3ll(RTvariable v, long long* ll1, long long* ll2, long long* ll3);
RTresult RTAPI rtVariableGet4ll(RTvariable v, long long* ll1, long long* ll2, long long* ll3,
                                long long* ll4);
RTresult RTAPI rtVariableGet1llv(RTvariable v, long long* ll);
RTresult RTAPI rtVariableGet2llv(RTvariable v, long long* ll);
RTresult RTAPI rtVariableGet3llv(RTvariable v, long long* ll);
RTresult RTAPI rtVariableGet4llv(RTvariable v, long long* ll);
RTresult RTAPI rtVariableGet1ull(RTvariable v, unsigned long long* u1);
RTresult RTAPI rtVariableGet2ull(RTvariable v, unsigned long long* u1, unsigned long long* u2);
RTresult RTAPI rtVariableGet3ull(RTvariable v, unsigned long long* u1, unsigned long long* u2,
                                 unsigned long long* u3);
RTresult RTAPI rtVariableGet4ull(RTvariable v, unsigned long long* u1, unsigned long long* u2,
                                 unsigned long long* u3, unsigned long long* u4);
RTresult RTAPI rtVariableGet1ullv(RTvariable v, unsigned long long* ull);
RTresult RTAPI rtVariableGet2ullv(RTvariable v, unsigned long long* ull);
RTresult RTAPI rtVariableGet3ullv(RTvariable v, unsigned long long* ull);
RTresult RTAPI rtVariableGet4ullv(RTvariable v, unsigned long long* ull);
RTresult RTAPI rtVariableGetMatrix2x2fv(RTvariable v, int transpose, float* m);
RTresult RTAPI rtVariableGetMatrix2x3fv(RTvariable v, int transpose, float* m);
RTresult RTAPI rtVariableGetMatrix2x4fv(RTvariable v, int transpose, float* m);
RTresult RTAPI rtVariableGetMatrix3x2fv(RTvariable v, int transpose, float* m);
RTresult RTAPI rtVariableGetMatrix3x3fv(RTvariable v, int transpose, float* m);
RTresult RTAPI rtVariableGetMatrix3x4fv(RTvariable v, int transpose, float* m);
RTresult RTAPI rtVariableGetMatrix4x2fv(RTvariable v, int transpose, float* m);
RTresult RTAPI rtVariableGetMatrix4x3fv(RTvariable v, int transpose, float* m);
RTresult RTAPI rtVariableGetMatrix4x4fv(RTvariable v, int transpose, float* m);

RTresult RTAPI rtBufferCreate(RTcontext context, unsigned int bufferdesc, RTbuffer* buffer);
RTresult RTAPI rtBufferDestroy(RTbuffer buffer);
RTresult RTAPI rtBufferValidate(RTbuffer buffer);
RTresult RTAPI rtBufferGetContext(RTbuffer buffer, RTcontext* context);
RTresult RTAPI rtBufferSetFormat(RTbuffer buffer, RTformat format);
RTresult RTAPI rtBufferGetFormat(RTbuffer buffer, RTformat* format);
RTresult RTAPI rtBufferSetElementSize(RTbuffer buffer, RTsize elementSize);
RTresult RTAPI rtBufferGetElementSize(RTbuffer buffer, RTsize* elementSize);
RTresult RTAPI rtBufferSetSize1D(RTbuffer buffer, RTsize width);
RTresult RTAPI rtBufferGetSize1D(RTbuffer buffer, RTsize* width);
RTresult RTAPI rtBufferSetSize2D(RTbuffer buffer, RTsize width, RTsize height);
RTresult RTAPI rtBufferGetSize2D(RTbuffer buffer, RTsize* width, RTsize* height);
RTresult RTAPI rtBufferSetSize3D(RTbuffer buffer, RTsize width, RTsize height, RTsize depth);
RTresult RTAPI rtBufferSetMipLevelCount(RTbuffer buffer, unsigned int levels);
RTresult RTAPI rtBufferGetSize3D(RTbuffer buffer, RTsize* width, RTsize* height, RTsize* depth);
RTresult RTAPI rtBufferGetMipLevelSize1D(RTbuffer buffer, unsigned int level, RTsize* width);
RTresult RTAPI rtBufferGetMipLevelSize2D(RTbuffer buffer, unsigned int level, RTsize* width,
                                         RTsize* height);
RTresult RTAPI rtBufferGetMipLevelSize3D(RTbuffer buffer, unsigned int level, RTsize* width,
                                         RTsize* height, RTsize* depth);
RTresult RTAPI rtBufferSetSizev(RTbuffer buffer, unsigned int dimensionality, const RTsize* dims);
RTresult RTAPI rtBufferGetSizev(RTbuffer buffer, unsigned int dimensionality, RTsize* dims);
RTresult RTAPI rtBufferGetDimensionality(RTbuffer buffer, unsigned int* dimensionality);
RTresult RTAPI rtBufferGetMipLevelCount(RTbuffer buffer, unsigned int* level);
RTresult RTAPI rtBufferMap(RTbuffer buffer, void** userPointer);
RTresult RTAPI rtBufferUnmap(RTbuffer buffer);
RTresult RTAPI rtBufferMapEx(RTbuffer buffer, unsigned int mapFlags, unsigned int level,
                             void* userOwned, void** optixOwned);
RTresult RTAPI rtBufferUnmapEx(RTbuffer buffer, unsigned int level);
RTresult RTAPI rtBufferGetId(RTbuffer buffer, int* bufferId);
RTresult RTAPI rtBufferGetProgressiveUpdateReady(RTbuffer buffer, int* ready,
                                                 unsigned int* subframeCount,
                                                 unsigned int* maxSubframes);
RTresult RTAPI rtBufferBindProgressiveStream(RTbuffer stream, RTbuffer source);
RTresult RTAPI rtBufferSetAttribute(RTbuffer buffer, RTbufferattribute attrib, RTsize size,
                                    const void* p);
RTresult RTAPI rtBufferGetAttribute(RTbuffer buffer, RTbufferattribute attrib, RTsize size,
                                    void* p);

RTresult RTAPI rtTextureSamplerCreate(RTcontext context, RTtexturesampler* texturesampler);
RTresult RTAPI rtTextureSamplerDestroy(RTtexturesampler texturesampler);
RTresult RTAPI rtTextureSamplerValidate(RTtexturesampler texturesampler);
RTresult RTAPI rtTextureSamplerGetContext(RTtexturesampler texturesampler, RTcontext* context);
RTresult RTAPI rtTextureSamplerSetMipLevelCount(RTtexturesampler texturesampler,
                                                unsigned int mipLevelCount);
RTresult RTAPI rtTextureSamplerGetMipLevelCount(RTtexturesampler texturesampler,
                                                unsigned int* mipLevelCount);
RTresult RTAPI rtTextureSamplerSetArraySize(RTtexturesampler texturesampler,
                                            unsigned int textureCount);
RTresult RTAPI rtTextureSamplerGetArraySize(RTtexturesampler texturesampler,
                                            unsigned int* textureCount);
RTresult RTAPI rtTextureSamplerSetWrapMode(RTtexturesampler texturesampler, unsigned int dimension,
                                           RTwrapmode wrapmode);
RTresult RTAPI rtTextureSamplerGetWrapMode(RTtexturesampler texturesampler, unsigned int dimension,
                                           RTwrapmode* wrapmode);
RTresult RTAPI rtTextureSamplerSetFilteringModes(RTtexturesampler texturesampler,
                                                 RTfiltermode minification,
                                                 RTfiltermode magnification,
                                                 RTfiltermode mipmapping);
RTresult RTAPI rtTextureSamplerGetFilteringModes(RTtexturesampler texturesampler,
                                                 RTfiltermode* minification,
                                                 RTfiltermode* magnification,
                                                 RTfiltermode* mipmapping);
RTresult RTAPI rtTextureSamplerSetMaxAnisotropy(RTtexturesampler texturesampler, float value);
RTresult RTAPI rtTextureSamplerGetMaxAnisotropy(RTtexturesampler texturesampler, float* value);
RTresult RTAPI rtTextureSamplerSetMipLevelClamp(RTtexturesampler texturesampler, float minLevel,
                                                float maxLevel);
RTresult RTAPI rtTextureSamplerGetMipLevelClamp(RTtexturesampler texturesampler, float* minLevel,
                                                float* maxLevel);
RTresult RTAPI rtTextureSamplerSetMipLevelBias(RTtexturesampler texturesampler, float value);
RTresult RTAPI rtTextureSamplerGetMipLevelBias(RTtexturesampler texturesampler, float* value);
RTresult RTAPI rtTextureSamplerSetReadMode(RTtexturesampler texturesampler,
                                           RTtexturereadmode readmode);
RTresult RTAPI rtTextureSamplerGetReadMode(RTtexturesampler texturesampler,
                                           RTtexturereadmode* readmode);
RTresult RTAPI rtTextureSamplerSetIndexingMode(RTtexturesampler texturesampler,
                                               RTtextureindexmode indexmode);
RTresult RTAPI rtTextureSamplerGetIndexingMode(RTtexturesampler texturesampler,
                                               RTtextureindexmode* indexmode);
RTresult RTAPI rtTextureSamplerSetBuffer(RTtexturesampler texturesampler, unsigned int deprecated0,
                                         unsigned int deprecated1, RTbuffer buffer);
RTresult RTAPI rtTextureSamplerGetBuffer(RTtexturesampler texturesampler, unsigned int deprecated0,
                                         unsigned int deprecated1, RTbuffer* buffer);
RTresult RTAPI rtTextureSamplerGetId(RTtexturesampler texturesampler, int* textureId);

RTresult RTAPI rtGeometryGroupCreate(RTcontext context, RTgeometrygroup* geometrygroup);
RTresult RTAPI rtGeometryGroupDestroy(RTgeometrygroup geometrygroup);
RTresult RTAPI rtGeometryGroupValidate(RTgeometrygroup geometrygroup);
RTresult RTAPI rtGeometryGroupGetContext(RTgeometrygroup geometrygroup, RTcontext* context);
RTresult RTAPI rtGeometryGroupSetAcceleration(RTgeometrygroup geometrygroup,
                                              RTacceleration acceleration);
RTresult RTAPI rtGeometryGroupGetAcceleration(RTgeometrygroup geometrygroup,
                                              RTacceleration* acceleration);
RTresult RTAPI rtGeometryGroupSetFlags(RTgeometrygroup group, RTinstanceflags flags);
RTresult RTAPI rtGeometryGroupGetFlags(RTgeometrygroup group, RTinstanceflags* flags);
RTresult RTAPI rtGeometryGroupSetVisibilityMask(RTgeometrygroup group, RTvisibilitymask mask);
RTresult RTAPI rtGeometryGroupGetVisibilityMask(RTgeometrygroup group, RTvisibilitymask* mask);
RTresult RTAPI rtGeometryGroupSetChildCount(RTgeometrygroup geometrygroup, unsigned int count);
RTresult RTAPI rtGeometryGroupGetChildCount(RTgeometrygroup geometrygroup, unsigned int* count);
RTresult RTAPI rtGeometryGroupSetChild(RTgeometrygroup geometrygroup, unsigned int index,
                                       RTgeometryinstance geometryinstance);
RTresult RTAPI rtGeometryGroupGetChild(RTgeometrygroup geometrygroup, unsigned int index,
                                       RTgeometryinstance* geometryinstance);

RTresult RTAPI rtGeometryInstanceCreate(RTcontext context, RTgeometryinstance* geometryinstance);
RTresult RTAPI rtGeometryInstanceDestroy(RTgeometryinstance geometryinstance);
RTresult RTAPI rtGeometryInstanceValidate(RTgeometryinstance geometryinstance);
RTresult RTAPI rtGeometryInstanceGetContext(RTgeometryinstance geometryinstance,
                                            RTcontext* context);
RTresult RTAPI rtGeometryInstanceSetGeometry(RTgeometryinstance geometryinstance,
                                             RTgeometry geometry);
RTresult RTAPI rtGeometryInstanceGetGeometry(RTgeometryinstance geometryinstance,
                                             RTgeometry* geometry);
RTresult RTAPI rtGeometryInstanceSetGeometryTriangles(RTgeometryinstance geometryinstance,
                                                      RTgeometrytriangles geometrytriangles);
RTresult RTAPI rtGeometryInstanceGetGeometryTriangles(RTgeometryinstance geometryinstance,
                                                      RTgeometrytriangles* geometrytriangles);
RTresult RTAPI rtGeometryInstanceSetMaterialCount(RTgeometryinstance geometryinstance,
                                                  unsigned int count);
RTresult RTAPI rtGeometryInstanceGetMaterialCount(RTgeometryinstance geometryinstance,
                                                  unsigned int* count);
RTresult RTAPI rtGeometryInstanceSetMaterial(RTgeometryinstance geometryinstance,
                                             unsigned int index, RTmaterial material);
RTresult RTAPI rtGeometryInstanceGetMaterial(RTgeometryinstance geometryinstance,
                                             unsigned int index, RTmaterial* material);
RTresult RTAPI rtGeometryInstanceDeclareVariable(RTgeometryinstance geometryinstance,
                                                 const char* name, RTvariable* v);
RTresult RTAPI rtGeometryInstanceQueryVariable(RTgeometryinstance geometryinstance,
                                               const char* name, RTvariable* v);
RTresult RTAPI rtGeometryInstanceRemoveVariable(RTgeometryinstance geometryinstance, RTvariable v);
RTresult RTAPI rtGeometryInstanceGetVariableCount(RTgeometryinstance geometryinstance,
                                                  unsigned int* count);
RTresult RTAPI rtGeometryInstanceGetVariable(RTgeometryinstance geometryinstance,
                                             unsigned int index, RTvariable* v);

RTresult RTAPI rtGeometryTrianglesCreate(RTcontext context, RTgeometrytriangles* geometrytriangles);
RTresult RTAPI rtGeometryTrianglesDestroy(RTgeometrytriangles geometrytriangles);
RTresult RTAPI rtGeometryTrianglesValidate(RTgeometrytriangles geometrytriangles);
RTresult RTAPI rtGeometryTrianglesGetContext(RTgeometrytriangles geometrytriangles,
                                             RTcontext* context);
RTresult RTAPI rtGeometryTrianglesSetPrimitiveIndexOffset(RTgeometrytriangles geometrytriangles,
                                                          unsigned int indexOffset);
RTresult RTAPI rtGeometryTrianglesGetPrimitiveIndexOffset(RTgeometrytriangles geometrytriangles,
                                                          unsigned int* indexOffset);
RTresult RTAPI rtGeometryTrianglesSetPreTransformMatrix(RTgeometrytriangles geometrytriangles,
                                                        int transpose, const float* matrix);
RTresult RTAPI rtGeometryTrianglesGetPreTransformMatrix(RTgeometrytriangles geometrytriangles,
                                                        int transpose, float* matrix);
RTresult RTAPI rtGeometryTrianglesSetPrimitiveCount(RTgeometrytriangles geometrytriangles,
                                                    unsigned int triangleCount);
RTresult RTAPI rtGeometryTrianglesGetPrimitiveCount(RTgeometrytriangles geometrytriangles,
                                                    unsigned int* triangleCount);
RTresult RTAPI rtGeometryTrianglesSetTriangleIndices(RTgeometrytriangles geometrytriangles,
                                                     RTbuffer indexBuffer,
                                                     RTsize indexBufferByteOffset,
                                                     RTsize triIndicesByteStride,
                                                     RTformat triIndicesFormat);
RTresult RTAPI rtGeometryTrianglesSetVertices(RTgeometrytriangles geometrytriangles,
                                              unsigned int vertexCount, RTbuffer vertexBuffer,
                                              RTsize vertexBufferByteOffset,
                                              RTsize vertexByteStride, RTformat positionFormat);
RTresult RTAPI rtGeometryTrianglesSetMotionVertices(RTgeometrytriangles geometrytriangles,
                                                    unsigned int vertexCount, RTbuffer vertexBuffer,
                                                    RTsize vertexBufferByteOffset,
                                                    RTsize vertexByteStride,
                                                    RTsize vertexMotionStepByteStride,
                                                    RTformat positionFormat);
RTresult RTAPI rtGeometryTrianglesSetMotionVerticesMultiBuffer(
    RTgeometrytriangles geometrytriangles, unsigned int vertexCount, RTbuffer* vertexBuffers,
    unsigned int vertexBufferCount, RTsize vertexBufferByteOffset, RTsize vertexByteStride,
    RTformat positionFormat);
RTresult RTAPI rtGeometryTrianglesSetMotionSteps(RTgeometrytriangles geometrytriangles,
                                                 unsigned int motionStepCount);
RTresult RTAPI rtGeometryTrianglesGetMotionSteps(RTgeometrytriangles geometrytriangles,
                                                 unsigned int* motionStepCount);
RTresult RTAPI rtGeometryTrianglesSetMotionRange(RTgeometrytriangles geometrytriangles,
                                                 float timeBegin, float timeEnd);
RTresult RTAPI rtGeometryTrianglesGetMotionRange(RTgeometrytriangles geometrytriangles,
                                                 float* timeBegin, float* timeEnd);
RTresult RTAPI rtGeometryTrianglesSetMotionBorderMode(RTgeometrytriangles geometrytriangles,
                                                      RTmotionbordermode beginMode,
                                                      RTmotionbordermode endMode);
RTresult RTAPI rtGeometryTrianglesGetMotionBorderMode(RTgeometrytriangles geometrytriangles,
                                                      RTmotionbordermode* beginMode,
                                                      RTmotionbordermode* endMode);
RTresult RTAPI rtGeometryTrianglesSetBuildFlags(RTgeometrytriangles geometrytriangles,
                                                RTgeometrybuildflags buildFlags);
RTresult RTAPI rtGeometryTrianglesGetMaterialCount(RTgeometrytriangles geometrytriangles,
                                                   unsigned int* numMaterials);
RTresult RTAPI rtGeometryTrianglesSetMaterialCount(RTgeometrytriangles geometrytriangles,
                                                   unsigned int numMaterials);
RTresult RTAPI rtGeometryTrianglesSetMaterialIndices(RTgeometrytriangles geometrytriangles,
                                                     RTbuffer materialIndexBuffer,
                                                     RTsize materialIndexBufferByteOffset,
                                                     RTsize materialIndexByteStride,
                                                     RTformat materialIndexFormat);
RTresult RTAPI rtGeometryTrianglesSetFlagsPerMaterial(RTgeometrytriangles geometrytriangles,
                                                      unsigned int materialIndex,
                                                      RTgeometryflags flags);
RTresult RTAPI rtGeometryTrianglesGetFlagsPerMaterial(RTgeometrytriangles triangles,
                                                      unsigned int materialIndex,
                                                      RTgeometryflags* flags);
RTresult RTAPI rtGeometryTrianglesSetAttributeProgram(RTgeometrytriangles geometrytriangles,
                                                      RTprogram program);
RTresult RTAPI rtGeometryTrianglesGetAttributeProgram(RTgeometrytriangles geometrytriangles,
                                                      RTprogram* program);
RTresult RTAPI rtGeometryTrianglesDeclareVariable(RTgeometrytriangles geometrytriangles,
                                                  const char* name, RTvariable* v);
RTresult RTAPI rtGeometryTrianglesQueryVariable(RTgeometrytriangles geometrytriangles,
                                                const char* name, RTvariable* v);
RTresult RTAPI rtGeometryTrianglesRemoveVariable(RTgeometrytriangles geometrytriangles,
                                                 RTvariable v);
RTresult RTAPI rtGeometryTrianglesGetVariableCount(RTgeometrytriangles geometrytriangles,
                                                   unsigned int* count);
RTresult RTAPI rtGeometryTrianglesGetVariable(RTgeometrytriangles geometrytriangles,
                                              unsigned int index, RTvariable* v);

RTresult RTAPI rtGeometryCreate(RTcontext context, RTgeometry* geometry);
RTresult RTAPI rtGeometryDestroy(RTgeometry geometry);
RTresult RTAPI rtGeometryValidate(RTgeometry geometry);
RTresult RTAPI rtGeometryGetContext(RTgeometry geometry, RTcontext* context);
RTresult RTAPI rtGeometrySetPrimitiveCount(RTgeometry geometry, unsigned int primitiveCount);
RTresult RTAPI rtGeometryGetPrimitiveCount(RTgeometry geometry, unsigned int* primitiveCount);
RTresult RTAPI rtGeometrySetPrimitiveIndexOffset(RTgeometry geometry, unsigned int indexOffset);
RTresult RTAPI rtGeometryGetPrimitiveIndexOffset(RTgeometry geometry, unsigned int* indexOffset);
RTresult RTAPI rtGeometrySetMotionRange(RTgeometry geometry, float timeBegin, float timeEnd);
RTresult RTAPI rtGeometryGetMotionRange(RTgeometry geometry, float* timeBegin, float* timeEnd);
RTresult RTAPI rtGeometrySetMotionBorderMode(RTgeometry geometry, RTmotionbordermode beginMode,
                                             RTmotionbordermode endMode);
RTresult RTAPI rtGeometryGetMotionBorderMode(RTgeometry geometry, RTmotionbordermode* beginMode,
                                             RTmotionbordermode* endMode);
RTresult RTAPI rtGeometrySetMotionSteps(RTgeometry geometry, unsigned int n);
RTresult RTAPI rtGeometryGetMotionSteps(RTgeometry geometry, unsigned int* n);
RTresult RTAPI rtGeometrySetBoundingBoxProgram(RTgeometry geometry, RTprogram program);
RTresult RTAPI rtGeometryGetBoundingBoxProgram(RTgeometry geometry, RTprogram* program);
RTresult RTAPI rtGeometrySetIntersectionProgram(RTgeometry geometry, RTprogram program);
RTresult RTAPI rtGeometryGetIntersectionProgram(RTgeometry geometry, RTprogram* program);
RTresult RTAPI rtGeometrySetFlags(RTgeometry geometry, RTgeometryflags flags);
RTresult RTAPI rtGeometryGetFlags(RTgeometry geometry, RTgeometryflags* flags);
RTresult RTAPI rtGeometryMarkDirty(RTgeometry geometry);
RTresult RTAPI rtGeometryIsDirty(RTgeometry geometry, int* dirty);
RTresult RTAPI rtGeometryDeclareVariable(RTgeometry geometry, const char* name, RTvariable* v);
RTresult RTAPI rtGeometryQueryVariable(RTgeometry geometry, const char* name, RTvariable* v);
RTresult RTAPI rtGeometryRemoveVariable(RTgeometry geometry, RTvariable v);
RTresult RTAPI rtGeometryGetVariableCount(RTgeometry geometry, unsigned int* count);
RTresult RTAPI rtGeometryGetVariable(RTgeometry geometry, unsigned int index, RTvariable* v);

RTresult RTAPI rtMaterialCreate(RTcontext context, RTmaterial* material);
RTresult RTAPI rtMaterialDestroy(RTmaterial material);
RTresult RTAPI rtMaterialValidate(RTmaterial material);
RTresult RTAPI rtMaterialGetContext(RTmaterial material, RTcontext* context);
RTresult RTAPI rtMaterialSetClosestHitProgram(RTmaterial material, unsigned int rayTypeIndex,
                                              RTprogram program);
RTresult RTAPI rtMaterialGetClosestHitProgram(RTmaterial material, unsigned int rayTypeIndex,
                                              RTprogram* program);
RTresult RTAPI rtMaterialSetAnyHitProgram(RTmaterial material, unsigned int rayTypeIndex,
                                          RTprogram program);
RTresult RTAPI rtMaterialGetAnyHitProgram(RTmaterial material, unsigned int rayTypeIndex,
                                          RTprogram* program);
RTresult RTAPI rtMaterialDeclareVariable(RTmaterial material, const char* name, RTvariable* v);
RTresult RTAPI rtMaterialQueryVariable(RTmaterial material, const char* name, RTvariable* v);
RTresult RTAPI rtMaterialRemoveVariable(RTmaterial material, RTvariable v);
RTresult RTAPI rtMaterialGetVariableCount(RTmaterial material, unsigned int* count);
RTresult RTAPI rtMaterialGetVariable(RTmaterial material, unsigned int index, RTvariable* v);

RTresult RTAPI rtAccelerationCreate(RTcontext context, RTacceleration* acceleration);
RTresult RTAPI rtAccelerationDestroy(RTacceleration acceleration);
RTresult RTAPI rtAccelerationValidate(RTacceleration acceleration);
RTresult RTAPI rtAccelerationGetContext(RTacceleration acceleration, RTcontext* context);
RTresult RTAPI rtAccelerationSetBuilder(RTacceleration acceleration, const char* builder);
RTresult RTAPI rtAccelerationGetBuilder(RTacceleration acceleration, const char** stringReturn);
RTresult RTAPI rtAccelerationSetTraverser(RTacceleration acceleration, const char* traverser);
RTresult RTAPI rtAccelerationGetTraverser(RTacceleration acceleration, const char** stringReturn);
RTresult RTAPI rtAccelerationGetProperty(RTacceleration acceleration, const char* name,
                                         const char** stringReturn);
RTresult RTAPI rtAccelerationGetDataSize(RTacceleration acceleration, RTsize* size);
RTresult RTAPI rtAccelerationGetData(RTacceleration acceleration, void* data);
RTresult RTAPI rtAccelerationSetData(RTacceleration acceleration, const void* data, RTsize size);
RTresult RTAPI rtAccelerationMarkDirty(RTacceleration acceleration);
RTresult RTAPI rtAccelerationIsDirty(RTacceleration acceleration, int* dirty);
RTresult RTAPI rtAccelerationSetProperty(RTacceleration acceleration, const char* name,
                                         const char* value);

RTresult RTAPI rtTransformCreate(RTcontext context, RTtransform* transform);
RTresult RTAPI rtTransformDestroy(RTtransform transform);
RTresult RTAPI rtTransformValidate(RTtransform transform);
RTresult RTAPI rtTransformGetContext(RTtransform transform, RTcontext* context);
RTresult RTAPI rtTransformSetMatrix(RTtransform transform, int transpose, const float* matrix,
                                    const float* inverseMatrix);
RTresult RTAPI rtTransformGetMatrix(RTtransform transform, int transpose, float* matrix,
                                    float* inverseMatrix);
RTresult RTAPI rtTransformSetMotionRange(RTtransform transform, float timeBegin, float timeEnd);
RTresult RTAPI rtTransformGetMotionRange(RTtransform transform, float* timeBegin, float* timeEnd);
RTresult RTAPI rtTransformSetMotionBorderMode(RTtransform transform, RTmotionbordermode beginMode,
                                              RTmotionbordermode endMode);
RTresult RTAPI rtTransformGetMotionBorderMode(RTtransform transform, RTmotionbordermode* beginMode,
                                              RTmotionbordermode* endMode);
RTresult RTAPI rtTransformSetMotionKeys(RTtransform transform, unsigned int n, RTmotionkeytype type,
                                        const float* keys);
RTresult RTAPI rtTransformGetMotionKeyType(RTtransform transform, RTmotionkeytype* type);
RTresult RTAPI rtTransformGetMotionKeyCount(RTtransform transform, unsigned int* n);
RTresult RTAPI rtTransformGetMotionKeys(RTtransform transform, float* keys);
RTresult RTAPI rtTransformSetChild(RTtransform transform, RTobject child);
RTresult RTAPI rtTransformGetChild(RTtransform transform, RTobject* child);
RTresult RTAPI rtTransformGetChildType(RTtransform transform, RTobjecttype* type);

RTresult RTAPI rtSelectorCreate(RTcontext context, RTselector* selector);
RTresult RTAPI rtSelectorDestroy(RTselector selector);
RTresult RTAPI rtSelectorValidate(RTselector selector);
RTresult RTAPI rtSelectorGetContext(RTselector selector, RTcontext* context);
RTresult RTAPI rtSelectorSetVisitProgram(RTselector selector, RTprogram program);
RTresult RTAPI rtSelectorGetVisitProgram(RTselector selector, RTprogram* program);
RTresult RTAPI rtSelectorSetChildCount(RTselector selector, unsigned int count);
RTresult RTAPI rtSelectorGetChildCount(RTselector selector, unsigned int* count);
RTresult RTAPI rtSelectorSetChild(RTselector selector, unsigned int index, RTobject child);
RTresult RTAPI rtSelectorGetChild(RTselector selector, unsigned int index, RTobject* child);
RTresult RTAPI rtSelectorGetChildType(RTselector selector, unsigned int index, RTobjecttype* type);
RTresult RTAPI rtSelectorDeclareVariable(RTselector selector, const char* name, RTvariable* v);
RTresult RTAPI rtSelectorQueryVariable(RTselector selector, const char* name, RTvariable* v);
RTresult RTAPI rtSelectorRemoveVariable(RTselector selector, RTvariable v);
RTresult RTAPI rtSelectorGetVariableCount(RTselector selector, unsigned int* count);
RTresult RTAPI rtSelectorGetVariable(RTselector selector, unsigned int index, RTvariable* v);

RTresult RTAPI rtGroupCreate(RTcontext context, RTgroup* group);
RTresult RTAPI rtGroupDestroy(RTgroup group);
RTresult RTAPI rtGroupValidate(RTgroup group);
RTresult RTAPI rtGroupGetContext(RTgroup group, RTcontext* context);
RTresult RTAPI rtGroupSetAcceleration(RTgroup group, RTacceleration acceleration);
RTresult RTAPI rtGroupSetVisibilityMask(RTgroup group, RTvisibilitymask mask);
RTresult RTAPI rtGroupGetVisibilityMask(RTgroup group, RTvisibilitymask* mask);
RTresult RTAPI rtGroupGetAcceleration(RTgroup group, RTacceleration* acceleration);
RTresult RTAPI rtGroupSetChildCount(RTgroup group, unsigned int count);
RTresult RTAPI rtGroupGetChildCount(RTgroup group, unsigned int* count);
RTresult RTAPI rtGroupSetChild(RTgroup group, unsigned int index, RTobject child);
RTresult RTAPI rtGroupGetChild(RTgroup group, unsigned int index, RTobject* child);
RTresult RTAPI rtGroupGetChildType(RTgroup group, unsigned int index, RTobjecttype* type);

RTresult RTAPI rtPostProcessingStageCreateBuiltin(RTcontext context, const char* builtinName,
                                                  RTpostprocessingstage* stage);
RTresult RTAPI rtPostProcessingStageDestroy(RTpostprocessingstage stage);
RTresult RTAPI rtPostProcessingStageDeclareVariable(RTpostprocessingstage stage, const char* name,
                                                    RTvariable* v);
RTresult RTAPI rtPostProcessingStageGetContext(RTpostprocessingstage stage, RTcontext* context);
RTresult RTAPI rtPostProcessingStageQueryVariable(RTpostprocessingstage stage, const char* name,
                                                  RTvariable* variable);
RTresult RTAPI rtPostProcessingStageGetVariableCount(RTpostprocessingstage stage,
                                                     unsigned int* count);
RTresult RTAPI rtPostProcessingStageGetVariable(RTpostprocessingstage stage, unsigned int index,
                                                RTvariable* variable);

RTresult RTAPI rtCommandListCreate(RTcontext context, RTcommandlist* list);
RTresult RTAPI rtCommandListDestroy(RTcommandlist list);
RTresult RTAPI rtCommandListAppendPostprocessingStage(RTcommandlist list,
                                                      RTpostprocessingstage stage,
                                                      RTsize launchWidth, RTsize launchHeight);
RTresult RTAPI rtCommandListAppendLaunch2D(RTcommandlist list, unsigned int entryPointIndex,
                                           RTsize launchWidth, RTsize launchHeight);
RTresult RTAPI rtCommandListFinalize(RTcommandlist list);
RTresult RTAPI rtCommandListExecute(RTcommandlist list);
RTresult RTAPI rtCommandListGetContext(RTcommandlist list, RTcontext* context);

RTresult RTAPI rtRemoteDeviceCreate(const char* url, const char* username, const char* password,
                                    RTremotedevice* remote_dev);
RTresult RTAPI rtRemoteDeviceDestroy(RTremotedevice remote_dev);
RTresult RTAPI rtRemoteDeviceGetAttribute(RTremotedevice remote_dev, RTremotedeviceattribute attrib,
                                          RTsize size, void* p);
RTresult RTAPI rtRemoteDeviceReserve(RTremotedevice remote_dev, unsigned int num_nodes,
                                     unsigned int configuration);
RTresult RTAPI rtRemoteDeviceRelease(RTremotedevice remote_dev);
RTresult RTAPI rtContextSetRemoteDevice(RTcontext context, RTremotedevice remote_dev);

#ifdef __cplusplus
}
#endif

#endif
