// SPDX-License-Identifier: Apache-2.0
// See module.h.
#include "api/cuda/driver/modules/module.h"

#include "api/cuda/driver/modules/fat_binary.h"
#include "api/cuda/driver/modules/libraries.h"
#include "base/handles.h"
#include "base/log.h"
#include "base/process_end.h"
#include "engine/compile_cache.h"
#include "ptx/parse/parser.h"

#include <chrono>
#include <cstring>

using namespace sunstone;
using namespace sunstone::api::cuda;

namespace sunstone::api::cuda {

namespace {

HandleTable<Function>& functionTable() {
    static auto* table = new HandleTable<Function>;
    return *table;
}

HandleTable<Module>& moduleTable() {
    static auto* table = [] {
        cpu::contexts().onDestroy([](cpu::Context* context) {
            auto dead = moduleTable().removeIf(
                [&](const Module& module) { return module.owner() == context; });
            for (const auto& module : dead)
                module->retire();
        });
        return new HandleTable<Module>;
    }();
    return *table;
}

// One cache for the process, opened by the first kernel.
const std::shared_ptr<engine::CompileCache>& compileCache() {
    static const auto* cache = [] {
        auto made = std::make_shared<engine::CompileCache>([](LogLevel level,
                                                              const std::string& text) {
            log(level == LogLevel::kInfo ? LogLevel::kDebug : level, "cuda", "disk cache: " + text);
        });
        made->start();
        return new std::shared_ptr<engine::CompileCache>(std::move(made));
    }();
    return *cache;
}

CUresult loadImage(const char* function, CUmodule* module, const void* image, unsigned count,
                   const CUjit_option* options, void** values) {
    return guarded(function, Needs::kContext, [&] {
        require(module, "module is null");
        const JitOptions jit(count, options, values);
        *module = makeModule(parseImage(ptxOfImage(image), jit));
    });
}

} // namespace

// Kernels that rely on lanes of a warp in step, without synchronisation, may have other results if
// threads run one by one.
static void reportThreads(const compiler::KernelInfo& info) {
    if (info.singleReason.empty())
        return;
    const bool mayDiffer = info.usesWarpFunctions || info.countsOnSteps;
    const LogLevel level = mayDiffer ? LogLevel::kWarning : LogLevel::kDebug;
    if (logEnabled(level, "cuda"))
        log(level, "cuda",
            message("kernel ", info.name, " runs thread by thread: ", info.singleReason));
}

ParsedImage parseImage(const std::vector<std::string>& texts, JitOptions options) {
    const auto start = std::chrono::steady_clock::now();
    const auto milliseconds = [&] {
        return std::chrono::duration<float, std::milli>(std::chrono::steady_clock::now() - start)
            .count();
    };
    ParsedImage image{{}, compiler::DebugLevel::kFull};
    std::string warnings;
    try {
        for (const std::string& text : texts)
            image.trees.push_back(parsePtx(text, &warnings));
    } catch (const Failure& failure) {
        options.report({}, failure.what(), milliseconds());
        throw;
    }
    options.report(warnings, {}, milliseconds());
    if (!options.debug())
        image.debugLevel = compiler::debugLevelOf(*image.trees[0]);
    return image;
}

CUmodule makeModule(const ParsedImage& image) {
    watchProcessEnd(); // afterwards the module's owner may unload it
    return static_cast<CUmodule>(moduleTable().add(
        std::make_shared<Module>(image.trees, cpu::contexts().current(), image.debugLevel)));
}

void unloadModule(CUmodule module) {
    if (auto dead = moduleTable().remove(module))
        dead->retire();
}

std::shared_ptr<const ptx::Module> parsePtx(const std::string& text, std::string* warnings) {
    ptx::Diagnostics diagnostics;
    std::shared_ptr<const ptx::Module> tree = ptx::parse(text, diagnostics);
    if (!tree)
        throw Failure(CUDA_ERROR_INVALID_PTX, diagnostics.format());
    *warnings += diagnostics.format();
    return tree;
}

Module::Module(std::vector<std::shared_ptr<const ptx::Module>> trees, const void* owner,
               compiler::DebugLevel debugLevel)
    : trees_(std::move(trees)), owner_(owner), debugLevel_(debugLevel) {}

Module::~Module() {
    for (const void* address : adopted_)
        cpu::memory().release(address,
                              {cpu::MemoryKind::kModule, cpu::MemoryKind::kManagedVariable});
}

int Module::ptxVersion() const {
    int version = 0;
    for (char c : trees_[0]->target)
        if (c >= '0' && c <= '9' && version < 1'000'000) // the text is untrusted
            version = version * 10 + (c - '0');
    return version;
}

void Module::open() {
    if (code_)
        return;
    code_ = compiler::openKernels(trees_, {debugLevel_, compileCache()});
    code_->forEachVariable([&](void* address, uint64_t size, bool isManaged) {
        if (cpu::memory().adopt(address, size,
                                isManaged ? cpu::MemoryKind::kManagedVariable
                                          : cpu::MemoryKind::kModule,
                                0, owner_))
            adopted_.push_back(address);
    });
    for (size_t i = 0; i < code_->kernels().size(); ++i) {
        auto function = std::make_shared<Function>();
        function->module = weak_from_this();
        function->info = &code_->kernels()[i];
        function->name = function->info->name;
        function->index = i;
        functions_[function->name] = function;
        functionTable().add(function);
    }
}

void Module::compile(Function& function) {
    std::lock_guard lock(mutex_);
    code_->prepare(function.index);
    reportThreads(*function.info);
    function.compiled.store(true, std::memory_order_release);
}

Function* Module::function(const std::string& name) {
    std::lock_guard lock(mutex_);
    open();
    const auto found = functions_.find(name);
    return found == functions_.end() ? nullptr : found->second.get();
}

size_t Module::functionCount() {
    std::lock_guard lock(mutex_);
    open();
    return functions_.size();
}

std::vector<Function*> Module::functions() {
    std::lock_guard lock(mutex_);
    open();
    std::vector<Function*> result;
    for (auto& [name, function] : functions_)
        result.push_back(function.get());
    return result;
}

bool Module::variable(const std::string& name, void** address, uint64_t* size) {
    std::lock_guard lock(mutex_);
    open();
    return code_->variable(name, address, size);
}

ptx::Type Module::referenceType(const std::string& name) const {
    for (const auto& tree : trees_)
        if (const ptx::Variable* found = tree->findVariable(name);
            found && found->type >= ptx::Type::kTexref)
            return found->type;
    return ptx::Type::kNone;
}

void Module::retire() {
    std::lock_guard lock(mutex_);
    for (auto& [name, function] : functions_)
        functionTable().remove(function->handle());
}

std::shared_ptr<Module> findModule(CUmodule module) {
    return moduleTable().find(module);
}

std::shared_ptr<Module> moduleOf(CUmodule module) {
    auto found = findModule(module);
    if (!found)
        refuse(CUDA_ERROR_INVALID_HANDLE, static_cast<void*>(module), " is not a live module");
    return found;
}

std::shared_ptr<Function> liveFunctionOf(CUfunction function) {
    auto found = functionTable().find(function);
    if (!found)
        found = functionOfKernel(function);
    if (!found)
        refuse(CUDA_ERROR_INVALID_HANDLE, static_cast<void*>(function), " is not a live function");
    return found;
}

std::shared_ptr<Function> functionOf(CUfunction function) {
    std::shared_ptr<Function> found = liveFunctionOf(function);
    ensureCompiled(*found);
    return found;
}

void ensureCompiled(Function& function) {
    if (!function.compiled.load(std::memory_order_acquire))
        if (const std::shared_ptr<Module> module = function.module.lock())
            module->compile(function);
}

} // namespace sunstone::api::cuda

SUNSTONE_EXPORT CUresult cuModuleLoad(CUmodule* module, const char* file) {
    return guarded("cuModuleLoad", Needs::kContext, [&] {
        require(module, "module is null");
        *module = makeModule(parseImage(ptxOfFile(file), JitOptions()));
    });
}
SUNSTONE_EXPORT CUresult cuModuleLoadData(CUmodule* module, const void* image) {
    return loadImage("cuModuleLoadData", module, image, 0, nullptr, nullptr);
}
SUNSTONE_EXPORT CUresult cuModuleLoadDataEx(CUmodule* module, const void* image,
                                            unsigned int numOptions, CUjit_option* options,
                                            void** values) {
    return loadImage("cuModuleLoadDataEx", module, image, numOptions, options, values);
}
SUNSTONE_EXPORT CUresult cuModuleLoadFatBinary(CUmodule* module, const void* image) {
    return loadImage("cuModuleLoadFatBinary", module, image, 0, nullptr, nullptr);
}
SUNSTONE_EXPORT CUresult cuModuleUnload(CUmodule module) {
    return guarded("cuModuleUnload", Needs::kObject, [&] {
        moduleOf(module);
        cpu::streams().synchronizeAll(); // queued work may use its code
        unloadModule(module);
    });
}

SUNSTONE_EXPORT CUresult cuModuleGetFunction(CUfunction* function, CUmodule module,
                                             const char* name) {
    return guarded("cuModuleGetFunction", Needs::kObject, [&] {
        require(function && name && *name, "function or name is null or empty");
        Function* found = moduleOf(module)->function(name);
        if (!found)
            refuse(CUDA_ERROR_NOT_FOUND, "the module has no kernel ", name);
        *function = static_cast<CUfunction>(found->handle());
    });
}
SUNSTONE_EXPORT CUresult cuModuleGetFunctionCount(unsigned int* count, CUmodule module) {
    return guarded("cuModuleGetFunctionCount", Needs::kObject, [&] {
        require(count, "count is null");
        *count = unsigned(moduleOf(module)->functionCount());
    });
}
SUNSTONE_EXPORT CUresult cuModuleEnumerateFunctions(CUfunction* functions, unsigned int count,
                                                    CUmodule module) {
    return guarded("cuModuleEnumerateFunctions", Needs::kObject, [&] {
        require(functions || count == 0, "functions is null");
        std::vector<Function*> all = moduleOf(module)->functions();
        for (unsigned i = 0; i < count && i < all.size(); ++i)
            functions[i] = static_cast<CUfunction>(all[i]->handle());
    });
}
SUNSTONE_EXPORT CUresult cuModuleGetGlobal(CUdeviceptr* address, size_t* bytes, CUmodule module,
                                           const char* name) {
    return guarded("cuModuleGetGlobal", Needs::kObject, [&] {
        require(name && *name, "name is null or empty");
        require(moduleOf(module)->referenceType(name) == ptx::Type::kNone,
                "a reference to a texture or surface is no variable");
        void* where = nullptr;
        uint64_t size = 0;
        if (!moduleOf(module)->variable(name, &where, &size))
            refuse(CUDA_ERROR_NOT_FOUND, "the module has no variable ", name);
        if (address)
            *address = reinterpret_cast<CUdeviceptr>(where);
        if (bytes)
            *bytes = size;
    });
}
