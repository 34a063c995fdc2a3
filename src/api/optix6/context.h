// SPDX-License-Identifier: Apache-2.0
// Contexts: settings, numbers of objects, the texts of programs, and the scene of the next launch.
#pragma once

#include "api/optix6/graph.h"
#include "api/optix6/id_list.h"
#include "api/optix6/texture_sampler.h"
#include "engine/context.h"

#include <atomic>
#include <memory>
#include <mutex>
#include <set>

namespace sunstone::optix6 {

class Progressive;
class RemoteDevice;
class Scene;

struct EntryPoint {
    Ref<Program> rayGeneration, exception;
};

// Defaults that the manual leaves open.
constexpr RTsize kDefaultStackSize = 2048;
constexpr unsigned kDefaultDepth = 5, kMostTraceDepth = 31;
constexpr RTsize kDefaultPrintBytes = 64 << 10;

class Context : public Scoped {
public:
    static constexpr Kind kKind = Kind::kContext;
    Context();
    ~Context() override;
    std::shared_ptr<Context> context() const override;
    std::shared_ptr<Context> self() const { return context(); }
    std::mutex& mutex() const { return mutex_; }

    // Notes a change of the values that variables of programs have, or of the set of programs and
    // objects.
    void noteStructure() { structureChanged = true; }

    // The code of a program, from texts that are linked. Throws.
    std::shared_ptr<ProgramCode> load(const std::vector<std::string>& texts,
                                      const std::string& name);

    // Gives an object its id at the first call.
    int idOf(Buffer& buffer);
    int idOf(TextureSampler& sampler);
    int idOf(Program& program);

    // For rtContextGetErrorString: the error of the last failed call.
    std::string lastError;
    // Keeps a returned string until the next call.
    const char* keep(std::string text);
    // Whether the usage report contains texts of this level.
    bool wantsReports(int level) const { return reportCallback && level <= reportVerbosity; }
    // Queues a line for the usage report's callback, which is called without the lock.
    void report(int level, const char* tag, const std::string& text);
    void deliverReports();

    // The device of all objects: the CPU or one of engine::gpus(). Objects move to it. Throws
    // Failure if one cannot.
    void setDevice(int ordinal);
    bool isOnGpu() const { return !engine->backend->sharesMemory(); }

    std::shared_ptr<engine::Context> engine;
    int device = 0;
    std::vector<EntryPoint> entryPoints;
    std::vector<Ref<Program>> misses; // by ray type
    RTsize stackSize = kDefaultStackSize;
    unsigned maxTraceDepth = kDefaultDepth, maxCallableDepth = kDefaultDepth;
    bool isTraceDepthSet = false, isCallableDepthSet = false;
    unsigned exceptions = 0;       // bits by place in kExceptions (context.cpp)
    bool wantsStackChecks = false; // the application has enabled RT_EXCEPTION_STACK_OVERFLOW
    bool printEnabled = false, launched = false, launchFailed = false;
    RTsize printBytes = kDefaultPrintBytes;
    int printIndex[3] = {-1, -1, -1};
    RTusagereportcallback reportCallback = nullptr;
    int reportVerbosity = 0;
    void* reportData = nullptr;
    std::map<RTcontextattribute, int> attributes; // stored without effect

    // By id; 0 is none.
    IdList<Buffer> buffers{1024};
    IdList<TextureSampler> samplers{1024};
    IdList<Program> programs{1024};
    IdList<Node> nodes{64};               // programs cannot keep their ids
    std::vector<Ref<Variable>> variables; // of all scopes
    std::vector<Ref<Buffer>> allBuffers;
    std::set<Ref<Buffer>, std::owner_less<>> mappedBuffers;
    // Buffers that share their data with OpenGL.
    std::vector<Ref<Buffer>> glBuffers;
    std::vector<Ref<TextureSampler>> glSamplers;

    // Offsets of attributes in blocks, by name and bytes.
    std::map<std::pair<std::string, uint32_t>, uint32_t> attributePlaces;
    unsigned attributeBytes() const;
    // The annotation of a program's variable with this name; empty if there is none.
    std::string annotationOf(const std::string& name) const;
    // Whether a program has a variable with this name.
    bool isRead(const std::string& name) const;

    Ref<RemoteDevice> remoteDevice; // set by rtContextSetRemoteDevice
    bool usesRemoteDevice = false;
    // Changes since the last launch: everything, or the members below.
    bool structureChanged = true;
    std::atomic<bool> idsChanged = true; // the objects with ids, or the data behind an id
    std::vector<Ref<Node>> movedNodes;
    std::vector<Ref<Acceleration>> dirtyAccelerations;
    uint64_t lastVersion = 0; // of bounds; unique among structures
    std::unique_ptr<Scene> scene;
    std::unique_ptr<Progressive> progressive; // its thread uses the scene

private:
    std::shared_ptr<ModuleText> loadText(const std::string& text);
    std::shared_ptr<ModuleText> linkTexts(const std::vector<std::shared_ptr<ModuleText>>& texts);
    void dropUnusedTexts();
    static std::shared_ptr<ProgramCode> codeOf(ModuleText& text, const ptx::Function& function);
    uint32_t attributePlace(const std::string& name, uint32_t bytes);
    void useBackend(std::shared_ptr<engine::Backend> backend, int ordinal);
    std::vector<std::shared_ptr<Object>> liveObjects() const;

    mutable std::mutex mutex_;
    std::map<std::string, std::shared_ptr<ModuleText>> texts_; // by digest
    std::map<std::vector<std::shared_ptr<ModuleText>>, std::shared_ptr<ModuleText>> linked_;
    size_t mostTexts_ = 0; // limit that starts a search for unused ones
    std::string returned_;
    struct Report {
        int level;
        std::string tag, text;
    };
    std::mutex reportMutex_;
    std::vector<Report> reports_;
    uint32_t nextAttribute_ = devlib::kFirstAttribute;
};

// RTexception in the order of the bits of Context::exceptions; the bit, or -1.
constexpr unsigned kAllExceptions = (1u << 12) - 1;
int exceptionBit(RTexception exception);
bool isEnabled(const Context& context, RTexception exception);

// Throw Failure: the entry point does not exist, there are too many launch indices, or a buffer is
// mapped.
void checkLaunch(const Context& context, unsigned entry, RTsize width, RTsize height, RTsize depth);
void checkUnmapped(const Context& context, bool withStreams);

const char* textOf(RTresult result);
// The last error of the calling thread without a known context, as for a dead handle.
const std::string& failureWithoutContext();
RTresult resultOf(Code code);

} // namespace sunstone::optix6
