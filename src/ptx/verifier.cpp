// SPDX-License-Identifier: Apache-2.0
// Checks every instruction against the instruction table. See verifier.h.
//
// A module has few opcode spellings and many instructions. The forms that match a spelling are
// therefore cached, and the common check is one look-up and a loop over operands.
#include "ptx/verifier.h"

#include "ptx/opcodes/opcode.h"
#include "ptx/opcodes/special_registers.h"
#include "ptx/printer.h"

#include <algorithm>
#include <deque>
#include <memory>
#include <unordered_map>

namespace sunstone::ptx {
namespace {

using Forms = std::vector<const Form*>;

// Functions that the engine or the driver provides without a declaration in the module.
bool isProvided(std::string_view name) {
    const auto startsWith = [&](std::string_view prefix) {
        return name.substr(0, prefix.size()) == prefix;
    };
    return startsWith("_optix_") || startsWith("_rt_") || startsWith("_rti_") ||
           name == "vprintf" || name == "__assertfail" || name == "malloc" || name == "free";
}

std::string bitsOf(unsigned bytes) {
    return std::to_string(bytes * 8) + "-bit";
}

class Verifier {
public:
    Verifier(const Module& module, Diagnostics& diagnostics, const Judge& judge,
             const OpcodeTable& opcodes)
        : module_(module), diagnostics_(diagnostics), judge_(judge), opcodes_(opcodes) {}

    void run(Module& module) {
        for (Function& function : module.functions) {
            function_ = &function;
            for (Statement& statement : function.body) {
                if (statement.kind != StatementKind::kInstruction)
                    continue;
                instruction_ = &statement.instruction;
                const size_t errors = diagnostics_.errorCount();
                check();
                if (judge_ && (diagnostics_.errorCount() != errors || formsFor().empty()))
                    statement.instruction.isForeign = ask(errors);
                if (diagnostics_.errorCount() >= Diagnostics::kMaxErrors)
                    return;
            }
        }
    }

private:
    void check();
    bool ask(size_t errorsBefore);
    std::unique_ptr<Module> moduleOfInstruction() const;
    const Forms& formsFor();
    std::string_view spelling();
    Forms findMatching();
    void checkCall();
    void checkOperands(const Form& form);
    void wrongCount(const Forms& forms);
    void checkOperand(const Operand& operand, const OperandRule& rule);
    void checkDestination(const Operand& operand, const OperandRule& rule);
    void checkSource(const Operand& operand, const OperandRule& rule);
    void checkVector(const Operand& operand, const OperandRule& rule);
    void checkPair(const Operand& operand, const OperandRule& rule);
    void checkAddress(const Operand& operand);
    void checkMove();
    void checkMoveSide(const Operand& operand, bool destination);
    void checkPacked(const Operand& operand, bool destination);
    bool checkWidth(const Operand& operand, unsigned bytes, bool predicate, bool wider);
    void checkImmediate(const Operand& operand, Type type);
    Type typeOf(const OperandRule& rule) const;
    unsigned vectorSize() const;
    bool isGenericOrGlobal() const;

    void error(const Operand& operand, const std::string& text) {
        diagnostics_.error(operand.location.line ? operand.location : instruction_->location,
                           "'" + instruction_->fullOpcode() + "': " + text);
    }
    const Register* registerOf(const Operand& operand) const {
        return operand.index < function_->registers.size() ? &function_->registers[operand.index]
                                                           : nullptr;
    }
    std::string nameOfOperand(const Operand& operand) const;

    const Module& module_;
    Diagnostics& diagnostics_;
    const Judge& judge_;
    const OpcodeTable& opcodes_;
    std::unordered_map<std::string, bool> verdicts_; // by text
    const Function* function_ = nullptr;
    const Instruction* instruction_ = nullptr;
    std::unordered_map<std::string_view, Forms> cache_;
    std::deque<std::string> spellings_; // keys of cache_ that are not pieces of the text
};

std::string nameOfRegister(const Register& reg) {
    std::string name(reg.name);
    if (reg.number != ~0u)
        name += std::to_string(reg.number);
    return quoted(name);
}

std::string Verifier::nameOfOperand(const Operand& operand) const {
    switch (operand.kind) {
    case OperandKind::kRegister:
        if (const Register* reg = registerOf(operand))
            return nameOfRegister(*reg);
        return "a register";
    case OperandKind::kInteger:
    case OperandKind::kFloat:
        return "a literal";
    case OperandKind::kSymbol:
    case OperandKind::kSpecial:
        return quoted(operand.name);
    case OperandKind::kAddress:
        return "an address";
    case OperandKind::kVector:
        return "a vector";
    case OperandKind::kLabel:
        return "a label";
    case OperandKind::kSink:
        return "'_'";
    case OperandKind::kPair:
        return "a pair";
    case OperandKind::kTexture:
        return "a texture";
    }
    return "an operand";
}

// The opcode with its modifiers as one piece of the text, if they are contiguous.
std::string_view Verifier::spelling() {
    const std::string_view opcode = instruction_->opcode;
    const char* end = opcode.data() + opcode.size();
    for (const std::string_view modifier : instruction_->modifiers) {
        if (modifier.data() != end + 1) {
            spellings_.push_back(instruction_->fullOpcode());
            return spellings_.back();
        }
        end = modifier.data() + modifier.size();
    }
    return std::string_view(opcode.data(), static_cast<size_t>(end - opcode.data()));
}

const Forms& Verifier::formsFor() {
    const std::string_view key = spelling();
    const auto found = cache_.find(key);
    if (found != cache_.end())
        return found->second;
    return cache_.emplace(key, findMatching()).first->second;
}

// Reports only the first use of a faulty spelling.
Forms Verifier::findMatching() {
    Forms result;
    const std::vector<Form>& forms = instruction_->facts->forms;
    if (forms.empty()) {
        Nearest nearest(instruction_->opcode);
        for (const Opcode& opcode : opcodes_.all())
            nearest.offer(opcode.name);
        diagnostics_.error(instruction_->location,
                           "unknown instruction " + quoted(instruction_->opcode) + nearest.hint());
        return result;
    }
    FormProblem problem;
    for (const Form& form : forms)
        if (matches(form, *instruction_, &problem))
            result.push_back(&form);
    if (!result.empty())
        return result;
    // A modifier that no form of the opcode has is the most specific cause.
    for (const std::string_view modifier : instruction_->modifiers) {
        Nearest nearest(modifier);
        bool known = false;
        for (const Form& form : forms) {
            for (const ModifierGroup& group : form.groups)
                for (const std::string_view choice : group.choices) {
                    known |= choice == modifier;
                    nearest.offer(choice);
                }
            for (unsigned type = 1; type <= static_cast<unsigned>(Type::kSurfref); ++type)
                for (const uint32_t set : form.types)
                    if (set >> type & 1) {
                        known |= modifier == nameOf(static_cast<Type>(type));
                        nearest.offer(nameOf(static_cast<Type>(type)));
                    }
        }
        if (!known) {
            diagnostics_.error(instruction_->location,
                               "'" + instruction_->fullOpcode() + "': unknown modifier " +
                                   quoted("." + std::string(modifier)) + " for " +
                                   quoted(instruction_->opcode) + nearest.hint("."));
            return result;
        }
    }
    diagnostics_.error(instruction_->location,
                       "'" + instruction_->fullOpcode() + "' " + problem.text);
    return result;
}

// A module with only this instruction, in a function with the same registers; null if the
// instruction needs other declarations.
std::unique_ptr<Module> Verifier::moduleOfInstruction() const {
    auto alone = std::make_unique<Module>();
    Module& module = *alone;
    module.versionMajor = module_.versionMajor;
    module.versionMinor = module_.versionMinor;
    module.target = module_.target;
    Function function;
    function.name = "instruction";
    function.hasBody = true;
    function.registers = function_->registers;
    Statement statement;
    statement.instruction = *instruction_;
    statement.instruction.source = {};
    bool isPlain = instruction_->facts->syntax != Syntax::kCall;
    const auto visit = [&](const auto& self, const Operand& operand) -> void {
        isPlain = isPlain && operand.kind != OperandKind::kLabel;
        for (const Operand& element : operand.elements)
            self(self, element);
        if (operand.name.empty() || operand.kind == OperandKind::kSpecial ||
            operand.kind == OperandKind::kRegister)
            return;
        const auto isNamed = [&](const Variable& each) { return each.name == operand.name; };
        const auto own =
            std::find_if(function_->variables.begin(), function_->variables.end(), isNamed);
        const Variable* const variable =
            own != function_->variables.end() ? &*own : module_.findVariable(operand.name);
        if (!variable)
            isPlain = false;
        else if (std::none_of(module.variables.begin(), module.variables.end(), isNamed)) {
            module.variables.push_back(*variable);
            Variable& copy = module.variables.back();
            copy.linkage = Linkage::kInternal;
            copy.hasInitializer = false;
            copy.initializer.clear();
            copy.relocations.clear();
        }
    };
    for (const Operand& operand : instruction_->operands)
        visit(visit, operand);
    function.body.push_back(std::move(statement));
    module.functions.push_back(std::move(function));
    return isPlain ? std::move(alone) : nullptr;
}

// Asks the judge about an instruction that violates a rule, or whose spelling has violated one
// before.
bool Verifier::ask(size_t errorsBefore) {
    if (const std::unique_ptr<Module> alone = moduleOfInstruction()) {
        const auto [known, isNew] = verdicts_.emplace(print(*alone), false);
        if (isNew)
            known->second = judge_(*alone);
        if (known->second) {
            diagnostics_.keepErrors(errorsBefore);
            return true;
        }
    }
    if (diagnostics_.errorCount() == errorsBefore)
        diagnostics_.error(instruction_->location, "'" + instruction_->fullOpcode() +
                                                       "' is not known, and the driver refuses it");
    return false;
}

void Verifier::check() {
    const Forms& forms = formsFor();
    if (forms.empty())
        return;
    if (instruction_->facts->syntax == Syntax::kCall)
        return checkCall();
    const size_t count = instruction_->operands.size();
    for (const Form* form : forms) {
        if (form->loose)
            return;
        if (count >= form->minimumOperands && count <= form->operands.size())
            return checkOperands(*form);
    }
    wrongCount(forms);
}

void Verifier::wrongCount(const Forms& forms) {
    size_t least = ~size_t(0), most = 0;
    for (const Form* form : forms) {
        least = std::min(least, form->minimumOperands);
        most = std::max(most, form->operands.size());
    }
    std::string wanted = std::to_string(least);
    if (most != least)
        wanted += (most == least + 1 ? " or " : " to ") + std::to_string(most);
    diagnostics_.error(instruction_->location, "'" + instruction_->fullOpcode() + "' takes " +
                                                   wanted + " operand" + (most == 1 ? "" : "s") +
                                                   ", not " +
                                                   std::to_string(instruction_->operands.size()));
}

void Verifier::checkCall() {
    const Operand& target = instruction_->target;
    if (target.kind == OperandKind::kRegister) {
        const Register* reg = registerOf(target);
        if (reg && (reg->vector != 1 || sizeOf(reg->type) != 8 || reg->type == Type::kPred))
            error(target, "the callee's address must be a 64-bit register");
        if (instruction_->prototype.empty())
            error(target, "a call through a register needs a .callprototype or .calltargets label");
        return;
    }
    const Function* callee = module_.findFunction(target.name);
    if (!callee) {
        for (const auto& alias : module_.aliases)
            if (alias.first == target.name)
                callee = module_.findFunction(alias.second);
    }
    if (!callee) {
        if (isProvided(target.name))
            return;
        Nearest nearest(target.name);
        for (const Function& function : module_.functions)
            nearest.offer(function.name);
        diagnostics_.error(target.location, "call of function " + quoted(target.name) +
                                                ", which the module neither declares nor defines" +
                                                nearest.hint());
        return;
    }
    const auto compare = [&](size_t has, size_t wants, const char* what) {
        if (has != wants)
            error(target, "function " + quoted(target.name) + " has " + std::to_string(wants) +
                              " " + what + (wants == 1 ? "" : "s") + ", the call " +
                              std::to_string(has));
    };
    compare(instruction_->results.size(), callee->results.size(), "result");
    compare(instruction_->arguments.size(), callee->parameters.size(), "parameter");
}

Type Verifier::typeOf(const OperandRule& rule) const {
    return rule.type < instruction_->types.size() ? instruction_->types[rule.type] : Type::kNone;
}

unsigned Verifier::vectorSize() const {
    for (const std::string_view modifier : instruction_->modifiers)
        if (modifier.size() == 2 && modifier[0] == 'v')
            return static_cast<unsigned>(modifier[1] - '0');
    return 1;
}

void Verifier::checkOperands(const Form& form) {
    if (form.operands.size() == 2 && form.operands[0].kind == OperandRuleKind::kMove)
        return checkMove();
    for (size_t i = 0; i < instruction_->operands.size(); ++i)
        checkOperand(instruction_->operands[i], form.operands[i]);
}

void Verifier::checkOperand(const Operand& operand, const OperandRule& rule) {
    switch (rule.kind) {
    case OperandRuleKind::kAny:
        return;
    case OperandRuleKind::kAddress:
        return checkAddress(operand);
    case OperandRuleKind::kTexture:
        if (operand.kind != OperandKind::kTexture)
            error(operand, "expected [texture, coordinates], found " + nameOfOperand(operand));
        return;
    case OperandRuleKind::kLabel:
        if (operand.kind != OperandKind::kLabel)
            error(operand, "expected a label, found " + nameOfOperand(operand));
        return;
    case OperandRuleKind::kTargets:
        if (operand.kind != OperandKind::kSymbol)
            error(operand, "expected a .branchtargets label, found " + nameOfOperand(operand));
        return;
    case OperandRuleKind::kConstant:
        if (operand.kind != OperandKind::kInteger)
            error(operand, "expected an integer literal, found " + nameOfOperand(operand));
        return;
    default:
        break;
    }
    if (operand.kind == OperandKind::kPair && rule.destination)
        return checkPair(operand, rule);
    const Register* reg = operand.kind == OperandKind::kRegister ? registerOf(operand) : nullptr;
    if (rule.vectorised && (vectorSize() > 1 || operand.kind == OperandKind::kVector ||
                            (reg && reg->vector > 1 && operand.component < 0)))
        return checkVector(operand, rule);
    if (rule.destination)
        checkDestination(operand, rule);
    else
        checkSource(operand, rule);
}

// value|predicate and predicate|predicate
void Verifier::checkPair(const Operand& operand, const OperandRule& rule) {
    if (!rule.pair && !rule.predicateToo)
        return error(operand, "takes no pair of destinations");
    OperandRule first = rule;
    first.sink = true;
    checkOperand(operand.elements[0], first);
    OperandRule second;
    second.kind = OperandRuleKind::kPredicate;
    second.destination = second.sink = true;
    checkOperand(operand.elements[1], second);
}

// Whether a register or special register has the required width; reports an error if not.
bool Verifier::checkWidth(const Operand& operand, unsigned bytes, bool predicate, bool wider) {
    Type type = Type::kNone;
    if (operand.kind == OperandKind::kSpecial) {
        const std::string_view name = operand.name.substr(0, operand.name.find('.'));
        const SpecialRegister* special = findSpecialRegister(name);
        if (special && special->vector && name.size() == operand.name.size()) {
            error(operand, quoted(name) + " is a vector: one of .x, .y, .z must follow");
            return false;
        }
        type = special ? special->type : Type::kNone;
    } else {
        const Register* reg = registerOf(operand);
        if (!reg)
            return true;
        if (reg->vector > 1 && operand.component < 0) {
            error(operand, "register " + nameOfOperand(operand) + " is a vector of " +
                               std::to_string(reg->vector) + ": one of its parts is needed here");
            return false;
        }
        type = reg->type;
    }
    if (predicate || type == Type::kPred) {
        if (predicate && type == Type::kPred)
            return true;
        error(operand, predicate ? "expected a predicate, found " + nameOfOperand(operand) +
                                       " of type ." + nameOf(type)
                                 : "predicate " + nameOfOperand(operand) +
                                       " stands where a value of " + bitsOf(bytes) + " is needed");
        return false;
    }
    const unsigned size = sizeOf(type);
    if (size == bytes || (wider && size > bytes))
        return true;
    // %tid.x and the like had 16 bits in early versions, and mov still accepts this width.
    if (operand.kind == OperandKind::kSpecial && bytes == 2 && size == 4 &&
        instruction_->facts->operation == Operation::kMove)
        return true;
    error(operand, nameOfOperand(operand) + " is " + bitsOf(size) + " (." + nameOf(type) +
                       "), this operand needs " + bitsOf(bytes) + (wider ? " or more" : ""));
    return false;
}

void Verifier::checkDestination(const Operand& operand, const OperandRule& rule) {
    if (operand.kind == OperandKind::kSink && rule.sink)
        return;
    if (operand.kind != OperandKind::kRegister)
        return error(operand, "the result must go to a register, found " + nameOfOperand(operand));
    if (operand.negated)
        return error(operand, "a result cannot be negated");
    const Type type = typeOf(rule);
    const bool predicate = rule.kind == OperandRuleKind::kPredicate ||
                           (rule.kind == OperandRuleKind::kTyped && type == Type::kPred);
    const unsigned bytes = rule.kind == OperandRuleKind::kFixed ? rule.bytes
                           : rule.kind == OperandRuleKind::kWide
                               ? 2 * sizeOf(instruction_->types[0])
                               : sizeOf(type);
    checkWidth(operand, bytes, predicate, rule.wider);
}

void Verifier::checkImmediate(const Operand& operand, Type type) {
    const bool isFloatLiteral = operand.kind == OperandKind::kFloat;
    const std::string shown = std::string(".") + nameOf(type);
    if (type == Type::kF32 || type == Type::kF64) {
        if (!isFloatLiteral)
            error(operand, "an integer literal stands where a " + shown +
                               " is needed (write 1.0 or 0f3F800000)");
        return;
    }
    if (isFloat(type))
        return error(operand, "there are no literals of type " + shown + ": use a register");
    if (!isFloatLiteral)
        return;
    const bool bits = type == Type::kB32 || type == Type::kB64;
    if (!bits || operand.floatBits != 8 * sizeOf(type))
        error(operand, "a " + std::to_string(operand.floatBits) +
                           "-bit floating point literal does not fit an operand of type " + shown);
}

void Verifier::checkSource(const Operand& operand, const OperandRule& rule) {
    const Type type = rule.kind == OperandRuleKind::kFixed ? (rule.bytes == 2   ? Type::kU16
                                                              : rule.bytes == 4 ? Type::kU32
                                                                                : Type::kU64)
                                                           : typeOf(rule);
    const bool predicate = rule.kind == OperandRuleKind::kPredicate || type == Type::kPred;
    const unsigned bytes =
        rule.kind == OperandRuleKind::kWide ? 2 * sizeOf(instruction_->types[0]) : sizeOf(type);
    switch (operand.kind) {
    case OperandKind::kRegister:
        if (operand.negated && !predicate)
            return error(operand, "only predicates can be negated here");
        checkWidth(operand, bytes, predicate, rule.wider);
        return;
    case OperandKind::kSpecial:
        checkWidth(operand, bytes, predicate, rule.wider);
        return;
    case OperandKind::kInteger:
        if (!predicate && rule.kind == OperandRuleKind::kTyped)
            checkImmediate(operand, type);
        return;
    case OperandKind::kFloat:
        if (predicate)
            return error(operand, "a floating point literal stands where a predicate is needed");
        return checkImmediate(operand, rule.kind == OperandRuleKind::kWide ? Type::kS64 : type);
    case OperandKind::kSymbol:
        if (!rule.symbol)
            return error(operand, "the address of " + quoted(operand.name) +
                                      " cannot stand here: take it with mov first");
        return;
    default:
        error(operand, nameOfOperand(operand) + " stands where a register or literal is needed");
    }
}

// {a, b, ...} or a vector register, of as many elements as .vN says.
void Verifier::checkVector(const Operand& operand, const OperandRule& rule) {
    const unsigned wanted = vectorSize();
    const Type type = typeOf(rule);
    if (operand.kind == OperandKind::kSink && rule.destination && rule.sink)
        return;
    if (operand.kind == OperandKind::kRegister) {
        const Register* reg = registerOf(operand);
        if (reg && (reg->vector != wanted || operand.component >= 0))
            error(operand, nameOfOperand(operand) + " is not a vector of " +
                               std::to_string(wanted) + " elements");
        else if (reg && sizeOf(reg->type) < sizeOf(type))
            error(operand, nameOfOperand(operand) + " has elements of " +
                               bitsOf(sizeOf(reg->type)) + ", this operand needs " +
                               bitsOf(sizeOf(type)));
        return;
    }
    if (operand.kind != OperandKind::kVector)
        return error(operand, "expected a vector of " + std::to_string(wanted) +
                                  " elements, found " + nameOfOperand(operand));
    if (operand.elements.size() != wanted)
        return error(operand, "the vector has " + std::to_string(operand.elements.size()) +
                                  " elements, the instruction takes " + std::to_string(wanted));
    OperandRule element = rule;
    element.vectorised = false;
    element.sink = true;
    for (const Operand& part : operand.elements) {
        if (rule.destination)
            checkDestination(part, element);
        else
            checkSource(part, element);
    }
}

void Verifier::checkAddress(const Operand& operand) {
    if (operand.kind != OperandKind::kAddress)
        return error(operand,
                     operand.kind == OperandKind::kSymbol && operand.name.size()
                         ? "the address " + quoted(operand.name) + " needs brackets: [" +
                               std::string(operand.name) + "]"
                         : "expected an address in brackets, found " + nameOfOperand(operand));
    const Register* reg = registerOf(operand);
    if (!reg)
        return;
    const unsigned size = sizeOf(reg->type);
    if (reg->type == Type::kPred || (reg->vector > 1 && operand.component < 0) ||
        (size != 8 && size != 4))
        error(operand, "an address register has 64 bits (or 32 in .shared, .local and .const), "
                       "this one is of type ." +
                           std::string(nameOf(reg->type)));
    else if (size == 4 && operand.scale == 0 && isGenericOrGlobal())
        error(operand, "register " + nameOfRegister(*reg) +
                           " has 32 bits, an address in generic or "
                           ".global space has 64");
}

// Whether a load or store accesses a space with 64-bit addresses.
bool Verifier::isGenericOrGlobal() const {
    if (!instruction_->facts->isAccess())
        return false;
    for (const std::string_view modifier : instruction_->modifiers)
        if (modifier == "local" || modifier == "const" || modifier.substr(0, 6) == "shared" ||
            modifier.substr(0, 5) == "param")
            return false;
    return true;
}

void Verifier::checkMove() {
    const Operand& to = instruction_->operands[0];
    const Operand& from = instruction_->operands[1];
    if (to.kind == OperandKind::kVector && from.kind == OperandKind::kVector && vectorSize() == 1)
        return error(to, "packs and unpacks at once: one side must be a single register (or write "
                         "mov.v2, mov.v4)");
    checkMoveSide(to, true);
    checkMoveSide(from, false);
}

void Verifier::checkMoveSide(const Operand& operand, bool destination) {
    OperandRule rule;
    rule.kind = OperandRuleKind::kTyped;
    rule.destination = destination;
    const Register* reg = operand.kind == OperandKind::kRegister ? registerOf(operand) : nullptr;
    if (vectorSize() > 1) {
        rule.vectorised = true;
        return checkVector(operand, rule);
    }
    if (operand.kind == OperandKind::kVector || (reg && reg->vector > 1 && operand.component < 0))
        return checkPacked(operand, destination);
    if (destination)
        return checkDestination(operand, rule);
    if (operand.kind != OperandKind::kSymbol && operand.kind != OperandKind::kAddress)
        return checkSource(operand, rule);
    const unsigned size = sizeOf(instruction_->types[0]);
    if (operand.kind == OperandKind::kAddress)
        error(operand, "mov takes no memory operand: use ld");
    else if (isFloat(instruction_->types[0]) || (size != 8 && size != 4))
        error(operand, "the address of " + quoted(operand.name) + " does not fit type ." +
                           std::string(nameOf(instruction_->types[0])));
}

// mov.b64 d, {a, b} and mov.b64 {a, b}, d: the parts' sizes add up to the whole.
void Verifier::checkPacked(const Operand& operand, bool destination) {
    const Type type = instruction_->types[0];
    const bool bits =
        type == Type::kB16 || type == Type::kB32 || type == Type::kB64 || type == Type::kB128;
    const Register* vector = operand.kind == OperandKind::kRegister ? registerOf(operand) : nullptr;
    const size_t count = vector ? vector->vector : operand.elements.size();
    const unsigned part = count ? sizeOf(type) / static_cast<unsigned>(count) : 0;
    if (!bits || count < 2 || part * count != sizeOf(type))
        return error(operand, std::to_string(count) + " parts do not make up a value of type ." +
                                  nameOf(type));
    if (vector) {
        if (sizeOf(vector->type) != part)
            error(operand, "each part must be " + bitsOf(part));
        return;
    }
    for (const Operand& element : operand.elements) {
        if (element.kind == OperandKind::kSink && destination)
            continue;
        if (element.kind == OperandKind::kRegister)
            checkWidth(element, part, false, false);
        else if (destination ||
                 (element.kind != OperandKind::kInteger && element.kind != OperandKind::kFloat))
            error(element,
                  "each part must be a register" + std::string(destination ? "" : " or a literal"));
    }
}

} // namespace

void verify(Module& module, Diagnostics& diagnostics, const Judge& judge,
            const OpcodeTable& opcodes) {
    Verifier(module, diagnostics, judge, opcodes).run(module);
}

} // namespace sunstone::ptx
