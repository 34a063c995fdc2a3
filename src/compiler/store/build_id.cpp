// SPDX-License-Identifier: Apache-2.0
// Reads the NT_GNU_BUILD_ID note (ELF specification, note sections) from the program headers of
// this binary.
#include "compiler/store/build_id.h"

#include <elf.h>
#include <link.h>

#include <cstring>
#include <random>
#include <string_view>

namespace sunstone::compiler {

namespace {

// The id in a run of notes, or empty. Name and descriptor are padded to four bytes.
std::string idInNotes(std::string_view notes) {
    const auto padded = [](size_t size) { return (size + 3) & ~size_t(3); };
    while (notes.size() >= sizeof(ElfW(Nhdr))) {
        ElfW(Nhdr) header;
        std::memcpy(&header, notes.data(), sizeof header);
        notes.remove_prefix(sizeof header);
        const size_t name = padded(header.n_namesz), size = padded(header.n_descsz);
        if (name > notes.size() || size > notes.size() - name)
            break;
        if (header.n_type == NT_GNU_BUILD_ID && notes.substr(0, 4) == std::string_view("GNU\0", 4))
            return std::string(notes.substr(name, header.n_descsz));
        notes.remove_prefix(name + size);
    }
    return {};
}

struct Search {
    ElfW(Addr) inside; // an address of the wanted binary
    std::string id;
};

int visit(dl_phdr_info* info, size_t, void* data) {
    auto& search = *static_cast<Search*>(data);
    bool holds = false;
    for (unsigned i = 0; i < info->dlpi_phnum; ++i) {
        const ElfW(Phdr)& part = info->dlpi_phdr[i];
        const ElfW(Addr) begin = info->dlpi_addr + part.p_vaddr;
        holds |= part.p_type == PT_LOAD && search.inside >= begin &&
                 search.inside < begin + part.p_memsz;
    }
    if (!holds)
        return 0;
    for (unsigned i = 0; i < info->dlpi_phnum && search.id.empty(); ++i) {
        const ElfW(Phdr)& part = info->dlpi_phdr[i];
        if (part.p_type == PT_NOTE)
            search.id = idInNotes(
                {reinterpret_cast<const char*>(info->dlpi_addr + part.p_vaddr), part.p_memsz});
    }
    return 1;
}

} // namespace

const std::string& buildId() {
    static const auto* id = [] {
        Search search{reinterpret_cast<ElfW(Addr)>(&buildId), {}};
        dl_iterate_phdr(visit, &search);
        if (search.id.empty()) {
            std::random_device random;
            for (int i = 0; i < 4; ++i)
                search.id += std::to_string(random()) + ".";
        }
        return new std::string(search.id);
    }();
    return *id;
}

} // namespace sunstone::compiler
