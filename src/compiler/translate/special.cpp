// SPDX-License-Identifier: Apache-2.0
// FunctionTranslator: special registers, barriers and warp functions. An OptiX program is alone
// in its warp: lane 0 of a warp with one active lane. Kernels reach their launcher through the
// functions of compiler/runtime/kernel.cpp.
#include "compiler/runtime/lane_functions.h"
#include "compiler/translate/function_translator.h"

namespace sunstone::compiler {

using devlib::KernelThread;

namespace {

// 0..2 for "%tid.x" and name "%tid", 3 for .w, -1 if the name differs.
int componentOf(std::string_view name, std::string_view base) {
    if (name.size() != base.size() + 2 || !name.starts_with(base) || name[base.size()] != '.')
        return -1;
    switch (name.back()) {
    case 'x':
        return 0;
    case 'y':
        return 1;
    case 'z':
        return 2;
    case 'w':
        return 3;
    default:
        return -1;
    }
}

} // namespace

Value* FunctionTranslator::special(std::string_view name, ptx::Location location) {
    if (Value* value = indexRegister(name))
        return value;
    if (unit_.isGpu() && name.starts_with("%"))
        return readSpecialNative(name);
    for (const auto read :
         {&FunctionTranslator::laneRegister, &FunctionTranslator::gridRegister,
          &FunctionTranslator::clockRegister, &FunctionTranslator::clusterRegister})
        if (Value* value = (this->*read)(name))
            return value;
    failAt(ErrorCode::kInvalidPtx, location, "special register \"", name,
           isKernel() ? "\" is not available" : "\" is not available in OptiX programs");
}

Value* FunctionTranslator::kernelField(size_t offset) {
    return stateField(offset, intType(32), "special");
}

// Components of %tid, %ntid, %ctaid and %nctaid; null for other names.
Value* FunctionTranslator::indexRegister(std::string_view name) {
    struct VectorRegister {
        std::string_view name;
        size_t offset;
    };
    static constexpr VectorRegister kVectors[] = {
        {"%tid", offsetof(KernelThread, tid)},
        {"%ntid", offsetof(KernelThread, ntid)},
        {"%ctaid", offsetof(KernelThread, ctaid)},
        {"%nctaid", offsetof(KernelThread, nctaid)},
    };
    for (const VectorRegister& entry : kVectors) {
        const int component = componentOf(name, entry.name);
        if (component < 0)
            continue;
        const bool isCount = entry.name[1] == 'n';
        if (component == 3)
            return builder_.getInt32(isCount ? 1 : 0);
        if (isKernel())
            return kernelField(entry.offset + size_t(component) * 4);
        if (entry.name == "%tid" || entry.name == "%ntid") {
            const Flavor& flavor = unit_.flavor();
            const std::string source = entry.name == "%tid" ? flavor.launchIndex(name.back())
                                                            : flavor.launchDimension(name.back());
            return builder_.CreateCall(unit_.intrinsic(*flavor.find(source), source), {state()});
        }
        return builder_.getInt32(isCount ? 1 : 0);
    }
    return nullptr;
}

// The thread's place in its warp and the masks of lanes around it; null for other names.
Value* FunctionTranslator::laneRegister(std::string_view name) {
    const auto lane = [&]() -> Value* {
        return isKernel() ? kernelField(offsetof(KernelThread, laneid)) : builder_.getInt32(0);
    };
    Value* one = builder_.getInt32(1);
    if (name == "%laneid")
        return lane();
    if (name == "%lanemask_eq")
        return builder_.CreateShl(one, lane());
    if (name == "%lanemask_lt")
        return builder_.CreateSub(builder_.CreateShl(one, lane()), one);
    if (name == "%lanemask_le")
        return builder_.CreateSub(builder_.CreateShl(builder_.getInt32(2), lane()), one);
    if (name == "%lanemask_ge")
        return builder_.CreateShl(builder_.getInt32(~0u), lane());
    if (name == "%lanemask_gt")
        return builder_.CreateShl(builder_.getInt32(~1u), lane());
    if (name == "WARP_SZ" || name == "%warpsize")
        return builder_.getInt32(32);
    return nullptr;
}

// Warps, processors, the grid and its memory; null for other names.
Value* FunctionTranslator::gridRegister(std::string_view name) {
    Value* one = builder_.getInt32(1);
    if (name == "%warpid")
        return isKernel() ? kernelField(offsetof(KernelThread, warpid)) : builder_.getInt32(0);
    if (name == "%nwarpid") {
        if (!isKernel())
            return one;
        Value* threads = one;
        for (size_t i = 0; i < 3; ++i)
            threads =
                builder_.CreateMul(threads, kernelField(offsetof(KernelThread, ntid) + i * 4));
        return builder_.CreateLShr(builder_.CreateAdd(threads, builder_.getInt32(31)), 5);
    }
    if (name == "%smid")
        return builder_.getInt32(0);
    if (name == "%nsmid")
        return one;
    if (name == "%gridid")
        return isKernel() ? kernelField(offsetof(KernelThread, gridIdLow)) : builder_.getInt32(0);
    // Only grid-wide barriers read them: the address of the launch's workspace, high word first.
    if (isKernel() && (name == "%envreg1" || name == "%envreg2"))
        return kernelField(offsetof(KernelThread, gridWorkspace) + (name == "%envreg1" ? 4 : 0));
    if (name == "%dynamic_smem_size" && isKernel())
        return kernelField(offsetof(KernelThread, dynamicSharedSize));
    return nullptr;
}

// Each block is a cluster of its own. Values that only tools give a meaning are 0. Null for other
// names.
Value* FunctionTranslator::clusterRegister(std::string_view name) {
    if (name.starts_with("%clusterid."))
        return indexRegister(message("%ctaid.", name.back()));
    if (name.starts_with("%nclusterid."))
        return indexRegister(message("%nctaid.", name.back()));
    if (name.starts_with("%cluster_nctaid.") || name == "%cluster_nctarank")
        return builder_.getInt32(1);
    if (name.starts_with("%cluster_ctaid.") || name == "%cluster_ctarank" ||
        name.starts_with("%envreg") || name.starts_with("%reserved_smem_offset_"))
        return builder_.getInt32(0);
    if (name == "%is_explicit_cluster")
        return builder_.getFalse();
    if (name == "%current_graph_exec")
        return builder_.getInt64(0);
    if (name.starts_with("%pm"))
        return name.ends_with("_64") ? builder_.getInt64(0) : builder_.getInt32(0);
    return nullptr;
}

// Null for other names.
Value* FunctionTranslator::clockRegister(std::string_view name) {
    llvm::Type* word = intType(32);
    if (name == "%clock64" || name == "%clock" || name == "%clock_hi") {
        Value* ticks = builder_.CreateIntrinsic(llvm::Intrinsic::readcyclecounter, {}, {});
        if (name == "%clock64")
            return ticks;
        if (name == "%clock_hi")
            ticks = builder_.CreateLShr(ticks, 32);
        return builder_.CreateTrunc(ticks, word);
    }
    if (!name.starts_with("%globaltimer"))
        return nullptr;
    Value* time =
        builder_.CreateCall(unit_.helper("sunstone_globaltimer", intType(64), {}, false), {});
    if (name == "%globaltimer_lo")
        return builder_.CreateTrunc(time, word);
    if (name == "%globaltimer_hi")
        return builder_.CreateTrunc(builder_.CreateLShr(time, 32), word);
    return time;
}

Value* FunctionTranslator::meet(ptx::Lockstep how, llvm::Type* result,
                                llvm::ArrayRef<Value*> operands) {
    const LaneFunction& function = laneFunction(how);
    facts_.warp |= function.needs == LaneFunction::kWarp;
    facts_.barriers |= function.needs == LaneFunction::kThreads;
    std::vector<Value*> values = {state()};
    values.insert(values.end(), operands.begin(), operands.end());
    std::vector<llvm::Type*> types;
    for (const Value* value : values)
        types.push_back(value->getType());
    llvm::CallInst* const call =
        builder_.CreateCall(unit_.helper(function.name, result, types, false), values);
    if (function.effect == LaneFunction::kAsks)
        call->addFnAttr(llvm::Attribute::NoMerge); // two branches ask for different lanes
    return call;
}

// A cluster is one block: its threads meet where they wait.
void FunctionTranslator::clusterBarrier(const ptx::Instruction& instruction) {
    operandCount(instruction, 0, 0);
    if (instruction.has("arrive"))
        return;
    Value* zero = builder_.getInt32(0);
    meet(instruction.facts->lockstep, intType(32),
         {zero, zero, builder_.getInt32(devlib::kReduceNone), zero});
}

void FunctionTranslator::barrier(const ptx::Instruction& instruction) {
    if (instruction.has("warp"))
        return warpSync(instruction);
    if (!isKernel())
        reject(instruction, ErrorCode::kInvalidPtx, "barriers are not allowed in OptiX programs");
    if (instruction.has("cluster"))
        return clusterBarrier(instruction);
    const bool reduces = instruction.has("red");
    const bool arrives = instruction.has("arrive");
    const devlib::BarrierReduction reduction = !reduces                  ? devlib::kReduceNone
                                               : instruction.has("popc") ? devlib::kReduceCount
                                               : instruction.has("and")  ? devlib::kReduceAnd
                                                                         : devlib::kReduceOr;
    operandCount(instruction, reduces ? 3 : 1, reduces ? 4 : 2);
    const size_t first = reduces ? 1 : 0;
    const size_t last = instruction.operands.size() - (reduces ? 1 : 0);
    Value* id = readInt(instruction.operands[first], 32);
    Value* threads = first + 1 < last ? readInt(instruction.operands[first + 1], 32)
                                      : static_cast<Value*>(builder_.getInt32(0));
    Value* predicate = builder_.getInt32(0);
    if (reduces)
        predicate = coerce(readInt(instruction.operands.back(), 1), intType(32));
    llvm::Type* word = intType(32);
    if (arrives) {
        facts_.barriers = true;
        builder_.CreateCall(unit_.helper("sunstone_arrive", builder_.getVoidTy(),
                                         {builder_.getPtrTy(), word, word}, false),
                            {state(), id, threads});
        return;
    }
    Value* result = meet(instruction.facts->lockstep, word,
                         {id, threads, builder_.getInt32(reduction), predicate});
    if (reduces)
        write(instruction.operands[0],
              instruction.has("popc") ? result : builder_.CreateIsNotNull(result));
}

void FunctionTranslator::warpSync(const ptx::Instruction& instruction) {
    operandCount(instruction, 1, 1);
    if (!isKernel())
        return;
    // A vote whose result is unused.
    meet(ptx::Lockstep::kVote, intType(32),
         {builder_.getInt32(0), readInt(instruction.operands[0], 32), builder_.getInt32(1)});
}

void FunctionTranslator::vote(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 3);
    const bool ballot = instruction.has("ballot");
    Value* predicate = readInt(instruction.operands[1], 1);
    if (!isKernel()) {
        write(instruction.operands[0], ballot ? builder_.CreateZExt(predicate, intType(32))
                                       : instruction.has("uni") ? builder_.getTrue()
                                                                : predicate);
        return;
    }
    const unsigned mode = ballot ? 3 : instruction.has("uni") ? 2 : instruction.has("any") ? 1 : 0;
    Value* mask = instruction.operands.size() == 3 ? readInt(instruction.operands[2], 32)
                                                   : static_cast<Value*>(builder_.getInt32(~0u));
    llvm::Type* word = intType(32);
    Value* result = meet(instruction.facts->lockstep, word,
                         {builder_.getInt32(mode), mask, builder_.CreateZExt(predicate, word)});
    write(instruction.operands[0], ballot ? result : builder_.CreateIsNotNull(result));
}

void FunctionTranslator::shuffle(const ptx::Instruction& instruction) {
    operandCount(instruction, 4, 5);
    const ptx::Operand& target = instruction.operands[0];
    const bool pair = target.kind == ptx::OperandKind::kPair;
    const ptx::Operand& into = pair ? target.elements[0] : target;
    Value* value = readInt(instruction.operands[1], 32);
    Value* distance = readInt(instruction.operands[2], 32);
    Value* valid = nullptr;
    if (isKernel()) {
        const unsigned mode = instruction.has("up")     ? 0
                              : instruction.has("down") ? 1
                              : instruction.has("bfly") ? 2
                                                        : 3;
        Value* mask = instruction.operands.size() == 5
                          ? readInt(instruction.operands[4], 32)
                          : static_cast<Value*>(builder_.getInt32(~0u));
        Value* both = meet(
            instruction.facts->lockstep, intType(64),
            {builder_.getInt32(mode), value, distance, readInt(instruction.operands[3], 32), mask});
        value = builder_.CreateTrunc(both, intType(32));
        valid = builder_.CreateIsNotNull(builder_.CreateLShr(both, 32));
    } else {
        valid = builder_.CreateIsNull(builder_.CreateAnd(distance, 31));
    }
    write(into, value);
    if (pair)
        write(target.elements[1], valid);
}

void FunctionTranslator::match(const ptx::Instruction& instruction) {
    operandCount(instruction, 3, 3);
    const ptx::Operand& target = instruction.operands[0];
    const bool pair = target.kind == ptx::OperandKind::kPair;
    const ptx::Operand& into = pair ? target.elements[0] : target;
    Value* mask = builder_.getInt32(1);
    Value* same = builder_.getTrue();
    if (isKernel()) {
        Value* value =
            coerce(readInt(instruction.operands[1], bitsOf(lastType(instruction))), intType(64));
        Value* both = meet(instruction.facts->lockstep, intType(64),
                           {builder_.getInt32(instruction.has("all")),
                            readInt(instruction.operands[2], 32), value});
        mask = builder_.CreateTrunc(both, intType(32));
        same = builder_.CreateIsNotNull(builder_.CreateLShr(both, 32));
    }
    write(into, mask);
    if (pair)
        write(target.elements[1], same);
}

void FunctionTranslator::reduceWarp(const ptx::Instruction& instruction) {
    operandCount(instruction, 3, 3);
    const ptx::Type type = lastType(instruction);
    if (ptx::isFloat(type))
        reject(instruction, ErrorCode::kNotSupported, "redux on floating point is not available");
    Value* value = readInt(instruction.operands[1], 32);
    if (isKernel()) {
        const bool isSigned = ptx::isSigned(type);
        const unsigned op = instruction.has("add")   ? 0
                            : instruction.has("and") ? 1
                            : instruction.has("or")  ? 2
                            : instruction.has("xor") ? 3
                            : instruction.has("min") ? (isSigned ? 4 : 5)
                                                     : (isSigned ? 6 : 7);
        value = meet(instruction.facts->lockstep, intType(32),
                     {builder_.getInt32(op), readInt(instruction.operands[2], 32), value});
    }
    write(instruction.operands[0], value);
}

void FunctionTranslator::activeMask(const ptx::Instruction& instruction) {
    operandCount(instruction, 1, 1);
    Value* mask = builder_.getInt32(1);
    if (isKernel())
        mask = meet(instruction.facts->lockstep, intType(32));
    write(instruction.operands[0], mask);
}

void FunctionTranslator::elect(const ptx::Instruction& instruction) {
    operandCount(instruction, 2, 2);
    const ptx::Operand& target = instruction.operands[0];
    if (target.kind != ptx::OperandKind::kPair)
        rejectForm(instruction);
    Value* leader = builder_.getInt32(0);
    Value* chosen = builder_.getTrue();
    if (isKernel()) { // the lowest lane of the mask
        Value* mask = readInt(instruction.operands[1], 32);
        leader = intrinsicCall(llvm::Intrinsic::cttz, {mask, builder_.getFalse()});
        chosen = builder_.CreateICmpEQ(leader, special("%laneid", instruction.location));
    }
    write(target.elements[0], leader);
    write(target.elements[1], chosen);
}

} // namespace sunstone::compiler
