// SPDX-License-Identifier: Apache-2.0
#include "compare.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

namespace differential {
namespace {

// One member of Seen: numbers agree within `slack` of their size (at least of 1), words agree
// exactly.
struct Field {
    const char* name;
    size_t offset, count;
    bool isNumber;
    float slack;
};

#define WORDS(member, count)                                                                       \
    { #member, offsetof(Seen, member), count, false, 0 }
#define NUMBERS(member, count, slack)                                                              \
    { #member, offsetof(Seen, member), count, true, slack }
const Field kFields[] = {WORDS(value, 1),
                         WORDS(sbtGasIndex, 1),
                         WORDS(instanceId, 1),
                         WORDS(hitKind, 1),
                         WORDS(primitiveType, 1),
                         WORDS(sides, 1),
                         WORDS(rayFlags, 1),
                         WORDS(mask, 1),
                         WORDS(transforms, 1),
                         NUMBERS(time, 1, 0),
                         NUMBERS(t, 1, 2e-5f),
                         NUMBERS(objectToWorld, 12, 1e-5f),
                         NUMBERS(worldToObject, 12, 1e-4f),
                         NUMBERS(worldPoint, 3, 1e-5f),
                         NUMBERS(worldNormal, 3, 1e-4f),
                         NUMBERS(geometry, 16, 1e-6f),
                         WORDS(payload, 2),
                         WORDS(exception, 1),
                         WORDS(exceptionDetails, 2)};

bool agree(const Field& field, const Seen& a, const Seen& b) {
    const char *pa = reinterpret_cast<const char*>(&a) + field.offset,
               *pb = reinterpret_cast<const char*>(&b) + field.offset;
    if (!field.isNumber)
        return std::memcmp(pa, pb, 4 * field.count) == 0;
    for (size_t i = 0; i < field.count; ++i) {
        float x, y;
        std::memcpy(&x, pa + 4 * i, 4);
        std::memcpy(&y, pb + 4 * i, 4);
        if (!(std::abs(x - y) <= field.slack * std::max(1.0f, std::abs(y))) &&
            std::memcmp(&x, &y, 4) != 0 && !(std::isnan(x) && std::isnan(y)))
            return false;
    }
    return true;
}

// Attributes of triangles and curves are numbers, those of custom primitives and spheres words.
bool attributesAgree(const Seen& a, const Seen& b) {
    for (int i = 0; i < 2; ++i) {
        float x, y;
        std::memcpy(&x, &a.attributes[i], 4);
        std::memcpy(&y, &b.attributes[i], 4);
        if (a.attributes[i] != b.attributes[i] && !(std::abs(x - y) <= 2e-4f))
            return false;
    }
    return true;
}

using Counts = std::map<std::string, size_t>;

void compareRay(const Seen& a, const Seen& b, Counts& counts) {
    if (a.outcome != b.outcome) {
        ++counts["outcome"];
        return;
    }
    if (a.primitive != b.primitive || a.instanceIndex != b.instanceIndex) {
        const bool near = std::abs(a.t - b.t) <= 1e-5f * std::max(1.0f, std::abs(b.t));
        ++counts[near ? "other_at_same_distance" : "other_primitive"];
        return;
    }
    for (const Field& field : kFields)
        if (!agree(field, a, b))
            ++counts[field.name];
    if (!attributesAgree(a, b))
        ++counts["attributes"];
}

// "name answer" lines; each difference is counted under its name and printed.
void compareText(const std::string& a, const std::string& b, Counts& counts, std::string& told) {
    std::istringstream inA(a), inB(b);
    for (std::string x, y; std::getline(inA, x);) {
        std::getline(inB, y);
        if (x == y)
            continue;
        ++counts[x.substr(0, x.find(' '))];
        told +=
            "    reference " + x + "; Sunstone" + y.substr(std::min(y.size(), y.find(' '))) + "\n";
    }
}

// Known differences: by case and name, the largest count.
class Known {
public:
    explicit Known(const std::string& path) {
        std::ifstream file(path);
        if (!file)
            throw std::runtime_error("cannot read " + path);
        for (std::string line; std::getline(file, line);) {
            std::istringstream words(line);
            std::string name, what, why;
            size_t most = 0;
            if (line.empty() || line[0] == '#')
                continue;
            if (!(words >> name >> what >> most >> why))
                throw std::runtime_error(path + ": cannot read '" + line + "'");
            most_[name + ' ' + what] = most;
        }
    }
    bool explains(const std::string& name, const std::string& what, size_t count) const {
        const auto found = most_.find(name + ' ' + what);
        return found != most_.end() && count <= found->second;
    }

private:
    std::map<std::string, size_t> most_;
};

size_t countOf(const Answer& a, Outcome outcome) {
    return size_t(std::count_if(a.seen.begin(), a.seen.end(),
                                [&](const Seen& s) { return s.outcome == outcome; }));
}

const Answer& answerOf(const std::vector<Answer>& answers, const std::string& name) {
    static const Answer none = {"", "no answer", {}, {}};
    const auto found = std::find_if(answers.begin(), answers.end(),
                                    [&](const Answer& a) { return a.name == name; });
    return found == answers.end() ? none : *found;
}

// Whether all differences of a case that both have run are explained.
bool compareCase(const Answer& reference, const Answer& ours, const Known& known) {
    Counts counts;
    std::string told;
    if (reference.seen.size() != ours.seen.size()) {
        counts["number_of_rays"] = 1;
    } else {
        for (size_t i = 0; i < ours.seen.size(); ++i)
            compareRay(ours.seen[i], reference.seen[i], counts);
    }
    compareText(reference.text, ours.text, counts, told);
    bool good = true;
    std::string line;
    for (const auto& [what, count] : counts) {
        const bool explained = known.explains(ours.name, what, count);
        good &= explained;
        line += (line.empty() ? "" : ", ") + what + " " + std::to_string(count) +
                (explained ? "" : " (UNEXPLAINED)");
    }
    std::printf("%-32s %4zu rays, %4zu hits: %s\n%s", ours.name.c_str(), ours.seen.size(),
                countOf(reference, kHit), line.empty() ? "agree" : line.c_str(), told.c_str());
    return good;
}

} // namespace

bool compare(const std::vector<std::string>& cases, const std::vector<Answer>& reference,
             const std::vector<Answer>& ours, const std::string& differences,
             const std::set<std::string>& missing) {
    const Known known(differences);
    bool good = true;
    for (const std::string& name : cases) {
        const Answer &a = answerOf(reference, name), &b = answerOf(ours, name);
        const bool listed = missing.count("differential." + name);
        if (a.state != "ok") {
            std::printf("%-32s the reference: %s\n", name.c_str(), a.state.c_str());
            good = false;
        } else if (b.state == "ok") {
            good &= compareCase(a, b, known);
            if (listed)
                std::printf("  on the list of what is missing, but runs\n");
        } else {
            std::printf("%-32s %s: %s\n", name.c_str(), listed ? "not yet" : "FAILS",
                        b.state.c_str());
            good &= listed;
        }
    }
    return good;
}

} // namespace differential
