// SPDX-License-Identifier: Apache-2.0
// The results of bench_gpu: numbers with their scene, name and unit, as JSON; and the table that
// compares the files of two libraries, with the bars met.
#pragma once

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace bench {

class Measurements {
public:
    explicit Measurements(std::string label) : label_(std::move(label)) {}

    // Prints the line too.
    void add(const std::string& scene, const std::string& what, double value, const char* unit);
    // Adds the differences of two libraries' hits as further members of the file.
    void addDifferences(const std::string& scene, const std::string& what, nlohmann::json counts);
    // Throws std::runtime_error if the file cannot be written.
    void write(const std::string& path) const;

private:
    std::string label_;
    nlohmann::json values_ = nlohmann::json::array(), differences_ = nlohmann::json::array();
};

// Reads files written by Measurements with the labels "reference" and "sunstone" and prints tables.
// Returns the number of missed bars. Throws std::runtime_error on files of another form.
int printReport(const std::vector<std::string>& files);

} // namespace bench
