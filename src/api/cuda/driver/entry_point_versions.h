// SPDX-License-Identifier: Apache-2.0
// For cuGetProcAddress: the first CUDA version in which a name means a given form of a function,
// recorded from a driver of version 13.0. Rows are in the order of versions.
#pragma once

namespace sunstone::api::cuda {

struct EntryPoints {
    int since;
    const char* form;
    const char* names; // separated by spaces
};

// clang-format off
constexpr EntryPoints kEntryPoints[] = {
    {2000, "",
     "cuArray3DCreate cuArray3DGetDescriptor cuArrayCreate cuArrayDestroy "
     "cuArrayGetDescriptor cuCtxAttach cuCtxCreate cuCtxDestroy cuCtxDetach cuCtxGetDevice "
     "cuCtxPopCurrent cuCtxPushCurrent cuCtxSynchronize cuDeviceComputeCapability "
     "cuDeviceGet cuDeviceGetAttribute cuDeviceGetCount cuDeviceGetName "
     "cuDeviceGetProperties cuDeviceTotalMem cuEventCreate cuEventDestroy cuEventElapsedTime "
     "cuEventQuery cuEventRecord cuEventSynchronize cuFuncSetBlockShape cuFuncSetSharedSize "
     "cuGLCtxCreate cuGLInit cuGLMapBufferObject cuGLRegisterBufferObject "
     "cuGLUnmapBufferObject cuGLUnregisterBufferObject cuInit cuLaunch cuLaunchGrid "
     "cuLaunchGridAsync cuMemAlloc cuMemAllocHost cuMemAllocPitch cuMemFree cuMemFreeHost "
     "cuMemGetAddressRange cuMemGetInfo cuMemcpy2D cuMemcpy2DAsync cuMemcpy2DUnaligned "
     "cuMemcpy3D cuMemcpy3DAsync cuMemcpyAtoA cuMemcpyAtoD cuMemcpyAtoH cuMemcpyAtoHAsync "
     "cuMemcpyDtoA cuMemcpyDtoD cuMemcpyDtoH cuMemcpyDtoHAsync cuMemcpyHtoA "
     "cuMemcpyHtoAAsync cuMemcpyHtoD cuMemcpyHtoDAsync cuMemsetD16 cuMemsetD2D16 "
     "cuMemsetD2D32 cuMemsetD2D8 cuMemsetD32 cuMemsetD8 cuModuleGetFunction "
     "cuModuleGetGlobal cuModuleGetTexRef cuModuleLoad cuModuleLoadData "
     "cuModuleLoadFatBinary cuModuleUnload cuParamSetSize cuParamSetTexRef cuParamSetf "
     "cuParamSeti cuParamSetv cuStreamCreate cuStreamDestroy cuStreamQuery "
     "cuStreamSynchronize cuTexRefCreate cuTexRefDestroy cuTexRefGetAddress "
     "cuTexRefGetAddressMode cuTexRefGetArray cuTexRefGetFilterMode cuTexRefGetFlags "
     "cuTexRefGetFormat cuTexRefSetAddress cuTexRefSetAddressMode cuTexRefSetArray "
     "cuTexRefSetFilterMode cuTexRefSetFlags cuTexRefSetFormat"},
    {2010, "",
     "cuModuleLoadDataEx"},
    {2020, "",
     "cuDriverGetVersion cuFuncGetAttribute cuMemHostAlloc cuMemHostGetDevicePointer "
     "cuTexRefSetAddress2D"},
    {2030, "",
     "cuGLMapBufferObjectAsync cuGLSetBufferObjectMapFlags cuGLUnmapBufferObjectAsync "
     "cuMemHostGetFlags"},
    {3000, "",
     "cuFuncSetCacheConfig cuGetExportTable cuGraphicsGLRegisterBuffer "
     "cuGraphicsGLRegisterImage cuGraphicsMapResources cuGraphicsResourceGetMappedPointer "
     "cuGraphicsResourceSetMapFlags cuGraphicsSubResourceGetMappedArray "
     "cuGraphicsUnmapResources cuGraphicsUnregisterResource cuMemcpyDtoDAsync "
     "cuModuleGetSurfRef cuSurfRefGetArray cuSurfRefSetArray"},
    {3010, "",
     "cuCtxGetLimit cuCtxSetLimit cuGraphicsVDPAURegisterOutputSurface "
     "cuGraphicsVDPAURegisterVideoSurface cuVDPAUCtxCreate cuVDPAUGetDevice"},
    {3020, "",
     "cuCtxGetApiVersion cuCtxGetCacheConfig cuCtxSetCacheConfig cuMemsetD16Async "
     "cuMemsetD2D16Async cuMemsetD2D32Async cuMemsetD2D8Async cuMemsetD32Async "
     "cuMemsetD8Async cuStreamWaitEvent"},
    {3020, "_v2",
     "cuArray3DCreate cuArray3DGetDescriptor cuArrayCreate cuArrayGetDescriptor cuCtxCreate "
     "cuDeviceTotalMem cuGLCtxCreate cuGLMapBufferObject cuGLMapBufferObjectAsync "
     "cuGraphicsResourceGetMappedPointer cuMemAlloc cuMemAllocHost cuMemAllocPitch cuMemFree "
     "cuMemGetAddressRange cuMemGetInfo cuMemHostGetDevicePointer cuMemcpy2D cuMemcpy2DAsync "
     "cuMemcpy2DUnaligned cuMemcpy3D cuMemcpy3DAsync cuMemcpyAtoA cuMemcpyAtoD cuMemcpyAtoH "
     "cuMemcpyAtoHAsync cuMemcpyDtoA cuMemcpyDtoD cuMemcpyDtoDAsync cuMemcpyDtoH "
     "cuMemcpyDtoHAsync cuMemcpyHtoA cuMemcpyHtoAAsync cuMemcpyHtoD cuMemcpyHtoDAsync "
     "cuMemsetD16 cuMemsetD2D16 cuMemsetD2D32 cuMemsetD2D8 cuMemsetD32 cuMemsetD8 "
     "cuModuleGetGlobal cuTexRefGetAddress cuTexRefSetAddress cuTexRefSetAddress2D "
     "cuVDPAUCtxCreate"},
    {4000, "",
     "cuCtxDisablePeerAccess cuCtxEnablePeerAccess cuCtxGetCurrent cuCtxSetCurrent "
     "cuDeviceCanAccessPeer cuLaunchKernel cuMemHostRegister cuMemHostUnregister cuMemcpy "
     "cuMemcpy3DPeer cuMemcpy3DPeerAsync cuMemcpyAsync cuMemcpyPeer cuMemcpyPeerAsync "
     "cuPointerGetAttribute cuProfilerInitialize cuProfilerStart cuProfilerStop"},
    {4000, "_v2",
     "cuCtxDestroy cuCtxPopCurrent cuCtxPushCurrent cuEventDestroy cuStreamDestroy"},
    {4010, "",
     "cuDeviceGetByPCIBusId cuDeviceGetPCIBusId cuGLGetDevices cuIpcCloseMemHandle "
     "cuIpcGetEventHandle cuIpcGetMemHandle cuIpcOpenEventHandle cuIpcOpenMemHandle"},
    {4010, "_v3",
     "cuTexRefSetAddress2D"},
    {4020, "",
     "cuCtxGetSharedMemConfig cuCtxSetSharedMemConfig cuFuncSetSharedMemConfig"},
    {5000, "",
     "cuGraphicsResourceGetMappedMipmappedArray cuMipmappedArrayCreate "
     "cuMipmappedArrayDestroy cuMipmappedArrayGetLevel cuStreamAddCallback "
     "cuSurfObjectCreate cuSurfObjectDestroy cuSurfObjectGetResourceDesc cuTexObjectCreate "
     "cuTexObjectDestroy cuTexObjectGetResourceDesc cuTexObjectGetResourceViewDesc "
     "cuTexObjectGetTextureDesc cuTexRefGetMaxAnisotropy cuTexRefGetMipmapFilterMode "
     "cuTexRefGetMipmapLevelBias cuTexRefGetMipmapLevelClamp cuTexRefGetMipmappedArray "
     "cuTexRefSetMaxAnisotropy cuTexRefSetMipmapFilterMode cuTexRefSetMipmapLevelBias "
     "cuTexRefSetMipmapLevelClamp cuTexRefSetMipmappedArray"},
    {5050, "",
     "cuCtxGetStreamPriorityRange cuLinkAddData cuLinkAddFile cuLinkComplete cuLinkCreate "
     "cuLinkDestroy cuStreamCreateWithPriority cuStreamGetFlags cuStreamGetPriority"},
    {6000, "",
     "cuGetErrorName cuGetErrorString cuMemAllocManaged cuPointerSetAttribute "
     "cuStreamAttachMemAsync"},
    {6050, "",
     "cuOccupancyMaxActiveBlocksPerMultiprocessor cuOccupancyMaxPotentialBlockSize"},
    {6050, "_v2",
     "cuGLGetDevices cuGraphicsResourceSetMapFlags cuLinkAddData cuLinkAddFile cuLinkCreate "
     "cuMemHostRegister"},
    {7000, "",
     "cuCtxGetFlags cuDevicePrimaryCtxGetState cuDevicePrimaryCtxRelease "
     "cuDevicePrimaryCtxReset cuDevicePrimaryCtxRetain cuDevicePrimaryCtxSetFlags "
     "cuEGLStreamConsumerAcquireFrame cuEGLStreamConsumerConnect "
     "cuEGLStreamConsumerDisconnect cuEGLStreamConsumerReleaseFrame "
     "cuEGLStreamProducerConnect cuEGLStreamProducerDisconnect "
     "cuEGLStreamProducerPresentFrame cuEGLStreamProducerReturnFrame "
     "cuGraphicsEGLRegisterImage cuGraphicsResourceGetMappedEglFrame "
     "cuOccupancyMaxActiveBlocksPerMultiprocessorWithFlags "
     "cuOccupancyMaxPotentialBlockSizeWithFlags cuPointerGetAttributes"},
    {8000, "",
     "cuDeviceGetP2PAttribute cuEGLStreamConsumerConnectWithFlags cuMemAdvise "
     "cuMemPrefetchAsync cuMemRangeGetAttribute cuMemRangeGetAttributes cuStreamBatchMemOp "
     "cuStreamWaitValue32 cuStreamWriteValue32 cuTexRefGetBorderColor cuTexRefSetBorderColor"},
    {9000, "",
     "cuFuncSetAttribute cuLaunchCooperativeKernel cuLaunchCooperativeKernelMultiDevice "
     "cuStreamWaitValue64 cuStreamWriteValue64"},
    {9020, "",
     "cuDeviceGetUuid cuStreamGetCtx"},
    {10000, "",
     "cuDestroyExternalMemory cuDestroyExternalSemaphore cuDeviceGetLuid "
     "cuExternalMemoryGetMappedBuffer cuExternalMemoryGetMappedMipmappedArray "
     "cuGraphAddChildGraphNode cuGraphAddDependencies cuGraphAddEmptyNode cuGraphAddHostNode "
     "cuGraphAddKernelNode cuGraphAddMemcpyNode cuGraphAddMemsetNode "
     "cuGraphChildGraphNodeGetGraph cuGraphClone cuGraphCreate cuGraphDestroy "
     "cuGraphDestroyNode cuGraphExecDestroy cuGraphGetEdges cuGraphGetNodes "
     "cuGraphGetRootNodes cuGraphHostNodeGetParams cuGraphHostNodeSetParams "
     "cuGraphInstantiate cuGraphKernelNodeGetParams cuGraphKernelNodeSetParams cuGraphLaunch "
     "cuGraphMemcpyNodeGetParams cuGraphMemcpyNodeSetParams cuGraphMemsetNodeGetParams "
     "cuGraphMemsetNodeSetParams cuGraphNodeFindInClone cuGraphNodeGetDependencies "
     "cuGraphNodeGetDependentNodes cuGraphNodeGetType cuGraphRemoveDependencies "
     "cuImportExternalMemory cuImportExternalSemaphore cuLaunchHostFunc "
     "cuSignalExternalSemaphoresAsync cuStreamBeginCapture cuStreamEndCapture "
     "cuStreamIsCapturing cuWaitExternalSemaphoresAsync"},
    {10010, "",
     "cuGraphExecKernelNodeSetParams cuStreamGetCaptureInfo "
     "cuThreadExchangeStreamCaptureMode"},
    {10010, "_v2",
     "cuStreamBeginCapture"},
    {10020, "",
     "cuDeviceGetNvSciSyncAttributes cuGraphExecHostNodeSetParams "
     "cuGraphExecMemcpyNodeSetParams cuGraphExecMemsetNodeSetParams cuGraphExecUpdate "
     "cuMemAddressFree cuMemAddressReserve cuMemCreate cuMemExportToShareableHandle "
     "cuMemGetAccess cuMemGetAllocationGranularity cuMemGetAllocationPropertiesFromHandle "
     "cuMemImportFromShareableHandle cuMemMap cuMemRelease cuMemSetAccess cuMemUnmap "
     "cuOccupancyAvailableDynamicSMemPerBlock"},
    {11000, "",
     "cuCtxResetPersistingL2Cache cuFuncGetModule cuGraphKernelNodeCopyAttributes "
     "cuGraphKernelNodeGetAttribute cuGraphKernelNodeSetAttribute "
     "cuMemRetainAllocationHandle cuStreamCopyAttributes cuStreamGetAttribute "
     "cuStreamSetAttribute"},
    {11000, "_v2",
     "cuDevicePrimaryCtxRelease cuDevicePrimaryCtxReset cuDevicePrimaryCtxSetFlags "
     "cuGraphInstantiate cuIpcOpenMemHandle"},
    {11010, "",
     "cuArrayGetSparseProperties cuDeviceGetTexture1DLinearMaxWidth cuEventRecordWithFlags "
     "cuGraphAddEventRecordNode cuGraphAddEventWaitNode cuGraphEventRecordNodeGetEvent "
     "cuGraphEventRecordNodeSetEvent cuGraphEventWaitNodeGetEvent "
     "cuGraphEventWaitNodeSetEvent cuGraphExecChildGraphNodeSetParams "
     "cuGraphExecEventRecordNodeSetEvent cuGraphExecEventWaitNodeSetEvent cuGraphUpload "
     "cuMemMapArrayAsync cuMipmappedArrayGetSparseProperties"},
    {11020, "",
     "cuArrayGetPlane cuDeviceGetDefaultMemPool cuDeviceGetMemPool cuDeviceSetMemPool "
     "cuGraphAddExternalSemaphoresSignalNode cuGraphAddExternalSemaphoresWaitNode "
     "cuGraphExecExternalSemaphoresSignalNodeSetParams "
     "cuGraphExecExternalSemaphoresWaitNodeSetParams "
     "cuGraphExternalSemaphoresSignalNodeGetParams "
     "cuGraphExternalSemaphoresSignalNodeSetParams "
     "cuGraphExternalSemaphoresWaitNodeGetParams cuGraphExternalSemaphoresWaitNodeSetParams "
     "cuMemAllocAsync cuMemAllocFromPoolAsync cuMemFreeAsync cuMemPoolCreate "
     "cuMemPoolDestroy cuMemPoolExportPointer cuMemPoolExportToShareableHandle "
     "cuMemPoolGetAccess cuMemPoolGetAttribute cuMemPoolImportFromShareableHandle "
     "cuMemPoolImportPointer cuMemPoolSetAccess cuMemPoolSetAttribute cuMemPoolTrimTo"},
    {11030, "",
     "cuFlushGPUDirectRDMAWrites cuGetProcAddress cuGraphDebugDotPrint "
     "cuGraphReleaseUserObject cuGraphRetainUserObject cuStreamUpdateCaptureDependencies "
     "cuUserObjectCreate cuUserObjectRelease cuUserObjectRetain"},
    {11030, "_v2",
     "cuStreamGetCaptureInfo"},
    {11040, "",
     "cuCtxGetExecAffinity cuDeviceGetExecAffinitySupport cuDeviceGetGraphMemAttribute "
     "cuDeviceGraphMemTrim cuDeviceSetGraphMemAttribute cuGraphAddMemAllocNode "
     "cuGraphAddMemFreeNode cuGraphInstantiateWithFlags cuGraphMemAllocNodeGetParams "
     "cuGraphMemFreeNodeGetParams"},
    {11040, "_v2",
     "cuDeviceGetUuid"},
    {11040, "_v3",
     "cuCtxCreate"},
    {11060, "",
     "cuArrayGetMemoryRequirements cuGraphNodeGetEnabled cuGraphNodeSetEnabled "
     "cuLaunchKernelEx cuMipmappedArrayGetMemoryRequirements"},
    {11070, "",
     "cuGraphAddBatchMemOpNode cuGraphBatchMemOpNodeGetParams cuGraphBatchMemOpNodeSetParams "
     "cuGraphExecBatchMemOpNodeSetParams cuMemGetHandleForAddressRange "
     "cuModuleGetLoadingMode cuOccupancyMaxActiveClusters cuOccupancyMaxPotentialClusterSize"},
    {11070, "_v2",
     "cuStreamBatchMemOp cuStreamWaitValue32 cuStreamWaitValue64 cuStreamWriteValue32 "
     "cuStreamWriteValue64"},
    {12000, "",
     "cuCtxGetId cuGraphExecGetFlags cuGraphInstantiateWithParams cuKernelGetAttribute "
     "cuKernelGetFunction cuKernelSetAttribute cuKernelSetCacheConfig cuLibraryGetGlobal "
     "cuLibraryGetKernel cuLibraryGetManaged cuLibraryGetModule cuLibraryGetUnifiedFunction "
     "cuLibraryLoadData cuLibraryLoadFromFile cuLibraryUnload cuStreamGetId "
     "cuTensorMapEncodeIm2col cuTensorMapEncodeTiled cuTensorMapReplaceAddress"},
    {12000, "_v2",
     "cuGetProcAddress cuGraphAddKernelNode cuGraphExecKernelNodeSetParams cuGraphExecUpdate "
     "cuGraphKernelNodeGetParams cuGraphKernelNodeSetParams"},
    {12010, "",
     "cuCoredumpGetAttribute cuCoredumpGetAttributeGlobal cuCoredumpSetAttribute "
     "cuCoredumpSetAttributeGlobal cuCtxSetFlags cuMulticastAddDevice cuMulticastBindAddr "
     "cuMulticastBindMem cuMulticastCreate cuMulticastGetGranularity cuMulticastUnbind"},
    {12020, "",
     "cuGraphAddNode cuGraphExecNodeSetParams cuGraphNodeSetParams"},
    {12020, "_v2",
     "cuMemAdvise cuMemPrefetchAsync"},
    {12030, "",
     "cuFuncGetName cuGraphConditionalHandleCreate cuKernelGetName "
     "cuStreamBeginCaptureToGraph"},
    {12030, "_v2",
     "cuGraphAddDependencies cuGraphAddNode cuGraphGetEdges cuGraphNodeGetDependencies "
     "cuGraphNodeGetDependentNodes cuGraphRemoveDependencies "
     "cuStreamUpdateCaptureDependencies"},
    {12030, "_v3",
     "cuStreamGetCaptureInfo"},
    {12040, "",
     "cuCtxFromGreenCtx cuCtxGetDevResource cuDevResourceGenerateDesc "
     "cuDevSmResourceSplitByCount cuDeviceGetDevResource cuDeviceRegisterAsyncNotification "
     "cuDeviceUnregisterAsyncNotification cuFuncGetParamInfo cuFuncIsLoaded cuFuncLoad "
     "cuGreenCtxCreate cuGreenCtxDestroy cuGreenCtxGetDevResource cuGreenCtxRecordEvent "
     "cuGreenCtxWaitEvent cuKernelGetParamInfo cuLibraryEnumerateKernels "
     "cuLibraryGetKernelCount cuModuleEnumerateFunctions cuModuleGetFunctionCount "
     "cuStreamGetGreenCtx"},
    {12050, "",
     "cuCtxRecordEvent cuCtxWaitEvent cuGreenCtxStreamCreate cuKernelGetLibrary"},
    {12050, "_v2",
     "cuStreamGetCtx"},
    {12050, "_v4",
     "cuCtxCreate"},
    {12060, "",
     "cuMemBatchDecompressAsync"},
    {12080, "",
     "cuCheckpointProcessCheckpoint cuCheckpointProcessGetRestoreThreadId "
     "cuCheckpointProcessGetState cuCheckpointProcessLock cuCheckpointProcessRestore "
     "cuCheckpointProcessUnlock cuMemcpy3DBatchAsync cuMemcpyBatchAsync cuStreamGetDevice "
     "cuTensorMapEncodeIm2colWide"},
    {12080, "_v2",
     "cuEventElapsedTime"},
    {12090, "",
     "cuGreenCtxGetId cuLogsCurrent cuLogsDumpToFile cuLogsDumpToMemory "
     "cuLogsRegisterCallback cuLogsUnregisterCallback"},
    {13000, "",
     "cuDeviceGetHostAtomicCapabilities cuDeviceGetP2PAtomicCapabilities "
     "cuMemDiscardAndPrefetchBatchAsync cuMemDiscardBatchAsync cuMemGetDefaultMemPool "
     "cuMemGetMemPool cuMemPrefetchBatchAsync cuMemSetMemPool"},
    {13000, "_v2",
     "cuCtxGetDevice cuCtxSynchronize cuMemcpy3DBatchAsync cuMemcpyBatchAsync"},
};
// clang-format on

} // namespace sunstone::api::cuda
