// SPDX-License-Identifier: Apache-2.0
#include "gltf_file.h"

#include <algorithm>
#include <bit>
#include <filesystem>

namespace model::gltf {
namespace {

constexpr uint32_t kMagic = 0x46546C67;       // "glTF"
constexpr uint32_t kJsonChunk = 0x4E4F534A;   // "JSON"
constexpr uint32_t kBinaryChunk = 0x004E4942; // "BIN"

uint32_t word(const std::string& bytes, size_t at) {
    uint32_t value = 0;
    for (size_t i = 0; i < 4; ++i)
        value |= uint32_t(uint8_t(bytes[at + i])) << (8 * i);
    return value;
}

int base64Value(char c) {
    if (c >= 'A' && c <= 'Z')
        return c - 'A';
    if (c >= 'a' && c <= 'z')
        return c - 'a' + 26;
    if (c >= '0' && c <= '9')
        return c - '0' + 52;
    if (c == '+' || c == '-')
        return 62;
    if (c == '/' || c == '_')
        return 63;
    return -1;
}

std::string decodeBase64(std::string_view text) {
    std::string bytes;
    uint32_t bits = 0;
    int count = 0;
    for (char c : text) {
        if (c == '=')
            break;
        int value = base64Value(c);
        if (value < 0)
            throw ModelError("a data URI is not valid base64");
        bits = bits << 6 | uint32_t(value);
        count += 6;
        if (count >= 8) {
            count -= 8;
            bytes.push_back(char(bits >> count & 0xff));
        }
    }
    return bytes;
}

// "a%20b" to "a b".
std::string decodePercent(const std::string& uri) {
    std::string text;
    for (size_t i = 0; i < uri.size(); ++i) {
        if (uri[i] == '%' && i + 2 < uri.size() && isxdigit(uint8_t(uri[i + 1])) &&
            isxdigit(uint8_t(uri[i + 2]))) {
            text.push_back(char(std::stoi(uri.substr(i + 1, 2), nullptr, 16)));
            i += 2;
        } else {
            text.push_back(uri[i]);
        }
    }
    return text;
}

std::string readUri(const std::string& uri, const std::string& folder) {
    if (uri.rfind("data:", 0) == 0) {
        size_t comma = uri.find(";base64,");
        if (comma == std::string::npos)
            throw ModelError("a data URI is not base64");
        return decodeBase64(std::string_view(uri).substr(comma + 8));
    }
    return readBeside(folder, decodePercent(uri));
}

struct ComponentType {
    unsigned size;
    bool isFloat, isSigned;
};

ComponentType componentType(uint64_t code) {
    switch (code) {
    case 5120:
        return {1, false, true};
    case 5121:
        return {1, false, false};
    case 5122:
        return {2, false, true};
    case 5123:
        return {2, false, false};
    case 5125:
        return {4, false, false};
    case 5126:
        return {4, true, true};
    default:
        throw ModelError("an accessor has the unknown component type " + std::to_string(code));
    }
}

double decode(const std::string& bytes, size_t at, const ComponentType& type, bool normalized) {
    uint32_t bits = 0;
    for (unsigned i = 0; i < type.size; ++i)
        bits |= uint32_t(uint8_t(bytes[at + i])) << (8 * i);
    if (type.isFloat)
        return double(std::bit_cast<float>(bits));
    unsigned unused = 32 - 8 * type.size;
    double value = type.isSigned ? double(int32_t(bits << unused) >> unused) : double(bits);
    if (!normalized)
        return value;
    double largest = double((uint64_t(1) << (8 * type.size - (type.isSigned ? 1 : 0))) - 1);
    return std::max(value / largest, -1.0);
}

unsigned componentsOf(const std::string& type) {
    if (type == "SCALAR")
        return 1;
    if (type.size() == 4 && type.rfind("VEC", 0) == 0)
        return unsigned(type[3] - '0');
    return 0;
}

} // namespace

const Json* find(const Json& object, const char* key) {
    if (!object.is_object())
        return nullptr;
    auto member = object.find(key);
    return member == object.end() ? nullptr : &*member;
}

const Json& array(const Json& value, const char* key) {
    if (!value.is_array())
        throw ModelError(std::string("\"") + key + "\" is not an array");
    return value;
}

double number(const Json& object, const char* key, double fallback) {
    const Json* member = find(object, key);
    if (!member)
        return fallback;
    if (!member->is_number())
        throw ModelError(std::string("\"") + key + "\" is not a number");
    return member->get<double>();
}

uint64_t index(const Json& object, const char* key, uint64_t fallback) {
    const Json* member = find(object, key);
    if (!member)
        return fallback;
    if (!member->is_number_unsigned())
        throw ModelError(std::string("\"") + key + "\" is not a whole number");
    return member->get<uint64_t>();
}

File::File(const std::string& path) : folder_(std::filesystem::path(path).parent_path().string()) {
    std::string bytes = readFile(path), json;
    if (bytes.size() >= 4 && word(bytes, 0) == kMagic)
        splitGlb(bytes, json);
    else
        json = std::move(bytes);
    root_ = Json::parse(json, nullptr, false);
    if (root_.is_discarded() || !root_.is_object())
        throw ModelError("is not glTF (its JSON is malformed)");
    const Json* asset = find(root_, "asset");
    const Json* version = asset ? find(*asset, "version") : nullptr;
    if (!version || !version->is_string() || version->get<std::string>().rfind("2.", 0) != 0)
        throw ModelError("is not glTF 2.0 (asset.version)");
    if (const Json* buffers = find(root_, "buffers"))
        buffers_.resize(array(*buffers, "buffers").size());
    isRead_.resize(buffers_.size());
}

void File::splitGlb(const std::string& bytes, std::string& json) {
    if (bytes.size() < 20)
        throw ModelError("is a GLB file cut short");
    if (word(bytes, 4) != 2)
        throw ModelError("is of GLB version " + std::to_string(word(bytes, 4)) + ", not 2");
    bool hasJson = false;
    for (size_t at = 12; at + 8 <= bytes.size();) {
        size_t length = word(bytes, at);
        uint32_t kind = word(bytes, at + 4);
        at += 8;
        if (length > bytes.size() - at)
            throw ModelError("is a GLB file cut short");
        if (kind == kJsonChunk && !hasJson) {
            json = bytes.substr(at, length);
            hasJson = true;
        } else if (kind == kBinaryChunk && !hasBinaryChunk_) {
            binaryChunk_ = bytes.substr(at, length);
            hasBinaryChunk_ = true;
        }
        at += (length + 3) / 4 * 4;
    }
    if (!hasJson)
        throw ModelError("is a GLB file without a JSON chunk");
}

const Json& File::element(const char* list, const Json& reference) const {
    const Json* members = find(root_, list);
    if (!members || !members->is_array() || !reference.is_number_unsigned() ||
        reference.get<uint64_t>() >= members->size())
        throw ModelError(std::string("refers to element ") + reference.dump() + " of \"" + list +
                         "\", which does not exist");
    return (*members)[reference.get<size_t>()];
}

const std::string& File::buffer(const Json& reference) {
    const Json& description = element("buffers", reference);
    size_t number = reference.get<size_t>();
    if (!isRead_[number]) {
        const Json* uri = find(description, "uri");
        if (uri && uri->is_string())
            buffers_[number] = readUri(uri->get<std::string>(), folder_);
        else if (hasBinaryChunk_ && number == 0)
            buffers_[number] = binaryChunk_;
        else
            throw ModelError("buffer " + std::to_string(number) + " has no data");
        isRead_[number] = true;
    }
    return buffers_[number];
}

std::string File::viewBytes(const Json& reference) {
    const Json& view = element("bufferViews", reference);
    const Json* bufferReference = find(view, "buffer");
    if (!bufferReference)
        throw ModelError("a buffer view names no buffer");
    const std::string& bytes = buffer(*bufferReference);
    const uint64_t start = index(view, "byteOffset", 0), size = index(view, "byteLength", 0);
    if (start > bytes.size() || size > bytes.size() - start)
        throw ModelError("a buffer view reaches beyond its buffer");
    return bytes.substr(start, size);
}

std::string File::image(const Json& reference) {
    const Json& description = element("images", reference);
    const Json* uri = find(description, "uri");
    if (uri && uri->is_string())
        return readUri(uri->get<std::string>(), folder_);
    const Json* view = find(description, "bufferView");
    if (!view)
        throw ModelError("image " + reference.dump() + " has no data");
    return viewBytes(*view);
}

std::vector<double> File::read(const Json& reference, unsigned components) {
    const Json& accessor = element("accessors", reference);
    const Json* typeName = find(accessor, "type");
    if (!typeName || !typeName->is_string() ||
        componentsOf(typeName->get<std::string>()) != components)
        throw ModelError("accessor " + reference.dump() + " is not of the type its use asks for");
    if (find(accessor, "sparse"))
        throw ModelError("has sparse accessors, which are not supported");
    const Json* viewReference = find(accessor, "bufferView");
    if (!viewReference)
        throw ModelError("accessor " + reference.dump() + " has no buffer view");
    const Json& view = element("bufferViews", *viewReference);
    const Json* bufferReference = find(view, "buffer");
    if (!bufferReference)
        throw ModelError("a buffer view names no buffer");
    const std::string& bytes = buffer(*bufferReference);

    ComponentType type = componentType(index(accessor, "componentType", 0));
    const Json* flag = find(accessor, "normalized");
    bool normalized = flag && flag->is_boolean() && flag->get<bool>();
    uint64_t count = index(accessor, "count", 0);
    uint64_t elementSize = uint64_t(type.size) * components;
    uint64_t stride = index(view, "byteStride", 0);
    if (stride == 0)
        stride = elementSize;
    uint64_t viewStart = index(view, "byteOffset", 0), viewSize = index(view, "byteLength", 0);
    uint64_t offset = index(accessor, "byteOffset", 0);
    // Each bound is checked before its use in the next sum, to avoid overflow.
    if (viewStart > bytes.size() || viewSize > bytes.size() - viewStart || offset > viewSize ||
        stride > (1u << 16))
        throw ModelError("a buffer view reaches beyond its buffer");
    uint64_t room = viewSize - offset;
    if (count != 0 && (elementSize > room || count - 1 > (room - elementSize) / stride))
        throw ModelError("accessor " + reference.dump() + " claims " + std::to_string(count) +
                         " elements, more than its buffer holds");

    std::vector<double> values;
    values.reserve(count * components);
    for (uint64_t i = 0; i < count; ++i)
        for (unsigned c = 0; c < components; ++c)
            values.push_back(
                decode(bytes, viewStart + offset + i * stride + c * type.size, type, normalized));
    return values;
}

} // namespace model::gltf
