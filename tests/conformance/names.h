// SPDX-License-Identifier: Apache-2.0
// Lists of names of forms and texture cases: gaps and deviations.
#pragma once

#include <set>
#include <string>

namespace conformance {

// One name a line; lines that begin with # are comments. No file: no names.
std::set<std::string> readNames(const std::string& file);
// A name of the list that ends in * stands for all that begin so.
bool isNamed(const std::set<std::string>& names, const std::string& name);

} // namespace conformance
