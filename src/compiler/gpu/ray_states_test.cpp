// SPDX-License-Identifier: Apache-2.0
// foldRayStates and packRayStates on small kernels: removed and remaining loads and stores, and the
// places of fields.
#include "compiler/gpu/ray_states.h"

#include "devlib/abi.h"

#include <gtest/gtest.h>
#include <llvm/IR/IRBuilder.h>
#include <llvm/IR/Module.h>
#include <llvm/IR/Verifier.h>
#include <llvm/Support/raw_ostream.h>

namespace sunstone::compiler {
namespace {

using devlib::RayState;

// void kernel(ptr launch, i64 depth, ptr out), with states of four rays.
struct Kernel {
    Kernel() : module("test", context), builder(context) {
        llvm::Type* const pointer = builder.getPtrTy();
        function = llvm::Function::Create(
            llvm::FunctionType::get(builder.getVoidTy(), {pointer, builder.getInt64Ty(), pointer},
                                    false),
            llvm::GlobalValue::ExternalLinkage, "kernel", module);
        builder.SetInsertPoint(llvm::BasicBlock::Create(context, "", function));
        states =
            builder.CreateAlloca(llvm::ArrayType::get(builder.getInt8Ty(), 4 * sizeof(RayState)));
    }

    // A field of the ray at a depth, or of the ray one level below.
    llvm::Value* field(uint64_t offset, bool below = false) {
        llvm::Value* const state =
            builder.CreateGEP(llvm::ArrayType::get(builder.getInt8Ty(), sizeof(RayState)), states,
                              function->getArg(1));
        return builder.CreateConstGEP1_64(builder.getInt8Ty(), state,
                                          offset + (below ? sizeof(RayState) : 0));
    }
    void store(llvm::Value* value, uint64_t offset, bool below = false) {
        builder.CreateStore(value, field(offset, below));
    }
    llvm::Value* load(llvm::Type* type, uint64_t offset) {
        return builder.CreateLoad(type, field(offset));
    }
    // Stores a value in the output, which keeps it alive.
    void show(llvm::Value* value) {
        shown.push_back(builder.CreateStore(value, function->getArg(2)));
    }

    bool fold() {
        builder.CreateRetVoid();
        EXPECT_FALSE(llvm::verifyFunction(*function, &llvm::errs()));
        const bool changed = foldRayStates({states});
        EXPECT_FALSE(llvm::verifyFunction(*function, &llvm::errs()));
        return changed;
    }
    std::optional<uint64_t> pack(const StateUses::Arrays& arrays) {
        builder.CreateRetVoid();
        const std::optional<uint64_t> bytes = packRayStates(arrays);
        EXPECT_FALSE(llvm::verifyModule(module, &llvm::errs()));
        return bytes;
    }
    // The constant offset of a load's address from the array, and the bytes between depths.
    std::pair<int64_t, int64_t> placeOf(const llvm::Value* address) const {
        const llvm::DataLayout& layout = module.getDataLayout();
        llvm::MapVector<llvm::Value*, llvm::APInt> variable;
        llvm::APInt constant(64, 0);
        while (const auto* step = llvm::dyn_cast<llvm::GEPOperator>(address)) {
            EXPECT_TRUE(step->collectOffset(layout, 64, variable, constant));
            address = step->getPointerOperand();
        }
        int64_t stride = 0;
        for (const auto& [value, scale] : variable) {
            const auto* product = llvm::dyn_cast<llvm::BinaryOperator>(value);
            const auto* factor =
                product ? llvm::dyn_cast<llvm::ConstantInt>(product->getOperand(1)) : nullptr;
            stride = factor ? factor->getSExtValue() : -1;
        }
        return {constant.getSExtValue(), stride};
    }
    template <class Kind>
    size_t count() const {
        size_t found = 0;
        for (const llvm::Instruction& each : function->getEntryBlock())
            found += llvm::isa<Kind>(each);
        return found;
    }

    llvm::LLVMContext context;
    llvm::Module module;
    llvm::IRBuilder<> builder;
    llvm::Function* function = nullptr;
    llvm::AllocaInst* states = nullptr;
    std::vector<llvm::StoreInst*> shown;
};

TEST(RayStates, WhatAllHaveIsNotLoaded) {
    Kernel k;
    llvm::Type* const word = k.builder.getInt32Ty();
    llvm::Value* const launch = k.function->getArg(0);
    k.store(launch, offsetof(RayState, launch));
    // A ray passes the launch to the ray below.
    k.store(k.load(k.builder.getPtrTy(), offsetof(RayState, launch)), offsetof(RayState, launch),
            true);
    k.store(k.builder.getInt32(1), offsetof(RayState, sbtStride));
    k.store(k.builder.getInt32(1), offsetof(RayState, sbtStride), true);
    k.store(k.builder.getInt32(2), offsetof(RayState, missIndex));
    k.store(k.builder.getInt32(3), offsetof(RayState, missIndex), true);
    k.store(k.builder.getInt32(9), offsetof(RayState, visibilityMask)); // no load reads it
    k.show(k.load(k.builder.getPtrTy(), offsetof(RayState, launch)));
    k.show(k.load(word, offsetof(RayState, sbtStride)));
    k.show(k.load(word, offsetof(RayState, missIndex)));
    ASSERT_TRUE(k.fold());
    EXPECT_EQ(k.shown[0]->getValueOperand(), launch);
    EXPECT_EQ(k.shown[1]->getValueOperand(), k.builder.getInt32(1));
    EXPECT_TRUE(llvm::isa<llvm::LoadInst>(k.shown[2]->getValueOperand()));
    EXPECT_EQ(k.count<llvm::LoadInst>(), 1u);
    EXPECT_EQ(k.count<llvm::StoreInst>(), 5u); // the miss index and the outputs
}

TEST(RayStates, PartsOfFieldsCount) {
    Kernel k;
    const uint64_t at = offsetof(RayState, payload);
    k.store(k.builder.getInt32(7), at);
    k.store(k.builder.getInt8(1), at + 1);
    k.builder.CreateMemSet(k.field(at + 4), k.builder.getInt8(0), 8, llvm::MaybeAlign());
    k.store(k.builder.getInt32(7), at + 4);
    k.show(k.load(k.builder.getInt32Ty(), at));
    k.show(k.load(k.builder.getInt32Ty(), at + 4));
    EXPECT_FALSE(k.fold());
}

TEST(RayStates, ListsAreReadAtAnyPlace) {
    Kernel k;
    const uint64_t list = offsetof(RayState, hit) + offsetof(devlib::Hit, transforms);
    llvm::Type* const entry = k.builder.getInt64Ty();
    k.store(k.builder.getInt64(5), list + 16);
    llvm::Value* const place = k.builder.CreateGEP(entry, k.field(list), k.function->getArg(1));
    k.show(k.builder.CreateLoad(entry, place));
    EXPECT_FALSE(k.fold());
    EXPECT_EQ(k.count<llvm::StoreInst>(), 2u);
}

// A function that is given a state and reads a word of it.
llvm::Function* reader(Kernel& k, uint64_t offset) {
    auto* function = llvm::Function::Create(
        llvm::FunctionType::get(k.builder.getInt32Ty(), {k.builder.getPtrTy()}, false),
        llvm::GlobalValue::InternalLinkage, "reader", k.module);
    llvm::IRBuilder<> builder(llvm::BasicBlock::Create(k.context, "", function));
    builder.CreateRet(builder.CreateLoad(
        builder.getInt32Ty(),
        builder.CreateConstGEP1_64(builder.getInt8Ty(), function->getArg(0), offset)));
    return function;
}

TEST(RayStates, CalledFunctionsAreFollowed) {
    Kernel k;
    const uint64_t at = offsetof(RayState, missIndex);
    llvm::Function* const function = reader(k, at);
    k.store(k.builder.getInt32(5), at);
    k.store(k.builder.getInt32(9), offsetof(RayState, visibilityMask)); // no load reads it
    k.show(k.builder.CreateCall(function, {k.field(0)}));
    ASSERT_TRUE(k.fold());
    const auto* result =
        llvm::cast<llvm::ReturnInst>(function->getEntryBlock().getTerminator())->getReturnValue();
    EXPECT_EQ(result, k.builder.getInt32(5));
    EXPECT_EQ(k.count<llvm::StoreInst>(), 1u) << "the output";
}

TEST(RayStates, FunctionsOfOtherStatesAreLeftAlone) {
    Kernel k;
    const uint64_t at = offsetof(RayState, missIndex);
    llvm::Function* const function = reader(k, at);
    k.store(k.builder.getInt32(5), at);
    k.show(k.builder.CreateCall(function, {k.field(0)}));
    k.show(k.builder.CreateCall(function, {k.function->getArg(0)}));
    EXPECT_FALSE(k.fold());
}

TEST(RayStates, UnknownFunctionsKeepTheStates) {
    Kernel k;
    k.store(k.builder.getInt32(1), offsetof(RayState, sbtStride));
    auto* type = llvm::FunctionType::get(k.builder.getVoidTy(), {k.builder.getPtrTy()}, false);
    k.builder.CreateCall(k.module.getOrInsertFunction("unknown", type), {k.field(0)});
    EXPECT_FALSE(k.fold());
}

TEST(RayStates, LoadsJoinedWithOthersAreSeparated) {
    Kernel k;
    llvm::Value* const outside = k.function->getArg(2);
    const uint64_t at = offsetof(RayState, missIndex);
    k.store(k.builder.getInt32(5), at);
    llvm::Value* const own = k.field(at);
    auto* const inside = llvm::BasicBlock::Create(k.context, "", k.function);
    auto* const both = llvm::BasicBlock::Create(k.context, "", k.function);
    llvm::BasicBlock* const first = k.builder.GetInsertBlock();
    k.builder.CreateCondBr(k.builder.CreateIsNull(k.function->getArg(1)), inside, both);
    k.builder.SetInsertPoint(inside);
    k.builder.CreateBr(both);
    k.builder.SetInsertPoint(both);
    llvm::PHINode* const address = k.builder.CreatePHI(k.builder.getPtrTy(), 2);
    address->addIncoming(own, inside);
    address->addIncoming(outside, first);
    k.show(k.builder.CreateLoad(k.builder.getInt32Ty(), address));
    ASSERT_TRUE(k.fold());
    const auto* value = llvm::dyn_cast<llvm::PHINode>(k.shown[0]->getValueOperand());
    ASSERT_TRUE(value);
    EXPECT_EQ(value->getIncomingValueForBlock(inside), k.builder.getInt32(5));
}

TEST(RayStates, LoadsOfOneOfTwoAddressesAreSeparated) {
    Kernel k;
    const uint64_t at = offsetof(RayState, missIndex);
    k.store(k.builder.getInt32(5), at);
    llvm::Value* const own = k.field(at);
    llvm::Value* const isOwn = k.builder.CreateIsNull(k.function->getArg(1));
    k.show(k.builder.CreateLoad(k.builder.getInt32Ty(),
                                k.builder.CreateSelect(isOwn, own, k.function->getArg(2))));
    k.store(k.builder.getInt32(9), offsetof(RayState, visibilityMask)); // no load reads it
    ASSERT_TRUE(k.fold());
    const auto* value = llvm::dyn_cast<llvm::PHINode>(k.shown[0]->getValueOperand());
    ASSERT_TRUE(value);
    EXPECT_EQ(value->getIncomingValue(0), k.builder.getInt32(5));
    EXPECT_TRUE(llvm::isa<llvm::LoadInst>(value->getIncomingValue(1)));
}

TEST(RayStates, PackedFieldsFollowOneAnother) {
    Kernel k;
    llvm::Type* const word = k.builder.getInt32Ty();
    for (const uint64_t at :
         {offsetof(RayState, tmax), offsetof(RayState, handle), offsetof(RayState, payload) + 8})
        k.store(k.function->getArg(0), at, true);
    llvm::LoadInst* const loads[] = {
        llvm::cast<llvm::LoadInst>(k.load(word, offsetof(RayState, tmax))),
        llvm::cast<llvm::LoadInst>(k.load(k.builder.getInt64Ty(), offsetof(RayState, handle))),
        llvm::cast<llvm::LoadInst>(k.load(word, offsetof(RayState, payload) + 8))};
    for (llvm::LoadInst* load : loads)
        k.show(load);
    const std::optional<uint64_t> bytes = k.pack({k.states});
    ASSERT_EQ(bytes, kStateAlignment) << "fields of 8, 8 and 8 bytes";
    int64_t last = -1;
    for (const llvm::LoadInst* load : loads) {
        const auto [place, stride] = k.placeOf(load->getPointerOperand());
        EXPECT_EQ(stride, int64_t(*bytes));
        EXPECT_GT(place, last);
        EXPECT_LE(place + 4, int64_t(*bytes));
        last = place;
    }
    const auto* below = llvm::cast<llvm::StoreInst>(&*std::find_if(
        k.function->getEntryBlock().begin(), k.function->getEntryBlock().end(),
        [](const llvm::Instruction& each) { return llvm::isa<llvm::StoreInst>(each); }));
    EXPECT_EQ(k.placeOf(below->getPointerOperand()).first,
              k.placeOf(loads[0]->getPointerOperand()).first + int64_t(*bytes));
}

TEST(RayStates, ListsArePackedAsAWhole) {
    Kernel k;
    const uint64_t list = offsetof(RayState, hit) + offsetof(devlib::Hit, transforms);
    llvm::Type* const entry = k.builder.getInt64Ty();
    k.store(k.builder.getInt64(5), list + 16);
    llvm::Value* const place = k.builder.CreateGEP(entry, k.field(list), k.function->getArg(1));
    k.show(k.builder.CreateLoad(entry, place));
    const std::optional<uint64_t> bytes = k.pack({k.states});
    ASSERT_TRUE(bytes);
    EXPECT_GE(*bytes, sizeof(devlib::Hit::transforms));
    EXPECT_LT(*bytes, sizeof(devlib::Hit::transforms) + 2 * kStateAlignment);
}

TEST(RayStates, AddressesThatLeaveAreLeftAlone) {
    Kernel k;
    k.store(k.builder.getInt32(1), offsetof(RayState, sbtStride)); // no load here reads it
    k.show(k.field(offsetof(RayState, sbtStride)));
    EXPECT_FALSE(k.fold());
    EXPECT_EQ(k.count<llvm::StoreInst>(), 2u);
}

} // namespace
} // namespace sunstone::compiler
