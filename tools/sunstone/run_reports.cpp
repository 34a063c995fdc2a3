// SPDX-License-Identifier: Apache-2.0
// Prints the reports of a checked run, as text and as JSON.
#include "commands.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace sunstone::tool {

bool summarize(const std::string& lines, const RunOptions& options) {
    using nlohmann::json;
    json accesses = json::array(), leaks = json::array();
    bool started = false;
    uint64_t times = 0, leakedBytes = 0;
    std::istringstream in(lines);
    for (std::string line; std::getline(in, line);) {
        // A killed process may leave half a line.
        json entry = json::parse(line, nullptr, false);
        if (!entry.is_object())
            continue;
        const std::string event = entry.value("event", "");
        entry.erase("event");
        if (event == "access") {
            accesses.push_back(std::move(entry));
        } else if (event == "leak") {
            leakedBytes += entry.value("bytes", uint64_t(0));
            leaks.push_back(std::move(entry));
        } else if (event == "summary") {
            times += entry.value("accesses", uint64_t(0));
        } else if (event == "start") {
            started = true;
        }
    }
    const bool any = !accesses.empty() || !leaks.empty();
    if (!started)
        std::fprintf(stderr, "sunstone: the program did not use Sunstone's libraries: "
                             "nothing was checked\n");
    else if (!any)
        std::fprintf(stderr, "sunstone: no invalid accesses%s\n",
                     options.leakCheck ? ", no leaks" : "");
    if (!accesses.empty())
        std::fprintf(stderr, "sunstone: invalid accesses at %zu %s, %llu in all\n", accesses.size(),
                     accesses.size() == 1 ? "place" : "places",
                     static_cast<unsigned long long>(std::max<uint64_t>(times, accesses.size())));
    if (!leaks.empty())
        std::fprintf(stderr, "sunstone: %zu %s never freed, %llu bytes\n", leaks.size(),
                     leaks.size() == 1 ? "allocation was" : "allocations were",
                     static_cast<unsigned long long>(leakedBytes));
    if (!options.json.empty()) {
        std::ofstream out(options.json);
        out << json{{"checked", started}, {"accesses", accesses}, {"leaks", leaks}}.dump(2) << '\n';
        if (!out.flush())
            throw std::runtime_error("run: cannot write " + options.json);
    }
    return any;
}

} // namespace sunstone::tool
