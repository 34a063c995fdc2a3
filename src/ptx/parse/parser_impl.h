// SPDX-License-Identifier: Apache-2.0
// Internals of the parser: recursive descent over tokens, one method per construct, in
//   parser.cpp        tokens, module directives, debug sections, the end of the module
//   declarations.cpp  variables, registers, initialisers
//   functions.cpp     function headers, attributes, parameters, prototypes
//   bodies.cpp        statements, scopes, labels, calls
//   operands.cpp      operands, addresses, constant expressions
// A fault is recorded and thrown as Fault. The innermost loop over statements, directives or module
// items catches it, skips to the next possible start, and continues.
#pragma once

#include "ptx/names.h"
#include "ptx/opcodes/opcode.h"
#include "ptx/parse/lexer.h"
#include "ptx/parse/scopes.h"

#include <memory>
#include <optional>
#include <string>

namespace sunstone::ptx {

struct Fault {};

// Value of a constant expression.
struct Constant {
    uint64_t bits = 0;
    uint8_t floatBits = 0; // 0: an integer
    bool isUnsigned = false;
};

class Parser {
public:
    Parser(Module& module, Diagnostics& diagnostics, const OpcodeTable& opcodes);
    void parseModule();

private:
    // parser.cpp
    [[noreturn]] void fault(Location location, std::string text);
    [[noreturn]] void unexpected(const char* wanted);
    void advance() { token_ = lexer_.next(); }
    bool at(char c) const { return token_.is(c); }
    bool atEnd() const { return token_.kind == TokenKind::kEnd; }
    bool accept(char c);
    void expect(char c, const char* where);
    std::string_view expectName(const char* what);
    uint64_t expectInteger(const char* what, uint64_t limit);
    bool tooManyErrors() const { return diagnostics_.errorCount() >= Diagnostics::kMaxErrors; }
    void recover();
    void parseItem();
    void parseVersion();
    void parseTarget();
    void parseAddressSize();
    void parseFile();
    void parseLoc();
    void parseSection();
    void parsePragma();
    void parseAlias();
    void unknownDirective();
    Linkage parseLinkage();
    void skipStatement();
    void requireHeader();
    void indexModule();
    void resolveModuleNames();
    void hintModuleNames(Nearest& nearest) const;

    // declarations.cpp
    bool parseSpace(std::string_view word, Space& space) const;
    void parseVariableType(Variable& variable);
    void parseAttribute(Variable& variable);
    void parsePointer(Variable& variable);
    void parseDeclarator(Variable& variable);
    void parseDimensions(Variable& variable);
    void finishSize(Variable& variable);
    void parseModuleVariables(Linkage linkage, Space space, bool isTexture, Location location);
    void addModuleVariable(Variable&& variable);
    void parseBodyVariables(Linkage linkage, Space space);
    void parseRegisters();
    void declareRegister(std::string_view name, const Register& pattern);
    void parseInitializer(Variable& variable);
    void parseInitializerList(Variable& variable);
    void parseElement(Variable& variable, uint64_t element);
    bool parseMask(Relocation& relocation, unsigned elementSize);
    void parseAddressWord(Relocation& relocation);
    void storeRelocation(Variable& variable, Relocation relocation);
    void storeConstant(Variable& variable, uint64_t offset, const Constant& constant,
                       Location location);

    // functions.cpp
    void parseFunction(Linkage linkage, bool isEntry);
    std::vector<Variable> parseParameters(bool prototype);
    Variable parseParameter(bool prototype);
    void parseHeader(Function& function);
    void parseBodyFunction(Linkage linkage);
    void parseFunctionAttributes(Function& function);
    void parseTriple(uint32_t (&values)[3]);
    void declareParameters(std::vector<Variable>& variables, std::vector<uint32_t>& registers,
                           SymbolKind kind);
    void addFunction(Function&& function);
    void parsePrototype(Prototype& prototype);

    // bodies.cpp
    void parseBody();
    void parseStatement();
    void parseBodyDirective();
    void closeScope();
    void parseLabel(std::string_view name, Location location);
    void parseBranchTargets(BranchTargets& targets);
    void parseCallTargets(CallTargets& targets);
    void parseGuard(Instruction& instruction);
    void completeRounding(Instruction& instruction) const;
    void parseInstruction(Instruction& instruction);
    void parseCall(Instruction& instruction);
    std::vector<Operand> parseCallList();
    Operand parseLabelOperand(size_t operand);
    void useLabel(LabelUse::Where where, size_t item, size_t element, std::string_view name,
                  Location location);
    void bindLabel(const LabelUse& use, const LabelDeclaration& label);
    void reportUnbound(const std::vector<LabelUse>& uses);
    std::string_view uniqueName(std::string_view name, std::vector<uint32_t>& stamps);

    // operands.cpp
    Operand parseOperand();
    Operand parseOperandCore();
    Operand parseBraces();
    Operand parseBrackets();
    Operand parseNamed();
    Operand parseConstant();
    void parseComponent(Operand& operand);
    void parseIndex(Operand& operand, std::string_view name);
    const Variable* variableOf(NameId name);
    void parseOffset(Operand& operand);
    void resolve(Operand& operand, const Token& name);
    bool resolveSpecial(Operand& operand, const Token& name);
    [[noreturn]] void undeclared(const Token& name);
    uint32_t expectRegister(const char* what);
    Constant parseExpression(unsigned minimumPrecedence = 0);
    Constant parseUnary();
    Constant parseChoice(Constant condition);
    Constant binary(std::string_view op, const Constant& a, const Constant& b, Location location);
    int64_t parseIntegerExpression(const char* what);

    struct NameUse {
        NameId name;
        Location location;
    };

    Module& module_;
    Diagnostics& diagnostics_;
    const OpcodeTable& opcodes_;
    Lexer lexer_;
    Token token_;
    Names names_;
    Scopes scopes_;
    unsigned expressionDepth_ = 0;
    bool sawVersion_ = false, sawTarget_ = false;

    // State of the function being parsed.
    Function function_;
    SourcePosition source_;
    bool addressesAreValues_ = false;      // in this instruction sym[N] is an address, not a place
    size_t statement_ = 0;                 // index that the instruction being parsed will get
    uint32_t functionNumber_ = 0;          // from 1
    std::vector<uint32_t> variableStamps_; // by name: function that last used it for a variable
    std::vector<uint32_t> labelStamps_;    // the same for prototypes and target lists
    std::vector<uint32_t> suffixes_;       // by name: last number tried to make it unique

    std::vector<NameUse> moduleUses_;  // symbols that must be found at module scope
    std::vector<uint8_t> moduleNames_; // by name: 1 = declared at module scope
};

} // namespace sunstone::ptx
