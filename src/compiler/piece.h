// SPDX-License-Identifier: Apache-2.0
// Compiles one piece of a pipeline: a program with its call graph, or the variables that programs
// share. A piece depends only on its request, so it can be stored. `keyOf` returns a digest of the
// request, of this build and of the processor.
#pragma once

#include "compiler/compiler.h"
#include "compiler/store/code_object.h"

namespace sunstone::compiler {

struct PieceRequest {
    std::vector<const Source*> modules; // searched for symbols
    const Flavor* flavor = nullptr; // null: OptiX 7
    PipelineRules rules;
    OptLevel optLevel = OptLevel::k3;
    DebugLevel debugLevel = DebugLevel::kMinimal;
    // Either a program (index of its module, name of its function) ...
    uint32_t module = 0;
    std::string function;
    ProgramKind kind = ProgramKind::kNone;
    int payloadType = -1; // that the program is compiled for, among its module's; -1: untyped
    // Options of the modules, in their order; missing and null ones: none.
    std::vector<std::shared_ptr<const ModuleRules>> moduleRules;
    // ... or variables to define.
    std::vector<VariableId> variables;
};

// Symbol of the program in the piece's object code.
std::string programSymbol(const PieceRequest& request);

CodeObject compilePiece(const PieceRequest& request);

// Compiles until all operands that must be constant are known to be constant and in range.
void checkPiece(const PieceRequest& request);

// The bound values of all modules, one after the other, in the order of CodeObject::boundLoads.
std::vector<BoundValue> boundValuesOf(const PieceRequest& request);

std::string keyOf(const PieceRequest& request);

// Reads a piece from the store (may be null). False if the store has no value or an unreadable one.
// Needs no tree.
bool findPiece(const PieceRequest& request, ObjectStore* store, CodeObject& object);

// Compiles the piece and stores it.
CodeObject makePiece(const PieceRequest& request, ObjectStore* store);

} // namespace sunstone::compiler
