// SPDX-License-Identifier: Apache-2.0
// Lists of names of forms and texture cases: gaps, and deviations with the accepted difference.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

namespace conformance {

// One name a line; lines that begin with # are comments. "": no names.
std::set<std::string> readNames(const std::string& file);
// A name of the list with a trailing * matches all names with that prefix.
bool isNamed(const std::set<std::string>& names, const std::string& name);

// Differences from the recording: a line "name<tab>count<tab>digest", with a digest of the indices
// and values of differing results.
struct Deviation {
    unsigned count = 0;
    unsigned digest = 0;
    bool operator==(const Deviation&) const = default;
};
using Deviations = std::map<std::string, Deviation>;
Deviations readDeviations(const std::string& file);
// As written in the list.
std::string lineOf(const std::string& name, const Deviation& deviation);

// Ends the process if a selection is stale: `only` is in none of `names`, or an entry of a list
// matches none of them.
void checkSelection(const std::vector<std::string>& names, const std::string& only,
                    const std::set<std::string>& gaps = {}, const Deviations& deviations = {});

} // namespace conformance
