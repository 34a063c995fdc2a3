// SPDX-License-Identifier: Apache-2.0
// Function bodies: statements, nested scopes, labels, calls. See parser_impl.h.
#include "ptx/parse/parser_impl.h"

#include <algorithm>

namespace sunstone::ptx {

// From '{' to its '}'. A loop handles nested braces, so their depth takes no stack.
void Parser::parseBody() {
    const Location start = token_.location;
    advance();
    scopes_.open();
    const size_t outermost = scopes_.depth();
    while (scopes_.depth() >= outermost) {
        if (atEnd()) {
            const size_t missing = scopes_.depth() - outermost + 1;
            fault(token_.location, "the text ends inside function " + quoted(function_.name) +
                                       " (its '{' is at " + std::to_string(start.line) + ":" +
                                       std::to_string(start.column) + "): " +
                                       (missing == 1 ? std::string("a '}' is")
                                                     : std::to_string(missing) + " '}' are") +
                                       " missing, the text may be truncated");
        }
        if (tooManyErrors())
            throw Fault{};
        try {
            parseStatement();
        } catch (const Fault&) {
            recover();
        }
    }
    reportUnbound(scopes_.endFunction(
        [this](const LabelUse& use, const LabelDeclaration& label) { bindLabel(use, label); }));
}

void Parser::closeScope() {
    advance();
    scopes_.close(
        [this](const LabelUse& use, const LabelDeclaration& label) { bindLabel(use, label); });
}

void Parser::parseStatement() {
    if (accept(';'))
        return;
    if (at('{')) {
        if (scopes_.depth() >= Scopes::kMaxDepth)
            fault(token_.location,
                  "braces are nested more than " + std::to_string(Scopes::kMaxDepth) + " deep");
        advance();
        return scopes_.open();
    }
    if (at('}'))
        return closeScope();
    if (token_.kind == TokenKind::kDotWord)
        return parseBodyDirective();
    statement_ = function_.body.size();
    Statement statement;
    if (at('@'))
        parseGuard(statement.instruction);
    else if (token_.kind != TokenKind::kIdentifier)
        unexpected("an instruction, a label or a directive");
    const Token first = token_;
    statement.instruction.opcode = expectName("an opcode");
    statement.instruction.location = first.location;
    if (at(':') && statement.instruction.guard < 0)
        return parseLabel(first.text, first.location);
    if (first.text[0] == '%')
        fault(first.location,
              "an instruction begins with its opcode, not with register " + quoted(first.text));
    parseInstruction(statement.instruction);
    function_.body.push_back(std::move(statement));
}

void Parser::parseBodyDirective() {
    const std::string_view word = token_.text;
    if (word == "loc")
        return parseLoc();
    if (word == "pragma")
        return parsePragma();
    if (word == "file")
        return parseFile();
    if (word == "section")
        return parseSection();
    const Linkage linkage = parseLinkage();
    Space space = Space::kNone;
    if (token_.kind == TokenKind::kDotWord && parseSpace(token_.text, space)) {
        advance();
        return space == Space::kReg ? parseRegisters() : parseBodyVariables(linkage, space);
    }
    if (token_.isDot("func")) {
        advance();
        return parseBodyFunction(linkage);
    }
    Nearest nearest(token_.text);
    for (const char* known :
         {"reg", "local", "shared", "param", "global", "const", "loc", "pragma"})
        nearest.offer(known);
    if (token_.kind != TokenKind::kDotWord)
        unexpected("a state space");
    const bool function = token_.text == "entry";
    fault(token_.location, "unknown directive " + quoted("." + std::string(token_.text)) +
                               " in the body of function " + quoted(function_.name) +
                               (function ? ": a '}' may be missing before it" : nearest.hint(".")));
}

// `name`, unless the function or the module already uses it: then name$1, name$2, ...
std::string_view Parser::uniqueName(std::string_view name, std::vector<uint32_t>& stamps) {
    const auto take = [&](NameId id) {
        if (id >= stamps.size())
            stamps.resize(names_.size() + names_.size() / 2);
        const bool taken = stamps[id] == functionNumber_ ||
                           module_.variableIndex.count(names_.text(id)) != 0 ||
                           module_.functionIndex.count(names_.text(id)) != 0;
        stamps[id] = functionNumber_;
        return !taken;
    };
    const NameId id = names_.intern(name);
    if (take(id))
        return name;
    if (id >= suffixes_.size())
        suffixes_.resize(names_.size() + names_.size() / 2);
    for (;;) {
        auto text = std::make_unique<std::string>(std::string(name) + "$" +
                                                  std::to_string(++suffixes_[id]));
        module_.generated.push_back(std::move(text));
        const std::string_view candidate = *module_.generated.back();
        if (take(names_.intern(candidate)))
            return candidate;
    }
}

// At the ':' after the name. A directive after the label may make it a prototype or a target list.
void Parser::parseLabel(std::string_view name, Location location) {
    advance();
    const NameId id = names_.intern(name);
    const auto declare = [&](LabelKind kind, size_t index) {
        if (const auto earlier =
                scopes_.declareLabel(id, kind, static_cast<uint32_t>(index), location))
            fault(location, "label " + quoted(name) +
                                " is defined twice in this scope; first at line " +
                                std::to_string(earlier->location.line));
    };
    if (token_.isDot("callprototype")) {
        advance();
        declare(LabelKind::kPrototype, function_.prototypes.size());
        Prototype prototype;
        prototype.name = uniqueName(name, labelStamps_);
        prototype.location = location;
        function_.prototypes.push_back(std::move(prototype));
        return parsePrototype(function_.prototypes.back());
    }
    if (token_.isDot("branchtargets")) {
        advance();
        declare(LabelKind::kBranchTargets, function_.branchTargets.size());
        function_.branchTargets.push_back({uniqueName(name, labelStamps_), {}});
        return parseBranchTargets(function_.branchTargets.back());
    }
    if (token_.isDot("calltargets")) {
        advance();
        declare(LabelKind::kCallTargets, function_.callTargets.size());
        function_.callTargets.push_back({uniqueName(name, labelStamps_), {}});
        return parseCallTargets(function_.callTargets.back());
    }
    declare(LabelKind::kLabel, function_.labels.size());
    Statement statement;
    statement.kind = StatementKind::kLabel;
    statement.label = static_cast<uint32_t>(function_.labels.size());
    statement.instruction.location = location;
    function_.labels.push_back(name);
    function_.body.push_back(std::move(statement));
}

void Parser::parseBranchTargets(BranchTargets& targets) {
    const size_t list = function_.branchTargets.size() - 1;
    do {
        const Token name = token_;
        expectName("a label");
        useLabel(LabelUse::Where::kBranchTarget, list, targets.labels.size(), name.text,
                 name.location);
        targets.labels.push_back(~0u);
    } while (accept(','));
    expect(';', "after the branch targets");
}

void Parser::parseCallTargets(CallTargets& targets) {
    do {
        const Token name = token_;
        targets.functions.push_back(expectName("a function name"));
        moduleUses_.push_back({names_.intern(name.text), name.location});
    } while (accept(','));
    expect(';', "after the call targets");
}

void Parser::useLabel(LabelUse::Where where, size_t item, size_t element, std::string_view name,
                      Location location) {
    LabelUse use;
    use.where = where;
    use.item = static_cast<uint32_t>(item);
    use.element = static_cast<uint32_t>(element);
    use.name = names_.intern(name);
    use.location = location;
    scopes_.useLabel(use);
}

// Writes a label's index into the operand that refers to the label.
void Parser::bindLabel(const LabelUse& use, const LabelDeclaration& label) {
    const auto wrong = [&](const char* wanted) {
        diagnostics_.error(use.location, quoted(names_.text(use.name)) + " (line " +
                                             std::to_string(label.location.line) + ") is not " +
                                             wanted);
    };
    if (use.where == LabelUse::Where::kBranchTarget) {
        if (label.kind != LabelKind::kLabel)
            return wrong("a label");
        function_.branchTargets[use.item].labels[use.element] = label.index;
        return;
    }
    // The statement is missing if a fault followed the use.
    if (use.item >= function_.body.size())
        return;
    Instruction& instruction = function_.body[use.item].instruction;
    if (use.where == LabelUse::Where::kCallShape) {
        if (label.kind == LabelKind::kPrototype)
            instruction.prototype = function_.prototypes[label.index].name;
        else if (label.kind == LabelKind::kCallTargets)
            instruction.prototype = function_.callTargets[label.index].name;
        else
            wrong("a .callprototype or .calltargets list");
        return;
    }
    if (use.element >= instruction.operands.size())
        return;
    Operand& operand = instruction.operands[use.element];
    if (label.kind == LabelKind::kLabel && operand.kind == OperandKind::kLabel)
        operand.index = label.index;
    else if (label.kind == LabelKind::kBranchTargets && operand.kind == OperandKind::kSymbol)
        operand.name = function_.branchTargets[label.index].name;
    else
        wrong(operand.kind == OperandKind::kLabel ? "a label" : "a .branchtargets list");
}

void Parser::reportUnbound(const std::vector<LabelUse>& uses) {
    for (const LabelUse& use : uses) {
        if (tooManyErrors())
            return;
        Nearest nearest(names_.text(use.name));
        for (const std::string_view label : function_.labels)
            nearest.offer(label);
        const bool inner = std::find(function_.labels.begin(), function_.labels.end(),
                                     names_.text(use.name)) != function_.labels.end();
        diagnostics_.error(use.location,
                           "unknown label " + quoted(names_.text(use.name)) + " in function " +
                               quoted(function_.name) +
                               (inner ? ": the label of this name is in a scope that cannot be "
                                        "seen from here"
                                      : nearest.hint()));
    }
}

// @p or @!p
void Parser::parseGuard(Instruction& instruction) {
    advance();
    instruction.guardNegated = accept('!');
    const Location location = token_.location;
    instruction.guard = static_cast<int32_t>(expectRegister("a predicate register"));
    const Register& predicate = function_.registers[instruction.guard];
    if (predicate.type != Type::kPred)
        diagnostics_.error(location, "the guard must be a .pred register, not a ." +
                                         std::string(nameOf(predicate.type)));
}

// PTX 1 may omit the rounding of floats: to the nearest, or that of the approximate forms.
void Parser::completeRounding(Instruction& instruction) const {
    static constexpr std::string_view kExact[] = {"mad", "div", "rcp", "sqrt"};
    static constexpr std::string_view kRough[] = {"div", "rcp", "sqrt", "rsqrt",
                                                  "sin", "cos", "lg2",  "ex2"};
    const auto isOneOf = [&](const auto& opcodes) {
        return std::find(std::begin(opcodes), std::end(opcodes), instruction.opcode) !=
               std::end(opcodes);
    };
    const Type type = instruction.types.empty() ? Type::kNone : instruction.types[0];
    for (const std::string_view given : {"rn", "rz", "rm", "rp", "approx", "full"})
        if (!isFloat(type) || instruction.has(given))
            return;
    std::vector<std::string_view>& modifiers = instruction.modifiers;
    if (type == Type::kF32 && isOneOf(kRough))
        modifiers.insert(modifiers.begin(), {"approx", "ftz"});
    else if (isOneOf(kExact))
        modifiers.insert(modifiers.begin(), "rn");
}

void Parser::parseInstruction(Instruction& instruction) {
    instruction.source = source_;
    while (token_.kind == TokenKind::kDotWord) {
        Type type = Type::kNone;
        instruction.modifiers.push_back(token_.text);
        if (typeFromName(token_.text, type))
            instruction.types.push_back(type);
        advance();
    }
    if (module_.versionMajor < 2)
        completeRounding(instruction);
    instruction.facts = &opcodes_.find(instruction.opcode);
    const Syntax syntax = instruction.facts->syntax;
    if (syntax == Syntax::kCall)
        return parseCall(instruction);
    addressesAreValues_ = syntax == Syntax::kAddresses;
    if (!at(';')) {
        do {
            const size_t index = instruction.operands.size();
            const bool isTable = syntax == Syntax::kTargets && index == 1;
            instruction.operands.push_back(
                syntax == Syntax::kLabel || isTable ? parseLabelOperand(index) : parseOperand());
            if (isTable)
                instruction.operands.back().kind = OperandKind::kSymbol;
        } while (accept(','));
    }
    if (!at(';')) {
        const std::string where =
            "',' or ';' after the operands of " + std::string(instruction.opcode);
        unexpected(where.c_str());
    }
    advance();
}

Operand Parser::parseLabelOperand(size_t index) {
    Operand operand;
    operand.kind = OperandKind::kLabel;
    operand.location = token_.location;
    operand.name = expectName("a label");
    useLabel(LabelUse::Where::kOperand, statement_, index, operand.name, operand.location);
    return operand;
}

// ( operand {, operand} )
std::vector<Operand> Parser::parseCallList() {
    std::vector<Operand> list;
    expect('(', "of the argument list");
    if (accept(')'))
        return list;
    do
        list.push_back(parseOperand());
    while (accept(','));
    expect(')', "after the arguments");
    return list;
}

// call[.uni] [(results),] target [, (arguments)] [, prototype] ;
void Parser::parseCall(Instruction& call) {
    addressesAreValues_ = true;
    if (at('(')) {
        call.results = parseCallList();
        expect(',', "between the results and the callee of the call");
    }
    const Token name = token_;
    expectName("a function name or a register");
    call.target.location = name.location;
    const auto symbol = scopes_.find(names_.intern(name.text), function_.registers);
    if (symbol && symbol->kind == SymbolKind::kRegister) {
        call.target.kind = OperandKind::kRegister;
        call.target.index = symbol->index;
    } else {
        call.target.kind = OperandKind::kSymbol;
        call.target.name = name.text;
        if (name.text[0] == '%')
            undeclared(name);
    }
    if (accept(',')) {
        if (at('('))
            call.arguments = parseCallList();
        if (call.arguments.empty() ? token_.kind == TokenKind::kIdentifier || accept(',')
                                   : accept(',')) {
            const Token shape = token_;
            call.prototype = expectName("the label of a .callprototype or .calltargets");
            useLabel(LabelUse::Where::kCallShape, statement_, 0, shape.text, shape.location);
        }
    }
    expect(';', "after the call");
}

} // namespace sunstone::ptx
