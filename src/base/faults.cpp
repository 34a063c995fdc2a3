// SPDX-License-Identifier: Apache-2.0
// See faults.h: the signal handlers and the signal stacks of threads.
#include "base/faults.h"

#include "base/error.h"
#include "base/threads/worker_object.h"
#include "base/x86_operand.h"

#include <csignal>
#include <mutex>
#include <pthread.h>
#include <sys/mman.h>
#include <ucontext.h>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SUNSTONE_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) ||                         \
    __has_feature(memory_sanitizer)
#define SUNSTONE_SANITIZED 1
#endif
#endif

namespace sunstone {

bool handlesFaults() {
#ifdef SUNSTONE_SANITIZED
    return false;
#else
    return true;
#endif
}

namespace {

// The frame of each thread. Not thread_local: the first access may allocate, which a signal handler
// must not do. The TLS model that never allocates prevents loading the library with dlopen.
pthread_key_t frameKey;
bool isInstalled = false;

constexpr int kSignals[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL};
struct sigaction previous[NSIG];

#if defined(__x86_64__)
// For accesses that are misaligned or whose address is not canonical the kernel reports address 0
// and this code.
void findHiddenAddress(const ucontext_t& context, FaultFrame& frame) {
    const auto& all = context.uc_mcontext.gregs;
    const X86Registers registers = {
        uint64_t(all[REG_RAX]), uint64_t(all[REG_RCX]), uint64_t(all[REG_RDX]),
        uint64_t(all[REG_RBX]), uint64_t(all[REG_RSP]), uint64_t(all[REG_RBP]),
        uint64_t(all[REG_RSI]), uint64_t(all[REG_RDI]), uint64_t(all[REG_R8]),
        uint64_t(all[REG_R9]),  uint64_t(all[REG_R10]), uint64_t(all[REG_R11]),
        uint64_t(all[REG_R12]), uint64_t(all[REG_R13]), uint64_t(all[REG_R14]),
        uint64_t(all[REG_R15])};
    uint64_t address = 0;
    frame.kind = FaultFrame::kUnknownAddress;
    if (!accessedAddress(static_cast<const uint8_t*>(frame.instruction), registers, address))
        return;
    frame.address = reinterpret_cast<const void*>(address);
    constexpr uint64_t kVector = 16; // the least alignment that any instruction needs
    if (!isCanonical(address))
        frame.kind = FaultFrame::kAccess;
    else if (address % kVector != 0)
        frame.kind = FaultFrame::kMisaligned;
}
#endif

// The address of an access, and the kind of fault, from what the kernel passes to the handler.
void describeMachine(const siginfo_t& info, const ucontext_t& context, FaultFrame& frame) {
    frame.address = info.si_addr;
    frame.kind = FaultFrame::kAccess;
#if defined(__x86_64__)
    frame.instruction = reinterpret_cast<const void*>(context.uc_mcontext.gregs[REG_RIP]);
    frame.stackPointer = reinterpret_cast<const void*>(context.uc_mcontext.gregs[REG_RSP]);
    if (info.si_code == SI_KERNEL && (frame.signal == SIGSEGV || frame.signal == SIGBUS))
        findHiddenAddress(context, frame);
#elif defined(__aarch64__)
    frame.instruction = reinterpret_cast<const void*>(context.uc_mcontext.pc);
    frame.stackPointer = reinterpret_cast<const void*>(context.uc_mcontext.sp);
#endif
    if (frame.signal == SIGBUS && info.si_code == BUS_ADRALN)
        frame.kind = FaultFrame::kMisaligned;
    // An address this close to the stack pointer is mapped, unless the stack has overflowed.
    constexpr uint64_t kNear = 64 << 10;
    const auto distance = reinterpret_cast<uint64_t>(frame.address) -
                          reinterpret_cast<uint64_t>(frame.stackPointer) + kNear;
    if (frame.signal == SIGSEGV && frame.stackPointer && distance < 2 * kNear)
        frame.kind = FaultFrame::kStackOverflow;
}

// Passes the signal to the handler that was installed before ours.
void passOn(int signal, siginfo_t* info, void* context) {
    const struct sigaction& old = previous[signal];
    if (old.sa_flags & SA_SIGINFO) {
        old.sa_sigaction(signal, info, context);
        return;
    }
    const bool isSent = info->si_code <= 0; // by kill and the like
    if (old.sa_handler == SIG_IGN && isSent)
        return;
    if (old.sa_handler != SIG_DFL && old.sa_handler != SIG_IGN) {
        old.sa_handler(signal);
        return;
    }
    // The default action ends the process when the instruction repeats or the signal is raised
    // again.
    struct sigaction standard {};
    standard.sa_handler = SIG_DFL;
    sigaction(signal, &standard, nullptr);
    if (isSent)
        raise(signal);
}

void onSignal(int signal, siginfo_t* info, void* context) {
    auto* frame = static_cast<FaultFrame*>(pthread_getspecific(frameKey));
    if (!frame || info->si_code <= 0) {
        passOn(signal, info, context);
        return;
    }
    pthread_setspecific(frameKey, nullptr);
    const auto& machine = *static_cast<const ucontext_t*>(context);
    frame->signal = signal;
    frame->cause = nullptr;
    describeMachine(*info, machine, *frame);
    pthread_sigmask(SIG_SETMASK, &machine.uc_sigmask, nullptr); // the jump does not restore the
                                                                // mask
    std::longjmp(frame->jump, kJumpFault);
}

// The signal stack of a thread, unless the application has set one.
class HandlerStack {
public:
    HandlerStack() {
        stack_t present{};
        if (sigaltstack(nullptr, &present) != 0 || !(present.ss_flags & SS_DISABLE))
            return;
        void* memory =
            mmap(nullptr, kSize, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (memory == MAP_FAILED)
            return; // faults are still handled, except stack overflows
        memory_ = memory;
        stack_t ours{};
        ours.ss_sp = memory;
        ours.ss_size = kSize;
        sigaltstack(&ours, nullptr);
    }
    ~HandlerStack() {
        if (!memory_)
            return;
        stack_t present{};
        if (sigaltstack(nullptr, &present) == 0 && present.ss_sp == memory_) {
            stack_t none{};
            none.ss_flags = SS_DISABLE;
            sigaltstack(&none, nullptr);
        }
        munmap(memory_, kSize);
    }
    HandlerStack(const HandlerStack&) = delete;
    HandlerStack& operator=(const HandlerStack&) = delete;

private:
    static constexpr size_t kSize = 64 << 10; // the application's handlers run on it as well
    void* memory_ = nullptr;
};

void install() {
    if (pthread_key_create(&frameKey, nullptr) != 0)
        return; // faults end the process, as without our handlers
    isInstalled = true;
    if (!handlesFaults())
        return;
    struct sigaction action {};
    action.sa_sigaction = onSignal;
    action.sa_flags = SA_SIGINFO | SA_ONSTACK;
    sigemptyset(&action.sa_mask);
    for (const int signal : kSignals) {
        // Store the old handler before ours can be called.
        sigaction(signal, nullptr, &previous[signal]);
        sigaction(signal, &action, nullptr);
    }
}

} // namespace

void prepareForFaults() {
    static std::once_flag once;
    std::call_once(once, install);
    if (!handlesFaults())
        return;
    workerObject<HandlerStack>();
}

void enterDeviceCode(FaultFrame& frame) {
    if (isInstalled)
        pthread_setspecific(frameKey, &frame);
}

void leaveDeviceCode() {
    if (isInstalled)
        pthread_setspecific(frameKey, nullptr);
}

void endDeviceCode(const char* cause, const void* address, const void* instruction) {
    auto* frame = isInstalled ? static_cast<FaultFrame*>(pthread_getspecific(frameKey)) : nullptr;
    if (!frame)
        return;
    pthread_setspecific(frameKey, nullptr);
    frame->signal = 0;
    frame->cause = cause;
    frame->address = address;
    frame->instruction = instruction;
    std::longjmp(frame->jump, kJumpFault);
}

std::string describeFault(const FaultFrame& frame) {
    if (frame.cause)
        return frame.address ? message(frame.cause, frame.address) : frame.cause;
    switch (frame.signal) {
    case SIGFPE:
        return message("integer division fault at instruction ", frame.instruction);
    case SIGILL:
        return message("illegal instruction at ", frame.instruction);
    default:
        break;
    }
    switch (frame.kind) {
    case FaultFrame::kMisaligned:
        return message("misaligned memory access to address ", frame.address);
    case FaultFrame::kUnknownAddress:
        return message("invalid memory access by the instruction at ", frame.instruction,
                       ", to an address that no memory has, or that is misaligned");
    case FaultFrame::kStackOverflow:
        return message("stack overflow at address ", frame.address);
    default: {
        // The stack segment's fault for addresses that are not canonical is a bus error, too.
        const bool isBus =
            frame.signal == SIGBUS && isCanonical(reinterpret_cast<uint64_t>(frame.address));
        return message("invalid memory access ", isBus ? "(bus error) " : "", "to address ",
                       frame.address);
    }
    }
}

} // namespace sunstone
