// SPDX-License-Identifier: Apache-2.0
// The message of a fuzzer that crashes or that a sanitizer ends: how to repeat the failure.
#pragma once

#include <signal.h>

#include <initializer_list>

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
extern "C" void __sanitizer_set_death_callback(void (*)());
#define FUZZ_HAS_SANITIZER 1
#endif
#endif

namespace fuzz {

inline void (*lastWords)() = nullptr;

inline void onSignal(int number) {
    lastWords();
    signal(number, SIG_DFL);
    raise(number);
}

// The handlers of crash signals and of the signal `more` call `tell`.
inline void setLastWords(void (*tell)(), int more = SIGABRT) {
    lastWords = tell;
#ifdef FUZZ_HAS_SANITIZER
    __sanitizer_set_death_callback(tell);
#else
    for (int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL})
        signal(number, onSignal);
#endif
    for (int number : {SIGABRT, more})
        signal(number, onSignal);
}

} // namespace fuzz
