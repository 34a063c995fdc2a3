// SPDX-License-Identifier: Apache-2.0
// foldRayStates on small kernels: which loads and stores it removes, and which it keeps.
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
        const bool changed = foldRayStates(*states);
        EXPECT_FALSE(llvm::verifyFunction(*function, &llvm::errs()));
        return changed;
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

TEST(RayStates, AddressesThatLeaveAreLeftAlone) {
    Kernel k;
    k.store(k.builder.getInt32(1), offsetof(RayState, sbtStride)); // no load here reads it
    k.show(k.field(offsetof(RayState, sbtStride)));
    EXPECT_FALSE(k.fold());
    EXPECT_EQ(k.count<llvm::StoreInst>(), 2u);
}

} // namespace
} // namespace sunstone::compiler
