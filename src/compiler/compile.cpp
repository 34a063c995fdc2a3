// SPDX-License-Identifier: Apache-2.0
// compilePipeline and compileKernels: the order of the steps from trees to loaded code.
#include "compiler/compiler.h"

#include "base/error.h"
#include "base/log.h"
#include "compiler/flush.h"
#include "compiler/lower_optix.h"
#include "compiler/machine.h"
#include "compiler/optimizer.h"
#include "compiler/shared_layout.h"
#include "compiler/unit.h"

#include <llvm/IR/Verifier.h>

#include <algorithm>
#include <chrono>

namespace sunstone::compiler {

namespace {

using Clock = std::chrono::steady_clock;

// One line per compilation with the time of each step, at level debug.
class StepTimes {
public:
    void step(const char* name) {
        const auto now = Clock::now();
        text_ += message(" ", name, " ",
                         std::chrono::duration<double, std::milli>(now - last_).count(), " ms");
        last_ = now;
    }
    ~StepTimes() {
        if (logEnabled(LogLevel::kDebug, "compiler"))
            log(LogLevel::kDebug, "compiler", "compiled:" + text_);
    }

private:
    Clock::time_point last_ = Clock::now();
    std::string text_;
};

void verify(Unit& unit, const char* step) {
    std::string text;
    llvm::raw_string_ostream stream(text);
    if (llvm::verifyModule(unit.module(), &stream))
        fail(ErrorCode::kInternal, "faulty intermediate code after ", step, ": ", text);
}

void prepare(Unit& unit, LentMachine& machine) {
    unit.module().setDataLayout(machine->createDataLayout());
    unit.module().setTargetTriple(machine->getTargetTriple().str());
}

bool findVariable(const std::map<std::string, uint64_t, std::less<>>& sizes, const LoadedCode& code,
                  std::string_view name, void** address, uint64_t* size) {
    const auto found = sizes.find(name);
    if (found == sizes.end())
        return false;
    void* place = code.address(kVariablePrefix + std::string(name));
    if (!place)
        return false;
    if (address)
        *address = place;
    if (size)
        *size = found->second;
    return true;
}

std::vector<std::string> variableSymbols(Unit& unit) {
    std::vector<std::string> names;
    for (const auto& [name, size] : unit.variableSizes())
        names.push_back(kVariablePrefix + name);
    // Unused ones may have been removed.
    std::erase_if(names, [&](const std::string& name) {
        const llvm::GlobalVariable* variable = unit.module().getNamedGlobal(name);
        return !variable;
    });
    for (const std::string& name : names)
        unit.module().getNamedGlobal(name)->setDSOLocal(true);
    return names;
}

class PipelineCode : public Code {
public:
    const std::vector<CompiledProgram>& programs() const override { return programs_; }
    bool variable(std::string_view name, void** address, uint64_t* size) const override {
        return findVariable(sizes_, *code_, name, address, size);
    }
    std::vector<CompiledProgram> programs_;
    std::map<std::string, uint64_t, std::less<>> sizes_;
    std::unique_ptr<LoadedCode> code_;
};

class KernelCodeImpl : public KernelCode {
public:
    const std::vector<KernelInfo>& kernels() const override { return kernels_; }
    bool variable(std::string_view name, void** address, uint64_t* size) const override {
        return findVariable(sizes_, *code_, name, address, size);
    }
    std::vector<KernelInfo> kernels_;
    std::map<std::string, uint64_t, std::less<>> sizes_;
    std::unique_ptr<LoadedCode> code_;
};

const ptx::Function& requestedFunction(const ProgramRequest& request) {
    if (!request.module)
        fail(ErrorCode::kInvalidValue, "program \"", request.function, "\" has no module");
    const ptx::Function* function = request.module->findFunction(request.function);
    if (!function || !function->hasBody)
        fail(ErrorCode::kNotFound, "the module has no function \"", request.function, "\"");
    if (programKind(request.function) == ProgramKind::kNone)
        fail(ErrorCode::kInvalidValue, "\"", request.function,
             "\" has none of the prefixes that make a function a program");
    return *function;
}

// The variable may be declared in several modules, which must agree on its size.
void checkLaunchParams(const PipelineRequest& request) {
    const ptx::Variable* first = nullptr;
    if (request.rules.launchParams.empty())
        return;
    for (const ProgramRequest& program : request.programs) {
        const ptx::Variable* variable = program.module->findVariable(request.rules.launchParams);
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

} // namespace

std::unique_ptr<Code> compilePipeline(const PipelineRequest& request) {
    StepTimes times;
    std::vector<const ptx::Module*> modules;
    OptLevel level = OptLevel::k0;
    for (const ProgramRequest& program : request.programs) {
        requestedFunction(program);
        if (std::find(modules.begin(), modules.end(), program.module.get()) == modules.end())
            modules.push_back(program.module.get());
        level = std::max(level, program.optLevel);
    }
    checkLaunchParams(request);

    LentMachine machine(level);
    Unit unit(Flavor::kOptix, request.rules, modules);
    prepare(unit, machine);
    times.step("set-up");

    ProgramKinds kinds;
    std::vector<llvm::Function*> functions;
    for (const ProgramRequest& program : request.programs) {
        llvm::Function* function = unit.declare(*program.module, requestedFunction(program));
        functions.push_back(function);
        if (kinds.emplace(function, programKind(program.function)).second) {
            function->setLinkage(llvm::GlobalValue::ExternalLinkage);
            function->setName("program" + std::to_string(functions.size()) + "." +
                              program.function);
            function->setDSOLocal(true);
        }
    }
    unit.translateQueue();
    times.step("translate");

    Optimizer optimizer(unit, *machine, level);
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

    auto code = std::make_unique<PipelineCode>();
    std::vector<std::string> symbols = variableSymbols(unit);
    std::vector<std::string> names;
    for (llvm::Function* function : functions)
        names.push_back(function->getName().str());
    symbols.insert(symbols.end(), names.begin(), names.end());
    std::sort(symbols.begin(), symbols.end());
    symbols.erase(std::unique(symbols.begin(), symbols.end()), symbols.end());
    code->code_ = loadModule(unit, machine, symbols);
    code->sizes_ = unit.variableSizes();
    for (const std::string& name : names)
        code->programs_.push_back(
            {code->code_->address(name),
             std::max(16u, code->code_->stackSize(name) +
                               code->code_->stackSize(name + kFlushedSuffix))});
    times.step("generate");
    return code;
}

namespace {

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
    const auto product = [](const uint32_t(&threads)[3]) {
        return threads[0] * std::max(1u, threads[1]) * std::max(1u, threads[2]);
    };
    info.maxThreadsPerBlock = product(function.requiredThreads);
    if (info.maxThreadsPerBlock == 0)
        info.maxThreadsPerBlock = product(function.maxThreads);
    return info;
}

// Translates every kernel that can be; false if one had to be given up, which leaves the unit
// half-made: the caller starts again without it.
bool translateKernels(Unit& unit, const ptx::Module& module, std::vector<KernelInfo>& kernels,
                      std::vector<llvm::Function*>& functions) {
    size_t number = 0;
    for (const ptx::Function& function : module.functions) {
        if (!function.isEntry || !function.hasBody)
            continue;
        KernelInfo& info = kernels[number++];
        functions.push_back(nullptr);
        if (!info.unsupported.empty())
            continue;
        try {
            llvm::Function* kernel = unit.declare(module, function);
            kernel->setLinkage(llvm::GlobalValue::ExternalLinkage);
            kernel->setName("kernel." + info.name);
            kernel->setDSOLocal(true);
            functions.back() = kernel;
            unit.translateQueue();
        } catch (const Error& error) {
            // Programs of OptiX may stand in the same module; they are no kernels.
            const bool isProgram = programKind(info.name) != ProgramKind::kNone;
            if (error.code() != ErrorCode::kNotSupported && !isProgram)
                throw;
            info.unsupported = error.what();
            return false;
        }
    }
    return true;
}

} // namespace

std::unique_ptr<KernelCode> compileKernels(std::shared_ptr<const ptx::Module> module) {
    if (!module)
        fail(ErrorCode::kInvalidValue, "no module");
    StepTimes times;
    auto code = std::make_unique<KernelCodeImpl>();
    for (const ptx::Function& function : module->functions)
        if (function.isEntry && function.hasBody)
            code->kernels_.push_back(describeKernel(function));

    LentMachine machine(OptLevel::k3);
    std::unique_ptr<Unit> unit;
    std::vector<llvm::Function*> functions;
    for (bool done = false; !done;) {
        unit = std::make_unique<Unit>(Flavor::kKernel, PipelineRules{},
                                      std::vector<const ptx::Module*>{module.get()});
        prepare(*unit, machine);
        functions.clear();
        done = translateKernels(*unit, *module, code->kernels_, functions);
    }
    unit->addAllVariables();
    unit->translateQueue();
    times.step("translate");

    describeThreads(*unit, functions, code->kernels_);
    Optimizer optimizer(*unit, *machine, OptLevel::k3);
    optimizer.dump("translated");
    verify(*unit, "translation");
    optimizer.promote();
    lowerFlushes(*unit, machine.hasFma());
    verify(*unit, "flushing");
    optimizer.optimize();
    times.step("optimize");

    std::vector<std::string> symbols = variableSymbols(*unit);
    for (llvm::Function* function : functions)
        if (function)
            symbols.push_back(function->getName().str());
    code->code_ = loadModule(*unit, machine, symbols);
    code->sizes_ = unit->variableSizes();
    for (size_t i = 0; i < functions.size(); ++i)
        if (functions[i])
            code->kernels_[i].address = code->code_->address("kernel." + code->kernels_[i].name);
    times.step("generate");
    return code;
}

} // namespace sunstone::compiler
