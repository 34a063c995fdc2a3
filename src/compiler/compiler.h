// SPDX-License-Identifier: Apache-2.0
// PTX to machine code. A Pipeline request names programs in several modules. The compiler takes
// only the functions in their call graphs, resolves symbols across the modules, lowers every
// `_optix_*` call to the ABI of devlib/abi.h, optimises the result and emits x86-64 code through
// ORC. LLVM does not appear in this interface. All functions are thread-safe.
#pragma once

#include "compiler/store/source.h"
#include "devlib/abi.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sunstone::compiler {

// The kind of a program. No generation of the API has all kinds.
enum class ProgramKind : uint8_t {
    kNone,
    kRaygen,
    kIntersection,
    kAnyHit,
    kClosestHit,
    kMiss,
    kDirectCallable,
    kContinuationCallable,
    kException,
    kBounds,    // writes the box of a custom primitive
    kAttribute, // computes the attributes of a built-in primitive's hit
    kVisit,     // chooses among the children of a node
};
constexpr ProgramKind kLastProgramKind = ProgramKind::kVisit;

enum class OptLevel : uint8_t { k0, k1, k2, k3 };
enum class DebugLevel : uint8_t { kNone, kMinimal, kModerate, kFull };

// Pipeline options of OptiX 7 alone.
struct Optix7Rules {
    unsigned numPayloadValues = 0;
    unsigned numAttributeValues = 2;
    bool operator==(const Optix7Rules&) const = default;
};

// Pipeline options of the classic API alone.
struct Optix6Rules {
    unsigned attributeBytes = 0;   // of an attribute block; 0: not the classic API
    unsigned exceptions = 0;       // devlib::ClassicException that are enabled
    unsigned maxCallableDepth = 0; // one more than callables may nest; 0: not checked
    bool operator==(const Optix6Rules&) const = default;
};

// Everything but the programs that compiled code depends on. Members named after a generation apply
// only to that generation.
struct PipelineRules {
    std::string launchParams;        // the .const variable with a copy per launch; empty: none
    unsigned exceptionFlags = 0;     // devlib::ExceptionFlag
    unsigned primitiveTypeFlags = 0; // bits of OptixPrimitiveTypeFlags that rays may meet; 0: all
    unsigned traversableGraphFlags = 0; // devlib::GraphFlag; 0: all graphs
    bool motionBlur = false;
    Optix7Rules optix7;
    Optix6Rules optix6;
};

// A payload type: for each word the programs that may read and write it (bits of
// OptixPayloadSemantics). Types of different modules are equal if all words are equal.
struct PayloadType {
    std::vector<uint32_t> words;
    bool operator==(const PayloadType&) const = default;
};
constexpr unsigned kMaxPayloadTypes = 8;

// Bytes of the launch parameters that are constant in a module's code.
struct BoundValue {
    uint64_t offset = 0;
    std::vector<uint8_t> bytes;
    std::string annotation;
};

// The place of an attribute variable of the classic API in attribute blocks.
struct AttributePlace {
    std::string name;
    uint32_t offset = 0;
};

// The compile options of one module, in addition to those of the pipeline.
struct ModuleRules {
    std::vector<PayloadType> payloadTypes; // empty: payloads are untyped
    std::vector<BoundValue> boundValues;
    std::vector<AttributePlace> attributes; // that the module declares
};

// inspect() does the checks of module creation that need no machine code: every `_optix_*` name is
// known, its operand count is right, the programs that call it may call it, and operands that must
// be constant are constant and in range. Throws Error(kInvalidPtx / kInvalidPayloadAccess /
// kInvalidFunctionUse / ...), whose text begins with the PTX line. The summary has all facts that
// the creation of modules, program groups and pipelines needs, so that only compilation needs the
// tree.
struct ModuleSummary {
    struct Program {
        std::string name;
        ProgramKind kind;
        unsigned payloadWords = 0; // highest accessed payload slot + 1
        bool traces = false;
        bool callsContinuation = false;
        unsigned parameterWords = 0; // 32-bit words of a callable's parameters
        uint32_t payloadTypes = 0;   // bit per type of the module that the program supports
        uint32_t statements = 0;     // of its own body
        // Estimate of its stack in bytes, for programs that cannot be compiled alone. Counts local
        // memory, registers live across calls, and traces; never 0.
        uint32_t estimatedStack = 0;
    };
    std::vector<Program> programs;
    uint64_t launchParamsSize = 0; // 0: no such variable
    uint64_t constantBytes = 0;    // of all other .const variables that are defined here
    // Programs can be compiled without the other modules of their pipeline: the module defines all
    // functions and variables that it declares, or the library provides them.
    bool selfContained = false;
    // A function calls itself, directly or through others, or may do so: it calls by address, or a
    // function of another module.
    bool mayRecurse = true;
    // Programs may wait for other launch indices: they have the means of locks and flags.
    bool mayWaitForOthers = false;
    std::string remarks; // log lines of its creation

    // Converts all members to bytes and back; deserialize returns false for malformed bytes.
    std::string serialize() const;
    bool deserialize(std::string_view bytes);
};
ModuleSummary inspect(const ptx::Module& module, const PipelineRules& rules,
                      const ModuleRules& moduleRules = {});

// Key of a module's summary: a digest of all its inputs and of this build.
std::string summaryKeyOf(const Source& source, const PipelineRules& rules,
                         const ModuleRules& moduleRules);

// The number of 32-bit words that these parameters of a callable take.
unsigned parameterWords(const std::vector<ptx::Variable>& parameters);

class ObjectStore;
class Flavor; // flavor.h

struct ProgramRequest {
    std::shared_ptr<const Source> module; // one for all programs of a module
    std::string function;
    ProgramKind kind = ProgramKind::kNone;
    OptLevel optLevel = OptLevel::k3;
    DebugLevel debugLevel = DebugLevel::kMinimal;
    std::shared_ptr<const ModuleRules> moduleRules; // may be null; one for all of a module
    int payloadType = -1; // index in moduleRules of the type to compile for; -1: untyped
    // Where its code is stored if it refers to no other module; null: in the pipeline's store.
    std::shared_ptr<ObjectStore> store;
    // ModuleSummary::selfContained, if known.
    std::optional<bool> selfContained;
};

struct CompiledProgram {
    const void* address = nullptr;
    unsigned stackSize = 0; // bytes of its frame and of all that it calls by name
};

// Machine code in memory; freed with the object.
class Code {
public:
    virtual ~Code() = default;
    // In the order of the request's programs (or of the module's entries for kernels).
    virtual const std::vector<CompiledProgram>& programs() const = 0;
    // Address and size of a module-scope variable; false if there is none.
    virtual bool variable(std::string_view name, void** address, uint64_t* size) const = 0;
    // Log lines: one for each bound value to which the code was specialised.
    virtual const std::string& feedback() const = 0;
};

// Stores compiled pieces between compilations. Keys are digests of all inputs of the piece, of this
// build and of this processor; values are bytes. Thread-safe.
class ObjectStore {
public:
    virtual ~ObjectStore() = default;
    virtual bool find(const std::string& key, std::string& value) = 0;
    // Whether the store has a value, for callers that have the value already. Counts as a use of
    // the value.
    virtual bool has(const std::string& key) {
        std::string value;
        return find(key, value);
    }
    virtual void insert(const std::string& key, const std::string& value) = 0;
};

struct PipelineRequest {
    std::vector<ProgramRequest> programs;
    PipelineRules rules;
    const Flavor* flavor = nullptr; // of all programs; null: OptiX 7
};

// Compiles each program separately, in parallel on the shared threads; code in `store` (may be
// null) is not compiled again. Throws Error(kLinkError) for unresolved or duplicate symbols,
// kInternal for defects of the compiler. If several programs fail, throws the first one's error.
std::unique_ptr<Code> compilePipeline(const PipelineRequest& request, ObjectStore* store = nullptr);

// Functions that the module declares but that neither the module nor the library defines.
std::vector<const ptx::Function*> undefinedFunctions(const ptx::Module& module);

// Whether a program of this module can be compiled without the other modules of its pipeline: the
// module declares no functions or variables that are defined elsewhere.
bool isSelfContained(const ptx::Module& module, const PipelineRules& rules);

// Compiles one OptiX 7 program of a self-contained module into its store, before the pipeline that
// uses it is created. Throws as compilePipeline does.
void precompile(const ProgramRequest& program, const PipelineRules& rules);

// Bytes of stack that a program of a self-contained module takes, including all functions that it
// calls by name. Frame sizes come from the machine code, which is in the program's store or is
// compiled and stored here. Throws as compilePipeline does.
unsigned stackNeed(const ProgramRequest& program, const PipelineRules& rules);

// Finds the source line of an address in loaded code of a pipeline, from the line information of
// its PTX. False if the line is unknown (other code, debug level NONE, PTX without .loc). Slow.
struct SourceLocation {
    std::string file;
    std::string function;
    unsigned line = 0;
    unsigned column = 0;
};
bool sourceLocation(const void* address, SourceLocation& location);

// For the memory checker: whether the range lies in variables of loaded code, or in one block of
// memory that device code allocated.
bool inDeviceData(const void* address, size_t bytes);

// Finds the place in the application's own code by the debug information of its file: the line, or
// without debug information "file+0xoffset" in `file` and line 0. False if no file is known.
bool hostLocation(const void* address, SourceLocation& location);

// A CUDA module: every .entry with parameters becomes a KernelFn.
struct KernelInfo {
    std::string name;
    const void* address = nullptr; // devlib::KernelFn
    std::vector<uint32_t> parameterOffsets;
    std::vector<uint32_t> parameterSizes;
    uint32_t parameterBytes = 0;
    uint32_t staticSharedBytes = 0;
    uint32_t maxThreadsPerBlock = 0; // 0: not limited
    bool usesBarriers = false;       // bar.sync and the like, directly or through callees
    bool usesWarpFunctions = false;  // shuffle, vote, match ...
    bool countsOnSteps = false;      // relies on lockstep without warp functions (lockstep/steps.h)
    uint32_t localBytes = 0;
    // The code that runs a warp at a time; null: none.
    const void* lockstep = nullptr;  // devlib::LockstepFn
    uint32_t lockstepFrameBytes = 0; // LockstepWarp::frame
    bool hasLockstep = false;
    bool needsThreads = false; // all of LockstepWarp::threads, not only the first
    std::string singleReason;  // why the kernel has no lockstep code
    // Why the kernel cannot run; empty if it can. If not empty, address is null.
    std::string unsupported;
};
class KernelCode {
public:
    virtual ~KernelCode() = default;
    virtual const std::vector<KernelInfo>& kernels() const = 0;
    virtual bool variable(std::string_view name, void** address, uint64_t* size) const = 0;
};
std::unique_ptr<KernelCode> compileKernels(std::shared_ptr<const ptx::Module> module);

} // namespace sunstone::compiler
