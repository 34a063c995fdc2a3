// SPDX-License-Identifier: Apache-2.0
// Programs cut at their traces, for the loops that keep the lanes of a GPU's warps busy
// (devlib/gpu/loop.h, nested.h): `start` runs a program to its first trace, `resume` from a trace
// to the next. Both ask for a ray by filling its state and setting `asks`. LLVM's coroutine passes
// cut the programs and keep values that live across a trace in a frame. The ray states are not in
// the frame, so that LLVM can keep the states of loop.h in registers.
#pragma once

#include <llvm/IR/Module.h>
#include <llvm/Target/TargetMachine.h>

#include <map>
#include <string>
#include <vector>

namespace sunstone::compiler {

struct Cut {
    // void(frame, RayState* state, RayState* ray, uint32_t* asks)
    llvm::Function *start = nullptr, *resume = nullptr;
};

constexpr unsigned kFrameAlignment = 16;

struct CutPrograms {
    std::map<llvm::Function*, Cut> cuts; // by program; the program loses its body
    uint64_t frameBytes = 0;             // the largest frame's
};

// The functions of a module with lowered calls that trace, in module order.
std::vector<llvm::Function*> tracingFunctions(llvm::Module& module);

// Whether the program, with lowered calls, traces at one place, repeatedly.
bool tracesInLoop(const llvm::Function& program);
// Whether it traces at one place, which is in no loop.
bool tracesOnce(const llvm::Function& program);

// The reason why the program cannot be cut, or empty. Its module must not depend on which lanes of
// a warp run together.
std::string obstacleToCut(const llvm::Function& program);

// Inlines the traversal into these programs if they trace at few places: two in one program, `most`
// in all.
void traceInline(const std::vector<llvm::Function*>& programs, size_t most);

// Cuts those programs, uint32_t(RayState*) with lowered calls, that trace and have no obstacle.
CutPrograms cutAtTraces(llvm::Module& module, llvm::TargetMachine& machine,
                        const std::vector<llvm::Function*>& programs);

} // namespace sunstone::compiler
