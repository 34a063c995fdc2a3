// SPDX-License-Identifier: Apache-2.0
// See module.h. Only functions that the file does not export are redirected: a library that exports
// the names of the runtime is a shared runtime or a tool between program and runtime.
#include "api/cuda/redirect/module.h"

#include "api/cuda/redirect/elf_file.h"

namespace sunstone::redirect {

namespace {

constexpr size_t kJump = 5; // bytes of a jump

bool isOwn(const Elf64_Sym& symbol) {
    const unsigned visibility = ELF64_ST_VISIBILITY(symbol.st_other);
    return ELF64_ST_BIND(symbol.st_info) == STB_LOCAL || visibility == STV_HIDDEN ||
           visibility == STV_INTERNAL;
}

bool mayBeRuntime(const char* name) {
    return startsWith(name, "cuda") || startsWith(name, "__cuda");
}

int indexOf(const Runtime& runtime, const char* name) {
    size_t low = 0, high = runtime.count;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        const int order = compare(name, runtime.names[middle]);
        if (order == 0)
            return int(middle);
        if (order < 0)
            high = middle;
        else
            low = middle + 1;
    }
    return -1;
}

// Facts about a file's runtime from its symbols.
struct Evidence {
    size_t functions = 0; // upper bound of those to redirect
    bool registers = false, unregisters = false;
    bool hasForms12 = false;  // functions that CUDA 13 removed
    bool hasTextures = false; // and those that CUDA 12 removed
    bool isOurs = false;      // our own archive
};

Evidence collect(const ElfFile& file) {
    Evidence evidence;
    file.eachFunction(SHT_SYMTAB, [&](const char* name, const Elf64_Sym& symbol) {
        if (startsWith(name, "_ZN8sunstone6cudart"))
            evidence.isOurs = true;
        if (!mayBeRuntime(name) || !isOwn(symbol))
            return;
        ++evidence.functions;
        evidence.registers |= compare(name, "__cudaRegisterFatBinary") == 0;
        evidence.unregisters |= compare(name, "__cudaUnregisterFatBinary") == 0;
        evidence.hasForms12 |= compare(name, "cudaGetDeviceProperties_v2") == 0;
        evidence.hasTextures |= compare(name, "cudaBindTexture") == 0;
    });
    return evidence;
}

// Whether this is the loaded file: its dynamic section is at the address that the loader reports.
bool isLoadedAs(const ElfFile& elf, const LoadedFile& file) {
    for (size_t i = 0; const Elf64_Phdr* segment = elf.segment(i); ++i)
        if (segment->p_type == PT_DYNAMIC)
            return segment->p_vaddr + file.base == file.dynamic;
    return false;
}

struct Range {
    uintptr_t low = UINTPTR_MAX, high = 0;
};
Range rangeOf(const ElfFile& elf, uintptr_t base) {
    Range range;
    for (size_t i = 0; const Elf64_Phdr* segment = elf.segment(i); ++i) {
        if (segment->p_type != PT_LOAD)
            continue;
        const uintptr_t from = base + segment->p_vaddr, to = from + segment->p_memsz;
        range.low = from < range.low ? from : range.low;
        range.high = to > range.high ? to : range.high;
    }
    return range;
}

// Changes access to the pages of the executable segments.
bool setAccess(const ElfFile& elf, uintptr_t base, bool isWritable) {
    constexpr uintptr_t kPage = 4096;
    for (size_t i = 0; const Elf64_Phdr* segment = elf.segment(i); ++i) {
        if (segment->p_type != PT_LOAD || !(segment->p_flags & PF_X))
            continue;
        const uintptr_t from = (base + segment->p_vaddr) & ~(kPage - 1);
        const uintptr_t to = base + segment->p_vaddr + segment->p_memsz;
        const int access = (segment->p_flags & PF_R ? PROT_READ : 0) |
                           (segment->p_flags & PF_W ? PROT_WRITE : 0) | PROT_EXEC;
        if (!protectMemory(from, to - from, isWritable ? PROT_READ | PROT_WRITE : access))
            return false;
    }
    return true;
}

// The address of a function in memory; null if its bytes differ from those of the file, because it
// is redirected already or the file has changed.
uint8_t* codeOf(const ElfFile& elf, uintptr_t base, const Elf64_Sym& symbol) {
    const Elf64_Phdr* segment = elf.segmentOf(symbol.st_value, kJump);
    if (symbol.st_size < kJump || !segment || !(segment->p_flags & PF_X))
        return nullptr;
    const auto* stored =
        elf.at<uint8_t>(segment->p_offset + (symbol.st_value - segment->p_vaddr), kJump);
    auto* code = reinterpret_cast<uint8_t*>(base + symbol.st_value);
    return stored && sameBytes(stored, code, kJump) ? code : nullptr;
}

void patch(uint8_t* code, uintptr_t target) {
    const auto distance = uint32_t(target - (reinterpret_cast<uintptr_t>(code) + kJump));
    const uint8_t jump[kJump] = {0xE9, uint8_t(distance), uint8_t(distance >> 8),
                                 uint8_t(distance >> 16), uint8_t(distance >> 24)};
    for (size_t i = 0; i < kJump; ++i)
        code[i] = jump[i];
}

void patchAll(const ElfFile& elf, uintptr_t base, Entries& entries) {
    size_t used = 0;
    elf.eachFunction(SHT_SYMTAB, [&](const char* name, const Elf64_Sym& symbol) {
        if (!mayBeRuntime(name) || !isOwn(symbol))
            return;
        const int index = indexOf(*entries.runtime, name);
        uint8_t* code = index < 0 ? nullptr : codeOf(elf, base, symbol);
        if (!code)
            return;
        setName(entries, used, uint16_t(index));
        patch(code, addressOf(entries, used++));
    });
}

} // namespace

Entries* redirectModule(const LoadedFile& file) {
    const ElfFile elf(file.path);
    if (!elf.isValid())
        return nullptr;
    const Evidence evidence = collect(elf);
    if (!evidence.registers || !evidence.unregisters || evidence.isOurs || !isLoadedAs(elf, file))
        return nullptr;
    if (evidence.hasTextures && !evidence.hasForms12) {
        say(file.path, ": the static CUDA runtime in this file is older than CUDA 12; Sunstone has "
                       "the runtimes of CUDA 12 and 13");
        return nullptr;
    }
    const Range range = rangeOf(elf, file.base);
    Entries* entries = makeEntries(evidence.hasForms12 ? kRuntime12 : kRuntime13,
                                   evidence.functions, range.low, range.high);
    if (!entries || !setAccess(elf, file.base, true)) {
        say(file.path, ": the system refuses to change the static CUDA runtime in this file (",
            entries ? "access to its code" : "no memory near it", ")");
        return nullptr;
    }
    patchAll(elf, file.base, *entries);
    if (!setAccess(elf, file.base, false) || !seal(*entries))
        say(file.path, ": the system refuses to make code executable");
    return entries;
}

} // namespace sunstone::redirect
