// SPDX-License-Identifier: Apache-2.0
// Proves for each function of the classic API that a test fails if the function has no effect.
//
//   check (--check | --find) TABLE FUNCTIONS RECORDS PROGRAM...
//
// A row of TABLE has a function and the test that shows its effect. FUNCTIONS lists all functions.
// Each PROGRAM runs once and leaves records of its tests in the folder RECORDS (calls.cpp). Then
// each test of the table runs again, and calls of the function that succeed do nothing: the test
// must fail. A row with the test "-" has a reason in its third column: the function has no effect,
// or cannot succeed. Then no test may call it with success and depend on it. --find prints rows for
// functions that the table lacks.
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <mutex>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr auto kLimit = 60s; // for a test whose call is missing: it may wait for ever

struct Row {
    std::string test, reason;
};
using Table = std::map<std::string, Row>; // by function
struct Record {
    std::string letters, program;
};
using Records = std::map<std::string, std::map<std::string, Record>>; // by function and test

[[noreturn]] void stop(const std::string& text) {
    std::cerr << "error: " << text << "\n";
    std::exit(2);
}

Table readTable(const std::string& path) {
    std::ifstream file(path);
    if (!file)
        stop("cannot read " + path);
    Table table;
    for (std::string line; std::getline(file, line);) {
        if (line.empty() || line[0] == '#')
            continue;
        std::stringstream fields(line);
        std::string function;
        Row row;
        std::getline(fields, function, '\t');
        std::getline(fields, row.test, '\t');
        std::getline(fields, row.reason, '\t');
        if (row.test.empty() || (row.test == "-" && row.reason.empty()))
            stop(path + ": " + function + " has no test and no reason");
        if (!table.emplace(function, row).second)
            stop(path + ": two rows for " + function);
    }
    return table;
}

// Names in lines like API6_DEFINITION(name, ...).
std::set<std::string> readFunctions(const std::string& path) {
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    const std::string all = text.str();
    static const std::regex kName(R"(API6_DEFINITION\((\w+),)");
    std::set<std::string> names = {"rtContextGetErrorString"};
    for (std::sregex_iterator it(all.begin(), all.end(), kName), end; it != end; ++it)
        names.insert((*it)[1]);
    if (names.size() < 425)
        stop(path + " has too few functions");
    return names;
}

// Runs the program silently with variables of the environment; returns whether it passes.
bool passes(const std::string& program, const std::string& filter,
            const std::vector<std::pair<std::string, std::string>>& variables) {
    const pid_t child = fork();
    if (child == 0) {
        for (const auto& [name, value] : variables)
            setenv(name.c_str(), value.c_str(), 1);
        if (!std::freopen("/dev/null", "w", stdout) || !std::freopen("/dev/null", "w", stderr))
            _exit(127);
        execl(program.c_str(), program.c_str(), ("--gtest_filter=" + filter).c_str(), nullptr);
        _exit(127);
    }
    if (child < 0)
        stop("fork failed");
    const auto end = std::chrono::steady_clock::now() + kLimit;
    int status = 0;
    while (waitpid(child, &status, WNOHANG) == 0) {
        if (std::chrono::steady_clock::now() > end) {
            kill(child, SIGKILL);
            waitpid(child, &status, 0);
            return false;
        }
        std::this_thread::sleep_for(1ms);
    }
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

// Empties the folder, runs the program and adds its records from the folder.
void addRecords(Records& records, const std::string& folder, const std::string& program) {
    fs::remove_all(folder);
    fs::create_directories(folder);
    if (!passes(program, "*", {{"SUNSTONE_CLASSIC_CALLS", folder}}))
        stop("tests of " + program + " fail");
    for (const auto& entry : fs::directory_iterator(folder)) {
        std::ifstream file(entry.path());
        for (std::string function, letters; file >> function >> letters;)
            if (letters.find('S') != std::string::npos)
                records[function][entry.path().filename()] = {letters, program};
    }
}

class Check {
public:
    Check(Table table, const std::set<std::string>& functions, Records records)
        : table_(std::move(table)), functions_(functions.begin(), functions.end()),
          records_(std::move(records)) {
        for (const std::string& function : functions)
            records_[function]; // several threads read the map
        for (const auto& [function, row] : table_)
            if (!functions.count(function))
                complain("there is no function " + function);
    }

    int run(void (Check::*one)(const std::string&)) {
        std::atomic<size_t> next{0};
        std::vector<std::thread> threads;
        for (unsigned i = 0; i < std::max(2u, std::thread::hardware_concurrency()); ++i)
            threads.emplace_back([&] {
                for (size_t n; (n = next++) < functions_.size();)
                    (this->*one)(functions_[n]);
            });
        for (std::thread& thread : threads)
            thread.join();
        std::cout << functions_.size() << " functions, " << errors_ << " errors\n";
        return errors_ ? 1 : 0;
    }

    void check(const std::string& function) {
        const auto found = table_.find(function);
        if (found == table_.end())
            return complain("no test shows what " + function + " does: add a row to effects.tsv");
        const Row& row = found->second;
        if (row.test == "-") {
            const std::string test = noticing(function);
            if (!test.empty())
                complain(test + " shows what " + function + " does: name it in effects.tsv");
            return;
        }
        const auto& tests = records_.at(function);
        const auto record = tests.find(row.test);
        if (record == tests.end())
            complain(row.test + " does not pass, or has no successful call of " + function);
        else if (!notices(function, row.test, record->second))
            complain(row.test + " passes when " + function + " does nothing");
    }

    void find(const std::string& function) {
        if (table_.count(function))
            return;
        const std::string test = noticing(function);
        std::lock_guard lock(mutex_);
        std::cout << function << "\t" << (test.empty() ? "?" : test) << std::endl;
    }

private:
    bool notices(const std::string& function, const std::string& test, const Record& record) {
        return !passes(record.program, test,
                       {{"SUNSTONE_CLASSIC_DROP", function + " " + record.letters}});
    }
    std::string noticing(const std::string& function) {
        for (const auto& [test, record] : records_.at(function))
            if (notices(function, test, record))
                return test;
        return "";
    }
    void complain(const std::string& text) {
        std::lock_guard lock(mutex_);
        std::cerr << "error: " << text << "\n";
        ++errors_;
    }

    const Table table_;
    const std::vector<std::string> functions_;
    Records records_;
    std::mutex mutex_;
    int errors_ = 0;
};

} // namespace

int main(int argc, char** argv) {
    const std::string mode = argc >= 6 ? argv[1] : "";
    if (mode != "--check" && mode != "--find")
        stop("usage: check (--check | --find) TABLE FUNCTIONS RECORDS PROGRAM...");
    Records records;
    for (int i = 5; i < argc; ++i)
        addRecords(records, argv[4], argv[i]);
    Check check(readTable(argv[2]), readFunctions(argv[3]), std::move(records));
    return check.run(mode == "--check" ? &Check::check : &Check::find);
}
