// SPDX-License-Identifier: Apache-2.0
// Arguments of random calls of the classic API, made of their types: handles that live, sometimes
// dead ones or odd bits, numbers near limits, names, memory of the world.
#pragma once

#include "optix.h"
#include "optix_cuda_interop.h"
#include "optix_gl_interop.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <random>
#include <string>
#include <type_traits>
#include <typeindex>
#include <vector>

namespace fuzz {

constexpr size_t kScratch = 1 << 16; // bytes of each piece of memory that calls get
constexpr size_t kMostBytes = 4096;  // that sizes of memory name

inline constexpr const char* kNames[] = {"result",
                                         "step",
                                         "ray_type",
                                         "flags",
                                         "mark",
                                         "height",
                                         "top_object",
                                         "scoped",
                                         "some_float3",
                                         "some_matrix",
                                         "some_user",
                                         "ids",
                                         "volume",
                                         "one_id",
                                         "element",
                                         "chosen",
                                         "ray_time",
                                         "materials",
                                         "by_id",
                                         "bound",
                                         "list",
                                         "texture_id",
                                         "picture",
                                         "inner::nested",
                                         "Trbvh",
                                         "Bvh",
                                         "NoAccel",
                                         "refit",
                                         "motion_steps",
                                         "chunk_size",
                                         "vertex_buffer_name",
                                         "DLDenoiser",
                                         "TonemapperSimple",
                                         "input_buffer",
                                         "exposure",
                                         "maxmem",
                                         "site",
                                         "mpi:",
                                         "",
                                         "0bad",
                                         "a b",
                                         "x"};
inline constexpr const char* kPrograms[] = {
    "write_values",  "write_scoped",   "write_other",  "read_ids",      "read_outside",
    "throw_user",    "note_exception", "print_index",  "shoot",         "shoot_at",
    "visit_chosen",  "missed",         "hit_mark",     "hit_world",     "hit_triangle",
    "hit_tag",       "attribute_tag",  "count_any",    "ignore_any",    "terminate_any",
    "square_bounds", "square_hit",     "two_hits",     "call_programs", "multiply",
    "add_scoped",    "scale",          "sample",       "shoot_far",     "hit_again",
    "any_random",    "bound_any",      "bound_motion", "intersect_all", "visit_many",
    "trace_value",   "nothing"};

struct World {
    std::mt19937_64 random;
    std::map<std::type_index, std::vector<void*>> live;
    std::vector<std::vector<uint8_t>> memory;
    std::vector<void*> slots;           // results of the present call
    std::vector<std::type_index> kinds; // of slots
    // For each context, buffers that no call changes: indices below 3, and zeros.
    std::map<RTcontext, RTbuffer> indices, zeros;
    const std::string* texts[2] = {}; // PTX
    bool smallCounts = false;         // for the present call

    explicit World(uint64_t sequence) : random(sequence) {
        slots.reserve(16);
        for (int i = 0; i < 4; ++i) {
            memory.emplace_back(kScratch);
            fill(memory.back().data(), kScratch);
        }
    }

    uint64_t below(uint64_t n) { return random() % n; }
    bool chance(unsigned percent) { return below(100) < percent; }
    template <class T, size_t n>
    T anyOf(const T (&items)[n]) {
        return items[below(n)];
    }

    // Small numbers, ids, odd bits.
    void fill(void* to, size_t bytes) {
        const bool whole = chance(40);
        for (size_t i = 0; i + 4 <= bytes; i += 4) {
            const auto number = int32_t(below(40)) - 4;
            const float part =
                chance(1) ? anyOf({NAN, INFINITY, 1e38f, -1e-40f}) : 0.25f * float(number);
            std::memcpy(static_cast<uint8_t*>(to) + i, whole ? (const void*)&number : &part, 4);
        }
    }

    template <class T>
    std::vector<void*>& all() {
        return live[typeid(T)];
    }
    template <class T>
    T handle() {
        const std::vector<void*>& objects = all<T>();
        if (objects.empty() || chance(3)) {
            if (chance(50)) // an object of another class
                for (const auto& [kind, others] : live)
                    if (!others.empty() && chance(30))
                        return static_cast<T>(others[below(others.size())]);
            const uint64_t odd[] = {0, 1, ~uint64_t(0), random(), uint64_t(memory[0].data())};
            return reinterpret_cast<T>(anyOf(odd));
        }
        return static_cast<T>(objects[below(objects.size())]);
    }
    void note(std::type_index kind, void* object) {
        std::vector<void*>& objects = live[kind];
        for (void* each : objects)
            if (each == object)
                return;
        if (objects.size() < 24)
            objects.push_back(object);
        else
            objects[below(objects.size())] = object;
    }
    const char* name() {
        if (chance(3))
            return nullptr;
        return chance(85) ? anyOf(kNames) : anyOf(kPrograms);
    }
    void* scratch() { return chance(2) ? nullptr : memory[below(memory.size())].data(); }
};

template <class T>
struct IsHandle : std::false_type {};
#define FUZZ_HANDLE(name)                                                                          \
    template <>                                                                                    \
    struct IsHandle<name> : std::true_type {};
FUZZ_HANDLE(RTacceleration)
FUZZ_HANDLE(RTbuffer)
FUZZ_HANDLE(RTcontext)
FUZZ_HANDLE(RTgeometry)
FUZZ_HANDLE(RTgeometrytriangles)
FUZZ_HANDLE(RTgeometryinstance)
FUZZ_HANDLE(RTgeometrygroup)
FUZZ_HANDLE(RTgroup)
FUZZ_HANDLE(RTmaterial)
FUZZ_HANDLE(RTprogram)
FUZZ_HANDLE(RTselector)
FUZZ_HANDLE(RTtexturesampler)
FUZZ_HANDLE(RTtransform)
FUZZ_HANDLE(RTvariable)
FUZZ_HANDLE(RTpostprocessingstage)
FUZZ_HANDLE(RTcommandlist)
FUZZ_HANDLE(RTremotedevice)
#undef FUZZ_HANDLE

inline int64_t wholeNumber(World& w) {
    if (w.chance(75))
        return int64_t(w.below(5));
    if (w.smallCounts)
        return int64_t(w.below(64));
    return w.anyOf<int64_t>({-1, 7, 8, 12, 16, 31, 32, 255, 256, 1000, 0x7fffffff, 0x80000000ll,
                             0xffffffffll, int64_t(w.random())});
}

// The first values of all enumerations, flags, and others.
inline unsigned enumerator(World& w) {
    const unsigned begins[] = {0,     1,     0x100, 0x111,      0x119,      0x11d,
                               0x120, 0x12c, 0x200, 0x209,      0x212,      0x3eb,
                               0x3fa, 0x400, 0x500, 0x7fffffff, 0x10000000, 0x04000000};
    return w.chance(50) ? unsigned(w.below(5)) : w.anyOf(begins) + unsigned(w.below(6));
}

inline int noTimeout() {
    return 0;
}
inline void usage(int, const char* tag, const char* text, void*) {
    if (std::strlen(tag) + std::strlen(text) > (1u << 24))
        std::abort();
}

template <class T>
T argument(World& w) {
    using Target = std::remove_const_t<std::remove_pointer_t<T>>;
    if constexpr (IsHandle<T>::value) {
        return w.handle<T>();
    } else if constexpr (std::is_same_v<T, const char*>) {
        return w.name();
    } else if constexpr (std::is_same_v<T, RTtimeoutcallback>) {
        return w.chance(50) ? noTimeout : nullptr;
    } else if constexpr (std::is_same_v<T, RTusagereportcallback>) {
        return w.chance(80) ? usage : nullptr;
    } else if constexpr (std::is_pointer_v<T> && IsHandle<Target>::value) {
        if (w.chance(2))
            return nullptr;
        w.slots.push_back(nullptr);
        w.kinds.push_back(typeid(Target));
        return reinterpret_cast<T>(&w.slots.back());
    } else if constexpr (std::is_pointer_v<T> && std::is_pointer_v<Target>) {
        static thread_local void* places[64];
        for (void*& place : places)
            place = const_cast<char*>(w.anyOf(kNames));
        return w.chance(2) ? nullptr : (T)places;
    } else if constexpr (std::is_pointer_v<T>) {
        return static_cast<T>(w.scratch());
    } else if constexpr (std::is_floating_point_v<T>) {
        return T(w.chance(80) ? float(w.below(9)) * 0.25f
                              : w.anyOf({NAN, INFINITY, -1.0f, 1e30f, 1e-40f, -0.0f}));
    } else if constexpr (std::is_enum_v<T>) {
        return T(enumerator(w));
    } else {
        static_assert(std::is_integral_v<T>);
        return T(wholeNumber(w));
    }
}

// Such functions take the number of elements as a separate argument.
template <class T>
constexpr bool kIsMemory =
    std::is_pointer_v<T> && !IsHandle<T>::value && !std::is_same_v<T, const char*> &&
    !IsHandle<std::remove_pointer_t<T>>::value;

} // namespace fuzz
