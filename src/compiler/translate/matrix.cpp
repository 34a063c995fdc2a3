// SPDX-License-Identifier: Apache-2.0
// FunctionTranslator: matrices spread over the lanes of a warp (mma, wmma, ldmatrix, stmatrix,
// movmatrix). See matrix.h. Source: PTX ISA manual, "Warp Level Matrix Instructions".
#include "compiler/runtime/matrix.h"
#include "compiler/translate/function_translator.h"

#include <charconv>
#include <cstring>
#include <optional>

namespace sunstone::compiler {

namespace {

using Words = std::vector<std::string_view>;

// Modifiers from left to right.
class ModifierReader {
public:
    explicit ModifierReader(const Words& words) : words_(words) {}
    bool atEnd() const { return next_ == words_.size(); }
    std::string_view peek() const { return atEnd() ? std::string_view() : words_[next_]; }
    bool take(std::string_view word) {
        const bool is = peek() == word;
        next_ += is;
        return is;
    }
    bool takeAll(std::initializer_list<std::string_view> words) {
        for (const std::string_view word : words)
            if (!take(word))
                return false;
        return true;
    }
    // m16n8k8
    bool takeShape(MatrixOperation& operation) {
        const std::string_view text = peek();
        unsigned numbers[3] = {};
        const char* at = text.data();
        const char* end = at + text.size();
        for (unsigned i = 0; i < 3; ++i) {
            if (at == end || *at != "mnk"[i])
                return false;
            const auto read = std::from_chars(at + 1, end, numbers[i]);
            if (read.ec != std::errc() || numbers[i] == 0 || numbers[i] > 256)
                return false;
            at = read.ptr;
        }
        if (at != end || numbers[0] > 32 || numbers[1] > 32)
            return false;
        ++next_;
        operation.m = uint8_t(numbers[0]);
        operation.n = uint8_t(numbers[1]);
        operation.k = uint16_t(numbers[2]);
        return true;
    }
    // row or col; `isColumn` says which.
    bool takeLayout(bool& isColumn) {
        isColumn = peek() == "col";
        return take("row") || take("col");
    }
    bool takeType(MatrixType& type) {
        static constexpr struct {
            std::string_view name;
            MatrixType type;
        } kNames[] = {
            {"f16", MatrixType::kF16},   {"bf16", MatrixType::kBF16}, {"tf32", MatrixType::kTF32},
            {"f32", MatrixType::kF32},   {"f64", MatrixType::kF64},   {"e4m3", MatrixType::kE4M3},
            {"e5m2", MatrixType::kE5M2}, {"s8", MatrixType::kS8},     {"u8", MatrixType::kU8},
            {"s4", MatrixType::kS4},     {"u4", MatrixType::kU4},     {"b1", MatrixType::kB1},
            {"s32", MatrixType::kS32}};
        for (const auto& entry : kNames)
            if (take(entry.name)) {
                type = entry.type;
                return true;
            }
        return false;
    }

private:
    const Words& words_;
    size_t next_ = 0;
};

struct Shape {
    unsigned m, n, k;
};

bool isOneOf(const MatrixOperation& o, std::initializer_list<Shape> shapes) {
    for (const Shape& shape : shapes)
        if (o.m == shape.m && o.n == shape.n && o.k == shape.k)
            return true;
    return false;
}

bool isHalfOrSingle(MatrixType type) {
    return type == MatrixType::kF16 || type == MatrixType::kF32;
}

// Whether PTX has such a product; k of bit matrices counts bits.
bool exists(const MatrixOperation& o) {
    using enum MatrixType;
    const bool wide = o.has(kMatrixWide);
    const auto are = [&](MatrixType a, MatrixType sum) {
        return o.a == a && o.b == a && o.c == sum && o.d == sum;
    };
    const bool isWideShape = isOneOf(o, {{16, 16, 16}, {8, 32, 16}, {32, 8, 16}});
    switch (o.a) {
    case kF16: {
        if (o.b != kF16 || !isHalfOrSingle(o.c) || !isHalfOrSingle(o.d))
            return false;
        if (wide)
            return isWideShape;
        if (isOneOf(o, {{8, 8, 4}}))
            return o.c == kF16 || o.d == kF32;
        return isOneOf(o, {{16, 8, 8}, {16, 8, 16}}) && o.c == o.d;
    }
    case kBF16:
        return are(kBF16, kF32) && (wide ? isWideShape : isOneOf(o, {{16, 8, 8}, {16, 8, 16}}));
    case kTF32:
        return are(kTF32, kF32) &&
               (wide ? isOneOf(o, {{16, 16, 8}}) : isOneOf(o, {{16, 8, 4}, {16, 8, 8}}));
    case kF64:
        return are(kF64, kF64) && (isOneOf(o, {{8, 8, 4}}) ||
                                   (!wide && isOneOf(o, {{16, 8, 4}, {16, 8, 8}, {16, 8, 16}})));
    case kE4M3:
    case kE5M2:
        return !wide && (o.b == kE4M3 || o.b == kE5M2) && isHalfOrSingle(o.c) && o.c == o.d &&
               isOneOf(o, {{16, 8, 16}, {16, 8, 32}});
    case kS8:
    case kU8:
        if (o.c != kS32 || o.d != kS32 || (o.b != kS8 && o.b != kU8))
            return false;
        return wide ? isWideShape && o.a == o.b
                    : isOneOf(o, {{8, 8, 16}, {16, 8, 16}, {16, 8, 32}});
    case kS4:
    case kU4:
        if (o.c != kS32 || o.d != kS32 || (o.b != kS4 && o.b != kU4))
            return false;
        return wide ? isOneOf(o, {{8, 8, 32}}) && o.a == o.b
                    : isOneOf(o, {{8, 8, 32}, {16, 8, 32}, {16, 8, 64}});
    case kB1:
        if (o.b != kB1 || o.c != kS32 || o.d != kS32)
            return false;
        return isOneOf(o, {{8, 8, 128}}) || (!wide && isOneOf(o, {{16, 8, 128}, {16, 8, 256}}));
    default:
        return false;
    }
}

constexpr unsigned kBitsOfWord = 32;

// Describes a product that can have this operand.
void describeFragment(MatrixOperation& operation, MatrixOperand operand, MatrixType type) {
    using enum MatrixType;
    const bool isSum = operand == MatrixOperand::kC || operand == MatrixOperand::kD;
    if (!isSum) {
        operation.a = operation.b = type;
        operation.c = operation.d = type == kF64 ? kF64 : isFloat(type) ? kF32 : kS32;
        return;
    }
    operation.c = operation.d = type;
    operation.a = type == kF64        ? kF64
                  : isFloat(type)     ? (operation.k == 8 ? kTF32 : kF16)
                  : operation.k == 16 ? kS8
                  : operation.k == 32 ? kS4
                                      : kB1;
    operation.b = operation.a;
}

} // namespace

// mma.sync.aligned.m16n8k16.row.col.f32.f16.f16.f32 d, a, b, c
void FunctionTranslator::multiplyMatrices(const ptx::Instruction& instruction) {
    for (const std::string_view word : instruction.modifiers)
        if (word.starts_with("sp") || word.starts_with("kind::") || word == "block_scale")
            reject(instruction, ErrorCode::kNotSupported,
                   "sparse and scaled matrices are not available");
    ModifierReader reader(instruction.modifiers);
    MatrixOperation operation;
    bool columnsA = false, columnsB = false;
    if (!reader.takeAll({"sync", "aligned"}) || !reader.takeShape(operation) ||
        !reader.takeLayout(columnsA) || !reader.takeLayout(columnsB))
        rejectForm(instruction);
    if (reader.take("satfinite"))
        operation.flags |= kMatrixSaturates;
    if (!reader.takeType(operation.d) || !reader.takeType(operation.a) ||
        !reader.takeType(operation.b) || !reader.takeType(operation.c))
        rejectForm(instruction);
    if (operation.a == MatrixType::kB1) {
        if (reader.take("and"))
            operation.flags |= kMatrixAnd;
        else if (!reader.take("xor"))
            rejectForm(instruction);
        if (!reader.take("popc"))
            rejectForm(instruction);
    }
    const bool isQuad = operation.isQuad();
    if (!reader.atEnd() || !exists(operation) || (!isQuad && (columnsA || !columnsB)) ||
        (operation.has(kMatrixSaturates) &&
         (isFloat(operation.a) || operation.a == MatrixType::kB1)))
        rejectForm(instruction);
    if (isQuad && columnsA)
        operation.flags |= kMatrixColumnsA;
    if (isQuad && !columnsB)
        operation.flags |= kMatrixRowsB;
    emitProduct(instruction, operation);
}

void FunctionTranslator::wideMatrices(const ptx::Instruction& instruction) {
    const bool isProduct = instruction.has("mma");
    if (!isProduct)
        return moveFragment(instruction);
    // wmma.mma.sync.aligned.row.col.m16n16k16.f32.f16 d, a, b, c
    ModifierReader reader(instruction.modifiers);
    MatrixOperation operation;
    operation.flags = kMatrixWide;
    bool columns = false;
    if (!reader.take("mma"))
        rejectForm(instruction);
    const bool isAnd = reader.peek() == "and", isOfBits = isAnd || reader.peek() == "xor";
    if (isOfBits && !(reader.take(reader.peek()) && reader.take("popc")))
        rejectForm(instruction);
    bool columnsB = false;
    if (!reader.takeAll({"sync", "aligned"}) || !reader.takeLayout(columns) ||
        !reader.takeLayout(columnsB) || !reader.takeShape(operation))
        rejectForm(instruction);
    // The rounding follows the shape or comes last.
    bool rounds = false;
    const auto takeRounding = [&] {
        static constexpr std::string_view kRoundings[] = {"rn", "rz", "rm", "rp"};
        for (uint8_t i = 0; i < 4 && !rounds; ++i)
            if (reader.take(kRoundings[i])) {
                operation.rounding = i;
                rounds = true;
            }
    };
    takeRounding();
    if (!reader.takeType(operation.d) || !reader.takeType(operation.a))
        rejectForm(instruction);
    if (reader.atEnd()) { // for halves only the sums' types are given
        operation.c = operation.a;
        operation.a = operation.b = MatrixType::kF16;
    } else if (!reader.takeType(operation.b) || !reader.takeType(operation.c)) {
        rejectForm(instruction);
    }
    if (reader.take("satfinite"))
        operation.flags |= kMatrixSaturates;
    takeRounding();
    if (isAnd)
        operation.flags |= kMatrixAnd;
    const bool isBits = operation.a == MatrixType::kB1;
    const bool isSmall = isBits || operation.a == MatrixType::kS4 || operation.a == MatrixType::kU4;
    if (!reader.atEnd() || !exists(operation) || isBits != isOfBits ||
        (rounds && operation.a != MatrixType::kF64) || (isSmall && (columns || !columnsB)))
        rejectForm(instruction);
    // .satfinite of floats has no effect: results stay finite or infinite.
    if (isFloat(operation.a) || isBits)
        operation.flags &= uint8_t(~kMatrixSaturates);
    emitProduct(instruction, operation);
}

void FunctionTranslator::emitProduct(const ptx::Instruction& instruction,
                                     MatrixOperation operation) {
    operandCount(instruction, 4, 4);
    if (operation.a == MatrixType::kB1)
        operation.k = uint16_t(operation.k / kBitsOfWord);
    static constexpr MatrixOperand kOrder[] = {MatrixOperand::kA, MatrixOperand::kB,
                                               MatrixOperand::kC};
    std::vector<Value*> words;
    for (unsigned i = 0; i < 3; ++i) {
        const unsigned bits = typeOfOperand(operation, kOrder[i]) == MatrixType::kF64 ? 64 : 32;
        const std::vector<ptx::Operand> parts = elements(instruction.operands[i + 1]);
        checkFragment(instruction, operation, kOrder[i], parts.size());
        for (const ptx::Operand& part : parts)
            words.push_back(readInt(part, bits));
    }
    const std::vector<ptx::Operand> targets = elements(instruction.operands[0]);
    checkFragment(instruction, operation, MatrixOperand::kD, targets.size());
    const std::vector<Value*> results =
        runMatrix(instruction, operation, words, unsigned(targets.size()),
                  operation.d == MatrixType::kF64 ? 64 : 32);
    for (size_t i = 0; i < targets.size(); ++i)
        write(targets[i], results[i]);
}

void FunctionTranslator::checkFragment(const ptx::Instruction& instruction,
                                       const MatrixOperation& operation, MatrixOperand operand,
                                       size_t registers) const {
    const unsigned wordsOfRegister = typeOfOperand(operation, operand) == MatrixType::kF64 ? 2 : 1;
    const unsigned wanted = wordsOf(operation, operand) / wordsOfRegister;
    if (registers != wanted)
        reject(instruction, ErrorCode::kInvalidPtx,
               message("operand ", "ABCD"[size_t(operand)], " has ", registers,
                       " registers; it needs ", wanted));
}

// Passes the operands, waits for the other lanes, and returns the results.
std::vector<Value*> FunctionTranslator::runMatrix(const ptx::Instruction& instruction,
                                                  const MatrixOperation& operation,
                                                  const std::vector<Value*>& inputs,
                                                  unsigned outputs, unsigned outputBits) {
    if (!isKernel())
        reject(instruction, ErrorCode::kNotSupported,
               "OptiX programs are alone in their warps: matrices are not available");
    if (!matrixBlock_) {
        llvm::IRBuilder<> top(entry_, entry_->begin());
        llvm::AllocaInst* block = top.CreateAlloca(
            llvm::ArrayType::get(top.getInt8Ty(), sizeof(MatrixBlock)), nullptr, "matrix");
        block->setAlignment(llvm::Align(16));
        matrixBlock_ = block;
    }
    const auto at = [&](size_t offset) { return offsetPointer(matrixBlock_, int64_t(offset)); };
    uint32_t description[sizeof operation / 4];
    std::memcpy(description, &operation, sizeof operation);
    for (size_t i = 0; i < std::size(description); ++i)
        builder_.CreateAlignedStore(builder_.getInt32(description[i]), at(4 * i), llvm::Align(4));
    size_t offset = offsetof(MatrixBlock, in);
    for (Value* value : inputs) {
        builder_.CreateAlignedStore(value, at(offset), llvm::Align(4));
        offset += value->getType()->getIntegerBitWidth() / 8;
    }
    SUNSTONE_CHECK(offset <= offsetof(MatrixBlock, out));
    meet(instruction.facts->lockstep, intType(32),
         {builder_.getInt32(0), builder_.getInt32(~0u),
          builder_.CreatePtrToInt(matrixBlock_, intType(64))});
    std::vector<Value*> results;
    for (unsigned i = 0; i < outputs; ++i)
        results.push_back(builder_.CreateAlignedLoad(
            intType(outputBits), at(offsetof(MatrixBlock, out) + size_t(i) * outputBits / 8),
            llvm::Align(4)));
    return results;
}

// ldmatrix.sync.aligned.m8n8.x4.trans.shared.b16 {r0, r1, r2, r3}, [address]; stmatrix in the
// opposite direction.
void FunctionTranslator::moveMatrixRows(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 2);
    const bool loads = instruction.opcode == "ldmatrix";
    ModifierReader reader(instruction.modifiers);
    MatrixOperation operation;
    operation.kind = loads ? MatrixKind::kLoadRows : MatrixKind::kStoreRows;
    if (!reader.takeAll({"sync", "aligned"}))
        rejectForm(instruction);
    if (reader.take("m16n16") || reader.take("m8n16") || reader.take("m16n8"))
        reject(instruction, ErrorCode::kNotSupported, "rows of bytes are not available");
    if (!reader.take("m8n8"))
        rejectForm(instruction);
    operation.k = reader.take("x1") ? 1 : reader.take("x2") ? 2 : reader.take("x4") ? 4 : 0;
    if (reader.take("trans"))
        operation.flags |= kMatrixTransposes;
    if (!reader.take("shared"))
        reader.take("shared::cta");
    if (operation.k == 0 || !reader.take("b16") || !reader.atEnd())
        rejectForm(instruction);
    const ptx::Operand& address = instruction.operands[loads ? 1 : 0];
    const std::vector<ptx::Operand> registers = elements(instruction.operands[loads ? 0 : 1]);
    if (address.kind != ptx::OperandKind::kAddress)
        reject(instruction, ErrorCode::kInvalidPtx, "an address expected");
    if (registers.size() != operation.k)
        reject(instruction, ErrorCode::kInvalidPtx,
               message(registers.size(), " registers; it needs ", operation.k));
    Value* const pointer = place(address).pointer;
    if (marksAccesses()) { // the row whose address this lane has
        constexpr unsigned kRowBytes = 16;
        auto* byte = builder_.CreateAlignedLoad(intType(8), pointer, llvm::Align(1), true);
        mark(*byte, address, loads ? devlib::kAccessLoad : devlib::kAccessStore, 0, kRowBytes);
    }
    std::vector<Value*> words = {builder_.CreatePtrToInt(pointer, intType(64))};
    for (size_t i = 0; !loads && i < registers.size(); ++i)
        words.push_back(readInt(registers[i], 32));
    const std::vector<Value*> results =
        runMatrix(instruction, operation, words, loads ? operation.k : 0, 32);
    for (size_t i = 0; i < results.size(); ++i)
        write(registers[i], results[i]);
}

// movmatrix.sync.aligned.m8n8.trans.b16 d, a
void FunctionTranslator::transposeMatrix(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 2);
    ModifierReader reader(instruction.modifiers);
    if (!reader.takeAll({"sync", "aligned", "m8n8", "trans", "b16"}) || !reader.atEnd())
        rejectForm(instruction);
    MatrixOperation operation;
    operation.kind = MatrixKind::kTranspose;
    const std::vector<Value*> results =
        runMatrix(instruction, operation, {readInt(instruction.operands[1], 32)}, 1, 32);
    write(instruction.operands[0], results[0]);
}

// wmma.load.a.sync.aligned.row.m16n16k16.global.f16 {r0, ...}, [address], stride; wmma.store.d ...
// [address], {r0, ...}, stride. Each lane moves the elements of its own registers; the stride is
// the distance of rows, or columns, in elements.
void FunctionTranslator::moveFragment(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 3);
    ModifierReader reader(instruction.modifiers);
    MatrixOperation operation;
    operation.flags = kMatrixWide;
    const bool loads = reader.take("load");
    if (!loads && !reader.take("store"))
        rejectForm(instruction);
    MatrixOperand operand = MatrixOperand::kD;
    if (loads && reader.take("a"))
        operand = MatrixOperand::kA;
    else if (loads && reader.take("b"))
        operand = MatrixOperand::kB;
    else if (loads && reader.take("c"))
        operand = MatrixOperand::kC;
    else if (loads || !reader.take("d"))
        rejectForm(instruction);
    bool byColumns = false;
    MatrixType type = MatrixType::kNone;
    if (!reader.takeAll({"sync", "aligned"}) || !reader.takeLayout(byColumns) ||
        !reader.takeShape(operation))
        rejectForm(instruction);
    if (!reader.take("global") && !reader.take("shared"))
        reader.take("shared::cta");
    if (!reader.takeType(type) || !reader.atEnd())
        rejectForm(instruction);
    describeFragment(operation, operand, type);
    const bool isSmall =
        type == MatrixType::kB1 || type == MatrixType::kS4 || type == MatrixType::kU4;
    if (!exists(operation) || (isSmall && byColumns != (operand == MatrixOperand::kB)))
        rejectForm(instruction);
    if (type == MatrixType::kB1)
        operation.k = uint16_t(operation.k / kBitsOfWord);
    const std::vector<ptx::Operand> registers = elements(instruction.operands[loads ? 0 : 1]);
    const ptx::Operand& address = instruction.operands[loads ? 1 : 0];
    if (address.kind != ptx::OperandKind::kAddress)
        reject(instruction, ErrorCode::kInvalidPtx, "an address expected");
    checkFragment(instruction, operation, operand, registers.size());
    emitFragment(instruction, operation, operand, byColumns, registers, address);
}

// Elements adjacent both in a register and in memory move together.
void FunctionTranslator::emitFragment(const ptx::Instruction& instruction,
                                      const MatrixOperation& operation, MatrixOperand operand,
                                      bool byColumns, const std::vector<ptx::Operand>& registers,
                                      const ptx::Operand& address) {
    const bool loads = operand != MatrixOperand::kD;
    const MatrixType type = typeOfOperand(operation, operand);
    const unsigned bits = bitsOfElement(type);
    const unsigned strideBits = type == MatrixType::kB1 ? 1 : bits;
    const bool isB = operand == MatrixOperand::kB;
    const unsigned rows = isB ? operation.k : operation.m;
    const unsigned columns = operand == MatrixOperand::kA ? operation.k : operation.n;
    Value* const stride = instruction.operands.size() == 3
                              ? readInt(instruction.operands[2], 32)
                              : static_cast<Value*>(builder_.getInt32((byColumns ? rows : columns) *
                                                                      bits / strideBits));
    Value* const strideBytes = builder_.CreateLShr(
        builder_.CreateMul(builder_.CreateZExt(stride, intType(64)), builder_.getInt64(strideBits)),
        3);
    // An element's position is the sum of a part from the lane and a part from the element's
    // number.
    const auto majorOf = [&](MatrixPlace at) { return byColumns ? at.column : at.row; };
    const auto minorOf = [&](MatrixPlace at) { return byColumns ? at.row : at.column; };
    const auto bytesAt = [&](Value* major, Value* minorBits) {
        return builder_.CreateAdd(builder_.CreateMul(major, strideBytes),
                                  builder_.CreateLShr(minorBits, 3));
    };
    Value* const lane = builder_.CreateZExt(special("%laneid", instruction.location), intType(64));
    Value* const group = builder_.CreateLShr(lane, 2);
    Value* const member = builder_.CreateAnd(lane, 3);
    const auto laneTerm = [&](auto part) {
        const uint64_t perGroup = part(placeOf(operation, operand, 4, 0));
        const uint64_t perMember = part(placeOf(operation, operand, 1, 0));
        return builder_.CreateAdd(builder_.CreateMul(group, builder_.getInt64(perGroup)),
                                  builder_.CreateMul(member, builder_.getInt64(perMember)));
    };
    Value* const first = builder_.CreateGEP(
        builder_.getInt8Ty(), place(address).pointer,
        bytesAt(laneTerm(majorOf), builder_.CreateMul(laneTerm(minorOf), builder_.getInt64(bits))));

    const unsigned registerBits = bits == 64 ? 64 : kBitsOfWord;
    const unsigned perRegister = registerBits / bits;
    for (size_t i = 0; i < registers.size(); ++i) {
        const auto at = [&](unsigned k) {
            return placeOf(operation, operand, 0, unsigned(i) * perRegister + k);
        };
        const bool together = perRegister == 1 || minorOf(at(1)) == minorOf(at(0)) + 1;
        const unsigned pieces = together ? 1 : perRegister;
        const unsigned pieceBits = registerBits / pieces;
        Value* whole =
            loads ? builder_.getIntN(registerBits, 0) : readInt(registers[i], registerBits);
        for (unsigned k = 0; k < pieces; ++k) {
            Value* const pointer =
                builder_.CreateGEP(builder_.getInt8Ty(), first,
                                   bytesAt(builder_.getInt64(majorOf(at(k))),
                                           builder_.getInt64(uint64_t(minorOf(at(k))) * bits)));
            llvm::Type* pieceType = intType(pieceBits);
            const uint64_t shift = uint64_t(k) * pieceBits;
            if (loads) {
                auto* loaded = builder_.CreateAlignedLoad(pieceType, pointer, llvm::Align(1));
                mark(*loaded, address, devlib::kAccessLoad, 0, pieceBits / 8);
                Value* piece = builder_.CreateZExt(loaded, whole->getType());
                whole = builder_.CreateOr(whole, builder_.CreateShl(piece, shift));
            } else {
                Value* piece = builder_.CreateTrunc(builder_.CreateLShr(whole, shift), pieceType);
                auto* stored = builder_.CreateAlignedStore(piece, pointer, llvm::Align(1));
                mark(*stored, address, devlib::kAccessStore, 0, pieceBits / 8);
            }
        }
        if (loads)
            write(registers[i], whole);
    }
}

} // namespace sunstone::compiler
