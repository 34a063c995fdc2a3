// SPDX-License-Identifier: Apache-2.0
// See programs.h.
#include "compiler/gpu/programs.h"

#include "base/error.h"

#include <llvm/Transforms/Utils/Cloning.h>

#include <algorithm>

namespace sunstone::compiler {

void GpuPrograms::declare() {
    for (const ProgramRequest& program : request_.pipeline.programs) {
        const ptx::Function* source = program.module->tree().findFunction(program.function);
        if (!source || !source->hasBody)
            fail(ErrorCode::kNotFound, "the module has no function \"", program.function, "\"");
        llvm::Function* function = unit_.declare(program.module->tree(), *source);
        const PayloadType* payload =
            program.payloadType < 0
                ? nullptr
                : &program.moduleRules->payloadTypes.at(size_t(program.payloadType));
        const bool isNew = unit_.kinds().emplace(function, program.kind).second;
        if (payload && isNew)
            payloads_[function] = payload;
        if (!isNew) // of another kind, or for another payload type: lowered in another way
            copies_.push_back({functions_.size(), program.kind, payload});
        // External until the dispatchers refer to it; otherwise passes could remove it.
        function->setLinkage(llvm::GlobalValue::ExternalLinkage);
        functions_.push_back(function);
    }
}

void GpuPrograms::copyShared() {
    for (const Copy& copy : copies_) {
        llvm::Function* original = functions_[copy.program];
        llvm::ValueToValueMapTy map;
        llvm::Function* function = llvm::CloneFunction(original, map);
        unit_.kinds()[function] = copy.kind;
        unit_.facts()[function] = unit_.facts().at(original);
        if (copy.payload)
            payloads_[function] = copy.payload;
        functions_[copy.program] = function;
    }
}

bool GpuPrograms::haveLongIntersections() const {
    constexpr unsigned kShort = 110; // LLVM instructions (docs/notes/programs-gpu.md)
    return std::ranges::any_of(functions_, [&](llvm::Function* function) {
        return unit_.kinds().at(function) == ProgramKind::kIntersection &&
               function->getInstructionCount() > kShort;
    });
}

std::vector<llvm::Function*> GpuPrograms::mainsOf(devlib::GroupKind kind) const {
    std::vector<llvm::Function*> mains;
    for (const GpuGroup& group : request_.groups) {
        const size_t index = group.programs[devlib::kRoleMain];
        if (group.kind != kind || index == GpuGroup::kNone)
            continue;
        if (std::find(mains.begin(), mains.end(), functions_[index]) == mains.end())
            mains.push_back(functions_[index]);
    }
    return mains;
}

} // namespace sunstone::compiler
