// SPDX-License-Identifier: Apache-2.0
// Fuzzes the classic API: sequences of random calls on a scene that could be launched at first. The
// arguments of most functions are made of their types (arguments.h); functions.inc has all
// functions of the headers. A sequence is determined by its number: `fuzz_api6 --sequence NUMBER`
// repeats it.
//   fuzz_api6 [--seconds N] [--start N] [--sequence N] [--calls N]
//
// The caller's obligations are kept: memory is as large as sizes say, indices of triangles name
// vertices. RT_ERROR_UNKNOWN is an internal error and therefore a finding.
#include "../last_words.h"
#include "../options.h"
#include "calls.h"

#include <unistd.h>

#include <array>
#include <chrono>
#include <cinttypes>
#include <fstream>
#include <iterator>

namespace fuzz {
namespace {

uint64_t gSequence = 0;
const char* gCall = "";
std::map<std::string, std::array<unsigned long, 2>> gCounts;

} // namespace

void fail(const std::string& what) {
    std::fprintf(stderr, "%s after %s; repeat with --sequence %" PRIu64 "\n", what.c_str(), gCall,
                 gSequence);
    std::_Exit(1);
}

namespace {

// -----------------------------------------------------------------------------------

// Every failure has a text.
void checkResult(World& w, RTresult result) {
    if (result == RT_SUCCESS)
        return;
    const char* text = nullptr;
    rtContextGetErrorString(w.handle<RTcontext>(), result, &text);
    if (!text || !*text || std::strlen(text) > 100000)
        fail("no text of the failure");
    if (result == RT_ERROR_UNKNOWN)
        fail(std::string("an internal error: ") + text);
}

void run(uint64_t sequence, uint64_t count, const std::array<std::string, 2>& texts) {
    static const auto* const all = new std::vector<Call>(calls());
    static const unsigned total = [] {
        unsigned sum = 0;
        for (const Call& call : *all)
            sum += call.weight;
        return sum;
    }();
    gSequence = sequence;
    alarm(120);
    World w(sequence);
    w.texts[0] = &texts[0];
    w.texts[1] = &texts[1];
    gCall = "the first launch";
    createContext(w);
    for (uint64_t i = 0; i < count; ++i) {
        uint64_t place = w.below(total);
        const Call* call = all->data();
        for (; place >= call->weight; ++call)
            place -= call->weight;
        gCall = call->name;
        const RTresult result = call->run(w);
        checkResult(w, result);
        ++gCounts[call->name][result == RT_SUCCESS];
        gCall = "the end of a context";
        if (w.chance(1) && w.chance(30))
            destroyContext(w);
        gCall = "a second context";
        if (w.all<RTcontext>().size() < 2 && w.chance(1) && w.chance(30))
            createContext(w);
    }
    gCall = "the end";
    for (void* context : w.all<RTcontext>())
        rtContextDestroy(static_cast<RTcontext>(context));
    alarm(0);
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

std::string read(const char* path) {
    std::ifstream file(path);
    std::string text(std::istreambuf_iterator<char>(file), {});
    if (text.empty())
        fail(std::string("cannot read ") + path);
    return text;
}

int report(uint64_t sequences, uint64_t start) {
    std::fprintf(stderr, "%" PRIu64 " sequences from %" PRIu64 "\n", sequences, start);
    unsigned never = 0;
    for (const auto& [name, counts] : gCounts) {
        never += counts[1] == 0;
        std::fprintf(stderr, "%-50s %8lu failed %8lu succeeded\n", name.c_str(), counts[0],
                     counts[1]);
    }
    const auto& launches = gCounts["rtContextLaunch"];
    // On a busy machine few sequences run in the given time, and they reach fewer functions.
    constexpr uint64_t kEnough = 400;
    const bool reached = launches[0] && launches[1] && (never < 80 || sequences < kEnough);
    if (reached)
        return 0;
    std::fprintf(stderr, "launches or too many functions never succeeded, or never failed\n");
    return 1;
}

} // namespace
} // namespace fuzz

int main(int argc, char** argv) {
    uint64_t duration = 10, start = 0, only = ~uint64_t(0), calls = 1500;
    fuzz::readOptions(argc, argv, "fuzz_api6 [--seconds N] [--start N] [--sequence N] [--calls N]",
                      {{"--seconds", &duration},
                       {"--start", &start},
                       {"--sequence", &only},
                       {"--calls", &calls}});
    fuzz::setLastWords(fuzz::tell, SIGALRM);
    if (!std::freopen("/dev/null", "w", stdout)) // programs print
        return 2;
    const std::array<std::string, 2> texts = {fuzz::read(SUNSTONE_FUZZ_TEXT1),
                                              fuzz::read(SUNSTONE_FUZZ_TEXT2)};
    if (only != ~uint64_t(0)) {
        fuzz::run(only, calls, texts);
        return 0;
    }
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + std::chrono::seconds(duration);
    uint64_t count = 0;
    for (; Clock::now() < end; ++count)
        fuzz::run(start + count, calls, texts);
    return fuzz::report(count, start);
}
