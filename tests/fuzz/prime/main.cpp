// SPDX-License-Identifier: Apache-2.0
// Fuzzes the OptiX Prime API: sequences of random calls with valid and invalid arguments. A
// sequence is determined by its number alone: `fuzz_prime --sequence NUMBER` repeats it.
//   fuzz_prime [--seconds N] [--start N] [--sequence N] [--calls N]
//
// The fuzzer meets a caller's obligations: memory that queued work may use lives as long as the
// sequence, and no thread changes it meanwhile. Bytes behind each buffer of hits must stay as they
// are.
#include "../last_words.h"
#include "../options.h"

#include "optix_prime/optix_prime.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cinttypes>
#include <cmath>
#include <cstring>
#include <map>
#include <random>

namespace {

constexpr size_t kBytes = 1 << 16; // of each buffer
constexpr size_t kGuard = 256;     // bytes behind it
constexpr uint8_t kGuardByte = 0xA7;
// Begin and length of ranges; the largest stride is 128 bytes.
constexpr uint64_t kMostElements = kBytes / 256;

uint64_t gSequence = 0;
const char* gCall = "";

struct World {
    std::mt19937_64 random;
    std::vector<RTPcontext> contexts;
    std::vector<RTPbufferdesc> descs;
    std::map<RTPbufferdesc, unsigned> formats;
    std::vector<RTPmodel> models;
    std::vector<RTPquery> queries;
    std::vector<std::vector<uint8_t>> buffers;

    explicit World(uint64_t sequence) : random(sequence) {
        for (int i = 0; i < 6; ++i) {
            buffers.emplace_back(kBytes + kGuard, kGuardByte);
            fill(i);
        }
    }
    uint64_t below(uint64_t n) { return random() % n; }
    bool chance(unsigned percent) { return below(100) < percent; }

    // Fills a buffer for use as vertices, rays, matrices, ...: numbers near zero, indices, odd
    // bits.
    void fill(int buffer) {
        uint8_t* const to = buffers[size_t(buffer)].data();
        const unsigned kind = unsigned(below(4));
        for (size_t i = 0; i + 4 <= kBytes; i += 4) {
            float number = float(int64_t(random() % 2001) - 1000) * 1e-3f;
            if (kind == 1 || (kind == 2 && chance(20))) {
                const auto index = int32_t(below(60)) - 2;
                std::memcpy(to + i, &index, 4);
                continue;
            }
            if (chance(1))
                number = std::array{NAN, INFINITY, -INFINITY, 1e38f, 1e-40f}[below(5)];
            std::memcpy(to + i, &number, 4);
        }
        if (kind == 3 && !models.empty())
            for (size_t i = 0; i < 64; ++i) {
                const RTPmodel model = pick(models);
                std::memcpy(to + i * sizeof(model), &model, sizeof(model));
            }
    }

    template <class T>
    T pick(const std::vector<T>& live) {
        if (live.empty() || chance(4)) {
            const uint64_t odd[] = {0, 1, ~uint64_t(0), random(), uint64_t(buffers[0].data())};
            return reinterpret_cast<T>(odd[below(5)]);
        }
        return live[below(live.size())];
    }
    // A buffer descriptor, mostly of one of these formats.
    RTPbufferdesc desc(unsigned first, unsigned last) {
        for (int i = 0; i < 40 && !descs.empty() && chance(98); ++i) {
            const RTPbufferdesc found = descs[below(descs.size())];
            if (formats[found] >= first && formats[found] <= last)
                return found;
        }
        return pick(descs);
    }
    unsigned number() {
        const unsigned odd[] = {0, 1, 2, 12, 16, 20, 48, 64, ~0u, 0x80000000u, unsigned(random())};
        return odd[below(std::size(odd))];
    }
    RTPbufferformat format() {
        const int all[] = {0x400, 0x401, 0x420, 0x421, 0x440, 0x441, 0x442, 0x460, 0x461,
                           0x462, 0x463, 0x464, 0x465, 0x480, 0x490, 0x491, 0,     0x499};
        return RTPbufferformat(all[below(std::size(all))]);
    }
};

// A place for a result, or null.
template <class T>
T* place(World& w, T& value) {
    return w.chance(97) ? &value : nullptr;
}

struct Call {
    const char* name;
    unsigned weight;
    RTPresult (*run)(World&);
};

RTPresult createContext(World& w) {
    RTPcontext context = nullptr;
    const RTPcontexttype types[] = {RTP_CONTEXT_TYPE_CPU, RTP_CONTEXT_TYPE_CPU,
                                    RTP_CONTEXT_TYPE_CUDA, RTPcontexttype(7)};
    const RTPresult result = rtpContextCreate(types[w.below(4)], place(w, context));
    if (context)
        w.contexts.push_back(context);
    return result;
}

RTPresult createDesc(World& w) {
    RTPbufferdesc desc = nullptr;
    auto& buffer = w.buffers[w.below(w.buffers.size())];
    uint8_t* address = buffer.data();
    if (w.chance(5)) {
        uint8_t* const odd[] = {nullptr, address + 1, reinterpret_cast<uint8_t*>(uintptr_t(64))};
        address = odd[w.below(3)];
    }
    const RTPbuffertype type =
        w.chance(90) ? RTP_BUFFER_TYPE_HOST : RTPbuffertype(0x200 + w.below(3));
    const RTPbufferformat format = w.format();
    const RTPresult result =
        rtpBufferDescCreate(w.pick(w.contexts), format, type, address, place(w, desc));
    if (!desc)
        return result;
    w.descs.push_back(desc);
    w.formats[desc] = format;
    const uint64_t most = kMostElements;
    const uint64_t begin = w.chance(60) ? 0 : w.below(most),
                   count = w.chance(50) ? 48 : w.below(most);
    rtpBufferDescSetRange(desc, begin, begin + count);
    return result;
}

// With ranges beyond the buffers queries would write to other memory.
RTPresult setRange(World& w) {
    const uint64_t most = kMostElements;
    if (w.chance(80)) {
        const uint64_t begin = w.below(most);
        return rtpBufferDescSetRange(w.pick(w.descs), begin,
                                     begin + (w.chance(80) ? 48 : w.below(most)));
    }
    return rtpBufferDescSetRange(w.pick(w.descs), 1 + w.below(most), 0);
}

RTPresult setStride(World& w) {
    const unsigned strides[] = {0, 12, 16, 20, 48, 64, 4, 13, 128};
    return rtpBufferDescSetStride(w.pick(w.descs), strides[w.below(std::size(strides))]);
}

template <class T>
RTPresult destroy(World& w, std::vector<T>& live, RTPresult (*function)(T)) {
    if (w.chance(85))
        return RTP_SUCCESS;
    const T handle = w.pick(live);
    const RTPresult result = function(handle);
    if (w.chance(80)) // else the dead handle is used again
        live.erase(std::remove(live.begin(), live.end(), handle), live.end());
    return result;
}

// New contents of a buffer that no work uses.
RTPresult refill(World& w) {
    for (const RTPquery query : w.queries)
        rtpQueryFinish(query);
    for (const RTPmodel model : w.models)
        rtpModelFinish(model);
    w.fill(int(w.below(w.buffers.size())));
    return w.chance(50) ? RTP_SUCCESS : RTP_ERROR_UNKNOWN;
}

const Call kCalls[] = {
    {"new contents", 2, refill},
    {"rtpContextCreate", 1, createContext},
    {"rtpContextSetCudaDeviceNumbers", 1,
     [](World& w) {
         const unsigned numbers[2] = {unsigned(w.below(2)), w.number()};
         return rtpContextSetCudaDeviceNumbers(w.pick(w.contexts), unsigned(w.below(3)),
                                               w.chance(90) ? numbers : nullptr);
     }},
    {"rtpContextSetCpuThreads", 1,
     [](World& w) { return rtpContextSetCpuThreads(w.pick(w.contexts), w.number()); }},
    {"rtpContextGetLastErrorString", 1,
     [](World& w) {
         const char* text = nullptr;
         const RTPresult result = rtpContextGetLastErrorString(w.pick(w.contexts), place(w, text));
         return text && std::strlen(text) > 100000 ? RTP_ERROR_UNKNOWN : result;
     }},
    {"rtpContextDestroy", 1, [](World& w) { return destroy(w, w.contexts, rtpContextDestroy); }},
    {"rtpBufferDescCreate", 12, createDesc},
    {"rtpBufferDescSetRange", 2, setRange},
    {"rtpBufferDescSetStride", 2, setStride},
    {"rtpBufferDescSetCudaDeviceNumber", 1,
     [](World& w) { return rtpBufferDescSetCudaDeviceNumber(w.pick(w.descs), w.number()); }},
    {"rtpBufferDescGetContext", 1,
     [](World& w) {
         RTPcontext context = nullptr;
         return rtpBufferDescGetContext(w.pick(w.descs), place(w, context));
     }},
    {"rtpBufferDescDestroy", 2, [](World& w) { return destroy(w, w.descs, rtpBufferDescDestroy); }},
    {"rtpModelCreate", 4,
     [](World& w) {
         RTPmodel model = nullptr;
         const RTPresult result = rtpModelCreate(w.pick(w.contexts), place(w, model));
         if (model)
             w.models.push_back(model);
         return result;
     }},
    {"rtpModelSetTriangles", 8,
     [](World& w) {
         return rtpModelSetTriangles(
             w.pick(w.models), w.chance(50) ? nullptr : w.desc(0x400, 0x401), w.desc(0x420, 0x421));
     }},
    {"rtpModelSetInstances", 4,
     [](World& w) {
         return rtpModelSetInstances(w.pick(w.models), w.desc(0x480, 0x480), w.desc(0x490, 0x491));
     }},
    {"rtpModelUpdate", 8,
     [](World& w) {
         const unsigned hints[] = {0, 0, 0x2001, 0x2001, 0x2002, 0x2003, 0x2004, 0x2005, 0x2008, 1};
         return rtpModelUpdate(w.pick(w.models), hints[w.below(std::size(hints))]);
     }},
    {"rtpModelFinish", 1, [](World& w) { return rtpModelFinish(w.pick(w.models)); }},
    {"rtpModelGetFinished", 1,
     [](World& w) {
         int finished = 0;
         return rtpModelGetFinished(w.pick(w.models), place(w, finished));
     }},
    {"rtpModelGetContext", 1,
     [](World& w) {
         RTPcontext context = nullptr;
         return rtpModelGetContext(w.pick(w.models), place(w, context));
     }},
    {"rtpModelCopy", 2, [](World& w) { return rtpModelCopy(w.pick(w.models), w.pick(w.models)); }},
    {"rtpModelSetBuilderParameter", 2,
     [](World& w) {
         const int64_t value = int64_t(w.below(3));
         const auto param = RTPbuilderparam(0x800 + w.below(3));
         return rtpModelSetBuilderParameter(w.pick(w.models), param, w.chance(50) ? 4 : 8,
                                            w.chance(95) ? &value : nullptr);
     }},
    {"rtpModelDestroy", 1, [](World& w) { return destroy(w, w.models, rtpModelDestroy); }},
    {"rtpQueryCreate", 4,
     [](World& w) {
         RTPquery query = nullptr;
         const RTPresult result =
             rtpQueryCreate(w.pick(w.models), RTPquerytype(0x1000 + w.below(w.chance(90) ? 2 : 4)),
                            place(w, query));
         if (query)
             w.queries.push_back(query);
         return result;
     }},
    {"rtpQuerySetRays", 8,
     [](World& w) { return rtpQuerySetRays(w.pick(w.queries), w.desc(0x440, 0x442)); }},
    {"rtpQuerySetHits", 8,
     [](World& w) { return rtpQuerySetHits(w.pick(w.queries), w.desc(0x460, 0x465)); }},
    {"rtpQueryExecute", 10,
     [](World& w) {
         const unsigned hints[] = {0, 0, 0x4001, 0x4001, 0x4002, 0x4003, 0x4004, 1};
         return rtpQueryExecute(w.pick(w.queries), hints[w.below(std::size(hints))]);
     }},
    {"rtpQueryFinish", 2, [](World& w) { return rtpQueryFinish(w.pick(w.queries)); }},
    {"rtpQueryGetFinished", 1,
     [](World& w) {
         int finished = 0;
         return rtpQueryGetFinished(w.pick(w.queries), place(w, finished));
     }},
    {"rtpQueryGetContext", 1,
     [](World& w) {
         RTPcontext context = nullptr;
         return rtpQueryGetContext(w.pick(w.queries), place(w, context));
     }},
    {"rtpQuerySetCudaStream", 1,
     [](World& w) {
         return rtpQuerySetCudaStream(w.pick(w.queries),
                                      reinterpret_cast<cudaStream_t>(uintptr_t(w.number())));
     }},
    {"rtpQueryDestroy", 1, [](World& w) { return destroy(w, w.queries, rtpQueryDestroy); }},
    {"rtpHostBufferLock", 1,
     [](World& w) {
         return rtpHostBufferLock(w.buffers[w.below(6)].data() + w.below(2) * 64,
                                  w.chance(80) ? w.below(kBytes) : ~size_t(0));
     }},
    {"rtpHostBufferUnlock", 1,
     [](World& w) { return rtpHostBufferUnlock(w.buffers[w.below(6)].data() + w.below(2) * 64); }},
};

std::map<std::string, std::array<unsigned long, 2>> gCounts;

void fail(const char* what) {
    std::fprintf(stderr, "%s after %s; repeat with --sequence %" PRIu64 "\n", what, gCall,
                 gSequence);
    std::_Exit(1);
}

void run(uint64_t sequence, uint64_t calls) {
    gSequence = sequence;
    World w(sequence);
    unsigned total = 0;
    for (const Call& call : kCalls)
        total += call.weight;
    createContext(w); // without contexts and buffers little succeeds
    for (int i = 0; i < 30; ++i)
        createDesc(w);
    for (uint64_t i = 0; i < calls; ++i) {
        uint64_t place = w.below(total);
        const Call* call = kCalls;
        for (; place >= call->weight; ++call)
            place -= call->weight;
        gCall = call->name;
        const RTPresult result = call->run(w);
        ++gCounts[call->name][result == RTP_SUCCESS];
    }
    gCall = "the end";
    for (const RTPcontext context : w.contexts)
        rtpContextDestroy(context);
    for (const auto& buffer : w.buffers) {
        rtpHostBufferUnlock(const_cast<uint8_t*>(buffer.data()));
        rtpHostBufferUnlock(const_cast<uint8_t*>(buffer.data()) + 64);
        if (std::any_of(buffer.begin() + kBytes, buffer.end(),
                        [](uint8_t byte) { return byte != kGuardByte; }))
            fail("bytes behind a buffer have changed");
    }
}

// Calls only functions that signal handlers may call.
void tell() {
    char text[256];
    const int length =
        std::snprintf(text, sizeof(text), "\nfailed in %s; repeat with --sequence %" PRIu64 "\n",
                      gCall, gSequence);
    if (write(2, text, size_t(length)) < 0)
        return;
}

} // namespace

int main(int argc, char** argv) {
    uint64_t duration = 10, start = 0, only = ~uint64_t(0), calls = 400;
    fuzz::readOptions(argc, argv, "fuzz_prime [--seconds N] [--start N] [--sequence N] [--calls N]",
                      {{"--seconds", &duration},
                       {"--start", &start},
                       {"--sequence", &only},
                       {"--calls", &calls}});
    fuzz::setLastWords(tell);
    if (only != ~uint64_t(0)) {
        run(only, calls);
        return 0;
    }
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + std::chrono::seconds(duration);
    uint64_t count = 0;
    for (; Clock::now() < end; ++count)
        run(start + count, calls);
    std::printf("%" PRIu64 " sequences from %" PRIu64 "\n", count, start);
    bool all = true;
    for (const Call& call : kCalls) {
        const auto& counts = gCounts[call.name];
        std::printf("%-34s %8lu failed %8lu succeeded\n", call.name, counts[0], counts[1]);
        // CUDA contexts need a driver.
        const bool cudaOnly = std::strstr(call.name, "Cuda") != nullptr;
        all &= counts[0] != 0 && (counts[1] != 0 || cudaOnly);
    }
    if (!all)
        std::fprintf(stderr, "a function never succeeded, or never failed\n");
    return all ? 0 : 1;
}
