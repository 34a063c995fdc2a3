// SPDX-License-Identifier: Apache-2.0
#include "world.h"

#include <sys/mman.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <stdexcept>

namespace fuzz {

namespace {

constexpr size_t kPage = 4096;

std::vector<Call>& list() {
    static std::vector<Call> calls;
    return calls;
}

} // namespace

Call::Call(const char* callName, int callWeight, void (*function)(World&))
    : name(callName), weight(callWeight), run(function) {
    // Sorted by name: a sequence must not depend on the order in which files are linked.
    auto before = [](const Call& a, const Call& b) { return std::string(a.name) < b.name; };
    list().insert(std::upper_bound(list().begin(), list().end(), *this, before), *this);
}

const std::vector<Call>& calls() {
    return list();
}

const std::string& programs() {
    static const std::string text = [] {
        std::ifstream file(SUNSTONE_FUZZ_PTX);
        std::ostringstream all;
        all << file.rdbuf();
        if (!file)
            throw std::runtime_error("cannot read " SUNSTONE_FUZZ_PTX);
        return all.str();
    }();
    return text;
}

std::map<std::string, std::array<uint64_t, 2>>& counts() {
    static std::map<std::string, std::array<uint64_t, 2>> map;
    return map;
}

World::World(uint64_t seed, bool print)
    : random_(seed), print_(print), isCalm_(random_() % 3 != 0) {}

World::~World() {
    for (OptixDenoiser denoiser : denoisers.live)
        done("optixDenoiserDestroy", optixDenoiserDestroy(denoiser));
    for (OptixPipeline pipeline : pipelines.live)
        done("optixPipelineDestroy", optixPipelineDestroy(pipeline));
    for (OptixProgramGroup group : groups.live)
        done("optixProgramGroupDestroy", optixProgramGroupDestroy(group));
    for (const auto* list : {&modules, &builtins})
        for (OptixModule module : list->live)
            done("optixModuleDestroy", optixModuleDestroy(module));
    for (OptixDeviceContext context : contexts.live)
        done("optixDeviceContextDestroy", optixDeviceContextDestroy(context));
    wait();
    for (const Mapping& mapping : mappings_)
        munmap(mapping.base, mapping.size);
}

uint32_t World::any32() {
    switch (below(5)) {
    case 0:
        return below(8);
    case 1:
        return ~below(4);
    case 2:
        return (1u << below(32)) + below(3) - 1;
    case 3:
        return below(5000);
    default:
        return uint32_t(random_());
    }
}

size_t World::anySize() {
    switch (below(4)) {
    case 0:
        return any32();
    case 1:
        return ~size_t(below(300));
    case 2:
        return (size_t(1) << below(64)) + below(3) - 1;
    default:
        return size_t(random_());
    }
}

float World::anyFloat() {
    using Limits = std::numeric_limits<float>;
    switch (below(10)) {
    case 0:
        return oneOf({0.0f, -0.0f, Limits::infinity(), -Limits::infinity(), Limits::quiet_NaN(),
                      Limits::max(), Limits::lowest(), Limits::denorm_min(), Limits::min()});
    case 1: {
        uint32_t bits = uint32_t(random_());
        float value;
        std::memcpy(&value, &bits, sizeof(value));
        return value;
    }
    default:
        return coordinate();
    }
}

void World::garble(void* bytes, size_t size) {
    for (unsigned i = 0, count = 1 + below(4); i < count && size != 0; ++i)
        static_cast<uint8_t*>(bytes)[random_() % size] = uint8_t(random_());
}

OptixTraversableHandle World::traversable() {
    if (!structures.empty() && chance(75))
        return structures[below(uint32_t(structures.size()))].handle;
    if (!transforms.empty() && chance(60))
        return transforms[below(uint32_t(transforms.size()))];
    size_t garbage = chance(50) ? 0 : anySize();
    // Shadow memory of sanitizers: mapped, but instrumented code must not read it.
    bool isShadow = garbage >= 0x7fff8000 && garbage < 0x100080000000;
    return isShadow ? garbage | (size_t(1) << 62) : garbage;
}

CUdeviceptr World::memory(size_t size, size_t alignment) {
    size_t room = (size + kPage - 1) / kPage * kPage;
    void* base =
        mmap(nullptr, room + kPage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (base == MAP_FAILED)
        throw std::runtime_error("no memory for the fuzzer");
    // The page stays mapped: another mapping might take its place.
    mprotect(static_cast<char*>(base) + room, kPage, PROT_NONE);
    mappings_.push_back({base, room + kPage});
    mapped_ += room + kPage;
    CUdeviceptr end = CUdeviceptr(uintptr_t(base)) + room;
    return (end - size) / alignment * alignment;
}

CUdeviceptr World::address(size_t size, size_t alignment) {
    if (chance(94))
        return memory(size, alignment);
    switch (below(5)) {
    case 0:
        return 0;
    case 1:
        return memory(size + alignment, alignment) + 1 + below(uint32_t(alignment)); // misaligned
    case 2:
        return CUdeviceptr(anySize() | (size_t(1) << 63)); // where no program has memory
    case 3: {
        static void* unreadable =
            mmap(nullptr, kPage * 64, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        return CUdeviceptr(uintptr_t(unreadable));
    }
    default:
        return size < 2 ? 0 : memory(size / 2, alignment); // the end is out of bounds
    }
}

void World::done(const char* function, OptixResult result, const std::string& arguments) {
    const char* name = optixGetErrorName(result);
    if (!name || std::string(name).rfind("OPTIX_", 0) != 0) {
        std::fprintf(stderr, "%s gave %d, which is no result\n", function, int(result));
        std::abort();
    }
    ++counts()[function][result == OPTIX_SUCCESS];
    if (print_)
        std::printf("  %s(%s) = %s\n", function, arguments.c_str(), name);
}

void World::note(const std::string& text) const {
    if (print_)
        std::printf("%s\n", text.c_str());
}

void World::wait() {
    OptixDeviceContext context = nullptr;
    if (optixDeviceContextCreate(nullptr, nullptr, &context) != OPTIX_SUCCESS ||
        optixDeviceContextDestroy(context) != OPTIX_SUCCESS) {
        std::fprintf(stderr, "cannot wait for the device\n");
        std::abort();
    }
}

} // namespace fuzz
