// SPDX-License-Identifier: Apache-2.0
// The audit library of `sunstone run` (rtld-audit(7)). The dynamic loader calls it for each file
// that it loads, at program start and for dlopen. The toolkit's static CUDA runtime uses
// undocumented tables of the driver; files that contain it are redirected to our libcudart.
// module.h finds and changes the functions; entries.h jumps to libcudart.
#include "api/cuda/redirect/elf_file.h"
#include "api/cuda/redirect/module.h"

#include <atomic>
#include <dlfcn.h>
#include <link.h>

namespace sunstone::redirect {

namespace {

// The functions of the program's C library. Before glibc 2.34 they are in libdl.so.2, which each
// static runtime needs.
std::atomic<decltype(&dlmopen)> openLibrary{nullptr};
std::atomic<decltype(&dlsym)> findSymbol{nullptr};

bool hasFileName(const char* path, const char* name) {
    const size_t length = lengthOf(path), wanted = lengthOf(name);
    return length > wanted && path[length - wanted - 1] == '/' &&
           compare(path + length - wanted, name) == 0;
}

void noteLoaderFunctions(const char* path, uintptr_t base) {
    const ElfFile file(path);
    if (!file.isValid())
        return;
    file.eachFunction(SHT_DYNSYM, [&](const char* name, const Elf64_Sym& symbol) {
        const uintptr_t address = base + symbol.st_value;
        if (compare(name, "dlmopen") == 0)
            openLibrary = reinterpret_cast<decltype(&dlmopen)>(address);
        else if (compare(name, "dlsym") == 0)
            findSymbol = reinterpret_cast<decltype(&dlsym)>(address);
    });
}

[[noreturn]] void stop(const char* runtime, const char* cause) {
    say("a call of the static CUDA runtime cannot go to ", runtime, ": ", cause);
    for (;;)
        systemCall(SYS_exit_group, 127);
}

// The function of our runtime, in the program's own name space.
void* functionOf(const Runtime& runtime, const char* name) {
    if (!openLibrary || !findSymbol)
        stop(runtime.file, "the program's C library has no dlmopen");
    // The loader takes $ORIGIN as the folder of the caller, which is this library.
    void* library = openLibrary.load()(LM_ID_BASE, runtime.file, RTLD_LAZY | RTLD_LOCAL);
    if (!library)
        stop(runtime.file, "it cannot be loaded");
    void* function = findSymbol.load()(library, name);
    if (!function)
        stop(runtime.file, name);
    return function;
}

} // namespace

extern "C" void* sunstoneResolve(Entries* entries, uint64_t index) {
    const Runtime& runtime = *entries->runtime;
    void* function = functionOf(runtime, runtime.names[entries->names[index]]);
    std::atomic_ref(entries->slots[index]).store(function, std::memory_order_release);
    return function;
}

} // namespace sunstone::redirect

using namespace sunstone::redirect;

#define SUNSTONE_AUDIT extern "C" __attribute__((visibility("default")))

SUNSTONE_AUDIT unsigned int la_version(unsigned int version) {
    return version;
}

SUNSTONE_AUDIT unsigned int la_objopen(struct link_map* map, Lmid_t space, uintptr_t* cookie) {
    // The main program has no name here.
    const char* path = map->l_name && *map->l_name ? map->l_name : "/proc/self/exe";
    if (space == LM_ID_BASE && (hasFileName(path, "libc.so.6") || hasFileName(path, "libdl.so.2")))
        noteLoaderFunctions(path, map->l_addr);
    Entries* entries = redirectModule({path, map->l_addr, reinterpret_cast<uintptr_t>(map->l_ld)});
    *cookie = reinterpret_cast<uintptr_t>(entries);
    return 0;
}

SUNSTONE_AUDIT unsigned int la_objclose(uintptr_t* cookie) {
    if (auto* entries = reinterpret_cast<Entries*>(*cookie))
        keepForReuse(entries);
    *cookie = 0;
    return 0;
}
