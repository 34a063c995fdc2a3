// SPDX-License-Identifier: Apache-2.0
// See state_uses.h.
#include "compiler/gpu/state_uses.h"

#include "compiler/gpu/calls_by_address.h"

#include <llvm/IR/InstIterator.h>
#include <llvm/IR/IntrinsicInst.h>
#include <llvm/IR/Module.h>

namespace sunstone::compiler {

using llvm::Value;

StateUses::StateUses(Arrays all)
    : arrays(std::move(all)), layout_(kernel().getParent()->getDataLayout()) {}

bool StateUses::collect() {
    listCalls();
    Queue queue(arrays.begin(), arrays.end());
    for (llvm::AllocaInst* array : arrays)
        places.emplace(array, Place());
    while (!queue.empty()) {
        Value* const pointer = queue.back();
        queue.pop_back();
        for (llvm::User* user : pointer->users()) {
            auto* const instruction = llvm::dyn_cast<llvm::Instruction>(user);
            if (!instruction || !use(*instruction, *pointer, queue))
                return false;
        }
    }
    for (const auto& [pointer, place] : places)
        if (llvm::isa<llvm::PHINode, llvm::SelectInst>(pointer) &&
            !operandsAgree(llvm::cast<llvm::User>(*pointer), place))
            return false;
    return argumentsAgree();
}

void StateUses::listCalls() {
    for (llvm::Function& function : *kernel().getParent()) {
        if (function.hasAddressTaken())
            byAddress_.push_back(&function);
        for (llvm::Instruction& each : llvm::instructions(function))
            if (auto* call = llvm::dyn_cast<llvm::CallBase>(&each))
                if (call->isIndirectCall())
                    indirectCalls_.push_back(call);
    }
}

bool StateUses::use(llvm::Instruction& user, Value& pointer, Queue& queue) {
    const Place place = places.at(&pointer);
    if (auto* load = llvm::dyn_cast<llvm::LoadInst>(&user)) {
        loads.emplace(load, Range());
        return load->isSimple() && rangeOf(place, load->getType(), loads[load]);
    }
    if (auto* store = llvm::dyn_cast<llvm::StoreInst>(&user)) {
        Value* const value = store->getValueOperand();
        return value != &pointer && store->isSimple() &&
               rangeOf(place, value->getType(), stores[store]);
    }
    if (auto* fill = llvm::dyn_cast<llvm::MemSetInst>(&user)) {
        const auto* length = llvm::dyn_cast<llvm::ConstantInt>(fill->getLength());
        if (fill->isVolatile() || !length || place.isIndexed ||
            place.offset + length->getZExtValue() > kBytes)
            return false;
        stores[fill] = {place.offset, place.offset + length->getZExtValue()};
        return true;
    }
    if (auto* step = llvm::dyn_cast<llvm::GEPOperator>(&user)) {
        Place moved;
        return move(place, *step, moved) && reach(user, moved, queue);
    }
    if (llvm::isa<llvm::PHINode, llvm::SelectInst>(user))
        return reach(user, place, queue);
    if (auto* call = llvm::dyn_cast<llvm::CallBase>(&user);
        call && !llvm::isa<llvm::IntrinsicInst>(call))
        return pass(*call, pointer, queue);
    return llvm::isa<llvm::ICmpInst, llvm::LifetimeIntrinsic>(user);
}

// Follows the pointer into all possible callees.
bool StateUses::pass(llvm::CallBase& call, Value& pointer, Queue& queue) {
    if (call.isInlineAsm() || call.getCalledOperand() == &pointer)
        return false;
    std::vector<llvm::Function*> callees;
    if (call.isIndirectCall())
        llvm::copy_if(byAddress_, std::back_inserter(callees),
                      [&](llvm::Function* function) { return mayCall(call, *function); });
    else if (!call.getCalledFunction())
        return false;
    else
        callees = {call.getCalledFunction()};
    for (unsigned i = 0; i < call.arg_size(); ++i) {
        if (call.getArgOperand(i) != &pointer)
            continue;
        if (call.isByValArgument(i))
            return false;
        for (llvm::Function* callee : callees) {
            if (i >= callee->arg_size() || !callee->getArg(i)->getType()->isPointerTy()) {
                if (call.isIndirectCall()) // of another type: not called here
                    continue;
                return false;
            }
            if (callee->isDeclaration() || !reach(*callee->getArg(i), places.at(&pointer), queue))
                return false;
        }
    }
    return true;
}

bool StateUses::rangeOf(const Place& place, llvm::Type* type, Range& range) const {
    const uint64_t size = layout_.getTypeStoreSize(type).getFixedValue();
    range = place.isIndexed ? Range{kList, kListEnd} : Range{place.offset, place.offset + size};
    return range.end <= kBytes;
}

bool StateUses::stepOf(const llvm::GEPOperator& step, Step& result) const {
    const unsigned bits = layout_.getIndexTypeSizeInBits(step.getType());
    llvm::APInt constant(bits, 0);
    if (!step.collectOffset(layout_, bits, result.variable, constant))
        return false;
    result.constant = constant.getSExtValue();
    return true;
}

bool StateUses::move(Place place, const llvm::GEPOperator& step, Place& result) const {
    Step bytes;
    if (!stepOf(step, bytes))
        return false;
    for (const auto& [value, scale] : bytes.variable)
        if (scale.srem(int64_t(kBytes)) != 0) {
            if (!place.isIndexed && (place.offset < kList || place.offset >= kListEnd))
                return false;
            place.isIndexed = true;
        }
    if (!place.isIndexed) {
        const int64_t offset = int64_t(place.offset) + bytes.constant;
        place.offset = uint64_t((offset % int64_t(kBytes) + int64_t(kBytes)) % int64_t(kBytes));
    }
    if (place.isIndexed)
        place.offset = kList;
    result = place;
    return true;
}

bool StateUses::reach(Value& pointer, const Place& place, Queue& queue) {
    const auto [known, isNew] = places.emplace(&pointer, place);
    if (isNew)
        queue.push_back(&pointer);
    return known->second == place;
}

bool StateUses::agrees(const Value& operand, const Place& place) const {
    if (llvm::isa<llvm::UndefValue>(operand)) // poison, too
        return true;
    const auto known = places.find(const_cast<Value*>(&operand));
    return known != places.end() && known->second == place;
}

// Whether all inputs of a phi or select lead to states.
bool StateUses::operandsAgree(const llvm::User& user, const Place& place) const {
    for (const Value* operand : user.operands())
        if (operand->getType()->isPointerTy() && !agrees(*operand, place))
            return false;
    return true;
}

// Whether all callers of a function with a state parameter pass states.
bool StateUses::argumentsAgree() const {
    for (const auto& [pointer, place] : places) {
        const auto* argument = llvm::dyn_cast<llvm::Argument>(pointer);
        if (!argument || argument->use_empty())
            continue;
        const unsigned number = argument->getArgNo();
        for (const llvm::User* user : argument->getParent()->users()) {
            const auto* call = llvm::dyn_cast<llvm::CallBase>(user);
            if (call && call->getCalledFunction() == argument->getParent() &&
                !agrees(*call->getArgOperand(number), place))
                return false;
        }
        if (!argument->getParent()->hasAddressTaken())
            continue;
        for (const llvm::CallBase* call : indirectCalls_)
            if (mayCall(*call, *argument->getParent()) && number < call->arg_size() &&
                call->getArgOperand(number)->getType()->isPointerTy() &&
                !agrees(*call->getArgOperand(number), place))
                return false;
    }
    return true;
}

} // namespace sunstone::compiler
