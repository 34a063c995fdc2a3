// SPDX-License-Identifier: Apache-2.0
// Operands and constant expressions. See parser_impl.h.
#include "ptx/opcodes/special_registers.h"
#include "ptx/parse/parser_impl.h"

#include <bit>

namespace sunstone::ptx {
namespace {

constexpr unsigned kMaxExpressionDepth = 100;

// .x .y .z .w, also spelt .r .g .b .a; halves and bytes of video instructions. -1: none of these.
int componentFromName(std::string_view word) {
    if (word.size() == 1) {
        const size_t at = std::string_view("xyzwrgba").find(word[0]);
        return at == std::string_view::npos ? -1 : static_cast<int>(at & 3);
    }
    if (word.size() == 2 && word[0] == 'b' && word[1] >= '0' && word[1] <= '3')
        return 4 + (word[1] - '0');
    if (word.size() == 2 && word[0] == 'h' && (word[1] == '0' || word[1] == '1'))
        return 8 + (word[1] - '0');
    const bool isBytes = word.size() > 2 && word.size() <= 5 && word[0] == 'b';
    const bool isHalves = word.size() == 3 && word[0] == 'h';
    if ((isBytes || isHalves) &&
        word.find_first_not_of(isBytes ? "01234567" : "0123", 1) == word.npos)
        return Operand::kPicked;
    return -1;
}

unsigned precedenceOf(std::string_view op) {
    if (op == "||")
        return 1;
    if (op == "&&")
        return 2;
    if (op == "|")
        return 3;
    if (op == "^")
        return 4;
    if (op == "&")
        return 5;
    if (op == "==" || op == "!=")
        return 6;
    if (op == "<" || op == ">" || op == "<=" || op == ">=")
        return 7;
    if (op == "<<" || op == ">>")
        return 8;
    if (op == "+" || op == "-")
        return 9;
    if (op == "*" || op == "/" || op == "%")
        return 10;
    return 0;
}

double asDouble(const Constant& constant) {
    if (constant.floatBits == 64)
        return std::bit_cast<double>(constant.bits);
    if (constant.floatBits == 32)
        return std::bit_cast<float>(static_cast<uint32_t>(constant.bits));
    return constant.isUnsigned ? static_cast<double>(constant.bits)
                               : static_cast<double>(static_cast<int64_t>(constant.bits));
}

Constant integer(uint64_t bits, bool isUnsigned) {
    return {bits, 0, isUnsigned};
}

Constant floating(double value) {
    return {std::bit_cast<uint64_t>(value), 64, false};
}

} // namespace

Operand Parser::parseOperand() {
    Operand operand = parseOperandCore();
    if (!at('|') || operand.kind == OperandKind::kInteger || operand.kind == OperandKind::kFloat)
        return operand;
    Operand pair;
    pair.kind = OperandKind::kPair;
    pair.location = operand.location;
    advance();
    pair.elements.push_back(std::move(operand));
    pair.elements.push_back(parseOperandCore());
    return pair;
}

Operand Parser::parseOperandCore() {
    switch (token_.kind) {
    case TokenKind::kIdentifier:
        return token_.text == "WARP_SZ" ? parseConstant() : parseNamed();
    case TokenKind::kInteger:
    case TokenKind::kFloat32:
    case TokenKind::kFloat64:
        return parseConstant();
    case TokenKind::kDotWord:
        if (token_.text[0] < '0' || token_.text[0] > '9')
            break;
        token_ = lexer_.numberAt(token_);
        return parseConstant();
    case TokenKind::kPunctuation:
        if (at('['))
            return parseBrackets();
        if (at('{'))
            return parseBraces();
        if (at('(') || at('~') || at('+'))
            return parseConstant();
        if (at('!') || at('-')) {
            const Token sign = token_;
            advance();
            const bool constant = token_.kind != TokenKind::kIdentifier || token_.text == "WARP_SZ";
            lexer_.rewind(sign);
            advance();
            if (constant)
                return parseConstant();
            advance();
            Operand operand = parseNamed();
            if (operand.kind != OperandKind::kRegister)
                fault(sign.location,
                      std::string("'") + sign.punctuation + "' must stand before a register");
            operand.negated = true;
            operand.location = sign.location;
            return operand;
        }
        break;
    default:
        break;
    }
    unexpected("an operand");
}

Operand Parser::parseConstant() {
    Operand operand;
    operand.location = token_.location;
    const Constant constant = parseExpression();
    operand.kind = constant.floatBits ? OperandKind::kFloat : OperandKind::kInteger;
    operand.floatBits = constant.floatBits;
    operand.integer = static_cast<int64_t>(constant.bits);
    return operand;
}

// {a, b, ...}
Operand Parser::parseBraces() {
    Operand operand;
    operand.kind = OperandKind::kVector;
    operand.location = token_.location;
    advance();
    do {
        if (at('{') || at('['))
            unexpected("a register or a number in the braces");
        operand.elements.push_back(parseOperandCore());
    } while (accept(','));
    expect('}', "after the vector's elements");
    return operand;
}

uint32_t Parser::expectRegister(const char* what) {
    const Token name = token_;
    expectName(what);
    const auto symbol = scopes_.find(names_.intern(name.text), function_.registers);
    if (!symbol)
        undeclared(name);
    if (symbol->kind != SymbolKind::kRegister)
        fault(name.location, quoted(name.text) + " is not a register");
    return symbol->index;
}

void Parser::undeclared(const Token& name) {
    Nearest nearest(name.text);
    scopes_.forEachVisible([&](std::string_view known) { nearest.offer(known); });
    const bool isRegister = name.text[0] == '%';
    if (!isRegister)
        hintModuleNames(nearest);
    fault(name.location, (isRegister ? "undeclared register " : "undeclared name ") +
                             quoted(name.text) + nearest.hint());
}

bool Parser::resolveSpecial(Operand& operand, const Token& name) {
    const SpecialRegister* special = findSpecialRegister(name.text);
    if (!special)
        return false;
    operand.kind = OperandKind::kSpecial;
    operand.name = name.text;
    if (special->vector && token_.kind == TokenKind::kDotWord && !token_.spaceBefore) {
        if (token_.text != "x" && token_.text != "y" && token_.text != "z" && token_.text != "w")
            unexpected(".x, .y, .z or .w");
        operand.name = std::string_view(name.text.data(), token_.end() - name.text.data());
        advance();
    }
    return true;
}

// The variable of a resolved symbol operand; null for functions and unknown names.
const Variable* Parser::variableOf(NameId name) {
    const auto symbol = scopes_.find(name, function_.registers);
    if (symbol && symbol->kind == SymbolKind::kParameter)
        return &function_.parameters[symbol->index];
    if (symbol && symbol->kind == SymbolKind::kResult)
        return &function_.results[symbol->index];
    if (symbol && symbol->kind == SymbolKind::kVariable)
        return &function_.variables[symbol->index];
    const auto found = module_.variableIndex.find(names_.text(name));
    return found == module_.variableIndex.end() ? nullptr : &module_.variables[found->second];
}

// Resolves a name. Names not declared in the function are looked up at module scope after the whole
// module has been read.
void Parser::resolve(Operand& operand, const Token& name) {
    const NameId id = names_.intern(name.text);
    if (const auto symbol = scopes_.find(id, function_.registers)) {
        if (symbol->kind == SymbolKind::kRegister) {
            operand.kind = OperandKind::kRegister;
            operand.index = symbol->index;
            return;
        }
        operand.kind = OperandKind::kSymbol;
        operand.name = symbol->kind == SymbolKind::kVariable
                           ? function_.variables[symbol->index].name
                           : name.text;
        return;
    }
    if (name.text[0] == '%') {
        if (!resolveSpecial(operand, name))
            undeclared(name);
        return;
    }
    operand.kind = OperandKind::kSymbol;
    operand.name = name.text;
    moduleUses_.push_back({id, name.location});
}

// A register, special register or symbol, with its suffixes.
Operand Parser::parseNamed() {
    Operand operand;
    operand.location = token_.location;
    const Token name = token_;
    if (name.kind != TokenKind::kIdentifier)
        unexpected("a name");
    advance();
    if (name.text == "_")
        return operand;
    resolve(operand, name);
    if (operand.kind == OperandKind::kRegister)
        parseComponent(operand);
    else if (operand.kind == OperandKind::kSymbol) {
        if (at('['))
            parseIndex(operand, name.text);
        else if (at('+') || at('-'))
            parseOffset(operand);
    }
    return operand;
}

void Parser::parseComponent(Operand& operand) {
    if (token_.kind != TokenKind::kDotWord)
        return;
    const int component = componentFromName(token_.text);
    const Register& reg = function_.registers[operand.index];
    const unsigned parts = component < 4 ? reg.vector : 4;
    if (component < 0 || (component < 4 && (parts == 1 || component >= static_cast<int>(parts))))
        fault(token_.location, "register has no part " + quoted("." + std::string(token_.text)));
    operand.component = static_cast<int8_t>(component);
    if (component == Operand::kPicked)
        operand.name = token_.text;
    advance();
}

// + N or - N, also +-N
void Parser::parseOffset(Operand& operand) {
    while (at('+') || at('-')) {
        const bool minus = at('-');
        advance();
        // The loop parses the following terms, so this parses only operators that bind tighter.
        const Location location = token_.location;
        const Constant term = parseExpression(10);
        if (term.floatBits)
            fault(location, "an offset must be a whole number");
        operand.offset = static_cast<int64_t>(static_cast<uint64_t>(operand.offset) +
                                              (minus ? 0 - term.bits : term.bits));
    }
}

// sym[N], sym[%r], sym[%r+N]: the index counts elements. mov reads the address, a load the value
// there.
void Parser::parseIndex(Operand& operand, std::string_view name) {
    const Variable* variable = variableOf(names_.intern(name));
    if (!variable)
        fault(operand.location, quoted(name) + " must be declared before it is indexed");
    const uint64_t scale = uint64_t(sizeOf(variable->type)) * variable->vector;
    advance();
    if (token_.kind == TokenKind::kIdentifier && token_.text != "WARP_SZ") {
        operand.index = expectRegister("a register or a number");
        operand.scale = static_cast<uint32_t>(scale);
        parseOffset(operand);
    } else {
        operand.offset = parseIntegerExpression("an index");
    }
    constexpr int64_t kMaxIndex = int64_t(1) << 40;
    if (operand.offset > kMaxIndex || operand.offset < -kMaxIndex)
        fault(operand.location, "index " + std::to_string(operand.offset) + " is out of range");
    operand.offset = static_cast<int64_t>(static_cast<uint64_t>(operand.offset) * scale);
    expect(']', "after the index");
    if (!addressesAreValues_)
        operand.kind = OperandKind::kAddress;
}

// [address], or [texture, ...]
Operand Parser::parseBrackets() {
    Operand address;
    address.location = token_.location;
    advance();
    if (token_.kind == TokenKind::kIdentifier && token_.text != "WARP_SZ") {
        const Location location = address.location;
        address = parseNamed();
        if (address.kind != OperandKind::kRegister && address.kind != OperandKind::kSymbol)
            fault(address.location, "an address begins with a register or a symbol");
        address.location = location;
        if (address.kind == OperandKind::kRegister)
            parseOffset(address);
    } else {
        address.kind = OperandKind::kAddress;
        address.offset = parseIntegerExpression("an address");
    }
    if (!at(',')) {
        expect(']', "after the address");
        address.kind = OperandKind::kAddress;
        return address;
    }
    Operand texture;
    texture.kind = OperandKind::kTexture;
    texture.location = address.location;
    texture.elements.push_back(std::move(address));
    while (accept(',')) {
        if (at('['))
            unexpected("coordinates");
        texture.elements.push_back(parseOperandCore());
    }
    expect(']', "after the coordinates");
    return texture;
}

int64_t Parser::parseIntegerExpression(const char* what) {
    const Location location = token_.location;
    const Constant constant = parseExpression();
    if (constant.floatBits)
        fault(location, std::string(what) + " must be a whole number");
    return static_cast<int64_t>(constant.bits);
}

// Precedence climbing; operators of two characters arrive as two tokens.
Constant Parser::parseExpression(unsigned minimumPrecedence) {
    Constant left = parseUnary();
    for (;;) {
        if (token_.kind != TokenKind::kPunctuation)
            return left;
        if (at('?') && minimumPrecedence == 0) {
            left = parseChoice(left);
            continue;
        }
        const Token op = token_;
        std::string_view text = op.text;
        advance();
        if (token_.kind == TokenKind::kPunctuation && !token_.spaceBefore) {
            const std::string_view two(op.text.data(), 2);
            if (two == "<<" || two == ">>" || two == "<=" || two == ">=" || two == "==" ||
                two == "!=" || two == "&&" || two == "||") {
                text = two;
                advance();
            }
        }
        const unsigned precedence = precedenceOf(text);
        if (precedence == 0 || precedence < minimumPrecedence) {
            lexer_.rewind(op);
            advance();
            return left;
        }
        left = binary(text, left, parseExpression(precedence + 1), op.location);
    }
}

Constant Parser::parseChoice(Constant condition) {
    advance();
    const bool first = condition.floatBits ? asDouble(condition) != 0 : condition.bits != 0;
    if (++expressionDepth_ > kMaxExpressionDepth)
        fault(token_.location, "the expression is nested too deep");
    const Constant yes = parseExpression();
    expect(':', "in the conditional expression");
    const Constant no = parseExpression();
    --expressionDepth_;
    return first ? yes : no;
}

Constant Parser::parseUnary() {
    if (++expressionDepth_ > kMaxExpressionDepth)
        fault(token_.location, "the expression is nested too deep");
    Constant result;
    if (token_.kind == TokenKind::kInteger) {
        result = integer(token_.bits, token_.bits >> 63 || token_.text.back() == 'U');
        advance();
    } else if (token_.kind == TokenKind::kFloat32 || token_.kind == TokenKind::kFloat64) {
        result = {token_.bits, static_cast<uint8_t>(token_.kind == TokenKind::kFloat32 ? 32 : 64),
                  false};
        advance();
    } else if (token_.kind == TokenKind::kDotWord && token_.text[0] >= '0' &&
               token_.text[0] <= '9') {
        token_ = lexer_.numberAt(token_);
        result = {token_.bits, 64, false};
        advance();
    } else if (token_.kind == TokenKind::kIdentifier && token_.text == "WARP_SZ") {
        result = integer(32, false);
        advance();
    } else if (accept('(')) {
        // (.s64) and (.u64) are casts; anything else in parentheses is an expression.
        const bool cast = token_.isDot("s64") || token_.isDot("u64");
        const bool toUnsigned = token_.isDot("u64");
        if (cast) {
            advance();
            expect(')', "after the type of the cast");
            result = parseUnary();
            if (result.floatBits)
                fault(token_.location, "floating point numbers cannot be cast");
            result.isUnsigned = toUnsigned;
        } else {
            result = parseExpression();
            expect(')', "after the expression");
        }
    } else if (at('-') || at('+') || at('~') || at('!')) {
        const char op = token_.punctuation;
        const Location location = token_.location;
        advance();
        result = parseUnary();
        if (result.floatBits && op == '-')
            result.bits ^= 1ull << (result.floatBits - 1);
        else if (result.floatBits && op != '+')
            fault(location, std::string("'") + op + "' needs a whole number");
        else if (op == '-')
            result.bits = 0 - result.bits;
        else if (op == '~')
            result.bits = ~result.bits;
        else if (op == '!')
            result = integer(result.bits == 0, false);
    } else {
        unexpected("a number");
    }
    --expressionDepth_;
    return result;
}

Constant Parser::binary(std::string_view op, const Constant& a, const Constant& b,
                        Location location) {
    if (a.floatBits || b.floatBits) {
        const double x = asDouble(a), y = asDouble(b);
        switch (op[0]) {
        case '+':
            return floating(x + y);
        case '-':
            return floating(x - y);
        case '*':
            return floating(x * y);
        case '/':
            return floating(y == 0 ? (x == 0 ? 0.0 : x) / y : x / y);
        default:
            fault(location, quoted(op) + " needs whole numbers");
        }
    }
    const bool isUnsigned = a.isUnsigned || b.isUnsigned;
    const int64_t sa = static_cast<int64_t>(a.bits), sb = static_cast<int64_t>(b.bits);
    const auto compare = [&](bool lessUnsigned, bool lessSigned) {
        return integer(isUnsigned ? lessUnsigned : lessSigned, false);
    };
    if (op == "+")
        return integer(a.bits + b.bits, isUnsigned);
    if (op == "-")
        return integer(a.bits - b.bits, isUnsigned);
    if (op == "*")
        return integer(a.bits * b.bits, isUnsigned);
    if (op == "/" || op == "%") {
        if (b.bits == 0)
            fault(location, "division by zero");
        const bool divide = op == "/";
        if (isUnsigned)
            return integer(divide ? a.bits / b.bits : a.bits % b.bits, true);
        if (sb == -1) // the only quotient that overflows
            return integer(divide ? 0 - a.bits : 0, false);
        return integer(static_cast<uint64_t>(divide ? sa / sb : sa % sb), false);
    }
    if (op == "<<")
        return integer(b.bits < 64 ? a.bits << b.bits : 0, a.isUnsigned);
    if (op == ">>") {
        const unsigned count = b.bits < 64 ? static_cast<unsigned>(b.bits) : 63;
        if (a.isUnsigned)
            return integer(b.bits < 64 ? a.bits >> count : 0, true);
        return integer(static_cast<uint64_t>(sa >> count), false);
    }
    if (op == "&")
        return integer(a.bits & b.bits, isUnsigned);
    if (op == "|")
        return integer(a.bits | b.bits, isUnsigned);
    if (op == "^")
        return integer(a.bits ^ b.bits, isUnsigned);
    if (op == "&&")
        return integer(a.bits && b.bits, false);
    if (op == "||")
        return integer(a.bits || b.bits, false);
    if (op == "==")
        return integer(a.bits == b.bits, false);
    if (op == "!=")
        return integer(a.bits != b.bits, false);
    if (op == "<")
        return compare(a.bits < b.bits, sa < sb);
    if (op == ">")
        return compare(a.bits > b.bits, sa > sb);
    if (op == "<=")
        return compare(a.bits <= b.bits, sa <= sb);
    return compare(a.bits >= b.bits, sa >= sb);
}

} // namespace sunstone::ptx
