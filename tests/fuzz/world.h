// SPDX-License-Identifier: Apache-2.0
// Shared by the calls of the API fuzzer: a stream of random numbers, the handles made so far (live
// and dead), device memory followed by unreadable pages, and the transcript.
//
// A call is one function `void(World&)` that picks arguments with the functions below, makes one
// API call (or a few related ones) and passes the result to World::done. A static object registers
// it: `static const Call kCall{"optixX", weight, fuzzX};` (calls_*.cpp). A new feature needs
// nothing else.
//
// The caller's obligations are kept: pointers to host memory are null or valid, and device memory
// passed as readable is readable or not mapped at all. All else is random: sizes, counts,
// enumerators, flags, floats, handles, alignments, the bytes of every buffer.
//
// The same files make two fuzzers: fuzz_api with the OptiX 7.4 headers, fuzz_api76 with those of
// 7.6. Code that only 7.6 has is behind FUZZ_76.
#pragma once

#include "optix.h"
#include "optix_stubs.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#define FUZZ_76 (OPTIX_VERSION >= 70600)

namespace fuzz {

#if FUZZ_76
using RelocationInfo = OptixRelocationInfo;
#else
using RelocationInfo = OptixAccelRelocationInfo;
#endif

class World;

struct Call {
    Call(const char* name, int weight, void (*run)(World&));
    const char* name;
    int weight; // how often, compared with others
    void (*run)(World&);
};
const std::vector<Call>& calls();

// For each function: the number of refused and of successful calls.
std::map<std::string, std::array<uint64_t, 2>>& counts();

// Handles of one kind.
template <class Handle>
struct Handles {
    std::vector<Handle> live, dead;
    void died(Handle handle) {
        std::erase(live, handle);
        dead.push_back(handle);
    }
};

struct Structure {
    OptixTraversableHandle handle;
    OptixDeviceContext context;
    unsigned buildFlags, operation;
    std::vector<OptixBuildInput> inputs; // point into memory of this sequence
    CUdeviceptr output;
    size_t outputSize;
};

// Opacity micromaps in memory of this sequence.
struct MicromapArray {
    CUdeviceptr address;
    size_t size;
};

class World {
public:
    World(uint64_t seed, bool print);
    ~World(); // destroys live objects and waits
    World(const World&) = delete;

    // ---- Random numbers ----
    uint32_t below(uint32_t count) { return count == 0 ? 0 : uint32_t(random_() % count); }
    // Chances up to 6 and from 90 percent decide about mistakes: calm sequences make a twelfth of
    // them.
    bool chance(unsigned percent) {
        if (isCalm_ && (percent <= 6 || percent >= 90))
            return below(1200) < (percent <= 6 ? percent : 1100 + percent);
        return below(100) < percent;
    }
    uint32_t any32(); // small, all ones, powers of two and their neighbours, anything
    size_t anySize(); // the same, with 64 bits
    float anyFloat(); // ordinary, 0, huge, tiny, infinite, no number
    float coordinate() { return float(int(below(2001)) - 1000) * 0.01f; }
    template <class T>
    T oneOf(std::initializer_list<T> values) {
        return values.begin()[below(uint32_t(values.size()))];
    }
    // An enumerator: mostly one of the list, sometimes none.
    template <class T>
    T enumerator(std::initializer_list<T> values) {
        return chance(94) ? oneOf(values) : T(any32());
    }
    // Mostly `right`, sometimes a number that is off by little or much.
    uint32_t nearly(uint32_t right) {
        return chance(93) ? right : chance(50) ? right - 1 : any32();
    }
    size_t nearlySize(size_t right) {
        return chance(93) ? right : chance(50) ? right - 1 : anySize();
    }
    void garble(void* bytes, size_t size); // changes a few bytes

    // ---- Handles: mostly live, sometimes dead, null or garbage ----
    template <class Handle>
    Handle pick(Handles<Handle>& handles) {
        if (!handles.live.empty() && chance(93))
            return handles.live[below(uint32_t(handles.live.size()))];
        if (!handles.dead.empty() && chance(60))
            return handles.dead[below(uint32_t(handles.dead.size()))];
        return reinterpret_cast<Handle>(uintptr_t(chance(50) ? 0 : anySize()));
    }
    // Mostly the same one: related objects must come from one context.
    OptixDeviceContext context() {
        return !contexts.live.empty() && chance(92) ? contexts.live[0] : pick(contexts);
    }
    CUstream stream() { return chance(97) ? CUstream(nullptr) : CUstream(anySize()); }
    OptixTraversableHandle traversable();

    // ---- Memory of this sequence, filled with zeros, then an unmapped page ----
    CUdeviceptr memory(size_t size, size_t alignment = 128);
    // An address for `size` bytes: mostly memory(size), sometimes too short, misaligned, null,
    // unmapped or unreadable.
    CUdeviceptr address(size_t size, size_t alignment = 128);
    template <class T>
    CUdeviceptr upload(const std::vector<T>& values) {
        CUdeviceptr at = memory(values.size() * sizeof(T));
        if (!values.empty())
            std::memcpy(reinterpret_cast<void*>(at), values.data(), values.size() * sizeof(T));
        return at;
    }
    // Host memory that lives as long as the sequence.
    template <class T>
    T* keep(const std::vector<T>& values) {
        return reinterpret_cast<T*>(upload(values));
    }
    // Bytes of memory mapped so far; calls that need much check it first.
    size_t mapped() const { return mapped_; }

    // ---- Results ----
    // Every call ends here. Stops the process if the result is not a code of the API.
    void done(const char* function, OptixResult result, const std::string& arguments = {});
    void note(const std::string& text) const; // part of the transcript
    bool prints() const { return print_; }
    void wait(); // until all queued work is done

    Handles<OptixDeviceContext> contexts;
    Handles<OptixModule> modules;
    Handles<OptixModule> builtins; // of optixBuiltinISModuleGet
    Handles<OptixProgramGroup> groups;
    std::map<OptixProgramGroup, OptixProgramGroupKind> kindOf;
    Handles<OptixPipeline> pipelines;
    Handles<OptixDenoiser> denoisers;
    std::vector<Structure> structures;
    std::vector<OptixTraversableHandle> transforms;
    std::vector<MicromapArray> arrays;
    unsigned logLines = 0;

private:
    struct Mapping {
        void* base;
        size_t size;
    };
    std::mt19937_64 random_;
    bool print_;
    bool isCalm_;
    std::vector<Mapping> mappings_;
    size_t mapped_ = 0;
};

// The compiled programs of programs.cu.
const std::string& programs();

} // namespace fuzz
