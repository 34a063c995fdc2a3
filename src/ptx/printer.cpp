// SPDX-License-Identifier: Apache-2.0
// Tree to PTX text. See printer.h.
#include "ptx/printer.h"

#include "ptx/opcodes/opcode.h"

#include <algorithm>
#include <concepts>
#include <cstring>
#include <unordered_map>
#include <unordered_set>

namespace sunstone::ptx {
namespace {

const char* spaceName(Space space) {
    switch (space) {
    case Space::kReg:
        return ".reg";
    case Space::kConst:
        return ".const";
    case Space::kGlobal:
        return ".global";
    case Space::kLocal:
        return ".local";
    case Space::kParam:
        return ".param";
    case Space::kShared:
        return ".shared";
    case Space::kNone:
        break;
    }
    return "";
}

const char* linkageName(Linkage linkage) {
    switch (linkage) {
    case Linkage::kVisible:
        return ".visible ";
    case Linkage::kExtern:
        return ".extern ";
    case Linkage::kWeak:
        return ".weak ";
    case Linkage::kCommon:
        return ".common ";
    case Linkage::kInternal:
        break;
    }
    return "";
}

const char* componentName(int component) {
    static const char* const kNames[] = {".x",  ".y",  ".z",  ".w",  ".b0",
                                         ".b1", ".b2", ".b3", ".h0", ".h1"};
    return component >= 0 && component < 10 ? kNames[component] : "";
}

bool isOpaque(Type type) {
    return type == Type::kTexref || type == Type::kSamplerref || type == Type::kSurfref;
}

class Printer {
public:
    explicit Printer(const Module& module) : module_(module) {
        for (const Variable& variable : module_.variables)
            moduleNames_.insert(variable.name);
        for (const Function& function : module_.functions)
            moduleNames_.insert(function.name);
    }

    std::string run() {
        header();
        for (const Function& function : module_.functions)
            if (!function.hasBody)
                printFunction(function);
        declareNamedByInitializers();
        for (const Variable& variable : module_.variables) {
            printVariable(variable);
            text_ += ";\n";
        }
        for (const Function& function : module_.functions)
            if (function.hasBody)
                printFunction(function);
        for (const auto& [name, target] : module_.aliases)
            add(".alias ", name, ", ", target, ";\n");
        return std::move(text_);
    }

private:
    void add(std::string_view part) { text_ += part; }
    void add(std::integral auto number) { text_ += std::to_string(number); }
    void add(const auto& first, const auto& second, const auto&... rest) {
        add(first);
        add(second, rest...);
    }

    void header();
    void declareNamedByInitializers();
    void printHex(uint64_t bits, unsigned digits);
    void printType(const Variable& variable);
    void printVariable(const Variable& variable);
    void printInitializer(const Variable& variable);
    void printElement(const Variable& variable, size_t offset);
    void printRelocation(const Relocation& relocation);
    void printParameters(const std::vector<Variable>& parameters, bool prototype);
    void printTriple(const char* directive, const uint32_t (&values)[3]);
    void printAttributes(const Function& function);
    void printHeader(const Function& function);
    void printFunction(const Function& function);
    void printDeclarations(const Function& function);
    void printInstruction(const Instruction& instruction);
    void printCall(const Instruction& call);
    void printList(const std::vector<Operand>& operands, const char* open, const char* close);
    void printOperand(const Operand& operand);
    void printRegister(const Operand& operand);
    void printOffset(int64_t offset);
    void printSymbol(const Operand& operand);
    void printAddress(const Operand& operand);
    void nameLocals(const Function& function);
    std::string unique(std::string name);

    const Module& module_;
    const Function* function_ = nullptr;
    std::string text_;
    std::unordered_set<std::string_view> moduleNames_;
    std::unordered_set<std::string> taken_; // names in use in the function
    std::vector<bool> inHeader_;            // registers that are parameters or results
    std::vector<std::string> registers_;    // printed name of each register
    std::vector<std::string> labels_;
    std::unordered_map<std::string, uint32_t> suffixes_; // last number tried, by name
    SourcePosition source_;
};

void Printer::header() {
    add(".version ", module_.versionMajor, ".", module_.versionMinor, "\n.target ", module_.target);
    for (const std::string_view option : module_.targetOptions)
        if (option != "debug") // it requires the debug sections, which the tree omits
            add(", ", option);
    add("\n.address_size ", module_.addressSize, "\n\n");
    for (size_t i = 0; i < module_.files.size(); ++i)
        if (!module_.files[i].empty())
            add(".file ", uint64_t(i), " \"", module_.files[i], "\"\n");
}

// Assemblers require a declaration before an initialiser takes a function's address.
void Printer::declareNamedByInitializers() {
    std::unordered_set<std::string_view> named;
    for (const Variable& variable : module_.variables)
        for (const Relocation& relocation : variable.relocations)
            named.insert(relocation.symbol);
    for (const Function& function : module_.functions)
        if (!function.hasBody)
            named.erase(function.name);
    for (const Function& function : module_.functions) {
        if (named.count(function.name) == 0)
            continue;
        printHeader(function);
        add(";\n\n");
    }
}

void Printer::printHex(uint64_t bits, unsigned digits) {
    for (unsigned i = digits; i-- > 0;)
        text_ += "0123456789ABCDEF"[bits >> (4 * i) & 15];
}

void Printer::printType(const Variable& variable) {
    add(spaceName(variable.space));
    if (variable.isManaged)
        add(" .attribute(.managed)");
    if (variable.space != Space::kReg && !isOpaque(variable.type) && !variable.isPointer)
        add(" .align ", variable.alignment);
    if (variable.vector > 1)
        add(" .v", variable.vector);
    add(" .", nameOf(variable.type));
    if (!variable.isPointer)
        return;
    add(" .ptr");
    if (variable.pointerSpace != Space::kNone)
        add(" ", spaceName(variable.pointerSpace));
    if (variable.pointerAlignment)
        add(" .align ", variable.pointerAlignment);
}

void Printer::printVariable(const Variable& variable) {
    add(linkageName(variable.linkage));
    printType(variable);
    add(" ", variable.name);
    for (const uint64_t dimension : variable.dimensions) {
        add("[");
        if (dimension)
            add(dimension);
        add("]");
    }
    if (variable.hasInitializer)
        printInitializer(variable);
}

void Printer::printRelocation(const Relocation& relocation) {
    if (relocation.generic)
        add("generic(", relocation.symbol, ")");
    else
        add(relocation.symbol);
    if (relocation.addend)
        printOffset(relocation.addend);
}

void Printer::printElement(const Variable& variable, size_t offset) {
    uint64_t bits = 0;
    const unsigned size = sizeOf(variable.type);
    std::memcpy(&bits, variable.initializer.data() + offset, std::min(size, 8u));
    if (variable.type == Type::kF32 || variable.type == Type::kF64) {
        add(size == 4 ? "0f" : "0d");
        printHex(bits, 2 * size);
    } else {
        add(bits);
    }
}

// Prints one element after the other, with braces at the start and end of each dimension's rows.
void Printer::printInitializer(const Variable& variable) {
    add(" = ");
    const unsigned size = sizeOf(variable.type);
    const size_t count = variable.initializer.size() / size;
    std::vector<uint64_t> rows; // elements per brace, outermost first
    uint64_t row = variable.vector;
    if (variable.vector > 1)
        rows.push_back(row);
    for (size_t i = variable.dimensions.size(); i-- > 0;)
        rows.insert(rows.begin(), row *= std::max<uint64_t>(variable.dimensions[i], 1));
    size_t element = 0;
    const auto open = [&] {
        add(element ? ", " : "");
        for (const uint64_t length : rows)
            add(element % length == 0 ? "{" : "");
    };
    const auto close = [&] {
        ++element;
        for (const uint64_t length : rows)
            add(element % length == 0 || element == count ? "}" : "");
    };
    if (count == 0)
        add(rows.empty() ? "0" : "{}");
    auto relocation = variable.relocations.begin();
    while (element < count) {
        const size_t offset = element * size;
        while (relocation != variable.relocations.end() && relocation->offset < offset)
            ++relocation;
        if (relocation == variable.relocations.end() || relocation->offset != offset) {
            open();
            printElement(variable, offset);
            close();
        } else if (relocation->mask == 0 && relocation->size == size) {
            open();
            printRelocation(*relocation);
            close();
        } else {
            // Byte selectors: the masked one, or all bytes of the address.
            for (unsigned byte = 0; byte < 8; ++byte) {
                if (relocation->mask && !(relocation->mask >> byte & 1))
                    continue;
                open();
                add("0xFF", std::string(2 * byte, '0'), "(");
                printRelocation(*relocation);
                add(")");
                close();
            }
        }
    }
}

void Printer::printParameters(const std::vector<Variable>& parameters, bool prototype) {
    add("(");
    for (size_t i = 0; i < parameters.size(); ++i) {
        add(i ? ", " : "");
        if (prototype && parameters[i].name.empty()) {
            printType(parameters[i]);
            add(" _");
        } else {
            printVariable(parameters[i]);
        }
    }
    add(")");
}

void Printer::printTriple(const char* directive, const uint32_t (&values)[3]) {
    if (values[0] | values[1] | values[2])
        add(directive, " ", values[0], ", ", values[1], ", ", values[2], "\n");
}

void Printer::printAttributes(const Function& function) {
    const auto number = [&](const char* directive, uint32_t value) {
        if (value)
            add(directive, " ", value, "\n");
    };
    if (function.noreturn)
        add(".noreturn\n");
    printTriple(".maxntid", function.maxThreads);
    printTriple(".reqntid", function.requiredThreads);
    printTriple(".reqnctapercluster", function.requiredCluster);
    number(".minnctapersm", function.minBlocks);
    number(".maxnctapersm", function.maxBlocks);
    number(".maxnreg", function.maxRegisters);
    number(".maxclusterrank", function.maxClusterRank);
    if (function.explicitCluster)
        add(".explicitcluster\n");
}

std::string Printer::unique(std::string name) {
    const auto take = [&](const std::string& candidate) {
        return moduleNames_.count(candidate) == 0 && taken_.insert(candidate).second;
    };
    if (take(name))
        return name;
    uint32_t& last = suffixes_[name];
    for (;;) {
        std::string candidate = name + "$" + std::to_string(++last);
        if (take(candidate))
            return candidate;
    }
}

// The tree has no scopes, so names of registers and labels must be unique within the function.
void Printer::nameLocals(const Function& function) {
    taken_.clear();
    inHeader_.assign(function.registers.size(), false);
    for (const auto* list : {&function.parameterRegisters, &function.resultRegisters})
        for (const uint32_t index : *list)
            if (index != ~0u)
                inHeader_[index] = true;
    registers_.clear();
    labels_.clear();
    suffixes_.clear();
    for (const auto* list : {&function.variables, &function.parameters, &function.results})
        for (const Variable& variable : *list)
            if (variable.space != Space::kReg)
                taken_.emplace(variable.name);
    for (const Prototype& prototype : function.prototypes)
        taken_.emplace(prototype.name);
    for (const BranchTargets& targets : function.branchTargets)
        taken_.emplace(targets.name);
    for (const CallTargets& targets : function.callTargets)
        taken_.emplace(targets.name);
    for (size_t i = 0; i < function.registers.size(); ++i) {
        const Register& reg = function.registers[i];
        std::string name(reg.name);
        if (reg.number != ~0u)
            name += std::to_string(reg.number);
        if (inHeader_[i])
            taken_.insert(name);
        registers_.push_back(inHeader_[i] ? name : unique(std::move(name)));
    }
    for (const std::string_view label : function.labels)
        labels_.push_back(unique(std::string(label)));
}

void Printer::printDeclarations(const Function& function) {
    constexpr uint32_t kPerLine = 8;
    uint32_t onLine = 0;
    const Register* last = nullptr;
    for (uint32_t i = 0; i < function.registers.size(); ++i) {
        if (inHeader_[i])
            continue;
        const Register& reg = function.registers[i];
        if (last && last->type == reg.type && last->vector == reg.vector && onLine < kPerLine) {
            add(", ", registers_[i]);
        } else {
            add(last ? ";\n" : "", "\t.reg ");
            if (reg.vector > 1)
                add(".v", reg.vector, " ");
            add(".", nameOf(reg.type), " ", registers_[i]);
            onLine = 0;
        }
        ++onLine;
        last = &reg;
    }
    add(last ? ";\n" : "");
    for (const Variable& variable : function.variables) {
        add("\t");
        printVariable(variable);
        add(";\n");
    }
    for (const Prototype& prototype : function.prototypes) {
        add("\t", prototype.name, ": .callprototype ");
        if (!prototype.results.empty())
            printParameters(prototype.results, true);
        add(" _ ");
        printParameters(prototype.parameters, true);
        add(";\n");
    }
    for (const CallTargets& targets : function.callTargets) {
        add("\t", targets.name, ": .calltargets ");
        for (size_t i = 0; i < targets.functions.size(); ++i)
            add(i ? ", " : "", targets.functions[i]);
        add(";\n");
    }
    for (const BranchTargets& targets : function.branchTargets) {
        add("\t", targets.name, ": .branchtargets ");
        for (size_t i = 0; i < targets.labels.size(); ++i)
            add(i ? ", " : "", labels_[targets.labels[i]]);
        add(";\n");
    }
}

void Printer::printHeader(const Function& function) {
    add(linkageName(function.linkage), function.isEntry ? ".entry " : ".func ");
    if (!function.results.empty()) {
        printParameters(function.results, false);
        add(" ");
    }
    add(function.name);
    printParameters(function.parameters, false);
    add("\n");
    printAttributes(function);
}

void Printer::printFunction(const Function& function) {
    function_ = &function;
    source_ = SourcePosition();
    printHeader(function);
    if (!function.hasBody) {
        add(";\n\n");
        return;
    }
    nameLocals(function);
    add("{\n");
    printDeclarations(function);
    for (const Statement& statement : function.body) {
        if (statement.kind == StatementKind::kLabel)
            add(labels_[statement.label], ":\n");
        else
            printInstruction(statement.instruction);
    }
    add("}\n\n");
}

void Printer::printInstruction(const Instruction& instruction) {
    const SourcePosition& source = instruction.source;
    if (source.file != source_.file || source.line != source_.line ||
        source.column != source_.column)
        add("\t.loc ", source.file, " ", source.line, " ", source.column, "\n");
    source_ = source;
    add("\t");
    if (instruction.guard >= 0)
        add(instruction.guardNegated ? "@!" : "@", registers_[instruction.guard], " ");
    add(instruction.opcode);
    for (const std::string_view modifier : instruction.modifiers)
        add(".", modifier);
    if (instruction.facts->syntax == Syntax::kCall)
        printCall(instruction);
    else if (!instruction.operands.empty())
        printList(instruction.operands, " ", "");
    add(";\n");
}

void Printer::printCall(const Instruction& call) {
    if (!call.results.empty())
        printList(call.results, " (", "),");
    add(" ");
    printOperand(call.target);
    printList(call.arguments, ", (", ")");
    if (!call.prototype.empty())
        add(", ", call.prototype);
}

void Printer::printList(const std::vector<Operand>& operands, const char* open, const char* close) {
    add(open);
    for (size_t i = 0; i < operands.size(); ++i) {
        add(i ? ", " : "");
        printOperand(operands[i]);
    }
    add(close);
}

void Printer::printOffset(int64_t offset) {
    if (offset)
        add("+", offset);
}

void Printer::printRegister(const Operand& operand) {
    if (operand.negated)
        add(function_->registers[operand.index].type == Type::kPred ? "!" : "-");
    add(registers_[operand.index], componentName(operand.component));
    if (operand.component == Operand::kPicked)
        add(".", operand.name);
}

// sym, sym+N, sym[%r+N]
void Printer::printSymbol(const Operand& operand) {
    add(operand.name);
    if (operand.scale == 0)
        return printOffset(operand.offset);
    add("[", registers_[operand.index]);
    printOffset(operand.offset / static_cast<int64_t>(operand.scale));
    add("]");
}

void Printer::printAddress(const Operand& operand) {
    if (operand.scale)
        return printSymbol(operand);
    add("[");
    if (operand.index != ~0u) {
        printRegister(operand);
        printOffset(operand.offset);
    } else if (!operand.name.empty()) {
        printSymbol(operand);
    } else {
        add(operand.offset);
    }
    add("]");
}

void Printer::printOperand(const Operand& operand) {
    switch (operand.kind) {
    case OperandKind::kRegister:
        printRegister(operand);
        return printOffset(operand.offset); // inside the brackets of a texture
    case OperandKind::kInteger:
        return add(operand.integer);
    case OperandKind::kFloat:
        add(operand.floatBits == 32 ? "0f" : "0d");
        return printHex(static_cast<uint64_t>(operand.integer), operand.floatBits / 4);
    case OperandKind::kSymbol:
        return printSymbol(operand);
    case OperandKind::kSpecial:
        return add(operand.name);
    case OperandKind::kAddress:
        return printAddress(operand);
    case OperandKind::kVector:
        return printList(operand.elements, "{", "}");
    case OperandKind::kLabel:
        return add(labels_[operand.index]);
    case OperandKind::kSink:
        return add("_");
    case OperandKind::kPair:
        printOperand(operand.elements[0]);
        add("|");
        return printOperand(operand.elements[1]);
    case OperandKind::kTexture:
        return printList(operand.elements, "[", "]");
    }
}

} // namespace

std::string print(const Module& module) {
    return Printer(module).run();
}

} // namespace sunstone::ptx
