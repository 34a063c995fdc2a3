// SPDX-License-Identifier: Apache-2.0
// A client of one release: its table, filled by position, and a small scene rendered through it.
// Every struct has garbage padding and ends directly before an unreadable page, so that a library
// that reads beyond the struct faults.
#pragma once

#include "releases.h"

#include <gtest/gtest.h>

#include <sys/mman.h>

#include <cstring>
#include <memory>
#include <new>
#include <string>
#include <vector>

namespace tests::abi {

// Memory that ends at a page which cannot be touched.
class GuardedMemory {
public:
    explicit GuardedMemory(size_t size);
    GuardedMemory(GuardedMemory&& other) noexcept;
    ~GuardedMemory();
    void* data() const { return data_; }

private:
    void* pages_ = nullptr;
    size_t mapped_ = 0;
    void* data_ = nullptr;
};

// A struct, or an array of them, in guarded memory; unset bytes are 0xA5.
template <class T>
class Guarded {
public:
    explicit Guarded(size_t count = 1) : memory_(count * sizeof(T)) {}
    T* operator->() { return get(); }
    T& operator[](size_t i) { return get()[i]; }
    T* get() { return static_cast<T*>(memory_.data()); }
    operator const void*() { return get(); } // NOLINT: arguments are passed so
private:
    GuardedMemory memory_;
};

// Sets members and leaves the padding between them unchanged.
template <class T, class Value>
void set(T& member, Value value) {
    const T converted = T(value);
    std::memcpy(static_cast<void*>(&member), &converted, sizeof(T));
}

// Device memory: on the CPU without CUDA, memory of this process.
class Memory {
public:
    explicit Memory(size_t size)
        : data_(::operator new(size + 1, std::align_val_t(128))), size_(size) {
        std::memset(data_, 0, size);
    }
    template <class T>
    explicit Memory(const std::vector<T>& values) : Memory(values.size() * sizeof(T)) {
        std::memcpy(data_, values.data(), size_);
    }
    Memory(Memory&& other) noexcept : data_(other.data_), size_(other.size_) {
        other.data_ = nullptr;
    }
    ~Memory() { ::operator delete(data_, std::align_val_t(128)); }
    DevicePointer address() const { return reinterpret_cast<DevicePointer>(data_); }
    size_t size() const { return size_; }
    template <class T>
    T* as() const {
        return static_cast<T*>(data_);
    }

private:
    void* data_;
    size_t size_;
};

constexpr int kSuccess = 0;
constexpr int kInvalidValue = 7001;
constexpr int kNotSupported = 7800;

// The function table of one ABI.
class Table {
public:
    explicit Table(int abi);
    // The function of a slot, with the signature the release gives it.
    template <class Function>
    Function* function(const std::string& name) const {
        return reinterpret_cast<Function*>(slots_[indexOf(name)]);
    }
    bool has(const std::string& name) const;
    template <class... Arguments>
    int call(const std::string& name, Arguments... arguments) const {
        return function<int(Arguments...)>(name)(arguments...);
    }
    const std::vector<void*>& slots() const { return slots_; }

private:
    size_t indexOf(const std::string& name) const;
    std::vector<std::string> names_;
    std::vector<void*> slots_;
};

using Query = int(int abi, unsigned numOptions, int* options, const void** values, void* table,
                  size_t size);
Query* queryFunction();

// Log lines of a context.
struct Log {
    std::string text;
    static void callback(unsigned level, const char* tag, const char* message, void* self);
};

struct Image {
    unsigned width = 0, height = 0;
    std::vector<uint32_t> words; // two for each pixel
    bool operator==(const Image&) const = default;
};

// PTX of the scene's programs with the intrinsics that a release's headers compile to; rays have
// these flags. showTime: rays have the time 0.5, and misses store the time in place of a constant.
std::string scenePtx(int abi, unsigned rayFlags = 0, bool showTime = false);

} // namespace tests::abi
