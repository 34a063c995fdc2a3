// SPDX-License-Identifier: Apache-2.0
// See debugger.h. Source: GDB manual, "JIT Compilation Interface".
#include "compiler/debug/debugger.h"

#include "base/error.h"
#include "compiler/compiler.h"
#include "compiler/debug/place.h"

#include <llvm/DebugInfo/DWARF/DWARFContext.h>
#include <llvm/Object/ELFObjectFile.h>

#include <cstdlib>
#include <cstring>
#include <cxxabi.h>
#include <elf.h>
#include <mutex>
#include <string_view>

// The names and layouts that gdb expects. gdb sets a breakpoint on the function.
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

// gdb expects the load addresses of sections; in the object file they are 0.
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

namespace {

using Functions = std::map<uint64_t, std::string>; // by offset in .text

// Facts about a range of loaded code.
struct Known {
    uint64_t end = 0;
    std::string object; // with line information, else empty
    Functions functions;
};
using Ranges = std::map<uint64_t, const Known*>; // by begin
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

// The functions of section `section`.
Functions functionsOf(const llvm::object::ObjectFile& object, uint64_t section) {
    Functions functions;
    for (const llvm::object::SymbolRef& symbol : object.symbols()) {
        auto type = symbol.getType();
        auto place = symbol.getSection();
        auto start = symbol.getAddress();
        auto text = symbol.getName();
        const bool good = type && place && start && text;
        if (good && *type == llvm::object::SymbolRef::ST_Function &&
            *place != object.section_end() && (*place)->getIndex() == section) {
            // Names in PTX have no dots, so the compiler added these prefixes and any suffix after
            // a dot.
            for (const char* prefix : {"program.", "kernel.", "lockstep.", "f."})
                if (text->consume_front(prefix))
                    break;
            functions[*start - (*place)->getAddress()] = text->split('.').first.str();
        }
        if (!type) llvm::consumeError(type.takeError());
        if (!place) llvm::consumeError(place.takeError());
        if (!start) llvm::consumeError(start.takeError());
        if (!text) llvm::consumeError(text.takeError());
    }
    return functions;
}

void tellDebugger(uint32_t action, jit_code_entry& entry) {
    __jit_debug_descriptor.action_flag = action;
    __jit_debug_descriptor.relevant_entry = &entry;
    __jit_debug_register_code();
    __jit_debug_descriptor.action_flag = kNoAction;
    __jit_debug_descriptor.relevant_entry = nullptr;
}

} // namespace

struct DebugRegistration::Entry {
    uint64_t begin = 0; // of .text
    Known known;
    jit_code_entry gdb{};
    bool forDebugger = false;
};

std::unique_ptr<DebugRegistration> DebugRegistration::add(const std::string& code,
                                                          const SectionAddresses& addresses,
                                                          bool forDebugger) {
    const auto text = addresses.find(".text");
    const auto object = objectOf(code);
    if (!object || text == addresses.end())
        return nullptr;
    bool hasLines = false;
    auto entry = std::make_unique<Entry>();
    entry->begin = text->second;
    for (const llvm::object::SectionRef& section : object->sections()) {
        llvm::Expected<llvm::StringRef> name = section.getName();
        if (!name) {
            llvm::consumeError(name.takeError());
            continue;
        }
        hasLines |= *name == ".debug_line";
        if (*name != ".text")
            continue;
        entry->known.end = text->second + section.getSize();
        entry->known.functions = functionsOf(*object, section.getIndex());
    }
    if (hasLines)
        entry->known.object = code;
    entry->forDebugger = forDebugger && hasLines;
    std::unique_ptr<DebugRegistration> registration(new DebugRegistration);
    registration->entry_ = std::move(entry);
    Entry& made = *registration->entry_;
    std::lock_guard lock(mutex());
    ranges()[made.begin] = &made.known;
    if (made.forDebugger) {
        setAddresses(made.known.object, addresses);
        made.gdb.symfile_addr = made.known.object.data();
        made.gdb.symfile_size = made.known.object.size();
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

// Whether a file with this path defines the API's device functions.
static bool isApiHeader(std::string_view path) {
    const std::string_view name = path.substr(path.rfind('/') + 1); // npos + 1 is 0
    return name.starts_with("optix_") && name.find("device") != name.npos && name.ends_with(".h");
}

// Fills file, line and column, and the function if the debug information names it.
static void findLine(const std::string& code, uint64_t offset, SourceLocation& location) {
    const auto object = code.empty() ? nullptr : objectOf(code);
    if (!object)
        return;
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
        return;
    uint32_t inner = 0; // of the application: optix_7_device_impl.h and its like say nothing
    while (inner + 1 < count && isApiHeader(frames.getFrame(inner).FileName))
        ++inner;
    const llvm::DILineInfo& info = frames.getFrame(inner);
    const std::string& outermost = frames.getFrame(count - 1).FunctionName;
    location.file = info.FileName;
    location.line = info.Line;
    location.column = info.Column;
    if (outermost != llvm::DILineInfo::BadString)
        location.function = outermost;
}

// The range that holds the address, or the end. The caller holds the mutex.
static Ranges::iterator findRange(uint64_t address) {
    const auto next = ranges().upper_bound(address);
    if (next == ranges().begin() || address >= std::prev(next)->second->end)
        return ranges().end();
    return std::prev(next);
}

bool isLoadedCode(const void* address) {
    std::lock_guard lock(mutex());
    return findRange(reinterpret_cast<uint64_t>(address)) != ranges().end();
}

// Fills the function, if known, even if the result is false.
bool sourceLocation(const void* address, SourceLocation& location) {
    location = {};
    std::lock_guard lock(mutex());
    const auto found = findRange(reinterpret_cast<uint64_t>(address));
    if (found == ranges().end())
        return false;
    const Known& known = *found->second;
    const uint64_t offset = reinterpret_cast<uint64_t>(address) - found->first;
    auto function = known.functions.upper_bound(offset);
    if (function != known.functions.begin())
        location.function = (--function)->second;
    findLine(known.object, offset, location);
    return location.line != 0;
}

std::string demangled(const char* symbol) {
    int status = 0;
    char* plain = abi::__cxa_demangle(symbol, nullptr, nullptr, &status);
    std::string text = status == 0 && plain ? plain : symbol;
    std::free(plain);
    return text;
}

std::string placeText(const void* address) {
    SourceLocation place;
    const bool hasLine = sourceLocation(address, place);
    return (place.function.empty() ? "" : message(", in ", demangled(place.function.c_str()))) +
           (hasLine ? message(", at ", place.file, ":", place.line) : "");
}

} // namespace sunstone::compiler
