// SPDX-License-Identifier: Apache-2.0
// hostLocation of compiler.h: the source line of an address in host code.
#include "compiler/compiler.h"

#include "base/error.h"

#include <llvm/DebugInfo/DWARF/DWARFContext.h>
#include <llvm/Object/ELFObjectFile.h>
#include <llvm/Support/Path.h>

#include <dlfcn.h>
#include <map>
#include <mutex>

namespace sunstone::compiler {

namespace {

struct HostFile {
    llvm::object::OwningBinary<llvm::object::ObjectFile> object;
    std::unique_ptr<llvm::DWARFContext> dwarf;
    bool isFixed = false; // not relocatable: file addresses are process addresses
};

// Null if the file cannot be read. Files stay open, because reports come in groups.
HostFile* hostFile(const std::string& path) {
    // Never destroyed: reports are also made while the process exits.
    static auto& files = *new std::map<std::string, std::unique_ptr<HostFile>>;
    const auto [entry, isNew] = files.try_emplace(path);
    if (!isNew)
        return entry->second.get();
    auto object = llvm::object::ObjectFile::createObjectFile(path);
    if (!object) {
        llvm::consumeError(object.takeError());
        return nullptr;
    }
    auto file = std::make_unique<HostFile>();
    file->object = std::move(*object);
    file->dwarf = llvm::DWARFContext::create(*file->object.getBinary());
    if (const auto* elf = llvm::dyn_cast<llvm::object::ELFObjectFileBase>(file->object.getBinary()))
        file->isFixed = elf->getEType() == llvm::ELF::ET_EXEC;
    entry->second = std::move(file);
    return entry->second.get();
}

// Headers whose inline functions call the API in place of the application.
bool isApiHeader(llvm::StringRef file) {
    const llvm::StringRef name = llvm::sys::path::filename(file);
    return name == "runtime_templates.h" || name == "cuda_runtime.h";
}

} // namespace

bool hostLocation(const void* address, SourceLocation& location) {
    static auto* mutex = new std::mutex;
    std::lock_guard lock(*mutex);
    Dl_info info{};
    if (!dladdr(address, &info) || !info.dli_fname)
        return false;
    const auto base = reinterpret_cast<uint64_t>(info.dli_fbase);
    uint64_t offset = reinterpret_cast<uint64_t>(address) - base;
    location = {};
    location.function = info.dli_sname ? info.dli_sname : "";
    // The path may be relative, and the program may have changed its working folder since its
    // start.
    std::string path = info.dli_fname;
    if (HostFile* file = hostFile(path)) {
        if (file->isFixed)
            offset += base;
        const llvm::DIInliningInfo frames = file->dwarf->getInliningInfoForAddress(
            {offset, llvm::object::SectionedAddress::UndefSection},
            {llvm::DILineInfoSpecifier::FileLineInfoKind::AbsoluteFilePath,
             llvm::DILineInfoSpecifier::FunctionNameKind::ShortName});
        for (uint32_t i = 0; i < frames.getNumberOfFrames(); ++i) {
            const llvm::DILineInfo& line = frames.getFrame(i);
            if (line.Line == 0 || isApiHeader(line.FileName))
                continue;
            location.file = line.FileName;
            location.line = line.Line;
            location.column = line.Column;
            if (line.FunctionName != llvm::DILineInfo::BadString)
                location.function = line.FunctionName;
            return true;
        }
    }
    char text[32];
    std::snprintf(text, sizeof text, "+0x%llx", static_cast<unsigned long long>(offset));
    location.file = path + text;
    return true;
}

} // namespace sunstone::compiler
