// SPDX-License-Identifier: Apache-2.0
// Reads the PTX of device_checks.cu and compares the `_optix_*` calls of each kernel
// call_<function>__<overload> with the table optix7_intrinsics.tsv, in both directions: names,
// number and types of results and operands, and operands that must be constants.
//
// A row is: function (with /overload where they differ), intrinsic, results, operands, constants.
// Types: r 32-bit, l 64-bit, f float, one letter each, "-" for none. Constants: position=value,...
// Usage: check_calls TABLE... PTX
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

int gErrors = 0;

void error(const std::string& text) {
    std::cerr << "error: " << text << "\n";
    ++gErrors;
}

struct Call {
    std::string intrinsic;
    std::string results;                  // one letter each
    std::string operands;                 // one letter each
    std::map<int, std::string> constants; // operands whose value is known, by position
};

std::string readFile(const char* path) {
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    if (!file || text.str().empty()) {
        std::cerr << "cannot read " << path << "\n";
        std::exit(1);
    }
    return text.str();
}

std::vector<std::string> listOf(const std::string& text) {
    std::vector<std::string> names;
    static const std::regex kName("[^\\s,]+");
    for (std::sregex_iterator it(text.begin(), text.end(), kName), end; it != end; ++it)
        names.push_back(it->str());
    return names;
}

// The body of one kernel.
class Body {
public:
    explicit Body(const std::string& text) : text_(text) {
        static const std::regex kRegisters(R"(\.reg\s+\.(\w+)\s+(%\w+?)<\d+>)");
        for (std::sregex_iterator it(text.begin(), text.end(), kRegisters), end; it != end; ++it)
            types_[(*it)[2]] = letter((*it)[1]);
        static const std::regex kMove(R"(mov\.[bu]32\s+(%\w+),\s*(-?\d+);)");
        for (std::sregex_iterator it(text.begin(), text.end(), kMove), end; it != end; ++it)
            values_[(*it)[1]] = (*it)[2];
    }

    std::vector<Call> calls() const {
        static const std::regex kCall(
            R"(call\s*(?:\(([^()]*)\)\s*,\s*)?(_optix_\w+)\s*,\s*\(([^()]*)\)\s*;)");
        std::vector<Call> calls;
        for (std::sregex_iterator it(text_.begin(), text_.end(), kCall), end; it != end; ++it) {
            Call call;
            call.intrinsic = (*it)[2];
            for (const std::string& name : listOf((*it)[1]))
                call.results += typeOf(name);
            for (const std::string& name : listOf((*it)[3])) {
                const auto value = values_.find(name);
                if (value != values_.end())
                    call.constants[int(call.operands.size())] = value->second;
                else if (name[0] != '%')
                    call.constants[int(call.operands.size())] = name;
                call.operands += typeOf(name);
            }
            calls.push_back(call);
        }
        return calls;
    }

private:
    static char letter(const std::string& type) {
        if (type == "b32" || type == "u32" || type == "s32")
            return 'r';
        if (type == "b64" || type == "u64" || type == "s64")
            return 'l';
        return type == "f32" ? 'f' : '?';
    }
    char typeOf(const std::string& name) const {
        const size_t digits = name.find_last_not_of("0123456789") + 1;
        const auto type = types_.find(name.substr(0, digits));
        return type == types_.end() ? 'r' : type->second; // a literal is a 32-bit constant
    }

    const std::string& text_;
    std::map<std::string, char> types_;         // by register prefix
    std::map<std::string, std::string> values_; // registers set by a plain move
};

std::map<std::string, std::string> kernelsOf(const std::string& ptx) {
    static const std::regex kEntry(R"(\.entry\s+call_(\w+)\()");
    std::map<std::string, std::string> kernels;
    for (std::sregex_iterator it(ptx.begin(), ptx.end(), kEntry), end; it != end; ++it) {
        const size_t start = size_t(it->position());
        const size_t stop = ptx.find(".entry", start + 6);
        kernels[(*it)[1]] = ptx.substr(start, stop == std::string::npos ? stop : stop - start);
    }
    return kernels;
}

using Table = std::map<std::string, std::vector<Call>>;

void readTable(const char* path, Table& table) {
    std::istringstream text(readFile(path));
    for (std::string function, intrinsic, results, operands, constants;
         text >> function >> intrinsic >> results >> operands >> constants;) {
        Call call{intrinsic, results == "-" ? "" : results, operands == "-" ? "" : operands, {}};
        for (const std::string& pair : listOf(constants == "-" ? "" : constants))
            call.constants[std::stoi(pair)] = pair.substr(pair.find('=') + 1);
        table[function].push_back(call);
    }
}

void compare(const std::string& kernel, const Call& expected, const Call& call) {
    if (call.results != expected.results || call.operands != expected.operands)
        error(kernel + ": " + call.intrinsic + " has (" + call.results + ") <- (" + call.operands +
              "), expected (" + expected.results + ") <- (" + expected.operands + ")");
    for (const auto& [position, value] : expected.constants)
        if (!call.constants.count(position) || call.constants.at(position) != value)
            error(kernel + ": operand " + std::to_string(position) + " of " + call.intrinsic +
                  " is not the constant " + value);
}

void checkKernel(const std::string& kernel, const std::vector<Call>& expected,
                 const std::string& text) {
    std::set<std::string> seen;
    for (const Call& call : Body(text).calls()) {
        const Call* row = nullptr;
        for (const Call& candidate : expected)
            if (candidate.intrinsic == call.intrinsic)
                row = &candidate;
        if (!row) {
            error(kernel + ": calls " + call.intrinsic);
            continue;
        }
        seen.insert(call.intrinsic);
        compare(kernel, *row, call);
    }
    for (const Call& row : expected)
        if (!seen.count(row.intrinsic))
            error(kernel + ": does not call " + row.intrinsic);
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 3) {
        std::cerr << "usage: check_calls TABLE... PTX\n";
        return 2;
    }
    Table table;
    for (int i = 1; i < argc - 1; ++i)
        readTable(argv[i], table);
    if (table.size() < 235)
        error("rows of the table are missing");
    const std::string ptx = readFile(argv[argc - 1]);
    std::set<std::string> used;
    int checked = 0;
    for (const auto& [kernel, text] : kernelsOf(ptx)) {
        static const std::regex kParts("(\\w+)__(\\d+)");
        std::smatch parts;
        if (!std::regex_match(kernel, parts, kParts))
            continue; // forms of calls that only have to compile
        std::string function = parts[1];
        if (!table.count(function))
            function += "/" + parts[2].str();
        if (!table.count(function)) {
            error(kernel + " is not in the table");
            continue;
        }
        used.insert(function);
        checkKernel(kernel, table.at(function), text);
        ++checked;
    }
    for (const auto& [function, calls] : table)
        if (!used.count(function))
            error("no kernel for " + function);
    std::cout << checked << " kernels checked, " << gErrors << " errors\n";
    return gErrors == 0 && checked >= int(table.size()) ? 0 : 1;
}
