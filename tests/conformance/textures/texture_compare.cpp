// SPDX-License-Identifier: Apache-2.0
// Recordings of texture cases. The file is one zstd frame: lines with the device and, per case, its
// status, the hash of all its inputs, and its name; then the results in planes of bytes.
#include "driver.h"
#include "names.h"
#include "recording.h"
#include "textures/texture_run.h"

#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>
#include <sstream>

namespace conformance {

namespace {

constexpr size_t kWords = size_t(kTextureVectors) * 4;
constexpr unsigned kShown = 4;

uint32_t caseHash(const TextureCase& test) {
    std::string all = textureKernel(test);
    const auto append = [&](const void* data, size_t size) {
        all.append(static_cast<const char*>(data), size);
    };
    for (unsigned i = 0; i < kTextureVectors; ++i) {
        const TextureVector vector = textureVector(test, i);
        append(vector.data(), sizeof vector);
    }
    for (unsigned level = 0; level < test.levels; ++level) {
        const std::vector<uint8_t> content = textureContent(test, level);
        append(content.data(), content.size());
    }
    append(&test.sampling, sizeof test.sampling);
    append(&test.arrayFlags, sizeof test.arrayFlags);
    return hashOf(all.data(), all.size());
}

struct Recorded {
    char status = '?';
    uint32_t hash = 0;
    std::vector<uint32_t> words;
};

std::map<std::string, Recorded> loadTextures(const std::string& file, std::string& device) {
    const std::string bytes = loadCompressed(file);
    const CaseHead head = readHead(bytes, file, "textures");
    device = head.device;
    std::map<std::string, Recorded> all;
    size_t at = head.end;
    for (const CaseHead::Case& one : head.cases) {
        Recorded* recorded = &all[one.name];
        recorded->status = one.status;
        recorded->hash = one.hash;
        if (one.status != 'r')
            continue;
        if (at + kWords * 4 > bytes.size())
            quit(1, file + " ends too early");
        recorded->words.assign(kWords, 0);
        for (unsigned plane = 0; plane < 4; ++plane)
            for (uint32_t& word : recorded->words)
                word |= uint32_t(uint8_t(bytes[at++])) << (8 * plane);
    }
    return all;
}

struct Outcome {
    unsigned words = 0; // beyond the bound
    bool tooFar = false;
    double worst = 0;
    std::string text;
    uint32_t digest = 0; // of the words beyond it and their excess in thousandths
};

bool agree(const TextureCase& test, uint32_t want, uint32_t got, double& distance) {
    if (want == got)
        return true;
    const auto a = std::bit_cast<float>(want), b = std::bit_cast<float>(got);
    if (std::isnan(a) && std::isnan(b))
        return true;
    distance = std::fabs(double(a) - double(b));
    return distance <= test.bound;
}

Outcome compareCase(const TextureCase& test, const std::vector<uint32_t>& want,
                    const std::vector<uint32_t>& got) {
    Outcome outcome;
    for (size_t i = 0; i < kWords; ++i) {
        double distance = 0;
        const bool good = agree(test, want[i], got[i], distance);
        outcome.tooFar |= !good && !(distance <= test.most);
        if (!(distance <= outcome.worst))
            outcome.worst = distance;
        if (good)
            continue;
        const double thousandths = distance * 1000;
        const uint64_t where[3] = {outcome.digest, i,
                                   thousandths < 1e9 ? uint64_t(thousandths + 0.5) : ~uint64_t(0)};
        outcome.digest = hashOf(where, sizeof where);
        if (outcome.words++ >= kShown)
            continue;
        const TextureVector v = textureVector(test, unsigned(i / 4));
        char line[300];
        std::snprintf(
            line, sizeof line,
            "  vector %zu: (%08x %08x %08x = %g %g %g) layer %d level %g  word %zu = %08x "
            "(%g), recorded %08x (%g)\n",
            i / 4, v[0], v[1], v[2], double(std::bit_cast<float>(v[0])),
            double(std::bit_cast<float>(v[1])), double(std::bit_cast<float>(v[2])), int(v[3]),
            double(std::bit_cast<float>(v[4])), i % 4, got[i], double(std::bit_cast<float>(got[i])),
            want[i], double(std::bit_cast<float>(want[i])));
        outcome.text += line;
    }
    return outcome;
}

} // namespace

void saveTextures(const std::string& file, const TextureResults& results) {
    const std::vector<TextureCase>& cases = allTextureCases();
    constexpr char kLetters[] = {'?', 'r', '-', 'x'};
    std::ostringstream head;
    head << "textures " << cases.size() << '\n' << results.device << '\n';
    std::string data;
    for (size_t i = 0; i < cases.size(); ++i) {
        head << kLetters[size_t(results.status[i])] << ' ' << caseHash(cases[i]) << ' '
             << cases[i].name << '\n';
        if (results.status[i] == Status::kDone)
            for (unsigned plane = 0; plane < 4; ++plane)
                for (const uint32_t word : results.words[i])
                    data.push_back(char(word >> (8 * plane)));
    }
    saveCompressed(file, head.str() + data);
}

int compareTextures(const std::string& file, const TextureResults& results,
                    const std::set<std::string>& gaps, const Deviations& deviations,
                    const std::string& only) {
    std::string device;
    const std::map<std::string, Recorded> recorded = loadTextures(file, device);
    const std::vector<TextureCase>& cases = allTextureCases();
    unsigned agreed = 0, different = 0, known = 0, notThere = 0, deviating = 0;
    for (size_t i = 0; i < cases.size(); ++i) {
        const TextureCase& test = cases[i];
        if (test.name.find(only) == std::string::npos)
            continue;
        const auto found = recorded.find(test.name);
        const bool gap = isNamed(gaps, test.name);
        std::string problem;
        if (found == recorded.end() || found->second.hash != caseHash(test)) {
            if (gap) {
                ++known;
                continue;
            }
            problem = "not in the recording";
        } else if (found->second.status != 'r') {
            ++notThere;
            continue;
        } else if (results.status[i] != Status::kDone) {
            if (gap) {
                ++known;
                continue;
            }
            problem = results.status[i] == Status::kRefused ? "refused" : "crashed";
        } else {
            const Outcome outcome = compareCase(test, found->second.words, results.words[i]);
            const bool differs = outcome.tooFar || outcome.words > test.share * kWords;
            const auto listed = deviations.find(test.name);
            const Deviation seen = {outcome.words, outcome.digest};
            if (listed != deviations.end() && seen == listed->second) {
                ++deviating;
                continue;
            }
            if (gap)
                problem = "named as a gap, but it runs";
            else if (listed != deviations.end())
                problem = "not the deviation of the list; here: " + lineOf(test.name, seen);
            else if (differs)
                problem = std::to_string(outcome.words) + " words differ, by " +
                          std::to_string(outcome.worst) +
                          " at most; here: " + lineOf(test.name, seen) + "\n" + outcome.text;
        }
        ++(problem.empty() ? agreed : different);
        if (!problem.empty())
            std::printf("%s: %s\n", test.name.c_str(), problem.c_str());
    }
    std::printf(
        "recorded on %s, replayed on %s: %u texture cases agree, %u do not; %u known gaps, "
        "%u where a device may differ, %u not recorded (the recorder's driver refused them)\n",
        device.c_str(), results.device.c_str(), agreed, different, known, deviating, notThere);
    return different ? 1 : 0;
}

} // namespace conformance
