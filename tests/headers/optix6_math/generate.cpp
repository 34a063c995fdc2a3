// SPDX-License-Identifier: Apache-2.0
// Turns the table of the classic API's mathematics (symbols.tsv) into checks.inc, which compiles
// only if the headers agree with it, host_checks.inc, the same for stream operators, calls.inc, a
// call of each function, and cases.inc, the names and signatures of these calls.
//
// A row is: kind, symbol, type or signature. A template's row has the signature of one instance.
// Usage: generate TABLE OUTPUT_FOLDER. Fails if a kind is unknown or rows of a kind are missing.
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <string>
#include <vector>

namespace {

struct Row {
    std::string kind, symbol, type;
};

// Number of rows of each kind: a table that lost rows must not pass.
const std::map<std::string, int> kExpected = {
    {"function", 478},     {"template", 18}, {"stream", 21},      {"member", 57},
    {"static member", 10}, {"field", 11},    {"constructor", 19}, {"size", 6},
    {"type", 68},          {"macro", 9},     {"ray function", 1}};

[[noreturn]] void fail(const std::string& text) {
    std::cerr << "generate: " << text << "\n";
    std::exit(1);
}

std::vector<Row> readTable(const char* path) {
    std::ifstream file(path);
    if (!file)
        fail(std::string("cannot read ") + path);
    std::vector<Row> rows;
    std::map<std::string, int> counts;
    for (std::string line; std::getline(file, line);) {
        const size_t first = line.find('\t'), second = line.find('\t', first + 1);
        if (first == std::string::npos || second == std::string::npos)
            fail("row with a wrong number of columns: " + line);
        rows.push_back({line.substr(0, first), line.substr(first + 1, second - first - 1),
                        line.substr(second + 1)});
        ++counts[rows.back().kind];
    }
    if (counts != kExpected) {
        for (const auto& [kind, count] : counts)
            std::cerr << kind << ": " << count << " rows\n";
        fail("rows are missing, doubled or of an unknown kind");
    }
    return rows;
}

// The parts of "R(A, B)"; commas inside <> do not separate.
std::vector<std::string> parameters(const std::string& signature) {
    std::vector<std::string> parts;
    int depth = 0;
    for (size_t i = signature.find('(') + 1; i < signature.rfind(')'); ++i) {
        const char c = signature[i];
        depth += c == '<' ? 1 : c == '>' ? -1 : 0;
        if (parts.empty() || (c == ',' && depth == 0))
            parts.emplace_back();
        if (!(c == ',' && depth == 0) && !(c == ' ' && parts.back().empty()))
            parts.back() += c;
    }
    return parts;
}

// "R(A) const" and "C::" to "R (C::*)(A) const".
std::string pointer(const std::string& signature, const std::string& scope = "") {
    const size_t open = signature.find('(');
    return signature.substr(0, open) + " (" + scope + "*)" + signature.substr(open);
}

std::string sameType(const std::string& what, const std::string& type, const Row& row) {
    return "static_assert(SameType<" + what + ", " + type + ">::value, \"" + row.symbol + " " +
           row.type + "\");\n";
}

std::string castCheck(const std::string& name, const std::string& type, const Row& row) {
    return sameType("decltype(static_cast<" + type + ">(" + name + "))", type, row);
}

std::string constructorCheck(const Row& row) {
    std::string values;
    for (const std::string& type : parameters(row.type))
        values += (values.empty() ? "" : ", ") + ("value<" + type + ">()");
    return sameType("decltype(" + row.symbol + "(" + values + "))", row.symbol, row);
}

std::string check(const Row& row) {
    const std::string scope = row.symbol.substr(0, row.symbol.rfind("::") + 2);
    if (row.kind == "function" || row.kind == "template" || row.kind == "ray function" ||
        row.kind == "stream")
        return castCheck("optix::" + row.symbol, pointer(row.type), row);
    if (row.kind == "member")
        return castCheck("&" + row.symbol, pointer(row.type, scope), row);
    if (row.kind == "static member")
        return castCheck("&" + row.symbol, pointer(row.type), row);
    if (row.kind == "constructor")
        return constructorCheck(row);
    if (row.kind == "field")
        return sameType("decltype(" + row.symbol + ")", row.type, row);
    if (row.kind == "type")
        return sameType(row.symbol, row.type, row);
    if (row.kind == "size")
        return "static_assert(sizeof(" + row.symbol + ") == " + row.type + ", \"size of " +
               row.symbol + "\");\n";
    return "#ifndef " + row.symbol + "\n#error " + row.symbol + " is missing\n#endif\n";
}

// Reads arguments, calls, writes the result and what the function changed.
std::string call(const Row& row, int index) {
    std::string text = "case " + std::to_string(index) + ": {\n", arguments, after;
    int count = 0;
    for (const std::string& parameter : parameters(row.type)) {
        const std::string name = "a" + std::to_string(count++);
        std::string type = parameter;
        const bool constant = type.compare(0, 6, "const ") == 0, reference = type.back() == '&';
        if (constant)
            type.erase(0, 6);
        if (reference)
            type.pop_back();
        text += "    " + type + " " + name + ";\n    read(in, " + name + ");\n";
        if (reference && !constant)
            after += "    write(out, " + name + ");\n";
        arguments += (arguments.empty() ? "" : ", ") + name;
    }
    const std::string expression = "optix::" + row.symbol + "(" + arguments + ")";
    const bool returns = row.type.compare(0, 5, "void(") != 0;
    text += "    " + (returns ? "write(out, " + expression + ")" : expression) + ";\n";
    return text + after + "    break;\n}\n";
}

void write(const std::string& path, const std::string& text) {
    std::ofstream file(path);
    file << "// Generated by generate.cpp; do not edit.\n" << text;
    if (!file.flush())
        fail("cannot write " + path);
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 3)
        fail("usage: generate TABLE OUTPUT_FOLDER");
    std::string checks, hostChecks, calls, cases;
    int index = 0;
    for (const Row& row : readTable(argv[1])) {
        (row.kind == "stream" ? hostChecks : checks) += check(row);
        if (row.kind != "function" && row.kind != "template")
            continue;
        calls += call(row, index++);
        cases += "{\"" + row.symbol + "\", \"" + row.type + "\"},\n";
    }
    const std::string folder = std::string(argv[2]) + "/";
    write(folder + "checks.inc", checks);
    write(folder + "host_checks.inc", hostChecks);
    write(folder + "calls.inc", calls);
    write(folder + "cases.inc", cases);
}
