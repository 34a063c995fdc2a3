// SPDX-License-Identifier: Apache-2.0
#include "elf_needs.h"

#include <elf.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

namespace sunstone::tool {

namespace {

std::string findInPath(const std::string& command) {
    const char* const path = std::getenv("PATH");
    if (command.find('/') != std::string::npos || !path)
        return command;
    std::istringstream folders(path);
    for (std::string folder; std::getline(folders, folder, ':');) {
        std::error_code error;
        const auto file = std::filesystem::path(folder.empty() ? "." : folder) / command;
        if (std::filesystem::is_regular_file(file, error))
            return file.string();
    }
    return command;
}

class Image {
public:
    explicit Image(std::string bytes) : bytes_(std::move(bytes)) {}
    template <class T>
    bool read(uint64_t offset, T& value) const {
        if (offset > bytes_.size() || bytes_.size() - offset < sizeof value)
            return false;
        std::memcpy(&value, bytes_.data() + offset, sizeof value);
        return true;
    }
    std::string text(uint64_t offset) const {
        return offset < bytes_.size() ? std::string(bytes_.c_str() + offset) : std::string();
    }

private:
    std::string bytes_;
};

// The file offset of a run-time address; -1: none.
uint64_t offsetOf(const Image& image, const Elf64_Ehdr& header, uint64_t address) {
    Elf64_Phdr segment;
    for (unsigned i = 0; i < header.e_phnum; ++i)
        if (image.read(header.e_phoff + i * sizeof segment, segment) && segment.p_type == PT_LOAD &&
            address >= segment.p_vaddr && address - segment.p_vaddr < segment.p_filesz)
            return address - segment.p_vaddr + segment.p_offset;
    return ~uint64_t(0);
}

} // namespace

std::vector<std::string> librariesOf(const std::string& command) {
    std::ifstream file(findInPath(command), std::ios::binary);
    const Image image(std::string(std::istreambuf_iterator<char>(file), {}));
    Elf64_Ehdr header;
    if (!image.read(0, header) || std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0 ||
        header.e_ident[EI_CLASS] != ELFCLASS64)
        return {};
    std::vector<uint64_t> names;
    uint64_t strings = ~uint64_t(0);
    Elf64_Phdr segment;
    for (unsigned i = 0; i < header.e_phnum; ++i) {
        if (!image.read(header.e_phoff + i * sizeof segment, segment) ||
            segment.p_type != PT_DYNAMIC)
            continue;
        Elf64_Dyn entry;
        for (uint64_t at = 0; at < segment.p_filesz; at += sizeof entry) {
            if (!image.read(segment.p_offset + at, entry) || entry.d_tag == DT_NULL)
                break;
            if (entry.d_tag == DT_NEEDED)
                names.push_back(entry.d_un.d_val);
            if (entry.d_tag == DT_STRTAB)
                strings = offsetOf(image, header, entry.d_un.d_ptr);
        }
    }
    std::vector<std::string> libraries;
    for (const uint64_t name : names)
        if (strings != ~uint64_t(0))
            libraries.push_back(image.text(strings + name));
    return libraries;
}

} // namespace sunstone::tool
