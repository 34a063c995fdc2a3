// SPDX-License-Identifier: Apache-2.0
// An ELF file in memory and its symbols. Each offset is checked: a damaged file has no symbols.
#pragma once

#include "api/cuda/redirect/system.h"

#include <elf.h>

namespace sunstone::redirect {

class ElfFile {
public:
    explicit ElfFile(const char* path) {
        const long file = systemCall(SYS_open, reinterpret_cast<long>(path), O_RDONLY | O_CLOEXEC);
        if (failed(file))
            return;
        struct stat status;
        if (!failed(systemCall(SYS_fstat, file, reinterpret_cast<long>(&status))) &&
            status.st_size >= long(sizeof(Elf64_Ehdr))) {
            bytes_ = mapMemory(0, size_t(status.st_size), PROT_READ, MAP_PRIVATE, int(file));
            size_ = bytes_ ? size_t(status.st_size) : 0;
        }
        systemCall(SYS_close, file);
        const Elf64_Ehdr* header = at<Elf64_Ehdr>(0);
        const uint8_t magic[] = {ELFMAG0, ELFMAG1, ELFMAG2, ELFMAG3, ELFCLASS64, ELFDATA2LSB};
        if (header && sameBytes(header->e_ident, magic, sizeof magic) &&
            header->e_machine == EM_X86_64)
            header_ = header;
    }
    ~ElfFile() {
        if (bytes_)
            unmapMemory(bytes_, size_);
    }
    ElfFile(const ElfFile&) = delete;
    ElfFile& operator=(const ElfFile&) = delete;

    bool isValid() const { return header_ != nullptr; }

    // count elements at an offset; null if the file ends earlier.
    template <class T>
    const T* at(uint64_t offset, uint64_t count = 1) const {
        if (offset > size_ || (size_ - offset) / sizeof(T) < count || offset % alignof(T))
            return nullptr;
        return reinterpret_cast<const T*>(bytes_ + offset);
    }

    const Elf64_Phdr* segment(size_t index) const {
        if (!header_ || index >= header_->e_phnum || header_->e_phentsize != sizeof(Elf64_Phdr))
            return nullptr;
        return at<Elf64_Phdr>(header_->e_phoff + index * sizeof(Elf64_Phdr));
    }

    // The loaded segment that holds [address, address + size) of the file; null if none.
    const Elf64_Phdr* segmentOf(uint64_t address, uint64_t size) const {
        for (size_t i = 0; const Elf64_Phdr* s = segment(i); ++i)
            if (s->p_type == PT_LOAD && address >= s->p_vaddr &&
                address - s->p_vaddr <= s->p_filesz && s->p_filesz - (address - s->p_vaddr) >= size)
                return s;
        return nullptr;
    }

    // visit(name, symbol) for each defined function of the table of this type, SHT_SYMTAB or
    // SHT_DYNSYM.
    template <class Visit>
    void eachFunction(uint32_t table, Visit&& visit) const {
        if (!header_ || header_->e_shentsize != sizeof(Elf64_Shdr))
            return;
        for (size_t i = 0; const Elf64_Shdr* s = section(i); ++i) {
            const Elf64_Shdr* texts = s->sh_type == table ? section(s->sh_link) : nullptr;
            if (!texts || s->sh_entsize != sizeof(Elf64_Sym))
                continue;
            const uint64_t count = s->sh_size / sizeof(Elf64_Sym);
            const Elf64_Sym* symbols = at<Elf64_Sym>(s->sh_offset, count);
            const char* text = at<char>(texts->sh_offset, texts->sh_size);
            if (!symbols || !text || !texts->sh_size || text[texts->sh_size - 1])
                continue;
            for (uint64_t n = 0; n < count; ++n)
                if (symbols[n].st_shndx != SHN_UNDEF && symbols[n].st_name < texts->sh_size &&
                    ELF64_ST_TYPE(symbols[n].st_info) == STT_FUNC)
                    visit(text + symbols[n].st_name, symbols[n]);
        }
    }

private:
    const Elf64_Shdr* section(size_t index) const {
        if (index >= header_->e_shnum)
            return nullptr;
        return at<Elf64_Shdr>(header_->e_shoff + index * sizeof(Elf64_Shdr));
    }

    uint8_t* bytes_ = nullptr;
    size_t size_ = 0;
    const Elf64_Ehdr* header_ = nullptr;
};

} // namespace sunstone::redirect
