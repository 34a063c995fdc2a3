// SPDX-License-Identifier: Apache-2.0
#include "compiler/piece.h"

#include "base/config.h"
#include "base/error.h"
#include "compiler/compile_steps.h"
#include "compiler/debug/debug_info.h"
#include "compiler/machine.h"
#include "compiler/optix7/check_module.h"
#include "compiler/optix7/payload.h"
#include "compiler/passes/bound_values.h"
#include "compiler/passes/flush.h"
#include "compiler/passes/optimizer.h"
#include "compiler/passes/stack_checks.h"
#include "compiler/store/build_id.h"
#include "compiler/store/digest.h"

#include <optional>

namespace sunstone::compiler {

std::string programSymbol(const PieceRequest& request) {
    return "program." + request.function;
}

namespace {

const ModuleRules& rulesOf(const PieceRequest& request, size_t module) {
    static const ModuleRules none;
    const bool given = module < request.moduleRules.size() && request.moduleRules[module];
    return given ? *request.moduleRules[module] : none;
}

std::vector<const ptx::Module*> treesOf(const PieceRequest& request) {
    std::vector<const ptx::Module*> trees;
    for (const Source* module : request.modules)
        trees.push_back(&module->tree());
    return trees;
}

const Flavor& flavorOf(const PieceRequest& request) {
    return request.flavor ? *request.flavor : optix7Flavor();
}

// With full debug information, the code of each line must stay at its place.
OptLevel levelOf(const PieceRequest& request) {
    return request.debugLevel == DebugLevel::kFull ? OptLevel::k0 : request.optLevel;
}

// One piece on its way from PTX to machine code.
class Compilation {
public:
    explicit Compilation(const PieceRequest& request)
        : request_(request), isProgram_(!request.function.empty()),
          times_(isProgram_ ? request.function : "variables"), level_(levelOf(request)),
          machine_(level_),
          unit_(flavorOf(request), request.rules, treesOf(request),
                isProgram_ ? Variables::kReferenced : Variables::kDefined) {
        for (size_t i = 0; i < request.modules.size(); ++i)
            unit_.setOptions(request.modules[i]->tree(),
                             i < request.moduleRules.size() ? request.moduleRules[i] : nullptr,
                             request.debugLevel);
        prepare(unit_, machine_);
        optimizer_.emplace(unit_, *machine_, level_);
        times_.step("set-up");
    }

    // Lowers until no `_optix_*` call remains.
    void lower() {
        if (isProgram_)
            declareProgram();
        for (const VariableId& id : request_.variables)
            unit_.addVariable(id);
        unit_.translateQueue();
        times_.step("translate");
        optimizer_->dump("translated");
        verify(unit_, "translation");
        optimizer_->promote();
        times_.step("promote");
        markIntrinsicUsers(unit_);
        optimizer_->inlineAlways();
        if (unit_.facts().size() > unit_.kinds().size()) // constants came along with what was inlined
            optimizer_->promote();
        times_.step("inline");
        object_.boundLoads = substituteBoundValues(unit_, boundValuesOf(request_));
        unit_.flavor().lower(unit_, payloads_);
    }

    CodeObject finish() {
        lowerFlushes(unit_, machine_.hasFma());
        optimizer_->dump("lowered");
        verify(unit_, "lowering");
        times_.step("lower");
        optimizer_->optimize();
        times_.step("optimize");
        addStackChecks(unit_);
        if (request_.debugLevel == DebugLevel::kFull)
            pinVariables(unit_);
        CodeObject object = generate(unit_, machine_);
        object.variables = unit_.variableIds();
        object.forDebugger = request_.debugLevel == DebugLevel::kModerate ||
                             request_.debugLevel == DebugLevel::kFull;
        object.boundLoads = std::move(object_.boundLoads);
        if (isProgram_)
            object.stackNeed =
                stackNeed(unit_, programSymbol(request_), object.stackSizes);
        times_.step("generate");
        return object;
    }

private:
    void declareProgram() {
        const ptx::Module& module = request_.modules[request_.module]->tree();
        llvm::Function* function = unit_.declare(module, *module.findFunction(request_.function));
        unit_.kinds()[function] = request_.kind;
        if (request_.payloadType >= 0)
            payloads_[function] = &rulesOf(request_, request_.module)
                                       .payloadTypes.at(size_t(request_.payloadType));
        function->setLinkage(llvm::GlobalValue::ExternalLinkage);
        function->setName(programSymbol(request_));
        function->setDSOLocal(true);
    }

    const PieceRequest& request_;
    const bool isProgram_;
    StepTimes times_;
    const OptLevel level_;
    LentMachine machine_;
    Unit unit_;
    std::optional<Optimizer> optimizer_;
    ProgramPayloads payloads_;
    CodeObject object_;
};

} // namespace

CodeObject compilePiece(const PieceRequest& request) {
    Compilation compilation(request);
    compilation.lower();
    return compilation.finish();
}

void checkPiece(const PieceRequest& request) {
    Compilation(request).lower();
}

std::vector<BoundValue> boundValuesOf(const PieceRequest& request) {
    std::vector<BoundValue> values;
    for (size_t i = 0; i < request.modules.size(); ++i) {
        const auto& own = rulesOf(request, i).boundValues;
        values.insert(values.end(), own.begin(), own.end());
    }
    return values;
}

void checkByCompiling(const ptx::Module& module, const PipelineRules& rules,
                      const ModuleRules& moduleRules, const ModuleSummary& summary) {
    const Source source(std::shared_ptr<const ptx::Module>(std::shared_ptr<void>(), &module));
    PieceRequest request;
    request.modules = {&source};
    request.rules = rules;
    request.moduleRules = {std::make_shared<const ModuleRules>(moduleRules)};
    const int types = int(moduleRules.payloadTypes.size());
    for (const ModuleSummary::Program& program : summary.programs) {
        const bool typed = types != 0 && hasPayload(program.kind);
        request.function = program.name;
        request.kind = program.kind;
        for (int type = typed ? 0 : -1; type < (typed ? types : 0); ++type) {
            if (typed && !(program.payloadTypes >> type & 1))
                continue;
            request.payloadType = type;
            try {
                checkPiece(request);
            } catch (const Error& error) {
                if (error.code() != ErrorCode::kLinkError) // other modules are not known yet
                    throw;
            }
        }
    }
}

std::string keyOf(const PieceRequest& request) {
    const auto& [modules, flavor, rules, optLevel, debugLevel, module, function, kind, payloadType,
                 moduleRules, variables] = request;
    Digest digest;
    digest.add(buildId());
    digest.add(targetDescription());
    digest.add(uint64_t(checks("memory")));
    digest.add(flavorOf(request).name());
    digest.add(uint64_t(modules.size()));
    for (const Source* each : modules)
        digest.add(each->digest());
    addRules(digest, rules);
    for (const uint64_t value : {uint64_t(optLevel), uint64_t(debugLevel), uint64_t(module)})
        digest.add(value);
    digest.add(function);
    digest.add(uint64_t(kind));
    digest.add(uint64_t(int64_t(payloadType)));
    for (size_t i = 0; i < modules.size(); ++i)
        addRules(digest, rulesOf(request, i));
    for (const VariableId& id : variables)
        digest.add(id.symbol());
    return digest.take();
}

bool findPiece(const PieceRequest& request, ObjectStore* store, CodeObject& object) {
    std::string bytes;
    return store && store->find(keyOf(request), bytes) && object.deserialize(bytes);
}

CodeObject makePiece(const PieceRequest& request, ObjectStore* store) {
    CodeObject object = compilePiece(request);
    if (store)
        store->insert(keyOf(request), object.serialize());
    return object;
}

} // namespace sunstone::compiler
