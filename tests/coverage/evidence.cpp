// SPDX-License-Identifier: Apache-2.0
#include "evidence.h"

#include <cctype>
#include <fstream>
#include <regex>
#include <sstream>
#include <stdexcept>

namespace coverage {

namespace fs = std::filesystem;

namespace {

bool isWord(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_';
}

// Words of a text, with the number of their occurrences. A word before "##" matches all words with
// that prefix, and is kept with the sign.
std::map<std::string, int> wordsOf(const std::string& text) {
    std::map<std::string, int> words;
    for (size_t i = 0; i < text.size();) {
        if (!isWord(text[i])) {
            ++i;
            continue;
        }
        size_t end = i;
        while (end < text.size() && isWord(text[end]))
            ++end;
        std::string word = text.substr(i, end - i);
        if (text.compare(end, 2, "##") == 0)
            word += "##";
        ++words[word];
        i = end;
    }
    return words;
}

int countOf(const std::map<std::string, int>& words, const std::string& word) {
    auto found = words.find(word);
    int count = found == words.end() ? 0 : found->second;
    size_t under = word.rfind('_');
    if (under != std::string::npos) {
        auto pasted = words.find(word.substr(0, under + 1) + "##");
        if (pasted != words.end())
            count += pasted->second;
    }
    return count;
}

// Functions defined in a header, with the text of their bodies.
std::map<std::string, std::string> bodiesOf(const std::string& text) {
    static const std::regex kDefinition(
        R"(\b(optix\w+)\s*\([^;{}()]*(\([^;{}()]*\)[^;{}()]*)*\)\s*\{)");
    std::map<std::string, std::string> bodies;
    for (std::sregex_iterator it(text.begin(), text.end(), kDefinition), end; it != end; ++it) {
        size_t open = size_t(it->position() + it->length()) - 1, at = open;
        int depth = 0;
        do {
            depth += text[at] == '{' ? 1 : text[at] == '}' ? -1 : 0;
            ++at;
        } while (at < text.size() && depth > 0);
        bodies[(*it)[1]] += text.substr(open, at - open);
    }
    return bodies;
}

} // namespace

std::string readText(const fs::path& file) {
    std::ifstream stream(file);
    std::ostringstream text;
    text << stream.rdbuf();
    if (!stream)
        throw std::runtime_error("cannot read " + file.string());
    return text.str();
}

std::vector<std::vector<std::string>> readRows(const fs::path& file) {
    std::vector<std::vector<std::string>> rows;
    std::istringstream lines(readText(file));
    for (std::string line; std::getline(lines, line);) {
        if (line.empty() || line[0] == '#')
            continue;
        std::vector<std::string> row;
        std::istringstream fields(line);
        for (std::string field; std::getline(fields, field, '\t');)
            row.push_back(field);
        row.resize(std::max<size_t>(row.size(), 4));
        rows.push_back(row);
    }
    return rows;
}

std::vector<Symbol> readSymbols(const std::vector<fs::path>& tables) {
    std::vector<Symbol> symbols;
    std::set<std::string> seen; // templates are also listed as functions
    for (const fs::path& table : tables)
        for (const auto& row : readRows(table)) {
            bool isSlot = row[0] == "table slot";
            std::string name = isSlot ? "OptixFunctionTable::" + row[1] : row[1];
            if (seen.insert(name).second)
                symbols.push_back({row[0], name, row[2], row[3]});
        }
    return symbols;
}

std::string withoutComments(const std::string& text) {
    std::string result;
    for (size_t i = 0; i < text.size();) {
        if (text.compare(i, 2, "//") == 0) {
            i = std::min(text.find('\n', i), text.size());
        } else if (text.compare(i, 2, "/*") == 0) {
            size_t end = text.find("*/", i + 2);
            i = end == std::string::npos ? text.size() : end + 2;
            result += ' ';
        } else if (text[i] == '"') {
            for (++i; i < text.size() && text[i] != '"' && text[i] != '\n'; ++i)
                i += text[i] == '\\';
            ++i;
            result += "\"\"";
        } else {
            result += text[i++];
        }
    }
    return result;
}

Evidence::Evidence(const fs::path& root, const std::vector<Symbol>& symbols)
    : root_(root), symbols_(symbols) {
    for (const Symbol& symbol : symbols)
        if (symbol.kind == "enumerator" && symbol.type == "OptixResult")
            resultNames_[std::stoi(symbol.value)] = symbol.name;
    for (const char* folder : {"tests", "src", "samples"})
        for (const auto& entry : fs::recursive_directory_iterator(root / folder))
            if (entry.is_regular_file())
                readSource(entry.path());
    readHelpers();
}

// Reads a source that runs in tests. Excludes header checks that are only compiled, fuzzers, and
// this folder.
void Evidence::readSource(const fs::path& file) {
    std::string path = fs::relative(file, root_).generic_string();
    std::string extension = file.extension().string();
    if (extension != ".cpp" && extension != ".cu" && extension != ".c" && extension != ".h")
        return;
    if (path.starts_with("src/") && !path.ends_with("_test.cpp"))
        return;
    if (path.starts_with("tests/coverage/") || path.starts_with("tests/fuzz/") ||
        path.starts_with("tests/headers/host_") || path.starts_with("tests/headers/device_") ||
        path.starts_with("tests/headers/nvrtc"))
        return;
    std::string text = readText(file);
    sources_.push_back({path, wordsOf(withoutComments(text)), {}});
    if (path.starts_with("tests/api"))
        sources_.back().allWords = wordsOf(text);
}

void Evidence::readHelpers() {
    for (const auto& entry : fs::directory_iterator(root_ / "include/optix7/internal"))
        for (const auto& [function, body] : bodiesOf(withoutComments(readText(entry.path()))))
            for (const auto& [word, count] : wordsOf(body))
                if (word.starts_with("optix") && word != function)
                    usersOf_[word].insert(function);
}

void Evidence::readRecords(const fs::path& records, const std::vector<fs::path>& programs) {
    fs::file_time_type newest = fs::file_time_type::min();
    for (const fs::path& program : programs)
        newest = std::max(newest, fs::last_write_time(program));
    if (!fs::exists(records))
        return;
    for (const auto& entry : fs::directory_iterator(records)) {
        if (entry.last_write_time() < newest)
            continue;
        std::istringstream lines(readText(entry.path()));
        std::string source, word;
        while (lines >> word) {
            std::string name;
            lines >> name;
            if (word == "source")
                source = name;
            if (word == "launched")
                ++launched_[name][source];
            if (word == "call") {
                int result = 0;
                lines >> result;
                results_[name].insert(resultNames_[result]);
                if (result == 0)
                    ++succeeded_[name][source];
            }
        }
    }
}

bool Evidence::runs(const std::string& path) {
    // Tests without records run the programs of the header check and of samples.
    return path.starts_with("tests/headers/interop/") || path.starts_with("samples/");
}

Files Evidence::references(const std::string& word) const {
    Files files;
    for (const Source& source : sources_)
        if (int count = countOf(source.words, word))
            files[source.path] += count;
    return files;
}

Files Evidence::deviceFunction(const std::string& name) const {
    Files files;
    for (const auto& [source, count] : references(name)) {
        if (!source.ends_with(".cu") && !source.ends_with(".h"))
            continue;
        auto launched = launched_.find(source);
        if (launched != launched_.end() || runs(source))
            files[source] += count;
    }
    return files;
}

// A field counts if its name occurs together with the name of its structure, or with a field of
// this structure's type.
Files Evidence::field(const Symbol& symbol) const {
    size_t colons = symbol.name.find("::");
    std::string structure = symbol.name.substr(0, colons), name = symbol.name.substr(colons + 2);
    std::vector<std::string> holders = {structure};
    for (const Symbol& other : symbols_)
        if (other.name.find("::") != std::string::npos && other.type.find(structure) == 0 &&
            (other.type.size() == structure.size() || !isWord(other.type[structure.size()])))
            holders.push_back(other.name.substr(other.name.find("::") + 2));
    Files files;
    for (const Source& source : sources_)
        for (const std::string& holder : holders)
            if (int count = countOf(source.words, name); count && source.words.count(holder)) {
                files[source.path] = count;
                break;
            }
    return files;
}

// The evidence for a type: that for its enumerators or fields.
Files Evidence::members(const Symbol& symbol) const {
    Files files;
    for (const Symbol& other : symbols_) {
        bool isMember = other.kind == "enumerator" ? other.type == symbol.name
                                                   : other.name.starts_with(symbol.name + "::");
        if (isMember && other.kind != "table slot")
            for (const auto& [file, count] : filesFor(other))
                files[file] += count;
    }
    return files;
}

Files Evidence::filesFor(const Symbol& later) const {
    // The evidence for symbols of 7.6 depends on their kind; calls of its functions are not
    // recorded.
    Symbol symbol = later;
    if (symbol.kind.ends_with(" 7.6"))
        symbol.kind.resize(symbol.kind.size() - 4);
    if (symbol.kind == "host function" && later.kind != symbol.kind)
        return references(symbol.name);
    const Files headers = {{"tests/headers/generate.cpp", 1}};
    if (symbol.kind == "host function") {
        auto found = succeeded_.find(symbol.name);
        return found == succeeded_.end() ? Files{} : found->second;
    }
    if (symbol.kind == "device function" || symbol.kind == "device template")
        return deviceFunction(symbol.name);
    if (symbol.kind == "device helper") {
        Files files = deviceFunction(symbol.name);
        auto users = usersOf_.find(symbol.name);
        if (users != usersOf_.end())
            for (const std::string& user : users->second)
                for (const auto& [file, count] : filesFor({"device helper", user, "", ""}))
                    files[file] += count;
        return files;
    }
    // Result codes that no function returns: a test has their names in strings.
    if (symbol.kind == "enumerator" && symbol.type == "OptixResult") {
        Files files = references(symbol.name);
        for (const Source& source : sources_)
            if (countOf(source.allWords, symbol.name))
                files.emplace(source.path, 1);
        return files;
    }
    if (symbol.kind == "enumerator" || symbol.kind == "macro" || symbol.kind == "utility function")
        return references(symbol.name);
    if (symbol.name.ends_with("::pad")) // there to be ignored; its offset is checked
        return headers;
    if (symbol.kind.ends_with("field"))
        return field(symbol);
    Files files = references(symbol.name);
    if (symbol.kind == "enum" || symbol.kind.ends_with("struct"))
        files.merge(members(symbol));
    else if (files.empty()) // names, values, sizes and signatures: the generated header checks
        files = headers;
    return files;
}

std::set<std::string> Evidence::resultsOf(const std::string& function) const {
    auto found = results_.find(function);
    return found == results_.end() ? std::set<std::string>{} : found->second;
}

} // namespace coverage
