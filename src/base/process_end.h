// SPDX-License-Identifier: Apache-2.0
// Work still running when the process ends is abandoned: no call waits for it, and the memory it
// uses is never freed. Exit handlers run in reverse order of registration, and other libraries'
// handlers wait for queued work (runtimes unload their modules). So our handler must run before
// theirs.
#pragma once

#include "base/error.h"

namespace sunstone {

// Thrown instead of waiting for work that is abandoned because the process ends.
class ProcessEnds : public Error {
public:
    ProcessEnds() : Error(Code::kCudaError, "the process ends before queued work is done") {}
};

// Registers our exit handler. Call it at the first use of an object of a library that has
// registered an exit handler. Cheap to call again.
void watchProcessEnd();

// Whether exit has been called, or main has returned.
bool processEnds();

} // namespace sunstone
