// SPDX-License-Identifier: Apache-2.0
// See report.h and memory_check.h.
#include "check/report.h"

#include "base/config.h"
#include "base/error.h"
#include "compiler/compiler.h"
#include "compiler/debug/place.h"
#include "device/cpu/memory.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <dlfcn.h>
#include <fcntl.h>
#include <map>
#include <mutex>
#include <unistd.h>

namespace sunstone::check {

namespace {

namespace cpu = device::cpu;

// Never destroyed: leaks are reported by a destructor of the library.
struct State {
    std::mutex mutex;
    std::map<std::string, uint64_t> places; // number of failures at each place
    std::string file = config(Setting::kCheckReport);
    bool leaks = checks("leaks");
    bool started = false;
};
State& state() {
    static State* instance = new State;
    return *instance;
}

// ---- JSON ---------------------------------------------------------------------------------------

std::string quoted(std::string_view text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') {
            out += '\\';
            out += c;
        } else if (static_cast<unsigned char>(c) < 0x20) {
            char escape[8];
            std::snprintf(escape, sizeof escape, "\\u%04x", unsigned(c));
            out += escape;
        } else {
            out += c;
        }
    }
    return out + '"';
}

class Json {
public:
    explicit Json(const char* event) : text_("{\"event\":" + quoted(event)) {}
    Json& add(const char* key, std::string_view value) { return raw(key, quoted(value)); }
    Json& add(const char* key, const char* value) { return raw(key, quoted(value)); }
    Json& add(const char* key, uint64_t value) { return raw(key, std::to_string(value)); }
    Json& add(const char* key, const uint32_t (&value)[3]) {
        return raw(key, message("[", value[0], ",", value[1], ",", value[2], "]"));
    }
    std::string take() { return text_ + "}\n"; }

private:
    Json& raw(const char* key, const std::string& value) {
        text_ += "," + quoted(key) + ":" + value;
        return *this;
    }
    std::string text_;
};

// One write call, so that lines of several processes do not interleave.
void writeLine(const std::string& line) {
    if (state().file.empty())
        return;
    const int file = open(state().file.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0600);
    if (file < 0 || write(file, line.data(), line.size()) != ssize_t(line.size()))
        std::fprintf(stderr, "sunstone: cannot write to %s: %s\n", state().file.c_str(),
                     std::strerror(errno));
    if (file >= 0)
        close(file);
}

// ---- the allocation near an address -------------------------------------------------------------

bool isOurs(const void* address) {
    Dl_info info{};
    if (!dladdr(address, &info) || !info.dli_fname)
        return true;
    const std::string_view path = info.dli_fname;
    const std::string_view name = path.substr(path.find_last_of('/') + 1);
    for (const char* own : {"libsunstone.so", "libcuda.so", "libcudart.so", "libnvoptix.so"})
        if (name.starts_with(own))
            return true;
    return false;
}

// "file:line" of the application's call: the innermost frame outside our libraries that has a
// line, else the file alone. Our static runtime lies in the application's file.
std::string placeOf(const cpu::CallStack& stack) {
    std::string fallback;
    for (const void* address : stack) {
        compiler::SourceLocation place;
        // A return address lies after the call instruction.
        const void* inside = static_cast<const char*>(address) - 1;
        if (isOurs(inside) || !compiler::hostLocation(inside, place))
            continue;
        if (place.line != 0)
            return message(place.file, ":", place.line);
        if (fallback.empty())
            fallback = place.file;
    }
    return fallback;
}

const char* nameOf(cpu::MemoryKind kind) {
    switch (kind) {
    case cpu::MemoryKind::kPinned:
        return "page-locked host memory";
    case cpu::MemoryKind::kManaged:
        return "managed memory";
    case cpu::MemoryKind::kRegistered:
        return "registered host memory";
    case cpu::MemoryKind::kModule:
    case cpu::MemoryKind::kManagedVariable:
        return "a module's variable";
    case cpu::MemoryKind::kArray:
        return "an array";
    case cpu::MemoryKind::kShared:
    case cpu::MemoryKind::kLent:
        return "a buffer of the library";
    case cpu::MemoryKind::kMapped:
        return "mapped device memory";
    default:
        return "device memory";
    }
}

struct Neighbour {
    cpu::Allocation allocation;
    bool isFreed = false;
    bool withContext = false;
    cpu::CallStack freedAt;
    int64_t distance = 0; // below 0: bytes before its start; 0: inside

    std::string text(uint64_t address) const {
        const uint64_t end = allocation.base + allocation.size;
        std::string where = distance < 0    ? message(-distance, " bytes before ")
                            : address < end ? message(address - allocation.base, " bytes into ")
                                            : message(address - end, " bytes behind ");
        where += message(allocation.size, " bytes of ", nameOf(allocation.kind), " at ",
                         reinterpret_cast<const void*>(allocation.base));
        if (allocation.allocatedAt)
            if (const std::string place = placeOf(*allocation.allocatedAt); !place.empty())
                where += ", allocated at " + place;
        if (isFreed) {
            const std::string place = placeOf(freedAt);
            where += withContext ? ", freed when its context ended" : ", freed";
            if (!place.empty())
                where += " at " + place;
        }
        return where;
    }
};

bool findNeighbour(uint64_t address, Neighbour& best) {
    bool found = false;
    const auto consider = [&](const cpu::Allocation& allocation,
                              const cpu::FreedAllocation* freed) {
        const uint64_t end = allocation.base + allocation.size;
        const int64_t distance = address < allocation.base ? -int64_t(allocation.base - address)
                                 : address >= end          ? int64_t(address - end) + 1
                                                           : 0;
        // A containing allocation comes first; among equals the one freed last.
        if (found && std::abs(distance) > std::abs(best.distance))
            return;
        found = true;
        best.allocation = allocation;
        best.distance = distance;
        best.isFreed = freed != nullptr;
        best.withContext = freed && freed->withContext;
        best.freedAt = freed ? freed->freedAt : cpu::CallStack();
    };
    for (const cpu::FreedAllocation& freed : cpu::memory().freed())
        consider(freed, &freed);
    for (const cpu::Allocation& allocation : cpu::memory().live())
        consider(allocation, nullptr);
    return found;
}

std::string rangeText(uint64_t address, const Range& range) {
    if (address < range.begin)
        return message(range.begin - address, " bytes before");
    if (address >= range.end)
        return message(address - range.end, " bytes behind");
    return "at the end of";
}

// The address in words. `near` receives the allocation mentioned, if any.
std::string describe(Fault fault, const devlib::CheckedAccess& access, const Scene& scene,
                     Neighbour& near, bool& hasNear) {
    const uint64_t address = access.address;
    if (access.objectBytes != 0) {
        const Range object{access.object, access.object + access.objectBytes};
        return message("the address is ", rangeText(address, object), " a variable of ",
                       access.objectBytes, " bytes");
    }
    if (fault == Fault::kShared) {
        const uint64_t bytes = scene.shared.end - scene.shared.begin;
        if (bytes == 0)
            return "the block has no shared memory";
        return message("the address is ", rangeText(address, scene.shared), " the ", bytes,
                       " bytes of the block's shared memory");
    }
    hasNear = findNeighbour(address, near);
    // Farther than this, an allocation does not explain the address.
    constexpr int64_t kNear = int64_t(1) << 20;
    std::string text;
    if (hasNear && std::abs(near.distance) <= kNear)
        return "the address is " + near.text(address);
    if (cpu::isMapped(reinterpret_cast<const void*>(address), 1))
        text = "the address is in ordinary memory of the process, which a GPU does not reach";
    else
        text = "the address is in no memory";
    if (hasNear)
        text += message("; nearest: ", near.text(address));
    return text;
}

const char* wordOf(uint8_t kind) {
    return kind == devlib::kAccessLoad ? "read" : kind == devlib::kAccessStore ? "write" : "atomic";
}

const char* wordOf(Fault fault, const Neighbour& near, bool hasNear) {
    if (fault == Fault::kAlignment)
        return "misaligned";
    if (fault == Fault::kShared)
        return "shared memory out of bounds";
    return hasNear && near.isFreed && near.distance == 0 ? "use after free" : "out of bounds";
}

std::string triple(const uint32_t (&value)[3]) {
    return message("(", value[0], ", ", value[1], ", ", value[2], ")");
}

} // namespace

std::string describeFreed(const void* address) {
    const auto place = reinterpret_cast<uint64_t>(address);
    Neighbour near;
    if (!findNeighbour(place, near) || !near.isFreed || near.distance != 0)
        return {};
    return "use after free: the address is " + near.text(place);
}

void report(Fault fault, const devlib::CheckedAccess& access, const Scene& scene) {
    const devlib::AccessPlace& place = *access.place;
    std::lock_guard lock(state().mutex);
    const std::string key = message(int(fault), " ", scene.kernel ? scene.kernel : "", " ",
                                    place.function, " ", place.ptxLine, " ", place.line);
    if (++state().places[key] > 1)
        return;
    Neighbour near;
    bool hasNear = false;
    const std::string where = describe(fault, access, scene, near, hasNear);
    const char* const error = wordOf(fault, near, hasNear);
    const std::string function = compiler::demangled(place.function);
    const std::string kernel = scene.kernel ? compiler::demangled(scene.kernel) : std::string();
    const std::string line =
        *place.line ? std::string(place.line) : message("line ", place.ptxLine, " of the PTX");
    const void* address = reinterpret_cast<const void*>(access.address);

    std::string text = message("sunstone: ", error, ": ", wordOf(place.kind), " of ", place.bytes,
                               " bytes at ", address, "\n    in ", function, ", ", line, "\n");
    if (scene.kernel)
        text += message("    kernel ", kernel, ", block ", triple(scene.block), ", thread ",
                        triple(scene.thread), "\n");
    else
        text += message("    launch index ", triple(scene.thread), "\n");
    text += "    " + where + "\n";
    std::fwrite(text.data(), 1, text.size(), stderr);

    Json json("access");
    json.add("error", error).add("access", wordOf(place.kind)).add("bytes", place.bytes);
    json.add("address", message(address)).add("function", function).add("line", line);
    json.add("ptxLine", place.ptxLine);
    if (scene.kernel)
        json.add("kernel", kernel).add("block", scene.block).add("thread", scene.thread);
    else
        json.add("launchIndex", scene.thread);
    json.add("where", where);
    if (hasNear) {
        json.add("allocation", message(reinterpret_cast<const void*>(near.allocation.base)));
        json.add("allocationBytes", near.allocation.size);
        json.add("freed", uint64_t(near.isFreed));
    }
    writeLine(json.take());
}

void start() {
    if (!enabled())
        return;
    std::lock_guard lock(state().mutex);
    if (state().started)
        return;
    state().started = true;
    writeLine(Json("start").add("process", uint64_t(getpid())).take());
}

namespace {

void reportLeak(const cpu::Allocation& leak) {
    const std::string place = leak.allocatedAt ? placeOf(*leak.allocatedAt) : std::string();
    const void* address = reinterpret_cast<const void*>(leak.base);
    std::fprintf(stderr, "sunstone: leak: %zu bytes of %s at %p were never freed%s%s\n", leak.size,
                 nameOf(leak.kind), address, place.empty() ? "" : ", allocated at ", place.c_str());
    writeLine(Json("leak")
                  .add("bytes", leak.size)
                  .add("memory", nameOf(leak.kind))
                  .add("address", message(address))
                  .add("allocatedAt", place)
                  .take());
}

// Runs when the library is unloaded, after the application's own destructors.
__attribute__((destructor)) void finish() {
    if (!enabled() || !state().started)
        return;
    std::lock_guard lock(state().mutex);
    uint64_t times = 0;
    for (const auto& [place, count] : state().places)
        times += count;
    // After an invalid access the application cannot free memory, so leaks are not reported.
    if (state().leaks && state().places.empty())
        for (const cpu::Allocation& leak : cpu::memory().leaked())
            reportLeak(leak);
    writeLine(Json("summary").add("places", state().places.size()).add("accesses", times).take());
}

} // namespace

} // namespace sunstone::check
