// SPDX-License-Identifier: Apache-2.0
// See advice.h. Ranges of one allocation with different advice are segments of a map. The segments
// of a freed allocation are removed at the next access to their range.
#include "api/cuda/driver/memory/advice.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <mutex>
#include <vector>

using namespace sunstone;
using namespace sunstone::api::cuda;

namespace {

struct Segment {
    uintptr_t end = 0;
    uint64_t allocation = 0; // the allocation's id; 0 for other memory
    Advice advice;
};

class Segments {
public:
    void change(uintptr_t begin, uintptr_t end, uint64_t allocation,
                const std::function<void(Advice&)>& with) {
        forget(begin, end, allocation);
        split(begin);
        split(end);
        uintptr_t at = begin;
        while (at < end) {
            auto found = segments_.lower_bound(at);
            if (found == segments_.end() || found->first > at) {
                const uintptr_t stop = found == segments_.end() ? end : std::min(end, found->first);
                found = segments_.emplace(at, Segment{stop, allocation, {}}).first;
            }
            with(found->second.advice);
            at = found->second.end;
        }
    }
    // The advice of all parts of the range; default advice for unknown parts.
    std::vector<Advice> within(uintptr_t begin, uintptr_t end, uint64_t allocation) {
        forget(begin, end, allocation);
        std::vector<Advice> all;
        uintptr_t at = begin;
        for (auto found = firstAfter(begin); found != segments_.end() && found->first < end;
             ++found) {
            if (found->first > at)
                all.emplace_back();
            all.push_back(found->second.advice);
            at = found->second.end;
        }
        if (at < end)
            all.emplace_back();
        return all;
    }

private:
    using Map = std::map<uintptr_t, Segment>;

    // The first segment that ends after the address.
    Map::iterator firstAfter(uintptr_t address) {
        auto found = segments_.upper_bound(address);
        if (found != segments_.begin() && std::prev(found)->second.end > address)
            --found;
        return found;
    }
    void split(uintptr_t at) {
        const auto found = firstAfter(at);
        if (found == segments_.end() || found->first >= at)
            return;
        segments_.emplace(at, found->second);
        found->second.end = at;
    }
    // Removes the advice for earlier memory at these addresses.
    void forget(uintptr_t begin, uintptr_t end, uint64_t allocation) {
        for (auto found = firstAfter(begin); found != segments_.end() && found->first < end;)
            found =
                found->second.allocation == allocation ? std::next(found) : segments_.erase(found);
    }

    Map segments_;
};

struct Known {
    std::mutex mutex;
    Segments segments;
};
Known& known() {
    static auto* instance = new Known;
    return *instance;
}

void* pointerOf(CUdeviceptr address) {
    return reinterpret_cast<void*>(address);
}

uint64_t allocationOf(CUdeviceptr address) {
    const auto found = cpu::memory().find(pointerOf(address));
    return found ? found->id : 0;
}

int deviceOf(const CUmemLocation& location) {
    return location.type == CU_MEM_LOCATION_TYPE_DEVICE ? location.id : CU_DEVICE_CPU;
}

// The value shared by all parts of a range, or `mixed`.
template <class Answer>
int common(const std::vector<Advice>& parts, int mixed, const Answer& answer) {
    const int first = answer(parts[0]);
    const bool same = std::all_of(parts.begin(), parts.end(),
                                  [&](const Advice& part) { return answer(part) == first; });
    return same ? first : mixed;
}

using Place = std::optional<CUmemLocation> Advice::*;

int placeOf(const std::vector<Advice>& parts, Place place) {
    return common(parts, CU_DEVICE_INVALID, [&](const Advice& part) {
        return part.*place ? deviceOf(*(part.*place)) : CU_DEVICE_INVALID;
    });
}
int placeTypeOf(const std::vector<Advice>& parts, Place place) {
    return common(parts, CU_MEM_LOCATION_TYPE_INVALID, [&](const Advice& part) {
        return part.*place ? int((part.*place)->type) : CU_MEM_LOCATION_TYPE_INVALID;
    });
}
int placeIdOf(const std::vector<Advice>& parts, Place place) {
    return common(parts, 0,
                  [&](const Advice& part) { return part.*place ? (part.*place)->id : 0; });
}

// The devices that access all of the range, then CU_DEVICE_INVALID.
void storeAccessors(const std::vector<Advice>& parts, int* values, size_t count) {
    std::fill_n(values, count, CU_DEVICE_INVALID);
    for (const int device : parts[0].accessedBy) {
        const bool everywhere = std::all_of(parts.begin(), parts.end(), [&](const Advice& part) {
            return part.accessedBy.count(device) != 0;
        });
        if (everywhere && count != 0) {
            *values++ = device;
            --count;
        }
    }
}

void getAttribute(void* data, size_t size, CUmem_range_attribute attribute, CUdeviceptr address,
                  size_t bytes) {
    require(data, "data is null");
    requireShared(address, bytes);
    const bool isList = attribute == CU_MEM_RANGE_ATTRIBUTE_ACCESSED_BY;
    require(isList ? size != 0 && size % 4 == 0 : size == 4,
            "dataSize must be 4, or a multiple of it for CU_MEM_RANGE_ATTRIBUTE_ACCESSED_BY");
    std::lock_guard lock(known().mutex);
    const std::vector<Advice> parts =
        known().segments.within(address, address + bytes, allocationOf(address));
    int value = 0;
    switch (attribute) {
    case CU_MEM_RANGE_ATTRIBUTE_READ_MOSTLY:
        value = common(parts, 0, [](const Advice& part) { return int(part.readMostly); });
        break;
    case CU_MEM_RANGE_ATTRIBUTE_PREFERRED_LOCATION:
        value = placeOf(parts, &Advice::preferred);
        break;
    case CU_MEM_RANGE_ATTRIBUTE_LAST_PREFETCH_LOCATION:
        value = placeOf(parts, &Advice::lastPrefetch);
        break;
    case CU_MEM_RANGE_ATTRIBUTE_PREFERRED_LOCATION_TYPE:
        value = placeTypeOf(parts, &Advice::preferred);
        break;
    case CU_MEM_RANGE_ATTRIBUTE_PREFERRED_LOCATION_ID:
        value = placeIdOf(parts, &Advice::preferred);
        break;
    case CU_MEM_RANGE_ATTRIBUTE_LAST_PREFETCH_LOCATION_TYPE:
        value = placeTypeOf(parts, &Advice::lastPrefetch);
        break;
    case CU_MEM_RANGE_ATTRIBUTE_LAST_PREFETCH_LOCATION_ID:
        value = placeIdOf(parts, &Advice::lastPrefetch);
        break;
    case CU_MEM_RANGE_ATTRIBUTE_ACCESSED_BY:
        storeAccessors(parts, static_cast<int*>(data), size / 4);
        return;
    default:
        refuse(CUDA_ERROR_INVALID_VALUE, "there is no range attribute ", int(attribute));
    }
    std::memcpy(data, &value, sizeof value);
}

CUresult giveAdvice(const char* function, CUdeviceptr address, size_t bytes, CUmem_advise advice,
                    const CUmemLocation& location) {
    return guarded(function, Needs::kContext, [&] {
        requireShared(address, bytes);
        const bool accesses =
            advice == CU_MEM_ADVISE_SET_ACCESSED_BY || advice == CU_MEM_ADVISE_UNSET_ACCESSED_BY;
        if (accesses || advice == CU_MEM_ADVISE_SET_PREFERRED_LOCATION)
            requireLocation(location);
        require(!accesses || location.type == CU_MEM_LOCATION_TYPE_DEVICE ||
                    location.type == CU_MEM_LOCATION_TYPE_HOST,
                "memory is accessed by a device or the host, not by a node of it");
        advise(address, bytes, [&](Advice& known) {
            switch (advice) {
            case CU_MEM_ADVISE_SET_READ_MOSTLY:
            case CU_MEM_ADVISE_UNSET_READ_MOSTLY:
                known.readMostly = advice == CU_MEM_ADVISE_SET_READ_MOSTLY;
                return;
            case CU_MEM_ADVISE_SET_PREFERRED_LOCATION:
                known.preferred = location;
                return;
            case CU_MEM_ADVISE_UNSET_PREFERRED_LOCATION:
                known.preferred.reset();
                return;
            case CU_MEM_ADVISE_SET_ACCESSED_BY:
                known.accessedBy.insert(deviceOf(location));
                return;
            case CU_MEM_ADVISE_UNSET_ACCESSED_BY:
                known.accessedBy.erase(deviceOf(location));
                return;
            }
            refuse(CUDA_ERROR_INVALID_VALUE, "there is no advice ", int(advice));
        });
    });
}

} // namespace

namespace sunstone::api::cuda {

void requireLocation(const CUmemLocation& location) {
    switch (location.type) {
    case CU_MEM_LOCATION_TYPE_DEVICE:
        return requireDevice(location.id);
    case CU_MEM_LOCATION_TYPE_HOST:
    case CU_MEM_LOCATION_TYPE_HOST_NUMA:
    case CU_MEM_LOCATION_TYPE_HOST_NUMA_CURRENT:
        return;
    default:
        refuse(CUDA_ERROR_INVALID_VALUE, "memory location type ", int(location.type));
    }
}

CUmemLocation locationOf(CUdevice device) {
    if (device == CU_DEVICE_CPU)
        return {CU_MEM_LOCATION_TYPE_HOST, 0};
    return {CU_MEM_LOCATION_TYPE_DEVICE, device};
}

void requireShared(CUdeviceptr address, size_t bytes) {
    require(address != 0 && bytes != 0, "the range is empty");
    const void* base = pointerOf(address);
    if (const auto memory = cpu::memory().find(base)) {
        if (!cpu::isManaged(memory->kind) || !cpu::memory().contains(base, bytes))
            refuse(CUDA_ERROR_INVALID_VALUE, base, " + ", bytes,
                   " is not inside an allocation of managed memory");
    } else if (!cpu::isMapped(base, bytes)) {
        refuse(CUDA_ERROR_INVALID_VALUE, base, " + ", bytes, " is not memory of this process");
    }
}

void advise(CUdeviceptr address, size_t bytes, const std::function<void(Advice&)>& change) {
    std::lock_guard lock(known().mutex);
    known().segments.change(address, address + bytes, allocationOf(address), change);
}

} // namespace sunstone::api::cuda

SUNSTONE_EXPORT CUresult cuMemAdvise(CUdeviceptr address, size_t bytes, CUmem_advise advice,
                                     CUmemLocation location) {
    return giveAdvice("cuMemAdvise", address, bytes, advice, location);
}
SUNSTONE_EXPORT CUresult cuMemRangeGetAttribute(void* data, size_t dataSize,
                                                CUmem_range_attribute attribute,
                                                CUdeviceptr address, size_t bytes) {
    return guarded("cuMemRangeGetAttribute", Needs::kContext,
                   [&] { getAttribute(data, dataSize, attribute, address, bytes); });
}
SUNSTONE_EXPORT CUresult cuMemRangeGetAttributes(void** data, size_t* dataSizes,
                                                 CUmem_range_attribute* attributes, size_t count,
                                                 CUdeviceptr address, size_t bytes) {
    return guarded("cuMemRangeGetAttributes", Needs::kContext, [&] {
        require(data && dataSizes && attributes && count != 0,
                "data, dataSizes or attributes is null or empty");
        for (size_t i = 0; i < count; ++i)
            getAttribute(data[i], dataSizes[i], attributes[i], address, bytes);
    });
}

// The form of CUDA 12 and earlier.
#undef cuMemAdvise
SUNSTONE_EXPORT CUresult sunstoneMemAdvise1(CUdeviceptr address, size_t bytes, CUmem_advise advice,
                                            CUdevice device) asm("cuMemAdvise");
SUNSTONE_EXPORT CUresult sunstoneMemAdvise1(CUdeviceptr address, size_t bytes, CUmem_advise advice,
                                            CUdevice device) {
    return giveAdvice("cuMemAdvise", address, bytes, advice, locationOf(device));
}
