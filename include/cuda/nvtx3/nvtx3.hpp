// SPDX-License-Identifier: Apache-2.0
// NVTX 3 for C++ (namespace nvtx3): ranges that end with their scope, marks, domains, categories,
// registered strings. Like nvToolsExt.h, all of it does nothing. C++11.
#ifndef SUNSTONE_NVTX3_HPP
#define SUNSTONE_NVTX3_HPP

#include "nvToolsExt.h"

#include <cstdint>
#include <string>
#include <utility>

#define NVTX3_CPP_VERSION_MAJOR 1
#define NVTX3_CPP_VERSION_MINOR 0

namespace nvtx3 {
inline namespace v1 {

class domain {
public:
    // The default domain.
    struct global {};

    domain(domain const&) = delete;
    domain& operator=(domain const&) = delete;

    template <class D = global>
    static domain const& get() noexcept {
        static domain const the;
        return the;
    }
    operator nvtxDomainHandle_t() const noexcept { return nullptr; }

private:
    domain() = default;
};

struct rgb {
    using component_type = std::uint8_t;
    constexpr rgb(component_type r, component_type g, component_type b) noexcept
        : red(r), green(g), blue(b) {}
    component_type red, green, blue;
};
struct argb final : rgb {
    constexpr argb(component_type a, component_type r, component_type g, component_type b) noexcept
        : rgb(r, g, b), alpha(a) {}
    component_type alpha;
};
class color {
public:
    using value_type = std::uint32_t;
    constexpr explicit color(value_type argb) noexcept : value_(argb) {}
    constexpr color(argb c) noexcept
        : value_(value_type(c.alpha) << 24 | value_type(c.red) << 16 | value_type(c.green) << 8 |
                 c.blue) {}
    constexpr color(rgb c) noexcept : color(argb(255, c.red, c.green, c.blue)) {}
    constexpr value_type get_value() const noexcept { return value_; }
    constexpr nvtxColorType_t get_type() const noexcept { return NVTX_COLOR_ARGB; }

private:
    value_type value_;
};

class category {
public:
    using id_type = std::uint32_t;
    constexpr explicit category(id_type id) noexcept : id_(id) {}
    constexpr id_type get_id() const noexcept { return id_; }

private:
    id_type id_;
};
template <class D = domain::global>
class named_category_in final : public category {
public:
    template <class C>
    static named_category_in const& get() noexcept {
        static named_category_in const the(C::id, C::name);
        return the;
    }
    named_category_in(id_type id, char const*) noexcept : category(id) {}
    named_category_in(id_type id, wchar_t const*) noexcept : category(id) {}
};
using named_category = named_category_in<domain::global>;

template <class D = domain::global>
class registered_string_in {
public:
    template <class M>
    static registered_string_in const& get() noexcept {
        static registered_string_in const the(M::message);
        return the;
    }
    explicit registered_string_in(char const*) noexcept {}
    explicit registered_string_in(wchar_t const*) noexcept {}
    explicit registered_string_in(std::string const&) noexcept {}
    explicit registered_string_in(std::wstring const&) noexcept {}
    nvtxStringHandle_t get_handle() const noexcept { return nullptr; }
};
using registered_string = registered_string_in<domain::global>;

class message {
public:
    using value_type = nvtxMessageValue_t;
    message(char const* text) noexcept : type_(NVTX_MESSAGE_TYPE_ASCII) { value_.ascii = text; }
    message(std::string const& text) noexcept : message(text.c_str()) {}
    message(std::string&&) = delete; // its text would be freed
    message(wchar_t const* text) noexcept : type_(NVTX_MESSAGE_TYPE_UNICODE) {
        value_.unicode = text;
    }
    message(std::wstring const& text) noexcept : message(text.c_str()) {}
    message(std::wstring&&) = delete;
    template <class D>
    message(registered_string_in<D> const& text) noexcept : type_(NVTX_MESSAGE_TYPE_REGISTERED) {
        value_.registered = text.get_handle();
    }
    value_type get_value() const noexcept { return value_; }
    nvtxMessageType_t get_type() const noexcept { return type_; }

private:
    nvtxMessageType_t type_;
    value_type value_;
};

class payload {
public:
    using value_type = decltype(nvtxEventAttributes_t::payload);
    explicit payload(std::int64_t v) noexcept : type_(NVTX_PAYLOAD_TYPE_INT64) {
        value_.llValue = v;
    }
    explicit payload(std::int32_t v) noexcept : type_(NVTX_PAYLOAD_TYPE_INT32) {
        value_.iValue = v;
    }
    explicit payload(std::uint64_t v) noexcept : type_(NVTX_PAYLOAD_TYPE_UNSIGNED_INT64) {
        value_.ullValue = v;
    }
    explicit payload(std::uint32_t v) noexcept : type_(NVTX_PAYLOAD_TYPE_UNSIGNED_INT32) {
        value_.uiValue = v;
    }
    explicit payload(float v) noexcept : type_(NVTX_PAYLOAD_TYPE_FLOAT) { value_.fValue = v; }
    explicit payload(double v) noexcept : type_(NVTX_PAYLOAD_TYPE_DOUBLE) { value_.dValue = v; }
    value_type get_value() const noexcept { return value_; }
    nvtxPayloadType_t get_type() const noexcept { return type_; }

private:
    nvtxPayloadType_t type_;
    value_type value_;
};

// The first argument of each kind counts.
class event_attributes {
public:
    using value_type = nvtxEventAttributes_t;
    event_attributes() noexcept : value_() {
        value_.version = NVTX_VERSION;
        value_.size = sizeof(value_type);
    }
    template <class... Args>
    explicit event_attributes(category const& c, Args const&... rest) noexcept
        : event_attributes(rest...) {
        value_.category = c.get_id();
    }
    template <class... Args>
    explicit event_attributes(color const& c, Args const&... rest) noexcept
        : event_attributes(rest...) {
        value_.color = c.get_value();
        value_.colorType = c.get_type();
    }
    template <class... Args>
    explicit event_attributes(rgb const& c, Args const&... rest) noexcept
        : event_attributes(color(c), rest...) {}
    template <class... Args>
    explicit event_attributes(argb const& c, Args const&... rest) noexcept
        : event_attributes(color(c), rest...) {}
    template <class... Args>
    explicit event_attributes(payload const& p, Args const&... rest) noexcept
        : event_attributes(rest...) {
        value_.payload = p.get_value();
        value_.payloadType = p.get_type();
    }
    template <class... Args>
    explicit event_attributes(message const& m, Args const&... rest) noexcept
        : event_attributes(rest...) {
        value_.message = m.get_value();
        value_.messageType = m.get_type();
    }
    value_type const* get() const noexcept { return &value_; }

private:
    value_type value_;
};

template <class D = domain::global>
class scoped_range_in {
public:
    explicit scoped_range_in(event_attributes const&) noexcept {}
    template <class... Args>
    explicit scoped_range_in(Args const&... args) noexcept
        : scoped_range_in(event_attributes(args...)) {}
    scoped_range_in() noexcept {}
    ~scoped_range_in() noexcept {} // avoids warnings of unused ranges
    scoped_range_in(scoped_range_in const&) = delete;
    scoped_range_in& operator=(scoped_range_in const&) = delete;
    void* operator new(std::size_t) = delete;
};
using scoped_range = scoped_range_in<domain::global>;

struct range_handle {
    using value_type = nvtxRangeId_t;
    constexpr explicit range_handle(value_type id) noexcept : id_(id) {}
    constexpr range_handle() noexcept : id_(0) {}
    constexpr range_handle(std::nullptr_t) noexcept : id_(0) {}
    constexpr explicit operator bool() const noexcept { return id_ != 0; }
    constexpr value_type get_value() const noexcept { return id_; }

private:
    value_type id_;
};
inline bool operator==(range_handle a, range_handle b) noexcept {
    return a.get_value() == b.get_value();
}
inline bool operator!=(range_handle a, range_handle b) noexcept {
    return !(a == b);
}

template <class D = domain::global, class... Args>
range_handle start_range_in(Args const&... args) noexcept {
    (void)event_attributes(args...);
    return range_handle();
}
template <class... Args>
range_handle start_range(Args const&... args) noexcept {
    return start_range_in<domain::global>(args...);
}
template <class D = domain::global>
void end_range_in(range_handle) noexcept {}
inline void end_range(range_handle) noexcept {}

template <class D = domain::global>
class unique_range_in {
public:
    template <class... Args>
    explicit unique_range_in(Args const&... args) noexcept {
        (void)event_attributes(args...);
    }
    unique_range_in(unique_range_in&&) noexcept {}
    unique_range_in& operator=(unique_range_in&&) noexcept { return *this; }
    unique_range_in(unique_range_in const&) = delete;
    unique_range_in& operator=(unique_range_in const&) = delete;
    ~unique_range_in() noexcept {}
};
using unique_range = unique_range_in<domain::global>;

template <class D = domain::global, class... Args>
void mark_in(Args const&... args) noexcept {
    (void)event_attributes(args...);
}
template <class... Args>
void mark(Args const&... args) noexcept {
    mark_in<domain::global>(args...);
}

} // namespace v1
} // namespace nvtx3

#define NVTX3_FUNC_RANGE_IN(D) ::nvtx3::scoped_range_in<D> const nvtx3_range__(__func__)
#define NVTX3_FUNC_RANGE() NVTX3_FUNC_RANGE_IN(::nvtx3::domain::global)
#define NVTX3_FUNC_RANGE_IF_IN(D, condition) NVTX3_FUNC_RANGE_IN(D)
#define NVTX3_FUNC_RANGE_IF(condition) NVTX3_FUNC_RANGE()

#endif
