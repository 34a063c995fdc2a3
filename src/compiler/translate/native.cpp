// SPDX-License-Identifier: Apache-2.0
// FunctionTranslator for GPUs: instructions that stay PTX. Those without an exact LLVM equivalent
// (approximations, flushing, directed rounding, saturation, textures, warp functions, atomics, and
// all opcodes unknown to the translator) become inline assembly, so results are the hardware's own
// and any PTX that the driver accepts is accepted.
//
// Registers are passed as bits of their declared width, which PTX accepts for operands of every
// type. Addresses are passed as generic ones, which for global memory are the same. Instructions
// that the optimiser can improve become LLVM IR: integers, plain float arithmetic, comparisons,
// loads and stores, control flow.
#include "compiler/gpu/header.h"
#include "compiler/translate/function_translator.h"
#include "ptx/special_registers.h"

#include <llvm/IR/InlineAsm.h>

#include <cinttypes>
#include <set>

namespace sunstone::compiler {

namespace {

using Names = std::set<std::string_view>;

// All modifiers except types and these two have meanings that LLVM's operations lack.
bool isPlain(const ptx::Instruction& instruction) {
    ptx::Type type;
    for (std::string_view modifier : instruction.modifiers)
        if (modifier != "rn" && !ptx::typeFromName(modifier, type))
            return false;
    for (ptx::Type each : instruction.types)
        if (each != ptx::Type::kF32 && each != ptx::Type::kF64)
            return false;
    return true;
}

bool hasFloat(const ptx::Instruction& instruction) {
    for (ptx::Type type : instruction.types)
        if (ptx::isFloat(type))
            return true;
    return false;
}

// Text and operands of one piece of inline assembly. Results come first.
struct Assembly {
    std::string text;
    std::string outputs, inputs; // constraints
    std::vector<llvm::Type*> types;
    std::vector<ptx::Operand> targets;
    std::vector<Value*> values;

    std::string place() const { return "$" + std::to_string(types.size() + values.size()); }
    static void add(std::string& constraints, const char* constraint) {
        constraints += (constraints.empty() ? "" : ",") + std::string(constraint);
    }
};

const char* constraintOf(unsigned bits) {
    return bits == 1 ? "b" : bits <= 16 ? "h" : bits == 32 ? "r" : bits == 64 ? "l" : "q";
}

// Components of a video instruction's operand, as ptx::Operand numbers them.
constexpr int kFirstByte = 4;

std::string selectorOf(const ptx::Operand& operand) {
    static const char* const kNames[] = {".b0", ".b1", ".b2", ".b3", ".h0", ".h1"};
    if (operand.component == ptx::Operand::kPicked)
        return "." + std::string(operand.name);
    return operand.component < kFirstByte ? "" : kNames[operand.component - kFirstByte];
}

std::string literalOf(const ptx::Operand& operand) {
    if (operand.kind == ptx::OperandKind::kInteger)
        return std::to_string(operand.integer);
    char text[32];
    if (operand.floatBits == 64)
        std::snprintf(text, sizeof text, "0d%016" PRIx64, uint64_t(operand.integer));
    else
        std::snprintf(text, sizeof text, "0f%08" PRIx32, uint32_t(operand.integer));
    return text;
}

} // namespace

// Returns true if it translated the instruction.
bool FunctionTranslator::translateNative(const ptx::Instruction& instruction) {
    static const auto& kKept =
        *new Names{"rcp", "sqrt", "rsqrt", "sin", "cos", "lg2", "ex2", "tanh", "testp", "lop3",
                   "prmt", "bfe", "bfi", "bfind", "shf", "fns", "bmsk", "szext", "dp4a", "dp2a",
                   "sad", "mul24", "mad24", "brev", "tex", "tld4", "txq", "suq", "copysign", "isspacep",
                   // video instructions
                   "vadd", "vsub", "vabsdiff", "vmin", "vmax", "vshl", "vshr", "vset", "vmad",
                   "vadd2", "vsub2", "vavrg2", "vabsdiff2", "vmin2", "vmax2", "vset2", "vadd4",
                   "vsub4", "vavrg4", "vabsdiff4", "vmin4", "vmax4", "vset4"};
    static const auto& kKeptIfFloat = *new Names{"add", "sub", "mul", "mad", "fma", "div",  "neg",
                                                 "abs", "min", "max", "cvt", "set", "setp", "slct"};
    static const auto& kMatrices = *new Names{"mma", "wmma", "ldmatrix", "stmatrix", "movmatrix"};
    static const auto& kStack = *new Names{"stacksave", "stackrestore"};
    static const auto& kWarp = *new Names{"vote", "shfl", "match", "redux", "activemask", "elect"};
    static const auto& kEffects = *new Names{
        "suld",    "sust",    "sured",    "atom",           "red",          "membar",
        "fence",   "cp",      "mbarrier", "griddepcontrol", "nanosleep",    "createpolicy",
        "discard", "pmevent", "prefetch", "prefetchu",      "applypriority"};
    static const auto& kWithoutResult = *new Names{
        "sust", "sured",   "red",     "membar",    "fence",         "nanosleep",     "prefetch",
        "cp",   "discard", "pmevent", "prefetchu", "applypriority", "griddepcontrol"};
    const std::string_view op = instruction.opcode;
    if (instruction.isForeign) {
        emitNative(instruction, Result::kPerhaps, true, true, true);
        return true;
    }
    if (kKept.count(op)) {
        emitNative(instruction, Result::kFirst, false, false, false);
        return true;
    }
    // LLVM's back end emits no loads and stores that order others, no atomic ones of 128 bits, and
    // no asynchronous ones.
    const bool isStore = op == "st";
    if ((isStore || op == "ld") &&
        (instruction.has("acquire") || instruction.has("release") || instruction.has("mmio") ||
         instruction.has("async") || instruction.has("bulk") ||
         (instruction.has("relaxed") && lastType(instruction) == ptx::Type::kB128))) {
        emitNative(instruction, isStore ? Result::kNone : Result::kFirst, true, false, true);
        return true;
    }
    if (instruction.has("f32x2")) {
        emitNative(instruction, Result::kFirst, false, false, false);
        return true;
    }
    if (kKeptIfFloat.count(op)) {
        const bool arithmetic = op != "min" && op != "max" && op != "cvt" && op != "set";
        if (!hasFloat(instruction) || (arithmetic && isPlain(instruction)))
            return false;
        if ((op == "setp" || op == "slct") && !instruction.has("ftz") &&
            (lastType(instruction) == ptx::Type::kF32 || lastType(instruction) == ptx::Type::kF64))
            return false;
        emitNative(instruction, Result::kFirst, false, false, false);
        return true;
    }
    const bool warpBarrier = (op == "bar" || op == "barrier") && instruction.has("warp");
    if (kWarp.count(op) || warpBarrier) {
        emitNative(instruction, warpBarrier ? Result::kNone : Result::kFirst, true, true,
                   warpBarrier);
        return true;
    }
    if (kMatrices.count(op) || kStack.count(op)) {
        emitNative(instruction, op == "stackrestore" ? Result::kNone : Result::kFirst, true, true,
                   true);
        return true;
    }
    if (op == "alloca") {
        allocateStackNative(instruction);
        return true;
    }
    if (kEffects.count(op) || handlers().find(op) == handlers().end()) {
        const bool known = kEffects.count(op);
        const Result result = !known                     ? Result::kPerhaps
                              : kWithoutResult.count(op) ? Result::kNone
                                                         : Result::kFirst;
        emitNative(instruction, result, true, !known, true);
        return true;
    }
    return false;
}

void FunctionTranslator::emitNative(const ptx::Instruction& instruction, Result result,
                                    bool effects, bool convergent, bool memory) {
    if (mayNeedHeader(instruction))
        unit_.needHeader(module_, instruction);
    const bool isLegacy =
        (instruction.opcode == "vote" || instruction.opcode == "shfl") && !instruction.has("sync");
    Assembly code;
    std::vector<Value*> before; // old values of results that may also be read
    const auto bitsOfRegister = [&](const ptx::Operand& operand) {
        const unsigned bits = bitsOf(source_.registers[operand.index].type);
        return bits == 8 ? 16u : bits;
    };
    const auto input = [&](Value* value) {
        const unsigned bits = unsigned(value->getType()->getIntegerBitWidth());
        code.text += code.place();
        Assembly::add(code.inputs, constraintOf(bits));
        code.values.push_back(value);
    };
    // Visits operands in the order of the text; `target`: the instruction writes it.
    const auto emit = [&](const auto& self, const ptx::Operand& operand, bool target) -> void {
        const auto list = [&](const std::vector<ptx::Operand>& all, const char* open,
                              const char* between, const char* close) {
            code.text += open;
            for (size_t i = 0; i < all.size(); ++i) {
                code.text += i ? between : "";
                self(self, all[i], target);
            }
            code.text += close;
        };
        switch (operand.kind) {
        case ptx::OperandKind::kRegister: {
            if (operand.negated || operand.component >= kFirstByte) {
                // -%r1.b0 and the like: a prefix or suffix of the whole register.
                ptx::Operand whole = operand;
                whole.negated = false;
                whole.component = operand.component >= kFirstByte ? -1 : operand.component;
                const bool predicate = bitsOfRegister(operand) == 1;
                code.text += !operand.negated ? "" : predicate ? "!" : "-";
                self(self, whole, target);
                code.text += selectorOf(operand);
                return;
            }
            const std::vector<ptx::Operand> parts = elements(operand);
            if (parts.size() > 1)
                return list(parts, "{", ", ", "}");
            const unsigned bits = bitsOfRegister(operand);
            const auto value = [&] {
                return coerce(readInt(operand, bitsOf(source_.registers[operand.index].type)),
                              intType(bits));
            };
            if (!target)
                return input(value());
            if (result == Result::kPerhaps)
                before.push_back(value());
            code.text += code.place();
            Assembly::add(code.outputs, (std::string("=") + constraintOf(bits)).c_str());
            code.types.push_back(intType(bits));
            code.targets.push_back(operand);
            return;
        }
        case ptx::OperandKind::kInteger:
        case ptx::OperandKind::kFloat:
            code.text += literalOf(operand);
            return;
        case ptx::OperandKind::kSpecial: {
            if (instruction.isForeign) {
                code.text += operand.name;
                return;
            }
            Value* value = special(operand.name, operand.location);
            return input(coerce(value, intType(unsigned(value->getType()->getIntegerBitWidth()))));
        }
        case ptx::OperandKind::kSymbol:
            return input(readInt(operand, 64));
        case ptx::OperandKind::kAddress: {
            code.text += "[";
            // 32-bit addresses are in spaces of their own: shared memory, matrix memory.
            const bool isWord = operand.name.empty() && operand.index != ~0u &&
                                bitsOfRegister(operand) == 32 && !instruction.has("local");
            if (isWord) {
                ptx::Operand word = operand;
                word.kind = ptx::OperandKind::kRegister;
                input(builder_.CreateAdd(readInt(word, 32),
                                         builder_.getInt32(uint32_t(operand.offset))));
            } else {
                Value* pointer = place(operand).pointer;
                input(builder_.CreatePtrToInt(pointer, builder_.getInt64Ty()));
            }
            code.text += "]";
            return;
        }
        case ptx::OperandKind::kVector:
            return list(operand.elements, "{", ", ", "}");
        case ptx::OperandKind::kPair:
            return list(operand.elements, "", "|", "");
        case ptx::OperandKind::kTexture: {
            const ptx::Operand& handle = operand.elements.at(0);
            if (handle.kind == ptx::OperandKind::kSymbol)
                reject(instruction, ErrorCode::kNotSupported,
                       "texture references are not available on GPUs; use texture objects");
            return list(operand.elements, "[", ", ", "]");
        }
        case ptx::OperandKind::kSink:
            code.text += "_";
            return;
        default:
            reject(instruction, ErrorCode::kNotSupported, "operand of an unexpected kind");
        }
    };
    for (size_t i = 0; i < instruction.operands.size(); ++i) {
        code.text += i ? ", " : " ";
        const bool isAddress = instruction.operands[i].kind == ptx::OperandKind::kAddress ||
                               instruction.operands[i].kind == ptx::OperandKind::kTexture;
        emit(emit, instruction.operands[i], result != Result::kNone && i == 0 && !isAddress);
    }
    code.text = instruction.fullOpcode() + code.text;
    // PTX 6.4 removed the forms without .sync on GPUs that have .sync: they apply to the active
    // threads.
    if (isLegacy)
        code.text = message("{ .reg .b32 all; activemask.b32 all; ", instruction.opcode, ".sync",
                            code.text.substr(instruction.opcode.size()), ", all; }");
    else
        code.text += ";";
    // The text names results and other operands; the old values of result registers follow.
    for (size_t i = 0; i < before.size(); ++i) {
        Assembly::add(code.inputs, std::to_string(i).c_str());
        code.values.push_back(before[i]);
    }
    std::string constraints = code.outputs;
    if (!code.inputs.empty())
        Assembly::add(constraints, code.inputs.c_str());
    if (memory)
        Assembly::add(constraints, "~{memory}");
    llvm::Type* resultType = code.types.empty() ? builder_.getVoidTy()
                             : code.types.size() == 1
                                 ? code.types[0]
                                 : llvm::StructType::get(unit_.context(), code.types);
    std::vector<llvm::Type*> inputs;
    for (Value* value : code.values)
        inputs.push_back(value->getType());
    auto* type = llvm::FunctionType::get(resultType, inputs, false);
    llvm::CallInst* call = builder_.CreateCall(
        type, llvm::InlineAsm::get(type, code.text, constraints, effects), code.values);
    call->addFnAttr(llvm::Attribute::NoUnwind);
    if (convergent)
        call->addFnAttr(llvm::Attribute::Convergent);
    if (!effects)
        call->setMemoryEffects(llvm::MemoryEffects::none());
    for (size_t i = 0; i < code.targets.size(); ++i)
        write(code.targets[i], code.targets.size() == 1
                                   ? static_cast<Value*>(call)
                                   : builder_.CreateExtractValue(call, unsigned(i)));
}

// The memory is freed when the function returns, so the function must not be inlined. Addresses are
// generic ones.
void FunctionTranslator::allocateStackNative(const ptx::Instruction& instruction) {
    const int64_t alignment = checkStack(instruction);
    if (!source_.isEntry)
        function_.addFnAttr(llvm::Attribute::NoInline);
    const std::string text =
        message("{ .reg .b64 at; alloca.u64 at, $1, ", alignment, "; cvta.local.u64 $0, at; }");
    llvm::Type* wide = intType(64);
    auto* type = llvm::FunctionType::get(wide, {wide}, false);
    write(instruction.operands[0],
          builder_.CreateCall(type, llvm::InlineAsm::get(type, text, "=l,l,~{memory}", true),
                              {readInt(instruction.operands[1], 64)}));
}

// Reads %laneid, %clock64 and other registers at the time of execution.
Value* FunctionTranslator::readSpecialNative(std::string_view name) {
    const ptx::SpecialRegister* known = ptx::findSpecialRegister(name.substr(0, name.find('.')));
    const bool isPredicate = known && known->type == ptx::Type::kPred;
    const unsigned bits = isPredicate ? 1 : known && ptx::sizeOf(known->type) == 8 ? 64 : 32;
    const std::string text = message(isPredicate  ? "mov.pred $0, "
                                     : bits == 64 ? "mov.u64 $0, "
                                                  : "mov.u32 $0, ",
                                     name, ";");
    auto* signature = llvm::FunctionType::get(intType(bits), false);
    const std::string constraint = std::string("=") + constraintOf(bits);
    return builder_.CreateCall(signature, llvm::InlineAsm::get(signature, text, constraint, true),
                               {});
}

} // namespace sunstone::compiler
