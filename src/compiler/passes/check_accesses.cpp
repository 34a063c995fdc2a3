// SPDX-License-Identifier: Apache-2.0
// See check_accesses.h.
#include "compiler/passes/check_accesses.h"

#include "devlib/abi.h"

#include <llvm/Analysis/ValueTracking.h>
#include <llvm/IR/Constants.h>
#include <llvm/IR/IRBuilder.h>
#include <llvm/IR/InstIterator.h>

#include <bit>
#include <optional>

namespace sunstone::compiler {

namespace {

constexpr const char* kKind = "sunstone.access";
constexpr const char* kKernelCheck = "sunstone_check_kernel";
constexpr const char* kProgramCheck = "sunstone_check_program";
enum Field : unsigned { kNumber, kBytes, kVerb, kSpace, kLine, kOffset, kFunction, kPlace };

uint64_t numberOf(const llvm::MDNode& node, Field field) {
    return llvm::mdconst::extract<llvm::ConstantInt>(node.getOperand(field))->getZExtValue();
}

llvm::Value* pointerOf(llvm::Instruction& access) {
    if (auto* load = llvm::dyn_cast<llvm::LoadInst>(&access))
        return load->getPointerOperand();
    if (auto* store = llvm::dyn_cast<llvm::StoreInst>(&access))
        return store->getPointerOperand();
    if (auto* change = llvm::dyn_cast<llvm::AtomicRMWInst>(&access))
        return change->getPointerOperand();
    if (auto* call = llvm::dyn_cast<llvm::CallInst>(&access)) // an atomic function of the run-time
        return call->getArgOperand(0);
    return llvm::cast<llvm::AtomicCmpXchgInst>(access).getPointerOperand();
}

// The variable from which an address was computed.
struct Object {
    llvm::Value* base = nullptr;
    uint64_t bytes = 0;
};

std::optional<Object> objectOf(llvm::Value* pointer, const llvm::DataLayout& layout) {
    const llvm::Value* base = llvm::getUnderlyingObject(pointer, 0);
    if (const auto* memory = llvm::dyn_cast<llvm::AllocaInst>(base)) {
        const auto bytes = memory->getAllocationSize(layout);
        if (bytes && !bytes->isScalable())
            return Object{const_cast<llvm::Value*>(base), bytes->getFixedValue()};
    } else if (const auto* variable = llvm::dyn_cast<llvm::GlobalVariable>(base)) {
        return Object{const_cast<llvm::Value*>(base),
                      layout.getTypeAllocSize(variable->getValueType())};
    }
    return std::nullopt;
}

// Whether the access is known to be inside its object, and aligned.
bool isFine(llvm::Value* pointer, const Object& object, uint64_t offset, uint64_t bytes,
            const llvm::DataLayout& layout) {
    llvm::APInt constant(64, 0);
    if (pointer->stripAndAccumulateConstantOffsets(layout, constant, true) != object.base)
        return false;
    const int64_t begin = constant.getSExtValue() - int64_t(offset);
    return begin >= 0 && uint64_t(begin) + bytes <= object.bytes &&
           uint64_t(begin) % std::bit_floor(bytes) == 0 &&
           object.base->getPointerAlignment(layout).value() >= std::bit_floor(bytes);
}

class Instrumenter {
public:
    Instrumenter(llvm::Module& module, bool isKernels)
        : module_(module), layout_(module.getDataLayout()), context_(module.getContext()) {
        auto* pointer = llvm::PointerType::getUnqual(context_);
        auto* word = llvm::Type::getInt64Ty(context_);
        check_ = module.getOrInsertFunction(
            isKernels ? kKernelCheck : kProgramCheck,
            llvm::FunctionType::get(llvm::Type::getVoidTy(context_),
                                    {pointer, word, pointer, word, word}, false));
        llvm::cast<llvm::Function>(check_.getCallee())->addFnAttr(llvm::Attribute::NoUnwind);
    }

    void instrument(llvm::Instruction& access) {
        llvm::MDNode* node = access.getMetadata(kKind);
        access.setMetadata(kKind, nullptr);
        // The parts of a vector access are consecutive; the first remaining one is checked for all.
        const uint64_t number = numberOf(*node, kNumber);
        if (number == lastNumber_ && access.getParent() == lastBlock_)
            return;
        lastNumber_ = number;
        lastBlock_ = access.getParent();

        llvm::Value* pointer = pointerOf(access);
        const uint64_t offset = numberOf(*node, kOffset), bytes = numberOf(*node, kBytes);
        const std::optional<Object> object = objectOf(pointer, layout_);
        if (object && isFine(pointer, *object, offset, bytes, layout_))
            return;
        llvm::IRBuilder<> builder(&access);
        llvm::Type* word = builder.getInt64Ty();
        llvm::Value* address =
            builder.CreateSub(builder.CreatePtrToInt(pointer, word), builder.getInt64(offset));
        llvm::Value* base = builder.getInt64(0);
        if (object)
            base = builder.CreatePtrToInt(object->base, word);
        builder.CreateCall(check_, {access.getFunction()->getArg(0), address, description(*node),
                                    base, builder.getInt64(object ? object->bytes : 0)});
    }

private:
    llvm::Constant* text(const llvm::MDNode& node, Field field) {
        const llvm::StringRef string =
            llvm::cast<llvm::MDString>(node.getOperand(field))->getString();
        llvm::Constant*& made = texts_[string.str()];
        if (!made)
            made = constant(llvm::ConstantDataArray::getString(context_, string));
        return made;
    }

    llvm::GlobalVariable* constant(llvm::Constant* value) {
        auto* variable = new llvm::GlobalVariable(module_, value->getType(), true,
                                                  llvm::GlobalValue::PrivateLinkage, value);
        variable->setDSOLocal(true);
        return variable;
    }

    // A devlib::AccessPlace.
    llvm::Constant* description(const llvm::MDNode& node) {
        llvm::Constant*& made = descriptions_[&node];
        if (made)
            return made;
        const auto number = [&](unsigned bits, uint64_t value) {
            return llvm::ConstantInt::get(llvm::Type::getIntNTy(context_, bits), value);
        };
        using devlib::AccessPlace;
        static_assert(sizeof(AccessPlace) == 32 && offsetof(AccessPlace, line) == 8 &&
                      offsetof(AccessPlace, ptxLine) == 16 && offsetof(AccessPlace, bytes) == 20 &&
                      offsetof(AccessPlace, kind) == 24 && offsetof(AccessPlace, space) == 25);
        llvm::Constant* fields[] = {text(node, kFunction),
                                    text(node, kPlace),
                                    number(32, numberOf(node, kLine)),
                                    number(32, numberOf(node, kBytes)),
                                    number(8, numberOf(node, kVerb)),
                                    number(8, numberOf(node, kSpace)),
                                    number(48, 0)};
        return made = constant(llvm::ConstantStruct::getAnon(context_, fields, true));
    }

    llvm::Module& module_;
    const llvm::DataLayout& layout_;
    llvm::LLVMContext& context_;
    llvm::FunctionCallee check_;
    std::map<std::string, llvm::Constant*> texts_;
    std::map<const llvm::MDNode*, llvm::Constant*> descriptions_;
    uint64_t lastNumber_ = ~uint64_t(0);
    const llvm::BasicBlock* lastBlock_ = nullptr;
};

} // namespace

void markAccess(llvm::Instruction& access, const AccessMark& mark, uint32_t offset) {
    llvm::LLVMContext& context = access.getContext();
    const auto number = [&](uint32_t value) {
        return llvm::ConstantAsMetadata::get(
            llvm::ConstantInt::get(llvm::Type::getInt32Ty(context), value));
    };
    access.setMetadata(
        kKind,
        llvm::MDNode::get(context, {number(mark.number), number(mark.bytes), number(mark.kind),
                                    number(mark.space), number(mark.ptxLine), number(offset),
                                    llvm::MDString::get(context, mark.function),
                                    llvm::MDString::get(context, mark.place)}));
}

llvm::PreservedAnalyses CheckAccessesPass::run(llvm::Module& module, llvm::ModuleAnalysisManager&) {
    std::vector<llvm::Instruction*> accesses;
    for (llvm::Function& function : module)
        for (llvm::Instruction& instruction : llvm::instructions(function))
            if (instruction.getMetadata(kKind))
                accesses.push_back(&instruction);
    if (accesses.empty())
        return llvm::PreservedAnalyses::all();
    Instrumenter instrumenter(module, isKernels);
    for (llvm::Instruction* access : accesses)
        instrumenter.instrument(*access);
    return llvm::PreservedAnalyses::none();
}

bool isAccessCheck(const llvm::Instruction& instruction) {
    const auto* call = llvm::dyn_cast<llvm::CallInst>(&instruction);
    const llvm::Function* callee = call ? call->getCalledFunction() : nullptr;
    return callee && (callee->getName() == kKernelCheck || callee->getName() == kProgramCheck);
}

} // namespace sunstone::compiler
