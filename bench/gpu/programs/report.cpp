// SPDX-License-Identifier: Apache-2.0
// Compares two libraries' results: ratios of times (above 1 the second library is faster), bars,
// and pictures.
#include "run.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>

namespace bench {
namespace {

using Values = std::map<std::string, double>; // by "phase, what"

void readValues(const std::string& out, const std::string& name, const std::string& label,
                const std::string& phase, Values& values) {
    std::ifstream stream(resultFile(out, name, label, phase + ".json"));
    const nlohmann::json file = nlohmann::json::parse(stream, nullptr, false);
    if (!file.is_object() || !file.contains("measurements"))
        return;
    for (const auto& entry : file["measurements"])
        values[phase + ", " + entry.at("what").get<std::string>()] = entry.at("value");
}

std::vector<float> readPicture(const std::string& path) {
    std::ifstream stream(path, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(stream), {}};
    std::vector<float> pixels(bytes.size() / sizeof(float));
    std::copy_n(bytes.begin(), pixels.size() * sizeof(float),
                reinterpret_cast<char*>(pixels.data()));
    return pixels;
}

struct Difference {
    double means, pixels; // over the mean of the reference
    bool isKnown;
};
Difference compare(const std::vector<float>& reference, const std::vector<float>& ours) {
    if (reference.empty() || reference.size() != ours.size())
        return {0, 0, false};
    double sumA = 0, sumB = 0, difference = 0, scale = 0;
    for (size_t i = 0; i < reference.size(); ++i) {
        if (i % 4 == 3)
            continue;
        const double a = double(reference[i]), b = double(ours[i]);
        sumA += a;
        sumB += b;
        difference += std::fabs(a - b);
        scale += std::fabs(a);
    }
    return {std::fabs(sumA - sumB) / scale, difference / scale, scale > 0};
}

struct Bar {
    const char* what; // of Values
    const char* title;
    double least, mean; // each program; geometric mean, 0: no bar
};
constexpr Bar kBars[] = {
    {"cold, compile", "compile, no caches", 1.25, 0},
    {"cold, start to picture", "start to picture, no caches", 1.2, 0},
    {"warm, start to picture", "start to picture, caches", 1.2, 0},
    {"warm, best frame", "frame", 1.3, 2},
};

class Table {
public:
    Table(const std::string& out, const std::string& reference, const std::string& ours)
        : out_(out), labels_{reference, ours} {}

    int print() {
        std::printf("| program |");
        for (const Bar& bar : kBars)
            std::printf(" %s: %s, %s (ms) | ratio |", bar.title, labels_[0].c_str(),
                        labels_[1].c_str());
        std::printf(" picture |\n|---|");
        for (size_t i = 0; i < std::size(kBars); ++i)
            std::printf("---|---|");
        std::printf("---|\n");
        for (const JobKind& kind : jobKinds())
            printRow(kind);
        printMeans();
        std::ofstream(out_ + "/report.json") << json_.dump(1) << '\n';
        return failures_;
    }

private:
    void printRow(const JobKind& kind) {
        Values values[2];
        for (int side = 0; side < 2; ++side)
            for (const char* phase : {"cold", "warm"})
                readValues(out_, kind.name, labels_[side], phase, values[side]);
        if (values[0].empty() && values[1].empty())
            return; // not run
        std::printf("| %s |", kind.name);
        nlohmann::json row = {
            {"program", kind.name}, {labels_[0], values[0]}, {labels_[1], values[1]}};
        for (size_t i = 0; i < std::size(kBars); ++i)
            printTimes(kBars[i], values, row, i);
        const std::string verdict = judgePicture(kind, row);
        std::printf(" %s |\n", verdict.c_str());
        json_.push_back(row);
    }

    void printTimes(const Bar& bar, const Values (&values)[2], nlohmann::json& row, size_t index) {
        const auto a = values[0].find(bar.what), b = values[1].find(bar.what);
        if (a == values[0].end() || b == values[1].end()) {
            std::printf(" - | - |");
            return;
        }
        const double ratio = a->second / b->second;
        ++count_[index];
        logarithms_[index] += std::log(ratio);
        missed_[index] += ratio < bar.least;
        row["ratio of " + std::string(bar.what)] = ratio;
        std::printf(" %.*f, %.*f | %.2f%s |", a->second < 100 ? 2 : 0, a->second,
                    b->second < 100 ? 2 : 0, b->second, ratio, ratio < bar.least ? " SHORT" : "");
    }

    std::string judgePicture(const JobKind& kind, nlohmann::json& row) {
        std::vector<float> pictures[2];
        for (int side = 0; side < 2; ++side)
            pictures[side] = readPicture(resultFile(out_, kind.name, labels_[side], "picture"));
        const Difference d = compare(pictures[0], pictures[1]);
        if (!d.isKnown) {
            ++failures_;
            return pictures[0].empty()   ? "FAIL: none of " + labels_[0]
                   : pictures[1].empty() ? "FAIL: none of " + labels_[1]
                                         : "FAIL: of other sizes, or black";
        }
        // A comparison with NaN is false.
        const bool isRight = d.means <= kind.meanTolerance && d.pixels <= kind.pixelTolerance;
        row["picture"] = {{"means", d.means}, {"pixels", d.pixels}, {"agree", isRight}};
        failures_ += !isRight;
        char text[96];
        std::snprintf(text, sizeof(text), "%s %.2g, pixels %.2g", isRight ? "mean" : "DIFFER: mean",
                      d.means, d.pixels);
        return text;
    }

    void printMeans() {
        std::printf("\n");
        for (size_t i = 0; i < std::size(kBars); ++i) {
            if (count_[i] == 0)
                continue;
            const double mean = std::exp(logarithms_[i] / count_[i]);
            std::printf("%s: geometric mean %.2f of %d programs%s; %d below %.2f\n", kBars[i].title,
                        mean, count_[i], kBars[i].mean > 0 && mean < kBars[i].mean ? " SHORT" : "",
                        missed_[i], kBars[i].least);
        }
        std::printf("%d programs failed or have other pictures\n", failures_);
    }

    std::string out_, labels_[2];
    nlohmann::json json_ = nlohmann::json::array();
    double logarithms_[std::size(kBars)] = {};
    int count_[std::size(kBars)] = {}, missed_[std::size(kBars)] = {};
    int failures_ = 0;
};

} // namespace

int reportRuns(const std::string& out, const std::string& reference, const std::string& ours) {
    return Table(out, reference, ours).print();
}

} // namespace bench
