// SPDX-License-Identifier: Apache-2.0
// Functions that kernels and programs call, except arithmetic: printf, assertions, barriers and
// warp functions. The launcher provides a barrier and an exchange (devlib::BlockFunctions), in
// which the lanes of a mask meet and see one another's values; all warp functions are built on the
// exchange.
#include "compiler/runtime/runtime.h"

#include "base/config.h"
#include "base/error.h"
#include "base/log.h"
#include "base/threads.h"
#include "compiler/lockstep/warp_functions.h"
#include "compiler/runtime/device_data.h"
#include "devlib/abi.h"

#include <bit>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

namespace sunstone::compiler {

namespace {

using devlib::BlockFunctions;
using devlib::KernelThread;

const BlockFunctions* functionsOf(const KernelThread* thread) {
    return thread->block ? *static_cast<BlockFunctions* const*>(thread->block) : nullptr;
}

// ---- printf -----------------------------------------------------------------------------------
// The argument buffer holds each argument at its natural alignment: 4 bytes for int, 8 for
// double, pointers and 64-bit integers. Strings in it are addresses.
class ArgumentReader {
public:
    explicit ArgumentReader(const char* buffer) : buffer_(buffer) {}
    template <class T>
    T take() {
        T value{};
        if (!buffer_)
            return value;
        offset_ = (offset_ + sizeof(T) - 1) / sizeof(T) * sizeof(T);
        std::memcpy(&value, buffer_ + offset_, sizeof(T));
        offset_ += sizeof(T);
        return value;
    }

private:
    const char* buffer_;
    size_t offset_ = 0;
};

template <class... T>
void append(std::string& out, const std::string& format, T... values) {
    char local[256];
    const int length = std::snprintf(local, sizeof local, format.c_str(), values...);
    if (length < 0)
        return;
    if (size_t(length) < sizeof local) {
        out.append(local, size_t(length));
        return;
    }
    std::string large(size_t(length) + 1, '\0');
    std::snprintf(large.data(), large.size(), format.c_str(), values...);
    out.append(large.data(), size_t(length));
}

// Formats one conversion; `spec` has its flags, width and precision.
void convert(std::string& out, const std::string& spec, int longs, char conversion,
             ArgumentReader& arguments) {
    switch (conversion) {
    case 'd':
    case 'i':
        append(out, spec + "lld",
               longs > 0 ? arguments.take<long long>()
                         : static_cast<long long>(arguments.take<int>()));
        break;
    case 'u':
    case 'x':
    case 'X':
    case 'o':
        append(out, spec + "ll" + conversion,
               longs > 0 ? arguments.take<unsigned long long>()
                         : static_cast<unsigned long long>(arguments.take<unsigned>()));
        break;
    case 'c':
        append(out, spec + "c", arguments.take<int>());
        break;
    case 'p':
        append(out, spec + "p", arguments.take<void*>());
        break;
    case 's': {
        const char* text = arguments.take<const char*>();
        append(out, spec + "s", text ? text : "(null)");
        break;
    }
    default:
        append(out, spec + conversion, arguments.take<double>());
    }
}

int printFormatted(void*, const char* format, const char* buffer) {
    if (!format)
        return -1;
    std::string out;
    ArgumentReader arguments(buffer);
    int converted = 0;
    for (const char* p = format; *p; ++p) {
        if (*p != '%') {
            out += *p;
            continue;
        }
        if (p[1] == '%') {
            out += '%';
            ++p;
            continue;
        }
        const char* start = p++;
        std::string spec = "%";
        int longs = 0;
        for (; *p && std::strchr("-+ #0123456789.*hlLqjzt", *p); ++p) {
            if (*p == '*')
                spec += std::to_string(arguments.take<int>());
            else if (*p == 'l' || *p == 'q' || *p == 'j' || *p == 'z' || *p == 't')
                ++longs;
            else if (*p != 'h' && *p != 'L')
                spec += *p;
        }
        if (!*p || !std::strchr("diuxXocpsfFeEgGaA", *p)) { // not a conversion: printed unchanged
            out.append(start, size_t(p - start) + (*p ? 1 : 0));
            if (!*p)
                break;
            continue;
        }
        convert(out, spec, longs, *p, arguments);
        ++converted;
    }
    std::fwrite(out.data(), 1, out.size(), stdout);
    return converted;
}

// ---- end of a thread ---------------------------------------------------------------------------

void endThread(KernelThread* thread) {
    if (const BlockFunctions* functions = functionsOf(thread))
        functions->exitThread(thread);
}

void trapThread(KernelThread* thread) {
    log(LogLevel::kError, "compiler", "a kernel executed a trap instruction");
    if (const BlockFunctions* functions = functionsOf(thread))
        functions->fault(thread, devlib::kFaultTrap);
}

void endAssertion(KernelThread* thread) {
    if (const BlockFunctions* functions = functionsOf(thread))
        functions->fault(thread, devlib::kFaultAssertion);
}

void reportAssertion(void*, const char* condition, const char* file, uint32_t line,
                     const char* function, uint64_t) {
    std::fprintf(stderr, "%s:%u: %s: device assertion `%s' failed\n", file ? file : "?", line,
                 function ? function : "?", condition ? condition : "?");
}

void* allocate(void*, uint64_t size) {
    void* memory = std::malloc(size);
    static const bool isChecked = checks("memory");
    if (isChecked && memory)
        addDeviceBlock(memory, size);
    return memory;
}
void release(void*, void* memory) {
    static const bool isChecked = checks("memory");
    if (isChecked && memory && !removeDeviceBlock(memory)) {
        log(LogLevel::kError, "compiler",
            message("device code frees ", memory, ", which it has not allocated"));
        return;
    }
    std::free(memory);
}

// Called in place of a callable that a shader binding table record lacks.
uint64_t noCallable() {
    return 0;
}

uint64_t globalTimer() {
    return uint64_t(std::chrono::duration_cast<std::chrono::nanoseconds>(
                        std::chrono::system_clock::now().time_since_epoch())
                        .count());
}

// ---- barriers and warps -----------------------------------------------------------------------

uint32_t barrier(KernelThread* thread, uint32_t id, uint32_t threads, uint32_t reduction,
                 uint32_t value) {
    return functionsOf(thread)->barrier(thread, id, threads, reduction, value);
}

void arrive(KernelThread* thread, uint32_t id, uint32_t threads) {
    functionsOf(thread)->arrive(thread, id, threads);
}

// Follows every read by which a thread may wait for another. The launcher's threads do not preempt
// one another, so a thread that reads in a loop must yield now and then.
void spin(KernelThread* thread) {
    if (--thread->spins == 0)
        functionsOf(thread)->yield(thread);
}

uint32_t activeMask(KernelThread* thread) {
    return functionsOf(thread)->activeMask(thread);
}

Gathered exchange(KernelThread* thread, uint32_t mask, uint64_t value) {
    Gathered gathered{};
    gathered.present = functionsOf(thread)->exchange(thread, mask, value, gathered.values);
    gathered.values[thread->laneid] = value; // also if the launcher left it out
    return gathered;
}

uint32_t vote(KernelThread* thread, uint32_t mode, uint32_t mask, uint32_t predicate) {
    return answerVote(mode, exchange(thread, mask, predicate));
}

uint64_t shuffle(KernelThread* thread, uint32_t mode, uint32_t value, uint32_t distance,
                 uint32_t control, uint32_t mask) {
    return answerShuffle(mode, thread->laneid, distance, control, exchange(thread, mask, value));
}

uint64_t match(KernelThread* thread, uint32_t wantAll, uint32_t mask, uint64_t value) {
    return answerMatch(wantAll, value, exchange(thread, mask, value));
}

uint32_t reduce(KernelThread* thread, uint32_t op, uint32_t mask, uint32_t value) {
    return answerReduce(op, exchange(thread, mask, value));
}

// isspacep: whether the address is in the frames of the thread, which end at `end`.
uint32_t isInFrames(uint64_t address, uint64_t end) {
    return address >= reinterpret_cast<uint64_t>(__builtin_frame_address(0)) && address < end;
}
uint32_t isLocalOfKernel(KernelThread* thread, uint64_t address) {
    return isInFrames(address, functionsOf(thread)->stackEnd(thread));
}
uint32_t isLocalOfProgram(uint64_t address) {
    return isInFrames(address, stackOfThread().end);
}

template <class Function>
const void* addressOf(Function* function) {
    return reinterpret_cast<const void*>(function);
}

} // namespace

void addKernelSymbols(std::vector<RuntimeSymbol>& symbols) {
    const RuntimeSymbol own[] = {
        {"sunstone_vprintf", addressOf(printFormatted)},
        {"sunstone_assertfail", addressOf(reportAssertion)},
        {"sunstone_assertion", addressOf(endAssertion)},
        {"sunstone_malloc", addressOf(allocate)},
        {"sunstone_free", addressOf(release)},
        {"sunstone_no_callable", addressOf(noCallable)},
        {"sunstone_trap", addressOf(trapThread)},
        {"sunstone_exit", addressOf(endThread)},
        {"sunstone_globaltimer", addressOf(globalTimer)},
        {"sunstone_barrier", addressOf(barrier)},
        {"sunstone_arrive", addressOf(arrive)},
        {"sunstone_spin", addressOf(spin)},
        {"sunstone_activemask", addressOf(activeMask)},
        {"sunstone_vote", addressOf(vote)},
        {"sunstone_shuffle", addressOf(shuffle)},
        {"sunstone_match", addressOf(match)},
        {"sunstone_redux", addressOf(reduce)},
        {"sunstone_lockstep_answer", addressOf(answerLanes)},
        {"sunstone_is_local_of_kernel", addressOf(isLocalOfKernel)},
        {"sunstone_is_local_of_program", addressOf(isLocalOfProgram)},
    };
    symbols.insert(symbols.end(), std::begin(own), std::end(own));
}

} // namespace sunstone::compiler
