// SPDX-License-Identifier: Apache-2.0
// The table of docs/features.md: every symbol of the API with its state and the tests that prove
// it. Checks the table against the evidence (evidence.h), or writes it.
//
//   features (--check | --write) ROOT RECORDS PROGRAM...
//
// RECORDS is the folder with the records of the tests in PROGRAMs. tests/coverage/missing.tsv lists
// symbols that do not work: a pattern of names and the reason, which is "no test" for symbols that
// only lack a test. The check fails when
//   - a symbol has no row, or a row no symbol;
//   - a symbol that is not listed as missing has no test, or a host function no test of an error;
//   - a function that is listed as missing succeeds in a test, or a pattern fits no symbol;
//   - a row names a test that no longer shows the symbol;
//   - a host function has no row in rules.tsv, or a rule there no test (rules.h).
#include "evidence.h"
#include "rules.h"

#include <algorithm>
#include <fstream>
#include <functional>
#include <iostream>
#include <optional>
#include <sstream>
#include <tuple>

namespace {

using namespace coverage;
namespace fs = std::filesystem;

constexpr const char* kBegin = "<!-- table of symbols: written by the target `features` -->";

struct Row {
    std::string state;
    std::vector<std::string> files;
    std::set<std::string> results;
};

struct Section {
    const char* title;
    std::vector<std::string> kinds;
};
const Section kSections[] = {
    {"Host functions", {"host function"}},
    {"Host functions of OptiX 7.6", {"host function 7.6"}},
    {"Utility functions", {"utility function", "windows function"}},
    {"Device functions", {"device function", "device template", "device helper", "device macro"}},
    {"Enumerations", {"enum", "enumerator"}},
    {"Structures",
     {"struct", "field", "device struct", "device field", "utility struct", "utility field"}},
    {"New in OptiX 7.6",
     {"enum 7.6", "enumerator 7.6", "struct 7.6", "field 7.6", "device function 7.6", "macro 7.6",
      "typedef 7.6", "utility function 7.6", "device helper 7.6", "utility struct 7.6",
      "utility field 7.6"}},
    {"Types, macros, table",
     {"typedef", "macro", "host macro", "transient macro", "windows macro", "variable", "table",
      "table slot"}},
};

std::vector<std::string> split(const std::string& text, const std::string& separator) {
    std::vector<std::string> parts;
    size_t at = 0;
    for (size_t next; (next = text.find(separator, at)) != std::string::npos;
         at = next + separator.size())
        parts.push_back(text.substr(at, next - at));
    parts.push_back(text.substr(at));
    return parts;
}

std::string join(const auto& parts, const char* separator) {
    std::string text;
    for (const std::string& part : parts)
        text += (text.empty() ? "" : separator) + part;
    return text;
}

std::string shortResult(std::string name) {
    for (const char* prefix : {"OPTIX_ERROR_", "OPTIX_"})
        if (name.starts_with(prefix))
            return name.substr(std::string(prefix).size());
    return name;
}

// '*' at the end of a pattern matches any text.
bool fits(const std::string& pattern, const std::string& name) {
    return pattern.ends_with("*") ? name.starts_with(pattern.substr(0, pattern.size() - 1))
                                  : name == pattern;
}

class Table {
public:
    explicit Table(const fs::path& root) : root_(root), document_(root / "docs/features.md") {
        std::string text = readText(document_);
        size_t begin = text.find(kBegin);
        prose_ = text.substr(0, begin);
        if (begin == std::string::npos)
            return;
        for (const std::string& line : split(text.substr(begin), "\n")) {
            auto cells = split(line, " | ");
            if (cells.size() < 3 || !cells[0].starts_with("| `"))
                continue;
            Row row;
            row.state = cells[1];
            std::string files = cells[2].substr(0, cells[2].find(" |"));
            if (!files.empty())
                row.files = split(files, ", ");
            if (cells.size() > 3)
                for (const std::string& result :
                     split(cells[3].substr(0, cells[3].find(" |")), ", "))
                    row.results.insert(result);
            rows_[cells[0].substr(3, cells[0].size() - 4)] = row;
        }
    }
    const std::map<std::string, Row>& rows() const { return rows_; }

    void write(const std::vector<Symbol>& symbols,
               const std::function<Row(const Symbol&, const Row&)>& rowOf) const {
        std::ofstream out(document_);
        out << prose_ << kBegin << "\n";
        for (const Section& section : kSections) {
            bool isHost = std::string(section.title).starts_with("Host");
            bool begun = false;
            for (const Symbol& symbol : symbols) {
                if (std::find(section.kinds.begin(), section.kinds.end(), symbol.kind) ==
                    section.kinds.end())
                    continue;
                if (!begun)
                    out << "\n### " << section.title << "\n\n| symbol | state | tested by |"
                        << (isHost ? " results in tests |\n|---|---|---|---|\n"
                                   : "\n|---|---|---|\n");
                begun = true;
                auto old = rows_.find(symbol.name);
                Row row = rowOf(symbol, old == rows_.end() ? Row{} : old->second);
                out << "| `" << symbol.name << "` | " << row.state << " | "
                    << join(row.files, ", ");
                if (isHost)
                    out << " | " << join(row.results, ", ");
                out << " |\n";
            }
        }
        if (!out.flush())
            throw std::runtime_error("cannot write " + document_.string());
    }

private:
    fs::path root_, document_;
    std::string prose_;
    std::map<std::string, Row> rows_;
};

class Judge {
public:
    Judge(const fs::path& root, const std::vector<Symbol>& symbols, const Evidence& evidence)
        : evidence_(evidence) {
        for (const auto& row : readRows(root / "tests/coverage/missing.tsv")) {
            bool isUsed = std::any_of(symbols.begin(), symbols.end(),
                                      [&](const Symbol& s) { return fits(row[0], s.name); });
            if (!isUsed)
                complain("missing.tsv: no symbol is called " + row[0]);
            missing_.emplace_back(row[0], row[1]);
        }
    }

    // The row as the tests prove it; files of the old row stay where they are still right.
    Row rowOf(const Symbol& symbol, const Row& old) {
        Row row;
        Files files = evidence_.filesFor(symbol);
        bool isFunction = symbol.kind == "host function";
        for (const std::string& result : evidence_.resultsOf(symbol.name))
            if (isFunction)
                row.results.insert(shortResult(result));
        if (const std::string* reason = reasonFor(symbol.name)) {
            // Tests may name refused functions; they cannot call them with success.
            bool isUntested = *reason == kUntested;
            row.state = isUntested ? "untested" : "missing: " + *reason;
            bool isCalled = isFunction || symbol.kind.starts_with("device function");
            if ((isUntested || isCalled) && !files.empty())
                complain(symbol.name + " is listed as missing, but " + files.begin()->first +
                         " tests it: remove it from missing.tsv");
            return row;
        }
        row.state = "works";
        if (files.empty())
            complain(symbol.name + " (" + symbol.kind +
                     ") has no test: write one, or list it in missing.tsv");
        bool canFail = isFunction && !symbol.type.starts_with("const char*");
        if (canFail && row.results.size() < 2)
            complain(symbol.name + " has no test of an error");
        for (const std::string& file : old.files)
            if (files.erase(file) && row.files.size() < kFiles)
                row.files.push_back(file);
        while (row.files.size() < kFiles && !files.empty()) {
            auto best = std::max_element(files.begin(), files.end(),
                                         [](auto& a, auto& b) { return rank(a) < rank(b); });
            row.files.push_back(best->first);
            files.erase(best);
        }
        return row;
    }

    void compare(const Symbol& symbol, const Table& table) {
        auto found = table.rows().find(symbol.name);
        if (found == table.rows().end())
            return complain("docs/features.md has no row for " + symbol.name);
        const Row& old = found->second;
        Row row = rowOf(symbol, old);
        if (old.state != row.state)
            complain("docs/features.md: " + symbol.name + " is '" + row.state + "', not '" +
                     old.state + "'");
        for (const std::string& file : old.files)
            if (std::find(row.files.begin(), row.files.end(), file) == row.files.end())
                complain("docs/features.md: " + symbol.name + " is not tested by " + file);
        for (const std::string& result : old.results)
            if (!result.empty() && !row.results.count(result))
                complain("docs/features.md: " + symbol.name + " gives " + result + " in no test");
    }

    void complain(const std::string& text) {
        std::cerr << "error: " << text << "\n";
        ++errors_;
    }
    int errors() const { return errors_; }

private:
    static constexpr size_t kFiles = 2;
    static constexpr const char* kUntested = "no test";
    // Tests of the API first, samples last, then by the number of uses; names decide ties.
    static std::tuple<bool, bool, int, std::string>
    rank(const std::pair<const std::string, int>& file) {
        return {!file.first.starts_with("samples/"), file.first.starts_with("tests/api"),
                file.second, file.first};
    }
    const std::string* reasonFor(const std::string& name) const {
        for (const auto& [pattern, reason] : missing_)
            if (fits(pattern, name))
                return &reason;
        return nullptr;
    }
    const Evidence& evidence_;
    std::vector<std::pair<std::string, std::string>> missing_;
    int errors_ = 0;
};

// Symbols that OptiX 7.6 has and 7.4 lacks, as separate kinds.
void addLaterSymbols(std::vector<Symbol>& symbols, const std::vector<Symbol>& changes) {
    std::set<std::string> known;
    for (const Symbol& symbol : symbols)
        known.insert(symbol.name);
    for (Symbol symbol : changes)
        if (symbol.kind != "-" && symbol.kind != "table slot" && known.insert(symbol.name).second) {
            symbol.kind += " 7.6";
            symbols.push_back(symbol);
        }
}

int run(bool write, const fs::path& root, const fs::path& records,
        const std::vector<fs::path>& programs) {
    std::vector<Symbol> symbols = readSymbols({root / "tests/headers/optix7_symbols.tsv"});
    addLaterSymbols(symbols, readSymbols({root / "tests/headers/optix76_changes.tsv"}));
    Evidence evidence(root, symbols);
    evidence.readRecords(records, programs);
    Table table(root);
    Judge judge(root, symbols, evidence);
    std::set<std::string> names;
    for (const Symbol& symbol : symbols)
        names.insert(symbol.name);
    if (write) {
        table.write(symbols, [&](const Symbol& s, const Row& old) { return judge.rowOf(s, old); });
    } else {
        for (const Symbol& symbol : symbols)
            judge.compare(symbol, table);
        checkRules(root, symbols, [&](const std::string& text) { judge.complain(text); });
        for (const auto& [name, row] : table.rows())
            if (!names.count(name))
                judge.complain("docs/features.md has a row for " + name + ", which is no symbol");
    }
    std::cout << symbols.size() << " symbols, " << judge.errors() << " errors\n";
    if (judge.errors() && !write)
        std::cout
            << "After `ctest -R coverage`, `cmake --build . --target features` renews the table.\n";
    return judge.errors() ? 1 : 0;
}

} // namespace

int main(int argc, char** argv) {
    std::vector<std::string> arguments(argv + 1, argv + argc);
    if (arguments.size() < 4 || (arguments[0] != "--check" && arguments[0] != "--write")) {
        std::cerr << "usage: features (--check | --write) ROOT RECORDS PROGRAM...\n";
        return 2;
    }
    try {
        return run(arguments[0] == "--write", arguments[1], arguments[2],
                   {arguments.begin() + 3, arguments.end()});
    } catch (const std::exception& failure) {
        std::cerr << "error: " << failure.what() << "\n";
        return 2;
    }
}
