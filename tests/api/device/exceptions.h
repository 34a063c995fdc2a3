// SPDX-License-Identifier: Apache-2.0
// Shared by exceptions.cu and its test.
#pragma once

enum ExceptionKind : unsigned {
    kNone,
    kFromRaygen,
    kFromHit,
    kFromAnyHit,
    kFromMiss,
    kFromCallable,
    kKinds
};

struct ExceptionResult {
    unsigned reached; // 1: the program started, 2: it ended normally
    unsigned value;
    int code;         // -77 where no exception program ran
    unsigned details[3];
    unsigned record;
};

struct ExceptionParams {
    ExceptionResult* results;
    unsigned long long handle;
};
