// SPDX-License-Identifier: Apache-2.0
#include "recording.h"

#include <zstd.h>

#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace differential {
namespace {

bool isCompressed(const std::string& path) {
    return path.size() > 4 && path.compare(path.size() - 4, 4, ".zst") == 0;
}

// Bytes of all rays at one offset are adjacent: they are similar and compress better.
std::string planes(const std::vector<Seen>& seen) {
    std::string out(seen.size() * sizeof(Seen), '\0');
    const auto* bytes = reinterpret_cast<const char*>(seen.data());
    for (size_t i = 0; i < seen.size(); ++i)
        for (size_t k = 0; k < sizeof(Seen); ++k)
            out[k * seen.size() + i] = bytes[i * sizeof(Seen) + k];
    return out;
}

std::vector<Seen> unpack(const std::string& planes) {
    std::vector<Seen> seen(planes.size() / sizeof(Seen));
    auto* bytes = reinterpret_cast<char*>(seen.data());
    for (size_t i = 0; i < seen.size(); ++i)
        for (size_t k = 0; k < sizeof(Seen); ++k)
            bytes[i * sizeof(Seen) + k] = planes[k * seen.size() + i];
    return seen;
}

std::string compress(const std::string& bytes) {
    std::string out(ZSTD_compressBound(bytes.size()), '\0');
    out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 19));
    return out;
}

std::string decompress(const std::string& bytes, const std::string& path) {
    const auto size = ZSTD_getFrameContentSize(bytes.data(), bytes.size());
    if (size > (1u << 28))
        throw std::runtime_error(path + " is no compressed recording");
    std::string out(size, '\0');
    if (ZSTD_decompress(out.data(), out.size(), bytes.data(), bytes.size()) != size)
        throw std::runtime_error(path + " is damaged");
    return out;
}

} // namespace

void write(const std::string& path, const std::vector<Answer>& answers) {
    std::string bytes;
    for (const Answer& a : answers) {
        const std::string body = a.text.empty() ? planes(a.seen) : a.text;
        std::string state = a.state;
        for (char& c : state)
            if (c == '\n' || c == '\t')
                c = ' ';
        bytes += a.name + '\t' + state + '\t' + (a.text.empty() ? "rays" : "text") + '\t' +
                 std::to_string(body.size()) + '\n' + body;
    }
    if (isCompressed(path))
        bytes = compress(bytes);
    std::ofstream file(path, std::ios::binary);
    if (!file.write(bytes.data(), std::streamsize(bytes.size())))
        throw std::runtime_error("cannot write " + path);
}

std::vector<Answer> read(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::stringstream content;
    content << file.rdbuf();
    if (!file)
        throw std::runtime_error("cannot read " + path);
    std::istringstream in(isCompressed(path) ? decompress(content.str(), path) : content.str());
    std::vector<Answer> answers;
    for (std::string line; std::getline(in, line);) {
        std::istringstream fields(line);
        Answer a;
        std::string kind, size;
        std::getline(fields, a.name, '\t');
        std::getline(fields, a.state, '\t');
        std::getline(fields, kind, '\t');
        std::getline(fields, size);
        if (size.empty() || size.size() > 9 || size.find_first_not_of("0123456789") != size.npos)
            throw std::runtime_error(path + " is no recording");
        std::string body(std::stoul(size), '\0');
        if (!in.read(body.data(), std::streamsize(body.size())))
            throw std::runtime_error(path + " ends early");
        if (kind == "rays")
            a.seen = unpack(body);
        else
            a.text = body;
        answers.push_back(std::move(a));
    }
    return answers;
}

} // namespace differential
