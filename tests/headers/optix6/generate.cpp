// SPDX-License-Identifier: Apache-2.0
// Turns the table of the classic API (symbols.tsv) into host_checks.inc and device_checks.inc,
// which compile only if the headers have each name, with its value, size or offset.
// exports_test.cpp reads the rows of exported functions itself.
//
// A row is: kind, symbol, number or remark. Usage: generate TABLE OUTPUT_FOLDER. Fails if a kind is
// unknown, or if rows of a kind are missing.
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <string>
#include <vector>

namespace {

// A table that lost rows must not pass. Rows of kind "absent" give the reason in the third column.
const std::map<std::string, int> kExpected = {
    {"absent", 668},      {"acceleration", 7},   {"builder", 7},         {"device field", 2},
    {"device macro", 16}, {"device member", 15}, {"device name", 72},    {"device type", 55},
    {"device value", 14}, {"field", 11},         {"function", 424},      {"macro", 19},
    {"member", 638},      {"name", 64},          {"prime function", 35}, {"rtu function", 20},
    {"text", 10},         {"type", 138},         {"value", 288}};

[[noreturn]] void fail(const std::string& text) {
    std::cerr << "generate: " << text << "\n";
    std::exit(1);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    for (size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
        text.replace(at, from.size(), to);
    return text;
}

// A class template with arguments: the name ends there or at "::".
std::string concrete(std::string name) {
    static const std::map<std::string, std::string> arguments = {
        {"optix::Handle", "<optix::BufferObj>"},
        {"optix::prime::Handle", "<optix::prime::ModelObj>"},
        {"optix::Matrix", "<3, 3>"},
        {"optix::VectorDim", "<3>"},
        {"optix::VectorTypes", "<int, 1>"},
        {"optix::buffer", "<float, 2>"},
        {"optix::bufferId", "<float, 2>"},
        {"optix::callableProgramId", "<int(int)>"},
        {"optix::boundCallableProgramId", "<int(int)>"},
        {"optix::markedCallableProgramId", "<int(int)>"},
        {"rtCallableProgramSizeofWrapper", "<int>"},
        {"rti_internal_typeinfo::rti_typeenum", "<int>"}};
    name = replaced(name, "<T,Dim>", "<int,1>");
    name = replaced(name, "<T2>", "");
    name = replaced(name, "<DIM>", "<2>");
    name = replaced(name, "<T>>", "<int(int)>>");
    for (const auto& [what, list] : arguments)
        if (name == what || name.starts_with(what + "::"))
            name.insert(what.size(), list);
    return replaced(name, "::type", "::template type<int>");
}

// The check of one row; empty if a compiler cannot make it.
std::string check(std::string kind, const std::string& symbol, const std::string& detail,
                  int line) {
    if (kind.starts_with("device "))
        kind.erase(0, 7);
    const std::string id = std::to_string(line);
    const std::string name = concrete(symbol);
    const size_t colons = symbol.rfind("::");
    const std::string last = colons == std::string::npos ? symbol : symbol.substr(colons + 2);
    const std::string owner = colons == std::string::npos ? "" : concrete(symbol.substr(0, colons));
    if (kind == "value")
        return "static_assert(static_cast<long long>(" + symbol + ") == static_cast<long long>(" +
               detail + "), \"\");";
    if (kind == "type") {
        const std::string size =
            detail.empty() ? "" : " static_assert(sizeof(Type" + id + ") == " + detail + ", \"\");";
        return "typedef " + name + " Type" + id + ";" + size;
    }
    if (kind == "field")
        return "static_assert(__builtin_offsetof(" + owner + ", " + last + ") == " + detail +
               ", \"\");";
    if (kind == "member") {
        const std::string plain = owner.substr(0, owner.find('<'));
        const size_t begin = plain.rfind("::");
        const std::string own = begin == std::string::npos ? plain : plain.substr(begin + 2);
        if (last == own || last[0] == '~')
            return "static_assert(sizeof(" + owner + ") != 0, \"\");";
        return "struct Member" + id + " : " + owner + " { using " + owner + "::" + last +
               "; ~Member" + id + "(); };";
    }
    if (kind == "macro")
        return "#ifndef " + symbol + "\n#error " + symbol + "\n#endif";
    if (kind == "name" || kind == "function" || kind == "prime function" || kind == "rtu function")
        return "namespace name" + id + " { using ::" + symbol + "; }";
    if (kind == "text" || kind == "acceleration" || kind == "builder" || kind == "absent")
        return "";
    fail("unknown kind " + kind);
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 3)
        fail("usage: generate TABLE OUTPUT_FOLDER");
    std::ifstream table(argv[1]);
    std::ofstream host(std::string(argv[2]) + "/host_checks.inc");
    std::ofstream device(std::string(argv[2]) + "/device_checks.inc");
    std::map<std::string, int> counts;
    int line = 0;
    for (std::string row; std::getline(table, row);) {
        ++line;
        const size_t first = row.find('\t'), second = row.find('\t', first + 1);
        if (second == std::string::npos)
            fail("row with a wrong number of columns: " + row);
        const std::string kind = row.substr(0, first);
        const std::string symbol = row.substr(first + 1, second - first - 1);
        ++counts[kind];
        const std::string text = check(kind, symbol, row.substr(second + 1), line);
        if (!text.empty())
            (kind.starts_with("device ") ? device : host) << text << "\n";
    }
    for (const auto& [kind, count] : counts) {
        const auto wanted = kExpected.find(kind);
        if (wanted == kExpected.end() || wanted->second != count)
            fail(std::to_string(count) + " rows of kind " + kind);
    }
    if (counts.size() != kExpected.size())
        fail("a kind has no rows");
    if (!host.flush() || !device.flush())
        fail("cannot write the checks");
}
