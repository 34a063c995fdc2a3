// SPDX-License-Identifier: Apache-2.0
// FunctionTranslator: textures and surfaces. A sampling instruction fills a block of operands in
// the frame and calls the sampler. A surface access asks for the texel's address, then loads or
// stores as usual. Handles are 64-bit values; a texture reference variable holds a handle.
#include "compiler/translate/function_translator.h"

#include "texture/device_functions.h"

namespace sunstone::compiler {

namespace {

struct GeometryName {
    std::string_view name;
    texture::Geometry geometry;
    unsigned coordinates; // without padding and layer
    bool layered;
};
constexpr GeometryName kGeometries[] = {
    {"1d", texture::k1D, 1, false},          {"2d", texture::k2D, 2, false},
    {"3d", texture::k3D, 3, false},          {"a1d", texture::k1DArray, 1, true},
    {"a2d", texture::k2DArray, 2, true},     {"cube", texture::kCube, 3, false},
    {"acube", texture::kCubeArray, 3, true},
};

const GeometryName* geometryOf(const ptx::Instruction& instruction) {
    for (const GeometryName& geometry : kGeometries)
        if (instruction.has(geometry.name))
            return &geometry;
    return nullptr;
}

unsigned vectorLength(const ptx::Instruction& instruction) {
    return instruction.has("v4") ? 4 : instruction.has("v2") ? 2 : 1;
}

struct QueryName {
    std::string_view name;
    texture::Query query;
};
constexpr QueryName kQueries[] = {
    {"width", texture::kQueryWidth},
    {"height", texture::kQueryHeight},
    {"depth", texture::kQueryDepth},
    {"array_size", texture::kQueryArraySize},
    {"num_mipmap_levels", texture::kQueryLevels},
    {"channel_data_type", texture::kQueryChannelType},
    {"channel_order", texture::kQueryChannelOrder},
    {"normalized_coords", texture::kQueryNormalized},
    {"num_samples", texture::kQuerySamples},
    {"filter_mode", texture::kQueryFilter},
    {"addr_mode_0", texture::kQueryAddress0},
    {"addr_mode_1", texture::kQueryAddress1},
    {"addr_mode_2", texture::kQueryAddress2},
};

} // namespace

// The handle in [handle, ...]: a register's value, or the value of a variable.
Value* FunctionTranslator::textureHandle(const ptx::Operand& operand) {
    if (operand.name.empty()) {
        ptx::Operand reg = operand;
        reg.kind = ptx::OperandKind::kRegister;
        if (operand.index == ~0u || operand.offset != 0)
            reject(*current_, ErrorCode::kInvalidPtx, "a texture or surface expected");
        return readInt(reg, 64);
    }
    return builder_.CreateAlignedLoad(builder_.getInt64Ty(), place(operand).pointer,
                                      llvm::Align(8));
}

FunctionTranslator::TextureOperand
FunctionTranslator::textureOperand(const ptx::Instruction& instruction, const ptx::Operand& operand,
                                   bool isFloat) {
    const GeometryName* geometry = geometryOf(instruction);
    if (!geometry)
        reject(instruction, ErrorCode::kNotSupported, "multisampled textures are not available");
    if (operand.kind != ptx::OperandKind::kTexture || operand.elements.size() < 2)
        reject(instruction, ErrorCode::kInvalidPtx, "[texture, coordinates] expected");
    if (operand.elements.size() > 2)
        reject(instruction, ErrorCode::kNotSupported, "samplers of their own are not available");
    TextureOperand result;
    result.form = geometry->geometry;
    result.handle = textureHandle(operand.elements[0]);
    const std::vector<ptx::Operand> coordinates = elements(operand.elements[1]);
    if (coordinates.size() < geometry->coordinates + geometry->layered)
        reject(instruction, ErrorCode::kInvalidPtx,
               message(coordinates.size(), " coordinates; needs ",
                       geometry->coordinates + geometry->layered));
    llvm::Type* type = isFloat ? builder_.getFloatTy() : static_cast<llvm::Type*>(intType(32));
    result.layer =
        geometry->layered ? readInt(coordinates[0], 32) : static_cast<Value*>(builder_.getInt32(0));
    for (unsigned i = 0; i < 3; ++i)
        result.position[i] = i < geometry->coordinates
                                 ? readAs(coordinates[i + geometry->layered], type)
                                 : llvm::Constant::getNullValue(type);
    return result;
}

// A block of the frame that all sampling instructions of the function share.
Value* FunctionTranslator::textureBlock() {
    if (!textureBlock_) {
        llvm::IRBuilder<> top(entry_, entry_->begin());
        llvm::AllocaInst* block =
            top.CreateAlloca(llvm::ArrayType::get(top.getInt8Ty(), sizeof(texture::SampleOperands) +
                                                                       4 * sizeof(uint32_t)),
                             nullptr, "texture");
        block->setAlignment(llvm::Align(16));
        textureBlock_ = block;
    }
    return textureBlock_;
}

void FunctionTranslator::storeOperand(size_t offset, Value* value) {
    builder_.CreateAlignedStore(value, offsetPointer(textureBlock(), int64_t(offset)),
                                llvm::Align(4));
}

// tex and tld4
void FunctionTranslator::sampleTexture(const ptx::Instruction& instruction) {
    using texture::SampleOperands;
    operandCount(instruction, 2, 4);
    if (instruction.types.size() != 2)
        rejectForm(instruction);
    const bool floatCoordinates = instruction.types[1] == ptx::Type::kF32;
    TextureOperand operand = textureOperand(instruction, instruction.operands[1], floatCoordinates);
    if (!floatCoordinates)
        operand.form |= texture::kIntegerCoordinates;
    for (unsigned i = 0; i < 3; ++i)
        storeOperand(offsetof(SampleOperands, position) + 4 * i, operand.position[i]);
    storeOperand(offsetof(SampleOperands, layer), operand.layer);

    size_t used = 2;
    if (instruction.opcode == "tld4") {
        const unsigned channel = instruction.has("r")   ? 0
                                 : instruction.has("g") ? 1
                                 : instruction.has("b") ? 2
                                                        : 3;
        operand.form |= texture::kGather | channel << texture::kGatherShift;
    } else if (instruction.has("level")) {
        operandCount(instruction, 3, 3);
        operand.form |= texture::kWithLevel;
        llvm::Type* type = instruction.types[1] == ptx::Type::kF32
                               ? builder_.getFloatTy()
                               : static_cast<llvm::Type*>(intType(32));
        Value* level = readAs(instruction.operands[used++], type);
        if (!level->getType()->isFloatTy())
            level = builder_.CreateSIToFP(level, builder_.getFloatTy());
        storeOperand(offsetof(SampleOperands, level), level);
    } else if (instruction.has("grad")) {
        operandCount(instruction, 4, 4);
        operand.form |= texture::kWithGradient;
        for (const size_t offset : {offsetof(SampleOperands, dx), offsetof(SampleOperands, dy)}) {
            const std::vector<ptx::Operand> parts = elements(instruction.operands[used++]);
            for (unsigned i = 0; i < 3; ++i)
                storeOperand(offset + 4 * i,
                             i < parts.size()
                                 ? readAs(parts[i], builder_.getFloatTy())
                                 : llvm::Constant::getNullValue(builder_.getFloatTy()));
        }
    }
    if (used != instruction.operands.size())
        reject(instruction, ErrorCode::kNotSupported,
               "texel offsets and depth comparison are not available");

    checkTexture(instruction.operands[1], operand.handle);
    Value* result = offsetPointer(textureBlock(), sizeof(SampleOperands));
    builder_.CreateCall(
        unit_.helper("sunstone_texture", builder_.getVoidTy(),
                     {intType(64), intType(32), builder_.getPtrTy(), builder_.getPtrTy()}, false),
        {operand.handle, builder_.getInt32(operand.form), textureBlock(), result});
    writeSample(instruction, result);
}

// For the memory checker: a texture of linear memory is checked by its first byte, because its
// range was checked when the object was made. Arrays live as long as the texture.
void FunctionTranslator::checkTexture(const ptx::Operand& operand, Value* handle) {
    if (!marksAccesses())
        return;
    Value* memory = builder_.CreateCall(
        unit_.helper("sunstone_texture_memory", builder_.getPtrTy(), {intType(64)}, false),
        {handle});
    llvm::BasicBlock* linear = llvm::BasicBlock::Create(unit_.context(), "", &function_);
    llvm::BasicBlock* join = llvm::BasicBlock::Create(unit_.context(), "", &function_);
    builder_.CreateCondBr(builder_.CreateIsNull(memory), join, linear);
    builder_.SetInsertPoint(linear);
    auto* byte = builder_.CreateAlignedLoad(intType(8), memory, llvm::Align(1), true);
    mark(*byte, operand, devlib::kAccessLoad, 0, 1);
    builder_.CreateBr(join);
    builder_.SetInsertPoint(join);
}

// The four words of a sample in the instruction's type.
void FunctionTranslator::writeSample(const ptx::Instruction& instruction, Value* result) {
    const ptx::Type type = instruction.types[0];
    const bool isHalf = type == ptx::Type::kF16 || type == ptx::Type::kF16x2;
    llvm::Type* wordType = isHalf || type == ptx::Type::kF32
                               ? builder_.getFloatTy()
                               : static_cast<llvm::Type*>(intType(32));
    std::vector<Value*> words;
    for (unsigned i = 0; i < 4; ++i) {
        Value* word =
            builder_.CreateAlignedLoad(wordType, offsetPointer(result, 4 * i), llvm::Align(4));
        if (isHalf)
            word = builder_.CreateFPTrunc(word, builder_.getHalfTy());
        words.push_back(word);
    }
    if (type == ptx::Type::kF16x2) {
        for (unsigned i = 0; i < 2; ++i) {
            Value* pair =
                llvm::PoisonValue::get(llvm::FixedVectorType::get(builder_.getHalfTy(), 2));
            pair = builder_.CreateInsertElement(pair, words[2 * i], uint64_t(0));
            words[i] = builder_.CreateInsertElement(pair, words[2 * i + 1], uint64_t(1));
        }
    }
    const ptx::Operand* target = &instruction.operands[0];
    if (target->kind == ptx::OperandKind::kPair) { // |p: whether the texels are resident
        write(target->elements[1], builder_.getTrue());
        target = &target->elements[0];
    }
    const std::vector<ptx::Operand> targets = elements(*target);
    if (targets.size() > 4 || (type == ptx::Type::kF16x2 && targets.size() != 2))
        rejectForm(instruction);
    for (size_t i = 0; i < targets.size(); ++i)
        write(targets[i], words[i]);
}

// txq and suq
void FunctionTranslator::queryTexture(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 3);
    const bool isTexture = instruction.opcode == "txq";
    Value* answer = nullptr;
    for (const QueryName& query : kQueries) {
        if (!instruction.has(query.name))
            continue;
        Value* handle = textureHandle(instruction.operands[1]);
        Value* which = builder_.getInt32(query.query);
        if (isTexture)
            answer = builder_.CreateCall(
                unit_.helper("sunstone_texture_query", intType(32),
                             {intType(64), intType(32), intType(32)}, false),
                {handle, which,
                 instruction.operands.size() == 3 ? readInt(instruction.operands[2], 32)
                                                  : static_cast<Value*>(builder_.getInt32(0))});
        else
            answer = builder_.CreateCall(unit_.helper("sunstone_surface_query", intType(32),
                                                      {intType(64), intType(32)}, false),
                                         {handle, which});
    }
    if (!answer)
        reject(instruction, ErrorCode::kNotSupported, "this query is not available");
    write(instruction.operands[0], answer);
}

// Calls `access` with the address of the texel if it exists; otherwise traps if the instruction
// says so, and the values of `access` are 0.
template <class Access>
std::vector<Value*> FunctionTranslator::atTexel(const ptx::Instruction& instruction,
                                                const ptx::Operand& operand, unsigned bytes,
                                                Access access) {
    TextureOperand at = textureOperand(instruction, operand, false);
    uint32_t form = at.form | bytes << texture::kBytesShift;
    const bool reduces = instruction.opcode == "sured";
    if (reduces && instruction.has("p")) // counts words of the access, for any texel size
        at.position[0] = builder_.CreateMul(at.position[0], builder_.getInt32(bytes));
    if (instruction.has("clamp"))
        form |= texture::kClamp;
    if (instruction.has("p") && !reduces)
        form |= texture::kFormatted;
    llvm::Type* word = intType(32);
    Value* place =
        builder_.CreateCall(unit_.helper("sunstone_surface", builder_.getPtrTy(),
                                         {intType(64), word, word, word, word, word}, false),
                            {at.handle, builder_.getInt32(form), at.position[0], at.position[1],
                             at.position[2], at.layer});
    llvm::BasicBlock* inside = llvm::BasicBlock::Create(unit_.context(), "", &function_);
    llvm::BasicBlock* outside = llvm::BasicBlock::Create(unit_.context(), "", &function_);
    llvm::BasicBlock* join = llvm::BasicBlock::Create(unit_.context(), "", &function_);
    builder_.CreateCondBr(builder_.CreateIsNotNull(place), inside, outside);
    builder_.SetInsertPoint(outside);
    const bool traps = instruction.has("trap");
    if (traps)
        emitTrap();
    else
        builder_.CreateBr(join);
    builder_.SetInsertPoint(inside);
    const std::vector<Value*> values = access(at.handle, place);
    inside = builder_.GetInsertBlock();
    builder_.CreateBr(join);
    builder_.SetInsertPoint(join);
    if (traps)
        return values;
    std::vector<Value*> merged;
    for (Value* value : values) {
        llvm::PHINode* phi = builder_.CreatePHI(value->getType(), 2);
        phi->addIncoming(value, inside);
        phi->addIncoming(llvm::Constant::getNullValue(value->getType()), outside);
        merged.push_back(phi);
    }
    return merged;
}

void FunctionTranslator::loadSurface(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 2);
    const unsigned count = vectorLength(instruction);
    const unsigned bytes = ptx::sizeOf(lastType(instruction));
    const std::vector<ptx::Operand> targets = elements(instruction.operands[0]);
    if (targets.size() != count)
        rejectForm(instruction);
    const bool formatted = instruction.has("p");
    const auto access = [&](Value* handle, Value* texel) {
        if (formatted) {
            builder_.CreateCall(
                unit_.helper("sunstone_surface_load", builder_.getVoidTy(),
                             {intType(64), builder_.getPtrTy(), builder_.getPtrTy()}, false),
                {handle, texel, textureBlock()});
            texel = textureBlock();
        }
        std::vector<Value*> values;
        for (unsigned i = 0; i < count; ++i)
            values.push_back(builder_.CreateAlignedLoad(
                intType(bytes * 8), offsetPointer(texel, int64_t(i) * bytes), llvm::Align(1)));
        return values;
    };
    if (formatted && bytes != 4)
        rejectForm(instruction);
    const std::vector<Value*> values =
        atTexel(instruction, instruction.operands[1], bytes * count, access);
    for (unsigned i = 0; i < count; ++i)
        write(targets[i], values[i]);
}

void FunctionTranslator::storeSurface(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 2);
    const unsigned count = vectorLength(instruction);
    const unsigned bytes = ptx::sizeOf(lastType(instruction));
    const std::vector<ptx::Operand> sources = elements(instruction.operands[1]);
    const bool formatted = instruction.has("p");
    if (sources.size() != count || (formatted && bytes != 4))
        rejectForm(instruction);
    std::vector<Value*> values;
    for (const ptx::Operand& source : sources)
        values.push_back(readInt(source, bytes * 8));
    const auto access = [&](Value* handle, Value* texel) {
        Value* to = formatted ? textureBlock() : texel;
        for (unsigned i = 0; i < count; ++i)
            builder_.CreateAlignedStore(values[i], offsetPointer(to, int64_t(i) * bytes),
                                        llvm::Align(1));
        if (formatted)
            builder_.CreateCall(
                unit_.helper("sunstone_surface_store", builder_.getVoidTy(),
                             {intType(64), builder_.getPtrTy(), builder_.getPtrTy(), intType(32)},
                             false),
                {handle, texel, to, builder_.getInt32(count)});
        return std::vector<Value*>();
    };
    atTexel(instruction, instruction.operands[0], bytes * count, access);
}

void FunctionTranslator::reduceSurface(const ptx::Instruction& instruction) {
    using Op = llvm::AtomicRMWInst::BinOp;
    operandCount(instruction, 2, 2);
    const ptx::Type type = lastType(instruction);
    const unsigned bytes = ptx::sizeOf(type);
    if (instruction.has("p"))
        return reduceFormatted(instruction, bytes);
    const bool isSigned = ptx::isSigned(type);
    const Op op = instruction.has("add")   ? Op::Add
                  : instruction.has("and") ? Op::And
                  : instruction.has("or")  ? Op::Or
                  : instruction.has("min") ? (isSigned ? Op::Min : Op::UMin)
                                           : (isSigned ? Op::Max : Op::UMax);
    Value* value = readInt(instruction.operands[1], bytes * 8);
    const auto access = [&](Value*, Value* texel) {
        // An unaligned address belongs to the texel that contains it, because atomics need
        // alignment.
        Value* aligned = builder_.CreateIntToPtr(
            builder_.CreateAnd(builder_.CreatePtrToInt(texel, intType(64)), ~uint64_t(bytes - 1)),
            builder_.getPtrTy());
        builder_.CreateAtomicRMW(op, aligned, value, llvm::MaybeAlign(bytes),
                                 llvm::AtomicOrdering::Monotonic);
        return std::vector<Value*>();
    };
    atTexel(instruction, instruction.operands[0], bytes, access);
}

// sured.p: the texel's format determines signedness.
void FunctionTranslator::reduceFormatted(const ptx::Instruction& instruction, unsigned bytes) {
    using texture::Reduction;
    const Reduction reduction = instruction.has("add")   ? Reduction::kAdd
                                : instruction.has("and") ? Reduction::kAnd
                                : instruction.has("or")  ? Reduction::kOr
                                : instruction.has("min") ? Reduction::kMinimum
                                                         : Reduction::kMaximum;
    Value* value = builder_.CreateZExt(readInt(instruction.operands[1], bytes * 8), intType(64));
    const auto access = [&](Value* handle, Value* texel) {
        llvm::Type* word = intType(32);
        builder_.CreateCall(
            unit_.helper("sunstone_surface_reduce", builder_.getVoidTy(),
                         {intType(64), builder_.getPtrTy(), word, word, intType(64)}, false),
            {handle, texel, builder_.getInt32(uint32_t(reduction)), builder_.getInt32(bytes),
             value});
        return std::vector<Value*>();
    };
    atTexel(instruction, instruction.operands[0], bytes, access);
}

} // namespace sunstone::compiler
