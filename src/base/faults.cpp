// SPDX-License-Identifier: Apache-2.0
// See faults.h: the signal handlers and the signal stacks of threads.
#include "base/faults.h"

#include "base/error.h"

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

const void* instructionOf(const ucontext_t& context) {
#if defined(__x86_64__)
    return reinterpret_cast<const void*>(context.uc_mcontext.gregs[REG_RIP]);
#elif defined(__aarch64__)
    return reinterpret_cast<const void*>(context.uc_mcontext.pc);
#else
    (void)context;
    return nullptr;
#endif
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
    frame->address = info->si_addr;
    frame->instruction = instructionOf(machine);
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
    thread_local HandlerStack stack;
    (void)stack;
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
        return message(frame.cause, frame.address);
    switch (frame.signal) {
    case SIGFPE:
        return message("integer division fault at instruction ", frame.instruction);
    case SIGILL:
        return message("illegal instruction at ", frame.instruction);
    case SIGBUS:
        return message("invalid memory access (bus error) to address ", frame.address);
    default:
        return message("invalid memory access to address ", frame.address);
    }
}

} // namespace sunstone
