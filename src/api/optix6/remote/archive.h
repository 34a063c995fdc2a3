// SPDX-License-Identifier: Apache-2.0
// Serialization of messages between ranks. Both sides name the same fields in the same order: one
// function fields(archive, object) serves a Writer and a Reader. All ranks run the same build on
// machines of one kind, so values travel as they are in memory.
#pragma once

#include "api/optix6/object.h"

#include <cstring>
#include <functional>
#include <map>
#include <string>
#include <type_traits>
#include <vector>

namespace sunstone::optix6 {

template <class T>
concept Plain = std::is_trivially_copyable_v<T>;

class Writer {
public:
    static constexpr bool kWrites = true;
    explicit Writer(std::function<void(const std::shared_ptr<Object>&)> onReference = {})
        : onReference_(std::move(onReference)) {}
    std::string bytes;

    template <class... T>
    void all(const T&... values) {
        (item(values), ...);
    }

    template <Plain T>
    void item(const T& value) {
        raw(&value, sizeof value);
    }
    void item(const std::string& text) {
        item(uint64_t(text.size()));
        raw(text.data(), text.size());
    }
    template <class T>
    void item(const std::vector<T>& list) {
        item(uint64_t(list.size()));
        for (const T& each : list)
            item(each);
    }
    template <class K, class T>
    void item(const std::map<K, T>& list) {
        item(uint64_t(list.size()));
        for (const auto& [key, value] : list)
            all(key, value);
    }
    template <class T>
    void item(const Ref<T>& ref) {
        const std::shared_ptr<T> object = ref.lock();
        item(object ? reinterpret_cast<uint64_t>(object->handle()) : uint64_t(0));
        if (object && onReference_)
            onReference_(object);
    }

    // Many plain values without a count.
    template <Plain T>
    void items(const T* values, size_t count) {
        raw(values, count * sizeof(T));
    }

private:
    void raw(const void* data, size_t size) { bytes.append(static_cast<const char*>(data), size); }
    std::function<void(const std::shared_ptr<Object>&)> onReference_;
};

class Reader {
public:
    static constexpr bool kWrites = false;
    // `find(number)`: the object of a reference; null means that the message is invalid.
    explicit Reader(std::string_view bytes,
                    std::function<std::shared_ptr<Object>(uint64_t)> find = {})
        : rest_(bytes), find_(std::move(find)) {}
    bool atEnd() const { return rest_.empty(); }

    template <class... T>
    void all(T&... values) {
        (item(values), ...);
    }
    template <class T>
    T get() {
        T value{};
        item(value);
        return value;
    }

    template <Plain T>
    void item(T& value) {
        std::memcpy(&value, take(sizeof value).data(), sizeof value);
    }
    void item(std::string& text) { text = take(get<uint64_t>()); }
    template <class T>
    void item(std::vector<T>& list) {
        const uint64_t count = countOfItems();
        list.clear();
        for (uint64_t i = 0; i < count; ++i)
            item(list.emplace_back());
    }
    template <class K, class T>
    void item(std::map<K, T>& list) {
        const uint64_t count = countOfItems();
        list.clear();
        for (uint64_t i = 0; i < count; ++i) {
            K key{};
            item(key);
            item(list[key]);
        }
    }
    template <class T>
    void item(Ref<T>& ref) {
        ref.reset();
        const auto number = get<uint64_t>();
        if (number == 0)
            return;
        const auto object = std::dynamic_pointer_cast<T>(find_ ? find_(number) : nullptr);
        if (!object)
            fail(Code::kInternal, "a message between ranks names an unknown object");
        ref = object;
    }

    template <Plain T>
    void items(T* values, size_t count) {
        std::memcpy(values, take(count * sizeof(T)).data(), count * sizeof(T));
    }

private:
    std::string_view take(uint64_t size) {
        if (size > rest_.size())
            fail(Code::kInternal, "a message between ranks is too short");
        const std::string_view taken = rest_.substr(0, size);
        rest_.remove_prefix(size);
        return taken;
    }
    // Each item has at least one byte, so a message cannot request more memory than its own size.
    uint64_t countOfItems() {
        const auto count = get<uint64_t>();
        if (count > rest_.size())
            fail(Code::kInternal, "a message between ranks is too short");
        return count;
    }
    std::string_view rest_;
    std::function<std::shared_ptr<Object>(uint64_t)> find_;
};

} // namespace sunstone::optix6
