// SPDX-License-Identifier: Apache-2.0
// Invalid accesses of device code end its launch, not the process.
//
// The first launch installs handlers for SIGSEGV, SIGBUS, SIGFPE and SIGILL. They act only on
// faults of a thread that is inside device code, which it says with enterDeviceCode: such a fault
// is stored in the frame, and the thread goes on at its jump target. Everything else goes to the
// handlers that were there before. Sanitizers report invalid accesses themselves, and better: in
// builds with them nothing is installed.
#pragma once

#include <csetjmp>
#include <string>

namespace sunstone {

// Jumps of our own carry other values than this one.
constexpr int kJumpFault = 2;

// Where a fault of device code goes; lives in the loop that calls the code.
struct FaultFrame {
    std::jmp_buf jump;             // set with setjmp; receives kJumpFault
    int signal = 0;                // what happened
    const void* address = nullptr; // accessed; of the instruction for SIGFPE and SIGILL
    const void* instruction = nullptr;
};

// Installs the handlers once, and gives the calling thread a stack for them: device code may have
// overflowed its own. Call it before enterDeviceCode.
void prepareForFaults();

// Between these two, faults of the calling thread belong to the frame (one at a time, not nested).
// A fault and leaveDeviceCode both end it. Code in between must hold no locks and own nothing.
void enterDeviceCode(FaultFrame& frame);
void leaveDeviceCode();

// One line: what happened and the address.
std::string describeFault(const FaultFrame& frame);

// Whether this build handles faults.
bool handlesFaults();

} // namespace sunstone
