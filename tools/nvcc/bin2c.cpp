// SPDX-License-Identifier: Apache-2.0
// See bin2c.h.
#include "bin2c.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace sunstone::nvcc {

namespace {

constexpr const char* kHelp =
    "Usage: bin2c [options] FILE\n\n"
    "Prints the definition of a C array with the bytes of FILE.\n\n"
    "  -n, --name NAME   name of the array; imageBytes without it\n"
    "  -t, --type TYPE   char (default), short, int or longlong; the last element is padded with 0\n"
    "  -p, --padd N,...  values behind the bytes of the file\n"
    "  -c, --const       the array is const\n"
    "  -st, --static     the array is static\n"
    "  -s, --size        also define NAME_size or, without a name, imageBytesSize\n"
    "  -o FILE           write to FILE in place of standard output";

[[noreturn]] void refuse(const std::string& text) {
    throw std::runtime_error("bin2c fatal   : " + text);
}

struct Request {
    std::string name, type = "char", input, output;
    std::vector<std::string> padding;
    bool isConst = false, isStatic = false, hasSize = false, needsHelp = false;
};

void addPadding(Request& request, const std::string& values) {
    for (size_t begin = 0; begin <= values.size();) {
        const size_t end = std::min(values.find(',', begin), values.size());
        const std::string value = values.substr(begin, end - begin);
        char* rest = nullptr;
        std::strtoll(value.c_str(), &rest, 0);
        if (value.empty() || *rest != 0)
            refuse("--padd: '" + value + "' is no number");
        request.padding.push_back(value);
        begin = end + 1;
    }
}

Request parse(const std::vector<std::string>& words) {
    Request request;
    for (size_t i = 0; i < words.size(); ++i) {
        std::string word = words[i], value;
        if (word.empty() || word[0] != '-') {
            request.input = word;
            continue;
        }
        const size_t equals = word.find('=');
        const auto takeValue = [&] {
            if (equals != std::string::npos)
                return words[i].substr(equals + 1);
            if (i + 1 == words.size())
                refuse("Missing value for option '" + word + "'");
            return words[++i];
        };
        word = word.substr(0, equals);
        if (word == "-n" || word == "--name")
            request.name = takeValue();
        else if (word == "-t" || word == "--type")
            request.type = takeValue();
        else if (word == "-p" || word == "--padd")
            addPadding(request, takeValue());
        else if (word == "-o")
            request.output = takeValue();
        else if (word == "-c" || word == "--const")
            request.isConst = true;
        else if (word == "-st" || word == "--static")
            request.isStatic = true;
        else if (word == "-s" || word == "--size")
            request.hasSize = true;
        else if (word == "-h" || word == "--help")
            request.needsHelp = true;
        else
            refuse("Unknown option '" + words[i] + "'");
    }
    return request;
}

struct ElementType {
    const char *name, *spelling, *suffix;
    size_t bytes;
};
constexpr ElementType kTypes[] = {{"char", "unsigned char", "", 1},
                                  {"short", "unsigned short", "", 2},
                                  {"int", "unsigned int", "u", 4},
                                  {"longlong", "unsigned long long", "ull", 8}};

const ElementType& typeOf(const Request& request) {
    const auto found = std::find_if(std::begin(kTypes), std::end(kTypes), [&](const auto& type) {
        return request.type == type.name;
    });
    if (found == std::end(kTypes))
        refuse("--type " + request.type + " is none of char, short, int and longlong");
    return *found;
}

std::string elementsOf(const std::string& bytes, const ElementType& type, size_t& count) {
    std::string text;
    for (size_t i = 0; i < bytes.size(); i += type.bytes) {
        uint64_t value = 0;
        for (size_t k = 0; k < type.bytes && i + k < bytes.size(); ++k)
            value |= uint64_t(uint8_t(bytes[i + k])) << 8 * k;
        char word[32];
        std::snprintf(word, sizeof word, "0x%0*llx%s,", int(2 * type.bytes),
                      static_cast<unsigned long long>(value), type.suffix);
        text += word;
        if (++count % (32 / type.bytes) == 0)
            text += '\n';
    }
    return text;
}

std::string definitionOf(const Request& request, const std::string& bytes) {
    const ElementType& type = typeOf(request);
    const std::string name = request.name.empty() ? "imageBytes" : request.name;
    const std::string storage =
        std::string(request.isStatic ? "static " : "") + (request.isConst ? "const " : "");
    size_t count = 0;
    std::string text = "#ifdef __cplusplus\nextern \"C\" {\n#endif\n\n" + storage + type.spelling +
                       " " + name + "[] = {\n" + elementsOf(bytes, type, count);
    for (const std::string& value : request.padding)
        text += value + ",";
    if (count + request.padding.size() == 0)
        text += "0";
    text += "\n};\n";
    if (request.hasSize)
        text += storage + "unsigned long long " + name +
                (request.name.empty() ? "Size" : "_size") + " = " + std::to_string(bytes.size()) +
                ";\n";
    return text + "\n#ifdef __cplusplus\n}\n#endif\n";
}

} // namespace

int runBin2c(const std::vector<std::string>& words) {
    const Request request = parse(words);
    if (request.needsHelp)
        return std::puts(kHelp), 0;
    if (request.input.empty())
        refuse("No input file; try --help");
    std::ifstream in(request.input, std::ios::binary);
    if (!in)
        refuse("Could not open input file '" + request.input + "'");
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    const std::string text = definitionOf(request, bytes);
    if (request.output.empty())
        return std::fwrite(text.data(), 1, text.size(), stdout) == text.size() ? 0 : 1;
    std::ofstream out(request.output, std::ios::binary);
    if (!(out << text).flush())
        refuse("Could not write '" + request.output + "'");
    return 0;
}

} // namespace sunstone::nvcc
