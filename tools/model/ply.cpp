// SPDX-License-Identifier: Apache-2.0
// PLY files, ascii and binary of both byte orders. Elements other than "vertex" and "face" are
// skipped. Counts in the header are not trusted: the loader reserves only as much memory as the
// file's size justifies. Source: Greg Turk's description of the format (1994).
#include "model.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>

namespace model {
namespace {

enum class Format { kAscii, kLittle, kBig };

struct Number {
    unsigned size = 0; // bytes; 0: unknown type
    bool isFloat = false, isSigned = false;
};

Number numberType(const std::string& name) {
    if (name == "char" || name == "int8")
        return {1, false, true};
    if (name == "uchar" || name == "uint8")
        return {1, false, false};
    if (name == "short" || name == "int16")
        return {2, false, true};
    if (name == "ushort" || name == "uint16")
        return {2, false, false};
    if (name == "int" || name == "int32")
        return {4, false, true};
    if (name == "uint" || name == "uint32")
        return {4, false, false};
    if (name == "float" || name == "float32")
        return {4, true, true};
    if (name == "double" || name == "float64")
        return {8, true, true};
    throw ModelError("PLY header: unknown type \"" + name + "\"");
}

struct Property {
    std::string name;
    Number type;
    Number countType; // size 0: no list
};

struct Element {
    std::string name;
    uint64_t count = 0;
    std::vector<Property> properties;

    int find(std::string_view wanted) const {
        for (size_t i = 0; i < properties.size(); ++i)
            if (properties[i].name == wanted)
                return int(i);
        return -1;
    }
};

struct Header {
    Format format = Format::kAscii;
    std::vector<Element> elements;
    size_t bodyStart = 0;
};

Property parseProperty(std::istringstream& words) {
    Property property;
    std::string type;
    words >> type;
    if (type == "list") {
        std::string count;
        words >> count >> type;
        property.countType = numberType(count);
        if (property.countType.isFloat)
            throw ModelError("PLY header: a list's length cannot be of type " + count);
    }
    property.type = numberType(type);
    words >> property.name;
    return property;
}

Header parseHeader(const std::string& text) {
    if (text.compare(0, 3, "ply") != 0)
        throw ModelError("is not a PLY file (it does not begin with \"ply\")");
    Header header;
    bool hasFormat = false;
    for (size_t start = 0; start < text.size();) {
        size_t end = text.find('\n', start);
        if (end == std::string::npos)
            break;
        std::istringstream words(text.substr(start, end - start));
        start = end + 1;
        std::string keyword, word;
        words >> keyword;
        if (keyword == "end_header") {
            if (!hasFormat)
                throw ModelError("PLY header: no format line");
            header.bodyStart = start;
            return header;
        } else if (keyword == "format") {
            words >> word;
            hasFormat = true;
            if (word == "ascii")
                header.format = Format::kAscii;
            else if (word == "binary_little_endian")
                header.format = Format::kLittle;
            else if (word == "binary_big_endian")
                header.format = Format::kBig;
            else
                throw ModelError("PLY header: unknown format \"" + word + "\"");
        } else if (keyword == "element") {
            Element element;
            if (!(words >> element.name >> element.count))
                throw ModelError("PLY header: an element has no name or count");
            header.elements.push_back(element);
        } else if (keyword == "property") {
            if (header.elements.empty())
                throw ModelError("PLY header: a property stands before any element");
            header.elements.back().properties.push_back(parseProperty(words));
        }
    }
    throw ModelError("PLY header: no end_header line");
}

// Reads numbers one after another; throws if the file ends too early.
class Reader {
public:
    Reader(std::string_view text, Format format) : text_(text), format_(format) {}

    double number(const Number& type) {
        return format_ == Format::kAscii ? asciiNumber() : binaryNumber(type);
    }
    size_t remaining() const { return text_.size() - at_; }
    // Fewest bytes that one number takes.
    size_t smallest(const Number& type) const { return format_ == Format::kAscii ? 1 : type.size; }

private:
    [[noreturn]] static void endsEarly() { throw ModelError("ends before all its elements"); }

    double asciiNumber() {
        constexpr std::string_view kBlank = " \t\r\n";
        at_ = std::min(text_.find_first_not_of(kBlank, at_), text_.size());
        size_t end = std::min(text_.find_first_of(kBlank, at_), text_.size());
        if (at_ == end)
            endsEarly();
        std::string_view word = text_.substr(at_, end - at_);
        at_ = end;
        if (word.front() == '+')
            word.remove_prefix(1);
        double value = 0.0;
        auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        bool tiny = error == std::errc::result_out_of_range; // taken as zero
        if ((error != std::errc() && !tiny) || rest != word.data() + word.size())
            throw ModelError("\"" + std::string(word.substr(0, 20)) + "\" is not a number");
        return value;
    }

    double binaryNumber(const Number& type) {
        if (remaining() < type.size)
            endsEarly();
        uint64_t bits = 0;
        for (unsigned i = 0; i < type.size; ++i) {
            unsigned shift = 8 * (format_ == Format::kLittle ? i : type.size - 1 - i);
            bits |= uint64_t(uint8_t(text_[at_ + i])) << shift;
        }
        at_ += type.size;
        if (type.isFloat)
            return type.size == 8 ? std::bit_cast<double>(bits)
                                  : double(std::bit_cast<float>(uint32_t(bits)));
        if (!type.isSigned)
            return double(bits);
        unsigned unused = 64 - 8 * type.size;
        return double(int64_t(bits << unused) >> unused);
    }

    std::string_view text_;
    size_t at_ = 0;
    Format format_;
};

// Length of a list; a length beyond the rest of the file is an error.
size_t listLength(Reader& reader, const Property& property) {
    double length = reader.number(property.countType);
    if (!(length >= 0.0) || length != std::floor(length) ||
        length * double(reader.smallest(property.type)) > double(reader.remaining()))
        throw ModelError("a list claims more entries than the file holds");
    return size_t(length);
}

// Values of one element; lists go to `list` if their property is number `listIndex`.
void readElement(Reader& reader, const Element& element, std::vector<double>& values, int listIndex,
                 std::vector<double>& list) {
    for (size_t i = 0; i < element.properties.size(); ++i) {
        const Property& property = element.properties[i];
        if (property.countType.size == 0) {
            values[i] = reader.number(property.type);
            continue;
        }
        size_t length = listLength(reader, property);
        if (int(i) == listIndex)
            list.clear();
        for (size_t k = 0; k < length; ++k) {
            double value = reader.number(property.type);
            if (int(i) == listIndex)
                list.push_back(value);
        }
    }
}

// An element without properties takes no bytes, so that the file's size does not bound its count.
bool isEmpty(const Element& element) {
    return element.properties.empty();
}

// Colours and alpha of vertices: bytes are sRGB, floats as well, from 0 to 1.
class VertexColors {
public:
    explicit VertexColors(const Element& element) : element_(element) {
        constexpr const char* kNames[4] = {"red", "green", "blue", "alpha"};
        for (int i = 0; i < 4; ++i)
            places_[i] = element.find(kNames[i]);
    }
    void add(const std::vector<double>& values, Model& model) const {
        if (places_[0] < 0 || places_[1] < 0 || places_[2] < 0)
            return;
        model.colors.push_back({linearOf(at(values, 0)), linearOf(at(values, 1)),
                                linearOf(at(values, 2)), at(values, 3)});
    }

private:
    float at(const std::vector<double>& values, int component) const {
        if (places_[component] < 0)
            return 1.0f;
        const size_t place = size_t(places_[component]);
        const Number& type = element_.properties[place].type;
        const double largest = type.isFloat ? 1.0 : std::exp2(8.0 * type.size) - 1.0;
        return float(std::clamp(values[place] / largest, 0.0, 1.0));
    }

    const Element& element_;
    int places_[4];
};

void readVertices(Reader& reader, const Element& element, Model& model) {
    int x = element.find("x"), y = element.find("y"), z = element.find("z");
    int nx = element.find("nx"), ny = element.find("ny"), nz = element.find("nz");
    if (x < 0 || y < 0 || z < 0)
        throw ModelError("has vertices without x, y and z");
    if (element.count > std::numeric_limits<uint32_t>::max())
        throw ModelError("claims " + std::to_string(element.count) + " vertices");
    const VertexColors colors(element);
    std::vector<double> values(element.properties.size()), unused;
    for (uint64_t i = 0; i < element.count; ++i) {
        readElement(reader, element, values, -1, unused);
        model.positions.push_back({float(values[x]), float(values[y]), float(values[z])});
        bool hasNormal = nx >= 0 && ny >= 0 && nz >= 0;
        model.normals.push_back(
            hasNormal ? Vec3{float(values[nx]), float(values[ny]), float(values[nz])} : Vec3{});
        colors.add(values, model);
    }
}

uint32_t vertexNumber(double value) {
    if (!(value >= 0.0) || value > double(std::numeric_limits<uint32_t>::max()))
        throw ModelError("a face refers to a vertex that does not exist");
    return uint32_t(value);
}

void readFaces(Reader& reader, const Element& element, Model& model) {
    int indices = element.find("vertex_indices");
    if (indices < 0)
        indices = element.find("vertex_index");
    if (indices < 0 || element.properties[size_t(indices)].countType.size == 0)
        throw ModelError("has faces without a list vertex_indices");
    std::vector<double> values(element.properties.size()), corners;
    for (uint64_t i = 0; i < element.count; ++i) {
        readElement(reader, element, values, indices, corners);
        for (size_t k = 2; k < corners.size(); ++k)
            model.triangles.push_back(
                {vertexNumber(corners[0]), vertexNumber(corners[k - 1]), vertexNumber(corners[k])});
    }
}

} // namespace

Model loadPly(const std::string& path) {
    std::string text = readFile(path);
    Header header = parseHeader(text);
    Reader reader(std::string_view(text).substr(header.bodyStart), header.format);
    Model model;
    for (const Element& element : header.elements) {
        if (isEmpty(element))
            continue;
        if (element.name == "vertex") {
            readVertices(reader, element, model);
        } else if (element.name == "face") {
            readFaces(reader, element, model);
        } else {
            std::vector<double> values(element.properties.size()), unused;
            for (uint64_t i = 0; i < element.count; ++i)
                readElement(reader, element, values, -1, unused);
        }
    }
    if (!model.colors.empty()) {
        Material& material = model.materials.emplace_back();
        material.color = {1.0f, 1.0f, 1.0f};
        for (const Vec4& color : model.colors)
            if (color.w < 1.0f)
                material.alpha = Alpha::kBlend;
    }
    return model;
}

} // namespace model
