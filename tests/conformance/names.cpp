// SPDX-License-Identifier: Apache-2.0
// See names.h.
#include "names.h"

#include "driver.h"

#include <cstdio>
#include <fstream>

namespace conformance {

std::set<std::string> readNames(const std::string& file) {
    std::set<std::string> names;
    std::ifstream in(file);
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

} // namespace conformance
