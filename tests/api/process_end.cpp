// SPDX-License-Identifier: Apache-2.0
#include "process_end.h"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <execinfo.h>
#include <unistd.h>

namespace tests::api {
namespace {

bool mayLose = false;

const char* runningTest(const char*& suite) {
    const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
    suite = test ? test->test_suite_name() : "(no";
    return test ? test->name() : "test)";
}

// Calls only async-signal-safe functions. tellFaults makes the first call of backtrace(), because
// the first call allocates.
void tell(const char* what, int signal) {
    const char* suite = nullptr;
    const char* name = runningTest(suite);
    for (const char* text : {what, suite, ".", name, ": ", sigabbrev_np(signal), "\n"})
        if (write(STDERR_FILENO, text, std::strlen(text)) < 0)
            break;
    void* calls[64];
    backtrace_symbols_fd(calls, backtrace(calls, 64), STDERR_FILENO);
}

void onFault(int signal) {
    tell("\n[ CRASHED  ] ", signal);
    raise(signal); // the default by now
}

void onAlarm(int signal) {
    tell("\n[ HUNG     ] ", signal);
    _exit(kTestHangs);
}

// The clock of each test.
class Limit : public testing::EmptyTestEventListener {
public:
    explicit Limit(unsigned seconds) : seconds_(seconds) {}
    void OnTestStart(const testing::TestInfo&) override { alarm(seconds_); }
    void OnTestEnd(const testing::TestInfo&) override { alarm(0); }

private:
    unsigned seconds_;
};

class Watch : public testing::EmptyTestEventListener {
public:
    explicit Watch(bool (*isLost)()) : isLost_(isLost) {}
    void OnTestEnd(const testing::TestInfo& test) override {
        if (!isLost_())
            return;
        const bool isMeant = mayLose && test.result()->Passed();
        const char *suite = test.test_suite_name(), *name = test.name();
        if (isMeant) // as gtest writes it
            std::printf("[       OK ] %s.%s (0 ms)\n", suite, name);
        else
            std::printf("[ LOST     ] %s.%s: the CUDA context\n", suite, name);
        std::fflush(nullptr);
        _exit(kContextLost); // destructors would access memory of the context
    }

private:
    bool (*isLost_)();
};

} // namespace

void tellFaults() {
    void* calls[1];
    backtrace(calls, 1);
    struct sigaction action{};
    action.sa_handler = onFault;
    action.sa_flags = SA_RESETHAND | SA_NODEFER;
    for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT})
        sigaction(signal, &action, nullptr);
}

void limitTests() {
    const char* text = std::getenv("SUNSTONE_TEST_LIMIT");
    const int seconds = text ? std::atoi(text) : 0;
    if (seconds <= 0)
        return;
    struct sigaction action{};
    action.sa_handler = onAlarm;
    sigaction(SIGALRM, &action, nullptr);
    testing::UnitTest::GetInstance()->listeners().Append(new Limit(unsigned(seconds)));
}

void mayLoseContext() {
    mayLose = true;
}

void endWithContext(bool (*isLost)()) {
    testing::UnitTest::GetInstance()->listeners().Append(new Watch(isLost));
}

} // namespace tests::api
