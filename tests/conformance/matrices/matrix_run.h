// SPDX-License-Identifier: Apache-2.0
// Runs matrix cases on the device, and stores and compares their results. A recording has a small
// digest of each problem's results, which shows equality; with `whole`, for studies of a device's
// arithmetic, also the results.
#pragma once

#include "forms/run_forms.h"
#include "names.h"

#include <set>

namespace conformance {

// Both return the process's exit code and take the cases with `only` in their names.
int recordMatrices(const std::string& file, const std::string& only, bool whole);
int replayMatrices(const std::string& file, const std::set<std::string>& gaps,
                   const std::string& only);

} // namespace conformance
