// SPDX-License-Identifier: Apache-2.0
// See names.h.
#include "names.h"

#include "driver.h"

#include <algorithm>
#include <cstdio>
#include <fstream>

namespace conformance {

std::set<std::string> readNames(const std::string& file) {
    std::set<std::string> names;
    if (file.empty())
        return names;
    std::ifstream in(file);
    if (!in)
        quit(2, "cannot read " + file);
    for (std::string line; std::getline(in, line);)
        if (!line.empty() && line[0] != '#')
            names.insert(line);
    return names;
}

Deviations readDeviations(const std::string& file) {
    Deviations deviations;
    for (const std::string& line : readNames(file)) {
        const size_t tab = line.find('\t');
        Deviation deviation;
        char rest = 0;
        if (tab == std::string::npos || std::sscanf(line.c_str() + tab, "%u %x%c", &deviation.count,
                                                    &deviation.digest, &rest) != 2)
            quit(1, file + " has a line without count and digest: " + line);
        deviations[line.substr(0, tab)] = deviation;
    }
    return deviations;
}

std::string lineOf(const std::string& name, const Deviation& deviation) {
    char text[40];
    std::snprintf(text, sizeof text, "\t%u\t%08x", deviation.count, deviation.digest);
    return name + text;
}

bool isNamed(const std::set<std::string>& names, const std::string& name) {
    for (const std::string& listed : names)
        if (listed.ends_with('*') ? name.starts_with(listed.substr(0, listed.size() - 1))
                                  : name == listed)
            return true;
    return false;
}

void checkSelection(const std::vector<std::string>& names, const std::string& only,
                    const std::set<std::string>& gaps, const Deviations& deviations) {
    const auto some = [&](auto&& fits) { return std::any_of(names.begin(), names.end(), fits); };
    if (!some([&](const std::string& name) { return name.find(only) != std::string::npos; }))
        quit(2, "--only " + only + ": no name has this text");
    for (const std::string& gap : gaps)
        if (!some([&](const std::string& name) { return isNamed({gap}, name); }))
            quit(2, "the list of gaps names what does not exist: " + gap);
    for (const auto& [listed, deviation] : deviations)
        if (!some([&, &listed = listed](const std::string& name) { return name == listed; }))
            quit(2, "the list of deviations names what does not exist: " + listed);
}

} // namespace conformance
