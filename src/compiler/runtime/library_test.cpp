// SPDX-License-Identifier: Apache-2.0
// The run-time has every function that the code generator may call. Code that calls any other
// function is an error and is not stored.
#include "compiler/flavor.h"
#include "compiler/machine.h"
#include "compiler/piece.h"
#include "compiler/runtime/runtime.h"
#include "compiler/testing.h"
#include "compiler/translate/unit.h"

#include <llvm/CodeGen/TargetLowering.h>
#include <llvm/CodeGen/TargetSubtargetInfo.h>
#include <llvm/MC/TargetRegistry.h>

#include <memory>
#include <regex>
#include <set>

namespace sunstone::compiler::testing {
namespace {

struct LibraryCall {
    const char* name; // of LLVM's list
    llvm::RTLIB::Libcall call;
};

constexpr LibraryCall kCalls[] = {
#define HANDLE_LIBCALL(code, name) {#code, llvm::RTLIB::code},
#include <llvm/IR/RuntimeLibcalls.def>
#undef HANDLE_LIBCALL
};

// Library calls that compiled code cannot contain.
bool isExcluded(const std::string& name) {
    static const std::regex excluded(
        // types that compiled code lacks
        ".*_(F80|F128|PPCF128)(_.*)?|.*BF16.*|"
        // instructions of every x86-64 processor
        ".*_I(8|16|32|64)|(FPTO|SINTTO|UINTTO)[^_]*(_F(32|64))?_I(8|16|32|64)(_F(32|64))?|"
        "(ADD|SUB|MUL|DIV)_F(32|64)|FPEXT_F32_F64|FPROUND_F64_F32|(O|U)[A-Z]+_F(32|64)|"
        "CTLZ_.*|(SYNC|ATOMIC|OUTLINE_ATOMIC)_.*|"
        // half is converted to float first, and never to or from 128 bits
        ".*_F16_I.*|.*_I.*_F16|FPEXT_F16_F64|"
        // only with finite numbers, other environments, exceptions, objects of other languages
        ".*_FINITE.*|FEGET.*|FESET.*|FERESET.*|.*ELEMENT_UNORDERED_ATOMIC.*|UNWIND.*|CXA.*|"
        "STACKPROTECTOR.*|DEOPTIMIZE|CLEAR_CACHE|RETURN_ADDRESS|BZERO|CALLOC|HEXAGON.*|"
        "SINCOS_STRET.*|RISCV.*|OBJC.*|UNKNOWN_LIBCALL|NEG_.*");
    return std::regex_match(name, excluded);
}

std::unique_ptr<llvm::TargetMachine> machineOf(const char* processor, const char* features) {
    const LentMachine host(OptLevel::k3); // sets the code generator up
    const std::string triple = LentMachine(OptLevel::k3)->getTargetTriple().str();
    std::string error;
    const llvm::Target* target = llvm::TargetRegistry::lookupTarget(triple, error);
    EXPECT_TRUE(target) << error;
    return std::unique_ptr<llvm::TargetMachine>(
        target->createTargetMachine(triple, processor, features, {}, llvm::Reloc::PIC_));
}

TEST(Library, HasEveryFunctionOfTheCodeGenerator) {
    std::set<std::string> provided;
    for (const RuntimeSymbol& symbol : runtimeSymbols())
        EXPECT_TRUE(provided.insert(symbol.name).second) << symbol.name << " is there twice";
    for (const char* processor : {"x86-64", "nehalem", "sandybridge", "haswell", "skylake-avx512",
                                  "sapphirerapids", "bdver2", "znver2", "znver4"}) {
        const auto machine = machineOf(processor, "+cx16");
        llvm::LLVMContext context;
        llvm::Module module("library", context);
        const auto* function =
            llvm::Function::Create(llvm::FunctionType::get(llvm::Type::getVoidTy(context), false),
                                   llvm::GlobalValue::ExternalLinkage, "function", module);
        const llvm::TargetLowering* lowering =
            machine->getSubtargetImpl(*function)->getTargetLowering();
        for (const LibraryCall& call : kCalls) {
            const char* symbol = call.call == llvm::RTLIB::UNKNOWN_LIBCALL
                                     ? nullptr
                                     : lowering->getLibcallName(call.call);
            if (!symbol || isExcluded(call.name))
                continue;
            EXPECT_TRUE(provided.contains(symbol))
                << call.name << " is " << symbol << " for " << processor;
        }
    }
}

class MapStore : public ObjectStore {
public:
    bool find(const std::string&, std::string&) override { return false; }
    void insert(const std::string&, const std::string&) override { ++inserts; }
    unsigned inserts = 0;
};

// The flavor OptiX 7 with programs that call a function that the run-time lacks.
class LostFlavor final : public Flavor {
public:
    const char* name() const override { return "lost"; }
    bool isIntrinsicName(std::string_view name) const override {
        return optix7Flavor().isIntrinsicName(name);
    }
    const Intrinsic* find(std::string_view name) const override {
        return optix7Flavor().find(name);
    }
    std::string launchIndex(char component) const override {
        return optix7Flavor().launchIndex(component);
    }
    std::string launchDimension(char component) const override {
        return optix7Flavor().launchDimension(component);
    }
    bool isProgramName(std::string_view name) const override {
        return optix7Flavor().isProgramName(name);
    }
    std::optional<size_t> parameterAt(ProgramKind, size_t, size_t) const override { return {}; }
    void lower(Unit& unit, const ProgramPayloads& payloads) const override {
        optix7Flavor().lower(unit, payloads);
        llvm::Type* none = llvm::Type::getVoidTy(unit.context());
        for (const auto& [program, kind] : unit.kinds())
            llvm::CallInst::Create(unit.helper("sunstone_lost", none, {}, false), "",
                                   program->getEntryBlock().getFirstInsertionPt());
    }
};

TEST(Library, CodeThatCannotBeLinkedIsNotKept) {
    const LostFlavor lost;
    const auto module = source(std::string(kHeader) + ".visible .entry __miss__m() { ret; }\n");
    PieceRequest request;
    request.modules = {module.get()};
    request.function = "__miss__m";
    request.kind = ProgramKind::kMiss;
    request.moduleRules = {nullptr};
    MapStore store;
    makePiece(request, &store);
    EXPECT_EQ(store.inserts, 1u);
    request.flavor = &lost;
    try {
        makePiece(request, &store);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), sunstone::Code::kInternal);
        EXPECT_NE(std::string(error.what()).find("calls sunstone_lost"), std::string::npos)
            << error.what();
    }
    EXPECT_EQ(store.inserts, 1u);
}

} // namespace
} // namespace sunstone::compiler::testing
