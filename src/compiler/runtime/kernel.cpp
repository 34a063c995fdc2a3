// SPDX-License-Identifier: Apache-2.0
// Functions that kernels and programs call, except arithmetic: printf, assertions, barriers and
// warp functions. The launcher provides a barrier and an exchange (devlib::BlockFunctions), in
// which the lanes of a mask meet and see one another's values; all warp functions are built on the
// exchange.
#include "compiler/runtime/runtime.h"

#include "base/config.h"
#include "base/error.h"
#include "base/faults.h"
#include "base/log.h"
#include "base/threads/threads.h"
#include "base/threads/worker_object.h"
#include "compiler/lockstep/warp_functions.h"
#include "compiler/runtime/device_data.h"
#include "devlib/abi.h"

#include <bit>
#include <chrono>
#include <cstdint>
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

// Buffers of a printf call. They belong to the CPU thread, because a fault at a read of device
// memory ends the call without running destructors (base/faults.h).
struct Printer {
    std::string out, spec;
};

Printer& printer() {
    constexpr size_t kMostKept = 64 << 10;
    Printer& own = workerObject<Printer>();
    if (own.out.capacity() > kMostKept)
        std::string().swap(own.out);
    own.out.clear();
    return own;
}

template <class... T>
void append(std::string& out, const char* format, T... values) {
    char local[256];
    const int length = std::snprintf(local, sizeof local, format, values...);
    if (length < 0)
        return;
    if (size_t(length) < sizeof local) {
        out.append(local, size_t(length));
        return;
    }
    const size_t before = out.size();
    out.resize(before + size_t(length) + 1);
    std::snprintf(out.data() + before, size_t(length) + 1, format, values...);
    out.resize(before + size_t(length));
}

// The value of a 32-bit argument with -longs modifiers "h".
template <class Half, class Quarter, class T>
long long narrow(int longs, T value) {
    return longs == 0 ? static_cast<long long>(value) : longs == -1 ? Half(value) : Quarter(value);
}

// Formats one conversion; the specification has its flags, width and precision.
void convert(Printer& to, int longs, char conversion, ArgumentReader& arguments) {
    const auto add = [&](const char* type, auto value) {
        to.spec += type;
        append(to.out, to.spec.c_str(), value);
    };
    const char plain[] = {conversion, '\0'}, wide[] = {'l', 'l', conversion, '\0'};
    switch (conversion) {
    case 'd':
    case 'i':
        return add("lld", longs > 0 ? arguments.take<long long>()
                                    : narrow<short, signed char>(longs, arguments.take<int>()));
    case 'u':
    case 'x':
    case 'X':
    case 'o':
        return add(
            wide, longs > 0 ? arguments.take<unsigned long long>()
                            : static_cast<unsigned long long>(narrow<unsigned short, unsigned char>(
                                  longs, arguments.take<unsigned>())));
    case 'c':
        return add(plain, arguments.take<int>());
    case 'p':
        return add(plain, arguments.take<void*>());
    case 's': {
        const char* text = arguments.take<const char*>();
        return add(plain, text ? text : "(null)");
    }
    default:
        add(plain, arguments.take<double>());
    }
}

// Reads the flags, width and precision of a conversion into `spec` and returns where they end.
// longs: the number of modifiers that widen the argument to 64 bits; below zero, of modifiers that
// narrow it.
const char* readSpecification(const char* at, std::string& spec, int& longs,
                              ArgumentReader& arguments) {
    spec = "%";
    for (; *at && std::strchr("-+ #0123456789.*hlLqjzt", *at); ++at) {
        if (*at == '*') {
            const int value = arguments.take<int>();
            spec += std::to_string(value);
        } else if (std::strchr("lqjzt", *at)) {
            ++longs;
        } else if (*at == 'h') {
            --longs;
        } else if (*at != 'L') {
            spec += *at;
        }
    }
    return at;
}

int printFormatted(void*, const char* format, const char* buffer) {
    if (!format)
        return -1;
    Printer& to = printer();
    ArgumentReader arguments(buffer);
    int converted = 0;
    for (const char* p = format; *p; ++p) {
        if (*p != '%') {
            to.out += *p;
            continue;
        }
        if (p[1] == '%') {
            to.out += '%';
            ++p;
            continue;
        }
        const char* start = p;
        int longs = 0;
        p = readSpecification(p + 1, to.spec, longs, arguments);
        if (!*p || !std::strchr("diuxXocpsfFeEgGaA", *p)) { // not a conversion: printed unchanged
            to.out.append(start, size_t(p - start) + (*p ? 1 : 0));
            if (!*p)
                break;
            continue;
        }
        convert(to, longs, *p, arguments);
        ++converted;
    }
    std::fwrite(to.out.data(), 1, to.out.size(), stdout);
    return converted;
}

// ---- end of a thread ---------------------------------------------------------------------------

void endThread(KernelThread* thread) {
    if (const BlockFunctions* functions = functionsOf(thread))
        functions->exitThread(thread);
}

void trapThread(KernelThread* thread) {
    endDeviceCode("executed a trap", nullptr,
                  static_cast<const char*>(__builtin_return_address(0)) - 1);
    if (const BlockFunctions* functions = functionsOf(thread))
        functions->fault(thread, devlib::kFaultTrap);
}

void endAssertion(KernelThread* thread) {
    if (const BlockFunctions* functions = functionsOf(thread))
        functions->fault(thread, devlib::kFaultAssertion);
}

void printAssertion(const char* condition, const char* file, uint32_t line, const char* function,
                    const std::string& place) {
    std::fprintf(stderr, "%s:%u: %s: %sAssertion `%s` failed.\n", file ? file : "?", line,
                 function ? function : "?", place.c_str(), condition ? condition : "?");
}

// The line has the form of the CUDA programming guide, which tools look for.
void reportKernelAssertion(const KernelThread* thread, const char* condition, const char* file,
                           uint32_t line, const char* function, uint64_t) {
    const auto triple = [](const uint32_t(&v)[3]) {
        return "[" + std::to_string(v[0]) + "," + std::to_string(v[1]) + "," +
               std::to_string(v[2]) + "]";
    };
    printAssertion(condition, file, line, function,
                   "block: " + triple(thread->ctaid) + ", thread: " + triple(thread->tid) + " ");
}
void reportAssertion(void*, const char* condition, const char* file, uint32_t line,
                     const char* function, uint64_t) {
    printAssertion(condition, file, line, function, "");
}

// ---- the heap ----------------------------------------------------------------------------------
// In front of each block. It tells a block from other addresses that device code may free.
struct alignas(16) BlockMark {
    uint64_t word;
};
static_assert(sizeof(BlockMark) == 16);

constexpr uint64_t kBlockMark = 0x9E3779B97F4A7C15u;

uint64_t markOf(const void* block) {
    return reinterpret_cast<uint64_t>(block) ^ kBlockMark;
}

void* allocate(void*, uint64_t size) {
    if (size > PTRDIFF_MAX - sizeof(BlockMark))
        return nullptr;
    void* const memory = std::malloc(sizeof(BlockMark) + size);
    if (!memory)
        return nullptr;
    auto* const mark = static_cast<BlockMark*>(memory);
    void* const block = mark + 1;
    mark->word = markOf(block);
    static const bool isChecked = checks("memory");
    if (isChecked)
        addDeviceBlock(block, size);
    return block;
}

// Removes the mark, so that a second call for the block finds none. The address may be invalid, so
// the sanitizer must not check the read.
__attribute__((no_sanitize("address"))) bool takeMark(void* block) {
    if (reinterpret_cast<uint64_t>(block) % alignof(BlockMark) != 0)
        return false;
    uint64_t expected = markOf(block);
    uint64_t& word = static_cast<BlockMark*>(block)[-1].word;
    return __atomic_load_n(&word, __ATOMIC_RELAXED) == expected &&
           __atomic_compare_exchange_n(&word, &expected, 0, false, __ATOMIC_RELAXED,
                                       __ATOMIC_RELAXED);
}

void release(void*, void* block) {
    if (!block)
        return;
    static const bool isChecked = checks("memory");
    const bool isBlock = (!isChecked || removeDeviceBlock(block)) && takeMark(block);
    if (!isBlock) {
        constexpr const char* kCause = "device code frees an address that it has not allocated, ";
        log(LogLevel::kError, "compiler", message(kCause, block));
        const auto* const next = static_cast<const char*>(__builtin_return_address(0));
        endDeviceCode(kCause, block, next - 1);
        return;
    }
    std::free(static_cast<BlockMark*>(block) - 1);
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
    return functionsOf(thread)->activeMask(thread, __builtin_return_address(0));
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
        {"sunstone_kernel_assertfail", addressOf(reportKernelAssertion)},
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
        {"sunstone_lockstep_meet", addressOf(meetLanes)},
        {"sunstone_lockstep_keep", addressOf(keepShared)},
        {"sunstone_lockstep_take", addressOf(takeShared)},
        {"sunstone_is_local_of_kernel", addressOf(isLocalOfKernel)},
        {"sunstone_is_local_of_program", addressOf(isLocalOfProgram)},
    };
    symbols.insert(symbols.end(), std::begin(own), std::end(own));
}

} // namespace sunstone::compiler
