// SPDX-License-Identifier: Apache-2.0
// Reports of the memory checker as text and JSON lines, one per place in the code; leaks are
// reported at the end of the process.
#pragma once

#include "check/memory_check.h"

namespace sunstone::check {

void report(Fault fault, const devlib::CheckedAccess& access, const Scene& scene);

} // namespace sunstone::check
