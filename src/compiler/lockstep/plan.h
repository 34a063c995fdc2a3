// SPDX-License-Identifier: Apache-2.0
// Analysis of a kernel for its 32-lane code: where threads meet, which values are uniform, the
// order of the blocks, and the values live across meeting points.
#pragma once

#include "compiler/runtime/lane_functions.h"

#include <llvm/ADT/DenseMap.h>
#include <llvm/ADT/DenseSet.h>
#include <llvm/ADT/MapVector.h>
#include <llvm/Analysis/LoopInfo.h>
#include <llvm/Analysis/PostDominators.h>
#include <llvm/IR/Dominators.h>
#include <llvm/IR/Instructions.h>

#include <string>
#include <vector>

namespace sunstone::compiler {

// The called run-time function, even if the call goes through the processor's default mode
// (flush.h); null for other calls.
llvm::Function* calleeOf(const llvm::CallBase& call);

// Whether the instruction reads the mask of active lanes, which is equal for all lanes that read it
// together.
bool asksForLanes(const llvm::Instruction& instruction);

struct MeetingPoint {
    llvm::CallInst* call = nullptr; // alone in its block, except for the branch
    llvm::BasicBlock* next = nullptr;
    uint32_t kind = 0, mode = 0;          // devlib::LockstepKind; ~0: the mode is not constant
    std::vector<llvm::Instruction*> live; // live after it, except its own result
};

// A block, or a loop of such steps whose first block is the head.
struct Step {
    llvm::BasicBlock* block = nullptr;
    const llvm::Loop* loop = nullptr;
    std::vector<Step> body;
};

class LockstepPlan {
public:
    // `function`: a copy of the kernel, which is changed: calls of meeting points get blocks of
    // their own.
    explicit LockstepPlan(llvm::Function& function) : function_(function) {}

    // Call endThreads() first. Passes must then simplify loops and turn switches into branches
    // before `analyze`, which returns false, with a reason, for kernels without lockstep code.
    void endThreads();
    bool analyze();
    const std::string& reason() const { return reason_; }

    llvm::Function& function() const { return function_; }
    const std::vector<MeetingPoint>& points() const { return points_; }
    const std::vector<Step>& steps() const { return steps_; }
    const llvm::LoopInfo& loops() const { return loops_; }
    // Whether all lanes that run together have the same value.
    bool isUniform(const llvm::Value* value) const { return !varying_.contains(value); }
    // Instructions computed at every entry from values that a warp always has, so they are never
    // live across points.
    const std::vector<llvm::Instruction*>& prologue() const { return prologue_; }
    bool isInPrologue(const llvm::Value* value) const { return inPrologue_.contains(value); }
    // Whether inactive lanes still need the value: it is used after its loop.
    bool outlivesLoop(const llvm::Instruction& instruction) const;
    const MeetingPoint* pointAt(const llvm::BasicBlock* block) const;

    // Whether the block belongs to a loop that has a pause.
    bool pauses(const llvm::BasicBlock& block) const;

    // Whether the loop is one block, except for the pause.
    bool isSimpleLoop(const llvm::Loop& loop) const;

    // Offset of a field of KernelThread that a load reads, or -1.
    int fieldOf(const llvm::Instruction& instruction) const;

private:
    bool check();
    void addPauses();
    void split();
    void findStructure();
    void findUniform();
    bool varies(const llvm::Instruction& instruction) const;
    void addDivergence(const llvm::BasicBlock& block);
    bool isDivergentLoop(const llvm::Loop& loop) const;
    void order(const llvm::Loop* loop, std::vector<Step>& steps);
    void findPrologue();
    void findLive();
    bool refuse(std::string reason) {
        reason_ = std::move(reason);
        return false;
    }

    llvm::Function& function_;
    std::string reason_;
    std::vector<MeetingPoint> points_;
    llvm::DominatorTree dominators_;
    llvm::PostDominatorTree postDominators_;
    llvm::LoopInfo loops_;
    llvm::DenseSet<const llvm::Value*> varying_;
    llvm::DenseSet<const llvm::BasicBlock*> divergentBranches_;
    llvm::DenseSet<const llvm::BasicBlock*> joins_;    // where lanes join from several paths
    llvm::DenseSet<const llvm::Loop*> divergentLoops_; // that lanes leave at different times
    llvm::DenseMap<const llvm::BasicBlock*, const MeetingPoint*> pointOf_;
    std::vector<Step> steps_;
    std::vector<llvm::Instruction*> prologue_;
    llvm::DenseSet<const llvm::Value*> inPrologue_;
};

} // namespace sunstone::compiler
