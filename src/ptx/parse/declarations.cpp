// SPDX-License-Identifier: Apache-2.0
// Declarations of variables and registers, and initialisers. See parser_impl.h.
#include "ptx/parse/parser_impl.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace sunstone::ptx {
namespace {

constexpr uint64_t kMaxAlignment = 1 << 20;
constexpr uint64_t kMaxVariableSize = 1ull << 40;
constexpr uint64_t kMaxInitializedSize = 64ull << 20;
constexpr uint32_t kMaxRange = 100'000'000;
constexpr size_t kMaxDimensions = 16;

unsigned vectorWidth(std::string_view word) {
    return word == "v2" ? 2 : word == "v4" ? 4 : word == "v8" ? 8 : 0;
}

} // namespace

bool Parser::parseSpace(std::string_view word, Space& space) const {
    if (word == "global")
        space = Space::kGlobal;
    else if (word == "const")
        space = Space::kConst;
    else if (word == "shared")
        space = Space::kShared;
    else if (word == "local")
        space = Space::kLocal;
    else if (word == "param")
        space = Space::kParam;
    else if (word == "reg")
        space = Space::kReg;
    else if (word == "tex")
        space = Space::kGlobal; // .tex, the older name of .global .texref
    else
        return false;
    return true;
}

// .attribute(.managed), .attribute(.unified(a, b))
void Parser::parseAttribute(Variable& variable) {
    expect('(', "after .attribute");
    unsigned depth = 1;
    while (depth > 0) {
        if (atEnd() || at(';') || at('{'))
            unexpected("')' after the attributes");
        variable.isManaged |= token_.isDot("managed");
        depth += at('(');
        depth -= at(')');
        advance();
    }
}

// .ptr[.space][.align N], after the word ptr.
void Parser::parsePointer(Variable& variable) {
    variable.isPointer = true;
    if (token_.kind == TokenKind::kDotWord && parseSpace(token_.text, variable.pointerSpace))
        advance();
    if (!token_.isDot("align"))
        return;
    advance();
    variable.pointerAlignment = static_cast<unsigned>(expectInteger("an alignment", 0xFFFFFFFF));
}

// The dot words between state space and name: alignment, vector width, type, attributes.
void Parser::parseVariableType(Variable& variable) {
    while (token_.kind == TokenKind::kDotWord) {
        const std::string_view word = token_.text;
        const Location location = token_.location;
        if (word == "align") {
            advance();
            const Location at = token_.location;
            const uint64_t alignment = expectInteger("an alignment", kMaxAlignment);
            if (!std::has_single_bit(alignment))
                fault(at, "alignment " + std::to_string(alignment) + " is not a power of two");
            variable.alignment = static_cast<unsigned>(alignment);
            continue;
        }
        advance();
        if (const unsigned width = vectorWidth(word)) {
            variable.vector = width;
        } else if (word == "attribute") {
            parseAttribute(variable);
        } else if (word == "ptr" && variable.space == Space::kParam) {
            parsePointer(variable);
        } else {
            Type type = Type::kNone;
            if (!typeFromName(word, type))
                fault(location, "unknown type " + quoted("." + std::string(word)));
            if (variable.type != Type::kNone)
                fault(location, "two types in one declaration: ." +
                                    std::string(nameOf(variable.type)) + " and ." +
                                    std::string(word));
            variable.type = type;
        }
    }
    if (variable.type == Type::kNone)
        unexpected("a type like .u32");
    if (variable.type == Type::kPred && variable.space != Space::kReg)
        fault(token_.location, ".pred variables can only be registers");
}

void Parser::parseDimensions(Variable& variable) {
    while (at('[')) {
        const Location location = token_.location;
        advance();
        variable.isArray = true;
        int64_t size = 0;
        if (!at(']')) {
            size = parseIntegerExpression("an array size");
            if (size < 0)
                fault(location, "array size " + std::to_string(size) + " is negative");
        }
        if (size == 0 && !variable.dimensions.empty())
            fault(location, "only the first dimension of an array may be left open");
        if (variable.dimensions.size() == kMaxDimensions)
            fault(location,
                  "an array has at most " + std::to_string(kMaxDimensions) + " dimensions");
        variable.dimensions.push_back(static_cast<uint64_t>(size));
        expect(']', "after the array size");
    }
}

// Size in bytes and natural alignment, from type and dimensions. A row must be within the limit
// even if the first dimension is open, so that sizes computed from the row do not overflow.
void Parser::finishSize(Variable& variable) {
    uint64_t row = uint64_t(sizeOf(variable.type)) * variable.vector;
    if (variable.alignment == 0)
        variable.alignment = static_cast<unsigned>(std::bit_ceil(row));
    bool isOpen = false;
    for (const uint64_t dimension : variable.dimensions) {
        isOpen = isOpen || dimension == 0;
        if (row != 0 && dimension > kMaxVariableSize / row) // predicates have size 0
            fault(variable.location,
                  "variable " + quoted(variable.name) + " is larger than the limit of 2^40 bytes");
        row *= std::max<uint64_t>(1, dimension);
    }
    variable.size = isOpen ? 0 : row;
}

void Parser::parseDeclarator(Variable& variable) {
    variable.location = token_.location;
    variable.name = expectName("a variable name");
    if (at('<'))
        fault(token_.location, "only registers are declared in ranges");
    parseDimensions(variable);
    finishSize(variable);
    if (accept('='))
        parseInitializer(variable);
}

void Parser::addModuleVariable(Variable&& variable) {
    // Uses the map that the module keeps for functions.
    const auto function = module_.functionIndex.find(variable.name);
    if (function != module_.functionIndex.end())
        fault(variable.location,
              "variable " + quoted(variable.name) +
                  " has the name of a function declared at line " +
                  std::to_string(module_.functions[function->second].location.line));
    const uint32_t index = static_cast<uint32_t>(module_.variables.size());
    const auto [entry, added] = module_.variableIndex.emplace(variable.name, index);
    if (!added) {
        const Variable& first = module_.variables[entry->second];
        const bool declares =
            variable.linkage == Linkage::kExtern || first.linkage == Linkage::kExtern;
        if (!declares)
            fault(variable.location, "variable " + quoted(variable.name) +
                                         " is defined twice; first at line " +
                                         std::to_string(first.location.line));
        if (first.linkage == Linkage::kExtern)
            entry->second = index;
    }
    module_.variables.push_back(std::move(variable));
}

// isTexture: declared in .tex, of a type without meaning.
void Parser::parseModuleVariables(Linkage linkage, Space space, bool isTexture, Location location) {
    Variable common;
    common.space = space;
    common.linkage = linkage;
    common.location = location;
    parseVariableType(common);
    if (isTexture)
        common.type = Type::kTexref;
    do {
        Variable variable = common;
        parseDeclarator(variable);
        if (linkage == Linkage::kExtern && variable.hasInitializer)
            fault(variable.location,
                  ".extern variable " + quoted(variable.name) + " cannot have an initialiser");
        addModuleVariable(std::move(variable));
    } while (accept(','));
    expect(';', "after the declaration");
}

void Parser::parseBodyVariables(Linkage linkage, Space space) {
    Variable common;
    common.space = space;
    common.linkage = linkage;
    parseVariableType(common);
    do {
        Variable variable = common;
        parseDeclarator(variable);
        const Symbol symbol = {SymbolKind::kVariable,
                               static_cast<uint32_t>(function_.variables.size()),
                               variable.location};
        if (const auto earlier = scopes_.declare(names_.intern(variable.name), symbol))
            fault(variable.location, quoted(variable.name) +
                                         " is declared twice in this scope; first at line " +
                                         std::to_string(earlier->location.line));
        variable.name = uniqueName(variable.name, variableStamps_);
        function_.variables.push_back(std::move(variable));
    } while (accept(','));
    expect(';', "after the declaration");
}

void Parser::declareRegister(std::string_view name, const Register& pattern) {
    const Symbol symbol = {SymbolKind::kRegister, static_cast<uint32_t>(function_.registers.size()),
                           pattern.location};
    if (const auto earlier = scopes_.declare(names_.intern(name), symbol))
        fault(pattern.location, "register " + quoted(name) +
                                    " is declared twice in this scope; first at line " +
                                    std::to_string(earlier->location.line));
    function_.registers.push_back(pattern);
    function_.registers.back().name = name;
}

// .reg [.vN] .type name [<count>] {, name [<count>]} ;
void Parser::parseRegisters() {
    Variable common;
    common.space = Space::kReg;
    parseVariableType(common);
    do {
        Register pattern;
        pattern.type = common.type;
        pattern.vector = common.vector;
        pattern.location = token_.location;
        const std::string_view name = expectName("a register name");
        if (!accept('<')) {
            declareRegister(name, pattern);
            continue;
        }
        const uint32_t count = static_cast<uint32_t>(expectInteger("a register count", kMaxRange));
        expect('>', "after the register count");
        pattern.name = name;
        if (!scopes_.declareRange(names_.intern(name), pattern, count))
            fault(pattern.location,
                  "registers " + quoted(name) + " are declared twice in this scope");
    } while (accept(','));
    expect(';', "after the register declaration");
}

void Parser::parseInitializer(Variable& variable) {
    if (variable.space != Space::kGlobal && variable.space != Space::kConst)
        fault(variable.location, "only .global and .const variables can have initialisers");
    variable.hasInitializer = true;
    if (at('{'))
        return parseInitializerList(variable);
    if (variable.isArray || variable.vector > 1)
        unexpected("'{' of the initialiser");
    parseElement(variable, 0);
}

// Nested braces fill rows: a closing brace moves to the start of the next row of its level.
void Parser::parseInitializerList(Variable& variable) {
    // Elements per row of each level, outermost braces first; the parts of a vector are the last
    // level.
    std::vector<uint64_t> rows;
    uint64_t elements = variable.vector;
    if (variable.vector > 1)
        rows.push_back(elements);
    for (size_t i = variable.dimensions.size(); i-- > 0;) {
        const bool open = variable.dimensions[i] == 0;
        elements *= open ? 1 : variable.dimensions[i];
        rows.insert(rows.begin(), open ? ~0ull : elements);
    }
    const Location location = token_.location;
    std::vector<uint64_t> starts;
    uint64_t element = 0, used = 0;
    do {
        while (at('{')) {
            if (starts.size() == rows.size())
                fault(token_.location, "the initialiser has more braces than the variable has "
                                       "dimensions");
            starts.push_back(element);
            advance();
        }
        if (!at('}')) {
            if (element >= rows[0])
                fault(token_.location, "the initialiser has more elements than the variable " +
                                           quoted(variable.name) + " (" + std::to_string(rows[0]) +
                                           ")");
            parseElement(variable, element++);
            used = std::max(used, element);
        }
        while (!starts.empty() && accept('}')) {
            const size_t level = starts.size() - 1;
            if (level > 0)
                element = starts.back() + rows[level];
            used = std::max(used, element);
            starts.pop_back();
        }
    } while (!starts.empty() && accept(','));
    if (!starts.empty())
        unexpected("',' or '}' in the initialiser");
    if (rows[0] != ~0ull && used > rows[0])
        fault(location, "the initialiser has more elements than the variable");
    if (variable.dimensions.empty() || variable.dimensions[0] != 0)
        return;
    // The open first dimension gets the length of the initialiser.
    const uint64_t row = elements;
    variable.dimensions[0] = (used + row - 1) / row;
    finishSize(variable);
}

// 0xFF(sym), 0xFF00(sym), ...: after a number and before '('.
bool Parser::parseMask(Relocation& relocation, unsigned elementSize) {
    const uint64_t bits = token_.bits;
    const unsigned shift = bits ? std::countr_zero(bits) : 0;
    if (bits == 0 || shift % 8 != 0 || bits >> shift != 0xFF)
        return false;
    if (elementSize != 1)
        return false;
    relocation.mask = static_cast<uint8_t>(1u << (shift / 8));
    relocation.size = 1;
    return true;
}

// sym, sym+N, sym-N, generic(sym), generic(sym)+N, generic(sym+N)
void Parser::parseAddressWord(Relocation& relocation) {
    bool closing = false;
    if (token_.kind == TokenKind::kIdentifier && token_.text == "generic") {
        advance();
        expect('(', "after generic");
        relocation.generic = closing = true;
    }
    const Token name = token_;
    relocation.symbol = expectName("a symbol");
    moduleUses_.push_back({names_.intern(relocation.symbol), name.location});
    const auto addend = [&] {
        if (at('+') || at('-')) {
            const bool minus = at('-');
            advance();
            const uint64_t value = static_cast<uint64_t>(parseIntegerExpression("an offset"));
            relocation.addend = static_cast<int64_t>(static_cast<uint64_t>(relocation.addend) +
                                                     (minus ? 0 - value : value));
        }
    };
    addend();
    if (closing) {
        expect(')', "after generic(...");
        addend();
    }
}

// Eight (or four) byte selectors of one address in a row become the address itself.
void Parser::storeRelocation(Variable& variable, Relocation relocation) {
    auto& list = variable.relocations;
    list.push_back(relocation);
    if (relocation.mask != 0x80 || list.size() < 8)
        return;
    const size_t first = list.size() - 8;
    for (size_t i = 0; i < 8; ++i) {
        const Relocation& byte = list[first + i];
        if (byte.mask != 1u << i || byte.offset != list[first].offset + i ||
            byte.symbol != relocation.symbol || byte.addend != relocation.addend ||
            byte.generic != relocation.generic)
            return;
    }
    list.resize(first + 1);
    list[first].mask = 0;
    list[first].size = 8;
}

void Parser::storeConstant(Variable& variable, uint64_t offset, const Constant& constant,
                           Location location) {
    const unsigned size = sizeOf(variable.type);
    uint64_t bits = constant.bits;
    const bool wantsFloat = variable.type == Type::kF32 || variable.type == Type::kF64;
    if (wantsFloat && constant.floatBits == 0) {
        fault(location, "an integer initialises a variable of type ." +
                            std::string(nameOf(variable.type)) + ": write 1.0 or 0f3F800000");
    } else if (variable.type == Type::kF32 && constant.floatBits == 64) {
        bits = std::bit_cast<uint32_t>(static_cast<float>(std::bit_cast<double>(bits)));
    } else if (variable.type == Type::kF64 && constant.floatBits == 32) {
        bits = std::bit_cast<uint64_t>(
            static_cast<double>(std::bit_cast<float>(static_cast<uint32_t>(bits))));
    } else if (constant.floatBits / 8 > size) {
        fault(location, "a floating point number does not fit an element of type ." +
                            std::string(nameOf(variable.type)));
    }
    std::memcpy(variable.initializer.data() + offset, &bits, std::min(size, 8u));
}

void Parser::parseElement(Variable& variable, uint64_t element) {
    const unsigned size = sizeOf(variable.type);
    const uint64_t offset = element * size;
    const Location location = token_.location;
    if (element >= kMaxInitializedSize / size) // empty braces may lead to any index
        fault(location, "initialised variable " + quoted(variable.name) +
                            " is larger than the limit of 64 MiB");
    if (variable.initializer.size() < offset + size)
        variable.initializer.resize(offset + size);
    Relocation relocation;
    relocation.offset = offset;
    if (token_.kind == TokenKind::kInteger) {
        // A number starts a constant expression, or selects a byte of an address.
        const Token number = token_;
        const bool mask = parseMask(relocation, size);
        if (mask) {
            advance();
            if (accept('(')) {
                parseAddressWord(relocation);
                expect(')', "after the address");
                return storeRelocation(variable, relocation);
            }
            lexer_.rewind(number);
            advance();
        }
    } else if (token_.kind == TokenKind::kIdentifier && token_.text != "WARP_SZ") {
        if (size != 8 && size != 4)
            fault(location, "an address needs elements of 4 or 8 bytes, not ." +
                                std::string(nameOf(variable.type)));
        relocation.size = size;
        parseAddressWord(relocation);
        return storeRelocation(variable, relocation);
    }
    storeConstant(variable, offset, parseExpression(), location);
}

} // namespace sunstone::ptx
