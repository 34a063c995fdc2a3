// SPDX-License-Identifier: Apache-2.0
// Reports of the memory checker: text and JSON lines, one for each place in the code; leaks at the
// end of the process.
#pragma once

#include "check/memory_check.h"

namespace sunstone::check {

void report(Fault fault, const devlib::CheckedAccess& access, const Scene& scene);

} // namespace sunstone::check
