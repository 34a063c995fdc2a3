// SPDX-License-Identifier: Apache-2.0
// Symbols across modules; variables and their initialisers.
#include "compiler/translate/unit.h"

#include "base/error.h"
#include "compiler/debug/debug_info.h"
#include "compiler/translate/callable.h"
#include "compiler/translate/function_translator.h"

#include <llvm/IR/Constants.h>

#include <algorithm>

namespace sunstone::compiler {

namespace {

bool isScalar(const ptx::Variable& variable) {
    return !variable.isArray && variable.vector == 1;
}

unsigned scalarBits(const ptx::Variable& variable) {
    return variable.type == ptx::Type::kPred ? 1 : ptx::sizeOf(variable.type) * 8;
}

// One of several equal definitions is used for all.
bool isWeak(const ptx::Variable& variable) {
    return variable.linkage == ptx::Linkage::kWeak || variable.linkage == ptx::Linkage::kCommon;
}

bool isDefined(const ptx::Variable& variable) {
    return variable.linkage != ptx::Linkage::kExtern;
}

// Whether the toolkit's device run-time has the function for kernels that launch kernels.
bool launchesKernels(std::string_view name) {
    return name.starts_with("__cuda_syscall_") || name.starts_with("cudaGetParameterBuffer") ||
           name.starts_with("cudaLaunchDevice");
}

} // namespace

Unit::Unit(const Flavor& flavor, PipelineRules rules, std::vector<const ptx::Module*> modules,
           Variables variables)
    : flavor_(flavor), home_(variables), rules_(std::move(rules)), modules_(std::move(modules)),
      context_(std::make_unique<llvm::LLVMContext>()),
      module_(std::make_unique<llvm::Module>("sunstone", *context_)), options_(modules_.size()) {
    for (const ptx::Module* module : modules_)
        collect(*module);
}

std::string Unit::moduleLabel(const ptx::Module* module) const {
    for (size_t i = 0; i < modules_.size(); ++i)
        if (modules_[i] == module)
            return "module " + std::to_string(i + 1);
    return "module";
}

void Unit::publish(std::string_view name, Definition definition) {
    if (!flavor_.linksModules())
        return;
    const auto [entry, inserted] = published_.emplace(name, definition);
    if (inserted)
        return;
    Definition& earlier = entry->second;
    if (definition.weak || earlier.module == definition.module)
        return;
    if (earlier.weak) {
        earlier = definition;
        return;
    }
    const auto line = [](const Definition& d) {
        return d.function ? d.function->location.line : d.variable->location.line;
    };
    fail(ErrorCode::kLinkError, "symbol \"", name, "\" is defined twice: in ",
         moduleLabel(earlier.module), " at line ", line(earlier), " and in ",
         moduleLabel(definition.module), " at line ", line(definition));
}

void Unit::collect(const ptx::Module& module) {
    Symbols& symbols = symbols_[&module];
    for (const ptx::Function& function : module.functions) {
        const ptx::Function*& entry = symbols.functions[function.name];
        if (!entry || (function.hasBody && !entry->hasBody))
            entry = &function;
        // Programs are named by (module, function) pairs, so equal names do not clash.
        if (function.hasBody && !function.isEntry && function.linkage != ptx::Linkage::kInternal &&
            !flavor_.isProgramName(function.name))
            publish(function.name,
                    {&module, &function, nullptr, function.linkage == ptx::Linkage::kWeak});
    }
    for (const auto& [alias, target] : module.aliases) {
        const auto found = symbols.functions.find(target);
        if (found != symbols.functions.end())
            symbols.functions[alias] = found->second;
    }
    for (const ptx::Variable& variable : module.variables) {
        const ptx::Variable*& entry = symbols.variables[variable.name];
        if (!entry || (isDefined(variable) && !isDefined(*entry)))
            entry = &variable;
        if (isDefined(variable) && variable.linkage != ptx::Linkage::kInternal &&
            variable.space != ptx::Space::kShared && !isLaunchParams(variable))
            publish(variable.name, {&module, nullptr, &variable, isWeak(variable)});
    }
}

const Unit::Definition* Unit::published(std::string_view name) const {
    const auto found = published_.find(name);
    return found == published_.end() ? nullptr : &found->second;
}

bool Unit::isLaunchParams(const ptx::Variable& variable) const {
    return !flavor_.isKernels() && !rules_.launchParams.empty() &&
           variable.space == ptx::Space::kConst && variable.name == rules_.launchParams;
}

void Unit::setOptions(const ptx::Module& module, std::shared_ptr<const ModuleRules> rules,
                      DebugLevel level) {
    options_[moduleNumber(module)] = {std::move(rules), level};
}

Unit::~Unit() = default;

DebugInfo& Unit::debugInfo() {
    if (!debugInfo_)
        debugInfo_ = std::make_unique<DebugInfo>(*this);
    return *debugInfo_;
}

uint32_t Unit::moduleNumber(const ptx::Module& module) const {
    const auto found = std::find(modules_.begin(), modules_.end(), &module);
    SUNSTONE_CHECK(found != modules_.end());
    return uint32_t(found - modules_.begin());
}

const ModuleRules& Unit::moduleRules(uint32_t moduleNumber) const {
    static const ModuleRules none;
    const auto& rules = options_[moduleNumber].rules;
    return rules ? *rules : none;
}

bool Unit::hasLineInfo(const ptx::Module& module) const {
    return options_[moduleNumber(module)].level != DebugLevel::kNone;
}

// ---- functions --------------------------------------------------------------------------------

Signature Unit::signature(const std::vector<ptx::Variable>& results,
                          const std::vector<ptx::Variable>& parameters) {
    llvm::Type* pointer = llvm::PointerType::getUnqual(*context_);
    std::vector<llvm::Type*> types = {pointer};
    Signature signature;
    llvm::Type* result = llvm::Type::getVoidTy(*context_);
    if (results.size() == 1 && isScalar(results[0])) {
        signature.returnsValue = true;
        result = llvm::Type::getIntNTy(*context_, scalarBits(results[0]));
    } else {
        types.insert(types.end(), results.size(), pointer);
    }
    for (const ptx::Variable& parameter : parameters)
        types.push_back(isScalar(parameter) ? static_cast<llvm::Type*>(llvm::Type::getIntNTy(
                                                  *context_, scalarBits(parameter)))
                                            : pointer);
    signature.type = llvm::FunctionType::get(result, types, false);
    return signature;
}

llvm::Function* Unit::declare(const ptx::Module& module, const ptx::Function& function) {
    llvm::Function*& entry = functions_[&function];
    if (entry)
        return entry;
    llvm::FunctionType* type = nullptr;
    llvm::Type* pointer = llvm::PointerType::getUnqual(*context_);
    if (function.isEntry && flavor_.isKernels())
        type = llvm::FunctionType::get(llvm::Type::getVoidTy(*context_), {pointer, pointer}, false);
    else if (function.isEntry)
        type = llvm::FunctionType::get(llvm::Type::getInt32Ty(*context_), {pointer}, false);
    else
        type = signature(function.results, function.parameters).type;
    entry = llvm::Function::Create(type, llvm::GlobalValue::InternalLinkage,
                                   kFunctionPrefix + std::string(function.name), *module_);
    entry->addFnAttr(llvm::Attribute::NoUnwind);
    entry->addFnAttr("warn-stack-size", "0");
    entry->setAlignment(llvm::Align(kFunctionAlignment));
    // The hidden state pointers are ours: user memory never holds or reaches them.
    entry->addParamAttr(0, llvm::Attribute::NoAlias);
    entry->addParamAttr(0, llvm::Attribute::NonNull);
    const uint64_t stateBytes =
        flavor_.isKernels() ? sizeof(devlib::KernelThread) : sizeof(devlib::RayState);
    entry->addParamAttr(0, llvm::Attribute::getWithDereferenceableBytes(*context_, stateBytes));
    if (!flavor_.isKernels())
        entry->addParamAttr(0, llvm::Attribute::getWithAlignment(*context_, llvm::Align(64)));
    facts_[entry] = {&module, &function};
    functionQueue_.push_back(entry);
    return entry;
}

const char* providedFunction(std::string_view name, bool isKernels) {
    for (const auto& [provided, target] :
         {std::pair<std::string_view, const char*>{"vprintf", "sunstone_vprintf"},
          {"malloc", "sunstone_malloc"},
          {"free", "sunstone_free"},
          {"__assertfail", isKernels ? "sunstone_kernel_assertfail" : "sunstone_assertfail"}})
        if (provided == name)
            return target;
    return nullptr;
}

llvm::Function* Unit::runtimeFunction(std::string_view name, const ptx::Module& from) {
    const char* symbol = providedFunction(name, flavor_.isKernels());
    const auto found = symbols_[&from].functions.find(name);
    if (!symbol || found == symbols_[&from].functions.end())
        return nullptr;
    if (llvm::Function* existing = module_->getFunction(symbol))
        return existing;
    auto* function =
        llvm::Function::Create(signature(found->second->results, found->second->parameters).type,
                               llvm::GlobalValue::ExternalLinkage, symbol, *module_);
    function->addFnAttr(llvm::Attribute::NoUnwind);
    return function;
}

bool Unit::knowsFunction(const ptx::Module& from, std::string_view name) const {
    const auto found = symbols_.at(&from).functions.find(name);
    return found != symbols_.at(&from).functions.end() || flavor_.isIntrinsicName(name);
}

llvm::Function* Unit::function(const ptx::Module& from, std::string_view name,
                               ptx::Location location) {
    const auto& own = symbols_[&from].functions;
    const auto found = own.find(name);
    if (found != own.end() && found->second->hasBody)
        return declare(from, *found->second);
    if (found == own.end())
        failAt(ErrorCode::kInvalidPtx, location, "function \"", name, "\" is not declared");
    if (const Definition* definition = published(name)) {
        if (!definition->function)
            failAt(ErrorCode::kLinkError, location, "\"", name,
                   "\" is called here, but another module defines it as a variable");
        const Signature wanted = signature(found->second->results, found->second->parameters);
        llvm::Function* target = declare(*definition->module, *definition->function);
        if (target->getFunctionType() != wanted.type)
            failAt(ErrorCode::kLinkError, location, "function \"", name,
                   "\" is declared here with ", "other parameters or results than ",
                   moduleLabel(definition->module), " defines it with at line ",
                   definition->function->location.line);
        return target;
    }
    if (llvm::Function* provided = runtimeFunction(name, from))
        return provided;
    if (flavor_.isKernels() && launchesKernels(name))
        failAt(ErrorCode::kNotSupported, location, "\"", name,
               "\" is not available: kernels cannot launch kernels");
    failAt(ErrorCode::kLinkError, location, "function \"", name,
           "\" is declared, but no module of the program defines it");
}

llvm::Function* Unit::intrinsic(const Intrinsic& intrinsic, std::string_view fullName) {
    const llvm::StringRef name(fullName.data(), fullName.size());
    if (llvm::Function* existing = module_->getFunction(name))
        return existing;
    const auto typeOf = [&](char letter) -> llvm::Type* {
        return letter == 'r'   ? llvm::Type::getInt32Ty(*context_)
               : letter == 'l' ? static_cast<llvm::Type*>(llvm::Type::getInt64Ty(*context_))
               : letter == 'p' ? llvm::PointerType::getUnqual(*context_)
                               : llvm::Type::getFloatTy(*context_);
    };
    // The hidden state is an operand: after inlining it is the program's own.
    std::vector<llvm::Type*> operands = {llvm::PointerType::getUnqual(*context_)};
    for (char letter : intrinsic.operands)
        operands.push_back(typeOf(letter));
    std::vector<llvm::Type*> results;
    for (char letter : intrinsic.results)
        results.push_back(typeOf(letter));
    llvm::Type* result = results.empty()       ? llvm::Type::getVoidTy(*context_)
                         : results.size() == 1 ? results[0]
                                               : llvm::StructType::get(*context_, results);
    auto* function = llvm::Function::Create(llvm::FunctionType::get(result, operands, false),
                                            llvm::GlobalValue::ExternalLinkage, name, *module_);
    function->addFnAttr(llvm::Attribute::NoUnwind);
    if (intrinsic.reads) {
        function->setMemoryEffects(llvm::MemoryEffects::inaccessibleMemOnly(llvm::ModRefInfo::Ref));
        function->addFnAttr(llvm::Attribute::WillReturn);
    }
    intrinsics_[function] = &intrinsic;
    return function;
}

const Intrinsic* Unit::intrinsicOf(const llvm::Function* function) const {
    const auto found = intrinsics_.find(function);
    return found == intrinsics_.end() ? nullptr : found->second;
}

llvm::FunctionCallee Unit::helper(const char* name, llvm::Type* result,
                                  llvm::ArrayRef<llvm::Type*> operands, bool pure) {
    if (llvm::Function* existing = module_->getFunction(name))
        return existing;
    auto* function = llvm::Function::Create(llvm::FunctionType::get(result, operands, false),
                                            llvm::GlobalValue::ExternalLinkage, name, *module_);
    function->addFnAttr(llvm::Attribute::NoUnwind);
    if (pure) {
        function->setMemoryEffects(llvm::MemoryEffects::none());
        function->addFnAttr(llvm::Attribute::WillReturn);
        function->addFnAttr(llvm::Attribute::Speculatable);
    }
    return function;
}

llvm::Value* Unit::launchFunction(llvm::IRBuilder<>& builder, llvm::Value* launch, size_t offset,
                                  const char* name, llvm::FunctionType* type) {
    if (isGpu()) {
        const std::string symbol = std::string("sunstone_gpu_") + name;
        if (llvm::Function* existing = module_->getFunction(symbol))
            return existing;
        auto* function =
            llvm::Function::Create(type, llvm::GlobalValue::ExternalLinkage, symbol, *module_);
        function->addFnAttr(llvm::Attribute::NoUnwind);
        return function;
    }
    llvm::Value* place =
        builder.CreateInBoundsGEP(builder.getInt8Ty(), launch, builder.getInt64(offset));
    auto* loaded = builder.CreateAlignedLoad(builder.getPtrTy(), place, llvm::Align(8));
    loaded->setMetadata(llvm::LLVMContext::MD_invariant_load, llvm::MDNode::get(*context_, {}));
    return loaded;
}

void Unit::needHeader(const ptx::Module& module, const ptx::Instruction& instruction) {
    if (llvm::none_of(headerNeeds_, [&](const HeaderNeed& need) { return need.module == &module; }))
        headerNeeds_.push_back({&module, &instruction});
}

void Unit::translateQueue() {
    while (!functionQueue_.empty() || !variableQueue_.empty()) {
        if (!functionQueue_.empty()) {
            llvm::Function* function = functionQueue_.front();
            functionQueue_.pop_front();
            FunctionTranslator(*this, *function, facts_[function]).translate();
        } else {
            const auto [module, variable] = variableQueue_.front();
            variableQueue_.pop_front();
            variables_[variable]->setInitializer(initializer(*module, *variable));
        }
    }
    if (debugInfo_)
        debugInfo_->finish();
}

// ---- variables --------------------------------------------------------------------------------

const ptx::Variable* Unit::findVariable(const ptx::Module& from, std::string_view name) const {
    const auto& own = symbols_.at(&from).variables;
    const auto found = own.find(name);
    return found == own.end() ? nullptr : found->second;
}

llvm::Constant* Unit::variable(const ptx::Module& from, std::string_view name,
                               ptx::Location location) {
    const ptx::Variable* variable = findVariable(from, name);
    if (!variable)
        failAt(ErrorCode::kInvalidPtx, location, "\"", name, "\" is not declared");
    const Definition* definition = published(name);
    const bool shared = isWeak(*variable) && definition && definition->variable;
    if (isDefined(*variable) && !shared)
        return addVariable(from, *variable);
    if (!definition || !definition->variable)
        failAt(ErrorCode::kLinkError, location, "variable \"", name,
               "\" is extern, but no module of the program defines it",
               rules_.launchParams.empty()
                   ? std::string()
                   : message("; the launch parameters are \"", rules_.launchParams, "\""));
    return addVariable(*definition->module, *definition->variable);
}

VariableId Unit::idOf(const ptx::Module& module, const ptx::Variable& variable) const {
    VariableId id;
    id.module = uint32_t(std::find(modules_.begin(), modules_.end(), &module) - modules_.begin());
    const auto within = [&](const std::vector<ptx::Variable>& list) {
        // std::less also orders pointers into different arrays.
        const std::less<const ptx::Variable*> before;
        if (list.empty() || before(&variable, list.data()) || before(&list.back(), &variable))
            return false;
        id.index = uint32_t(&variable - list.data());
        return true;
    };
    if (within(module.variables))
        return id;
    for (id.function = 0; id.function < module.functions.size(); ++id.function)
        if (within(module.functions[id.function].variables))
            return id;
    fail(ErrorCode::kInternal, "variable \"", variable.name, "\" is in no module");
}

void Unit::addVariable(const VariableId& id) {
    if (id.module < modules_.size()) {
        const ptx::Module& module = *modules_[id.module];
        const bool isLocal = id.function < module.functions.size();
        if (isLocal || id.function == VariableId::kModuleScope) {
            const auto& list = isLocal ? module.functions[id.function].variables : module.variables;
            if (id.index < list.size()) {
                addVariable(module, list[id.index]);
                return;
            }
        }
    }
    fail(ErrorCode::kInternal, "no variable ", id.symbol());
}

llvm::Constant* Unit::addVariable(const ptx::Module& module, const ptx::Variable& variable) {
    llvm::GlobalVariable*& entry = variables_[&variable];
    if (entry)
        return entry;
    if (variable.type == ptx::Type::kSamplerref)
        failAt(ErrorCode::kNotSupported, variable.location, "samplers of their own (\"",
               variable.name, "\") are not available");
    // Internal constants may be folded into the code: each piece has its own copy.
    constexpr uint64_t kCopyLimit = 4096;
    const bool fixed = !flavor_.isKernels() && variable.space == ptx::Space::kConst &&
                       variable.linkage == ptx::Linkage::kInternal && variable.size <= kCopyLimit;
    const VariableId id = idOf(module, variable);
    entry = new llvm::GlobalVariable(*module_, initializerType(variable), fixed,
                                     fixed ? llvm::GlobalValue::InternalLinkage
                                           : llvm::GlobalValue::ExternalLinkage,
                                     nullptr, id.symbol());
    entry->setAlignment(llvm::Align(std::max(1u, variable.alignment)));
    if (!fixed)
        ids_.push_back(id);
    if (fixed || home_ == Variables::kDefined) {
        entry->setDSOLocal(true);
        variableQueue_.emplace_back(&module, &variable);
    }
    return entry;
}

std::vector<std::pair<const ptx::Module*, const ptx::Variable*>> Unit::constants() const {
    std::vector<std::pair<const ptx::Module*, const ptx::Variable*>> found;
    const auto add = [&](const ptx::Module* module, const std::vector<ptx::Variable>& variables) {
        for (const ptx::Variable& variable : variables)
            if (variable.space == ptx::Space::kConst &&
                (isDefined(variable) || isLaunchParams(variable)))
                found.emplace_back(module, &variable);
    };
    for (const ptx::Module* module : modules_) {
        add(module, module->variables);
        for (const ptx::Function& function : module->functions)
            add(module, function.variables);
    }
    return found;
}

// Runs of plain bytes and 64-bit words for addresses, in order, packed.
llvm::Type* Unit::initializerType(const ptx::Variable& variable) {
    llvm::Type* byte = llvm::Type::getInt8Ty(*context_);
    if (variable.relocations.empty())
        return llvm::ArrayType::get(byte, variable.size);
    std::vector<llvm::Type*> parts;
    uint64_t at = 0;
    for (const ptx::Relocation& relocation : variable.relocations) {
        if (relocation.mask != 0 || relocation.size != 8)
            failAt(ErrorCode::kNotSupported, variable.location, "the initialiser of \"",
                   variable.name, "\" takes single bytes of the address of \"", relocation.symbol,
                   "\"");
        if (relocation.offset < at || relocation.offset + 8 > variable.size)
            failAt(ErrorCode::kInvalidPtx, variable.location, "bad initialiser of \"",
                   variable.name, "\"");
        if (relocation.offset > at)
            parts.push_back(llvm::ArrayType::get(byte, relocation.offset - at));
        parts.push_back(llvm::Type::getInt64Ty(*context_));
        at = relocation.offset + 8;
    }
    if (variable.size > at)
        parts.push_back(llvm::ArrayType::get(byte, variable.size - at));
    return llvm::StructType::get(*context_, parts, true);
}

llvm::Constant* Unit::initializer(const ptx::Module& module, const ptx::Variable& variable) {
    std::vector<uint8_t> bytes = variable.initializer;
    bytes.resize(variable.size);
    if (variable.relocations.empty())
        return llvm::ConstantDataArray::get(*context_, llvm::ArrayRef<uint8_t>(bytes));

    std::vector<llvm::Constant*> parts;
    uint64_t at = 0;
    const auto addBytes = [&](uint64_t end) {
        if (end > at)
            parts.push_back(llvm::ConstantDataArray::get(
                *context_, llvm::ArrayRef<uint8_t>(bytes).slice(at, end - at)));
        at = end;
    };
    for (const ptx::Relocation& relocation : variable.relocations) {
        addBytes(relocation.offset);
        const bool isVariable = findVariable(module, relocation.symbol) != nullptr;
        llvm::Constant* symbol = isVariable
                                     ? this->variable(module, relocation.symbol, variable.location)
                                     : function(module, relocation.symbol, variable.location);
        llvm::Type* word = llvm::Type::getInt64Ty(*context_);
        parts.push_back(
            llvm::ConstantExpr::getAdd(llvm::ConstantExpr::getPtrToInt(symbol, word),
                                       llvm::ConstantInt::getSigned(word, relocation.addend)));
        at += 8;
    }
    addBytes(variable.size);
    return llvm::ConstantStruct::getAnon(*context_, parts, true);
}

llvm::Constant* Unit::sharedOffset(const ptx::Variable& variable, llvm::Function* user) {
    SharedVariable*& entry = sharedIndex_[&variable];
    if (!entry) {
        shared_.emplace_back();
        entry = &shared_.back();
        entry->variable = &variable;
        entry->dynamic = variable.linkage == ptx::Linkage::kExtern && variable.size == 0;
        entry->placeholder = new llvm::GlobalVariable(
            *module_, llvm::Type::getInt8Ty(*context_), false, llvm::GlobalValue::ExternalLinkage,
            nullptr, "sunstone.shared." + std::to_string(shared_.size()));
    }
    entry->users.insert(user);
    return llvm::ConstantExpr::getPtrToInt(entry->placeholder, llvm::Type::getInt64Ty(*context_));
}

} // namespace sunstone::compiler
