// SPDX-License-Identifier: Apache-2.0
// Exceptions on a GPU. Each thread is a launch index; the index ends after the exception program,
// if the pipeline has one. The launch's report passes the exception to the host.
#pragma once

#include "devlib/gpu/lane_memory.h"
#include "devlib/gpu/programs.h"

namespace sunstone::devlib::gpu {

SUNSTONE_INLINE LaunchReport& reportOf(RayState* state) {
    return blockOf(state->launch).report;
}

SUNSTONE_INLINE uint64_t placeOf(const RayState* state) {
    const uint32_t *index = state->thread->index, *size = state->launch->dimensions;
    return (uint64_t(index[2]) * size[1] + index[1]) * size[0] + index[0];
}

SUNSTONE_INLINE void note(uint64_t& word, uint64_t place, int32_t code) {
    __nvvm_atom_min_gen_ull(reinterpret_cast<unsigned long long*>(&word),
                            place << 32 | uint32_t(code));
}

SUNSTONE_INLINE void note(RayState* state, uint64_t& word, int32_t code) {
    note(word, placeOf(state), code);
}

[[noreturn]] SUNSTONE_INLINE void endThread() {
    if (sunstone_gpu_hasLaneMemory())
        sunstone_gpu_leaveLaneMemory(1);
    asm volatile("exit;");
    __builtin_unreachable();
}

// Ends the launch by ending the thread; the host finds the cause in the report. (A trap instruction
// would end the CUDA context.)
[[noreturn]] [[gnu::noinline]] static void endLaunch(LaunchReport& report, uint64_t place,
                                                     int32_t code) {
    note(report.fatal, place, code);
    endThread();
}

// Passes on no pointer to the state, which can therefore stay in registers.
[[noreturn]] SUNSTONE_INLINE void endLaunch(RayState* state, int32_t code) {
    endLaunch(reportOf(state), placeOf(state), code);
}

// Copies the end of a text, which contains the file name.
[[gnu::noinline]] static void keepText(char (&to)[LaunchSaying::kBytes], const char* text) {
    if (!text)
        return;
    uint32_t length = 0;
    while (text[length])
        ++length;
    if (length >= LaunchSaying::kBytes)
        text += length - (LaunchSaying::kBytes - 1);
    for (uint32_t i = 0; i + 1 < LaunchSaying::kBytes && text[i]; ++i)
        to[i] = text[i];
}

// Only the first thread of a launch with a message is reported.
[[gnu::noinline]] static void say(RayState* state, int32_t code, uint32_t line, const char* text,
                                  const char* file, const char* function) {
    LaunchSaying& saying = reportOf(state).saying;
    if (__nvvm_atom_cas_gen_ll(reinterpret_cast<long long*>(&saying.by), 0,
                               static_cast<long long>(placeOf(state) + 1)) != 0)
        return;
    saying.line = line;
    saying.code = code;
    keepText(saying.texts[0], text);
    keepText(saying.texts[1], file);
    keepText(saying.texts[2], function);
}

// Stores the values of the exception getters for the host.
[[gnu::noinline]] static void noteDetails(RayState* state, uint64_t* words) {
    const ExceptionInfo& info = state->thread->exception;
    const int32_t code = state->thread->exceptionCode;
    const auto put = [&](unsigned word, uint32_t value) {
        note(state, words[word], int32_t(value));
    };
    const auto putAddress = [&](unsigned word, uint64_t value) {
        put(word, uint32_t(value));
        put(word + 1, uint32_t(value >> 32));
    };
    put(kWordCode, uint32_t(code));
    putAddress(kWordLine, reinterpret_cast<uint64_t>(info.line));
    if (code == kExceptionInvalidRay) {
        for (unsigned i = 0; i < 9; ++i)
            put(i, __builtin_bit_cast(uint32_t, info.ray[i]));
        return;
    }
    putAddress(kWordTraversable, info.traversable);
    put(kWordSbtOffset, info.sbtOffset);
    put(kWordExpected, info.expectedWords);
    put(kWordExpected + 1, info.passedWords);
    put(kWordExpected + 2, info.callableIndex);
    putAddress(kWordName, reinterpret_cast<uint64_t>(info.callableName));
}

// Leaves the launch index. The exception program runs with the launch index's own state, so the
// transform list at the fault is copied there.
[[noreturn]] [[gnu::noinline]] static void leave(RayState* state, int32_t code) {
    ThreadState* const thread = state->thread;
    const LaunchState& launch = *state->launch;
    thread->exceptionCode = code;
    const bool overflow =
        code == kExceptionStackOverflow && !(sunstone_gpu_exceptionFlags & kFlagStackOverflow);
    if (code == kExceptionTrap || overflow)
        endLaunch(state, code);
    const bool again = thread->pad != 0; // raised by the exception program itself
    if (again)
        endThread();
    const bool debugging = sunstone_gpu_exceptionFlags & kFlagDebug;
    if (code < 0) {
        note(state, reportOf(state).raised, code);
        if (debugging)
            noteDetails(state, reportOf(state).raisedDetails);
    }
    if (!sunstone_gpu_hasException || launch.sbt.exceptionRecord == 0) {
        note(state, reportOf(state).unseen, code);
        if (debugging)
            noteDetails(state, reportOf(state).unseenDetails);
        endThread();
    }
    thread->pad = 1;
    RayState* const root = thread->root;
    if (root != state) {
        const uint32_t count = state->hit.transformCount;
        root->hit.transformCount = count;
        for (uint32_t i = 0; i < count && i < kMaxGraphDepth; ++i)
            root->hit.transforms[i] = state->hit.transforms[i];
        root->hit.sbtGasIndex = state->hit.sbtGasIndex;
    }
    root->sbtData = dataOf(launch.sbt.exceptionRecord);
    root->depth = 0;
    if (sunstone_gpu_exception(
            root, groupOf(launch, launch.sbt.exceptionRecord, kGroupException)) == kNoProgram)
        endLaunch(state, kFatalExceptionRecord);
    endThread();
}

extern "C" void sunstone_gpu_throwException(RayState* state, int32_t code, uint32_t count,
                                            const uint32_t* details) {
    ThreadState* const thread = state->thread;
    if (code == kExceptionTrap && details) // the text of its place
        say(state, code, 0, reinterpret_cast<const char*>(details), nullptr, nullptr);
    for (uint32_t i = 0; i < 8; ++i)
        thread->exceptionDetails[i] = i < count ? details[i] : 0;
    thread->exception = {};
    thread->exception.line = thread->line;
    constexpr int32_t kUserCodes = 1 << 30;
    if (code != kExceptionTrap && uint32_t(code) >= uint32_t(kUserCodes)) {
        if (sunstone_gpu_exceptionFlags & kFlagDebug)
            code = kExceptionInvalidArgument0;
        else
            code &= kUserCodes - 1; // never taken for a code of the run-time
    }
    leave(state, code);
}

[[noreturn]] SUNSTONE_INLINE void raise(RayState* state, int32_t code,
                                        const ExceptionInfo* info = nullptr) {
    ThreadState* const thread = state->thread;
    for (uint32_t& detail : thread->exceptionDetails)
        detail = 0;
    thread->exception = info ? *info : ExceptionInfo{};
    leave(state, code);
}

// Called by stack checks in programs.
extern "C" [[gnu::noinline]] void sunstone_gpu_raise(RayState* state, int32_t code,
                                                     const ExceptionInfo* info) {
    raise(state, code, info);
}

extern "C" void sunstone_gpu_checkPayload(RayState* state, uint32_t type) {
    if (state->payloadType != type)
        raise(state, kExceptionPayloadType);
}

} // namespace sunstone::devlib::gpu
