// SPDX-License-Identifier: Apache-2.0
// Contexts: creation, the stack of current ones, limits and preferences.
#include "api/cuda/driver/shell.h"
#include "base/readable.h"

using namespace sunstone;
using namespace sunstone::api::cuda;

namespace {

CUcontext handleOf(cpu::Context* context) {
    return reinterpret_cast<CUcontext>(context);
}

void requireFlags(unsigned flags) {
    const unsigned schedule = flags & CU_CTX_SCHED_MASK;
    require((flags & ~unsigned(CU_CTX_FLAGS_MASK)) == 0 &&
                (schedule == 0 || schedule == 1 || schedule == 2 || schedule == 4),
            "unknown context flags");
}

CUresult createContext(const char* function, CUcontext* context, unsigned flags, CUdevice device) {
    return guarded(function, Needs::kInit, [&] {
        require(context, "context is null");
        requireFlags(flags);
        requireDevice(device);
        *context = handleOf(cpu::contexts().create(flags));
    });
}

} // namespace

SUNSTONE_EXPORT CUresult cuDevicePrimaryCtxRetain(CUcontext* context, CUdevice device) {
    return guarded("cuDevicePrimaryCtxRetain", Needs::kInit, [&] {
        require(context, "context is null");
        requireDevice(device);
        *context = handleOf(cpu::contexts().retainPrimary());
    });
}
SUNSTONE_EXPORT CUresult cuDevicePrimaryCtxRelease(CUdevice device) {
    return guarded("cuDevicePrimaryCtxRelease", Needs::kInit, [&] {
        requireDevice(device);
        if (!cpu::contexts().releasePrimary())
            refuse(CUDA_ERROR_INVALID_CONTEXT, "the primary context is not retained");
    });
}
SUNSTONE_EXPORT CUresult cuDevicePrimaryCtxReset(CUdevice device) {
    return guarded("cuDevicePrimaryCtxReset", Needs::kInit, [&] {
        requireDevice(device);
        cpu::contexts().resetPrimary();
    });
}
SUNSTONE_EXPORT CUresult cuDevicePrimaryCtxSetFlags(CUdevice device, unsigned int flags) {
    return guarded("cuDevicePrimaryCtxSetFlags", Needs::kInit, [&] {
        requireDevice(device);
        requireFlags(flags);
        cpu::contexts().setPrimaryFlags(flags);
    });
}
SUNSTONE_EXPORT CUresult cuDevicePrimaryCtxGetState(CUdevice device, unsigned int* flags,
                                                    int* active) {
    return guarded("cuDevicePrimaryCtxGetState", Needs::kInit, [&] {
        requireDevice(device);
        require(flags && active, "flags or active is null");
        *flags = cpu::contexts().primaryFlags();
        *active = cpu::contexts().primaryActive();
    });
}

SUNSTONE_EXPORT CUresult cuCtxCreate(CUcontext* context, CUctxCreateParams* params,
                                     unsigned int flags, CUdevice device) {
    const CUresult checked = guarded("cuCtxCreate", Needs::kInit, [&] {
        require(!params || isReadable(params, sizeof(*params)), "params is no readable memory");
        if (params && (params->numExecAffinityParams != 0 || params->cigParams))
            refuse(CUDA_ERROR_NOT_SUPPORTED, "execution affinity and graphics clients");
    });
    return checked == CUDA_SUCCESS ? createContext("cuCtxCreate", context, flags, device) : checked;
}
SUNSTONE_EXPORT CUresult cuCtxCreate_v2(CUcontext* context, unsigned int flags, CUdevice device) {
    return createContext("cuCtxCreate_v2", context, flags, device);
}
SUNSTONE_EXPORT CUresult cuCtxCreate_v3(CUcontext* context, void*, int count, unsigned int flags,
                                        CUdevice device) {
    if (count != 0) // without any, the pointer is ignored
        return guarded("cuCtxCreate_v3", Needs::kInit,
                       [] { refuse(CUDA_ERROR_NOT_SUPPORTED, "execution affinity"); });
    return createContext("cuCtxCreate_v3", context, flags, device);
}
SUNSTONE_EXPORT CUresult cuCtxDestroy(CUcontext context) {
    return guarded("cuCtxDestroy", Needs::kInit, [&] {
        if (!cpu::contexts().destroy(context))
            refuse(CUDA_ERROR_INVALID_CONTEXT, "not a live context made by cuCtxCreate");
    });
}

SUNSTONE_EXPORT CUresult cuCtxPushCurrent(CUcontext context) {
    return guarded("cuCtxPushCurrent", Needs::kInit,
                   [&] { cpu::contexts().push(requireContext(context)); });
}
SUNSTONE_EXPORT CUresult cuCtxPopCurrent(CUcontext* context) {
    return guarded("cuCtxPopCurrent", Needs::kAnyContext, [&] {
        cpu::Context* popped = cpu::contexts().pop();
        if (context)
            *context = handleOf(popped);
    });
}
SUNSTONE_EXPORT CUresult cuCtxSetCurrent(CUcontext context) {
    return guarded("cuCtxSetCurrent", Needs::kInit, [&] {
        cpu::contexts().setCurrent(context ? requireContext(context) : nullptr);
    });
}
SUNSTONE_EXPORT CUresult cuCtxGetCurrent(CUcontext* context) {
    return guarded("cuCtxGetCurrent", Needs::kInit, [&] {
        require(context, "context is null");
        *context = handleOf(cpu::contexts().current());
    });
}
SUNSTONE_EXPORT CUresult cuCtxGetDevice(CUdevice* device) {
    return guarded("cuCtxGetDevice", Needs::kAnyContext, [&] {
        require(device, "device is null");
        *device = 0;
    });
}
SUNSTONE_EXPORT CUresult cuCtxGetFlags(unsigned int* flags) {
    return guarded("cuCtxGetFlags", Needs::kAnyContext, [&] {
        require(flags, "flags is null");
        *flags = cpu::contexts().current()->flags;
    });
}
SUNSTONE_EXPORT CUresult cuCtxSetFlags(unsigned int flags) {
    return guarded("cuCtxSetFlags", Needs::kAnyContext, [&] {
        requireFlags(flags);
        cpu::contexts().current()->flags = flags;
    });
}
SUNSTONE_EXPORT CUresult cuCtxGetId(CUcontext context, unsigned long long* id) {
    return guarded("cuCtxGetId", context ? Needs::kInit : Needs::kAnyContext, [&] {
        require(id, "id is null");
        *id = (context ? requireContext(context) : cpu::contexts().current())->id;
    });
}
SUNSTONE_EXPORT CUresult cuCtxSynchronize(void) {
    return guarded("cuCtxSynchronize", Needs::kContext, [] { cpu::streams().synchronizeAll(); });
}
SUNSTONE_EXPORT CUresult cuCtxGetDevice_v2(CUdevice* device, CUcontext context) {
    return guarded("cuCtxGetDevice_v2", Needs::kInit, [&] {
        require(device, "device is null");
        if (context)
            requireContext(context);
        else if (!cpu::contexts().shareCurrent())
            refuse(CUDA_ERROR_INVALID_CONTEXT, "no context is current on this thread");
        *device = 0;
    });
}
SUNSTONE_EXPORT CUresult cuCtxSynchronize_v2(CUcontext context) {
    return guarded("cuCtxSynchronize_v2", Needs::kInit, [&] {
        const cpu::ContextPtr target =
            context ? cpu::contexts().find(context) : cpu::contexts().shareCurrent();
        if (!target)
            refuse(CUDA_ERROR_INVALID_CONTEXT, static_cast<void*>(context), " is not live");
        cpu::streams().synchronizeAll();
        if (const int fault = target->fault)
            refuse(CUresult(fault),
                   "device code has failed in this context: ", target->faultText());
    });
}
SUNSTONE_EXPORT CUresult cuCtxGetApiVersion(CUcontext context, unsigned int* version) {
    return guarded("cuCtxGetApiVersion", context ? Needs::kInit : Needs::kAnyContext, [&] {
        require(version, "version is null");
        if (context)
            requireContext(context);
        *version = 3020;
    });
}

SUNSTONE_EXPORT CUresult cuCtxSetLimit(CUlimit limit, size_t value) {
    return guarded("cuCtxSetLimit", Needs::kAnyContext, [&] {
        if (unsigned(limit) > CU_LIMIT_PERSISTING_L2_CACHE_SIZE)
            refuse(CUDA_ERROR_UNSUPPORTED_LIMIT, "there is no limit ", int(limit));
        cpu::contexts().current()->limits[limit] = value;
    });
}
SUNSTONE_EXPORT CUresult cuCtxGetLimit(size_t* value, CUlimit limit) {
    return guarded("cuCtxGetLimit", Needs::kContext, [&] {
        require(value, "value is null");
        if (unsigned(limit) > CU_LIMIT_PERSISTING_L2_CACHE_SIZE)
            refuse(CUDA_ERROR_UNSUPPORTED_LIMIT, "there is no limit ", int(limit));
        *value = cpu::contexts().current()->limits[limit];
    });
}
SUNSTONE_EXPORT CUresult cuCtxGetCacheConfig(CUfunc_cache* config) {
    return guarded("cuCtxGetCacheConfig", Needs::kAnyContext, [&] {
        require(config, "config is null");
        *config = CUfunc_cache(cpu::contexts().current()->cacheConfig.load());
    });
}
SUNSTONE_EXPORT CUresult cuCtxSetCacheConfig(CUfunc_cache config) {
    return guarded("cuCtxSetCacheConfig", Needs::kAnyContext, [&] {
        require(unsigned(config) <= CU_FUNC_CACHE_PREFER_EQUAL, "unknown cache configuration");
        cpu::contexts().current()->cacheConfig = config;
    });
}
SUNSTONE_EXPORT CUresult cuCtxGetSharedMemConfig(CUsharedconfig* config) {
    return guarded("cuCtxGetSharedMemConfig", Needs::kAnyContext, [&] {
        require(config, "config is null");
        *config = CUsharedconfig(cpu::contexts().current()->sharedConfig.load());
    });
}
SUNSTONE_EXPORT CUresult cuCtxSetSharedMemConfig(CUsharedconfig config) {
    return guarded("cuCtxSetSharedMemConfig", Needs::kAnyContext, [&] {
        require(unsigned(config) <= CU_SHARED_MEM_CONFIG_EIGHT_BYTE_BANK_SIZE,
                "unknown shared memory configuration");
        cpu::contexts().current()->sharedConfig = config;
    });
}
SUNSTONE_EXPORT CUresult cuCtxGetStreamPriorityRange(int* least, int* greatest) {
    return guarded("cuCtxGetStreamPriorityRange", Needs::kContext, [&] {
        if (least)
            *least = cpu::Streams::kLeastPriority;
        if (greatest)
            *greatest = cpu::Streams::kGreatestPriority;
    });
}
SUNSTONE_EXPORT CUresult cuCtxEnablePeerAccess(CUcontext peer, unsigned int flags) {
    return guarded("cuCtxEnablePeerAccess", Needs::kContext, [&] {
        require(flags == 0, "flags must be 0");
        if (requireContext(peer) == cpu::contexts().current())
            refuse(CUDA_ERROR_INVALID_CONTEXT, "a context is no peer of itself");
        refuse(CUDA_ERROR_PEER_ACCESS_UNSUPPORTED, "there is one device");
    });
}
SUNSTONE_EXPORT CUresult cuCtxDisablePeerAccess(CUcontext peer) {
    return guarded("cuCtxDisablePeerAccess", Needs::kContext, [&] {
        requireContext(peer);
        refuse(CUDA_ERROR_PEER_ACCESS_NOT_ENABLED, "there is one device");
    });
}
