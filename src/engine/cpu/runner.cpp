// SPDX-License-Identifier: Apache-2.0
#include "engine/cpu/runner.h"

#include "base/error.h"
#include "devlib/flags.h"

#include <csetjmp>
#include <cstddef>
#include <cstring>

namespace sunstone::engine::cpu {

using devlib::RayState;
using devlib::ThreadState;

void Runner::prepare(RayState& state, ThreadState& thread, uint64_t stack,
                     uint64_t stackLimit) const {
    std::memset(static_cast<void*>(&state), 0, offsetof(RayState, hit));
    state.hit.transformCount = 0;
    state.hit.sbtGasIndex = 0;
    state.launch = &launch_;
    state.thread = &thread;
    thread.root = &state;
    thread.stackLimit = stackLimit;
    if (stack > stackBudget_)
        thread.stackLimit = std::max(stackLimit, stack - stackBudget_);
}

// No object with a destructor lives here: exceptions of device programs leave through longjmp.
void Runner::run(const Tile& tile) {
    ThreadState thread{};
    FaultFrame frame;
    thread.exceptionFrame = &frame;
    RayState state;
    // Not the address of a variable: sanitizers keep those elsewhere.
    prepare(state, thread, reinterpret_cast<uint64_t>(__builtin_frame_address(0)),
            stackLimitOfThread());
    volatile uint32_t next = 0;
    volatile bool ending = false; // an exception program may raise exceptions itself
    const int reason = setjmp(frame.jump);
    if (reason != 0) {
        leaveDeviceCode();
        if (reason == kJumpFault) {
            noteFault(frame, thread);
        } else if (!ending) {
            ending = true;
            endIndex(state, frame, frame);
        }
        ending = false;
        next = next + 1;
    }
    enterDeviceCode(frame);
    for (uint32_t i = next; i < tile.count(); ++i) {
        next = i;
        tile.place(i, thread.index);
        runEntry(state);
    }
    leaveDeviceCode();
}

std::string Runner::finish(bool validation) const {
    if (fatal_.any())
        fail(Code::kLaunchFailure, fatal_.text());
    if (validation && raised_.any())
        fail(Code::kLaunchFailure, raised_.text());
    return unseen_.any() ? unseen_.text() : std::string();
}

void Runner::endIndex(RayState& state, const FaultFrame& place, FaultFrame& faults) {
    const int32_t code = state.thread->exceptionCode;
    const bool overflow = code == devlib::kExceptionStackOverflow &&
                          !(launch_.exceptionFlags & devlib::kFlagStackOverflow);
    if (code == devlib::kExceptionTrap || code == devlib::kExceptionAccess || overflow) {
        fatal_.add(*state.thread, launch_, place.instruction);
        return;
    }
    if (code < 0)
        raised_.add(*state.thread, launch_, place.instruction);
    if (!exception_) {
        unseen_.add(*state.thread, launch_, place.instruction);
        return;
    }
    state.sbtData =
        reinterpret_cast<const void*>(launch_.sbt.exceptionRecord + sizeof(devlib::SbtHeader));
    state.depth = 0;
    enterDeviceCode(faults);
    exception_(&state);
    leaveDeviceCode();
}

} // namespace sunstone::engine::cpu
