// SPDX-License-Identifier: Apache-2.0
// Translates the body of one PTX function to LLVM IR, one instruction at a time.
//
// Registers. PTX registers are untyped bits, assigned any number of times. A register used within a
// single region (the code between two labels) lives only in `current`, the table of known values.
// Others also have an alloca, written at each definition and read at most once per region; mem2reg
// removes those. An unwritten register reads as zero, which PTX allows.
//
// Guards. A guarded instruction becomes a branch around it and phis for the registers it wrote, so
// the translation of an instruction does not depend on its guard; SimplifyCFG makes selects where
// they are cheaper.
//
// Addresses are host addresses in all state spaces, so cvta is the identity.
//
// translate/dispatch.cpp has the member function of each ptx::Operation, which the opcode's row
// names (ptx/opcodes/opcode_table.h). The members of an instruction family stand in one file of
// this folder: integer.cpp, float.cpp, memory.cpp and so on. Source: PTX ISA manual, chapter
// "Instruction Set".
#pragma once

#include "base/error.h"
#include "compiler/debug/debug_info.h"
#include "compiler/runtime/matrix.h"
#include "compiler/translate/native.h"
#include "compiler/translate/unit.h"
#include "ptx/opcodes/opcode.h"

#include <optional>
#include <unordered_map>

namespace sunstone::compiler {

using Value = llvm::Value;

// How floating point results are rounded.
enum class Rounding : uint8_t { kNearest, kZero, kDown, kUp };

class FunctionTranslator {
public:
    FunctionTranslator(Unit& unit, llvm::Function& function, FunctionFacts& facts);
    void translate();

private:
    // ---- the member of each operation: translate/dispatch.cpp
    struct Members;
    void dispatch(const ptx::Instruction& instruction);

    // ---- set-up and the walk over the body: translate/function.cpp
    void declareVariables();
    void declareParameters();
    void classifyRegisters();
    void createRegisters();
    void translateInstruction(const ptx::Instruction& instruction);
    void translateGuarded(const ptx::Instruction& instruction);
    void beginDebug();
    void startRegion(llvm::BasicBlock* block);
    void emitReturn();
    bool terminated() const { return builder_.GetInsertBlock()->getTerminator() != nullptr; }
    [[noreturn]] void reject(const ptx::Instruction& instruction, ErrorCode code,
                             const std::string& why) const;
    [[noreturn]] void rejectForm(const ptx::Instruction& instruction) const;
    void operandCount(const ptx::Instruction& instruction, size_t least, size_t most) const;

    // ---- types, registers, operands: translate/operands.cpp
    struct Slot {
        llvm::Type* type = nullptr;
        llvm::AllocaInst* memory = nullptr; // null: the register lives in one region
        Value* current = nullptr;
        uint32_t region = 0; // in which `current` is valid
    };
    llvm::IntegerType* intType(unsigned bits) { return builder_.getIntNTy(bits); }
    llvm::Type* typeOf(ptx::Type type); // integer, half, float, double, <2 x half>
    static unsigned bitsOf(ptx::Type type) {
        return type == ptx::Type::kPred ? 1 : ptx::sizeOf(type) * 8;
    }
    Value* coerce(Value* value, llvm::Type* type, bool isSigned = false);
    Value* readSlot(uint32_t slot);
    void writeSlot(uint32_t slot, Value* value, bool isSigned);
    uint32_t slotOf(const ptx::Operand& operand) const;
    Value* read(const ptx::Operand& operand, ptx::Type type);
    Value* readInt(const ptx::Operand& operand, unsigned bits);
    Value* readAs(const ptx::Operand& operand, llvm::Type* type);
    Value* readImmediate(const ptx::Operand& operand, llvm::Type* type);
    void write(const ptx::Operand& operand, Value* value, bool isSigned = false);
    // The elements of a vector operand, also of a whole vector register.
    std::vector<ptx::Operand> elements(const ptx::Operand& operand) const;
    template <class Visit>
    void visitRegisters(const ptx::Instruction& instruction, Visit visit) const;
    ptx::Type lastType(const ptx::Instruction& instruction) const {
        if (instruction.types.empty())
            rejectForm(instruction);
        return instruction.types.back();
    }
    Value* readCarry();
    void writeCarry(Value* carry);

    // ---- memory: translate/memory.cpp
    struct Place {
        Value* pointer = nullptr;
        bool constant = false; // never changes during a launch
    };
    Place place(const ptx::Operand& operand);
    Value* symbolAddress(std::string_view name, ptx::Location location, bool* constant = nullptr);
    Value* launchParams();
    Value* stateField(size_t offset, llvm::Type* type, const char* name);
    Value* indexedPointer(Value* base, const ptx::Operand& operand);
    Value* pointerOfWord(const ptx::Operand& reg);
    bool isGlobalMemory();
    Value* addressedConstant();
    Value* offsetPointer(Value* pointer, int64_t offset);
    // For the memory checker: `access` is the part at `offset` of an access of `bytes`.
    bool marksAccesses() const; // for the memory checker
    void mark(llvm::Instruction& access, const ptx::Operand& operand, uint8_t kind, unsigned offset,
              unsigned bytes);
    bool isWithinVariable(const ptx::Operand& operand, unsigned bytes) const;
    bool isWholeVector(const ptx::Instruction& instruction, unsigned bytes) const;
    std::vector<llvm::Value*> splitWhole(llvm::Value* whole, llvm::Type* type, unsigned count);
    llvm::Value* joinWhole(const std::vector<llvm::Value*>& elements);
    void load(const ptx::Instruction& instruction);
    void store(const ptx::Instruction& instruction);
    void atomic(const ptx::Instruction& instruction);
    void mayWait();
    void mayWaitIfZero(Value* operand);
    void sleep(const ptx::Instruction&) { mayWait(); }
    void atomicNumbers(const ptx::Instruction& instruction);
    llvm::CallInst* atomicNumber(const ptx::Instruction& instruction, Value* pointer,
                                 const ptx::Operand& source);
    void fence(const ptx::Instruction& instruction);
    void move(const ptx::Instruction& instruction);
    void convertAddress(const ptx::Instruction& instruction);

    // ---- the space of an address: translate/address_spaces.cpp
    void testAddressSpace(const ptx::Instruction& instruction);
    Value* isWithin(Value* address, Value* begin, Value* bytes);
    Value* isShared(Value* address);
    Value* isConstant(Value* address);
    Value* isParameter(const ptx::Instruction& instruction, Value* address);
    Value* isLocal(Value* address);
    void noOperation(const ptx::Instruction&) {}

    // ---- integer: translate/integer.cpp
    void add(const ptx::Instruction& instruction);
    void subtract(const ptx::Instruction& instruction);
    void multiply(const ptx::Instruction& instruction);
    void multiplyAdd(const ptx::Instruction& instruction);
    void multiply24(const ptx::Instruction& instruction);
    void divide(const ptx::Instruction& instruction);
    void remainder(const ptx::Instruction& instruction);
    void negate(const ptx::Instruction& instruction);
    void absolute(const ptx::Instruction& instruction);
    void minimum(const ptx::Instruction& instruction);
    void sumAbsoluteDifference(const ptx::Instruction& instruction);
    void logic(const ptx::Instruction& instruction);
    void logicNot(const ptx::Instruction& instruction);
    void lookup3(const ptx::Instruction& instruction);
    void shift(const ptx::Instruction& instruction);
    void funnelShift(const ptx::Instruction& instruction);
    void extractField(const ptx::Instruction& instruction);
    void insertField(const ptx::Instruction& instruction);
    void findBit(const ptx::Instruction& instruction);
    void countBits(const ptx::Instruction& instruction);
    void fieldMask(const ptx::Instruction& instruction);
    void permute(const ptx::Instruction& instruction);
    void dotProduct(const ptx::Instruction& instruction);
    void packedArithmetic(const ptx::Instruction& instruction); // u16x2, s16x2
    void findNthSet(const ptx::Instruction& instruction);
    void addInteger(const ptx::Instruction& instruction, Value* a, Value* b, unsigned bits,
                    bool subtract);
    Value* shiftLeft(Value* value, Value* amount);
    Value* shiftRight(Value* value, Value* amount, bool isSigned);

    // ---- video instructions: translate/video.cpp
    void videoScalar(const ptx::Instruction& instruction);
    void videoMultiplyAdd(const ptx::Instruction& instruction);
    void videoPacked(const ptx::Instruction& instruction);
    Value* videoOperand(const ptx::Operand& operand, bool isSigned);
    Value* videoResult(const ptx::Instruction& instruction, Value* a, Value* b,
                       bool arithmeticShift);
    Value* videoSaturate(Value* value, unsigned bits, bool isSigned);
    Value* videoSecond(const ptx::Instruction& instruction, Value* result, Value* other,
                       bool isSigned);

    // ---- floating point: translate/float.cpp
    void floatArithmetic(const ptx::Instruction& instruction);
    void fusedMultiplyAdd(const ptx::Instruction& instruction);
    void floatDivide(const ptx::Instruction& instruction);
    void reciprocal(const ptx::Instruction& instruction);
    void squareRoot(const ptx::Instruction& instruction);
    void reciprocalSquareRoot(const ptx::Instruction& instruction);
    void approximateDouble(const ptx::Instruction& instruction);
    void transcendental(const ptx::Instruction& instruction);
    void floatSign(const ptx::Instruction& instruction);
    void floatMinimum(const ptx::Instruction& instruction);
    void copySign(const ptx::Instruction& instruction);
    void testProperty(const ptx::Instruction& instruction);
    Value* flush(Value* value); // subnormal f32 or f16 → zero of its sign
    ptx::Type floatType(const ptx::Instruction& instruction) const;
    // These apply the instruction's .ftz. 16-bit numbers are computed in single precision, which
    // holds them; writeFloat rounds back.
    Value* readFloat(const ptx::Instruction& instruction, const ptx::Operand& operand,
                     ptx::Type type);
    static bool isHalfType(ptx::Type type); // f16, bf16 and pairs of them
    static bool isHalfPair(ptx::Type type);
    static bool isBrainType(ptx::Type type);
    Value* widenHalf(Value* value, ptx::Type type);
    Value* narrowHalf(Value* value, ptx::Type type);
    Value* fusedHalf(Value* a, Value* b, Value* c, ptx::Type type);
    void writeFloat(const ptx::Instruction& instruction, Value* value, bool canBeSubnormal = true);
    Value* saturate(Value* value);
    Value* pickMinimum(Value* a, Value* b, bool greatest, bool propagateNan);
    Value* roundedCall(const char* operation, Rounding rounding, llvm::ArrayRef<Value*> operands);
    static Rounding roundingOf(const ptx::Instruction& instruction);
    Value* intrinsicCall(llvm::Intrinsic::ID id, llvm::ArrayRef<Value*> operands);

    // ---- conversion and comparison: translate/convert.cpp, translate/compare.cpp
    void convert(const ptx::Instruction& instruction);
    void convertPacked(const ptx::Instruction& instruction);
    void packIntegers(const ptx::Instruction& instruction);
    void convertSmall(const ptx::Instruction& instruction);
    void decodeSmallPair(const ptx::Instruction& instruction, uint32_t format);
    Value* intToHalf(Value* value, bool isSigned, ptx::Type to, Rounding rounding);
    Value* encodeSmall(Value* value, uint32_t format, uint32_t how);
    Value* limitHalf(const ptx::Instruction& instruction, Value* half, ptx::Type type);
    Value* roundToIntegral(Value* value, const ptx::Instruction& instruction);
    Value* floatToFloat(const ptx::Instruction& instruction, Value* value, ptx::Type from,
                        ptx::Type to);
    Value* floatToInt(const ptx::Instruction& instruction, Value* value, ptx::Type to);
    Value* intToFloat(const ptx::Instruction& instruction, Value* value, ptx::Type from,
                      ptx::Type to);
    Value* intToInt(const ptx::Instruction& instruction, Value* value, ptx::Type from,
                    ptx::Type to);
    void setPredicate(const ptx::Instruction& instruction);
    void setValue(const ptx::Instruction& instruction);
    void select(const ptx::Instruction& instruction);
    void selectBySign(const ptx::Instruction& instruction);
    // One bit, or two for pairs of halves.
    Value* comparison(const ptx::Instruction& instruction, const ptx::Operand& a,
                      const ptx::Operand& b, ptx::Type type);
    Value* combine(const ptx::Instruction& instruction, Value* result, const ptx::Operand* with);

    // ---- control flow and calls: translate/control.cpp
    void branch(const ptx::Instruction& instruction);
    void branchIndexed(const ptx::Instruction& instruction);
    void returnFrom(const ptx::Instruction& instruction);
    void exitThread(const ptx::Instruction& instruction);
    void trap(const ptx::Instruction& instruction);
    void call(const ptx::Instruction& instruction);
    void callIntrinsic(const ptx::Instruction& instruction, std::string_view name);
    Value* resolveCallee(const ptx::Instruction& instruction, Value* target,
                         const ptx::Prototype& prototype);
    void callFunction(const ptx::Instruction& instruction, Value* target,
                      const Signature& signature, const std::vector<ptx::Variable>& results,
                      const std::vector<ptx::Variable>& parameters);
    // The memory of a variable that an argument or a result of a call names; null for a register.
    Value* memoryOf(const ptx::Operand& operand) const;
    uint64_t sizeOfMemory(const ptx::Operand& operand) const;
    // Memory to which a callee writes a result; temporary if the result goes to a register.
    Value* memoryForResult(const ptx::Operand& operand, uint64_t bytes);
    Value* readArgument(const ptx::Operand& operand, llvm::Type* type);
    void writeResult(const ptx::Operand& operand, Value* value);
    void emitTrap(ptx::Lockstep how = ptx::Lockstep::kTrap);
    void endAfterAssertion();

    // ---- special registers, warps, barriers: translate/special.cpp
    Value* special(std::string_view name, ptx::Location location);
    Value* indexRegister(std::string_view name);
    Value* laneRegister(std::string_view name);
    Value* gridRegister(std::string_view name);
    Value* clusterRegister(std::string_view name);
    Value* clockRegister(std::string_view name);
    Value* kernelField(size_t offset);
    // Calls the run-time where a lane of a kernel depends on other lanes.
    Value* meet(ptx::Lockstep how, llvm::Type* result, llvm::ArrayRef<Value*> operands = {});
    void barrier(const ptx::Instruction& instruction);
    void clusterBarrier(const ptx::Instruction& instruction);
    void warpSync(const ptx::Instruction& instruction);
    void vote(const ptx::Instruction& instruction);
    void shuffle(const ptx::Instruction& instruction);
    void match(const ptx::Instruction& instruction);
    void reduceWarp(const ptx::Instruction& instruction);
    void activeMask(const ptx::Instruction& instruction);
    void elect(const ptx::Instruction& instruction);

    // ---- asynchronous copies, barrier objects: translate/async.cpp
    void copyAsync(const ptx::Instruction& instruction);
    void copyBulk(const ptx::Instruction& instruction);
    void copyBytes(const ptx::Instruction& instruction, Value* to, Value* from, Value* bytes);
    bool isPolicy(const ptx::Instruction& instruction, size_t operand) const;
    void barrierObject(const ptx::Instruction& instruction);
    Value* arriveAt(const ptx::Operand& object, Value* count, Value* bytes, bool drop);
    void waitAt(const ptx::Instruction& instruction);
    void checkObject(Value* pointer, const ptx::Operand& object);

    // ---- matrices of a warp: translate/matrix.cpp
    void multiplyMatrices(const ptx::Instruction& instruction);
    void wideMatrices(const ptx::Instruction& instruction);
    void moveMatrixRows(const ptx::Instruction& instruction);
    void transposeMatrix(const ptx::Instruction& instruction);
    void emitProduct(const ptx::Instruction& instruction, MatrixOperation operation);
    void moveFragment(const ptx::Instruction& instruction);
    void emitFragment(const ptx::Instruction& instruction, const MatrixOperation& operation,
                      MatrixOperand operand, bool byColumns,
                      const std::vector<ptx::Operand>& registers, const ptx::Operand& address);
    void checkFragment(const ptx::Instruction& instruction, const MatrixOperation& operation,
                       MatrixOperand operand, size_t registers) const;
    std::vector<Value*> runMatrix(const ptx::Instruction& instruction,
                                  const MatrixOperation& operation,
                                  const std::vector<Value*>& inputs, unsigned outputs,
                                  unsigned outputBits);

    // ---- memory of the stack: translate/stack.cpp
    void checkStackType(const ptx::Instruction& instruction) const;
    int64_t checkStack(const ptx::Instruction& instruction) const;
    void allocateStack(const ptx::Instruction& instruction);
    void saveStack(const ptx::Instruction& instruction);
    void restoreStack(const ptx::Instruction& instruction);

    // ---- textures and surfaces: translate/texture.cpp
    struct TextureOperand {
        Value* handle = nullptr;
        uint32_t form = 0; // geometry
        Value* position[3] = {};
        Value* layer = nullptr;
    };
    Value* textureHandle(const ptx::Operand& operand);
    TextureOperand textureOperand(const ptx::Instruction& instruction, const ptx::Operand& operand,
                                  bool isFloat);
    Value* textureBlock();
    void storeOperand(size_t offset, Value* value);
    void sampleTexture(const ptx::Instruction& instruction);
    void checkTexture(const ptx::Operand& operand, Value* handle);
    void writeSample(const ptx::Instruction& instruction, Value* result);
    void queryTexture(const ptx::Instruction& instruction);
    template <class Access>
    std::vector<Value*> atTexel(const ptx::Instruction& instruction, const ptx::Operand& operand,
                                unsigned bytes, Access access);
    void loadSurface(const ptx::Instruction& instruction);
    void storeSurface(const ptx::Instruction& instruction);
    void reduceSurface(const ptx::Instruction& instruction);
    void reduceFormatted(const ptx::Instruction& instruction, unsigned bytes);

    // ---- GPU: instructions kept as they are, translate/native.cpp
    bool translateNative(const ptx::Instruction& instruction);
    struct Assembly;
    void emitNative(const ptx::Instruction& instruction, const NativeForm& form);
    void nativeOperand(Assembly& code, const ptx::Operand& operand, bool isTarget);
    void nativeList(Assembly& code, const std::vector<ptx::Operand>& operands, bool isTarget,
                    const char* open, const char* between, const char* close);
    void nativeRegister(Assembly& code, const ptx::Operand& operand, bool isTarget);
    void nativeAddress(Assembly& code, const ptx::Operand& operand);
    static ptx::Instruction rowLookup(const ptx::Instruction& line);
    bool isReference(const ptx::Operand& operand) const;
    Value* referenceHandle(const ptx::Operand& operand);
    unsigned nativeBits(const ptx::Operand& operand) const;
    llvm::CallInst* callAssembly(const Assembly& code);
    void allocateStackNative(const ptx::Instruction& instruction);
    Value* readSpecialNative(std::string_view name);

    bool isKernel() const { return unit_.flavor().isKernels(); }
    Value* state() { return function_.getArg(0); }

    Unit& unit_;
    llvm::Function& function_;
    FunctionFacts& facts_;
    const ptx::Module& module_;
    const ptx::Function& source_;
    llvm::IRBuilder<> builder_;
    llvm::BasicBlock* entry_ = nullptr;

    std::unique_ptr<FunctionDebug> debug_; // null without line information

    std::vector<uint32_t> firstSlot_;      // by register
    std::vector<uint32_t> registerOfSlot_; // filled where variables are described
    std::vector<Slot> slots_;
    uint32_t carrySlot_ = 0;
    uint32_t region_ = 0;
    std::optional<bool> hasOwnVariables_; // the module has some with Flavor::variableIntrinsic()
    std::vector<std::pair<uint32_t, Value*>>* guardLog_ = nullptr; // slots written under a guard
    std::vector<llvm::BasicBlock*> labels_;
    // Parameters and variables of the body: address by name.
    std::unordered_map<std::string_view, Value*> locals_;
    std::unordered_map<std::string_view, const ptx::Variable*> localVariables_;
    const ptx::Instruction* current_ = nullptr;
    Value* textureBlock_ = nullptr;
    Value* matrixBlock_ = nullptr;
};

} // namespace sunstone::compiler
