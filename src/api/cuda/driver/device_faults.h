// SPDX-License-Identifier: Apache-2.0
// Faults of queued work. A kernel, a copy or a set may meet memory that was freed after it was
// queued; the context keeps the error, as with a GPU, and work queued after it does not run.
#pragma once

#include "api/cuda/driver/shell.h"
#include "base/faults.h"

namespace sunstone::api::cuda {

// The error for a fault of a kernel.
CUresult faultResult(const FaultFrame& fault);

// " (use after free: ...)" with the allocation, if the fault's address lies in freed memory.
std::string freedRemark(const FaultFrame& fault);

// Throws the Failure for a fault of `what`.
[[noreturn]] void refuseFault(const char* what, const FaultFrame& fault);

// Runs a body that accesses memory, owns no objects and holds no locks. Throws Failure if the
// processor faults.
template <class Body>
void accessMemory(const char* what, const Body& body) {
    FaultFrame frame;
    if (!runFaultable(frame, body))
        refuseFault(what, frame);
}

// Runs queued work of a context. A Failure becomes the context's error, and after one nothing runs.
void runInContext(const std::weak_ptr<cpu::Context>& context, const std::function<void()>& work);

} // namespace sunstone::api::cuda
