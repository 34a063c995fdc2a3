// SPDX-License-Identifier: Apache-2.0
#include "compiler/piece.h"

#include "compiler/build_id.h"
#include "compiler/compile_steps.h"
#include "compiler/flush.h"
#include "compiler/lower_optix.h"
#include "compiler/machine.h"
#include "compiler/optimizer.h"

#include <llvm/Support/BLAKE3.h>

namespace sunstone::compiler {

std::string programSymbol(const PieceRequest& request) {
    return "program." + request.function;
}

CodeObject compilePiece(const PieceRequest& request) {
    const bool isProgram = !request.function.empty();
    StepTimes times(isProgram ? request.function : "variables");
    LentMachine machine(request.optLevel);
    Unit unit(Flavor::kOptix, request.rules, request.modules,
              isProgram ? Variables::kReferenced : Variables::kDefined);
    prepare(unit, machine);
    times.step("set-up");

    ProgramKinds kinds;
    if (isProgram) {
        const ptx::Module& module = *request.modules[request.module];
        llvm::Function* function = unit.declare(module, *module.findFunction(request.function));
        kinds[function] = programKind(request.function);
        function->setLinkage(llvm::GlobalValue::ExternalLinkage);
        function->setName(programSymbol(request));
        function->setDSOLocal(true);
    }
    for (const VariableId& id : request.variables)
        unit.addVariable(id);
    unit.translateQueue();
    times.step("translate");

    Optimizer optimizer(unit, *machine, request.optLevel);
    optimizer.dump("translated");
    verify(unit, "translation");
    optimizer.promote();
    times.step("promote");
    markIntrinsicUsers(unit, kinds);
    optimizer.inlineAlways();
    if (unit.facts().size() > kinds.size()) // constants came along with what was inlined
        optimizer.promote();
    times.step("inline");
    lowerIntrinsics(unit, kinds);
    lowerFlushes(unit, machine.hasFma());
    optimizer.dump("lowered");
    verify(unit, "lowering");
    times.step("lower");
    optimizer.optimize();
    times.step("optimize");
    CodeObject object = generate(unit, machine);
    object.variables = unit.variableIds();
    times.step("generate");
    return object;
}

namespace {

class Digest {
public:
    void add(std::string_view text) {
        add(uint64_t(text.size()));
        hash_.update(llvm::StringRef(text.data(), text.size()));
    }
    void add(uint64_t value) {
        hash_.update(
            llvm::ArrayRef<uint8_t>(reinterpret_cast<const uint8_t*>(&value), sizeof value));
    }
    std::string take() {
        const auto bytes = hash_.final<16>();
        return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    }

private:
    llvm::BLAKE3 hash_;
};

void addRules(Digest& digest, const PipelineRules& rules) {
    // Names every field: a new one does not compile until it is part of the key.
    const auto& [launchParams, numPayloadValues, numAttributeValues, exceptionFlags,
                 primitiveTypeFlags, traversableGraphFlags, motionBlur] = rules;
    digest.add(launchParams);
    for (const uint64_t value :
         {uint64_t(numPayloadValues), uint64_t(numAttributeValues), uint64_t(exceptionFlags),
          uint64_t(primitiveTypeFlags), uint64_t(traversableGraphFlags), uint64_t(motionBlur)})
        digest.add(value);
}

} // namespace

std::string keyOf(const PieceRequest& request) {
    const auto& [modules, rules, optLevel, debugLevel, module, function, variables] = request;
    Digest digest;
    digest.add(buildId());
    digest.add(targetDescription());
    digest.add(uint64_t(modules.size()));
    for (const ptx::Module* each : modules)
        digest.add(each->text);
    addRules(digest, rules);
    for (const uint64_t value : {uint64_t(optLevel), uint64_t(debugLevel), uint64_t(module)})
        digest.add(value);
    digest.add(function);
    for (const VariableId& id : variables)
        digest.add(id.symbol());
    return digest.take();
}

CodeObject obtainPiece(const PieceRequest& request, ObjectStore* store) {
    if (!store)
        return compilePiece(request);
    const std::string key = keyOf(request);
    CodeObject object;
    std::string bytes;
    if (store->find(key, bytes) && object.deserialize(bytes))
        return object;
    object = compilePiece(request);
    store->insert(key, object.serialize());
    return object;
}

} // namespace sunstone::compiler
