// SPDX-License-Identifier: Apache-2.0
// Fuzzes the host API: sequences of random calls with valid and invalid arguments. A sequence is
// determined by its number alone: `fuzz_api --sequence NUMBER` repeats a failure (or fuzz_api76,
// the same with OptiX 7.6: each has its own sequences).
//   --seconds N    runs sequences for this long (20)
//   --start N      number of the first sequence (1); with --seconds, sequences count up from it
//   --sequence N   runs this sequence alone, and prints its calls
//   --calls N      calls in a sequence (60)
// It finds crashes, sanitizer reports, undefined result codes, and calls that do not return within
// a minute. Read world.h for how calls are written.
#include "last_words.h"
#include "options.h"
#include "world.h"

#include "optix_function_table_definition.h"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <thread>

namespace {

std::atomic<uint64_t> gSequence{0};
std::atomic<uint64_t> gCalls{0};
std::atomic<const char*> gCall{"none"};

void tellWhere() {
    char text[200];
    int size = std::snprintf(text, sizeof(text), "\nfuzz_api: in %s; repeat with --sequence %llu\n",
                             gCall.load(), static_cast<unsigned long long>(gSequence.load()));
    if (write(STDERR_FILENO, text, size_t(size)) < 0)
        _exit(3);
}

// Ends the process if a call takes longer than a minute.
void watch() {
    for (uint64_t seen = 0;;) {
        std::this_thread::sleep_for(std::chrono::seconds(60));
        uint64_t now = gCalls;
        if (now == seen) {
            std::fprintf(stderr, "a call does not return\n");
            tellWhere();
            std::_Exit(4);
        }
        seen = now;
    }
}

void runSequence(uint64_t number, unsigned count, bool print) {
    gSequence = number;
    if (print)
        std::printf("sequence %llu\n", static_cast<unsigned long long>(number));
    int total = 0;
    for (const fuzz::Call& call : fuzz::calls())
        total += call.weight;
    fuzz::World world(number * 0x9E3779B97F4A7C15ull + 1, print);
    for (unsigned i = 0; i < count; ++i) {
        int at = int(world.below(uint32_t(total)));
        for (const fuzz::Call& call : fuzz::calls()) {
            at -= call.weight;
            bool isFirst = call.name == std::string("optixDeviceContextCreate");
            if (i == 0 ? !isFirst : at >= 0) // no call works without a context
                continue;
            gCall = call.name;
            ++gCalls;
            if (print) {
                std::printf("%u: %s\n", i, call.name);
                std::fflush(stdout);
            }
            call.run(world);
            break;
        }
    }
    gCall = "the end of the sequence";
    ++gCalls;
}

} // namespace

int main(int argc, char** argv) {
    uint64_t seconds = 20, start = 1, sequence = 0, count = 60;
    fuzz::readOptions(argc, argv, "fuzz_api [--seconds N] [--start N] [--sequence N] [--calls N]",
                      {{"--seconds", &seconds},
                       {"--start", &start},
                       {"--sequence", &sequence},
                       {"--calls", &count}});
    fuzz::setLastWords(tellWhere);
    // A private disk cache, removed at the end.
    char folder[] = "/tmp/sunstone-fuzz-XXXXXX";
    if (!mkdtemp(folder) || setenv("OPTIX_CACHE_PATH", folder, 1) != 0) {
        std::fprintf(stderr, "cannot make a folder\n");
        return 1;
    }
    struct Cleaner {
        const char* folder;
        ~Cleaner() {
            std::error_code ignored;
            std::filesystem::remove_all(folder, ignored);
        }
    } cleaner{folder};
    if (optixInit() != OPTIX_SUCCESS) {
        std::fprintf(stderr, "cannot load the library\n");
        return 1;
    }
    std::thread(watch).detach();
    if (sequence != 0) {
        runSequence(sequence, unsigned(count), true);
        return 0;
    }
    auto end = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
    uint64_t ran = 0;
    for (uint64_t number = start; std::chrono::steady_clock::now() < end; ++number, ++ran)
        runSequence(number, unsigned(count), false);
    std::printf("%-45s %10s %10s\n", "function", "success", "refused");
    for (const auto& [name, count] : fuzz::counts())
        std::printf("%-45s %10llu %10llu\n", name.c_str(),
                    static_cast<unsigned long long>(count[1]),
                    static_cast<unsigned long long>(count[0]));
    std::printf("%llu sequences, %llu calls\n", static_cast<unsigned long long>(ran),
                static_cast<unsigned long long>(gCalls.load()));
    return 0;
}
