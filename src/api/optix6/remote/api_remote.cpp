// SPDX-License-Identifier: Apache-2.0
// Entry points of remote devices.
#include "api/optix6/call.h"
#include "api/optix6/remote/ranks.h"
#include "api/optix6/remote/remote_device.h"
#include "engine/gpu/gpus.h"

#include <unistd.h>

#include <algorithm>
#include <cstring>

using namespace sunstone;
using namespace sunstone::optix6;

namespace {

constexpr const char* kScheme = "mpi:";
constexpr const char* kConfiguration = "ranks of this run";

// Guards all remote devices.
std::mutex& mutexOfDevices() {
    static auto* const mutex = new std::mutex;
    return *mutex;
}

// Entry points without a context's lock.
template <class Body>
RTresult callDevice(const char* function, RTremotedevice handle, const Body& body) {
    return guarded(nullptr, function, [&] {
        const auto device = require<RemoteDevice>(handle, "remote_dev");
        std::lock_guard lock(mutexOfDevices());
        body(*device);
    });
}

unsigned rankCount() {
    const Ranks* const ranks = Ranks::get();
    return ranks ? ranks->size() : 1;
}

bool isUsable(uint32_t rank) {
    return rank == 0 || Ranks::get()->isAlive(rank);
}

// Live ranks that no device has reserved.
std::vector<uint32_t> freeRanks() {
    if (Ranks* const ranks = Ranks::get())
        ranks->refresh();
    std::vector<uint32_t> list;
    for (uint32_t rank = 0; rank < rankCount(); ++rank) {
        const auto holder = objects().findIf([&](const Object& object) {
            if (object.kind != Kind::kRemoteDevice)
                return false;
            const auto& nodes = static_cast<const RemoteDevice&>(object).nodes;
            return std::find(nodes.begin(), nodes.end(), rank) != nodes.end();
        });
        if (isUsable(rank) && !holder)
            list.push_back(rank);
    }
    return list;
}

unsigned reservedCount(const RemoteDevice& device) {
    return unsigned(std::count_if(device.nodes.begin(), device.nodes.end(), isUsable));
}

RTremotedevicestatus statusOf(const RemoteDevice& device) {
    const bool isLost = rankCount() > 1 && Ranks::get()->alive().empty();
    return isLost                 ? RT_REMOTEDEVICE_STATUS_DISCONNECTED
           : device.nodes.empty() ? RT_REMOTEDEVICE_STATUS_CONNECTED
                                  : RT_REMOTEDEVICE_STATUS_RESERVED;
}

RTsize totalMemory() {
    const std::vector<engine::Gpu>& gpus = engine::gpus();
    const Ranks* const ranks = Ranks::get();
    RTsize own = RTsize(sysconf(_SC_PHYS_PAGES)) * RTsize(sysconf(_SC_PAGE_SIZE));
    if (!gpus.empty())
        own = gpus[0].memoryBytes;
    return own + (ranks ? RTsize(ranks->memory()) : 0);
}

template <class T>
void give(RTsize size, void* p, const T& value) {
    if (size != sizeof(T))
        refuse(RT_ERROR_INVALID_VALUE, "size = ", size, ", but the attribute has ", sizeof(T),
               " bytes");
    std::memcpy(p, &value, sizeof(T));
}

void giveText(RTsize size, void* p, const std::string& text) {
    if (size <= text.size())
        refuse(RT_ERROR_INVALID_VALUE, "size = ", size, ", but the text needs ", text.size() + 1,
               " bytes");
    std::memcpy(p, text.c_str(), text.size() + 1);
}

void giveAttribute(const RemoteDevice& device, RTremotedeviceattribute attribute, RTsize size,
                   void* p) {
    switch (attribute) {
    case RT_REMOTEDEVICE_ATTRIBUTE_CLUSTER_URL:
    case RT_REMOTEDEVICE_ATTRIBUTE_HEAD_NODE_URL:
        return giveText(size, p, device.url);
    case RT_REMOTEDEVICE_ATTRIBUTE_NUM_CONFIGURATIONS:
        return give(size, p, 1u);
    case RT_REMOTEDEVICE_ATTRIBUTE_CONFIGURATIONS:
        return giveText(size, p, kConfiguration);
    case RT_REMOTEDEVICE_ATTRIBUTE_STATUS:
        return give(size, p, statusOf(device));
    case RT_REMOTEDEVICE_ATTRIBUTE_NUM_TOTAL_NODES:
        return give(size, p, rankCount());
    case RT_REMOTEDEVICE_ATTRIBUTE_NUM_FREE_NODES:
        return give(size, p, unsigned(freeRanks().size()));
    case RT_REMOTEDEVICE_ATTRIBUTE_NUM_RESERVED_NODES:
        return give(size, p, reservedCount(device));
    case RT_REMOTEDEVICE_ATTRIBUTE_NAME:
        return giveText(size, p, "Sunstone");
    case RT_REMOTEDEVICE_ATTRIBUTE_GPU_TOTAL_MEMORY:
        return give(size, p, totalMemory());
    default:
        refuse(RT_ERROR_INVALID_VALUE, "attrib = ", unsigned(attribute), " is unknown");
    }
}

} // namespace

std::vector<uint32_t> sunstone::optix6::reservedNodes(const Ref<RemoteDevice>& ref) {
    const std::shared_ptr<RemoteDevice> device = ref.lock();
    if (!device)
        refuse(RT_ERROR_CLUSTER_NOT_RUNNING, "the context's remote device is destroyed");
    std::lock_guard lock(mutexOfDevices());
    if (device->nodes.empty())
        refuse(RT_ERROR_CLUSTER_NOT_RUNNING, "the context's remote device has no reserved nodes");
    return device->nodes;
}

// `mpirun` has started the ranks, so the function ignores the user's name and password.
SUNSTONE_API RTresult rtRemoteDeviceCreate(const char* url, const char*, const char*,
                                           RTremotedevice* remote_dev) {
    return guarded(nullptr, __func__, [&] {
        requireNonNull(remote_dev, "remote_dev");
        *remote_dev = nullptr;
        watchForks();
        requireNonNull(url, "url");
        if (std::strncmp(url, kScheme, std::strlen(kScheme)) != 0)
            refuse(RT_ERROR_CONNECTION_FAILED, "url = \"", url, "\" does not begin with \"",
                   kScheme, "\": remote devices are the ranks of `mpirun sunstone run`");
        *remote_dev =
            static_cast<RTremotedevice>(objects().add(std::make_shared<RemoteDevice>(url)));
    });
}

SUNSTONE_API RTresult rtRemoteDeviceDestroy(RTremotedevice remote_dev) {
    return callDevice(__func__, remote_dev, [&](RemoteDevice&) { objects().remove(remote_dev); });
}

SUNSTONE_API RTresult rtRemoteDeviceGetAttribute(RTremotedevice remote_dev,
                                                 RTremotedeviceattribute attribute, RTsize size,
                                                 void* p) {
    return callDevice(__func__, remote_dev, [&](RemoteDevice& device) {
        requireNonNull(p, "p");
        giveAttribute(device, attribute, size, p);
    });
}

SUNSTONE_API RTresult rtRemoteDeviceReserve(RTremotedevice remote_dev, unsigned count,
                                            unsigned configuration) {
    return callDevice(__func__, remote_dev, [&](RemoteDevice& device) {
        if (count == 0)
            refuse(RT_ERROR_INVALID_VALUE, "num_nodes is 0");
        if (configuration != 0)
            refuse(RT_ERROR_INVALID_VALUE, "configuration = ", configuration,
                   ", but there is only configuration 0");
        if (!device.nodes.empty())
            refuse(RT_ERROR_CLUSTER_ALREADY_RUNNING, "the remote device has ", device.nodes.size(),
                   " reserved nodes");
        std::vector<uint32_t> free = freeRanks();
        if (count > free.size())
            refuse(RT_ERROR_INSUFFICIENT_FREE_NODES, "num_nodes = ", count, ", but ", free.size(),
                   " nodes are free");
        free.resize(count);
        device.nodes = std::move(free);
    });
}

SUNSTONE_API RTresult rtRemoteDeviceRelease(RTremotedevice remote_dev) {
    return callDevice(__func__, remote_dev, [&](RemoteDevice& device) {
        if (device.nodes.empty())
            refuse(RT_ERROR_CLUSTER_NOT_RUNNING, "the remote device has no reserved nodes");
        device.nodes.clear();
    });
}

// Null: all ranks again, as before the first call.
SUNSTONE_API RTresult rtContextSetRemoteDevice(RTcontext handle, RTremotedevice remote_dev) {
    return callContext(
        __func__, handle,
        [&](Context& context) {
            context.remoteDevice.reset();
            context.usesRemoteDevice = false;
            if (!remote_dev)
                return;
            const auto device = require<RemoteDevice>(remote_dev, "remote_dev");
            reservedNodes(device);
            context.remoteDevice = device;
            context.usesRemoteDevice = true;
        },
        RT_ERROR_INVALID_CONTEXT);
}
