// SPDX-License-Identifier: Apache-2.0
// Contexts without their entry points.
#include "api/optix6/context.h"

#include "api/optix6/post/stage.h"
#include "api/optix6/progressive/progressive.h"
#include "api/optix6/scene.h"
#include "base/log.h"
#include "compiler/flavor.h"
#include "compiler/optix6/texture_calls.h"
#include "engine/gpu/gpus.h"
#include "ptx/link.h"
#include "ptx/parse/parser.h"

#include <cxxabi.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstdlib>
#include <limits>

namespace sunstone::optix6 {

const char* nameOf(Kind kind) {
    static constexpr const char* kNames[] = {"context",
                                             "program",
                                             "variable",
                                             "buffer",
                                             "texture sampler",
                                             "geometry",
                                             "geometry triangles",
                                             "material",
                                             "geometry instance",
                                             "geometry group",
                                             "group",
                                             "transform",
                                             "selector",
                                             "acceleration",
                                             "post-processing stage",
                                             "command list",
                                             "remote device"};
    return kNames[unsigned(kind)];
}

void Object::noteSceneChange() const {
    if (const std::shared_ptr<Context> owner = isInScene ? context() : nullptr)
        owner->noteStructure();
}

void Object::noteIds() const {
    if (const std::shared_ptr<Context> owner = context())
        owner->idsChanged = true;
}

// Never destroyed: clients may call from their own exit handlers.
HandleTable<Object>& objects() {
    static auto* table = new HandleTable<Object>;
    return *table;
}

namespace {

const char* exceptionName(int32_t code) {
    switch (code) {
    case devlib::kExceptionStackOverflow:
    case devlib::kCodeStackOverflow:
        return "RT_EXCEPTION_STACK_OVERFLOW";
    case devlib::kExceptionTraceDepth:
        return "RT_EXCEPTION_TRACE_DEPTH_EXCEEDED";
    case devlib::kCodePayload:
        return "RT_EXCEPTION_PAYLOAD_ACCESS_OUT_OF_BOUNDS";
    case devlib::kCodeUserCode:
        return "RT_EXCEPTION_USER_EXCEPTION_CODE_OUT_OF_BOUNDS";
    case devlib::kCodeProgramId:
        return "RT_EXCEPTION_PROGRAM_ID_INVALID";
    case devlib::kCodeTextureId:
        return "RT_EXCEPTION_TEXTURE_ID_INVALID";
    case devlib::kCodeBufferId:
        return "RT_EXCEPTION_BUFFER_ID_INVALID";
    case devlib::kCodeIndex:
        return "RT_EXCEPTION_INDEX_OUT_OF_BOUNDS";
    case devlib::kCodeBufferIndex:
        return "RT_EXCEPTION_BUFFER_INDEX_OUT_OF_BOUNDS";
    case devlib::kCodeInvalidRay:
        return "RT_EXCEPTION_INVALID_RAY";
    default:
        return nullptr;
    }
}

const engine::Wording& wording() {
    static const engine::Wording words = [] {
        engine::Wording w = engine::plainWording();
        w.exceptionName = exceptionName;
        w.packedBy = "the classic API";
        return w;
    }();
    return words;
}

constexpr RTexception kExceptions[] = {RT_EXCEPTION_PAYLOAD_ACCESS_OUT_OF_BOUNDS,
                                       RT_EXCEPTION_USER_EXCEPTION_CODE_OUT_OF_BOUNDS,
                                       RT_EXCEPTION_TRACE_DEPTH_EXCEEDED,
                                       RT_EXCEPTION_PROGRAM_ID_INVALID,
                                       RT_EXCEPTION_TEXTURE_ID_INVALID,
                                       RT_EXCEPTION_BUFFER_ID_INVALID,
                                       RT_EXCEPTION_INDEX_OUT_OF_BOUNDS,
                                       RT_EXCEPTION_STACK_OVERFLOW,
                                       RT_EXCEPTION_BUFFER_INDEX_OUT_OF_BOUNDS,
                                       RT_EXCEPTION_INVALID_RAY,
                                       RT_EXCEPTION_INTERNAL_ERROR,
                                       RT_EXCEPTION_USER};

} // namespace

int exceptionBit(RTexception exception) {
    const auto* found = std::find(std::begin(kExceptions), std::end(kExceptions), exception);
    return found == std::end(kExceptions) ? -1 : int(found - kExceptions);
}

bool isEnabled(const Context& context, RTexception exception) {
    return context.exceptions >> exceptionBit(exception) & 1;
}

void checkLaunch(const Context& context, unsigned entry, RTsize width, RTsize height,
                 RTsize depth) {
    if (entry >= context.entryPoints.size())
        refuse(RT_ERROR_INVALID_VALUE, "entryPointIndex = ", entry, " of ",
               context.entryPoints.size(), " entry points");
    constexpr RTsize kMost = std::numeric_limits<uint32_t>::max();
    if (width > kMost || height > kMost || depth > kMost || (depth != 0 && width > kMost / depth))
        refuse(RT_ERROR_INVALID_VALUE, "a launch of ", width, " by ", height, " by ", depth,
               " has too many indices");
}

void checkUnmapped(const Context& context, bool withStreams) {
    for (const Ref<Buffer>& ref : context.mappedBuffers)
        if (const auto buffer = ref.lock(); buffer && (withStreams || !buffer->stream))
            refuse(RT_ERROR_ALREADY_MAPPED, "buffer ", buffer->handle(), buffer->variableNames(),
                   " is mapped");
}

Context::Context() : Scoped(kKind, nullptr), engine(std::make_shared<engine::Context>()) {
    isInScene = true; // its variables
    exceptions = 1u << exceptionBit(RT_EXCEPTION_STACK_OVERFLOW);
    engine->wording = &wording();
    engine->log = [](LogLevel level, std::string_view tag, std::string_view text) {
        sunstone::log(level, "optix6", message(tag, ": ", text));
    };
    engine->cache =
        std::make_shared<engine::CompileCache>([](LogLevel level, const std::string& text) {
            sunstone::log(level, "optix6", message("DISKCACHE: ", text));
        });
    engine->cache->start();
    setDevice(0);
    progressive = std::make_unique<Progressive>(*this);
}

void Context::useBackend(std::shared_ptr<engine::Backend> backend, int ordinal) {
    engine->backend = std::move(backend);
    engine->device = &engine->backend->device();
    engine->backend->useCache(engine->cache);
    device = ordinal;
}

std::vector<std::shared_ptr<Object>> Context::liveObjects() const {
    std::vector<std::shared_ptr<Object>> live;
    objects().findIf([&](Object& object) {
        if (&object != this && object.context().get() == this)
            live.push_back(object.shared_from_this());
        return false;
    });
    return live;
}

namespace {

void moveTo(const std::shared_ptr<engine::Backend>& backend, Object& object) {
    if (object.kind == Kind::kBuffer)
        static_cast<Buffer&>(object).moveTo(backend);
    else if (object.kind == Kind::kTextureSampler)
        static_cast<TextureSampler&>(object).moveTo(backend);
    else if (object.kind == Kind::kAcceleration)
        static_cast<Acceleration&>(object).drop();
    else if (object.kind == Kind::kPostProcessingStage)
        static_cast<PostProcessingStage&>(object).dropMemory();
    else if (isNode(object.kind))
        static_cast<Node&>(object).dropStructures();
}

} // namespace

void Context::setDevice(int ordinal) {
    if (engine->backend && ordinal == device)
        return;
    const std::vector<engine::Gpu>& gpus = engine::gpus();
    auto backend =
        gpus.empty() ? engine::cpuBackend() : engine::createPrimaryBackend(gpus[size_t(ordinal)]);
    if (!engine->backend) // the context is being created
        return useBackend(std::move(backend), ordinal);
    checkUnmapped(*this, true);
    const std::vector<std::shared_ptr<Object>> all = liveObjects();
    for (const std::shared_ptr<Object>& object : all)
        if (object->kind == Kind::kBuffer)
            static_cast<const Buffer&>(*object).requireMovable();
    const std::shared_ptr<engine::Backend> before = engine->backend;
    const int deviceBefore = device;
    const auto moveAll = [&](const std::shared_ptr<engine::Backend>& to, int toOrdinal) {
        scene = nullptr;
        useBackend(to, toOrdinal);
        scene = std::make_unique<Scene>(*this);
        noteStructure();
        for (const std::shared_ptr<Object>& object : all) // before buffers write to blocks
            if (object->kind == Kind::kVariable)
                static_cast<Variable&>(*object).users.clear(); // in blocks of the scene before
        for (const std::shared_ptr<Object>& object : all)
            moveTo(to, *object);
    };
    try {
        moveAll(backend, ordinal);
    } catch (...) { // the device has too little memory
        moveAll(before, deviceBefore);
        throw;
    }
}

Context::~Context() = default;

std::shared_ptr<Context> Context::context() const {
    return std::const_pointer_cast<Context>(
        std::static_pointer_cast<const Context>(shared_from_this()));
}

const char* Context::keep(std::string text) {
    returned_ = std::move(text);
    return returned_.c_str();
}

void Context::report(int level, const char* tag, const std::string& text) {
    if (!wantsReports(level))
        return;
    std::lock_guard lock(reportMutex_);
    reports_.push_back({level, tag, text});
}

void Context::deliverReports() {
    std::vector<Report> lines;
    {
        std::lock_guard lock(reportMutex_);
        lines.swap(reports_);
    }
    if (lines.empty())
        return;
    RTusagereportcallback callback;
    void* data;
    {
        std::lock_guard lock(mutex_);
        callback = reportCallback;
        data = reportData;
    }
    for (const Report& line : lines)
        if (callback)
            callback(line.level, line.tag.c_str(), line.text.c_str(), data);
}

namespace {

template <class T>
int giveId(T& object, IdList<T>& list) {
    if (object.id == 0) {
        object.id = int(list.reserve());
        list.set(unsigned(object.id), std::static_pointer_cast<T>(object.shared_from_this()));
        object.noteIds();
    }
    return object.id;
}

} // namespace

int Context::idOf(Buffer& buffer) {
    return giveId(buffer, buffers);
}
int Context::idOf(TextureSampler& sampler) {
    return giveId(sampler, samplers);
}
int Context::idOf(Program& program) {
    if (program.id == 0)
        noteStructure(); // it needs a record
    return giveId(program, programs);
}

// ---- programs ---------------------------------------------------------------------------------

unsigned Context::attributeBytes() const {
    constexpr unsigned kLeast = 64;
    return std::bit_ceil(std::max(kLeast, nextAttribute_));
}

uint32_t Context::attributePlace(const std::string& name, uint32_t bytes) {
    if (name == "barycentrics" && bytes == 8)
        return devlib::kBarycentricsOffset;
    if (name == "instanceid" && bytes == 4)
        return devlib::kInstanceIdOffset;
    const auto [place, isNew] = attributePlaces.try_emplace({name, bytes}, nextAttribute_);
    if (isNew)
        nextAttribute_ = (nextAttribute_ + bytes + 15) / 16 * 16;
    return place->second;
}

namespace {

// Start of linked texts, which already contain the texture functions. Remote devices receive them
// like other texts.
constexpr std::string_view kLinked = "// linked\n";

} // namespace

std::shared_ptr<ModuleText> Context::loadText(const std::string& text) {
    auto source = std::make_shared<const compiler::Source>(std::string_view(text));
    std::shared_ptr<ModuleText>& entry = texts_[source->digest()];
    if (entry)
        return entry;
    ptx::Diagnostics diagnostics;
    const std::string functions =
        text.starts_with(kLinked) ? std::string() : compiler::optix6::textureFunctionsFor(text);
    std::shared_ptr<const ptx::Module> tree = ptx::parse(text + functions, diagnostics);
    if (diagnostics.failed() || !tree) {
        texts_.erase(source->digest());
        refuse(RT_ERROR_INVALID_SOURCE, diagnostics.format());
    }
    auto module = std::make_shared<engine::Module>();
    module->source = std::make_shared<const compiler::Source>(tree);
    module->summary.selfContained = compiler::isSelfContained(*tree, {});
    for (const ptx::Function& function : tree->functions) {
        if (!function.hasBody)
            continue;
        auto& program = module->summary.programs.emplace_back();
        program.name = function.name;
        program.kind = compiler::ProgramKind::kNone;
        program.parameterWords = compiler::parameterWords(function.parameters);
        program.statements = uint32_t(function.body.size());
    }
    auto rules = std::make_shared<compiler::ModuleRules>();
    for (const auto& attribute : compiler::optix6::attributesOf(*tree))
        rules->attributes.push_back(
            {attribute.name, attributePlace(attribute.name, attribute.bytes)});
    module->moduleRules = std::move(rules);
    module->prepared = std::make_shared<engine::PreparedCode>(engine->cache);
    auto made = std::make_shared<ModuleText>();
    made->module = std::move(module);
    made->text = std::make_shared<const std::string>(text);
    return entry = made;
}

namespace {

// The first variable of this name that satisfies the condition, of all programs; or null.
template <class Texts, class Condition>
const compiler::optix6::DeviceVariable* findVariable(const Texts& texts, const std::string& name,
                                                     const Condition& condition) {
    for (const auto& [digest, text] : texts)
        for (const auto& [symbol, code] : text->programs)
            for (const auto& variable : code->variables.list)
                if (variable.name == name && condition(variable))
                    return &variable;
    return nullptr;
}

} // namespace

std::string Context::annotationOf(const std::string& name) const {
    const auto* found =
        findVariable(texts_, name, [](const auto& each) { return !each.annotation.empty(); });
    return found ? found->annotation : std::string();
}

bool Context::isRead(const std::string& name) const {
    return findVariable(texts_, name, [](const auto&) { return true; }) != nullptr;
}

namespace {

// Whether a symbol is that of a function template's instance, as "name<7>".
bool isInstance(std::string_view symbol, const std::string& name) {
    int status = 0;
    const std::unique_ptr<char, decltype(&std::free)> text(
        abi::__cxa_demangle(std::string(symbol).c_str(), nullptr, nullptr, &status), &std::free);
    if (!text)
        return false;
    const std::string_view whole = text.get(); // starts with the type of the result
    const size_t place = whole.find(name + "(");
    return place != whole.npos && (place == 0 || whole[place - 1] == ' ');
}

// The function of this name as the application writes it: its symbol, or its name in the source.
const ptx::Function* findProgram(const ptx::Module& tree, const std::string& name) {
    const ptx::Function* exact = tree.findFunction(name);
    if (exact && exact->hasBody)
        return exact;
    const ptx::Function* found = nullptr;
    const bool isTemplate = name.ends_with('>');
    for (const ptx::Function& function : tree.functions) {
        if (!function.hasBody || (isTemplate ? !isInstance(function.name, name)
                                             : compiler::optix6::sourceName(function.name) != name))
            continue;
        if (found)
            refuse(RT_ERROR_INVALID_SOURCE, "programName = \"", name,
                   "\" is the name of several functions: \"", found->name, "\" and \"",
                   function.name, "\"");
        found = &function;
    }
    return found;
}

} // namespace

std::shared_ptr<ModuleText>
Context::linkTexts(const std::vector<std::shared_ptr<ModuleText>>& texts) {
    std::shared_ptr<ModuleText>& entry = linked_[texts];
    if (entry)
        return entry;
    std::vector<const ptx::Module*> trees;
    for (const std::shared_ptr<ModuleText>& text : texts)
        trees.push_back(&text->module->source->tree());
    const auto isShared = [](const ptx::Module& module, const ptx::Variable& variable) {
        return variable.name.find("rti_internal_") != std::string_view::npos ||
               compiler::optix6::describe(module, variable).use !=
                   compiler::optix6::VariableUse::kNone;
    };
    std::string whole;
    try {
        whole = std::string(kLinked) + ptx::link(trees, isShared);
    } catch (const Error& error) {
        linked_.erase(texts);
        refuse(RT_ERROR_INVALID_SOURCE, error.what());
    }
    return entry = loadText(whole);
}

// Texts without programs are kept for applications that create the same programs again. An
// application that edits its programs has a new text each time, so the number is limited.
void Context::dropUnusedTexts() {
    constexpr size_t kLeast = 64;
    if (texts_.size() < std::max(kLeast, mostTexts_))
        return;
    const auto isUsed = [](const ModuleText& text) {
        return std::any_of(text.programs.begin(), text.programs.end(),
                           [](const auto& program) { return program.second.use_count() > 1; });
    };
    std::erase_if(linked_, [&](const auto& entry) { return !isUsed(*entry.second); });
    std::erase_if(texts_, [&](const auto& entry) {
        return entry.second.use_count() == 1 && !isUsed(*entry.second);
    });
    mostTexts_ = 2 * texts_.size();
}

namespace {

// The text `no function "NAME" in the PTX` with the names that the application may mean: those that
// differ in case or in their namespaces, or else the first ones, programs before callables.
std::string missingProgram(const std::vector<std::shared_ptr<ModuleText>>& texts,
                           const std::string& name) {
    constexpr size_t kMost = 8;
    const auto endsWith = [](std::string_view whole, std::string_view end) {
        return whole.size() >= end.size() &&
               std::equal(end.begin(), end.end(), whole.end() - ptrdiff_t(end.size()),
                          [](unsigned char a, unsigned char b) {
                              return std::tolower(a) == std::tolower(b);
                          });
    };
    const std::string base = name.substr(0, name.find('<'));
    std::vector<std::string> all, similar;
    const auto note = [](std::vector<std::string>& list, const std::string& each) {
        if (std::find(list.begin(), list.end(), each) == list.end())
            list.push_back(each);
    };
    for (const bool isEntry : {true, false})
        for (const std::shared_ptr<ModuleText>& text : texts)
            for (const ptx::Function& function : text->module->source->tree().functions) {
                if (!function.hasBody || function.isEntry != isEntry)
                    continue;
                const std::string known = compiler::optix6::sourceName(function.name);
                note(all, known);
                if (!base.empty() &&
                    (endsWith("::" + known, "::" + base) || endsWith("::" + base, "::" + known)))
                    note(similar, known);
            }
    const std::vector<std::string>& list = similar.empty() ? all : similar;
    std::string names;
    for (size_t i = 0; i < std::min(list.size(), kMost); ++i)
        names += (i ? ", \"" : "\"") + list[i] + "\"";
    if (list.size() > kMost)
        names += message(" and ", list.size() - kMost, " more");
    return message("no function \"", name, "\" in the PTX, which has ",
                   list.empty() ? "no functions" : names);
}

} // namespace

std::shared_ptr<ProgramCode> Context::load(const std::vector<std::string>& texts,
                                           const std::string& name) {
    dropUnusedTexts();
    std::vector<std::shared_ptr<ModuleText>> all;
    for (const std::string& text : texts)
        all.push_back(loadText(text));
    for (std::shared_ptr<ModuleText> loaded : all) {
        const ptx::Function* function = findProgram(loaded->module->source->tree(), name);
        if (!function)
            continue;
        if (!loaded->module->summary.selfContained && texts.size() > 1) {
            loaded = linkTexts(all);
            function = loaded->module->source->tree().findFunction(function->name);
            if (!loaded->module->summary.selfContained)
                refuse(RT_ERROR_INVALID_SOURCE, "the text with \"", name,
                       "\" refers to symbols that none of the texts defines");
        }
        return codeOf(*loaded, *function);
    }
    refuse(RT_ERROR_INVALID_SOURCE, missingProgram(all, name));
}

std::shared_ptr<ProgramCode> Context::codeOf(ModuleText& text, const ptx::Function& function) {
    std::shared_ptr<ProgramCode>& code = text.programs[std::string(function.name)];
    if (code)
        return code;
    code = std::make_shared<ProgramCode>();
    code->module = text.module;
    code->text = text.text;
    code->function = function.name;
    code->name = compiler::optix6::sourceName(function.name);
    code->isEntry = function.isEntry;
    code->parameters = unsigned(function.parameters.size());
    code->variables = compiler::optix6::variablesOf({&text.module->source->tree()}, function.name);
    return code;
}

void checkKind(const Program& program, compiler::ProgramKind kind, const char* parameter) {
    using compiler::ProgramKind;
    const ProgramCode& code = *program.code;
    bool fits = code.isEntry && code.parameters == 0;
    const char* wanted = "a program without parameters";
    if (kind == ProgramKind::kDirectCallable) {
        fits = !code.isEntry;
        wanted = "a callable program";
    } else if (kind == ProgramKind::kIntersection) {
        fits = code.isEntry && code.parameters == 1;
        wanted = "a program with one parameter";
    } else if (kind == ProgramKind::kBounds) {
        fits = code.isEntry && (code.parameters == 2 || code.parameters == 3);
        wanted = "a program with two or three parameters";
    }
    if (!fits)
        refuse(RT_ERROR_TYPE_MISMATCH, parameter, " = \"", code.name, "\" is ",
               code.isEntry ? "a program" : "a function", " with ", code.parameters,
               " parameters, but ", wanted, " is needed");
}

} // namespace sunstone::optix6
