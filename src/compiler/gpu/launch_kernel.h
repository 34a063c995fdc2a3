// SPDX-License-Identifier: Apache-2.0
// The kernel of a GPU pipeline: the choice among the run-time's three kernels, the programs that
// are cut for it, and its memory.
#pragma once

#include "compiler/gpu/machine.h"
#include "compiler/gpu/programs.h"
#include "compiler/gpu/ray_states.h"
#include "compiler/gpu/resumable.h"

#include <llvm/IR/ValueHandle.h>

namespace sunstone::compiler {

class LaunchKernel {
public:
    LaunchKernel(const GpuPipelineRequest& request, Unit& unit, llvm::TargetMachine& machine,
                 const GpuPrograms& programs)
        : request_(request), unit_(unit), machine_(machine), programs_(programs) {}

    // Chooses the kernel and cuts programs for it. Returns log lines with the choice and its
    // reason.
    std::string choose();
    // Whether there is no kernel, but dispatchers and programs for one (GpuPart).
    bool isApart() const;
    // Functions of this name are in the kernel's part, for all parts.
    static bool isOfKernel(llvm::StringRef name);
    // Whether the programs must compile together with their kernel.
    bool refuses() const { return refuses_; }
    const CutPrograms& cuts() const { return cuts_; }
    // Whether closest-hit or miss programs trace and are cut at their traces.
    bool recurses() const { return kind_ == Kind::kNested; }
    // Whether warps take new launch indices as their rays end.
    bool takesTurns() const { return kind_ != Kind::kPlain; }
    // Whether all warps of a block traverse in step.
    bool walksInStep() const;
    // Defines the kernel, which calls a function of the run-time.
    void make();
    // Makes the kernel the only visible function of the linked module.
    void hideOthers();
    // Kernels that traverse in step keep O3: with O1 one ended with an illegal instruction, for an
    // unknown reason.
    GpuEffort effort() const { return walksInStep() ? GpuEffort::kMuch : GpuEffort::kLittle; }
    // Call after optimisation. Folds the states of rays in the kernel's memory into registers.
    void foldStates();
    // Gives the states their final layout and place. Returns the bytes that a warp claims for
    // states outside local memory (devlib/gpu/lane_memory.h), or 0.
    uint64_t placeStates();
    // Replaces the functions of LaunchConstants by the kernel's arguments, which GPUs read without
    // a load.
    void defineConstants();

private:
    // Kernels of devlib/gpu: run.h, loop.h, nested.h.
    enum class Kind : uint8_t { kPlain, kLoop, kNested };

    const char* entry() const; // the run-time's function that the kernel calls
    // Whether the pipeline is compiled in parts, and states of rays are in lane memory.
    bool isDeepPart() const;
    bool overflows() const; // the pipeline has stack overflow exceptions
    // Whether the pipeline allows the kernel of devlib/gpu/nested.h.
    bool mayNest() const;
    // All programs that trace, for that kernel. It is used if closest-hit or miss programs trace,
    // ray generation programs trace several rays in graphs with instances, or `nests`, and no
    // obstacle prevents it; `reason` receives the obstacle.
    std::vector<llvm::Function*> programsToNest(bool nests, std::string& reason);
    std::string chooseSimple();
    std::string cutApart(); // for isApart()
    // Why a program that traces cannot be cut, or empty.
    std::string obstacleIn(llvm::Function& program) const;
    void decideLaneMemory(bool has);  // sets the result of kHasLaneMemory
    StateUses::Arrays states() const; // all, or none if LLVM has removed some
    uint64_t claimLaneMemory(llvm::AllocaInst& states, uint64_t count, uint64_t bytes);

    const GpuPipelineRequest& request_;
    Unit& unit_;
    llvm::TargetMachine& machine_;
    const GpuPrograms& programs_;
    Kind kind_ = Kind::kPlain;
    bool refuses_ = false;
    bool raysTrace_ = false; // closest-hit or miss programs trace
    CutPrograms cuts_;
    // The kernel's memory for states of rays and frames of programs: first the near part, then the
    // far part if there are many depths.
    std::vector<llvm::WeakTrackingVH> states_, frames_;
};

} // namespace sunstone::compiler
