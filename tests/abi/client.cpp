// SPDX-License-Identifier: Apache-2.0
#include "client.h"

#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>

namespace tests::abi {

GuardedMemory::GuardedMemory(size_t size) {
    const size_t page = size_t(sysconf(_SC_PAGESIZE));
    const size_t usable = (size + page - 1) / page * page;
    mapped_ = usable + page;
    pages_ = mmap(nullptr, mapped_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (pages_ == MAP_FAILED || mprotect(static_cast<char*>(pages_) + usable, page, PROT_NONE) != 0)
        throw std::bad_alloc();
    data_ = static_cast<char*>(pages_) + usable - size;
    std::memset(data_, 0xA5, size);
}

GuardedMemory::GuardedMemory(GuardedMemory&& other) noexcept
    : pages_(other.pages_), mapped_(other.mapped_), data_(other.data_) {
    other.pages_ = nullptr;
}

GuardedMemory::~GuardedMemory() {
    if (pages_)
        munmap(pages_, mapped_);
}

Query* queryFunction() {
    static Query* const query = [] {
        void* library = dlopen("libnvoptix.so.1", RTLD_NOW);
        if (!library)
            throw std::runtime_error(dlerror());
        return reinterpret_cast<Query*>(dlsym(library, "optixQueryFunctionTable"));
    }();
    return query;
}

Table::Table(int abi) : names_(slotsOf(abi)), slots_(names_.size()) {
    const int result =
        queryFunction()(abi, 0, nullptr, nullptr, slots_.data(), slots_.size() * sizeof(void*));
    if (result != kSuccess)
        throw std::runtime_error("ABI " + std::to_string(abi) + ": result " +
                                 std::to_string(result));
}

bool Table::has(const std::string& name) const {
    return std::find(names_.begin(), names_.end(), name) != names_.end();
}

size_t Table::indexOf(const std::string& name) const {
    const auto found = std::find(names_.begin(), names_.end(), name);
    if (found == names_.end())
        throw std::logic_error("no slot " + name);
    return size_t(found - names_.begin());
}

void Log::callback(unsigned, const char*, const char* message, void* self) {
    static_cast<Log*>(self)->text += std::string(message) + "\n";
}

namespace {

std::string join(const std::string& prefix, int count) {
    std::string text;
    for (int i = 0; i < count; ++i)
        text += (i ? ", " : "") + prefix + std::to_string(i);
    return text;
}

// A trace with two payload words, %p0 and %p1, in and out.
std::string traceCall(int abi) {
    const std::string ray = "%handle, %ox, %oy, %oz, %dx, %dy, %dz, %tmin, %tmax, %time, ";
    const std::string table = "%mask, %flags, %offset, %stride, %miss, ";
    if (abi < 47)
        return "call (%p0, %p1), _optix_trace_2, (" + ray + table + "%p0, %p1);\n";
    // The headers pass uninitialised registers for the words beyond the count.
    return "mov.u32 %type, 0;\n mov.u32 %count, 2;\n"
           " call (" +
           join("%p", 32) + "), _optix_trace_typed_32, (%type, " + ray + table + "%count, " +
           join("%p", 32) + ");\n";
}

std::string setPayload(int abi, int slot, const std::string& value) {
    if (abi < 47)
        return "call _optix_set_payload_" + std::to_string(slot) + ", (" + value + ");\n";
    return "mov.u32 %slot, " + std::to_string(slot) + ";\n call _optix_set_payload, (%slot, " +
           value + ");\n";
}

std::string getPayload(int abi, int slot, const std::string& result) {
    if (abi < 47)
        return "call (" + result + "), _optix_get_payload_" + std::to_string(slot) + ", ();\n";
    return "mov.u32 %slot, " + std::to_string(slot) + ";\n call (" + result +
           "), _optix_get_payload, (%slot);\n";
}

} // namespace

std::string scenePtx(int abi, unsigned rayFlags, bool showTime) {
    return R"(.version 6.5
.target sm_60
.address_size 64
.const .align 8 .b8 params[16];

.visible .entry __raygen__main() {
 .reg .b32 %p<32>, %x, %y, %w, %h, %mask, %flags, %offset, %stride, %miss, %type, %count, %at;
 .reg .f32 %ox, %oy, %oz, %dx, %dy, %dz, %tmin, %tmax, %time, %size;
 .reg .b64 %handle, %out, %place;
 call (%x), _optix_get_launch_index_x, ();
 call (%y), _optix_get_launch_index_y, ();
 call (%w), _optix_get_launch_dimension_x, ();
 call (%h), _optix_get_launch_dimension_y, ();
 ld.const.u64 %out, [params];
 ld.const.u64 %handle, [params+8];
 cvt.rn.f32.u32 %ox, %x;
 cvt.rn.f32.u32 %size, %w;
 add.f32 %ox, %ox, 0f3F000000;
 div.rn.f32 %ox, %ox, %size;
 cvt.rn.f32.u32 %oy, %y;
 cvt.rn.f32.u32 %size, %h;
 add.f32 %oy, %oy, 0f3F000000;
 div.rn.f32 %oy, %oy, %size;
 mov.f32 %oz, 0fC0000000;
 mov.f32 %dx, 0f3DCCCCCD;
 mov.f32 %dy, 0f00000000;
 mov.f32 %dz, 0f3F800000;
 mov.f32 %tmin, 0f00000000;
 mov.f32 %tmax, 0f42C80000;
 mov.f32 %time, )" +
           std::string(showTime ? "0f3F000000" : "0f00000000") + R"(;
 mov.u32 %mask, 255;
 mov.u32 %flags, )" +
           std::to_string(rayFlags) +
           R"(;
 mov.u32 %offset, 0;
 mov.u32 %stride, 1;
 mov.u32 %miss, 0;
 mov.u32 %p0, 77;
 mov.u32 %p1, 78;
 )" + traceCall(abi) +
           R"( mad.lo.u32 %at, %y, %w, %x;
 mul.wide.u32 %place, %at, 8;
 add.u64 %place, %place, %out;
 st.global.u32 [%place], %p0;
 st.global.u32 [%place+4], %p1;
 ret;
}

.visible .entry __closesthit__main() {
 .reg .b32 %slot, %old, %bits, %prim, %id, %word;
 .reg .f32 %u, %v;
 .reg .b64 %data;
 )" + getPayload(abi, 0, "%old") +
           R"( call (%u, %v), _optix_get_triangle_barycentrics, ();
 call (%prim), _optix_read_primitive_idx, ();
 call (%id), _optix_read_instance_id, ();
 call (%data), _optix_get_sbt_data_ptr_64, ();
 ld.global.u32 %word, [%data];
 mov.b32 %bits, %u;
 add.u32 %bits, %bits, %old;
 )" + setPayload(abi, 0, "%bits") +
           R"( mov.b32 %bits, %v;
 mad.lo.u32 %bits, %prim, 1000003, %bits;
 mad.lo.u32 %bits, %id, 7919, %bits;
 add.u32 %bits, %bits, %word;
 )" + setPayload(abi, 1, "%bits") +
           R"( ret;
}

.visible .entry __miss__main() {
 .reg .b32 %slot, %word;
 .reg .f32 %time;
 )" +
           (showTime ? "call (%time), _optix_get_ray_time, ();\n mov.b32 %word, %time;\n"
                     : "mov.u32 %word, 12345;\n") +
           setPayload(abi, 0, "%word") +
           R"( ret;
}
)";
}

} // namespace tests::abi
