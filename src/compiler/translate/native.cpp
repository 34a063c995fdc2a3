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
#include "compiler/translate/native.h"

#include "compiler/gpu/header.h"
#include "compiler/translate/function_translator.h"
#include "ptx/opcodes/special_registers.h"

#include <llvm/IR/InlineAsm.h>

#include <algorithm>
#include <bit>
#include <cinttypes>

namespace sunstone::compiler {

namespace {

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
    return instruction.has("f32x2");
}

bool isPlainComparison(const ptx::Instruction& instruction) {
    const ptx::Type last = instruction.types.empty() ? ptx::Type::kNone : instruction.types.back();
    return !instruction.has("ftz") && (last == ptx::Type::kF32 || last == ptx::Type::kF64);
}

// LLVM's back end cannot emit loads and stores that order others, 128-bit atomic ones, or
// asynchronous ones.
bool ordersOthers(const ptx::Instruction& instruction) {
    return instruction.has("acquire") || instruction.has("release") || instruction.has("mmio") ||
           instruction.has("async") || instruction.has("bulk") ||
           (instruction.has("relaxed") && !instruction.types.empty() &&
            instruction.types.back() == ptx::Type::kB128);
}

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

std::optional<NativeForm> nativeForm(const ptx::Instruction& instruction) {
    const ptx::Opcode& facts = *instruction.facts;
    if (instruction.isForeign || facts.operation == ptx::Operation::kUnknown)
        return NativeForm{NativeForm::kPerhaps, true, true, true};
    const auto result = facts.hasResult ? NativeForm::kFirst : NativeForm::kNone;
    const auto valueIf = [](bool condition) {
        return condition ? std::optional<NativeForm>(NativeForm()) : std::nullopt;
    };
    switch (facts.native) {
    case ptx::Native::kNever:
        return std::nullopt;
    case ptx::Native::kValue:
        return NativeForm();
    case ptx::Native::kInexact:
        return valueIf(hasFloat(instruction) && !isPlain(instruction));
    case ptx::Native::kFloats:
        return valueIf(hasFloat(instruction));
    case ptx::Native::kCompares:
        return valueIf(hasFloat(instruction) && !isPlainComparison(instruction));
    case ptx::Native::kOrders:
        if (!ordersOthers(instruction))
            return std::nullopt;
        [[fallthrough]];
    case ptx::Native::kEffects:
    case ptx::Native::kStack:
        return NativeForm{result, true, false, true};
    case ptx::Native::kWarp:
        return NativeForm{result, true, true, false};
    case ptx::Native::kWarpMemory:
        return NativeForm{result, true, true, true};
    case ptx::Native::kWarpSync:
        if (!instruction.has("warp"))
            return std::nullopt;
        return NativeForm{NativeForm::kNone, true, true, true};
    }
    return std::nullopt;
}

// Text and operands of one piece of inline assembly. Results come first.
struct FunctionTranslator::Assembly {
    const ptx::Instruction& instruction;
    NativeForm form;
    std::string text;
    std::string outputs, inputs; // constraints
    std::vector<llvm::Type*> types;
    std::vector<ptx::Operand> targets;
    std::vector<Value*> values;
    std::vector<Value*> before; // old values of results that may also be read

    static void add(std::string& constraints, const std::string& constraint) {
        constraints += (constraints.empty() ? "" : ",") + constraint;
    }
    void addPlace() { text += "$" + std::to_string(types.size() + values.size()); }
    void addInput(Value* value) {
        addPlace();
        add(inputs, constraintOf(unsigned(value->getType()->getIntegerBitWidth())));
        values.push_back(value);
    }
    void addTarget(const ptx::Operand& operand, llvm::Type* type) {
        addPlace();
        add(outputs, std::string("=") + constraintOf(unsigned(type->getIntegerBitWidth())));
        types.push_back(type);
        targets.push_back(operand);
    }
};

// Writes a 1D lookup as a 2D lookup in one row: at the row's centre, with a zero gradient across.
// 1D arrays have no lookups by integers.
ptx::Instruction FunctionTranslator::rowLookup(const ptx::Instruction& line) {
    ptx::Instruction row = line;
    std::replace(row.modifiers.begin(), row.modifiers.end(), std::string_view("1d"),
                 std::string_view("2d"));
    const auto widen = [](ptx::Operand& coordinates, const ptx::Operand& second) {
        if (coordinates.kind != ptx::OperandKind::kVector) {
            const ptx::Operand first = coordinates;
            coordinates.kind = ptx::OperandKind::kVector;
            coordinates.elements = {first};
        }
        coordinates.elements.push_back(second);
    };
    ptx::Operand zero;
    zero.kind = ptx::OperandKind::kInteger;
    if (row.types.at(1) == ptx::Type::kF32) {
        zero.kind = ptx::OperandKind::kFloat;
        zero.floatBits = 32;
    }
    ptx::Operand centre = zero;
    if (centre.kind == ptx::OperandKind::kFloat)
        centre.integer = std::bit_cast<int32_t>(0.5f);
    widen(row.operands.at(1).elements.at(1), centre);
    if (row.has("grad"))
        for (size_t i = 2; i < row.operands.size(); ++i)
            widen(row.operands[i], zero);
    return row;
}

// Returns true if it translated the instruction.
bool FunctionTranslator::translateNative(const ptx::Instruction& instruction) {
    const std::optional<NativeForm> form = nativeForm(instruction);
    if (!form)
        return false;
    if (!instruction.isForeign && instruction.facts->native == ptx::Native::kStack)
        allocateStackNative(instruction);
    else if (instruction.opcode == "tex" && instruction.has("1d") &&
             isReference(instruction.operands.at(1).elements.at(0)))
        emitNative(rowLookup(instruction), *form);
    else
        emitNative(instruction, *form);
    return true;
}

void FunctionTranslator::emitNative(const ptx::Instruction& instruction, const NativeForm& form) {
    if (mayNeedHeader(instruction))
        unit_.needHeader(module_, instruction);
    Assembly code{instruction, form};
    for (size_t i = 0; i < instruction.operands.size(); ++i) {
        const ptx::Operand& operand = instruction.operands[i];
        code.text += i ? ", " : " ";
        const bool isAddress = operand.kind == ptx::OperandKind::kAddress ||
                               operand.kind == ptx::OperandKind::kTexture;
        nativeOperand(code, operand, form.result != NativeForm::kNone && i == 0 && !isAddress);
    }
    // PTX 6.4 removed the forms without .sync on GPUs that have .sync: they apply to the active
    // threads.
    const ptx::Operation operation = instruction.facts->operation;
    const bool isLegacy =
        (operation == ptx::Operation::kVote || operation == ptx::Operation::kShuffle) &&
        !instruction.has("sync");
    code.text = instruction.fullOpcode() + code.text;
    if (isLegacy)
        code.text = message("{ .reg .b32 all; activemask.b32 all; ", instruction.opcode, ".sync",
                            code.text.substr(instruction.opcode.size()), ", all; }");
    else
        code.text += ";";
    // The text names results and other operands; the old values of result registers follow.
    for (size_t i = 0; i < code.before.size(); ++i) {
        Assembly::add(code.inputs, std::to_string(i));
        code.values.push_back(code.before[i]);
    }
    llvm::CallInst* call = callAssembly(code);
    for (size_t i = 0; i < code.targets.size(); ++i)
        write(code.targets[i], code.targets.size() == 1
                                   ? static_cast<Value*>(call)
                                   : builder_.CreateExtractValue(call, unsigned(i)));
}

llvm::CallInst* FunctionTranslator::callAssembly(const Assembly& code) {
    std::string constraints = code.outputs;
    if (!code.inputs.empty())
        Assembly::add(constraints, code.inputs);
    if (code.form.memory)
        Assembly::add(constraints, "~{memory}");
    llvm::Type* result = code.types.empty() ? builder_.getVoidTy()
                         : code.types.size() == 1
                             ? code.types[0]
                             : llvm::StructType::get(unit_.context(), code.types);
    std::vector<llvm::Type*> inputs;
    for (Value* value : code.values)
        inputs.push_back(value->getType());
    auto* type = llvm::FunctionType::get(result, inputs, false);
    llvm::CallInst* call = builder_.CreateCall(
        type, llvm::InlineAsm::get(type, code.text, constraints, code.form.effects), code.values);
    call->addFnAttr(llvm::Attribute::NoUnwind);
    if (code.form.convergent) {
        call->addFnAttr(llvm::Attribute::Convergent);
        call->addFnAttr(llvm::Attribute::NoMerge); // LLVM hoists convergent calls of two branches
    }
    if (!code.form.effects)
        call->setMemoryEffects(llvm::MemoryEffects::none());
    return call;
}

// Adds operands in the order of the text. isTarget: the instruction writes the operand.
void FunctionTranslator::nativeOperand(Assembly& code, const ptx::Operand& operand, bool isTarget) {
    const ptx::Instruction& instruction = code.instruction;
    switch (operand.kind) {
    case ptx::OperandKind::kRegister:
        return nativeRegister(code, operand, isTarget);
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
        return code.addInput(
            coerce(value, intType(unsigned(value->getType()->getIntegerBitWidth()))));
    }
    case ptx::OperandKind::kSymbol:
        return code.addInput(isReference(operand) ? referenceHandle(operand)
                                                  : readInt(operand, 64));
    case ptx::OperandKind::kAddress:
        return nativeAddress(code, operand);
    case ptx::OperandKind::kVector:
        return nativeList(code, operand.elements, isTarget, "{", ", ", "}");
    case ptx::OperandKind::kPair:
        return nativeList(code, operand.elements, isTarget, "", "|", "");
    case ptx::OperandKind::kTexture:
        return nativeList(code, operand.elements, isTarget, "[", ", ", "]");
    case ptx::OperandKind::kSink:
        code.text += "_";
        return;
    default:
        reject(instruction, ErrorCode::kNotSupported, "operand of an unexpected kind");
    }
}

void FunctionTranslator::nativeList(Assembly& code, const std::vector<ptx::Operand>& operands,
                                    bool isTarget, const char* open, const char* between,
                                    const char* close) {
    code.text += open;
    for (size_t i = 0; i < operands.size(); ++i) {
        code.text += i ? between : "";
        nativeOperand(code, operands[i], isTarget);
    }
    code.text += close;
}

unsigned FunctionTranslator::nativeBits(const ptx::Operand& operand) const {
    const unsigned bits = bitsOf(source_.registers[operand.index].type);
    return bits == 8 ? 16u : bits;
}

void FunctionTranslator::nativeRegister(Assembly& code, const ptx::Operand& operand,
                                        bool isTarget) {
    const unsigned bits = nativeBits(operand);
    if (operand.negated || operand.component >= kFirstByte) {
        // -%r1.b0 and the like: a prefix or suffix of the whole register.
        ptx::Operand whole = operand;
        whole.negated = false;
        whole.component = operand.component >= kFirstByte ? -1 : operand.component;
        code.text += !operand.negated ? "" : bits == 1 ? "!" : "-";
        nativeOperand(code, whole, isTarget);
        code.text += selectorOf(operand);
        return;
    }
    const std::vector<ptx::Operand> parts = elements(operand);
    if (parts.size() > 1)
        return nativeList(code, parts, isTarget, "{", ", ", "}");
    const auto value = [&] {
        return coerce(readInt(operand, bitsOf(source_.registers[operand.index].type)),
                      intType(bits));
    };
    if (!isTarget)
        return code.addInput(value());
    if (code.form.result == NativeForm::kPerhaps)
        code.before.push_back(value());
    code.addTarget(operand, intType(bits));
}

void FunctionTranslator::nativeAddress(Assembly& code, const ptx::Operand& operand) {
    code.text += "[";
    if (isReference(operand)) {
        code.addInput(referenceHandle(operand));
        code.text += "]";
        return;
    }
    // 32-bit addresses are in spaces of their own: shared memory, matrix memory.
    const bool isWord = operand.name.empty() && operand.index != ~0u && nativeBits(operand) == 32 &&
                        !code.instruction.has("local");
    if (isWord) {
        ptx::Operand word = operand;
        word.kind = ptx::OperandKind::kRegister;
        code.addInput(
            builder_.CreateAdd(readInt(word, 32), builder_.getInt32(uint32_t(operand.offset))));
    } else {
        code.addInput(builder_.CreatePtrToInt(place(operand).pointer, builder_.getInt64Ty()));
    }
    code.text += "]";
}

// Whether the operand names a .texref or .surfref.
bool FunctionTranslator::isReference(const ptx::Operand& operand) const {
    const ptx::Variable* variable =
        operand.name.empty() ? nullptr : unit_.findVariable(module_, operand.name);
    return variable && variable->type >= ptx::Type::kTexref;
}

// The texture object that stands for a reference. Drivers bind references of modules; here only a
// flavor whose variables have values of their own gives them objects.
Value* FunctionTranslator::referenceHandle(const ptx::Operand& operand) {
    const ptx::Variable* variable = unit_.findVariable(module_, operand.name);
    if (unit_.flavor().variableIntrinsic(module_, *variable).empty())
        reject(*current_, ErrorCode::kNotSupported,
               "texture references are not available on GPUs; use texture objects");
    return textureHandle(operand);
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
