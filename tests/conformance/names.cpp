// SPDX-License-Identifier: Apache-2.0
// See names.h.
#include "names.h"

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

bool isNamed(const std::set<std::string>& names, const std::string& name) {
    for (const std::string& listed : names)
        if (listed.ends_with('*') ? name.starts_with(listed.substr(0, listed.size() - 1))
                                  : name == listed)
            return true;
    return false;
}

} // namespace conformance
