// SPDX-License-Identifier: Apache-2.0
// See dwarf.h. The steps: sections as bytes, then entries, then their meaning.
#include "compiler/debug/dwarf.h"

#include <charconv>
#include <optional>

namespace sunstone::compiler {

namespace {

// Thrown for malformed data; readDwarf returns the part it read before.
struct Unreadable {};

// ---- data directives to bytes -----------------------------------------------------------------

struct SectionBytes {
    std::string bytes;
    std::map<size_t, std::pair<std::string, uint64_t>> references; // offset to symbol + addend
    std::map<std::string, size_t, std::less<>> labels;
};

class SectionReader {
public:
    explicit SectionReader(std::string_view text) : rest_(text) {}

    SectionBytes read() {
        for (skipSpace(); !rest_.empty(); skipSpace()) {
            const std::string_view word = takeWord();
            if (word.empty())
                throw Unreadable();
            skipSpace();
            if (take(':')) {
                out_.labels.emplace(word, out_.bytes.size());
                continue;
            }
            const unsigned size = word == ".b8"    ? 1
                                  : word == ".b16" ? 2
                                  : word == ".b32" ? 4
                                  : word == ".b64" ? 8
                                                   : 0;
            if (size == 0)
                throw Unreadable();
            do
                value(size);
            while (skipSpace(), take(','));
        }
        return std::move(out_);
    }

private:
    void skipSpace() {
        for (;;) {
            while (!rest_.empty() && std::string_view(" \t\r\n").find(rest_[0]) != rest_.npos)
                rest_.remove_prefix(1);
            const std::string_view end = rest_.substr(0, 2) == "//"   ? "\n"
                                         : rest_.substr(0, 2) == "/*" ? "*/"
                                                                      : "";
            if (end.empty())
                return;
            const size_t at = rest_.find(end);
            rest_.remove_prefix(at == rest_.npos ? rest_.size() : at + end.size());
        }
    }
    bool take(char c) {
        if (rest_.empty() || rest_[0] != c)
            return false;
        rest_.remove_prefix(1);
        return true;
    }
    std::string_view takeWord() {
        size_t size = 0;
        while (size < rest_.size() && (isalnum(uint8_t(rest_[size])) ||
                                       std::string_view("._$%").find(rest_[size]) != rest_.npos))
            ++size;
        const std::string_view word = rest_.substr(0, size);
        rest_.remove_prefix(size);
        return word;
    }
    std::optional<uint64_t> number() {
        const std::string_view word = takeWord();
        const bool isHex = word.size() > 2 && word[0] == '0' && (word[1] == 'x' || word[1] == 'X');
        const std::string_view digits = isHex ? word.substr(2) : word;
        uint64_t result = 0;
        const auto [end, error] =
            std::from_chars(digits.data(), digits.data() + digits.size(), result, isHex ? 16 : 10);
        const bool good = error == std::errc() && end == digits.data() + digits.size();
        return good ? std::optional(result) : std::nullopt;
    }
    void value(unsigned size) {
        skipSpace();
        uint64_t bits = 0;
        const bool negative = take('-');
        if (!rest_.empty() && isdigit(uint8_t(rest_[0]))) {
            const auto found = number();
            if (!found)
                throw Unreadable();
            bits = negative ? 0 - *found : *found;
        } else {
            const std::string symbol(takeWord());
            if (symbol.empty() || negative)
                throw Unreadable();
            skipSpace();
            if (take('+')) {
                skipSpace();
                const auto found = number();
                if (!found)
                    throw Unreadable();
                bits = *found;
            } else if (take('-')) { // a length between labels: nothing here needs it
                skipSpace();
                takeWord();
            }
            out_.references.emplace(out_.bytes.size(), std::make_pair(symbol, bits));
        }
        for (unsigned i = 0; i < size; ++i)
            out_.bytes.push_back(char(bits >> 8 * i));
    }

    std::string_view rest_;
    SectionBytes out_;
};

// ---- bytes to numbers -------------------------------------------------------------------------

class Cursor {
public:
    Cursor(const SectionBytes& section, size_t at, size_t end)
        : section_(section), at_(at), end_(std::min(end, section.bytes.size())) {}
    explicit Cursor(const SectionBytes& section, size_t at = 0)
        : Cursor(section, at, section.bytes.size()) {}

    size_t at() const { return at_; }
    bool atEnd() const { return at_ >= end_; }
    uint64_t fixed(unsigned size) {
        need(size);
        uint64_t value = 0;
        for (unsigned i = 0; i < size; ++i)
            value |= uint64_t(uint8_t(section_.bytes[at_ + i])) << 8 * i;
        at_ += size;
        return value;
    }
    uint64_t unsignedLeb() {
        uint64_t value = 0;
        for (unsigned shift = 0;; shift += 7) {
            const uint64_t byte = fixed(1);
            if (shift < 64)
                value |= (byte & 127) << shift;
            if (!(byte & 128))
                return value;
        }
    }
    int64_t signedLeb() {
        uint64_t value = 0;
        for (unsigned shift = 0;;) {
            const uint64_t byte = fixed(1);
            if (shift < 64)
                value |= (byte & 127) << shift;
            shift += 7;
            if (byte & 128)
                continue;
            if ((byte & 64) && shift < 64)
                value |= ~uint64_t(0) << shift;
            return int64_t(value);
        }
    }
    std::string string() {
        const size_t end = section_.bytes.find('\0', at_);
        if (end == std::string::npos || end >= end_)
            throw Unreadable();
        std::string text = section_.bytes.substr(at_, end - at_);
        at_ = end + 1;
        return text;
    }
    void skip(uint64_t size) {
        need(size);
        at_ += size;
    }
    // The symbol that the next bytes refer to, if they are an address.
    const std::pair<std::string, uint64_t>* reference() const {
        const auto found = section_.references.find(at_);
        return found == section_.references.end() ? nullptr : &found->second;
    }

private:
    void need(uint64_t size) const {
        if (at_ > end_ || size > end_ - at_)
            throw Unreadable();
    }
    const SectionBytes& section_;
    size_t at_, end_;
};

// ---- entries ----------------------------------------------------------------------------------

// The numbers of the DWARF specification in use here.
enum Tag : uint32_t {
    kTagArray = 0x01,
    kTagClass = 0x02,
    kTagEnumeration = 0x04,
    kTagParameter = 0x05,
    kTagLexicalBlock = 0x0b,
    kTagMember = 0x0d,
    kTagPointer = 0x0f,
    kTagReference = 0x10,
    kTagStruct = 0x13,
    kTagTypedef = 0x16,
    kTagUnion = 0x17,
    kTagInlined = 0x1d,
    kTagSubrange = 0x21,
    kTagBase = 0x24,
    kTagConst = 0x26,
    kTagEnumerator = 0x28,
    kTagSubprogram = 0x2e,
    kTagVariable = 0x34,
    kTagVolatile = 0x35,
    kTagRvalueReference = 0x42,
};
enum Attribute : uint32_t {
    kLocation = 0x02,
    kName = 0x03,
    kByteSize = 0x0b,
    kLowPc = 0x11,
    kHighPc = 0x12,
    kConstValue = 0x1c,
    kUpperBound = 0x2f,
    kAbstractOrigin = 0x31,
    kCount = 0x37,
    kMemberLocation = 0x38,
    kDeclFile = 0x3a,
    kDeclLine = 0x3b,
    kEncoding = 0x3e,
    kSpecification = 0x47,
    kType = 0x49,
    kRanges = 0x55,
    kCallColumn = 0x57,
    kCallFile = 0x58,
    kCallLine = 0x59,
    kLinkageName = 0x6e,
    kMipsLinkageName = 0x2007,
};

struct Value {
    uint64_t number = 0;
    std::string text;          // strings, symbols
    size_t begin = 0, end = 0; // of a block, in .debug_info
    bool isBlock = false;
};

struct Entry {
    uint32_t tag = 0;
    uint32_t offset = 0;
    std::map<uint32_t, Value> values;
    std::vector<size_t> children;

    const Value* find(uint32_t attribute) const {
        const auto found = values.find(attribute);
        return found == values.end() ? nullptr : &found->second;
    }
    uint64_t number(uint32_t attribute) const {
        const Value* value = find(attribute);
        return value ? value->number : 0;
    }
    std::string text(uint32_t attribute) const {
        const Value* value = find(attribute);
        return value ? value->text : std::string();
    }
};

struct Abbreviation {
    uint32_t tag = 0;
    bool hasChildren = false;
    std::vector<std::pair<uint32_t, uint32_t>> attributes; // and their forms
};

class Reader {
public:
    explicit Reader(const ptx::Module& module) {
        for (const ptx::Section& section : module.sections)
            try {
                sections_[std::string(section.name)] = SectionReader(section.text).read();
            } catch (const Unreadable&) { // others may be of use without it
            }
    }

    void readEntries() {
        const SectionBytes& info = sections_["debug_info"];
        for (size_t next = 0; next < info.bytes.size();) {
            Cursor cursor(info, next);
            unit_ = uint32_t(next);
            const uint64_t length = cursor.fixed(4);
            next = cursor.at() + length;
            const uint64_t version = cursor.fixed(2);
            const uint64_t abbreviations = cursor.fixed(4);
            if (version < 2 || version > 4 || cursor.fixed(1) != 8)
                throw Unreadable();
            readAbbreviations(abbreviations);
            Cursor body(info, cursor.at(), next);
            readSiblings(body, roots_, 0);
        }
    }

    DwarfInfo take() {
        for (const size_t root : roots_)
            for (const size_t child : entries_[root].children)
                collect(entries_[child]);
        return std::move(out_);
    }

private:
    static constexpr unsigned kMaxDepth = 64;
    // An inlined copy leads to its function, and that to its declaration: two links. Each entry may
    // have two links, so a higher limit would allow too many paths.
    static constexpr unsigned kMaxLinks = 4;

    void readAbbreviations(uint64_t at) {
        abbreviations_.clear();
        Cursor cursor(sections_["debug_abbrev"], at);
        while (const uint64_t code = cursor.unsignedLeb()) {
            Abbreviation& entry = abbreviations_[code];
            entry.tag = uint32_t(cursor.unsignedLeb());
            entry.hasChildren = cursor.fixed(1) != 0;
            for (;;) {
                const auto attribute = uint32_t(cursor.unsignedLeb());
                const auto form = uint32_t(cursor.unsignedLeb());
                if (attribute == 0 && form == 0)
                    break;
                entry.attributes.emplace_back(attribute, form);
            }
            if (cursor.atEnd())
                break;
        }
    }

    void readSiblings(Cursor& cursor, std::vector<size_t>& into, unsigned depth) {
        if (depth > kMaxDepth)
            throw Unreadable();
        while (!cursor.atEnd()) {
            Entry entry;
            entry.offset = uint32_t(cursor.at());
            const uint64_t code = cursor.unsignedLeb();
            if (code == 0)
                return;
            const auto found = abbreviations_.find(code);
            if (found == abbreviations_.end())
                throw Unreadable();
            entry.tag = found->second.tag;
            for (const auto& [attribute, form] : found->second.attributes)
                entry.values[attribute] = readValue(cursor, form);
            const size_t index = entries_.size();
            byOffset_[entry.offset] = index;
            entries_.push_back(std::move(entry));
            into.push_back(index);
            if (!found->second.hasChildren)
                continue;
            std::vector<size_t> children;
            readSiblings(cursor, children, depth + 1);
            entries_[index].children = std::move(children);
        }
    }

    Value readBlock(Cursor& cursor, uint64_t size) {
        Value value;
        value.isBlock = true;
        value.begin = cursor.at();
        cursor.skip(size);
        value.end = cursor.at();
        return value;
    }

    Value readValue(Cursor& cursor, uint32_t form) {
        Value value;
        const auto fixed = [&](unsigned size) {
            if (const auto* reference = cursor.reference()) {
                value.text = reference->first;
                cursor.skip(size);
                value.number = reference->second;
            } else {
                value.number = cursor.fixed(size);
            }
            return value;
        };
        switch (form) {
        case 0x01: // addr
            return fixed(8);
        case 0x03:
            return readBlock(cursor, cursor.fixed(2));
        case 0x04:
            return readBlock(cursor, cursor.fixed(4));
        case 0x05:
            return fixed(2);
        case 0x06:
        case 0x17: // sec_offset
            return fixed(4);
        case 0x07:
            return fixed(8);
        case 0x08:
            value.text = cursor.string();
            return value;
        case 0x09:
        case 0x18: // exprloc
            return readBlock(cursor, cursor.unsignedLeb());
        case 0x0a:
            return readBlock(cursor, cursor.fixed(1));
        case 0x0b:
        case 0x0c: // flag
            return fixed(1);
        case 0x0d:
            value.number = uint64_t(cursor.signedLeb());
            return value;
        case 0x0e: { // strp
            const Value at = fixed(4);
            const SectionBytes& strings = sections_["debug_str"];
            const auto label = strings.labels.find(at.text);
            const size_t start = label == strings.labels.end() ? 0 : label->second;
            value.text = Cursor(strings, start + at.number).string();
            return value;
        }
        case 0x0f:
            value.number = cursor.unsignedLeb();
            return value;
        case 0x10: // ref_addr: from the start of the section
            return fixed(4);
        case 0x11:
        case 0x12:
        case 0x13:
        case 0x14: // ref1 .. ref8: from the start of the unit
            value.number = cursor.fixed(1u << (form - 0x11)) + unit_;
            return value;
        case 0x15:
            value.number = cursor.unsignedLeb() + unit_;
            return value;
        case 0x19: // flag_present
            value.number = 1;
            return value;
        default:
            throw Unreadable();
        }
    }

    // ---- meaning

    const Entry* entryAt(uint64_t offset) const {
        const auto found = byOffset_.find(uint32_t(offset));
        return found == byOffset_.end() ? nullptr : &entries_[found->second];
    }

    // An attribute of the entry or of the entry it completes.
    const Value* inherited(const Entry& entry, uint32_t attribute, unsigned depth = 0) const {
        if (const Value* value = entry.find(attribute))
            return value;
        for (const uint32_t link : {kSpecification, kAbstractOrigin})
            if (const Value* origin = entry.find(link); origin && depth < kMaxLinks)
                if (const Entry* target = entryAt(origin->number))
                    if (const Value* value = inherited(*target, attribute, depth + 1))
                        return value;
        return nullptr;
    }
    std::string inheritedText(const Entry& entry, uint32_t attribute) const {
        const Value* value = inherited(entry, attribute);
        return value ? value->text : std::string();
    }
    uint64_t inheritedNumber(const Entry& entry, uint32_t attribute) const {
        const Value* value = inherited(entry, attribute);
        return value ? value->number : 0;
    }

    void collect(const Entry& entry) {
        if (entry.tag == kTagVariable)
            return collectGlobal(entry);
        if (entry.tag != kTagSubprogram || !entry.find(kLowPc))
            return;
        DwarfFunction function;
        function.name = inheritedText(entry, kName);
        function.line = uint32_t(inheritedNumber(entry, kDeclLine));
        function.file = uint32_t(inheritedNumber(entry, kDeclFile));
        fillScope(entry, function.scope, 0);
        std::string symbol = inheritedText(entry, kMipsLinkageName);
        if (symbol.empty())
            symbol = inheritedText(entry, kLinkageName);
        out_.functions[symbol.empty() ? function.name : symbol] = std::move(function);
    }

    void collectGlobal(const Entry& entry) {
        DwarfScope scope;
        addVariable(entry, scope);
        for (DwarfVariable& variable : scope.variables)
            if (const DwarfPlace place = variable.places[0]; !place.isRegister)
                out_.globals.emplace(place.name, std::move(variable));
    }

    void fillScope(const Entry& entry, DwarfScope& scope, unsigned depth) {
        for (const size_t index : entry.children) {
            const Entry& child = entries_[index];
            if (child.tag == kTagVariable || child.tag == kTagParameter) {
                addVariable(child, scope);
            } else if ((child.tag == kTagLexicalBlock || child.tag == kTagInlined) &&
                       depth < kMaxDepth) {
                DwarfScope inner;
                inner.ranges = rangesOf(child);
                if (child.tag == kTagInlined)
                    inner.inlined = inlinedOf(child);
                fillScope(child, inner, depth + 1);
                if (!inner.ranges.empty())
                    scope.scopes.push_back(std::move(inner));
            }
        }
    }

    DwarfInlined inlinedOf(const Entry& entry) const {
        DwarfInlined inlined;
        inlined.name = inheritedText(entry, kName);
        inlined.line = uint32_t(inheritedNumber(entry, kDeclLine));
        inlined.file = uint32_t(inheritedNumber(entry, kDeclFile));
        inlined.origin = uint32_t(entry.number(kAbstractOrigin));
        inlined.callLine = uint32_t(entry.number(kCallLine));
        inlined.callFile = uint32_t(entry.number(kCallFile));
        inlined.callColumn = uint32_t(entry.number(kCallColumn));
        return inlined;
    }

    // Low and high address, or a list in .debug_ranges that ends with zeros.
    std::vector<std::pair<std::string, std::string>> rangesOf(const Entry& entry) {
        std::vector<std::pair<std::string, std::string>> ranges;
        const std::string low = entry.text(kLowPc), high = entry.text(kHighPc);
        if (!low.empty() && !high.empty())
            ranges.emplace_back(low, high);
        if (!entry.find(kRanges))
            return ranges;
        const SectionBytes& list = sections_["debug_ranges"];
        for (Cursor cursor(list, entry.number(kRanges)); !cursor.atEnd();) {
            const std::string begin = address(cursor), end = address(cursor);
            if (begin.empty() || end.empty())
                break;
            ranges.emplace_back(begin, end);
        }
        return ranges;
    }

    static std::string address(Cursor& cursor) {
        const auto* reference = cursor.reference();
        cursor.skip(8);
        return reference ? reference->first : std::string();
    }

    void addVariable(const Entry& entry, DwarfScope& scope) {
        DwarfVariable variable;
        variable.name = inheritedText(entry, kName);
        variable.line = uint32_t(inheritedNumber(entry, kDeclLine));
        variable.file = uint32_t(inheritedNumber(entry, kDeclFile));
        variable.origin = uint32_t(entry.number(kAbstractOrigin));
        variable.type = uint32_t(inheritedNumber(entry, kType));
        variable.isParameter = entry.tag == kTagParameter;
        const Value* location = entry.find(kLocation);
        if (variable.name.empty() || !location)
            return;
        if (location->isBlock)
            addPlace(Cursor(sections_["debug_info"], location->begin, location->end), {}, {},
                     variable);
        else
            addList(location->number, variable);
        noteType(variable.type, 0);
        if (!variable.places.empty())
            scope.variables.push_back(std::move(variable));
    }

    void addPlace(Cursor cursor, std::string begin, std::string end, DwarfVariable& variable) {
        DwarfPlace place{std::move(begin), std::move(end), false, {}, 0};
        const uint64_t operation = cursor.fixed(1);
        if (operation == 0x03 && cursor.reference()) { // addr
            place.name = cursor.reference()->first;
            place.offset = cursor.reference()->second;
            cursor.skip(8);
            if (!cursor.atEnd() && cursor.fixed(1) == 0x23) // plus_uconst
                place.offset += cursor.unsignedLeb();
        } else if (operation == 0x90) { // regx
            place.isRegister = true;
            for (uint64_t name = cursor.unsignedLeb(); name != 0; name >>= 8)
                place.name.insert(place.name.begin(), char(name & 255));
        } else {
            return;
        }
        if (cursor.atEnd())
            variable.places.push_back(std::move(place));
    }

    void addList(uint64_t at, DwarfVariable& variable) {
        const SectionBytes& list = sections_["debug_loc"];
        for (Cursor cursor(list, at); !cursor.atEnd();) {
            const std::string begin = address(cursor), end = address(cursor);
            if (begin.empty() || end.empty())
                return;
            const uint64_t size = cursor.fixed(2);
            addPlace(Cursor(list, cursor.at(), cursor.at() + size), begin, end, variable);
            cursor.skip(size);
        }
    }

    static DwarfType::Kind kindOf(uint32_t tag) {
        using Kind = DwarfType::Kind;
        switch (tag) {
        case kTagBase:
            return Kind::kBase;
        case kTagPointer:
            return Kind::kPointer;
        case kTagReference:
        case kTagRvalueReference:
            return Kind::kReference;
        case kTagStruct:
        case kTagClass:
        case kTagUnion:
            return Kind::kStruct;
        case kTagArray:
            return Kind::kArray;
        case kTagTypedef:
            return Kind::kTypedef;
        case kTagConst:
            return Kind::kConst;
        case kTagVolatile:
            return Kind::kVolatile;
        case kTagEnumeration:
            return Kind::kEnum;
        default:
            return Kind::kNone;
        }
    }

    void noteType(uint32_t key, unsigned depth) {
        const Entry* entry = entryAt(key);
        if (key == 0 || !entry || depth > kMaxDepth || out_.types.count(key))
            return;
        DwarfType& type = out_.types[key];
        type.kind = kindOf(entry->tag);
        type.name = entry->text(kName);
        type.size = entry->number(kByteSize);
        type.encoding = uint32_t(entry->number(kEncoding));
        type.of = uint32_t(entry->number(kType));
        std::vector<uint32_t> needed = {type.of};
        for (const size_t index : entry->children) {
            const Entry& child = entries_[index];
            if (child.tag == kTagMember && !child.text(kName).empty()) {
                type.members.push_back(
                    {child.text(kName), uint32_t(child.number(kType)), memberOffset(child)});
                needed.push_back(type.members.back().type);
            } else if (child.tag == kTagSubrange) {
                const bool hasBound = child.find(kUpperBound) != nullptr;
                const uint64_t count =
                    hasBound ? child.number(kUpperBound) + 1 : child.number(kCount);
                type.count = type.count == 0 ? count : type.count * count;
            } else if (child.tag == kTagEnumerator) {
                type.enumerators.emplace_back(child.text(kName),
                                              int64_t(child.number(kConstValue)));
            }
        }
        for (const uint32_t each : needed)
            noteType(each, depth + 1);
    }

    // A number, or the expression DW_OP_plus_uconst.
    uint64_t memberOffset(const Entry& member) {
        const Value* value = member.find(kMemberLocation);
        if (!value || !value->isBlock)
            return value ? value->number : 0;
        Cursor cursor(sections_["debug_info"], value->begin, value->end);
        return cursor.fixed(1) == 0x23 ? cursor.unsignedLeb() : 0;
    }

    std::map<std::string, SectionBytes> sections_;
    uint32_t unit_ = 0;
    std::map<uint64_t, Abbreviation> abbreviations_;
    std::vector<Entry> entries_;
    std::map<uint32_t, size_t> byOffset_;
    std::vector<size_t> roots_;
    DwarfInfo out_;
};

} // namespace

std::string debugString(const ptx::Module& module, std::string_view label, uint64_t offset) {
    for (const ptx::Section& section : module.sections)
        try {
            if (section.name != "debug_str")
                continue;
            const SectionBytes strings = SectionReader(section.text).read();
            const auto found = strings.labels.find(label);
            if (found != strings.labels.end())
                return Cursor(strings, found->second + offset).string();
        } catch (const Unreadable&) { // no name then
        }
    return {};
}

DwarfInfo readDwarf(const ptx::Module& module) {
    try {
        Reader reader(module);
        reader.readEntries();
        return reader.take();
    } catch (const Unreadable&) {
        return {};
    }
}

} // namespace sunstone::compiler
