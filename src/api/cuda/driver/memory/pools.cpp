// SPDX-License-Identifier: Apache-2.0
// See pools.h.
#include "api/cuda/driver/memory/pools.h"

#include "api/cuda/driver/memory/advice.h"

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>

using namespace sunstone;
using namespace sunstone::api::cuda;

namespace {

struct Pool {
    CUmemLocation location = {CU_MEM_LOCATION_TYPE_DEVICE, 0};
    size_t maxSize = 0; // 0: no limit
    int reuse[3] = {1, 1, 1};
    uint64_t releaseThreshold = 0;
    uint64_t used = 0, usedHigh = 0, reservedHigh = 0;
    bool destroyed = false;
};

struct PoolMemory {
    Pool* pool;
    size_t size;
    uint64_t id; // of the allocation, because an address may be reused
};

struct Pools {
    std::mutex mutex;
    Pool standard;
    Pool* current = &standard;
    std::map<const Pool*, std::unique_ptr<Pool>> created;
    std::map<uintptr_t, PoolMemory> memory;

    Pool& of(CUmemoryPool handle) {
        Pool* pool = reinterpret_cast<Pool*>(handle);
        if (pool == &standard)
            return standard;
        auto found = created.find(pool);
        if (found == created.end() || found->second->destroyed)
            refuse(CUDA_ERROR_INVALID_VALUE, static_cast<void*>(handle), " is not a live pool");
        return *found->second;
    }
    void drop(std::map<uintptr_t, PoolMemory>::iterator entry) {
        Pool* pool = entry->second.pool;
        pool->used -= entry->second.size;
        memory.erase(entry);
        if (pool->destroyed && pool->used == 0)
            created.erase(pool);
    }
    // Removes memory that was freed with its context.
    void forgetDead() {
        for (auto entry = memory.begin(); entry != memory.end();) {
            const auto next = std::next(entry);
            const auto live = cpu::memory().find(reinterpret_cast<void*>(entry->first));
            if (!live || live->id != entry->second.id)
                drop(entry);
            entry = next;
        }
    }
};

Pools& pools() {
    static auto* instance = new Pools;
    return *instance;
}

CUmemoryPool handleOf(Pool* pool) {
    return reinterpret_cast<CUmemoryPool>(pool);
}

// Default and current pools exist only for device memory.
void requireDevicePool(const CUmemLocation* location, CUmemAllocationType type) {
    require(location, "location is null");
    requireLocation(*location);
    if (location->type != CU_MEM_LOCATION_TYPE_DEVICE || type != CU_MEM_ALLOCATION_TYPE_PINNED)
        refuse(CUDA_ERROR_NOT_SUPPORTED, "default pools of other places than the device");
}

std::unique_ptr<Pool> makePool(const CUmemPoolProps& properties) {
    if (properties.allocType == CU_MEM_ALLOCATION_TYPE_MANAGED)
        refuse(CUDA_ERROR_NOT_SUPPORTED, "pools of managed memory");
    require(properties.allocType == CU_MEM_ALLOCATION_TYPE_PINNED,
            "allocType must be CU_MEM_ALLOCATION_TYPE_PINNED");
    requireLocation(properties.location);
    if (properties.handleTypes != CU_MEM_HANDLE_TYPE_NONE)
        refuse(CUDA_ERROR_NOT_SUPPORTED, "pools shared between processes (handle types ",
               int(properties.handleTypes), ")");
    const bool zero = std::all_of(std::begin(properties.reserved), std::end(properties.reserved),
                                  [](unsigned char byte) { return byte == 0; });
    require(zero && !properties.win32SecurityAttributes,
            "reserved or win32SecurityAttributes is not zero");
    auto pool = std::make_unique<Pool>();
    pool->location = properties.location;
    pool->maxSize = properties.maxSize;
    return pool;
}

void setAttribute(Pool& pool, CUmemPool_attribute attribute, const void* value) {
    switch (attribute) {
    case CU_MEMPOOL_ATTR_REUSE_FOLLOW_EVENT_DEPENDENCIES:
    case CU_MEMPOOL_ATTR_REUSE_ALLOW_OPPORTUNISTIC:
    case CU_MEMPOOL_ATTR_REUSE_ALLOW_INTERNAL_DEPENDENCIES: {
        const int flag = *static_cast<const int*>(value);
        require(flag == 0 || flag == 1, "the value is neither 0 nor 1");
        pool.reuse[attribute - CU_MEMPOOL_ATTR_REUSE_FOLLOW_EVENT_DEPENDENCIES] = flag;
        return;
    }
    case CU_MEMPOOL_ATTR_RELEASE_THRESHOLD:
        pool.releaseThreshold = *static_cast<const cuuint64_t*>(value);
        return;
    case CU_MEMPOOL_ATTR_RESERVED_MEM_HIGH:
    case CU_MEMPOOL_ATTR_USED_MEM_HIGH:
        require(*static_cast<const cuuint64_t*>(value) == 0, "a high water mark can only be reset");
        (attribute == CU_MEMPOOL_ATTR_USED_MEM_HIGH ? pool.usedHigh : pool.reservedHigh) =
            pool.used;
        return;
    default:
        refuse(CUDA_ERROR_INVALID_VALUE, "pool attribute ", int(attribute), " cannot be set");
    }
}

void getAttribute(const Pool& pool, CUmemPool_attribute attribute, void* value) {
    auto* number = static_cast<cuuint64_t*>(value);
    switch (attribute) {
    case CU_MEMPOOL_ATTR_REUSE_FOLLOW_EVENT_DEPENDENCIES:
    case CU_MEMPOOL_ATTR_REUSE_ALLOW_OPPORTUNISTIC:
    case CU_MEMPOOL_ATTR_REUSE_ALLOW_INTERNAL_DEPENDENCIES:
        *static_cast<int*>(value) =
            pool.reuse[attribute - CU_MEMPOOL_ATTR_REUSE_FOLLOW_EVENT_DEPENDENCIES];
        return;
    case CU_MEMPOOL_ATTR_RELEASE_THRESHOLD:
        *number = pool.releaseThreshold;
        return;
    case CU_MEMPOOL_ATTR_RESERVED_MEM_CURRENT:
    case CU_MEMPOOL_ATTR_USED_MEM_CURRENT:
        *number = pool.used;
        return;
    case CU_MEMPOOL_ATTR_RESERVED_MEM_HIGH:
        *number = pool.reservedHigh;
        return;
    case CU_MEMPOOL_ATTR_USED_MEM_HIGH:
        *number = pool.usedHigh;
        return;
    default:
        refuse(CUDA_ERROR_INVALID_VALUE, "there is no pool attribute ", int(attribute));
    }
}

// Runs a body with the pools locked.
template <class Body>
CUresult withPools(const char* function, Body&& body) {
    return guarded(function, Needs::kInit, [&] {
        std::lock_guard lock(pools().mutex);
        body(pools());
    });
}

} // namespace

namespace sunstone::api::cuda {

void* allocateFromPool(CUmemoryPool handle, size_t bytes) {
    std::lock_guard lock(pools().mutex);
    Pool& pool = handle ? pools().of(handle) : *pools().current;
    if (pool.maxSize) {
        pools().forgetDead();
        if (bytes > pool.maxSize || pool.used > pool.maxSize - bytes)
            refuse(CUDA_ERROR_OUT_OF_MEMORY, bytes, " bytes from a pool of ", pool.maxSize,
                   " bytes, of which ", pool.used, " are in use");
    }
    void* address =
        cpu::memory().allocate(bytes, cpu::MemoryKind::kDevice, 0, cpu::contexts().current());
    const uintptr_t base = reinterpret_cast<uintptr_t>(address);
    if (auto stale = pools().memory.find(base); stale != pools().memory.end())
        pools().drop(stale);
    pools().memory[base] = {&pool, bytes, cpu::memory().find(address)->id};
    pool.used += bytes;
    pool.usedHigh = std::max(pool.usedHigh, pool.used);
    pool.reservedHigh = std::max(pool.reservedHigh, pool.used);
    return address;
}

void forgetPoolMemory(const void* address, uint64_t allocation) {
    std::lock_guard lock(pools().mutex);
    const auto found = pools().memory.find(reinterpret_cast<uintptr_t>(address));
    if (found != pools().memory.end() && found->second.id == allocation)
        pools().drop(found);
}

CUmemoryPool poolOfMemory(const cpu::Allocation& allocation) {
    std::lock_guard lock(pools().mutex);
    const auto found = pools().memory.find(allocation.base);
    return found == pools().memory.end() || found->second.id != allocation.id
               ? nullptr
               : handleOf(found->second.pool);
}

} // namespace sunstone::api::cuda

SUNSTONE_EXPORT CUresult cuMemPoolCreate(CUmemoryPool* pool, const CUmemPoolProps* properties) {
    return withPools("cuMemPoolCreate", [&](Pools& all) {
        require(pool && properties, "pool or properties is null");
        std::unique_ptr<Pool> made = makePool(*properties);
        *pool = handleOf(made.get());
        all.created[made.get()] = std::move(made);
    });
}
SUNSTONE_EXPORT CUresult cuMemPoolDestroy(CUmemoryPool pool) {
    return withPools("cuMemPoolDestroy", [&](Pools& all) {
        Pool& found = all.of(pool);
        require(&found != &all.standard, "the default pool of a device cannot be destroyed");
        all.forgetDead();
        if (all.current == &found)
            all.current = &all.standard;
        found.destroyed = true; // the pool lives until its memory is freed
        if (found.used == 0)
            all.created.erase(&found);
    });
}
SUNSTONE_EXPORT CUresult cuMemPoolTrimTo(CUmemoryPool pool, size_t) {
    // The pool holds no free memory, so trimming has no effect.
    return withPools("cuMemPoolTrimTo", [&](Pools& all) { all.of(pool); });
}
SUNSTONE_EXPORT CUresult cuMemPoolSetAttribute(CUmemoryPool pool, CUmemPool_attribute attribute,
                                               void* value) {
    return withPools("cuMemPoolSetAttribute", [&](Pools& all) {
        require(value, "value is null");
        all.forgetDead();
        setAttribute(all.of(pool), attribute, value);
    });
}
SUNSTONE_EXPORT CUresult cuMemPoolGetAttribute(CUmemoryPool pool, CUmemPool_attribute attribute,
                                               void* value) {
    return withPools("cuMemPoolGetAttribute", [&](Pools& all) {
        require(value, "value is null");
        all.forgetDead();
        getAttribute(all.of(pool), attribute, value);
    });
}
SUNSTONE_EXPORT CUresult cuMemPoolSetAccess(CUmemoryPool pool, const CUmemAccessDesc* map,
                                            size_t count) {
    return withPools("cuMemPoolSetAccess", [&](Pools& all) {
        all.of(pool);
        require(map || count == 0, "map is null");
        for (size_t i = 0; i < count; ++i) {
            requireLocation(map[i].location);
            require(map[i].flags == CU_MEM_ACCESS_FLAGS_PROT_READWRITE,
                    "a pool's own place always has read and write access");
        }
    });
}
SUNSTONE_EXPORT CUresult cuMemPoolGetAccess(CUmemAccess_flags* flags, CUmemoryPool pool,
                                            CUmemLocation* location) {
    return withPools("cuMemPoolGetAccess", [&](Pools& all) {
        require(flags && location, "flags or location is null");
        all.of(pool);
        requireLocation(*location);
        *flags = CU_MEM_ACCESS_FLAGS_PROT_READWRITE;
    });
}

SUNSTONE_EXPORT CUresult cuDeviceGetDefaultMemPool(CUmemoryPool* pool, CUdevice device) {
    return withPools("cuDeviceGetDefaultMemPool", [&](Pools& all) {
        require(pool, "pool is null");
        requireDevice(device);
        *pool = handleOf(&all.standard);
    });
}
SUNSTONE_EXPORT CUresult cuDeviceGetMemPool(CUmemoryPool* pool, CUdevice device) {
    return withPools("cuDeviceGetMemPool", [&](Pools& all) {
        require(pool, "pool is null");
        requireDevice(device);
        *pool = handleOf(all.current);
    });
}
SUNSTONE_EXPORT CUresult cuDeviceSetMemPool(CUdevice device, CUmemoryPool pool) {
    return withPools("cuDeviceSetMemPool", [&](Pools& all) {
        requireDevice(device);
        all.current = &all.of(pool);
    });
}
SUNSTONE_EXPORT CUresult cuMemGetDefaultMemPool(CUmemoryPool* pool, CUmemLocation* location,
                                                CUmemAllocationType type) {
    return withPools("cuMemGetDefaultMemPool", [&](Pools& all) {
        require(pool, "pool is null");
        requireDevicePool(location, type);
        *pool = handleOf(&all.standard);
    });
}
SUNSTONE_EXPORT CUresult cuMemGetMemPool(CUmemoryPool* pool, CUmemLocation* location,
                                         CUmemAllocationType type) {
    return withPools("cuMemGetMemPool", [&](Pools& all) {
        require(pool, "pool is null");
        requireDevicePool(location, type);
        *pool = handleOf(all.current);
    });
}
SUNSTONE_EXPORT CUresult cuMemSetMemPool(CUmemLocation* location, CUmemAllocationType type,
                                         CUmemoryPool pool) {
    return withPools("cuMemSetMemPool", [&](Pools& all) {
        requireDevicePool(location, type);
        all.current = &all.of(pool);
    });
}
