// SPDX-License-Identifier: Apache-2.0
// Runs matrix cases on the device, and keeps and compares their results. A recording has a digest
// of each problem's results, which is little and says whether they are the same; with `whole`,
// which is for finding out how a device computes, the results too.
#pragma once

#include "names.h"
#include "run_forms.h"

#include <set>

namespace conformance {

// Both return the process's exit code and take the cases with `only` in their names.
int recordMatrices(const std::string& file, const std::string& only, bool whole);
int replayMatrices(const std::string& file, const std::set<std::string>& gaps,
                   const std::string& only);

} // namespace conformance
