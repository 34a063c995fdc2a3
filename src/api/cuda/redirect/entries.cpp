// SPDX-License-Identifier: Apache-2.0
// See entries.h.
#include "api/cuda/redirect/entries.h"

#include "api/cuda/redirect/system.h"

// Entered by a jump with the table and the index of the entry on the stack, above the return
// address of the program's call. Keeps the registers of arguments.
asm(R"(
    .text
    .type sunstoneResolver, @function
    .hidden sunstoneResolver
    .globl sunstoneResolver
sunstoneResolver:
    push %rdi
    push %rsi
    push %rdx
    push %rcx
    push %r8
    push %r9
    push %rax
    sub $128, %rsp
    movups %xmm0, (%rsp)
    movups %xmm1, 16(%rsp)
    movups %xmm2, 32(%rsp)
    movups %xmm3, 48(%rsp)
    movups %xmm4, 64(%rsp)
    movups %xmm5, 80(%rsp)
    movups %xmm6, 96(%rsp)
    movups %xmm7, 112(%rsp)
    mov 184(%rsp), %rdi
    mov 192(%rsp), %rsi
    call sunstoneResolve
    mov %rax, %r11
    movups (%rsp), %xmm0
    movups 16(%rsp), %xmm1
    movups 32(%rsp), %xmm2
    movups 48(%rsp), %xmm3
    movups 64(%rsp), %xmm4
    movups 80(%rsp), %xmm5
    movups 96(%rsp), %xmm6
    movups 112(%rsp), %xmm7
    add $128, %rsp
    pop %rax
    pop %r9
    pop %r8
    pop %rcx
    pop %rdx
    pop %rsi
    pop %rdi
    add $16, %rsp
    jmp *%r11
    .size sunstoneResolver, .-sunstoneResolver
)");
extern "C" __attribute__((visibility("hidden"))) void sunstoneResolver();

namespace sunstone::redirect {

namespace {

constexpr size_t kPage = 4096, kCodeOfEntry = 16;
constexpr uintptr_t kReach = uintptr_t(1) << 30;

constexpr size_t roundUp(size_t size) {
    return (size + kPage - 1) / kPage * kPage;
}

// Maps memory before the module, else behind it. Programs grow their heap behind the main program,
// so that place is the second choice.
uint8_t* mapNear(size_t size, uintptr_t low, uintptr_t high) {
    constexpr int kFlags = MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED_NOREPLACE;
    const auto attempt = [&](uintptr_t address) -> uint8_t* {
        uint8_t* at = mapMemory(address, size, PROT_READ | PROT_WRITE, kFlags);
        if (at && reinterpret_cast<uintptr_t>(at) != address) { // kernels before 4.17
            unmapMemory(at, size);
            at = nullptr;
        }
        return at;
    };
    low = low / kPage * kPage;
    high = roundUp(high);
    for (uintptr_t step = 0; step < kReach;
         step += step < 64 * kPage ? size : step / 8 / kPage * kPage) {
        if (low > size + step + 16 * kPage)
            if (uint8_t* at = attempt(low - size - step))
                return at;
        if (step >= 16 * kPage)
            if (uint8_t* at = attempt(high + step))
                return at;
    }
    return nullptr;
}

// Tables of closed files. The loader's lock protects the list.
Entries* firstFree = nullptr;

uint8_t* takeFree(size_t size, uintptr_t low, uintptr_t high) {
    for (Entries** link = &firstFree; *link; link = &(*link)->nextFree) {
        const auto at = reinterpret_cast<uintptr_t>((*link)->region);
        if ((*link)->regionSize != size || at + kReach < high || at > low + kReach)
            continue;
        *link = (*link)->nextFree;
        auto* region = reinterpret_cast<uint8_t*>(at);
        if (protectMemory(at, size, PROT_READ | PROT_WRITE))
            return region;
        unmapMemory(region, size);
        return nullptr;
    }
    return nullptr;
}

class Writer {
public:
    explicit Writer(uint8_t* at) : at_(at) {}
    template <class... Bytes>
    Writer& bytes(Bytes... values) {
        ((*at_++ = uint8_t(values)), ...);
        return *this;
    }
    Writer& number(uint32_t value) { return bytes(value, value >> 8, value >> 16, value >> 24); }
    // Writes the distance from the end of the instruction, whose last bytes it is.
    Writer& distance(const void* target) {
        return number(uint32_t(static_cast<const uint8_t*>(target) - (at_ + 4)));
    }

private:
    uint8_t* at_;
};

} // namespace

Entries* makeEntries(const Runtime& runtime, size_t count, uintptr_t low, uintptr_t high) {
    const size_t codeSize = roundUp((count + 1) * kCodeOfEntry);
    const size_t dataSize = roundUp(sizeof(Entries) + count * (sizeof(void*) + sizeof(uint16_t)));
    uint8_t* region = takeFree(codeSize + dataSize, low, high);
    if (!region)
        region = mapNear(codeSize + dataSize, low, high);
    if (!region)
        return nullptr;
    uint8_t* data = region + codeSize;
    auto* entries = reinterpret_cast<Entries*>(data);
    auto* slots = reinterpret_cast<void**>(data + sizeof(Entries));
    *entries = {&runtime,
                reinterpret_cast<uint16_t*>(slots + count),
                slots,
                reinterpret_cast<void*>(&sunstoneResolver),
                region,
                region,
                codeSize + dataSize,
                nullptr};
    uint8_t* common = region + count * kCodeOfEntry;
    // lea entries(%rip), %r11; push %r11; jmp *resolver(%rip)
    Writer(common).bytes(0x4C, 0x8D, 0x1D).distance(entries).bytes(0x41, 0x53);
    Writer(common + 9).bytes(0xFF, 0x25).distance(&entries->resolver);
    for (size_t i = 0; i < count; ++i) {
        uint8_t* code = region + i * kCodeOfEntry;
        // jmp *slot(%rip); push $i; jmp common
        Writer(code).bytes(0xFF, 0x25).distance(slots + i);
        Writer(code + 6).bytes(0x68).number(uint32_t(i)).bytes(0xE9).distance(common);
        slots[i] = code + 6;
    }
    return entries;
}

void setName(Entries& entries, size_t index, uint16_t name) {
    const_cast<uint16_t*>(entries.names)[index] = name;
}

uintptr_t addressOf(const Entries& entries, size_t index) {
    return reinterpret_cast<uintptr_t>(entries.code) + index * kCodeOfEntry;
}

bool seal(Entries& entries) {
    const size_t codeSize = size_t(reinterpret_cast<uint8_t*>(&entries) - entries.region);
    return protectMemory(reinterpret_cast<uintptr_t>(entries.region), codeSize,
                         PROT_READ | PROT_EXEC);
}

void keepForReuse(Entries* entries) {
    entries->nextFree = firstFree;
    firstFree = entries;
}

} // namespace sunstone::redirect
