// SPDX-License-Identifier: Apache-2.0
// The programs of a GPU pipeline as functions of its LLVM module.
#pragma once

#include "compiler/gpu/pipeline.h"
#include "compiler/translate/unit.h"

namespace sunstone::compiler {

class GpuPrograms {
public:
    GpuPrograms(const GpuPipelineRequest& request, Unit& unit) : request_(request), unit_(unit) {}

    // Declares the programs and queues them for translation.
    void declare();
    // Copies functions that are programs of several kinds, as the classic API allows, or that are
    // used with several payload types. Afterwards code may depend on kind and type.
    void copyShared();

    const ProgramPayloads& payloads() const { return payloads_; }
    // By index in the request.
    std::vector<llvm::Function*>& functions() { return functions_; }
    const std::vector<llvm::Function*>& functions() const { return functions_; }
    // Whether an intersection program takes longer than the test of a node. Before lowering.
    bool haveLongIntersections() const;
    // The main programs of groups of this kind, each once.
    std::vector<llvm::Function*> mainsOf(devlib::GroupKind kind) const;

private:
    struct Copy {
        size_t program;
        ProgramKind kind;
        const PayloadType* payload;
    };
    const GpuPipelineRequest& request_;
    Unit& unit_;
    ProgramPayloads payloads_;
    std::vector<llvm::Function*> functions_;
    std::vector<Copy> copies_;
};

} // namespace sunstone::compiler
