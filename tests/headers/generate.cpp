// SPDX-License-Identifier: Apache-2.0
// Turns the table of API facts (optix7_symbols.tsv) into source files that compile only if the
// headers agree with it: host_checks.inc (C++11), host_checks_c.inc (C99), device_checks.inc and
// device_calls.inc (one kernel for each device function, whose PTX check_calls.cpp examines).
//
// A row is: kind, symbol, number (value, size, offset or slot), type or signature.
// Usage: generate TABLE OUTPUT_FOLDER [CHANGES]. Fails if a kind is unknown or rows of a kind are
// missing. CHANGES (optix76_changes.tsv) makes the table of a later version: a row replaces that of
// the same kind and symbol, or is new; one that begins with "-" takes a symbol away.
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <string>
#include <vector>

namespace {

using Row = std::vector<std::string>;

using Counts = std::map<std::string, int>;

// Number of rows of each kind: a table that lost rows must not pass.
const Counts kExpected74 = {{"enum", 33},
                            {"enumerator", 214},
                            {"struct", 36},
                            {"field", 191},
                            {"utility struct", 1},
                            {"utility field", 4},
                            {"device struct", 2},
                            {"device field", 9},
                            {"typedef", 11},
                            {"macro", 11},
                            {"host macro", 1},
                            {"device macro", 2},
                            {"transient macro", 4},
                            {"windows macro", 1},
                            {"windows function", 2},
                            {"host function", 41},
                            {"table", 1},
                            {"table slot", 43},
                            {"variable", 1},
                            {"utility function", 11},
                            {"device function", 233},
                            {"device template", 2},
                            {"device helper", 25}};

// Additions and removals of 7.6.
const Counts kMoreIn76 = {{"enum", 4},       {"enumerator", 25},    {"struct", 12},
                          {"field", 59},     {"macro", 11},         {"host function", 4},
                          {"table slot", 4}, {"device function", 1}};

[[noreturn]] void fail(const std::string& text) {
    std::cerr << "generate: " << text << "\n";
    std::exit(1);
}

std::vector<std::string> split(const std::string& text, char separator) {
    std::vector<std::string> parts(1);
    for (char c : text) {
        if (c == separator)
            parts.emplace_back();
        else
            parts.back() += c;
    }
    return parts;
}

std::vector<Row> readRows(const char* path) {
    std::ifstream file(path);
    if (!file)
        fail(std::string("cannot read ") + path);
    std::vector<Row> rows;
    for (std::string line; std::getline(file, line);) {
        rows.push_back(split(line, '\t'));
        if (rows.back().size() != (rows.back()[0] == "-" ? 3 : 4))
            fail("row with a wrong number of columns: " + line);
    }
    return rows;
}

void change(std::vector<Row>& rows, const Row& change) {
    const bool removes = change[0] == "-";
    const std::string& kind = change[removes ? 1 : 0];
    const std::string& name = change[removes ? 2 : 1];
    const auto found = std::find_if(
        rows.begin(), rows.end(), [&](const Row& row) { return row[0] == kind && row[1] == name; });
    if (removes && found == rows.end())
        fail("nothing to take away: " + name);
    if (removes)
        rows.erase(found);
    else if (found != rows.end())
        *found = change;
    else
        rows.push_back(change);
}

std::vector<Row> readTable(const char* path, const char* changes) {
    std::vector<Row> rows = readRows(path);
    Counts expected = kExpected74, counts;
    if (changes) {
        for (const Row& row : readRows(changes))
            change(rows, row);
        for (const auto& [kind, more] : kMoreIn76)
            expected[kind] += more;
    }
    for (const Row& row : rows)
        ++counts[row[0]];
    if (counts != expected) {
        for (const auto& [kind, count] : counts)
            if (!expected.count(kind) || expected.at(kind) != count)
                std::cerr << kind << ": " << count << " rows\n";
        fail("rows are missing, doubled or of an unknown kind");
    }
    return rows;
}

// "R(A, B)" to "R (*)(A, B)".
std::string pointerTo(const std::string& signature) {
    const size_t open = signature.find('(');
    return signature.substr(0, open) + " (*)" + signature.substr(open);
}

std::string sameType(const std::string& what, const std::string& type, const std::string& name) {
    return "static_assert(SameType<" + what + ", " + type + ">::value, \"type of " + name +
           "\");\n";
}

std::string equal(const std::string& left, const std::string& right, const std::string& name) {
    return "static_assert(" + left + " == " + right + ", \"" + name + "\");\n";
}

// Types that appear in the headers for host and device alike.
std::string typeCheck(const Row& row) {
    const std::string &kind = row[0], &name = row[1], &number = row[2], &type = row[3];
    if (kind == "enum")
        return equal("sizeof(" + name + ")", number, name);
    if (kind == "enumerator")
        return equal("static_cast<unsigned int>(" + name + ")",
                     "static_cast<unsigned int>(" + number + ")", name) +
               sameType("decltype(" + name + ")", type, name);
    if (kind == "struct" || kind == "utility struct" || kind == "device struct" || kind == "table")
        return equal("sizeof(" + name + ")", number, name);
    if (kind == "field" || kind == "utility field" || kind == "device field") {
        const size_t colons = name.find("::");
        const std::string owner = name.substr(0, colons), member = name.substr(colons + 2);
        const size_t bracket = type.find('[');
        const std::string array = bracket == std::string::npos ? "" : type.substr(bracket);
        return "CHECK_OFFSET(" + owner + ", " + member + ", " + number + ")\n" + "typedef " +
               type.substr(0, bracket) + " Type_" + owner + "_" + member + array + ";\n" +
               sameType("decltype(" + name + ")", "Type_" + owner + "_" + member, name);
    }
    if (kind == "typedef") {
        std::string check = sameType(name, type, name);
        return number.empty() ? check : check + equal("sizeof(" + name + ")", number, name);
    }
    if (kind == "macro")
        return equal(name, number, name);
    if (kind == "transient macro")
        return "#ifdef " + name + "\n#error " + name + " is left defined\n#endif\n";
    return "";
}

std::string hostCheck(const Row& row) {
    const std::string &kind = row[0], &name = row[1], &number = row[2], &type = row[3];
    if (kind == "host macro")
        return equal(name, number, name);
    if (kind == "windows macro")
        return "#ifdef _WIN32\n" + equal(name, number, name) + "#endif\n";
    if (kind == "windows function")
        return "#ifdef _WIN32\n" + sameType("decltype(&" + name + ")", pointerTo(type), name) +
               "#endif\n";
    if (kind == "variable")
        return sameType("decltype(" + name + ")", type, name);
    if (kind == "table slot")
        return "CHECK_OFFSET(OptixFunctionTable, " + name + ", " + number + " * sizeof(void*))\n" +
               sameType("decltype(OptixFunctionTable::" + name + ")", pointerTo(type), name);
    if (kind == "host function" || kind == "utility function")
        return sameType("decltype(&" + name + ")", pointerTo(type), name);
    if (kind.compare(0, 6, "device") == 0)
        return "";
    return typeCheck(row);
}

// C99 has neither static_assert nor decltype: an array of negative size makes the error.
std::string cCheck(const Row& row, int index) {
    const std::string &kind = row[0], &name = row[1], &number = row[2];
    const auto check = [&](const std::string& condition) {
        return "typedef char check_" + std::to_string(index) + "[(" + condition +
               ") ? 1 : -1]; /* " + name + " */\n";
    };
    if (kind == "enum" || kind == "struct" || kind == "table")
        return check("sizeof(" + name + ") == " + number);
    if (kind == "enumerator")
        return check("(unsigned int)" + name + " == (unsigned int)(" + number + ")");
    if (kind == "macro" || kind == "host macro")
        return check(name + " == " + number);
    if (kind == "field") {
        const size_t colons = name.find("::");
        return check("offsetof(" + name.substr(0, colons) + ", " + name.substr(colons + 2) +
                     ") == " + number);
    }
    if (kind == "table slot")
        return check("offsetof(OptixFunctionTable, " + name + ") == " + number +
                     " * sizeof(void*)");
    return "";
}

std::string deviceCheck(const Row& row) {
    const std::string &kind = row[0], &name = row[1], &type = row[3];
    if (kind == "device macro")
        return "#ifndef " + name + "\n#error " + name + " is missing\n#endif\n";
    const std::string prefix = kind == "device helper" ? "optix_impl::" : "";
    if (kind == "device function" || kind == "device helper")
        return sameType("decltype(static_cast<" + pointerTo(type) + ">(" + prefix + name + "))",
                        pointerTo(type), name);
    if (kind == "device template")
        return sameType("decltype(&" + name + "<float, int, float3>)",
                        "float (*)(unsigned int, int, float3)", name);
    return typeCheck(row);
}

// One kernel that calls a device function: values come from kernel parameters, references are
// variables read from and written to memory, results are stored.
std::string kernel(const std::string& name, int overload, const std::string& type) {
    const size_t open = type.find('(');
    const std::string result = type.substr(0, open);
    const std::string list = type.substr(open + 1, type.size() - open - 2);
    std::string parameters, before, arguments, after;
    int index = 0;
    for (std::string part : list.empty() ? std::vector<std::string>() : split(list, ',')) {
        if (part[0] == ' ')
            part.erase(0, 1);
        const std::string variable = "a" + std::to_string(index++);
        if (part.back() == '&') {
            const std::string word = "words[" + std::to_string(index) + "]";
            before += "    unsigned int " + variable + " = " + word + ";\n";
            after += "    " + word + " = " + variable + ";\n";
        } else if (part == "OptixPayloadTypeID") {
            before += "    const OptixPayloadTypeID " + variable + " = OPTIX_PAYLOAD_TYPE_ID_2;\n";
        } else {
            parameters += ", " + part + " " + variable;
        }
        arguments += (index > 1 ? ", " : "") + variable;
    }
    const bool returns = result != "void";
    const std::string out = returns ? result + "* out" : "int* out";
    return "extern \"C\" __global__ void call_" + name + "__" + std::to_string(overload) + "(" +
           out + ", unsigned int* words" + parameters + ") {\n    (void)out;\n    (void)words;\n" +
           before + "    " + (returns ? "*out = " : "") + name + "(" + arguments + ");\n" + after +
           "}\n";
}

void write(const std::string& path, const std::string& text) {
    std::ofstream file(path);
    file << text;
    if (!file.flush())
        fail("cannot write " + path);
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 3 && argc != 4)
        fail("usage: generate TABLE OUTPUT_FOLDER [CHANGES]");
    const std::string head = "// Generated by generate.cpp; do not edit.\n";
    std::string host = head, c = "/* Generated by generate.cpp; do not edit. */\n";
    std::string device = head, calls = head, uses;
    std::map<std::string, int> overloads;
    int index = 0;
    for (const Row& row : readTable(argv[1], argc == 4 ? argv[3] : nullptr)) {
        host += hostCheck(row);
        c += cCheck(row, index++);
        if (row[0] != "utility struct" && row[0] != "utility field" && row[0] != "table")
            device += deviceCheck(row);
        if (row[0] == "device function")
            calls += kernel(row[1], overloads[row[1]]++, row[3]);
        if (row[0] == "host function" || row[0] == "utility function")
            uses += "    reinterpret_cast<Function>(&" + row[1] + "),\n";
    }
    host += "typedef void (*Function)();\nextern const Function kUsed[];\n"
            "const Function kUsed[] = {\n" +
            uses + "};\n";
    const std::string folder = std::string(argv[2]) + "/";
    write(folder + "host_checks.inc", host);
    write(folder + "host_checks_c.inc", c);
    write(folder + "device_checks.inc", device);
    write(folder + "device_calls.inc", calls);
}
