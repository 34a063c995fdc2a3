// SPDX-License-Identifier: Apache-2.0
// inspect: what can be said of a module from its tree alone. One walk over the functions collects
// their calls; programs then follow the direct calls. Operands whose value is not plain to see
// here (they come through memory, or are computed) are checked when the program is compiled.
#include "compiler/compiler.h"

#include "compiler/intrinsics.h"

#include "base/error.h"

#include <algorithm>
#include <optional>
#include <set>
#include <unordered_map>

namespace sunstone::compiler {

namespace {

using ErrorCode = sunstone::Code;

struct IntrinsicCall {
    const Intrinsic* intrinsic = nullptr;
    const ptx::Instruction* instruction = nullptr;
};

struct FunctionCalls {
    std::vector<IntrinsicCall> intrinsics;
    std::set<std::string_view> callees;
};

template <class... Parts>
[[noreturn]] void reject(ErrorCode code, const ptx::Instruction& instruction,
                         const Parts&... parts) {
    fail(code, "line ", instruction.location.line, ": ", parts...);
}

// Registers that hold one known number all the time.
class Constants {
public:
    explicit Constants(const ptx::Function& function)
        : definitions_(function.registers.size(), 0), values_(function.registers.size()) {
        for (const ptx::Statement& statement : function.body) {
            if (statement.kind != ptx::StatementKind::kInstruction)
                continue;
            const ptx::Instruction& instruction = statement.instruction;
            if (!instruction.operands.empty())
                define(instruction.operands[0], &instruction);
            for (const ptx::Operand& result : instruction.results)
                define(result, nullptr);
        }
    }

    std::optional<uint32_t> valueOf(const ptx::Operand& operand) const {
        if (operand.kind == ptx::OperandKind::kInteger)
            return uint32_t(operand.integer);
        if (operand.kind != ptx::OperandKind::kRegister || operand.index >= values_.size() ||
            definitions_[operand.index] != 1)
            return std::nullopt;
        return values_[operand.index];
    }

private:
    void define(const ptx::Operand& target, const ptx::Instruction* instruction) {
        for (const ptx::Operand& element : target.elements)
            define(element, nullptr);
        if (target.kind != ptx::OperandKind::kRegister || target.index >= values_.size())
            return;
        ++definitions_[target.index];
        if (instruction && instruction->opcode == "mov" && instruction->guard < 0 &&
            instruction->operands.size() == 2 &&
            instruction->operands[1].kind == ptx::OperandKind::kInteger)
            values_[target.index] = uint32_t(instruction->operands[1].integer);
    }

    std::vector<unsigned> definitions_;
    std::vector<std::optional<uint32_t>> values_;
};

class Inspection {
public:
    Inspection(const ptx::Module& module, const PipelineRules& rules)
        : module_(module), rules_(rules) {}

    ModuleSummary run() {
        for (const ptx::Function& function : module_.functions)
            if (function.hasBody)
                collect(function);
        ModuleSummary summary;
        for (const ptx::Function& function : module_.functions) {
            const ProgramKind kind = programKind(function.name);
            if (!function.hasBody || kind == ProgramKind::kNone)
                continue;
            checkShape(function, kind);
            summary.programs.push_back({std::string(function.name), kind});
            std::set<std::string_view> visited;
            follow(function.name, summary.programs.back(), visited);
        }
        inspectLaunchParams(summary);
        return summary;
    }

private:
    void collect(const ptx::Function& function) {
        FunctionCalls& calls = calls_[function.name];
        std::optional<Constants> constants;
        for (const ptx::Statement& statement : function.body) {
            if (statement.kind != ptx::StatementKind::kInstruction ||
                statement.instruction.opcode != "call" ||
                statement.instruction.target.kind != ptx::OperandKind::kSymbol)
                continue;
            const ptx::Instruction& instruction = statement.instruction;
            const std::string_view name = instruction.target.name;
            if (!isIntrinsicName(name)) {
                calls.callees.insert(name);
                continue;
            }
            const Intrinsic* intrinsic = findIntrinsic(name);
            if (!intrinsic)
                reject(ErrorCode::kInvalidPtx, instruction, "unknown OptiX function \"", name,
                       "\"");
            checkOperands(*intrinsic, instruction);
            if (!intrinsic->anySignature) {
                checkWidths(function, *intrinsic, instruction, instruction.results,
                            intrinsic->results);
                checkWidths(function, *intrinsic, instruction, instruction.arguments,
                            intrinsic->operands);
            }
            if (!constants)
                constants.emplace(function);
            checkConstants(*intrinsic, instruction, *constants);
            calls.intrinsics.push_back({intrinsic, &instruction});
        }
    }

    void checkOperands(const Intrinsic& intrinsic, const ptx::Instruction& instruction) const {
        if (intrinsic.anySignature)
            return;
        if (instruction.arguments.size() != intrinsic.operands.size() ||
            instruction.results.size() != intrinsic.results.size())
            reject(ErrorCode::kInvalidPtx, instruction, "\"_optix_", intrinsic.name,
                   "\" is called with ", instruction.arguments.size(), " arguments and ",
                   instruction.results.size(), " results; it has ", intrinsic.operands.size(),
                   " and ", intrinsic.results.size());
    }

    // Registers must be as wide as the letters of the signature say.
    template <class Operands>
    static void checkWidths(const ptx::Function& function, const Intrinsic& intrinsic,
                            const ptx::Instruction& instruction, const Operands& operands,
                            const std::string& letters) {
        for (size_t i = 0; i < letters.size(); ++i) {
            const ptx::Operand& operand = operands[i];
            if (operand.kind != ptx::OperandKind::kRegister ||
                operand.index >= function.registers.size())
                continue;
            const unsigned bytes = ptx::sizeOf(function.registers[operand.index].type);
            const unsigned wanted = letters[i] == 'l' ? 8 : 4;
            if (bytes != wanted)
                reject(ErrorCode::kInvalidPtx, instruction, "\"_optix_", intrinsic.name,
                       "\" takes a register of ", wanted * 8, " bits here, not of ", bytes * 8);
        }
    }

    void checkConstants(const Intrinsic& intrinsic, const ptx::Instruction& instruction,
                        const Constants& constants) {
        std::optional<uint32_t> slot;
        switch (intrinsic.op) {
        case IntrinsicOp::kSetPayload:
        case IntrinsicOp::kGetPayload:
            slot = intrinsic.number >= 0 ? std::optional(uint32_t(intrinsic.number))
                                         : constants.valueOf(instruction.arguments[0]);
            if (slot && *slot >= rules_.numPayloadValues)
                reject(ErrorCode::kInvalidPayloadAccess, instruction, "_optix_", intrinsic.name,
                       ": payload slot ", *slot, " of ", rules_.numPayloadValues,
                       " (numPayloadValues of the pipeline compile options)");
            if (slot)
                slots_[&instruction] = *slot + 1;
            break;
        case IntrinsicOp::kTrace: {
            std::optional<uint32_t> count = uint32_t(std::max(0, intrinsic.number));
            if (intrinsic.number < 0)
                count = constants.valueOf(instruction.arguments[16]);
            if (count && *count > rules_.numPayloadValues)
                reject(ErrorCode::kInvalidPayloadAccess, instruction, "_optix_", intrinsic.name,
                       ": ", *count, " payload values of ", rules_.numPayloadValues,
                       " (numPayloadValues of the pipeline compile options)");
            break;
        }
        case IntrinsicOp::kReport:
            if (unsigned(intrinsic.number) > attributes())
                reject(ErrorCode::kInvalidAttributeAccess, instruction, "_optix_", intrinsic.name,
                       ": ", intrinsic.number, " attributes of ", attributes(),
                       " (numAttributeValues of the pipeline compile options)");
            break;
        default:
            checkAttribute(intrinsic, instruction);
        }
    }

    void checkAttribute(const Intrinsic& intrinsic, const ptx::Instruction& instruction) const {
        constexpr std::string_view kPrefix = "get_attribute_";
        if (!intrinsic.name.starts_with(kPrefix))
            return;
        const unsigned index = unsigned(intrinsic.name[kPrefix.size()] - '0');
        if (index >= attributes())
            reject(ErrorCode::kInvalidAttributeAccess, instruction, "_optix_", intrinsic.name,
                   ": attribute ", index, " of ", attributes(),
                   " (numAttributeValues of the pipeline compile options)");
    }
    unsigned attributes() const { return std::max(2u, rules_.numAttributeValues); }

    void checkShape(const ptx::Function& function, ProgramKind kind) const {
        const bool callable =
            kind == ProgramKind::kDirectCallable || kind == ProgramKind::kContinuationCallable;
        if (callable && function.isEntry)
            fail(ErrorCode::kInvalidPtx, "line ", function.location.line, ": callable \"",
                 function.name, "\" must be a .func, not an .entry");
        if (!callable && !function.isEntry)
            fail(ErrorCode::kInvalidPtx, "line ", function.location.line, ": program \"",
                 function.name, "\" must be an .entry");
        if (!callable && !function.parameters.empty())
            fail(ErrorCode::kInvalidPtx, "line ", function.location.line, ": program \"",
                 function.name, "\" has parameters; programs take none");
    }

    // Everything `name` reaches by direct calls counts as the program's own.
    void follow(std::string_view name, ModuleSummary::Program& program,
                std::set<std::string_view>& visited) {
        const auto found = calls_.find(name);
        if (found == calls_.end() || !visited.insert(name).second)
            return;
        for (const IntrinsicCall& call : found->second.intrinsics) {
            if (!(call.intrinsic->kinds & kindBit(program.kind)))
                reject(ErrorCode::kInvalidFunctionUse, *call.instruction, "\"_optix_",
                       call.intrinsic->name, "\" cannot be used in a ", prefixOf(program.kind),
                       " program (\"", program.name, "\")");
            program.traces |= call.intrinsic->op == IntrinsicOp::kTrace;
            program.callsContinuation |=
                call.intrinsic->op == IntrinsicOp::kCallable && call.intrinsic->number == 1;
            const auto slot = slots_.find(call.instruction);
            if (slot != slots_.end())
                program.payloadWords = std::max(program.payloadWords, slot->second);
        }
        for (std::string_view callee : found->second.callees)
            follow(callee, program, visited);
    }

    void inspectLaunchParams(ModuleSummary& summary) const {
        if (rules_.launchParams.empty())
            return;
        const ptx::Variable* variable = module_.findVariable(rules_.launchParams);
        if (!variable)
            return;
        if (variable->space != ptx::Space::kConst)
            fail(ErrorCode::kInvalidLaunchParameter, "line ", variable->location.line,
                 ": the launch parameter variable \"", variable->name, "\" is not .const");
        summary.launchParamsSize = variable->size;
    }

    const ptx::Module& module_;
    const PipelineRules& rules_;
    std::unordered_map<std::string_view, FunctionCalls> calls_;
    std::unordered_map<const ptx::Instruction*, uint32_t> slots_; // payload words a call needs
};

} // namespace

ModuleSummary inspect(const ptx::Module& module, const PipelineRules& rules) {
    return Inspection(module, rules).run();
}

} // namespace sunstone::compiler
