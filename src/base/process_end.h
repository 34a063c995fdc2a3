// SPDX-License-Identifier: Apache-2.0
// When a process ends, what it still computes is given up: nobody waits for it any more, and what
// it uses stays. Handlers of exit run in the opposite order of their registration, and handlers of
// others wait for queued work (runtimes unload their modules), so the end must be known before
// theirs run.
#pragma once

#include "base/error.h"

namespace sunstone {

// Thrown instead of waiting for what will not be finished any more.
class ProcessEnds : public Error {
public:
    ProcessEnds() : Error(Code::kCudaError, "the process ends before queued work is done") {}
};

// Call it when something of a library that has registered such a handler is first used. Costs
// little.
void watchProcessEnd();

// Whether exit has been called, or main has returned.
bool processEnds();

} // namespace sunstone
