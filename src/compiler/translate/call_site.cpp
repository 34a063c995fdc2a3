// SPDX-License-Identifier: Apache-2.0
// See call_site.h.
#include "compiler/translate/call_site.h"

#include <llvm/IR/Constants.h>

namespace sunstone::compiler {

namespace {

constexpr const char* kKind = "sunstone.site";

uint32_t numberOf(const llvm::MDNode& node, unsigned operand) {
    const auto* number = llvm::mdconst::dyn_extract<llvm::ConstantInt>(node.getOperand(operand));
    return number ? uint32_t(number->getZExtValue()) : 0;
}

bool isKnown(const ptx::Module& module, const ptx::SourcePosition& at) {
    return at.line != 0 && at.file < module.files.size() && !module.files[at.file].empty();
}

// Headers of device functions: optix_7_device_impl.h and the like, those of include/cuda and of a
// toolkit.
bool isApiHeader(std::string_view file) {
    const std::string_view name = file.substr(file.find_last_of('/') + 1);
    if (name.starts_with("optix") && name.find("device") != std::string_view::npos)
        return true;
    return file.find("/cuda/sunstone/") != std::string_view::npos ||
           name.ends_with("_atomic_functions.hpp") || name.ends_with("_intrinsics.hpp");
}

} // namespace

std::string sourcePlace(Unit& unit, const FunctionFacts& caller,
                        const ptx::Instruction& instruction) {
    const ptx::Module& module = *caller.module;
    ptx::SourcePosition at = instruction.source;
    if (!unit.hasLineInfo(module) || !isKnown(module, at))
        return {};
    if (isApiHeader(module.files[at.file]))
        for (const ptx::Statement& statement : caller.function->body) {
            if (&statement.instruction == &instruction)
                break;
            const ptx::SourcePosition& before = statement.instruction.source;
            if (statement.kind == ptx::StatementKind::kInstruction && isKnown(module, before) &&
                !isApiHeader(module.files[before.file]))
                at = before;
        }
    std::string text = message(module.files[at.file], ":", at.line);
    return at.column ? message(text, ":", at.column) : text;
}

std::string placeIn(Unit& unit, const FunctionFacts& function,
                    const ptx::Instruction& instruction) {
    const std::string place = sourcePlace(unit, function, instruction);
    return message(", in ", function.function->name, place.empty() ? "" : ", at ", place);
}

void setCallSite(Unit& unit, llvm::CallInst& call, const FunctionFacts& caller,
                 const ptx::Instruction& instruction, const std::string& source) {
    llvm::LLVMContext& context = unit.context();
    const auto number = [&](uint32_t value) {
        return llvm::ConstantAsMetadata::get(
            llvm::ConstantInt::get(llvm::Type::getInt32Ty(context), value));
    };
    call.setMetadata(kKind, llvm::MDNode::get(context, {number(instruction.location.line),
                                                        number(unit.moduleNumber(*caller.module)),
                                                        llvm::MDString::get(context, source)}));
}

CallSite callSite(Unit& unit, const llvm::Instruction& call) {
    static const ModuleRules none;
    CallSite site;
    site.rules = &none;
    if (const llvm::MDNode* node = call.getMetadata(kKind)) {
        site.line = numberOf(*node, 0);
        site.rules = &unit.moduleRules(numberOf(*node, 1));
        site.source = llvm::cast<llvm::MDString>(node->getOperand(2))->getString();
    }
    return site;
}

} // namespace sunstone::compiler
