// SPDX-License-Identifier: Apache-2.0
// Writes the code for 32 lanes according to lockstep/plan.h.
//
// Each value used outside its block has a place in memory: a vector of 32, or a scalar if the value
// is uniform. Promotion turns places into SSA values again. A place keeps the values of inactive
// lanes. Masks of blocks are places too.
#pragma once

#include "compiler/lockstep/plan.h"
#include "devlib/lockstep.h"

#include <llvm/IR/IRBuilder.h>
#include <llvm/IR/Module.h>

#include <functional>

namespace sunstone::compiler {

class LockstepEmitter {
public:
    // hasMasks: the processor has masked loads and stores, and gathers (AVX-512). byRuns: the lanes
    // execute short runs of instructions one after another (lockstep/runs.cpp).
    LockstepEmitter(const LockstepPlan& plan, llvm::Function& result, bool hasMasks, bool byRuns);

    void emit();
    uint32_t frameBytes() const { return frameBytes_; }
    bool needsThreads() const { return needsThreads_; }

private:
    using Value = llvm::Value;
    static constexpr unsigned kLanes = devlib::kWarpLanes;

    // ---- control (lockstep/emit.cpp) ----
    void begin();
    void finish();
    void emitPrologue();
    void emitEntry();
    void resumeAt(size_t number);
    void goOn(const MeetingPoint& point, Value* mask);
    void landAt(const Step& step);
    void emitSteps(const std::vector<Step>& steps);
    void emitLoop(const Step& step);
    void emitSimpleBody(const Step& step);
    void emitBlock(llvm::BasicBlock& block);
    void emitBody(llvm::BasicBlock& block);
    void emitTerminator(llvm::BasicBlock& block);
    void emitEdge(llvm::BasicBlock& from, llvm::BasicBlock& to, Value* mask, Value* always);
    void emitPoint(const MeetingPoint& point);
    Value* isPauseDue(const MeetingPoint& point);
    Value* hasJumped();
    void countJump(Value* address, uint64_t bytes);
    void leaveAt(const MeetingPoint& point, uint32_t what);
    struct Operand {
        Value* value;
        llvm::Type* type; // in the warp
        size_t offset;
    };
    std::vector<Operand> operandsOf(const MeetingPoint& point);
    void storeOperands(const MeetingPoint& point);
    bool needsGuard(llvm::BasicBlock& block) const;
    void addToMask(llvm::BasicBlock* block, Value* mask);
    llvm::Type* maskType();
    Value* maskOf(Value* bits);
    Value* maskBits(Value* mask);
    Value* any(Value* mask);
    void makeMasks();
    llvm::Value* maskPlace(llvm::BasicBlock* block);
    llvm::Value* loadMask(llvm::BasicBlock* block);
    void storeMask(llvm::BasicBlock* block, llvm::Value* mask);

    // ---- warp functions without leaving (lockstep/warps.cpp) ----
    Value* canAnswer(const MeetingPoint& point, Value* bits);
    Value* answer(const MeetingPoint& point);
    Value* answerVote(const MeetingPoint& point);
    Value* answerShuffle(const MeetingPoint& point);
    Value* answerReduce(const MeetingPoint& point);
    Value* answerByHelper(const MeetingPoint& point);
    void callHelper(const MeetingPoint& point);

    // ---- values (lockstep/values.cpp) ----
    llvm::FixedVectorType* wideType(llvm::Type* type) const;
    llvm::Type* typeFor(const llvm::Value* value) const; // of its place
    bool isUniform(const Value* value) const { return plan_.isUniform(value); }
    llvm::AllocaInst* place(const llvm::Instruction& value);
    Value* loadUniform(const llvm::Instruction& value);
    void storeUniform(const llvm::Instruction& value, Value* made);
    Value* scalar(Value* value); // of a uniform value
    Value* wide(Value* value);   // of any value
    Value* operand(Value* value) { return isUniform(value) ? scalar(value) : wide(value); }
    void define(llvm::Instruction& instruction, Value* made);
    void store(llvm::Instruction& value, Value* made, bool blend, Value* mask);
    Value* splat(Value* scalar);
    Value* lanes(llvm::Type* type, uint64_t step = 1); // 0, step, 2 step, ...
    Value* select(Value* mask, Value* first, Value* second);
    Value* temporary(llvm::Type* type);
    Value* field(size_t offset);
    void storeMasked(Value* made, Value* address, llvm::Align align, Value* mask);
    Value* framePlace(const llvm::Instruction& value);
    size_t arrayOfField(const llvm::Instruction& load) const; // offset in LockstepWarp
    llvm::Type* storedType(llvm::Type* type) const;           // a bool is a byte
    Value* toStored(Value* made);
    Value* fromStored(Value* made, llvm::Type* type);
    Value* firstLane(Value* bits);

    // ---- instructions (lockstep/widen.cpp) ----
    bool isFieldAddress(const llvm::Instruction& instruction) const;
    void emitInstruction(llvm::Instruction& instruction);
    void emitUniform(llvm::Instruction& instruction);
    Value* widen(llvm::Instruction& instruction); // null: lane by lane
    Value* widenCall(llvm::CallInst& call);
    Value* widenLoad(llvm::LoadInst& load);
    bool widenStore(llvm::StoreInst& store);
    Value* widenDivision(llvm::BinaryOperator& division);
    void storeUniformAddress(llvm::StoreInst& store);
    Value* laneByLane(llvm::Instruction& instruction);
    void forEachLane(const std::function<void(Value* lane)>& body);
    Value* threadOf(Value* lane);
    // Runs `near` if the addresses of the lanes are consecutive, with the first address and whether
    // all lanes are active; else `far`.
    using Near = std::function<Value*(Value* first, bool isFull)>;
    struct Nearness {
        Value* fits = nullptr;  // by lane: whether the address is consecutive
        Value* first = nullptr; // address of the first lane
        Value* bound = nullptr; // further condition; null: none
    };
    Value* byNearness(Value* pointer, uint64_t bytes, bool isWrite, const Near& near,
                      const std::function<Value*()>& far);
    Nearness nearnessOf(Value* pointer, uint64_t bytes);
    // ---- code by runs (lockstep/runs.cpp) ----
    struct Run {
        std::vector<llvm::Instruction*> members;
        bool reads = false, writes = false; // memory that other lanes may see
        bool admits(const llvm::Instruction& instruction) const;
        void note(const llvm::Instruction& instruction);
    };
    void beginRuns();
    void emitRuns(llvm::BasicBlock& block);
    void emitRun(Run& run);
    void findSlots(llvm::BasicBlock& block);
    bool isOfBlock(const llvm::Instruction& instruction) const; // whether all uses are in the block
    Value* arrayOf(const llvm::Instruction& value);
    Value* ofLane(Value* value, Value* lane);
    void setLane(const llvm::Instruction& value, Value* made, Value* lane);
    void meetByLane(const MeetingPoint& point, uint32_t what);
    void resumeByLane(const MeetingPoint& point);
    void storeOperandsByLane(const MeetingPoint& point);
    void takeResults(const MeetingPoint& point);
    Value* moveShared(const MeetingPoint& point, const char* function, llvm::Type* result,
                      Value* bits);
    Value* callRunTime(const char* name, llvm::Type* result, llvm::ArrayRef<Value*> arguments);
    void moveByLane(const std::vector<std::pair<llvm::PHINode*, Value*>>& moves, Value* mask);

    // ---- addresses (lockstep/addresses.cpp) ----
    // An address of the form base + extended index * scale, with a 32-bit index and a uniform rest:
    // the indices show whether the lanes' addresses are consecutive.
    struct IndexedAddress {
        llvm::CastInst* extension = nullptr;
        uint64_t scale = 1;
        std::vector<llvm::Instruction*> chain; // from the address to the extension
    };
    bool findIndex(Value* address, IndexedAddress& found) const;
    bool isNearPossible(const llvm::Instruction& access) const;
    void findAddresses(llvm::BasicBlock& block);
    Nearness nearnessOf(const IndexedAddress& address, uint64_t bytes);
    Value* addressAt(const IndexedAddress& address, Value* index);
    Value* farAddresses(Value* pointer);
    bool canGather(llvm::Type* type) const;

    const LockstepPlan& plan_;
    llvm::Function& source_;
    llvm::Function& result_;
    const bool hasMasks_, byRuns_;
    llvm::LLVMContext& context_;
    const llvm::DataLayout& layout_;
    llvm::IRBuilder<> builder_;
    llvm::IRBuilder<> top_; // for places, in the first block
    llvm::BasicBlock* entry_ = nullptr;
    std::vector<llvm::BasicBlock*> resumes_; // where lanes continue from each point
    Value* warp_ = nullptr;
    Value* params_ = nullptr;
    Value* threads_ = nullptr;
    Value* frame_ = nullptr;
    llvm::AllocaInst* ran_ = nullptr;
    llvm::AllocaInst* jumps_ = nullptr;       // of addresses, in loops that have a pause
    llvm::AllocaInst* spins_ = nullptr;       // reads of memory that others may write
    const llvm::BasicBlock* block_ = nullptr; // the current block
    Value* mask_ = nullptr;                   // of the current block
    bool isPart_ = false;                     // the code for all lanes together is separate
    llvm::DenseMap<const Value*, IndexedAddress> indexed_; // addresses of the block
    llvm::DenseSet<const Value*> late_;                    // those made only where they are needed
    llvm::DenseMap<const Value*, Value*> here_;            // made in the current block
    llvm::DenseMap<const Value*, Value*> always_;          // made in the prologue
    llvm::DenseMap<const Value*, llvm::AllocaInst*> places_;
    llvm::DenseMap<const llvm::BasicBlock*, llvm::Value*> masks_;
    llvm::Value* maskMemory_ = nullptr; // of all masks, where they stay in memory
    llvm::DenseMap<const Value*, uint32_t> framePlaces_;
    uint32_t frameBytes_ = 0;
    llvm::DenseMap<const Value*, uint64_t> slots_; // in scratch_, of values of the block
    llvm::AllocaInst* scratch_ = nullptr;
    uint64_t scratchBytes_ = 0;
    // Uniform values that live across points: indices into an array, or into the frame by lane.
    llvm::DenseMap<const Value*, unsigned> shared_;
    Value* sharedPlace_ = nullptr;
    uint32_t keptPlace_ = 0;
    bool needsThreads_ = false;
};

} // namespace sunstone::compiler
