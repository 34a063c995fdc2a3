// SPDX-License-Identifier: Apache-2.0
// A C API that records its calls as text, for tests of the C++ wrapper: "rtBufferSetSize1D(buffer,
// 3)". Output parameters get numbers or new objects, and appear as "out".
#pragma once

#include <optix_cuda_interop.h>
#include <optix_gl_interop.h>
#include <optix_host.h>
#include <optixu/optixu.h>

#include <map>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

struct Recorder {
    std::vector<std::string> calls;
    std::map<const void*, std::string> names; // of objects and of memory
    std::map<std::string, RTresult> results;  // of functions that shall fail
    std::map<std::string, int> numbers;       // that functions give, else kNumber
    std::map<std::string, void*> objects;     // that functions give, else new ones
    static const int kNumber = 41;
    char storage[1 << 16]; // addresses of objects
    size_t used = 0;

    void* newObject() { return storage + ++used; }
};
extern Recorder recorder;

class Call {
public:
    explicit Call(const char* name) : name_(name), text_(std::string(name) + "(") {}

    // Arguments.
    template <typename T>
    void add(T value) {
        addValue(value, std::is_pointer<T>());
    }
    void add(const char* text) { next(text ? text : "null"); }
    void add(const void* memory) { next(nameOf(memory)); }
    void add(void* memory) { next(nameOf(memory)); } // objects of any class, too
    void add(RTtimeoutcallback callback) { next(callback ? "callback" : "null"); }
    void add(RTusagereportcallback callback) { next(callback ? "callback" : "null"); }
    // A list of strings or objects, or an output parameter for one.
    void add(const char** text) {
        if (isGetter() && text)
            *text = "text";
        next(isGetter() ? "out" : text ? nameOf(text) : "null");
    }
    void add(void** place) {
        if (place)
            *place = object();
        next(place ? "out" : "null");
    }

    template <typename... T>
    void addAll(T... values) {
        (add(values), ...);
    }

    RTresult finish() {
        recorder.calls.push_back(text_ + ")");
        const auto found = recorder.results.find(name_);
        return found == recorder.results.end() ? RT_SUCCESS : found->second;
    }

private:
    bool isGetter() const { return name_.find("Get") != std::string::npos; }
    void next(const std::string& text) { text_ += (text_.back() == '(' ? "" : ", ") + text; }
    void* object() const {
        const auto found = recorder.objects.find(name_);
        return found == recorder.objects.end() ? recorder.newObject() : found->second;
    }
    static std::string nameOf(const void* p) {
        if (!p)
            return "null";
        const auto found = recorder.names.find(p);
        return found == recorder.names.end() ? "input" : found->second;
    }

    template <typename T>
    void addValue(T value, std::false_type) {
        std::ostringstream text;
        text << value;
        next(text.str());
    }
    template <typename T>
    void addValue(T pointer, std::true_type) {
        addPointer(pointer, std::is_class<typename std::remove_pointer<T>::type>());
    }
    // Objects are pointers to classes without a definition.
    template <typename T>
    void addPointer(T* object, std::true_type) {
        next(nameOf(object));
    }
    template <typename T>
    void addPointer(T* place, std::false_type) {
        addPlace(place, std::is_const<T>());
    }
    template <typename T>
    void addPlace(T* input, std::true_type) {
        next(nameOf(input));
    }
    template <typename T>
    void addPlace(T* place, std::false_type) {
        if (name_.find("MultiBuffer") != std::string::npos)
            return next(nameOf(*reinterpret_cast<void**>(place)));
        if (place)
            assign(*place);
        next(place ? "out" : "null");
    }
    template <typename T>
    void assign(T*& object_) {
        object_ = static_cast<T*>(object());
    }
    template <typename T>
    void assign(T& value) {
        const auto found = recorder.numbers.find(name_);
        value = static_cast<T>(found == recorder.numbers.end() ? Recorder::kNumber : found->second);
    }

    std::string name_, text_;
};
