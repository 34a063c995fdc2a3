// SPDX-License-Identifier: Apache-2.0
// See machine.h.
#include "compiler/machine.h"

#include "base/config.h"
#include "base/log.h"
#include "compiler/debug/debugger.h"
#include "compiler/passes/code_generator.h"
#include "compiler/runtime/device_data.h"
#include "compiler/runtime/runtime.h"

#include <llvm/ADT/StringExtras.h>
#include <llvm/ExecutionEngine/JITLink/JITLinkMemoryManager.h>
#include <llvm/ExecutionEngine/Orc/Core.h>
#include <llvm/ExecutionEngine/Orc/ExecutorProcessControl.h>
#include <llvm/ExecutionEngine/Orc/ObjectLinkingLayer.h>
#include <llvm/ExecutionEngine/Orc/TaskDispatch.h>
#include <llvm/IR/DiagnosticInfo.h>
#include <llvm/IR/DiagnosticPrinter.h>
#include <llvm/IR/LegacyPassManager.h>
#include <llvm/MC/TargetRegistry.h>
#include <llvm/Object/ObjectFile.h>
#include <llvm/Support/MemoryBuffer.h>
#include <llvm/Support/TargetSelect.h>
#include <llvm/TargetParser/Host.h>

#include <atomic>
#include <mutex>
#include <set>

namespace sunstone::compiler {

namespace {

std::string textOf(llvm::Error error) {
    return llvm::toString(std::move(error));
}

// The target of compiled code: this processor, or a subset of its instructions if SUNSTONE_ISA
// names one.
struct Processor {
    std::string name, features;
};

const Processor& processor() {
    static const auto* chosen = [] {
        const std::string& highest = config(Setting::kIsa);
        if (highest == "baseline") // the 16-byte exchange is in every x86-64 processor since 2006
            return new Processor{"x86-64", "+cx16"};
        std::vector<std::string> features;
        for (const auto& feature : llvm::sys::getHostCPUFeatures()) {
            const bool allowed = highest != "avx2" || !(feature.first().starts_with("avx512") ||
                                                        feature.first().starts_with("avx10"));
            features.push_back((feature.second && allowed ? "+" : "-") + feature.first().str());
        }
        llvm::sort(features); // the map is unordered
        return new Processor{llvm::sys::getHostCPUName().str(), llvm::join(features, ",")};
    }();
    return *chosen;
}

std::unique_ptr<llvm::TargetMachine> createMachine() {
    static const bool initialized = [] {
        llvm::InitializeNativeTarget();
        llvm::InitializeNativeTargetAsmPrinter();
        limitCodeGenerator();
        return true;
    }();
    (void)initialized;
    const std::string triple = llvm::sys::getProcessTriple();
    std::string error;
    const llvm::Target* target = llvm::TargetRegistry::lookupTarget(triple, error);
    if (!target)
        fail(ErrorCode::kInternal, "no code generator for ", triple, ": ", error);
    llvm::TargetOptions options;
    options.AllowFPOpFusion = llvm::FPOpFusion::Strict;
    options.UnsafeFPMath = options.NoInfsFPMath = options.NoNaNsFPMath = false;
    options.NoSignedZerosFPMath = options.ApproxFuncFPMath = false;
    return std::unique_ptr<llvm::TargetMachine>(target->createTargetMachine(
        triple, processor().name, processor().features, options, llvm::Reloc::PIC_,
        llvm::CodeModel::Small, llvm::CodeGenOptLevel::Default, true));
}

class MachinePool {
public:
    std::unique_ptr<llvm::TargetMachine> take() {
        {
            std::lock_guard lock(mutex_);
            if (!free_.empty()) {
                auto machine = std::move(free_.back());
                free_.pop_back();
                return machine;
            }
        }
        return createMachine();
    }
    void give(std::unique_ptr<llvm::TargetMachine> machine) {
        std::lock_guard lock(mutex_);
        free_.push_back(std::move(machine));
    }

private:
    std::mutex mutex_;
    std::vector<std::unique_ptr<llvm::TargetMachine>> free_;
};

MachinePool& pool() {
    static MachinePool* instance = new MachinePool; // outlives every user at exit
    return *instance;
}

// Records the load addresses of each object's sections.
class SectionNotes : public llvm::orc::ObjectLinkingLayer::Plugin {
public:
    void modifyPassConfig(llvm::orc::MaterializationResponsibility& responsibility,
                          llvm::jitlink::LinkGraph&,
                          llvm::jitlink::PassConfiguration& config) override {
        const llvm::orc::JITDylib* library = &responsibility.getTargetJITDylib();
        config.PostFixupPasses.push_back([this, library](llvm::jitlink::LinkGraph& graph) {
            SectionAddresses addresses;
            for (llvm::jitlink::Section& section : graph.sections()) {
                if (section.empty())
                    continue;
                const llvm::jitlink::SectionRange range(section);
                addresses[section.getName().str()] = range.getStart().getValue();
                if (section.getName() == ".data" || section.getName() == ".bss" ||
                    section.getName().starts_with(".rodata"))
                    addLoadedData(library, range.getStart().getValue(), range.getSize());
            }
            std::lock_guard lock(mutex_);
            notes_[library] = std::move(addresses);
            return llvm::Error::success();
        });
    }
    SectionAddresses take(const llvm::orc::JITDylib& library) {
        std::lock_guard lock(mutex_);
        SectionAddresses addresses = std::move(notes_[&library]);
        notes_.erase(&library);
        return addresses;
    }
    llvm::Error notifyFailed(llvm::orc::MaterializationResponsibility&) override {
        return llvm::Error::success();
    }
    llvm::Error notifyRemovingResources(llvm::orc::JITDylib&, llvm::orc::ResourceKey) override {
        return llvm::Error::success();
    }
    void notifyTransferringResources(llvm::orc::JITDylib&, llvm::orc::ResourceKey,
                                     llvm::orc::ResourceKey) override {}

private:
    std::mutex mutex_;
    std::map<const llvm::orc::JITDylib*, SectionAddresses> notes_;
};

// The process's linking session. Never destroyed: destructors may free code at exit.
class Session {
public:
    static Session& get() {
        static Session* instance = new Session;
        return *instance;
    }

    llvm::orc::JITDylib& newLibrary() {
        static std::atomic<unsigned> count{0};
        llvm::orc::JITDylib& library =
            session_->createBareJITDylib("code" + std::to_string(++count));
        library.addToLinkOrder(*runtime_);
        return library;
    }
    llvm::orc::ExecutionSession& session() { return *session_; }
    llvm::orc::ObjectLinkingLayer& linker() { return *linker_; }
    SectionNotes& sections() { return *sections_; }

private:
    Session() {
        auto control = llvm::orc::SelfExecutorProcessControl::Create(
            nullptr, std::make_unique<llvm::orc::InPlaceTaskDispatcher>());
        if (!control)
            fail(ErrorCode::kInternal, "cannot start the linker: ", textOf(control.takeError()));
        session_ = std::make_unique<llvm::orc::ExecutionSession>(std::move(*control));
        session_->setErrorReporter(
            [](llvm::Error error) { log(LogLevel::kError, "compiler", textOf(std::move(error))); });
        linker_ = std::make_unique<llvm::orc::ObjectLinkingLayer>(
            *session_, session_->getExecutorProcessControl().getMemMgr());
        sections_ = std::make_shared<SectionNotes>();
        linker_->addPlugin(sections_);
        runtime_ = &session_->createBareJITDylib("runtime");
        llvm::orc::SymbolMap symbols;
        for (const RuntimeSymbol& symbol : runtimeSymbols())
            symbols[session_->intern(symbol.name)] = {
                llvm::orc::ExecutorAddr::fromPtr(symbol.address),
                llvm::JITSymbolFlags::Exported | llvm::JITSymbolFlags::Callable};
        if (llvm::Error error = runtime_->define(llvm::orc::absoluteSymbols(std::move(symbols))))
            fail(ErrorCode::kInternal, "cannot link the run-time: ", textOf(std::move(error)));
    }

    std::unique_ptr<llvm::orc::ExecutionSession> session_;
    std::unique_ptr<llvm::orc::ObjectLinkingLayer> linker_;
    std::shared_ptr<SectionNotes> sections_;
    llvm::orc::JITDylib* runtime_ = nullptr;
};

class LoadedLibrary : public LoadedCode {
public:
    LoadedLibrary() : library_(Session::get().newLibrary()) {}
    ~LoadedLibrary() override {
        debug_ = nullptr;
        removeLoadedData(&library_);
        if (llvm::Error error = Session::get().session().removeJITDylib(library_))
            log(LogLevel::kError, "compiler", "cannot free code: " + textOf(std::move(error)));
    }

    void define(const std::vector<std::pair<std::string, void*>>& externals) {
        if (externals.empty())
            return;
        llvm::orc::SymbolMap symbols;
        for (const auto& [name, address] : externals)
            symbols[Session::get().session().intern(name)] = {
                llvm::orc::ExecutorAddr::fromPtr(address), llvm::JITSymbolFlags::Exported};
        if (llvm::Error error = library_.define(llvm::orc::absoluteSymbols(std::move(symbols))))
            fail(ErrorCode::kInternal, "cannot link variables: ", textOf(std::move(error)));
    }

    void link(std::unique_ptr<llvm::MemoryBuffer> object, const std::vector<std::string>& symbols) {
        Session& session = Session::get();
        if (llvm::Error error = session.linker().add(library_, std::move(object)))
            fail(ErrorCode::kInternal, "cannot add code: ", textOf(std::move(error)));
        llvm::orc::SymbolLookupSet wanted;
        for (const std::string& name : symbols)
            wanted.add(session.session().intern(name));
        auto found = session.session().lookup(
            llvm::orc::makeJITDylibSearchOrder({&library_},
                                               llvm::orc::JITDylibLookupFlags::MatchAllSymbols),
            std::move(wanted));
        if (!found)
            fail(ErrorCode::kInternal, "cannot link code: ", textOf(found.takeError()));
        for (const auto& [name, definition] : *found)
            addresses_[(*name).str()] = definition.getAddress().toPtr<void*>();
    }

    void describe(const CodeObject& object) {
        const SectionAddresses addresses = Session::get().sections().take(library_);
        debug_ = DebugRegistration::add(object.code, addresses, object.forDebugger);
    }

    void* address(const std::string& name) const override {
        const auto found = addresses_.find(name);
        return found == addresses_.end() ? nullptr : found->second;
    }

private:
    llvm::orc::JITDylib& library_;
    std::map<std::string, void*> addresses_;
    std::unique_ptr<DebugRegistration> debug_; // unregistered before the code is freed
};

struct CodegenNotes {
    CodeObject* object = nullptr;
    std::string error;
};

// The code generator reports frame sizes and faults as diagnostics.
void takeDiagnostic(const llvm::DiagnosticInfo* info, void* context) {
    auto& notes = *static_cast<CodegenNotes*>(context);
    if (const auto* size = llvm::dyn_cast<llvm::DiagnosticInfoStackSize>(info)) {
        notes.object->stackSizes[size->getFunction().getName().str()] =
            uint32_t(size->getResourceSize());
        return;
    }
    if (info->getSeverity() != llvm::DS_Error)
        return;
    llvm::raw_string_ostream stream(notes.error);
    llvm::DiagnosticPrinterRawOStream printer(stream);
    info->print(printer);
}

// Throws if the code refers to unknown symbols. Otherwise the store would keep the code, and each
// later link would fail.
void checkSymbols(const Unit& unit, llvm::StringRef code) {
    static const auto& provided = *[] {
        auto* names = new std::set<std::string, std::less<>>;
        for (const RuntimeSymbol& symbol : runtimeSymbols())
            names->insert(symbol.name);
        names->insert("_GLOBAL_OFFSET_TABLE_"); // the linker makes it
        return names;
    }();
    auto object = llvm::object::ObjectFile::createObjectFile({code, "code"});
    if (!object)
        fail(ErrorCode::kInternal, "cannot read code: ", textOf(object.takeError()));
    std::set<std::string, std::less<>> variables;
    for (const VariableId& id : unit.variableIds())
        variables.insert(id.symbol());
    for (const llvm::object::SymbolRef& symbol : (*object)->symbols()) {
        if (!(llvm::cantFail(symbol.getFlags()) & llvm::object::SymbolRef::SF_Undefined))
            continue;
        const llvm::StringRef name = llvm::cantFail(symbol.getName());
        if (!name.empty() && !provided.contains(name) && !variables.contains(name))
            fail(ErrorCode::kInternal, "code generation: the code calls ", name.str(),
                 ", which the run-time lacks");
    }
}

} // namespace

const std::string& targetDescription() {
    static const auto* text = new std::string(llvm::sys::getProcessTriple() + " " +
                                              processor().name + " " + processor().features);
    return *text;
}

LentMachine::LentMachine(OptLevel level) : machine_(pool().take()) {
    machine_->setOptLevel(level == OptLevel::k0   ? llvm::CodeGenOptLevel::None
                          : level == OptLevel::k1 ? llvm::CodeGenOptLevel::Less
                                                  : llvm::CodeGenOptLevel::Default);
}

LentMachine::~LentMachine() {
    pool().give(std::move(machine_));
}

bool LentMachine::hasFma() const {
    return ("," + machine_->getTargetFeatureString().str() + ",").find(",+fma,") !=
           std::string::npos;
}

CodeObject generate(Unit& unit, LentMachine& machine) {
    CodeObject object;
    CodegenNotes notes{&object, {}};
    unit.context().setDiagnosticHandlerCallBack(takeDiagnostic, &notes);
    llvm::SmallVector<char, 0> code;
    {
        llvm::raw_svector_ostream stream(code);
        llvm::legacy::PassManager passes;
        if (!addCodeGenerator(*machine, unit.module(), passes, stream))
            fail(ErrorCode::kInternal, "the code generator cannot write object code");
        passes.run(unit.module());
    }
    unit.context().setDiagnosticHandlerCallBack(nullptr, nullptr);
    if (!notes.error.empty())
        fail(ErrorCode::kInternal, "code generation: ", notes.error);
    checkSymbols(unit, {code.data(), code.size()});
    object.code.assign(code.begin(), code.end());
    return object;
}

std::unique_ptr<LoadedCode>
loadObject(const CodeObject& object, const std::vector<std::string>& symbols,
           const std::vector<std::pair<std::string, void*>>& externals) {
    auto loaded = std::make_unique<LoadedLibrary>();
    loaded->define(externals);
    loaded->link(llvm::MemoryBuffer::getMemBufferCopy(object.code, "code"), symbols);
    loaded->describe(object);
    return loaded;
}

} // namespace sunstone::compiler
