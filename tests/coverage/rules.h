// SPDX-License-Identifier: Apache-2.0
// tests/coverage/rules.tsv: the rules of the manuals about host functions and the test of each.
#pragma once

#include "evidence.h"

#include <functional>

namespace coverage {

// Complains about functions without a rule, rows about other names, and tests that are not there.
void checkRules(const std::filesystem::path& root, const std::vector<Symbol>& symbols,
                const std::function<void(const std::string&)>& complain);

} // namespace coverage
