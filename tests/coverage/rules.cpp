// SPDX-License-Identifier: Apache-2.0
#include "rules.h"

#include <regex>

namespace coverage {

namespace fs = std::filesystem;

namespace {

// "Suite.Name" of every test in the tree.
std::set<std::string> testsIn(const fs::path& folder) {
    static const std::regex kTest(R"(\bTEST(_F|_P)?\(\s*(\w+),\s*(\w+)\))");
    std::set<std::string> tests;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        if (!entry.path().string().ends_with("_test.cpp"))
            continue;
        const std::string text = readText(entry.path());
        for (std::sregex_iterator it(text.begin(), text.end(), kTest), end; it != end; ++it)
            tests.insert((*it)[2].str() + "." + (*it)[3].str());
    }
    return tests;
}

} // namespace

void checkRules(const fs::path& root, const std::vector<Symbol>& symbols,
                const std::function<void(const std::string&)>& complain) {
    const std::set<std::string> tests = testsIn(root / "tests");
    std::set<std::string> functions, ruled;
    for (const Symbol& symbol : symbols)
        if (symbol.kind.starts_with("host function"))
            functions.insert(symbol.name);
    for (const auto& row : readRows(root / "tests/coverage/rules.tsv")) {
        if (!functions.count(row[0]))
            complain("rules.tsv: " + row[0] + " is no host function");
        if (row[1].empty() || row[2].empty() || !tests.count(row[3]))
            complain("rules.tsv: no test " + row[3] + " for " + row[0] + ": " + row[1]);
        ruled.insert(row[0]);
    }
    for (const std::string& function : functions)
        if (!ruled.count(function))
            complain("rules.tsv has no rule of " + function);
}

} // namespace coverage
