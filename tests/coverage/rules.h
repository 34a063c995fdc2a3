// SPDX-License-Identifier: Apache-2.0
// tests/coverage/rules.tsv: the rules of the manuals about host functions and the test of each.
#pragma once

#include "evidence.h"

#include <functional>

namespace coverage {

// Reports functions without a rule, rows with unknown names, and missing tests.
void checkRules(const std::filesystem::path& root, const std::vector<Symbol>& symbols,
                const std::function<void(const std::string&)>& complain);

} // namespace coverage
