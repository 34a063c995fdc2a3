// SPDX-License-Identifier: Apache-2.0
// sunstone_fatbin IN.ptx... OUT.fatbin: wraps PTX texts, one per architecture, in the container
// that clang embeds in host code with -fcuda-include-gpubinary. driver/modules/fat_binary.h
// describes the layout.
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>

namespace {

struct Header {
    uint32_t magic = 0xBA55ED50;
    uint16_t version = 1, headerSize = 16;
    uint64_t size = 0;
};
struct Entry {
    uint16_t kind = 1, version = 0x0101;
    uint32_t headerSize = 80;
    uint64_t payloadSize = 0;
    uint32_t compressedSize = 0, optionsOffset = 64;
    uint16_t minor = 0, major = 0;
    uint32_t architecture = 0, nameOffset = 0, nameLength = 0;
    uint64_t flags = 0x11, reserved = 0, uncompressedSize = 0; // 64-bit, Linux
    uint32_t optionTextOffset = 72, optionTextLength = 0;      // no options
    uint64_t noText = 0;
};
static_assert(sizeof(Header) == 16 && sizeof(Entry) == 80);

// Appends an entry with the PTX of a file; false if the file is not readable PTX.
bool append(std::string& entries, const char* path) {
    std::ifstream in(path, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    if (!in || text.find(".version") == std::string::npos) {
        std::fprintf(stderr, "sunstone_fatbin: %s is not readable PTX\n", path);
        return false;
    }
    Entry entry;
    if (size_t target = text.find(".target sm_"); target != std::string::npos)
        entry.architecture = uint32_t(std::atoi(text.c_str() + target + 11));
    if (size_t version = text.find(".version "); version != std::string::npos)
        std::sscanf(text.c_str() + version, ".version %hu.%hu", &entry.major, &entry.minor);
    text.resize((text.size() + 8) / 8 * 8, '\0'); // at least one NUL ends it
    entry.payloadSize = text.size();
    entries.append(reinterpret_cast<const char*>(&entry), sizeof entry);
    entries += text;
    return true;
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 3) {
        std::fprintf(stderr, "usage: %s IN.ptx... OUT.fatbin\n", argv[0]);
        return 1;
    }
    std::string entries;
    for (int i = 1; i + 1 < argc; ++i)
        if (!append(entries, argv[i]))
            return 1;
    Header header;
    header.size = entries.size();
    std::ofstream out(argv[argc - 1], std::ios::binary);
    out.write(reinterpret_cast<const char*>(&header), sizeof header);
    out.write(entries.data(), std::streamsize(entries.size()));
    out.close();
    if (!out) {
        std::fprintf(stderr, "%s: cannot write %s\n", argv[0], argv[argc - 1]);
        return 1;
    }
    return 0;
}
