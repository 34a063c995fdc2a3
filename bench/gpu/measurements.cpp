// SPDX-License-Identifier: Apache-2.0
#include "measurements.h"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <stdexcept>

namespace bench {

void Measurements::add(const std::string& scene, const std::string& what, double value,
                       const char* unit) {
    values_.push_back({{"scene", scene}, {"what", what}, {"value", value}, {"unit", unit}});
    std::printf("%-24s %-28s %10.3f %s\n", scene.c_str(), what.c_str(), value, unit);
    std::fflush(stdout);
}

void Measurements::addDifferences(const std::string& scene, const std::string& what,
                                  nlohmann::json counts) {
    std::printf("%-24s %-28s differences %s\n", scene.c_str(), what.c_str(), counts.dump().c_str());
    counts["scene"] = scene;
    counts["what"] = what;
    differences_.push_back(std::move(counts));
}

void Measurements::write(const std::string& path) const {
    std::ofstream file(path);
    file << nlohmann::json{{"library", label_},
                           {"measurements", values_},
                           {"differences", differences_}}
                .dump(1)
         << '\n';
    if (!file)
        throw std::runtime_error("cannot write " + path);
}

namespace {

struct Key {
    std::string scene, what;
    auto operator<=>(const Key&) const = default;
};

struct Pair {
    double reference = NAN, ours = NAN;
    std::string unit;
    // Ratio to the reference, above 1: better.
    double ratio() const {
        return unit == "Mrays/s" || unit == "dB" ? ours / reference : reference / ours;
    }
};

class Report {
public:
    void read(const std::string& path) {
        std::ifstream stream(path);
        const nlohmann::json file = nlohmann::json::parse(stream, nullptr, false);
        if (!file.is_object() || !file.contains("library") || !file.contains("measurements"))
            throw std::runtime_error(path + " is no file of bench_gpu");
        const bool reference = file["library"] == "reference";
        for (const auto& entry : file["measurements"]) {
            const Key key{entry.at("scene"), entry.at("what")};
            if (!pairs_.contains(key))
                order_.push_back(key);
            Pair& pair = pairs_[key];
            (reference ? pair.reference : pair.ours) = entry.at("value");
            pair.unit = entry.at("unit");
        }
        for (const auto& entry : file.value("differences", nlohmann::json::array()))
            differences_.push_back(entry);
    }

    int print() {
        std::printf("| scene | what | unit | reference | Sunstone | ratio | bar |\n"
                    "|---|---|---|---|---|---|---|\n");
        for (const Key& key : order_)
            printRow(key);
        if (rays_ > 0)
            printBar("geometric mean of rays, default flags", std::exp(logarithms_ / rays_), 2.0);
        std::printf("\n%d of %d bars are met\n", met_, met_ + missed_);
        printDifferences();
        return missed_;
    }

private:
    static bool has(const std::string& text, const char* part) {
        return text.find(part) != std::string::npos;
    }

    void printDifferences() const {
        std::printf("\nRays whose hits differ (right and wrong by arithmetic of 113 bits):%s\n",
                    differences_.empty() ? " none" : "");
        for (const auto& entry : differences_) {
            std::string counts;
            for (const auto& [name, value] : entry.items())
                if (name != "scene" && name != "what")
                    counts += (counts.empty() ? "" : ", ") + name + " " + value.dump();
            std::printf("- %s, %s: %s\n", entry["scene"].get<std::string>().c_str(),
                        entry["what"].get<std::string>().c_str(), counts.c_str());
        }
    }

    void printRow(const Key& key) {
        const Pair& pair = pairs_[key];
        const auto number = [](const char* format, double value) {
            char text[32];
            std::snprintf(text, sizeof(text), format, value);
            return std::string(std::isnan(value) ? "-" : text);
        };
        std::printf("| %s | %s | %s | %s | %s | %s | ", key.scene.c_str(), key.what.c_str(),
                    pair.unit.c_str(), number("%.4g", pair.reference).c_str(),
                    number("%.4g", pair.ours).c_str(), number("%.2f", pair.ratio()).c_str());
        std::printf("%s |\n", judge(key, pair).c_str());
    }

    // The bar of a row, and whether it is met; empty: no bar.
    std::string judge(const Key& key, const Pair& pair) {
        if (has(key.scene, "moving"))
            return "";
        const bool fastTrace = has(key.scene, "fast trace");
        if (pair.unit == "Mrays/s") {
            if (!fastTrace && pair.ratio() > 0) {
                logarithms_ += std::log(pair.ratio());
                ++rays_;
            }
            return atLeast(pair.ratio(), fastTrace && has(key.scene, "long thin") ? 8.0 : 1.3);
        }
        if (pair.unit == "ms/frame")
            return atLeast(pair.ratio(), has(key.scene, "recursion") ? 0.67 : 1.5);
        if (pair.unit == "ms" && has(key.what, "compile"))
            return has(key.what, "first")
                       ? ""
                       : atLeast(pair.ratio(), has(key.what, "cached") ? 3.0 : 1.0);
        if (pair.unit == "ms" && has(key.what, "build, "))
            return has(key.what, "fast trace") ? "" : atLeast(pair.ratio(), 1.0);
        if (pair.unit == "B/triangle" && has(key.what, "compacted"))
            return atMost(pair.ours, has(key.what, "random access") ? 80 : 60);
        if (pair.unit == "B/triangle" && has(key.what, "temp"))
            return atMost(pair.ours, 100);
        return "";
    }

    std::string atLeast(double value, double bar) { return verdict(value >= bar, ">=", bar); }
    std::string atMost(double value, double bar) { return verdict(value <= bar, "<=", bar); }
    std::string verdict(bool met, const char* relation, double bar) {
        ++(met ? met_ : missed_);
        char text[48];
        std::snprintf(text, sizeof(text), "%s %g %s", relation, bar, met ? "pass" : "SHORT");
        return text;
    }
    void printBar(const char* what, double value, double bar) {
        std::printf("| all | %s | | | | %.2f | %s |\n", what, value, atLeast(value, bar).c_str());
    }

    std::map<Key, Pair> pairs_;
    std::vector<Key> order_;
    std::vector<nlohmann::json> differences_;
    double logarithms_ = 0;
    int rays_ = 0, met_ = 0, missed_ = 0;
};

} // namespace

int printReport(const std::vector<std::string>& files) {
    Report report;
    for (const std::string& file : files)
        report.read(file);
    return report.print();
}

} // namespace bench
