// SPDX-License-Identifier: Apache-2.0
// inspect: facts about a module from its tree alone. One walk over the functions collects their
// calls; programs then follow the direct calls. If an operand's value is not visible in the tree
// (it is computed or comes through memory), inspect compiles the module as far as constant
// propagation and discards the code (checkByCompiling).
#include "compiler/optix7/inspect.h"

#include "compiler/optix7/check_module.h"
#include "compiler/optix7/intrinsics.h"
#include "compiler/optix7/payload.h"
#include "compiler/optix7/program_kind.h"
#include "compiler/optix7/tree_constants.h"

#include "base/error.h"
#include "ptx/opcodes/opcode.h"

#include <algorithm>
#include <array>
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
    uint32_t firstBranch = ~0u; // line of the first branch
    std::set<std::string_view> callees;
};

template <class... Parts>
[[noreturn]] void reject(ErrorCode code, const ptx::Instruction& instruction,
                         const Parts&... parts) {
    fail(code, "line ", instruction.location.line, ": ", parts...);
}

uint32_t estimateStack(const ptx::Function& function, bool traces) {
    uint64_t bytes = 32; // return address and saved registers
    for (const ptx::Variable& variable : function.variables)
        if (variable.space == ptx::Space::kLocal)
            bytes += variable.size;
    // Values that live across a trace or call are spilled: a share of the registers is a fair
    // guess.
    const bool calls = std::any_of(function.body.begin(), function.body.end(), [](const auto& s) {
        return s.kind == ptx::StatementKind::kInstruction &&
               s.instruction.facts->syntax == ptx::Syntax::kCall;
    });
    if (traces)
        bytes += std::min<uint64_t>(function.registers.size(), 64) * 4;
    else if (calls)
        bytes += std::min<uint64_t>(function.registers.size(), 16) * 4;
    return uint32_t((bytes + 15) / 16 * 16);
}

// Whether a function has the means to take a lock or to wait for a flag.
bool mayWait(const ptx::Function& function) {
    return std::ranges::any_of(function.body, [](const ptx::Statement& statement) {
        const ptx::Instruction& instruction = statement.instruction;
        if (statement.kind != ptx::StatementKind::kInstruction)
            return false;
        if (instruction.opcode == "atom")
            return instruction.has("cas") || instruction.has("exch");
        return instruction.opcode == "ld" &&
               (instruction.has("volatile") || instruction.has("relaxed") ||
                instruction.has("acquire"));
    });
}

class Inspection {
public:
    Inspection(const ptx::Module& module, const PipelineRules& rules,
               const ModuleRules& moduleRules)
        : module_(module), rules_(rules), moduleRules_(moduleRules) {}

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
            ModuleSummary::Program& program = summary.programs.emplace_back();
            program.name = function.name;
            program.kind = kind;
            program.parameterWords = parameterWords(function.parameters);
            program.statements = uint32_t(function.body.size());
            std::set<std::string_view> visited;
            typeCall_ = nullptr;
            typeMask_ = 0;
            follow(function.name, program, visited);
            program.payloadTypes = supportedTypes(typeMask_, moduleRules_);
            program.estimatedStack = estimateStack(function, program.traces);
            visited.clear();
            if (!moduleRules_.payloadTypes.empty())
                checkTypedAccess(function.name, program, visited);
        }
        inspectLaunchParams(summary);
        for (const ptx::Variable& variable : module_.variables)
            if (variable.space == ptx::Space::kConst && variable.linkage != ptx::Linkage::kExtern &&
                variable.name != rules_.launchParams)
                summary.constantBytes += variable.size;
        summary.selfContained = isSelfContained(module_, rules_);
        summary.mayRecurse = !summary.selfContained || callsByAddress_ || hasRecursion();
        summary.mayWaitForOthers = std::ranges::any_of(module_.functions, mayWait);
        summary.remarks = remarkOnThrows();
        if (mustCompile_)
            checkByCompiling(module_, rules_, moduleRules_, summary);
        return summary;
    }

private:
    // The manual requires the flag. Sunstone's user exceptions also work without it; other
    // libraries' may not.
    std::string remarkOnThrows() const {
        if (rules_.exceptionFlags & devlib::kFlagUser)
            return {};
        for (const ptx::Function& function : module_.functions)
            for (const ptx::Statement& statement : function.body)
                if (statement.instruction.target.name.starts_with("_optix_throw_exception_"))
                    return message("warning: line ", statement.instruction.location.line, ": \"",
                                   function.name,
                                   "\" calls optixThrowException, but the exception flags lack "
                                   "USER\n");
        return {};
    }

    bool hasRecursion() const {
        std::unordered_map<std::string_view, bool> isDone; // false: in progress
        return std::ranges::any_of(
            calls_, [&](const auto& entry) { return leadsToItself(entry.first, isDone); });
    }
    // Whether a path of calls from the function meets a function twice.
    bool leadsToItself(std::string_view name,
                       std::unordered_map<std::string_view, bool>& isDone) const {
        const auto found = calls_.find(name);
        if (found == calls_.end())
            return false;
        const auto [state, isNew] = isDone.emplace(name, false);
        if (!isNew)
            return !state->second;
        for (const std::string_view callee : found->second.callees)
            if (leadsToItself(callee, isDone))
                return true;
        isDone[name] = true;
        return false;
    }

    void collect(const ptx::Function& function) {
        FunctionCalls& calls = calls_[function.name];
        std::optional<TreeConstants> constants;
        for (const ptx::Statement& statement : function.body) {
            if (statement.kind == ptx::StatementKind::kInstruction &&
                statement.instruction.facts->isJump() && !leadsToNext(function, statement))
                calls.firstBranch =
                    std::min(calls.firstBranch, statement.instruction.location.line);
            if (statement.kind != ptx::StatementKind::kInstruction ||
                statement.instruction.facts->syntax != ptx::Syntax::kCall)
                continue;
            if (statement.instruction.target.kind != ptx::OperandKind::kSymbol) {
                callsByAddress_ = true;
                continue;
            }
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

    // nvcc -G emits jumps to the beginning of inlined code.
    static bool leadsToNext(const ptx::Function& function, const ptx::Statement& jump) {
        const ptx::Statement* next = &jump + 1;
        const auto& operands = jump.instruction.operands;
        return jump.instruction.guard < 0 && operands.size() == 1 &&
               operands[0].kind == ptx::OperandKind::kLabel &&
               next != function.body.data() + function.body.size() &&
               next->kind == ptx::StatementKind::kLabel && next->label == operands[0].index;
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
                        const TreeConstants& constants) {
        std::optional<uint32_t> slot;
        switch (opOf(intrinsic)) {
        case IntrinsicOp::kSetPayload:
        case IntrinsicOp::kGetPayload:
            slot = intrinsic.number >= 0 ? std::optional(uint32_t(intrinsic.number))
                                         : constants.valueOf(instruction.arguments[0]);
            mustCompile_ |= !slot;
            if (slot && *slot >= rules_.optix7.numPayloadValues &&
                moduleRules_.payloadTypes.empty())
                reject(ErrorCode::kInvalidPayloadAccess, instruction, "_optix_", intrinsic.name,
                       ": payload slot ", *slot, " of ", rules_.optix7.numPayloadValues,
                       " (numPayloadValues of the pipeline compile options)");
            if (slot)
                slots_[&instruction] = *slot + 1;
            break;
        case IntrinsicOp::kTrace: {
            std::optional<uint32_t> count = uint32_t(std::max(0, intrinsic.number)), mask = 0;
            if (intrinsic.number < 0) {
                count = constants.valueOf(instruction.arguments[16]);
                mask = constants.valueOf(instruction.arguments[0]);
            }
            mustCompile_ |= !count || !mask;
            if (!count || !mask)
                break;
            const TracePayload payload = payloadOfTrace(*mask, *count, moduleRules_, rules_);
            if (payload.code != ErrorCode::kOk)
                reject(payload.code, instruction, "_optix_", intrinsic.name, ": ", payload.problem);
            break;
        }
        case IntrinsicOp::kSetPayloadTypes:
            slot = constants.valueOf(instruction.arguments[0]);
            if (!slot)
                reject(ErrorCode::kInvalidFunctionArguments, instruction, "_optix_", intrinsic.name,
                       ": the payload type mask is not a constant");
            slots_[&instruction] = *slot;
            break;
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
    unsigned attributes() const { return std::max(2u, rules_.optix7.numAttributeValues); }

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

    // Adds the facts of all functions in the direct call graph of `name` to the program.
    void follow(std::string_view name, ModuleSummary::Program& program,
                std::set<std::string_view>& visited) {
        const auto found = calls_.find(name);
        if (found == calls_.end() || !visited.insert(name).second)
            return;
        for (const IntrinsicCall& call : found->second.intrinsics) {
            if (!call.intrinsic->isAvailable)
                reject(ErrorCode::kNotSupported, *call.instruction, "\"",
                       call.instruction->target.name, "\" is not available");
            if (!(call.intrinsic->kinds & kindBit(program.kind)))
                reject(ErrorCode::kInvalidFunctionUse, *call.instruction, "\"_optix_",
                       call.intrinsic->name, "\" cannot be used in a ", prefixOf(program.kind),
                       " program (\"", program.name, "\")");
            program.traces |= opOf(*call.intrinsic) == IntrinsicOp::kTrace;
            program.callsContinuation |=
                opOf(*call.intrinsic) == IntrinsicOp::kCallable && call.intrinsic->number == 1;
            const auto slot = slots_.find(call.instruction);
            if (opOf(*call.intrinsic) == IntrinsicOp::kSetPayloadTypes)
                takePayloadTypes(found->second, call, slot->second);
            else if (slot != slots_.end())
                program.payloadWords = std::max(program.payloadWords, slot->second);
        }
        for (std::string_view callee : found->second.callees)
            follow(callee, program, visited);
    }

    // "Once per program, at the top": before anything that may branch.
    void takePayloadTypes(const FunctionCalls& function, const IntrinsicCall& call, uint32_t mask) {
        const ptx::Instruction& instruction = *call.instruction;
        if (typeCall_)
            reject(ErrorCode::kInvalidFunctionUse, instruction,
                   "\"_optix_set_payload_types\" is used twice in a program; first at line ",
                   typeCall_->location.line);
        if (instruction.guard >= 0 || instruction.location.line > function.firstBranch)
            reject(ErrorCode::kInvalidFunctionUse, instruction,
                   "\"_optix_set_payload_types\" must stand at the top of the program, outside "
                   "of conditions");
        const std::string problem = unknownTypes(mask, moduleRules_);
        if (!problem.empty())
            reject(ErrorCode::kPayloadTypeId, instruction, problem);
        typeCall_ = &instruction;
        typeMask_ = mask;
    }

    // Checks the program's payload accesses for each type that it supports.
    void checkTypedAccess(std::string_view name, const ModuleSummary::Program& program,
                          std::set<std::string_view>& visited) const {
        const auto found = calls_.find(name);
        if (found == calls_.end() || !visited.insert(name).second)
            return;
        for (const IntrinsicCall& call : found->second.intrinsics) {
            const bool reads = opOf(*call.intrinsic) == IntrinsicOp::kGetPayload;
            const auto slot = slots_.find(call.instruction);
            if ((!reads && opOf(*call.intrinsic) != IntrinsicOp::kSetPayload) ||
                slot == slots_.end())
                continue;
            const PayloadAccess access = reads ? PayloadAccess::kRead : PayloadAccess::kWrite;
            for (size_t i = 0; i < moduleRules_.payloadTypes.size(); ++i) {
                if (!(program.payloadTypes >> i & 1))
                    continue;
                const std::string problem = payloadProblem(program.kind, slot->second - 1, access,
                                                           &moduleRules_.payloadTypes[i], 0);
                if (!problem.empty())
                    reject(ErrorCode::kInvalidPayloadAccess, *call.instruction, "_optix_",
                           call.intrinsic->name, ": ", problem, "; payload type ", i,
                           ", program \"", program.name, "\"");
            }
        }
        for (std::string_view callee : found->second.callees)
            checkTypedAccess(callee, program, visited);
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
        if (variable->size == 0) // .extern params[]
            fail(ErrorCode::kInvalidLaunchParameter, "line ", variable->location.line,
                 ": the launch parameter variable \"", variable->name, "\" has no size");
        summary.launchParamsSize = variable->size;
    }

    const ptx::Module& module_;
    const PipelineRules& rules_;
    const ModuleRules& moduleRules_;
    bool mustCompile_ = false;                   // operands were found that may not be constants
    const ptx::Instruction* typeCall_ = nullptr; // set_payload_types of the current program
    uint32_t typeMask_ = 0;
    std::unordered_map<std::string_view, FunctionCalls> calls_;
    bool callsByAddress_ = false;
    std::unordered_map<const ptx::Instruction*, uint32_t> slots_; // payload words a call needs, or
                                                                  // its type mask
};

// The payload types in the calls of a module, each with the number of words that its traces pass.
class NamedTypes {
public:
    void add(const ptx::Function& function) {
        const TreeConstants constants(function);
        for (const ptx::Statement& statement : function.body) {
            const ptx::Instruction& instruction = statement.instruction;
            if (statement.kind != ptx::StatementKind::kInstruction ||
                instruction.facts->syntax != ptx::Syntax::kCall ||
                instruction.target.kind != ptx::OperandKind::kSymbol)
                continue;
            const Intrinsic* intrinsic = findIntrinsic(instruction.target.name);
            if (!intrinsic || instruction.arguments.size() != intrinsic->operands.size())
                continue;
            if (opOf(*intrinsic) == IntrinsicOp::kSetPayloadTypes)
                name(constants.valueOf(instruction.arguments[0]), std::nullopt);
            else if (opOf(*intrinsic) == IntrinsicOp::kTrace && intrinsic->number < 0)
                name(constants.valueOf(instruction.arguments[0]),
                     constants.valueOf(instruction.arguments[16]));
        }
    }
    std::vector<PayloadType> widest() const {
        std::vector<PayloadType> types;
        for (unsigned i = 0; i < count_; ++i) {
            constexpr uint32_t kEverybody = 0x3FF; // reads and writes
            const bool isOnly = count_ == 1 && !words_[0];
            const std::optional<uint32_t> words = isOnly ? unnamedWords_ : words_[i];
            types.push_back(
                {std::vector<uint32_t>(std::min<uint32_t>(words.value_or(devlib::kMaxPayloadWords),
                                                          devlib::kMaxPayloadWords),
                                       kEverybody)});
        }
        return types;
    }

private:
    void name(std::optional<uint32_t> mask, std::optional<uint32_t> words) {
        if (!mask)
            return;
        if (*mask == 0 && words)
            unnamedWords_ = words;
        for (unsigned i = 0; i < kMaxPayloadTypes; ++i) {
            if (!(*mask >> i & 1))
                continue;
            count_ = std::max(count_, i + 1);
            if (words && !words_[i])
                words_[i] = words;
        }
    }

    unsigned count_ = 0;
    std::array<std::optional<uint32_t>, kMaxPayloadTypes> words_;
    std::optional<uint32_t> unnamedWords_; // of traces that leave the type to the module
};

} // namespace

std::vector<PayloadType> widestPayloadTypes(const ptx::Module& module) {
    NamedTypes types;
    for (const ptx::Function& function : module.functions)
        types.add(function);
    return types.widest();
}

ModuleSummary inspect(const ptx::Module& module, const PipelineRules& rules,
                      const ModuleRules& moduleRules) {
    return Inspection(module, rules, moduleRules).run();
}

unsigned parameterWords(const std::vector<ptx::Variable>& parameters) {
    uint64_t words = 0;
    for (const ptx::Variable& parameter : parameters)
        words += (parameter.size + 3) / 4;
    return unsigned(words);
}

} // namespace sunstone::compiler
