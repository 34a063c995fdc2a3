// SPDX-License-Identifier: Apache-2.0
// compileKernels: the order of the steps from a CUDA module's tree to loaded code.
#include "compiler/compile_steps.h"
#include "compiler/flush.h"
#include "compiler/machine.h"
#include "compiler/optimizer.h"
#include "compiler/shared_layout.h"

#include <algorithm>

namespace sunstone::compiler {

namespace {

class KernelCodeImpl : public KernelCode {
public:
    const std::vector<KernelInfo>& kernels() const override { return kernels_; }
    bool variable(std::string_view name, void** address, uint64_t* size) const override {
        return variables_.find(name, address, size);
    }
    std::vector<KernelInfo> kernels_;
    VariableTable variables_;
    std::unique_ptr<LoadedCode> code_;
};

} // namespace

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
    StepTimes times("kernels");
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

    std::vector<std::string> symbols;
    for (const VariableId& id : unit->variableIds())
        symbols.push_back(id.symbol());
    for (llvm::Function* function : functions)
        if (function)
            symbols.push_back(function->getName().str());
    code->code_ = loadObject(generate(*unit, machine), symbols, {});
    for (const VariableId& id : unit->variableIds())
        code->variables_.add({module.get()}, id, code->code_->address(id.symbol()));
    for (size_t i = 0; i < functions.size(); ++i)
        if (functions[i])
            code->kernels_[i].address = code->code_->address("kernel." + code->kernels_[i].name);
    times.step("generate");
    return code;
}

} // namespace sunstone::compiler
