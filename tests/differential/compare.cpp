// SPDX-License-Identifier: Apache-2.0
#include "compare.h"

#include <optix_types.h>

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

#define WORDS(member, count) {#member, offsetof(Seen, member), count, false, 0}
#define NUMBERS(member, count, slack) {#member, offsetof(Seen, member), count, true, slack}
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
                         NUMBERS(objectToWorld, 12, 0),
                         NUMBERS(worldToObject, 12, 0),
                         NUMBERS(worldPoint, 3, 0),
                         NUMBERS(worldNormal, 3, 0),
                         NUMBERS(geometry, 16, 0),
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

// The attributes of triangles and the parameter of curves are numbers. All others are words: the
// programs of custom primitives report integers, whose bits would be tiny numbers.
bool attributesAgree(const Seen& a, const Seen& b) {
    const bool isCurve = a.primitiveType >= OPTIX_PRIMITIVE_TYPE_ROUND_QUADRATIC_BSPLINE &&
                         a.primitiveType <= OPTIX_PRIMITIVE_TYPE_ROUND_CATMULLROM;
    const int numbers = a.primitiveType == OPTIX_PRIMITIVE_TYPE_TRIANGLE ? 2 : isCurve ? 1 : 0;
    for (int i = 0; i < 2; ++i) {
        float x, y;
        std::memcpy(&x, &a.attributes[i], 4);
        std::memcpy(&y, &b.attributes[i], 4);
        if (a.attributes[i] != b.attributes[i] && !(i < numbers && std::abs(x - y) <= 2e-4f))
            return false;
    }
    return true;
}

// How often two libraries differ in one field or answer, and a digest of the places and of our
// exact answers.
struct Difference {
    size_t count = 0;
    unsigned digest = 0x811C9DC5u;

    void add(const void* bytes, size_t size) { // FNV-1a
        for (size_t i = 0; i < size; ++i)
            digest = (digest ^ static_cast<const unsigned char*>(bytes)[i]) * 0x01000193u;
    }
    void at(unsigned index, const void* answer = nullptr, size_t size = 0) {
        ++count;
        add(&index, sizeof index);
        add(answer, size);
    }
    bool operator==(const Difference&) const = default;
};
using Differences = std::map<std::string, Difference>;

// Compares the answers of the reference, `a`, and of Sunstone, `b`, to the ray of this index.
void compareRay(const Seen& a, const Seen& b, unsigned index, Differences& differences) {
    if (a.outcome != b.outcome) {
        differences["outcome"].at(index, &b.outcome, sizeof b.outcome);
        return;
    }
    if (a.primitive != b.primitive || a.instanceIndex != b.instanceIndex) {
        const bool near = std::abs(a.t - b.t) <= 1e-5f * std::max(1.0f, std::abs(a.t));
        differences[near ? "other_at_same_distance" : "other_primitive"].at(index, &b.primitive,
                                                                            sizeof b.primitive);
        return;
    }
    for (const Field& field : kFields) {
        if (agree(field, b, a))
            continue;
        // The digest leaves out the last bits of numbers.
        const char* const ours = reinterpret_cast<const char*>(&b) + field.offset;
        differences[field.name].at(index, ours, field.isNumber ? 0 : 4 * field.count);
    }
    if (!attributesAgree(a, b))
        differences["attributes"].at(index);
}

// "name answer" lines; each difference is counted under its name and printed.
void compareText(const std::string& a, const std::string& b, Differences& differences,
                 std::string& told) {
    std::istringstream inA(a), inB(b);
    for (unsigned i = 0;; ++i) {
        std::string x, y;
        std::getline(inA, x);
        std::getline(inB, y);
        if (!inA && !inB)
            return;
        if (x == y)
            continue;
        const std::string& named = x.empty() ? y : x;
        differences[named.substr(0, named.find(' '))].at(i, y.data(), y.size());
        told += "    reference " + (x.empty() ? "nothing" : x) + "; Sunstone" +
                y.substr(std::min(y.size(), y.find(' '))) + "\n";
    }
}

// Known differences, by case and name.
class Known {
public:
    Known(const std::string& path, const std::vector<std::string>& cases) {
        std::ifstream file(path);
        if (!file)
            throw std::runtime_error("cannot read " + path);
        for (std::string line; std::getline(file, line);) {
            std::istringstream words(line);
            std::string name, what, why;
            Difference one;
            if (line.empty() || line[0] == '#')
                continue;
            if (!(words >> name >> what >> one.count >> std::hex >> one.digest >> why))
                throw std::runtime_error(path + ": cannot read '" + line + "'");
            if (std::find(cases.begin(), cases.end(), name) == cases.end())
                throw std::runtime_error(path + ": there is no case '" + name + "'");
            known_[name][what].push_back(one);
        }
    }
    // For each name the differences that may occur: those on the CPU and, if they are others, those
    // of the code for GPUs.
    using Listed = std::map<std::string, std::vector<Difference>>;
    Listed of(const std::string& name) const {
        const auto found = known_.find(name);
        return found == known_.end() ? Listed() : found->second;
    }

private:
    std::map<std::string, Listed> known_;
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

// A line of the list, without the reason.
std::string lineOf(const std::string& name, const std::string& what, const Difference& difference) {
    char text[40];
    std::snprintf(text, sizeof text, " %zu %08x", difference.count, difference.digest);
    return name + ' ' + what + text;
}

// Whether the differences of a case that both libraries have run are exactly those of the list.
bool compareCase(const Answer& reference, const Answer& ours, const Known& known) {
    Differences differences;
    std::string told;
    if (reference.seen.size() != ours.seen.size() ||
        (reference.seen.empty() && reference.text.empty())) {
        differences["number_of_rays"].at(unsigned(ours.seen.size()));
    } else {
        for (size_t i = 0; i < ours.seen.size(); ++i)
            compareRay(reference.seen[i], ours.seen[i], unsigned(i), differences);
    }
    compareText(reference.text, ours.text, differences, told);
    Known::Listed expected = known.of(ours.name);
    bool good = true;
    std::string line;
    for (const auto& [what, difference] : differences) {
        const std::vector<Difference>& forms = expected[what];
        const bool explained = std::find(forms.begin(), forms.end(), difference) != forms.end();
        good &= explained;
        line += (line.empty() ? "" : ", ") + what + " " + std::to_string(difference.count);
        if (!explained)
            told += "  UNEXPLAINED: " + lineOf(ours.name, what, difference) + "\n";
        expected.erase(what);
    }
    for (const auto& [what, forms] : expected) {
        good = false;
        told += "  listed, but agrees: " + ours.name + ' ' + what + "\n";
    }
    std::printf("%-32s %4zu rays, %4zu hits: %s\n%s", ours.name.c_str(), ours.seen.size(),
                countOf(reference, kHit), line.empty() ? "agree" : line.c_str(), told.c_str());
    return good;
}

} // namespace

bool compare(const std::vector<std::string>& cases, const std::vector<std::string>& allCases,
             const std::vector<Answer>& reference, const std::vector<Answer>& ours,
             const std::string& differences, const std::set<std::string>& missing) {
    const Known known(differences, allCases);
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
