// SPDX-License-Identifier: Apache-2.0
// Entry points without a context (section 5.20), and the attributes of contexts.
#include "api/optix6/call.h"
#include "base/readable.h"
#include "base/threads/threads.h"

#include <atomic>
#include <cstring>
#include <unistd.h>

using namespace sunstone;
using namespace sunstone::optix6;

namespace {

void requireSize(RTsize size, RTsize wanted) {
    if (size != wanted)
        refuse(RT_ERROR_INVALID_VALUE, "size = ", size, ", but the attribute has ", wanted,
               " bytes");
}

template <class T>
void give(RTsize size, void* p, const T& value) {
    requireNonNull(p, "p");
    requireSize(size, sizeof(T));
    std::memcpy(p, &value, sizeof(T));
}

void giveList(RTsize size, void* p, const std::vector<int>& list) {
    requireNonNull(p, "p");
    requireSize(size, list.size() * sizeof(int));
    std::memcpy(p, list.data(), size);
}

// Copies the part of a text that fits, with a terminator.
void giveText(RTsize size, void* p, std::string_view text) {
    requireNonNull(p, "p");
    if (size == 0)
        refuse(RT_ERROR_INVALID_VALUE, "size = 0");
    const size_t length = std::min<size_t>(size - 1, text.size());
    std::memcpy(p, text.data(), length);
    static_cast<char*>(p)[length] = 0;
}

int capabilityOf(const engine::Gpu* gpu, unsigned part) {
    constexpr int kCpu[2] = {7, 5};
    return gpu ? gpu->capability[part] : kCpu[part];
}

RTsize physicalMemory() {
    return RTsize(sysconf(_SC_PHYS_PAGES)) * RTsize(sysconf(_SC_PAGE_SIZE));
}
RTsize freeMemory(unsigned device) {
    if (!engine::gpus().empty())
        return engine::freeMemory(engine::gpus()[device]);
    return RTsize(sysconf(_SC_AVPHYS_PAGES)) * RTsize(sysconf(_SC_PAGE_SIZE));
}

std::atomic<int> usesRtx{0};

// Null: the CPU.
const engine::Gpu* gpuAt(int ordinal) {
    const std::vector<engine::Gpu>& all = engine::gpus();
    return all.empty() ? nullptr : &all[size_t(ordinal)];
}

// The count, then the devices, then zeros.
std::vector<int> compatibleDevices(int ordinal) {
    std::vector<int> list(deviceCount() + 1);
    for (unsigned i = 0; i < deviceCount(); ++i)
        if (capabilityOf(gpuAt(int(i)), 0) == capabilityOf(gpuAt(ordinal), 0) &&
            capabilityOf(gpuAt(int(i)), 1) == capabilityOf(gpuAt(ordinal), 1))
            list[size_t(++list[0])] = int(i);
    return list;
}

void deviceAttribute(int ordinal, RTdeviceattribute attribute, RTsize size, void* p) {
    const engine::Gpu* const gpu = gpuAt(ordinal);
    const int capability[2] = {capabilityOf(gpu, 0), capabilityOf(gpu, 1)};
    switch (attribute) {
    case RT_DEVICE_ATTRIBUTE_MAX_THREADS_PER_BLOCK:
        return give(size, p, gpu ? gpu->threadsPerBlock : 1024);
    case RT_DEVICE_ATTRIBUTE_CLOCK_RATE:
        return give(size, p, gpu ? gpu->clockKhz : 1000000);
    case RT_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT:
        return give(size, p, gpu ? gpu->multiprocessors : int(threadCount()));
    case RT_DEVICE_ATTRIBUTE_EXECUTION_TIMEOUT_ENABLED:
        return give(size, p, int(gpu && gpu->hasTimeout));
    case RT_DEVICE_ATTRIBUTE_MAX_HARDWARE_TEXTURE_COUNT:
        return give(size, p, 1 << 20);
    case RT_DEVICE_ATTRIBUTE_NAME:
        return giveText(size, p, gpu ? gpu->name : "Sunstone CPU");
    case RT_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY:
        return give(size, p, capability);
    case RT_DEVICE_ATTRIBUTE_TOTAL_MEMORY:
        return give(size, p, gpu ? RTsize(gpu->memoryBytes) : physicalMemory());
    case RT_DEVICE_ATTRIBUTE_TCC_DRIVER:
        return give(size, p, int(gpu && gpu->isTcc));
    case RT_DEVICE_ATTRIBUTE_CUDA_DEVICE_ORDINAL:
        return give(size, p, gpu ? gpu->ordinal : engine::cudaOrdinalOfCpu());
    case RT_DEVICE_ATTRIBUTE_PCI_BUS_ID:
        return giveText(std::min<RTsize>(size, 14), p, gpu ? gpu->pciBusId : "0000:00:00.0");
    case RT_DEVICE_ATTRIBUTE_COMPATIBLE_DEVICES:
        return giveList(size, p, compatibleDevices(ordinal));
    }
    refuse(RT_ERROR_INVALID_VALUE, "attrib = ", unsigned(attribute), " is unknown");
}

} // namespace

SUNSTONE_API RTresult rtGetVersion(unsigned* version) {
    return guarded(nullptr, __func__, [&] { store(version, "version", unsigned(OPTIX_VERSION)); });
}

SUNSTONE_API RTresult rtGlobalSetAttribute(RTglobalattribute attribute, RTsize size,
                                           const void* p) {
    return guarded(nullptr, __func__, [&] {
        if (attribute != RT_GLOBAL_ATTRIBUTE_ENABLE_RTX &&
            attribute != RT_GLOBAL_ATTRIBUTE_DEVELOPER_OPTIONS)
            refuse(RT_ERROR_INVALID_GLOBAL_ATTRIBUTE, "attrib = ", unsigned(attribute),
                   " cannot be set");
        requireNonNull(p, "p");
        if (attribute == RT_GLOBAL_ATTRIBUTE_DEVELOPER_OPTIONS)
            return;
        requireSize(size, sizeof(int));
        int value = 0;
        std::memcpy(&value, p, sizeof value);
        usesRtx = value != 0;
    });
}
SUNSTONE_API RTresult rtGlobalGetAttribute(RTglobalattribute attribute, RTsize size, void* p) {
    return guarded(nullptr, __func__, [&] {
        switch (attribute) {
        case RT_GLOBAL_ATTRIBUTE_ENABLE_RTX:
            return give(size, p, usesRtx.load());
        case RT_GLOBAL_ATTRIBUTE_DISPLAY_DRIVER_VERSION_MAJOR:
        case RT_GLOBAL_ATTRIBUTE_DISPLAY_DRIVER_VERSION_MINOR:
            refuse(RT_ERROR_DRIVER_VERSION_FAILED, "the CPU has no display driver");
        default:
            refuse(RT_ERROR_INVALID_GLOBAL_ATTRIBUTE, "attrib = ", unsigned(attribute),
                   " is unknown");
        }
    });
}
SUNSTONE_API RTresult rtDeviceGetDeviceCount(unsigned* count) {
    return guarded(nullptr, __func__, [&] { store(count, "count", deviceCount()); });
}
SUNSTONE_API RTresult rtDeviceGetAttribute(int ordinal, RTdeviceattribute attribute, RTsize size,
                                           void* p) {
    return guarded(nullptr, __func__, [&] {
        if (ordinal < 0 || unsigned(ordinal) >= deviceCount())
            refuse(RT_ERROR_INVALID_VALUE, "ordinal = ", ordinal, ", but the number of devices is ",
                   deviceCount());
        deviceAttribute(ordinal, attribute, size, p);
    });
}

// ---- attributes of contexts -------------------------------------------------------------------

namespace {

// Attributes that are stored without effect.
bool isKept(RTcontextattribute attribute) {
    return attribute == RT_CONTEXT_ATTRIBUTE_CPU_NUM_THREADS ||
           attribute == RT_CONTEXT_ATTRIBUTE_GPU_PAGING_FORCED_OFF ||
           attribute == RT_CONTEXT_ATTRIBUTE_PREFER_FAST_RECOMPILES ||
           attribute == RT_CONTEXT_ATTRIBUTE_FORCE_INLINE_USER_FUNCTIONS;
}

int keptDefault(RTcontextattribute attribute) {
    if (attribute == RT_CONTEXT_ATTRIBUTE_CPU_NUM_THREADS)
        return int(threadCount());
    return attribute == RT_CONTEXT_ATTRIBUTE_FORCE_INLINE_USER_FUNCTIONS;
}

// A path that the caller gives as text or as a pointer to it: the manual (rtContextSetAttribute)
// has the size of a pointer, and a text as the value. The first bytes of a text are no readable
// address.
std::string pathAt(const void* p) {
    const char* text = nullptr;
    if (isReadable(p, sizeof text))
        std::memcpy(&text, p, sizeof text);
    if (!text || !isReadable(text, 1))
        text = static_cast<const char*>(p);
    if (!isReadable(text, 1))
        refuse(RT_ERROR_INVALID_VALUE, "p = ", p, " is not readable");
    constexpr size_t kMost = 4096;
    return std::string(text, strnlen(text, kMost));
}

void setAttribute(Context& context, RTcontextattribute attribute, RTsize size, const void* p) {
    requireNonNull(p, "p");
    if (isKept(attribute)) {
        requireSize(size, sizeof(int));
        int value = 0;
        std::memcpy(&value, p, sizeof value);
        if (attribute == RT_CONTEXT_ATTRIBUTE_CPU_NUM_THREADS && value < 1)
            refuse(RT_ERROR_INVALID_VALUE, "the number of threads = ", value, " is below 1");
        context.attributes[attribute] = value;
        return;
    }
    if (attribute == RT_CONTEXT_ATTRIBUTE_DISK_CACHE_LOCATION)
        return context.engine->cache->setLocation(pathAt(p));
    if (attribute == RT_CONTEXT_ATTRIBUTE_DISK_CACHE_MEMORY_LIMITS) {
        RTsize limits[2];
        requireSize(size, sizeof limits);
        std::memcpy(limits, p, sizeof limits);
        if ((limits[0] || limits[1]) && limits[1] <= limits[0])
            refuse(RT_ERROR_INVALID_VALUE, "the high mark ", limits[1],
                   " of the disk cache is not above the low mark ", limits[0]);
        return context.engine->cache->setMarks({limits[0], limits[1]});
    }
    refuse(RT_ERROR_INVALID_VALUE, "attrib = ", unsigned(attribute), " cannot be set");
}

void getAttribute(Context& context, RTcontextattribute attribute, RTsize size, void* p) {
    requireNonNull(p, "p");
    if (isKept(attribute)) {
        const auto found = context.attributes.find(attribute);
        return give(size, p,
                    found == context.attributes.end() ? keptDefault(attribute) : found->second);
    }
    // The ordinal of a device is added to this attribute.
    const unsigned device = unsigned(attribute) - RT_CONTEXT_ATTRIBUTE_AVAILABLE_DEVICE_MEMORY;
    if (attribute >= RT_CONTEXT_ATTRIBUTE_AVAILABLE_DEVICE_MEMORY && device < deviceCount())
        return give(size, p, freeMemory(device));
    switch (unsigned(attribute)) {
    case RT_CONTEXT_ATTRIBUTE_MAX_TEXTURE_COUNT:
        return give(size, p, 1 << 20);
    case RT_CONTEXT_ATTRIBUTE_GPU_PAGING_ACTIVE:
        return give(size, p, 0);
    case RT_CONTEXT_ATTRIBUTE_USED_HOST_MEMORY: {
        RTsize bytes = 0;
        for (const Ref<Buffer>& ref : context.allBuffers)
            if (const auto buffer = ref.lock())
                bytes += buffer->bytes();
        return give(size, p, bytes);
    }
    case RT_CONTEXT_ATTRIBUTE_DISK_CACHE_ENABLED:
        return give(size, p, context.engine->cache->enabled());
    case RT_CONTEXT_ATTRIBUTE_DISK_CACHE_LOCATION:
        return give(size, p, context.keep(context.engine->cache->location()));
    case RT_CONTEXT_ATTRIBUTE_DISK_CACHE_MEMORY_LIMITS: {
        const auto marks = context.engine->cache->marks();
        const RTsize limits[2] = {marks.low, marks.high};
        return give(size, p, limits);
    }
    default:
        refuse(RT_ERROR_INVALID_VALUE, "attrib = ", unsigned(attribute), " is unknown");
    }
}

} // namespace

SUNSTONE_API RTresult rtContextSetAttribute(RTcontext handle, RTcontextattribute attribute,
                                            RTsize size, const void* p) {
    return callContext(__func__, handle,
                       [&](Context& context) { setAttribute(context, attribute, size, p); });
}
SUNSTONE_API RTresult rtContextGetAttribute(RTcontext handle, RTcontextattribute attribute,
                                            RTsize size, void* p) {
    return callContext(__func__, handle,
                       [&](Context& context) { getAttribute(context, attribute, size, p); });
}
