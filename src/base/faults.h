// SPDX-License-Identifier: Apache-2.0
// Invalid accesses of device code end its launch, not the process.
//
// The first launch installs handlers for SIGSEGV, SIGBUS, SIGFPE and SIGILL. They act only on
// faults of a thread that is inside device code, between enterDeviceCode and leaveDeviceCode: the
// handler stores the fault in the thread's frame and the thread continues at the frame's jump
// target. All other signals go to the handlers installed before. Builds with sanitizers install no
// handlers, because sanitizers report invalid accesses in more detail.
#pragma once

#include <csetjmp>
#include <string>

namespace sunstone {

// The jump value of a fault; our other jumps carry other values.
constexpr int kJumpFault = 2;

// Receives a fault of device code; lives in the loop that calls the code.
struct FaultFrame {
    std::jmp_buf jump;             // set with setjmp; receives kJumpFault
    int signal = 0;                // the signal's number
    const void* address = nullptr; // the accessed address; for SIGFPE and SIGILL the instruction's
    const void* instruction = nullptr;
    const void* stackPointer = nullptr;
    enum Kind { kAccess, kMisaligned, kUnknownAddress, kStackOverflow };
    Kind kind = kAccess; // of SIGSEGV and SIGBUS
    // From endDeviceCode, which uses no signal; `signal` is 0.
    const char* cause = nullptr;
};

// Installs the handlers once, and gives the calling thread a signal stack, because device code may
// have overflowed the thread's own stack. Call it before enterDeviceCode.
void prepareForFaults();

// Between these two calls, faults of the calling thread go to the frame (one frame at a time, not
// nested). A fault and leaveDeviceCode both end this. Code in between must hold no locks and own no
// objects.
void enterDeviceCode(FaultFrame& frame);
void leaveDeviceCode();

// Runs a body that owns no objects and holds no locks. False if the processor faulted in it.
template <class Body>
bool runFaultable(FaultFrame& frame, const Body& body) {
    prepareForFaults();
    if (setjmp(frame.jump) == kJumpFault)
        return false;
    enterDeviceCode(frame);
    body();
    leaveDeviceCode();
    return true;
}

// For functions that device code calls: ends the calling thread's device code like a fault. `cause`
// is never freed; `address`, if not null, completes the message. Returns if no frame receives
// faults.
void endDeviceCode(const char* cause, const void* address, const void* instruction);

// One line with the kind of fault and the address.
std::string describeFault(const FaultFrame& frame);

// Whether this build handles faults of the processor.
bool handlesFaults();

} // namespace sunstone
