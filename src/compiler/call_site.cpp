// SPDX-License-Identifier: Apache-2.0
#include "compiler/call_site.h"

#include <llvm/IR/Constants.h>

namespace sunstone::compiler {

namespace {

constexpr const char* kKind = "sunstone.site";

uint32_t numberOf(const llvm::MDNode& node, unsigned operand) {
    const auto* number = llvm::mdconst::dyn_extract<llvm::ConstantInt>(node.getOperand(operand));
    return number ? uint32_t(number->getZExtValue()) : 0;
}

} // namespace

std::string sourcePlace(Unit& unit, const ptx::Module& module,
                        const ptx::Instruction& instruction) {
    const ptx::SourcePosition& at = instruction.source;
    if (!unit.hasLineInfo(module) || at.line == 0 || at.file >= module.files.size() ||
        module.files[at.file].empty())
        return {};
    std::string text = message(module.files[at.file], ":", at.line);
    return at.column ? message(text, ":", at.column) : text;
}

void setCallSite(Unit& unit, llvm::CallInst& call, const ptx::Module& module,
                 const ptx::Instruction& instruction) {
    llvm::LLVMContext& context = unit.context();
    const auto number = [&](uint32_t value) {
        return llvm::ConstantAsMetadata::get(
            llvm::ConstantInt::get(llvm::Type::getInt32Ty(context), value));
    };
    call.setMetadata(
        kKind, llvm::MDNode::get(context, {number(instruction.location.line),
                                           number(unit.moduleNumber(module)),
                                           llvm::MDString::get(
                                               context, sourcePlace(unit, module, instruction))}));
}

CallSite callSite(Unit& unit, const llvm::Instruction& call) {
    CallSite site;
    if (const llvm::MDNode* node = call.getMetadata(kKind)) {
        site.line = numberOf(*node, 0);
        site.rules = &unit.moduleRules(numberOf(*node, 1));
        site.source = llvm::cast<llvm::MDString>(node->getOperand(2))->getString();
    }
    return site;
}

} // namespace sunstone::compiler
