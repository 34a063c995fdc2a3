// SPDX-License-Identifier: Apache-2.0
// sunstone_link_stub [--may-be-empty] OUT.c OBJECT...: writes the code that a program of several
// CUDA files with relocatable device code (-fgpu-rdc) needs. Compilers leave one call in each
// object, __cudaRegisterLinkedBinary<id>, which a device linker must define. The definitions
// written here collect the objects' fat binaries and register them as one, which the runtime links
// when it loads it. Compile OUT.c and link it with the objects. All members of an archive count as
// objects.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <elf.h>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

namespace {

constexpr char kPrefix[] = "__cudaRegisterLinkedBinary";

template <class T>
bool readAt(const std::string& bytes, uint64_t offset, T& value) {
    if (offset > bytes.size() || bytes.size() - offset < sizeof value)
        return false;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return true;
}

// The ids of an object's undefined calls. False if it is not a 64-bit ELF object.
bool collect(const std::string& object, std::set<std::string>& ids) {
    Elf64_Ehdr header;
    if (!readAt(object, 0, header) || std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0 ||
        header.e_ident[EI_CLASS] != ELFCLASS64)
        return false;
    for (unsigned s = 0; s < header.e_shnum; ++s) {
        Elf64_Shdr section, strings;
        if (!readAt(object, header.e_shoff + uint64_t(s) * sizeof section, section))
            return false;
        if (section.sh_type != SHT_SYMTAB)
            continue;
        if (!readAt(object, header.e_shoff + section.sh_link * sizeof strings, strings))
            return false;
        for (uint64_t at = 0; at + sizeof(Elf64_Sym) <= section.sh_size; at += sizeof(Elf64_Sym)) {
            Elf64_Sym symbol;
            if (!readAt(object, section.sh_offset + at, symbol))
                return false;
            const uint64_t name = strings.sh_offset + symbol.st_name;
            if (symbol.st_shndx != SHN_UNDEF || name >= object.size())
                continue;
            const std::string text = object.c_str() + name; // the file ends with a NUL of its own
            if (text.rfind(kPrefix, 0) == 0)
                ids.insert(text.substr(sizeof kPrefix - 1));
        }
    }
    return true;
}

// The same for an archive: an eight-byte mark, then headers of 60 bytes with the size of the member
// in decimal digits at byte 48. Members begin at even places.
bool collectAll(const std::string& bytes, std::set<std::string>& ids) {
    constexpr char kMark[] = "!<arch>\n";
    constexpr size_t kHeader = 60, kSize = 48, kDigits = 10;
    if (bytes.compare(0, 8, kMark) != 0)
        return collect(bytes, ids);
    for (size_t at = 8; at + kHeader <= bytes.size();) {
        const size_t size = std::strtoull(bytes.substr(at + kSize, kDigits).c_str(), nullptr, 10);
        at += kHeader;
        if (size > bytes.size() - at)
            return false;
        collect(bytes.substr(at, size), ids); // the index of the archive is no object
        at += size + size % 2;
    }
    return true;
}

void write(std::ostream& out, const std::set<std::string>& ids) {
    out << "struct Wrapper { int magic, version; const void* image; const void* pieces; };\n"
           "static const void* pieces["
        << ids.size() + 1
        << "];\n"
           "static const unsigned long long nothing[2] = {0x00100001ba55ed50ull, 0};\n"
           "static const struct Wrapper whole = {0x466243b1, 2, nothing, pieces};\n"
           "static void (*callbacks["
        << ids.size()
        << "])(void**);\n"
           "static void** handle;\n"
           "extern void** __cudaRegisterFatBinary(const void*);\n"
           "extern void __cudaRegisterFatBinaryEnd(void**);\n"
           "extern void __cudaUnregisterFatBinary(void**);\n"
           "extern int atexit(void (*)(void));\n"
           "static void leave(void) { __cudaUnregisterFatBinary(handle); }\n"
           "static void add(const struct Wrapper* piece, void (*callback)(void**)) {\n"
           "    static int count;\n"
           "    pieces[count] = piece->image;\n"
           "    callbacks[count++] = callback;\n"
           "    if (count != "
        << ids.size()
        << ")\n"
           "        return;\n"
           "    handle = __cudaRegisterFatBinary(&whole);\n"
           "    atexit(leave);\n"
           "    for (int i = 0; i < count; ++i)\n"
           "        callbacks[i](handle);\n"
           "    __cudaRegisterFatBinaryEnd(handle);\n"
           "}\n";
    for (const std::string& id : ids)
        out << "extern const struct Wrapper __fatbinwrap" << id << ";\nvoid " << kPrefix << id
            << "(void (*callback)(void**), void* piece, void* name, void (*unused)(void*)) {\n"
               "    (void)piece, (void)name, (void)unused;\n    add(&__fatbinwrap"
            << id << ", callback);\n}\n";
}

} // namespace

int main(int argc, char** argv) {
    const bool mayBeEmpty = argc > 1 && std::strcmp(argv[1], "--may-be-empty") == 0;
    const int first = mayBeEmpty ? 2 : 1;
    if (argc < first + (mayBeEmpty ? 1 : 2)) {
        std::fprintf(stderr, "usage: %s [--may-be-empty] OUT.c OBJECT...\n", argv[0]);
        return 1;
    }
    std::set<std::string> ids;
    for (int i = first + 1; i < argc; ++i) {
        std::ifstream in(argv[i], std::ios::binary);
        std::string object((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
        if (!in || !collectAll(object, ids)) {
            std::fprintf(stderr, "%s: %s is not a readable ELF object\n", argv[0], argv[i]);
            return 1;
        }
    }
    if (ids.empty() && !mayBeEmpty) {
        std::fprintf(stderr, "%s: no object has relocatable device code (-fgpu-rdc)\n", argv[0]);
        return 1;
    }
    std::ofstream out(argv[first]);
    if (!ids.empty())
        write(out, ids);
    out.close();
    if (!out) {
        std::fprintf(stderr, "%s: cannot write %s\n", argv[0], argv[first]);
        return 1;
    }
    return 0;
}
