// SPDX-License-Identifier: Apache-2.0
// See debugger.h. Source: GDB manual, "JIT Compilation Interface".
#include "compiler/debug/debugger.h"

#include "compiler/compiler.h"

#include <llvm/DebugInfo/DWARF/DWARFContext.h>
#include <llvm/Object/ELFObjectFile.h>

#include <cstring>
#include <elf.h>
#include <mutex>

// The names and layouts gdb looks for. It sets a breakpoint on the function.
extern "C" {
struct jit_code_entry {
    jit_code_entry* next_entry;
    jit_code_entry* prev_entry;
    const char* symfile_addr;
    uint64_t symfile_size;
};
struct jit_descriptor {
    uint32_t version;
    uint32_t action_flag;
    jit_code_entry* relevant_entry;
    jit_code_entry* first_entry;
};
__attribute__((noinline, used, visibility("default"))) void __jit_debug_register_code() {
    asm volatile("" ::: "memory");
}
__attribute__((used, visibility("default"))) jit_descriptor __jit_debug_descriptor = {
    1, 0, nullptr, nullptr};
}

namespace sunstone::compiler {

namespace {

enum : uint32_t { kNoAction, kRegister, kUnregister };

// Guards the descriptor and the table of ranges. Never destroyed: code may run after main.
std::mutex& mutex() {
    static auto* instance = new std::mutex;
    return *instance;
}

// gdb expects sections at their load addresses: the object file has 0 for all.
void setAddresses(std::string& code, const SectionAddresses& addresses) {
    Elf64_Ehdr header;
    std::memcpy(&header, code.data(), sizeof header);
    const auto sectionAt = [&](unsigned index) {
        return code.data() + header.e_shoff + size_t(index) * header.e_shentsize;
    };
    Elf64_Shdr names;
    std::memcpy(&names, sectionAt(header.e_shstrndx), sizeof names);
    for (unsigned i = 0; i < header.e_shnum; ++i) {
        Elf64_Shdr section;
        std::memcpy(&section, sectionAt(i), sizeof section);
        const auto found = addresses.find(code.data() + names.sh_offset + section.sh_name);
        if (found == addresses.end() || !(section.sh_flags & SHF_ALLOC))
            continue;
        section.sh_addr = found->second;
        std::memcpy(sectionAt(i), &section, sizeof section);
    }
}

} // namespace

struct DebugRegistration::Entry {
    std::string code;
    uint64_t begin = 0, end = 0; // of .text
    jit_code_entry gdb{};
    bool forDebugger = false;
};

namespace {

using Ranges = std::map<uint64_t, std::pair<uint64_t, const std::string*>>; // begin: end, code
Ranges& ranges() {
    static auto* instance = new Ranges;
    return *instance;
}

std::unique_ptr<llvm::object::ObjectFile> objectOf(const std::string& code) {
    auto object = llvm::object::ObjectFile::createELFObjectFile(
        llvm::MemoryBufferRef(code, "code"));
    if (!object) {
        llvm::consumeError(object.takeError());
        return nullptr;
    }
    return std::move(*object);
}

// The function of the machine code at this offset of .text, for code without line information.
std::string symbolAt(const llvm::object::ObjectFile& object, uint64_t section, uint64_t offset) {
    std::string name;
    uint64_t best = 0;
    for (const llvm::object::SymbolRef& symbol : object.symbols()) {
        auto type = symbol.getType();
        auto place = symbol.getSection();
        auto start = symbol.getAddress();
        auto text = symbol.getName();
        const bool good = type && place && start && text;
        if (good && *type == llvm::object::SymbolRef::ST_Function &&
            *place != object.section_end() && (*place)->getIndex() == section &&
            *start <= offset && *start >= best) {
            best = *start;
            text->consume_front("program."); // the compiler's prefix for entry points of pipelines
            name = text->str();
        }
        if (!type) llvm::consumeError(type.takeError());
        if (!place) llvm::consumeError(place.takeError());
        if (!start) llvm::consumeError(start.takeError());
        if (!text) llvm::consumeError(text.takeError());
    }
    return name;
}

void tellDebugger(uint32_t action, jit_code_entry& entry) {
    __jit_debug_descriptor.action_flag = action;
    __jit_debug_descriptor.relevant_entry = &entry;
    __jit_debug_register_code();
    __jit_debug_descriptor.action_flag = kNoAction;
    __jit_debug_descriptor.relevant_entry = nullptr;
}

} // namespace

std::unique_ptr<DebugRegistration> DebugRegistration::add(const std::string& code,
                                                          const SectionAddresses& addresses,
                                                          bool forDebugger) {
    const auto text = addresses.find(".text");
    const auto object = objectOf(code);
    if (!object || text == addresses.end())
        return nullptr;
    bool hasLines = false;
    auto entry = std::make_unique<Entry>();
    for (const llvm::object::SectionRef& section : object->sections()) {
        llvm::Expected<llvm::StringRef> name = section.getName();
        if (!name) {
            llvm::consumeError(name.takeError());
            continue;
        }
        hasLines |= *name == ".debug_line";
        if (*name == ".text")
            entry->end = text->second + section.getSize();
    }
    if (!hasLines)
        return nullptr;
    entry->begin = text->second;
    entry->code = code;
    entry->forDebugger = forDebugger;
    std::unique_ptr<DebugRegistration> registration(new DebugRegistration);
    registration->entry_ = std::move(entry);
    Entry& made = *registration->entry_;
    std::lock_guard lock(mutex());
    ranges()[made.begin] = {made.end, &made.code};
    if (forDebugger) {
        setAddresses(made.code, addresses);
        made.gdb.symfile_addr = made.code.data();
        made.gdb.symfile_size = made.code.size();
        made.gdb.next_entry = __jit_debug_descriptor.first_entry;
        if (made.gdb.next_entry)
            made.gdb.next_entry->prev_entry = &made.gdb;
        __jit_debug_descriptor.first_entry = &made.gdb;
        tellDebugger(kRegister, made.gdb);
    }
    return registration;
}

DebugRegistration::~DebugRegistration() {
    std::lock_guard lock(mutex());
    ranges().erase(entry_->begin);
    if (!entry_->forDebugger)
        return;
    jit_code_entry& gdb = entry_->gdb;
    (gdb.prev_entry ? gdb.prev_entry->next_entry : __jit_debug_descriptor.first_entry) =
        gdb.next_entry;
    if (gdb.next_entry)
        gdb.next_entry->prev_entry = gdb.prev_entry;
    tellDebugger(kUnregister, gdb);
}

bool sourceLocation(const void* address, SourceLocation& location) {
    const auto wanted = reinterpret_cast<uint64_t>(address);
    std::lock_guard lock(mutex());
    auto found = ranges().upper_bound(wanted);
    if (found == ranges().begin())
        return false;
    --found;
    const auto& [end, code] = found->second;
    const auto object = wanted < end ? objectOf(*code) : nullptr;
    if (!object)
        return false;
    uint64_t offset = wanted - found->first;
    uint64_t index = llvm::object::SectionedAddress::UndefSection;
    for (const llvm::object::SectionRef& section : object->sections())
        if (auto name = section.getName(); !name) {
            llvm::consumeError(name.takeError());
        } else if (*name == ".text") {
            index = section.getIndex();
            offset += section.getAddress(); // 0, unless set for gdb
        }
    const auto context = llvm::DWARFContext::create(*object);
    const llvm::DIInliningInfo frames = context->getInliningInfoForAddress(
        {offset, index},
        {llvm::DILineInfoSpecifier::FileLineInfoKind::AbsoluteFilePath,
         llvm::DILineInfoSpecifier::FunctionNameKind::ShortName});
    const uint32_t count = frames.getNumberOfFrames();
    if (count == 0 || frames.getFrame(0).Line == 0)
        return false;
    const llvm::DILineInfo& info = frames.getFrame(0);
    const std::string& outermost = frames.getFrame(count - 1).FunctionName;
    location.file = info.FileName;
    location.function = outermost == llvm::DILineInfo::BadString ? symbolAt(*object, index, offset)
                                                                 : outermost;
    location.line = info.Line;
    location.column = info.Column;
    return true;
}

} // namespace sunstone::compiler
