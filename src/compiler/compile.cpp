// SPDX-License-Identifier: Apache-2.0
// compilePipeline: checks, parallel compilation of pieces, linking. A pipeline's programs are
// independent pieces of code; the variables that they share are one more piece, made after all of
// its users. Read next: piece.h.
#include "compiler/compiler.h"

#include "base/error.h"
#include "base/threads/threads.h"
#include "compiler/compile_steps.h"
#include "compiler/piece.h"
#include "compiler/store/build_id.h"
#include "compiler/store/digest.h"

#include <algorithm>
#include <exception>

namespace sunstone::compiler {

namespace {

class PipelineCode : public Code {
public:
    const std::vector<CompiledProgram>& programs() const override { return programs_; }
    bool variable(std::string_view name, void** address, uint64_t* size) const override {
        std::vector<const ptx::Module*> trees;
        for (const auto& module : modules_)
            trees.push_back(&module->tree());
        VariableTable table;
        for (const auto& [id, place] : variables_)
            table.add(trees, id, place);
        return table.find(name, address, size);
    }
    const std::string& feedback() const override { return feedback_; }
    std::string feedback_;
    std::vector<CompiledProgram> programs_;
    std::vector<std::shared_ptr<const Source>> modules_; // the modules of variables_
    std::vector<std::pair<VariableId, void*>> variables_;
    std::vector<std::unique_ptr<LoadedCode>> code_;
};

const ptx::Function& requestedFunction(const ProgramRequest& request) {
    if (!request.module)
        fail(ErrorCode::kInvalidValue, "program \"", request.function, "\" has no module");
    const ptx::Function* function = request.module->tree().findFunction(request.function);
    if (!function || !function->hasBody)
        fail(ErrorCode::kNotFound, "the module has no function \"", request.function, "\"");
    if (request.kind == ProgramKind::kNone)
        fail(ErrorCode::kInvalidValue, "\"", request.function,
             "\" is requested as no kind of program");
    return *function;
}

// The variable may be declared in several modules, which must agree on its size.
void checkLaunchParams(const PipelineRequest& request) {
    const ptx::Variable* first = nullptr;
    if (request.rules.launchParams.empty())
        return;
    for (const ProgramRequest& program : request.programs) {
        const ptx::Variable* variable =
            program.module->tree().findVariable(request.rules.launchParams);
        if (!variable)
            continue;
        if (variable->space != ptx::Space::kConst)
            failAt(ErrorCode::kInvalidLaunchParameter, variable->location,
                   "the launch parameter variable \"", variable->name, "\" is not .const");
        if (first && first->size != variable->size)
            failAt(ErrorCode::kInvalidLaunchParameter, variable->location,
                   "the launch parameter variable \"", variable->name, "\" has ", variable->size,
                   " bytes here and ", first->size, " in another module");
        first = variable;
    }
}

constexpr uint32_t kLeastStack = 16; // every program uses some stack

// The request for a program without the rest of its pipeline.
PieceRequest aloneOf(const ProgramRequest& program, const PipelineRules& rules) {
    PieceRequest request;
    request.modules = {program.module.get()};
    request.rules = rules;
    request.optLevel = program.optLevel;
    request.debugLevel = program.debugLevel;
    request.function = program.function;
    request.kind = program.kind;
    request.payloadType = program.payloadType;
    request.moduleRules = {program.moduleRules};
    return request;
}

// One pipeline under construction.
class PipelineBuild {
public:
    PipelineBuild(const PipelineRequest& request, ObjectStore* store)
        : request_(request), store_(store) {
        for (const ProgramRequest& program : request.programs) {
            const Source* module = program.module.get();
            if (std::find(modules_.begin(), modules_.end(), module) == modules_.end()) {
                modules_.push_back(module);
                rules_.push_back(program.moduleRules);
                code_->modules_.push_back(program.module);
            }
            level_ = std::max(level_, program.optLevel);
        }
    }

    std::unique_ptr<Code> run() {
        checkTogether();
        planPrograms();
        obtainPrograms();
        loadVariables();
        for (size_t i = 0; i < pieces_.size(); ++i)
            loadProgram(i);
        describeBoundValues();
        return std::move(code_);
    }

private:
    struct Piece {
        PieceRequest request;
        std::vector<uint32_t> modules; // for each module of the request, its index in modules_
        ObjectStore* store;
        CodeObject object;
        std::exception_ptr error;
    };

    // The checks that need syntax trees. A stored result of a single module has passed them before
    // it was stored, so it needs no tree.
    void check() {
        if (checked_)
            return;
        for (const ProgramRequest& program : request_.programs)
            requestedFunction(program);
        checkLaunchParams(request_);
        std::vector<const ptx::Module*> trees;
        for (const Source* module : modules_)
            trees.push_back(&module->tree());
        const Flavor& flavor = request_.flavor ? *request_.flavor : optix7Flavor();
        Unit(flavor, request_.rules, trees); // refuses symbols defined twice
        checked_ = true;
    }

    // Stored programs do not prove that their modules agree, so the store has an entry of its own
    // for this check.
    void checkTogether() {
        if (modules_.size() < 2)
            return;
        if (!store_)
            return check();
        Digest digest;
        digest.add(buildId());
        digest.add("together");
        digest.add(request_.rules.launchParams);
        for (const Source* module : modules_)
            digest.add(module->digest());
        const std::string key = digest.take();
        std::string nothing;
        if (store_->find(key, nothing))
            return;
        check();
        store_->insert(key, {});
    }

    void planPrograms() {
        pieces_.resize(request_.programs.size());
        for (size_t i = 0; i < pieces_.size(); ++i) {
            const ProgramRequest& program = request_.programs[i];
            const auto own =
                uint32_t(std::find(modules_.begin(), modules_.end(), program.module.get()) -
                         modules_.begin());
            Piece& piece = pieces_[i];
            piece.request.flavor = request_.flavor;
            piece.request.rules = request_.rules;
            piece.request.optLevel = program.optLevel;
            piece.request.debugLevel = program.debugLevel;
            piece.request.function = program.function;
            piece.request.kind = program.kind;
            piece.request.payloadType = program.payloadType;
            piece.store = store_;
            SUNSTONE_CHECK(program.payloadType < 0 || program.moduleRules);
            if (program.selfContained ? *program.selfContained
                                      : isSelfContained(program.module->tree(), request_.rules)) {
                piece.request.modules = {program.module.get()};
                piece.request.moduleRules = {program.moduleRules};
                piece.modules = {own};
                if (program.store)
                    piece.store = program.store.get();
                continue;
            }
            piece.request.modules = modules_;
            piece.request.moduleRules = rules_;
            piece.request.module = own;
            for (uint32_t k = 0; k < modules_.size(); ++k)
                piece.modules.push_back(k);
        }
    }

    void obtainPrograms() {
        std::vector<Piece*> missing;
        for (Piece& piece : pieces_)
            if (!findPiece(piece.request, piece.store, piece.object))
                missing.push_back(&piece);
        if (!missing.empty())
            check();
        parallelFor(missing.size(), 1, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i) {
                try {
                    missing[i]->object = makePiece(missing[i]->request, missing[i]->store);
                } catch (...) {
                    missing[i]->error = std::current_exception();
                }
            }
        });
        for (const Piece& piece : pieces_)
            if (piece.error)
                std::rethrow_exception(piece.error);
    }

    VariableId inPipeline(const Piece& piece, VariableId id) const {
        if (id.module >= piece.modules.size())
            fail(ErrorCode::kInternal, "piece refers to unknown variable ", id.symbol());
        id.module = piece.modules[id.module];
        return id;
    }

    void loadVariables() {
        for (const Piece& piece : pieces_)
            for (const VariableId& id : piece.object.variables)
                addresses_[inPipeline(piece, id)] = nullptr;
        if (addresses_.empty())
            return;
        PieceRequest request;
        request.modules = modules_;
        request.flavor = request_.flavor;
        request.rules = request_.rules;
        request.optLevel = level_;
        for (const auto& [id, address] : addresses_)
            request.variables.push_back(id);
        CodeObject object;
        if (!findPiece(request, store_, object)) {
            check();
            object = makePiece(request, store_);
        }
        std::vector<std::string> symbols;
        for (const VariableId& id : object.variables)
            symbols.push_back(id.symbol());
        code_->code_.push_back(loadObject(object, symbols, {}));
        for (const VariableId& id : object.variables) {
            void* address = code_->code_.back()->address(id.symbol());
            addresses_[id] = address;
            code_->variables_.emplace_back(id, address);
        }
    }

    void loadProgram(size_t i) {
        const Piece& piece = pieces_[i];
        std::vector<std::pair<std::string, void*>> externals;
        for (const VariableId& id : piece.object.variables)
            externals.emplace_back(id.symbol(), addresses_.at(inPipeline(piece, id)));
        const std::string symbol = programSymbol(piece.request);
        code_->code_.push_back(loadObject(piece.object, {symbol}, externals));
        code_->programs_.push_back(
            {code_->code_.back()->address(symbol), std::max(kLeastStack, piece.object.stackNeed)});
    }

    // Writes a line for each bound value, with the number of loads that it replaced in all
    // programs.
    void describeBoundValues() {
        std::map<std::pair<uint64_t, std::string>, std::pair<const BoundValue*, uint64_t>> lines;
        std::vector<std::vector<BoundValue>> values(pieces_.size());
        for (size_t p = 0; p < pieces_.size(); ++p) {
            const Piece& piece = pieces_[p];
            values[p] = boundValuesOf(piece.request);
            for (size_t i = 0; i < values[p].size(); ++i) {
                const BoundValue& value = values[p][i];
                auto& line = lines[{value.offset, value.annotation}];
                line.first = &value;
                if (i < piece.object.boundLoads.size())
                    line.second += piece.object.boundLoads[i];
            }
        }
        for (const auto& [name, line] : lines)
            code_->feedback_ +=
                message("bound value \"", line.first->annotation, "\", bytes ", line.first->offset,
                        " to ", line.first->offset + line.first->bytes.size() - 1, ": ",
                        line.second, line.second == 1 ? " load" : " loads", " specialised\n");
    }

    const PipelineRequest& request_;
    ObjectStore* store_;
    std::vector<const Source*> modules_;
    bool checked_ = false;
    std::vector<std::shared_ptr<const ModuleRules>> rules_; // of modules_
    OptLevel level_ = OptLevel::k0;
    std::vector<Piece> pieces_;
    std::map<VariableId, void*> addresses_;
    std::unique_ptr<PipelineCode> code_ = std::make_unique<PipelineCode>();
};

} // namespace

std::unique_ptr<Code> compilePipeline(const PipelineRequest& request, ObjectStore* store) {
    return PipelineBuild(request, store).run();
}

std::vector<const ptx::Function*> undefinedFunctions(const ptx::Module& module) {
    std::vector<const ptx::Function*> found;
    for (const ptx::Function& function : module.functions)
        if (!module.findFunction(function.name)->hasBody && !providedFunction(function.name))
            found.push_back(&function);
    return found;
}

bool isSelfContained(const ptx::Module& module, const PipelineRules& rules) {
    if (!undefinedFunctions(module).empty())
        return false;
    return std::all_of(
        module.variables.begin(), module.variables.end(), [&](const ptx::Variable& variable) {
            return variable.linkage != ptx::Linkage::kExtern ||
                   variable.space == ptx::Space::kShared || variable.name == rules.launchParams ||
                   module.findVariable(variable.name)->linkage != ptx::Linkage::kExtern;
        });
}

namespace {

CodeObject obtainAlone(const ProgramRequest& program, const PipelineRules& rules) {
    const PieceRequest request = aloneOf(program, rules);
    CodeObject object;
    if (findPiece(request, program.store.get(), object))
        return object;
    requestedFunction(program);
    return makePiece(request, program.store.get());
}

} // namespace

void precompile(const ProgramRequest& program, const PipelineRules& rules) {
    obtainAlone(program, rules);
}

unsigned stackNeed(const ProgramRequest& program, const PipelineRules& rules) {
    return std::max(kLeastStack, obtainAlone(program, rules).stackNeed);
}

} // namespace sunstone::compiler
