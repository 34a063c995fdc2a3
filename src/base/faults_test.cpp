// SPDX-License-Identifier: Apache-2.0
// Which handler gets a fault: device code's frame its own, the application's handler all others.
#include "base/faults.h"

#include <gtest/gtest.h>

#include <csetjmp>
#include <csignal>
#include <thread>

namespace sunstone {
namespace {

sigjmp_buf gApplication;
volatile sig_atomic_t gSeen = 0;

void applicationHandler(int) {
    gSeen = gSeen + 1;
    siglongjmp(gApplication, 1);
}
void applicationCounts(int) {
    gSeen = gSeen + 1;
}

[[gnu::noinline]] void writeTo(uintptr_t address) {
    *reinterpret_cast<volatile int*>(address) = 1;
}

[[gnu::noinline]] int recurse(volatile char* from) {
    volatile char frame[512];
    frame[0] = *from;
    return frame[0] == 77 ? 0 : recurse(frame) + frame[0];
}

class Faults : public testing::Test {
protected:
    static void SetUpTestSuite() {
        std::signal(SIGSEGV, applicationHandler);
        std::signal(SIGFPE, applicationCounts);
        prepareForFaults();
    }
    void SetUp() override {
        if (!handlesFaults())
            GTEST_SKIP() << "a sanitizer reports faults";
        gSeen = 0;
    }
};

TEST_F(Faults, OfDeviceCodeGoToItsFrame) {
    for (volatile int round = 0; round < 3; round = round + 1) {
        FaultFrame frame;
        if (setjmp(frame.jump) == 0) {
            enterDeviceCode(frame);
            writeTo(0x1230);
            FAIL() << "no fault";
        }
        EXPECT_EQ(SIGSEGV, frame.signal);
        EXPECT_EQ(reinterpret_cast<void*>(0x1230), frame.address);
        EXPECT_NE(nullptr, frame.instruction);
        EXPECT_NE(std::string::npos, describeFault(frame).find("0x1230")) << describeFault(frame);
    }
    EXPECT_EQ(0, gSeen);
    sigset_t blocked;
    pthread_sigmask(SIG_BLOCK, nullptr, &blocked);
    EXPECT_FALSE(sigismember(&blocked, SIGSEGV));
}

TEST_F(Faults, OfTheApplicationGoToItsHandler) {
    if (sigsetjmp(gApplication, 1) == 0) {
        writeTo(0x1230);
        FAIL() << "no fault";
    }
    EXPECT_EQ(1, gSeen);
    FaultFrame frame; // a frame that was left gets no fault either
    if (setjmp(frame.jump) == 0) {
        enterDeviceCode(frame);
        leaveDeviceCode();
    }
    if (sigsetjmp(gApplication, 1) == 0)
        writeTo(0x1230);
    EXPECT_EQ(2, gSeen);
    EXPECT_EQ(0, frame.signal);
}

TEST_F(Faults, SentSignalsAreNotOurs) {
    FaultFrame frame;
    if (setjmp(frame.jump) == 0) {
        enterDeviceCode(frame);
        std::raise(SIGFPE);
        leaveDeviceCode();
    }
    EXPECT_EQ(0, frame.signal);
    EXPECT_EQ(1, gSeen);
}

TEST_F(Faults, AnOverflownStackIsAFault) {
    FaultFrame frame;
    std::thread([&frame] {
        prepareForFaults();
        if (setjmp(frame.jump) == 0) {
            enterDeviceCode(frame);
            volatile char start = 0;
            recurse(&start);
        }
    }).join();
    EXPECT_EQ(SIGSEGV, frame.signal);
    EXPECT_NE(std::string::npos, describeFault(frame).find("stack overflow at address"))
        << describeFault(frame);
}

// The application has no handler: the process ends by the default action.
TEST_F(Faults, TheDefaultEndsTheProcess) {
    EXPECT_EXIT(__builtin_trap(), testing::KilledBySignal(SIGILL), "");
    EXPECT_EXIT(std::raise(SIGBUS), testing::KilledBySignal(SIGBUS), "");
}

} // namespace
} // namespace sunstone
