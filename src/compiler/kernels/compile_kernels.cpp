// SPDX-License-Identifier: Apache-2.0
// Implements kernel_module.h: the steps from a CUDA module's tree to loaded code.
#include "compiler/kernels/kernel_module.h"

#include "base/config.h"
#include "base/log.h"
#include "base/threads/threads.h"
#include "compiler/compile_steps.h"
#include "compiler/debug/debug_info.h"
#include "compiler/kernels/exchanges.h"
#include "compiler/kernels/shared_layout.h"
#include "compiler/lockstep/lockstep.h"
#include "compiler/lockstep/steps.h"
#include "compiler/machine.h"
#include "compiler/passes/flush.h"
#include "compiler/passes/optimizer.h"
#include "compiler/store/build_id.h"
#include "compiler/store/digest.h"
#include "ptx/opcodes/opcode.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <map>

namespace sunstone::compiler {

namespace {

constexpr const char* kKernelPrefix = "kernel.";

// Statements of a module for a debugger up to which kernels are also compiled with optimisation
// (obtainKernel), which takes some seconds.
constexpr size_t kLongModule = 50000;

KernelInfo describeKernel(const ptx::Function& function) {
    KernelInfo info;
    info.name = std::string(function.name);
    uint64_t offset = 0;
    for (const ptx::Variable& parameter : function.parameters) {
        const uint64_t alignment = std::max(1u, parameter.alignment);
        offset = (offset + alignment - 1) / alignment * alignment;
        info.parameterOffsets.push_back(uint32_t(offset));
        info.parameterSizes.push_back(uint32_t(parameter.size));
        offset += parameter.size;
    }
    info.parameterBytes = uint32_t(offset);
    limitBytes(info, offset, "parameters");
    const auto product = [](const uint32_t(&threads)[3]) {
        uint64_t all = threads[0];
        for (const uint32_t more : {threads[1], threads[2]})
            all = std::min<uint64_t>(all * std::max(1u, more), UINT32_MAX);
        return uint32_t(all);
    };
    info.maxThreadsPerBlock = product(function.requiredThreads);
    if (info.maxThreadsPerBlock == 0)
        info.maxThreadsPerBlock = product(function.maxThreads);
    return info;
}

bool callsThroughPointers(const ptx::Module& module) {
    for (const ptx::Function& function : module.functions)
        for (const ptx::Statement& statement : function.body)
            if (statement.kind == ptx::StatementKind::kInstruction &&
                statement.instruction.facts->syntax == ptx::Syntax::kCall &&
                statement.instruction.target.kind != ptx::OperandKind::kSymbol)
                return true;
    return false;
}

bool areLong(const KernelModules& modules) {
    size_t statements = 0;
    for (const auto& module : modules)
        for (const ptx::Function& function : module->functions)
            statements += function.body.size();
    return statements > kLongModule;
}

bool isMemory(const ptx::Variable& variable) {
    return variable.linkage != ptx::Linkage::kExtern && variable.type != ptx::Type::kSamplerref &&
           (variable.space == ptx::Space::kGlobal || variable.space == ptx::Space::kConst);
}

// All variables of the modules, those inside functions too.
std::vector<VariableId> variablesOf(const KernelModules& modules) {
    std::vector<VariableId> ids;
    for (uint32_t m = 0; m < modules.size(); ++m) {
        const ptx::Module& module = *modules[m];
        for (uint32_t i = 0; i < module.variables.size(); ++i)
            if (isMemory(module.variables[i]))
                ids.push_back({m, VariableId::kModuleScope, i});
        for (uint32_t f = 0; f < module.functions.size(); ++f)
            for (uint32_t i = 0; i < module.functions[f].variables.size(); ++i)
                if (isMemory(module.functions[f].variables[i]))
                    ids.push_back({m, f, i});
    }
    return ids;
}

struct KernelSource {
    const ptx::Module* module;
    const ptx::Function* function;
};

// The kernels of all modules, in the order of the first definitions of their names. Templates may
// define the same weak kernel in several modules. The first definition is used, unless another one
// is strong.
std::vector<KernelSource> kernelsOf(const KernelModules& modules) {
    std::vector<KernelSource> kernels;
    std::map<std::string_view, size_t> indices;
    for (const auto& module : modules)
        for (const ptx::Function& function : module->functions) {
            if (!function.isEntry || !function.hasBody)
                continue;
            const auto [known, isNew] = indices.emplace(function.name, kernels.size());
            if (isNew) {
                kernels.push_back({module.get(), &function});
                continue;
            }
            KernelSource& earlier = kernels[known->second];
            if (function.linkage == ptx::Linkage::kWeak)
                continue;
            if (earlier.function->linkage != ptx::Linkage::kWeak)
                fail(ErrorCode::kLinkError, "kernel \"", function.name, "\" is defined twice");
            earlier = {module.get(), &function};
        }
    return kernels;
}

std::vector<KernelInfo> describeKernels(const KernelModules& modules) {
    std::vector<KernelInfo> kernels;
    for (const KernelSource& source : kernelsOf(modules))
        kernels.push_back(describeKernel(*source.function));
    return kernels;
}

std::vector<const ptx::Module*> pointersOf(const KernelModules& modules) {
    std::vector<const ptx::Module*> pointers;
    for (const auto& module : modules)
        pointers.push_back(module.get());
    return pointers;
}

// Results of compiling kernels besides their code.
struct KernelObject {
    CodeObject object;
    std::vector<KernelInfo> kernels; // in the order of the request

    std::string serialize() const {
        std::string text;
        const auto number = [&](uint32_t value) {
            text.append(reinterpret_cast<const char*>(&value), sizeof value);
        };
        for (const KernelInfo& info : kernels) {
            for (const uint32_t value :
                 {uint32_t(info.usesBarriers), uint32_t(info.usesWarpFunctions),
                  info.staticSharedBytes, info.localBytes, uint32_t(info.hasLockstep),
                  info.lockstepFrameBytes, uint32_t(info.needsThreads),
                  uint32_t(info.countsOnSteps), uint32_t(info.singleReason.size()),
                  uint32_t(info.unsupported.size())})
                number(value);
            text += info.singleReason + info.unsupported;
        }
        return text + object.serialize();
    }
    // `kernels` already has the descriptions.
    bool deserialize(std::string_view bytes) {
        for (KernelInfo& info : kernels) {
            uint32_t values[10];
            if (bytes.size() < sizeof values)
                return false;
            std::memcpy(values, bytes.data(), sizeof values);
            bytes.remove_prefix(sizeof values);
            if (bytes.size() < uint64_t(values[8]) + values[9])
                return false;
            info.usesBarriers = values[0] != 0;
            info.usesWarpFunctions = values[1] != 0;
            info.staticSharedBytes = values[2];
            info.localBytes = values[3];
            info.hasLockstep = values[4] != 0;
            info.lockstepFrameBytes = values[5];
            info.needsThreads = values[6] != 0;
            info.countsOnSteps = values[7] != 0;
            info.singleReason = std::string(bytes.substr(0, values[8]));
            info.unsupported = std::string(bytes.substr(values[8], values[9]));
            bytes.remove_prefix(size_t(values[8]) + values[9]);
        }
        return object.deserialize(bytes);
    }
};

// One piece: kernels, variables, or all of a module.
class KernelCompilation {
public:
    KernelCompilation(const KernelModules& modules, DebugLevel debugLevel, Variables home)
        : modules_(modules), sources_(kernelsOf(modules)), debugLevel_(debugLevel), home_(home),
          level_(debugLevel == DebugLevel::kFull ? OptLevel::k0 : OptLevel::k3), machine_(level_) {
        begin();
    }

    void addVariables(const std::vector<VariableId>& ids) {
        for (const VariableId& id : ids)
            unit_->addVariable(id);
        unit_->translateQueue();
    }

    // False if a kernel cannot be compiled. The unit is then incomplete, and the caller starts
    // again without that kernel.
    bool addKernels(std::vector<KernelInfo>& kernels) {
        functions_.clear();
        for (KernelInfo& info : kernels) {
            functions_.push_back(nullptr);
            if (!info.unsupported.empty())
                continue;
            try {
                llvm::Function* kernel = declare(info.name);
                kernel->setLinkage(llvm::GlobalValue::ExternalLinkage);
                kernel->setName(kKernelPrefix + info.name);
                kernel->setDSOLocal(true);
                functions_.back() = kernel;
                unit_->translateQueue();
            } catch (const Error& error) {
                // The module may also contain ray tracing programs, which are not kernels.
                if (error.code() != ErrorCode::kNotSupported)
                    throw;
                info.unsupported = error.what();
                begin();
                return false;
            }
        }
        return true;
    }

    CodeObject finish(std::vector<KernelInfo>& kernels, StepTimes& times) {
        times.step("translate");
        describeThreads(*unit_, functions_, kernels);
        const bool wantsLockstep = level_ != OptLevel::k0 && !checks("memory");
        if (wantsLockstep)
            inlineMeetings(*unit_);
        Optimizer optimizer(*unit_, *machine_, level_);
        optimizer.dump("translated");
        verify(*unit_, "translation");
        optimizer.promote();
        lowerFlushes(*unit_, machine_.hasFma());
        verify(*unit_, "flushing");
        optimizer.optimize();
        if (debugLevel_ == DebugLevel::kFull)
            pinVariables(*unit_);
        times.step("optimize");
        if (wantsLockstep) {
            addLockstepCode(optimizer, kernels);
            times.step("lockstep");
        } else {
            for (size_t i = 0; i < functions_.size(); ++i) {
                kernels[i].singleReason = level_ == OptLevel::k0 ? "it was compiled for debugging"
                                                                 : "the memory checker watches it";
                kernels[i].countsOnSteps =
                    functions_[i] &&
                    countsOnSteps(flushedOf(*unit_, *functions_[i]), kernels[i].usesBarriers);
            }
        }
        CodeObject object = generate(*unit_, machine_);
        object.variables = unit_->variableIds();
        object.forDebugger = debugLevel_ >= DebugLevel::kModerate;
        times.step("generate");
        return object;
    }

private:
    void addLockstepCode(Optimizer& optimizer, std::vector<KernelInfo>& kernels) {
        for (size_t i = 0; i < functions_.size(); ++i)
            if (functions_[i])
                addLockstep(*unit_, optimizer, machine_, *functions_[i], kernels[i]);
        verify(*unit_, "lockstep");
        optimizer.dump("lockstep");
    }

    llvm::Function* declare(const std::string& name) {
        for (const KernelSource& source : sources_)
            if (source.function->name == name)
                return unit_->declare(*source.module, *source.function);
        fail(ErrorCode::kInternal, "no kernel ", name);
    }

    void begin() {
        unit_ =
            std::make_unique<Unit>(kernelFlavor(), PipelineRules{}, pointersOf(modules_), home_);
        for (const auto& module : modules_)
            unit_->setOptions(*module, nullptr, debugLevel_);
        prepare(*unit_, machine_);
    }

    const KernelModules& modules_;
    const std::vector<KernelSource> sources_;
    const DebugLevel debugLevel_;
    const Variables home_;
    const OptLevel level_;
    LentMachine machine_;
    std::unique_ptr<Unit> unit_;
    std::vector<llvm::Function*> functions_;
};

class KernelModuleImpl : public KernelModule {
public:
    KernelModuleImpl(KernelModules modules, const KernelOptions& options)
        : modules_(std::move(modules)), options_(options),
          isWhole_(modules_.size() > 1 || callsThroughPointers(*modules_[0])),
          isLong_(areLong(modules_)), kernels_(describeKernels(modules_)) {
        ready_.resize(kernels_.size());
        if (options.debugLevel == DebugLevel::kFull)
            exchanging_ = functionsThatMayExchange(pointersOf(modules_));
        if (isWhole_)
            loadWhole();
        else
            loadVariables();
    }

    const std::vector<KernelInfo>& kernels() const override { return kernels_; }
    bool variable(std::string_view name, void** address, uint64_t* size) const override {
        return table_.find(name, address, size);
    }
    void forEachVariable(const std::function<void(void* address, uint64_t bytes, bool isManaged)>&
                             visit) const override {
        for (const auto& [id, address] : addresses_) {
            const ptx::Variable& variable = variableOf(id);
            if (variable.size != 0)
                visit(address, variable.size, variable.isManaged);
        }
    }

    void prepare(size_t index) override {
        if (ready_[index])
            return;
        KernelObject made = obtainKernel(index);
        loadKernel(index, made);
    }
    void prepareAll() {
        std::vector<KernelObject> objects(kernels_.size());
        std::vector<std::exception_ptr> errors(kernels_.size());
        parallelFor(kernels_.size(), 1, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i)
                try {
                    if (!ready_[i])
                        objects[i] = obtainKernel(i);
                } catch (...) {
                    errors[i] = std::current_exception();
                }
        });
        for (size_t i = 0; i < kernels_.size(); ++i) {
            if (errors[i])
                std::rethrow_exception(errors[i]);
            if (!ready_[i])
                loadKernel(i, objects[i]);
        }
    }

private:
    const ptx::Variable& variableOf(const VariableId& id) const {
        const ptx::Module& module = *modules_[id.module];
        return id.function == VariableId::kModuleScope
                   ? module.variables[id.index]
                   : module.functions[id.function].variables[id.index];
    }

    std::string keyOf(std::string_view what) const {
        Digest digest;
        digest.add(buildId());
        digest.add(targetDescription());
        digest.add(uint64_t(checks("memory")));
        digest.add(uint64_t(wantsRuns()));
        for (const auto& module : modules_)
            digest.add(module->text);
        digest.add(uint64_t(options_.debugLevel));
        digest.add(what);
        return digest.take();
    }

    // From the store, or made by `compile` and stored.
    template <class Compile>
    KernelObject obtain(const std::string& what, std::vector<KernelInfo> kernels,
                        const Compile& compile) const {
        KernelObject made;
        made.kernels = kernels;
        std::string key, bytes;
        if (options_.store) {
            key = keyOf(what);
            if (options_.store->find(key, bytes) && made.deserialize(bytes))
                return made;
        }
        made.kernels = std::move(kernels);
        StepTimes times(what);
        made.object = compile(made.kernels, times);
        if (options_.store)
            options_.store->insert(key, made.serialize());
        return made;
    }

    // Code for a debugger runs thread by thread, with wrong results if lanes exchange values
    // through memory in lockstep. The optimised code shows whether a kernel does so. Such a kernel
    // runs as lockstep code without variables, unless the user asks for single threads.
    KernelObject obtainKernel(size_t index) const {
        const KernelInfo& info = kernels_[index];
        const bool mayExchange = exchanging_.count(info.name) != 0;
        bool countsOnSteps = mayExchange;
        if (mayExchange && !isLong_ && !checks("memory")) {
            KernelObject made = obtainKernel(index, DebugLevel::kModerate, " in step");
            countsOnSteps = made.kernels[0].countsOnSteps;
            if (countsOnSteps && made.kernels[0].hasLockstep &&
                currentConfig(Setting::kKernels) != "single") {
                log(LogLevel::kInfo, "compiler",
                    message("kernel ", info.name,
                            " exchanges values through memory, so its warps run in step and a "
                            "debugger does not see its variables; SUNSTONE_KERNELS=single shows "
                            "them"));
                return made;
            }
        }
        KernelObject made = obtainKernel(index, options_.debugLevel, "");
        if (mayExchange && !checks("memory"))
            made.kernels[0].countsOnSteps = countsOnSteps;
        return made;
    }

    KernelObject obtainKernel(size_t index, DebugLevel level, const char* way) const {
        return obtain(kKernelPrefix + kernels_[index].name + way, {kernels_[index]},
                      [&](std::vector<KernelInfo>& kernels, StepTimes& times) {
                          KernelCompilation compilation(modules_, level, Variables::kReferenced);
                          if (!compilation.addKernels(kernels))
                              return CodeObject();
                          return compilation.finish(kernels, times);
                      });
    }

    void loadVariables() {
        const std::vector<VariableId> ids = variablesOf(modules_);
        if (ids.empty())
            return;
        const KernelObject made =
            obtain("variables", {}, [&](std::vector<KernelInfo>& kernels, StepTimes& times) {
                KernelCompilation compilation(modules_, options_.debugLevel, Variables::kDefined);
                compilation.addVariables(ids);
                return compilation.finish(kernels, times);
            });
        load(made, {});
    }

    void loadWhole() {
        const KernelObject made =
            obtain("module", kernels_, [&](std::vector<KernelInfo>& kernels, StepTimes& times) {
                KernelCompilation compilation(modules_, options_.debugLevel, Variables::kDefined);
                while (!compilation.addKernels(kernels)) {
                }
                compilation.addVariables(variablesOf(modules_));
                return compilation.finish(kernels, times);
            });
        kernels_ = made.kernels;
        for (KernelInfo& info : kernels_) // no optimised code: the tree decides
            info.countsOnSteps |= exchanging_.count(info.name) != 0;
        std::vector<std::string> symbols;
        for (const KernelInfo& info : kernels_)
            addSymbols(info, symbols);
        const LoadedCode& code = load(made, symbols);
        for (size_t i = 0; i < kernels_.size(); ++i) {
            takeAddresses(kernels_[i], code);
            ready_[i] = true;
        }
    }

    static void addSymbols(const KernelInfo& info, std::vector<std::string>& symbols) {
        if (info.unsupported.empty())
            symbols.push_back(kKernelPrefix + info.name);
        if (info.hasLockstep)
            symbols.push_back(kLockstepPrefix + info.name);
    }
    static void takeAddresses(KernelInfo& info, const LoadedCode& code) {
        info.address = code.address(kKernelPrefix + info.name);
        if (info.hasLockstep)
            info.lockstep = code.address(kLockstepPrefix + info.name);
    }

    // Loads a piece that defines variables.
    const LoadedCode& load(const KernelObject& made, std::vector<std::string> symbols) {
        for (const VariableId& id : made.object.variables)
            symbols.push_back(id.symbol());
        code_.push_back(loadObject(made.object, symbols, {}));
        for (const VariableId& id : made.object.variables) {
            addresses_[id] = code_.back()->address(id.symbol());
            table_.add(pointersOf(modules_), id, addresses_[id]);
        }
        return *code_.back();
    }

    void loadKernel(size_t index, const KernelObject& made) {
        KernelInfo info = made.kernels[0];
        if (info.unsupported.empty()) {
            std::vector<std::pair<std::string, void*>> externals;
            for (const VariableId& id : made.object.variables)
                externals.emplace_back(id.symbol(), addresses_.at(id));
            std::vector<std::string> symbols;
            addSymbols(info, symbols);
            code_.push_back(loadObject(made.object, symbols, externals));
            takeAddresses(info, *code_.back());
        }
        kernels_[index] = std::move(info);
        ready_[index] = true;
    }

    const KernelModules modules_;
    const KernelOptions options_;
    const bool isWhole_, isLong_;
    std::vector<KernelInfo> kernels_;
    std::set<std::string_view> exchanging_; // in modules for a debugger
    std::vector<char> ready_;
    std::map<VariableId, void*> addresses_;
    VariableTable table_;
    std::vector<std::unique_ptr<LoadedCode>> code_;
};

} // namespace

std::unique_ptr<KernelModule> openKernels(const KernelModules& modules,
                                          const KernelOptions& options) {
    if (modules.empty() || std::find(modules.begin(), modules.end(), nullptr) != modules.end())
        fail(ErrorCode::kInvalidValue, "no module");
    return std::make_unique<KernelModuleImpl>(modules, options);
}

void checkKernels(const KernelModules& modules) {
    std::vector<KernelInfo> kernels = describeKernels(modules);
    KernelCompilation compilation(modules, DebugLevel::kMinimal, Variables::kDefined);
    while (!compilation.addKernels(kernels)) {
    }
    compilation.addVariables(variablesOf(modules));
}

std::unique_ptr<KernelCode> compileKernels(std::shared_ptr<const ptx::Module> module) {
    if (!module)
        fail(ErrorCode::kInvalidValue, "no module");
    auto code =
        std::make_unique<KernelModuleImpl>(KernelModules{std::move(module)}, KernelOptions{});
    code->prepareAll();
    return code;
}

DebugLevel debugLevelOf(const ptx::Module& module) {
    for (const std::string_view option : module.targetOptions)
        if (option == "debug")
            return DebugLevel::kFull;
    return DebugLevel::kMinimal;
}

} // namespace sunstone::compiler
