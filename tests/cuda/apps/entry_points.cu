// SPDX-License-Identifier: Apache-2.0
// Functions of the driver by name, version and kind of default stream: the form of each function
// that the driver returns. A line lists the versions from which on another form applies.
#include <cuda.h>

#include "entry_point_names.h"

#include <dlfcn.h>

#include <cstdio>
#include <map>
#include <string>

namespace {

void* library;

// The exported form that a pointer is.
std::string formOf(const std::string& name, void* function) {
    static std::map<void*, std::string> known;
    if (!function)
        return "-";
    std::string found;
    for (const char* version : {"", "_v2", "_v3", "_v4"})
        for (const char* stream : {"", "_ptds", "_ptsz"}) {
            const std::string form = std::string(version) + stream;
            if (dlsym(library, (name + form).c_str()) == function)
                found += (found.empty() ? "" : "=") + (form.empty() ? std::string("plain") : form);
        }
    if (!found.empty())
        return found;
    return known.emplace(function, name + "#" + std::to_string(known.size())).first->second;
}

std::string answer(const char* name, int version, cuuint64_t flags) {
    void* function = reinterpret_cast<void*>(1);
    CUdriverProcAddressQueryResult status = CUdriverProcAddressQueryResult(77);
    const CUresult result = cuGetProcAddress(name, &function, version, flags, &status);
    std::string text =
        result || status ? "(" + std::to_string(result) + " " + std::to_string(status) + ") " : "";
    return text + (function == reinterpret_cast<void*>(1) ? "untouched"
                                                          : formOf(name ? name : "", function));
}

void line(const char* name, cuuint64_t flags) {
    std::string text, last;
    for (int version = 1000; version <= 14000; version += 10) {
        if (version % 1000 > 90)
            continue;
        const std::string now = answer(name, version, flags);
        if (now != last)
            text += " " + std::to_string(version) + " " + now;
        last = now;
    }
    std::printf("%s %d:%s\n", name, int(flags), text.c_str());
}

} // namespace

int main() {
    library = dlopen("libcuda.so.1", RTLD_NOW);
    for (const char* name : kEntryPointNames)
        for (cuuint64_t flags :
             {CU_GET_PROC_ADDRESS_LEGACY_STREAM, CU_GET_PROC_ADDRESS_PER_THREAD_DEFAULT_STREAM})
            line(name, flags);
    // Not names of functions, or names of forms.
    for (const char* name :
         {"", "cu", "cuNothing", "nothing", "cuMemAlloc_v2", "cuMemcpy_ptds", "cuGetProcAddress_v2",
          "cuStreamSynchronize_ptsz", "cumemalloc", "cuMemAlloc ", "cudaMalloc"})
        std::printf("'%s': %s\n", name, answer(name, 12000, 0).c_str());
    for (int version : {-1, 0, 1, 999, 13000, 13010, 2147483647})
        std::printf("version %d: %s %s\n", version, answer("cuMemAlloc", version, 0).c_str(),
                    answer("cuInit", version, 0).c_str());
    for (cuuint64_t flags :
         {cuuint64_t(0), cuuint64_t(3), cuuint64_t(4), cuuint64_t(1) << 40, ~cuuint64_t(0)})
        std::printf("flags %llx: %s\n", (unsigned long long)flags,
                    answer("cuMemcpy", 12000, flags).c_str());
    return 0;
}
