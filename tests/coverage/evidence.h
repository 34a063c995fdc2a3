// SPDX-License-Identifier: Apache-2.0
// Evidence for each symbol: from the records of test runs (call_record.h) for host and device
// functions, from the sources of tests for enumerators, fields and macros.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace coverage {

struct Symbol {
    std::string kind; // as in tests/headers/optix7_symbols.tsv
    std::string name;
    std::string value;
    std::string type;
};

std::string readText(const std::filesystem::path& file); // throws if there is none
// Rows of a table: fields between tabs; empty lines and lines that begin with # are left out.
std::vector<std::vector<std::string>> readRows(const std::filesystem::path& file);
std::vector<Symbol> readSymbols(const std::vector<std::filesystem::path>& tables);

// Returns the text without comments and without the contents of strings.
std::string withoutComments(const std::string& text);

using Files = std::map<std::string, int>; // file of the project, how often it shows the symbol

class Evidence {
public:
    // Ignores `records` that are older than their programs, because their tests may have been
    // removed.
    Evidence(const std::filesystem::path& root, const std::vector<Symbol>& symbols);
    void readRecords(const std::filesystem::path& records,
                     const std::vector<std::filesystem::path>& programs);

    // Files of tests that show the symbol at work; none if there is no test.
    Files filesFor(const Symbol& symbol) const;
    // The names of the results that a host function has returned in tests.
    std::set<std::string> resultsOf(const std::string& function) const;

private:
    struct Source {
        std::string path;
        std::map<std::string, int> words;
        std::map<std::string, int> allWords; // those in strings and comments too; API tests only
    };
    void readSource(const std::filesystem::path& file);
    void readHelpers();
    Files references(const std::string& word) const;
    Files deviceFunction(const std::string& name) const;
    Files field(const Symbol& symbol) const;
    Files members(const Symbol& symbol) const;
    static bool runs(const std::string& path);

    std::filesystem::path root_;
    const std::vector<Symbol>& symbols_;
    std::vector<Source> sources_;
    std::map<std::string, Files> succeeded_; // host function: files of tests
    std::map<std::string, std::set<std::string>> results_;
    std::map<std::string, Files> launched_; // .cu file: files of tests
    std::map<int, std::string> resultNames_;
    std::map<std::string, std::set<std::string>> usersOf_; // device helper: functions that call it
};

} // namespace coverage
