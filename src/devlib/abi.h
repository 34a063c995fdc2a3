// SPDX-License-Identifier: Apache-2.0
// The contract between compiled device programs and the run-time that calls them: the state that a
// program sees, and the data behind the `_optix_*` calls. Compiled code reads and writes these
// structs by offset (the compiler takes offsetof of this header); traversal and launch code use
// them as C++. Plain data only, no pointers to C++ objects with behaviour.
//
// A program is `uint32_t program(RayState*)`. Every other function of an OptiX module gets the same
// RayState* as a hidden first parameter, indirect calls included. The result:
//   any-hit                     ProgramResult: accept, ignore, terminate
//   intersection                kTerminate if a reported hit ended the ray, else kAccept
//   all others                  ignored (return kAccept)
//
// optixTrace: the caller makes a RayState in its own frame, fills the fields marked [trace], calls
// launch->trace(state) and reads the payload words back.
#pragma once

#include "devlib/graph.h"

#include <cstddef>
#include <cstdint>

namespace sunstone::devlib {

struct RayState;
struct LaunchState;
struct VisitNode;

using ProgramFn = uint32_t (*)(RayState*);

enum ProgramResult : uint32_t { kAccept = 0, kIgnore = 1, kTerminate = 2 };

constexpr unsigned kMaxPayloadWords = 32;
constexpr unsigned kMaxAttributeWords = 8;
constexpr unsigned kMaxGraphDepth = 31; // entries of a transform list; traversables: one more

// Codes of exceptions. User exceptions are 0 and above; those of the run-time have the numbers of
// the API (OptixExceptionCodes).
enum ExceptionCode : int32_t {
    kExceptionTrap = INT32_MIN, // `trap` and a failed assertion: ends the launch
    kExceptionAccess,           // the memory checker found an invalid access: ends the launch
    kExceptionStackOverflow = -1,
    kExceptionTraceDepth = -2,
    kExceptionTraversalDepth = -3,
    kExceptionInvalidTraversable = -5,
    kExceptionInvalidMissSbt = -6,
    kExceptionInvalidHitSbt = -7,
    kExceptionUnsupportedPrimitive = -8,
    kExceptionInvalidRay = -9,
    kExceptionParameterMismatch = -10,
    kExceptionBuiltinIsMismatch = -11,
    kExceptionCallableInvalidSbt = -12,
    kExceptionNoDirectCallable = -13,
    kExceptionNoContinuationCallable = -14,
    kExceptionUnsupportedSingleGas = -15,
    kExceptionInvalidArgument0 = -16, // -17, -18: the next arguments
    kExceptionUnsupportedDataAccess = -32,
    kExceptionPayloadType = -33,
};

// Bits of LaunchState::exceptionFlags (OptixExceptionFlags).
enum ExceptionFlag : uint32_t {
    kFlagStackOverflow = 1,
    kFlagTraceDepth = 2,
    kFlagUser = 4,
    kFlagDebug = 8, // checks in traversal, callables and getters
};

// Numbers of OptixPrimitiveType.
enum PrimitiveType : uint32_t {
    kPrimitiveCustom = 0x2500,
    kPrimitiveQuadraticBSpline = 0x2501,
    kPrimitiveCubicBSpline = 0x2502,
    kPrimitiveLinear = 0x2503,
    kPrimitiveCatmullRom = 0x2504,
    kPrimitiveSphere = 0x2506,
    kPrimitiveTriangle = 0x2531,
};

// First 32 bytes of an SBT record, packed by sbtRecordPackHeader. Holds no address, so that it
// survives copies and is valid before and across pipelines.
struct SbtHeader {
    uint32_t magic;   // kSbtMagic
    uint32_t group;   // Context::nextGroup
    uint32_t kind;    // GroupKind
    uint32_t pad[5];
};
static_assert(sizeof(SbtHeader) == 32);
constexpr uint32_t kSbtMagic = 0x53544E53u;

// The numbers that OptiX 7 has, then those of programs that other generations launch.
enum GroupKind : uint32_t {
    kGroupRaygen = 1,
    kGroupMiss,
    kGroupException,
    kGroupHit,
    kGroupCallables,
    kGroupBounds,
    kGroupVisit,
};

// The roles that programs have in their group. No generation of the API uses all of them.
enum Role : uint32_t {
    kRoleMain, // ray generation, miss, exception, closest-hit, bounds or visit program, by the kind
    kRoleAnyHit,
    kRoleIntersection,
    kRoleDirect,       // direct callable
    kRoleContinuation, // continuation callable
    kRoleAttribute,    // computes the attributes of a built-in primitive's hit
};
constexpr unsigned kRoleCount = 6;

// A program group of a pipeline, with the addresses of its programs by role; null where it has none.
struct GroupEntry {
    const void* code[kRoleCount];
    GroupKind kind; // 0: the number belongs to no group of the pipeline
    uint32_t builtinPrimitive; // OptixPrimitiveType of a built-in intersection; 0: none
    // For kFlagDebug: 32-bit words of parameters and names of the direct and the continuation callable.
    uint32_t callableWords[2];
    const char* callableNames[2];

    ProgramFn program(Role role) const { return ProgramFn(code[role]); }
};

struct SbtView {
    uint64_t entryRecord; // of the program that runs for each launch index
    uint64_t exceptionRecord;
    uint64_t missBase;
    uint64_t hitBase;
    uint64_t callableBase;
    uint32_t missStride, missCount;
    uint32_t hitStride, hitCount;
    uint32_t callableStride, callableCount;
};

// Getters that LaunchState::checkAccess knows; first and second are their further operands.
enum AccessKind : uint32_t {
    kAccessVertices,      // gas, primitive, sbtGasIndex
    kAccessInstance,      // ias, index
    kAccessTransformList, // 0, index
    kAccessMotion,        // gas
};

// Data of the getters of exception programs; members that the code does not use are zero.
struct ExceptionInfo {
    uint64_t traversable;
    uint32_t sbtOffset;
    uint32_t expectedWords; // these four in the order of the getter's results
    uint32_t passedWords;
    uint32_t callableIndex;
    const char* callableName;
    float ray[9]; // origin, direction, tmin, tmax, time
    uint32_t pad;
    const char* line; // "file:line:column", null if not known
};

// Motion of a geometry acceleration structure, as built; 1 key and times 0 without motion.
struct GasMotion {
    uint32_t keys;
    float begin, end;
};

// An access that code compiled for the memory checker is about to make.
enum AccessVerb : uint8_t { kAccessLoad, kAccessStore, kAccessAtomic };
enum AccessSpace : uint8_t { kSpaceGeneric, kSpaceGlobal, kSpaceShared, kSpaceLocal, kSpaceParam };
struct AccessPlace {
    const char* function; // its name in the PTX
    const char* line;     // "file:line:column", empty if not known
    uint32_t ptxLine;
    uint32_t bytes; // also the alignment that the access must have
    uint8_t kind;   // AccessVerb
    uint8_t space;  // AccessSpace
    uint8_t pad[6];
};
struct CheckedAccess {
    uint64_t address;
    const AccessPlace* place; // one for each access in the code
    // The variable that the address was computed from, where the compiler knows it; else 0, 0.
    uint64_t object, objectBytes;
};

// Everything the programs of one launch share; read only while it runs.
struct LaunchState {
    const void* params;           // launch parameter block (a copy made in stream order)
    uint32_t dimensions[3];
    uint32_t maxTraceDepth;
    void (*trace)(RayState*);                                    // traversal + hit/miss programs
    uint32_t (*report)(RayState*, float t, uint32_t kind);       // ProgramResult: kIgnore = rejected
    // Precedes the call of a callable: returns its code (of the right kind) and sets callableData.
    // `call`: bit 0 continuation callable, from bit 8 the number of parameter words passed.
    const void* (*callable)(RayState*, uint32_t sbtIndex, uint32_t call);
    // Called by programs: `trap` and user exceptions. ThreadState::line has the place.
    void (*throwException)(RayState*, int32_t code, uint32_t detailCount, const uint32_t* details);
    // Called by the run-time: leaves the launch index with this code. Does not return.
    void (*raise)(RayState*, int32_t code, const ExceptionInfo* info);
    // With kFlagDebug, before a getter with a handle or index (AccessKind): raises an exception
    // where the getter would return NaN or null.
    void (*checkAccess)(RayState*, uint32_t kind, uint64_t handle, uint32_t first, uint32_t second);
    // With kFlagDebug, at the start of programs with a payload: raises if the trace's type differs.
    void (*checkPayload)(RayState*, uint32_t type);
    // Called by code for the memory checker; ends the launch index if the access is invalid.
    void (*checkMemory)(RayState*, const CheckedAccess*);
    uint64_t paramsBytes;         // of the block at `params`
    SbtView sbt;
    const GroupEntry* groups;     // by group number, from the pipeline's first
    uint32_t firstGroup;          // number of the pipeline's first group
    uint32_t groupCount;          // entries of `groups`
    uint32_t exceptionFlags;      // OptixExceptionFlags of the pipeline
    uint32_t hasAnyHit;           // some hit group of the pipeline has an any-hit program
    uint32_t opacityMicromaps;    // rays test opacity micromaps
    uint32_t motion;              // rays have times; otherwise they meet no moving objects
    uint32_t traversableGraphFlags;
    uint32_t primitiveTypeFlags;
    uint32_t maxGraphDepth;       // limit of traversables on a path
    uint32_t numAttributes;
    // Random access to structures; missing data gives NaN or the null handle.
    void (*triangleVertices)(uint64_t gas, uint32_t primitive, uint32_t sbtGasIndex, float time,
                             float* vertices); // nine floats
    uint64_t (*instanceHandle)(uint64_t ias, uint32_t index);
    void (*gasMotion)(uint64_t gas, GasMotion* motion);
    // Four floats for each control point of a curve's segment, or for a sphere; `shape` is the number
    // of the OptixPrimitiveType.
    void (*shapePoints)(uint64_t gas, uint32_t shape, uint32_t primitive, uint32_t sbtGasIndex,
                        float time, float* points);
    // For generations with visit programs: walks child `index` of the node at RayState::visited,
    // from the current place of the walk. kTerminate: the ray has ended, and the program returns.
    uint32_t (*visitChild)(RayState*, uint32_t index);
    uint32_t attributeBytes; // of an attribute block; 0 in generations with attribute words
    uint32_t entryKind;      // GroupKind of the entry record's group
    float* boxes;            // of bounds programs, six floats for each primitive; else null
    uint32_t firstPrimitive; // of bounds programs: the number of the primitive of launch index 0
    uint32_t motionStep;     // of bounds programs with motion
};

// On GPUs these follow the LaunchState. The kernel receives them as arguments, in this order, after
// the address of the LaunchState, so that reading them is free.
struct LaunchConstants {
    uint64_t usual; // a valid handle that most rays are likely to use; or 0
    uint64_t known; // the table of valid handles, see bvh/gpu/known_handles.h
    uint64_t maxGraphDepth;
    static constexpr unsigned kCount = 3;
};
static_assert(sizeof(LaunchConstants) == LaunchConstants::kCount * sizeof(uint64_t));

// A hit: the candidate of an any-hit or intersection program, or the accepted hit.
struct Hit {
    float t;
    uint32_t kind;
    uint32_t primitive;      // with primitiveIndexOffset
    uint32_t sbtGasIndex;
    uint32_t instanceIndex;  // 0 without instance
    uint32_t instanceId;     // ~0u without instance
    uint32_t instanceSbtOffset;
    uint32_t transformCount; // entries of transforms in use, root first
    uint64_t gas;            // handle
    const void* record;      // SBT record of the hit program, or null
    uint32_t attributes[kMaxAttributeWords]; // barycentrics of triangles: 0 and 1 as floats
    uint64_t transforms[kMaxGraphDepth];     // handles: instances and transforms
};

// One per thread and launch index.
struct ThreadState {
    uint32_t index[3];        // launch index
    uint32_t pad;
    void* exceptionFrame;     // jump target of the launch index, owned by the launch loop
    int32_t exceptionCode;
    uint32_t exceptionDetails[8];
    uint64_t knownHandles[4]; // traversables that trace has found in mapped memory; starts as 0
    RayState* root;           // state of the launch index itself
    uint64_t stackLimit;      // frames below this address are an overflow
    const char* line;         // place of the throw, or (kFlagDebug) of the callable's call; or null
    ExceptionInfo exception;
};

// The data that a program can access. Compiled code fills [trace] fields of a new one at each
// optixTrace; the run-time fills the rest.
struct alignas(64) RayState {
    float worldOrigin[3];     // [trace]
    float tmin;               // [trace]
    float worldDirection[3];  // [trace]
    float tmax;               // [trace]; then the closest accepted t; in any-hit the candidate's t
    float objectOrigin[3];    // ray in the space of the current primitive: intersection, any-hit
    float time;               // [trace]
    float objectDirection[3];
    uint32_t rayFlags;        // [trace]
    uint32_t visibilityMask;  // [trace]
    uint32_t sbtOffset;       // [trace]
    uint32_t sbtStride;       // [trace]
    uint32_t missIndex;       // [trace]
    uint64_t handle;          // [trace] traversable
    const LaunchState* launch; // [trace] copied from the caller's state
    ThreadState* thread;       // [trace] copied from the caller's state
    const void* sbtData;      // data of the running program's SBT record (after the header)
    const void* callableData; // set by LaunchState::callable for the call; read on entry
    uint32_t depth;           // [trace] caller's depth + 1; 0 in ray generation
    uint32_t payloadType;     // [trace] type mask of the trace call, 0 untyped
    uint32_t payloadCount;    // [trace]
    uint32_t pad;
    uint32_t payload[kMaxPayloadWords]; // [trace] the first payloadCount words
    uint32_t reportAttributes[kMaxAttributeWords]; // set before LaunchState::report
    Hit hit;                  // candidate in intersection/any-hit, accepted in closest-hit
    void* traversal;          // private to the traversal loop
    const char* line;         // [trace] place of the trace call, with kFlagDebug; else not set
    // Generations whose payload and attributes are variables of any size keep them in memory and do
    // not use `payload` and the attribute words.
    void* payloadMemory; // [trace] of the caller; in bounds programs the primitive's box
    // [trace] Two blocks of LaunchState::attributeBytes. Programs see the first: in intersection and
    // any-hit the candidate's, in closest-hit the accepted hit's. An accepted hit swaps the two.
    void* attributeBlocks[2];
    const VisitNode* visited; // in visit programs
};

// A node of the traversable graph with a visit program that chooses among its children. 64-byte
// aligned, in device memory.
struct alignas(64) VisitNode {
    uint64_t record;          // of a group of kind kGroupVisit: an SbtHeader, then data
    const uint64_t* children; // traversable handles
    uint32_t count;
    uint32_t pad;
};

// ---- CUDA kernels -----------------------------------------------------------------------------
// A kernel is `void kernel(KernelThread*, const void* params)`; params has the layout of the PTX
// .param list (each parameter at its alignment). Other functions of a kernel module get
// KernelThread* as hidden first parameter, like RayState* above.
struct KernelThread {
    uint32_t tid[3];
    uint32_t ntid[3];
    uint32_t ctaid[3];
    uint32_t nctaid[3];
    uint32_t laneid;          // of the block's linear thread number
    uint32_t warpid;
    uint8_t* shared;          // base of the block's shared memory: statics first, dynamic after;
                              // below 4 GiB, as PTX may hold shared addresses in 32 bits
    uint32_t dynamicSharedSize;
    uint32_t gridIdLow;
    void* block;              // private to the launcher; begins with a BlockFunctions*
    uint64_t gridWorkspace;   // of a cooperative launch, else 0; the word at +4 is the grid barrier's
    uint32_t spins;           // reads of memory that others may write, until the thread yields
    uint32_t sharedBytes;     // of `shared`
};

// Functions of a kernel's meeting points: `(*(BlockFunctions**)thread->block)->barrier(...)`.
// Kernels without meeting points need none; their threads run as a plain loop.
enum BarrierReduction : uint32_t { kReduceNone = 0, kReduceAnd, kReduceOr, kReduceCount };
struct BlockFunctions {
    // bar.sync, bar.red: returns once `threads` threads (0: all running threads of the block) have
    // arrived at barrier `id` (0..15). Result: and / or of `value != 0` (0 or 1), or the number of
    // threads with that.
    uint32_t (*barrier)(KernelThread*, uint32_t id, uint32_t threads, uint32_t reduction,
                        uint32_t value);
    // bar.arrive: counts as an arrival at the barrier, without waiting.
    void (*arrive)(KernelThread*, uint32_t id, uint32_t threads);
    // shfl, vote, match, redux, bar.warp.sync: returns once all running lanes of `mask` have
    // arrived; values[lane] then has the value of each. Result: the lanes that took part.
    uint32_t (*exchange)(KernelThread*, uint32_t mask, uint64_t value, uint64_t values[32]);
    // activemask: the lanes assumed to run together; only the own lane is certain. `site`: of the
    // instruction.
    uint32_t (*activeMask)(KernelThread*, const void* site);
    // exit, or a fault: ends the calling thread. Does not return.
    void (*exitThread)(KernelThread*);
    // trap or a failed assertion: as exitThread, and the launch fails for all its threads.
    void (*fault)(KernelThread*, uint32_t kind);
    // The thread may be waiting for another one: lets others run, and resets `spins`.
    void (*yield)(KernelThread*);
    // Called by code for the memory checker: `fault` if the access is invalid.
    void (*checkMemory)(KernelThread*, const CheckedAccess*);
    // isspacep: the end of the stack that holds the thread's frames.
    uint64_t (*stackEnd)(KernelThread*);
};
enum KernelFault : uint32_t {
    kFaultTrap = 0,
    kFaultAssertion = 1,
    // Found by the memory checker: the other threads of the launch continue.
    kFaultAddress = 2,
    kFaultAlignment = 3,
    kFaultShared = 4,
};
using KernelFn = void (*)(KernelThread*, const void*);

} // namespace sunstone::devlib
