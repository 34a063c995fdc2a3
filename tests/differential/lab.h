// SPDX-License-Identifier: Apache-2.0
// The tools of all cases: a context, pipelines from the programs of programs.cu, structures, rays.
// All failures are std::runtime_error. The list of cases is at the end.
#pragma once

#include "optix_setup.h"
#include "recording.h"

#include <functional>
#include <memory>

namespace differential {

// The same numbers on every machine.
class Random {
public:
    explicit Random(uint64_t seed) : state_(seed * 2654435761u + 12345) {}
    uint32_t next() {
        state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
        return uint32_t(state_ >> 33);
    }
    float unit() { return float(next() & 0xFFFFFF) * 0x1p-24f; } // [0, 1)
    float symmetric() { return 2 * unit() - 1; }

private:
    uint64_t state_;
};

// The programs of one hit record.
struct HitRecord {
    const char* closestHit = "__closesthit__triangle";
    const char* anyHit = nullptr;
    const char* intersection = nullptr;
    OptixPrimitiveType builtin = OPTIX_PRIMITIVE_TYPE_CUSTOM; // another: its intersection program
    RecordData data = {};
};

struct Pipeline {
    std::string_view ptx; // empty: the programs for triangles and custom primitives
    const char* raygen = "__raygen__trace";
    unsigned graphFlags = OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS;
    unsigned primitiveTypes = unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE);
    bool motion = false, micromaps = false, exceptions = false, callables = false;
    unsigned exceptionFlags = OPTIX_EXCEPTION_FLAG_NONE, traceDepth = 1, graphDepth = 1;
    std::vector<HitRecord> hits;
};

struct Mesh {
    std::vector<float> vertices; // 3 each; of all motion keys, one after the other
    std::vector<uint32_t> indices, sbt;
    std::vector<unsigned> flags = {OPTIX_GEOMETRY_FLAG_NONE};
    unsigned keys = 1;
};
Mesh randomTriangles(unsigned count, float size, uint64_t seed);
Mesh roughSphere(unsigned rings, uint64_t seed); // closed

class Lab {
public:
    Lab() : context_(createContext()) {}
    ~Lab() { optixDeviceContextDestroy(context_); }
    OptixDeviceContext context() const { return context_; }

    // With random access to vertices.
    Accel triangles(const Mesh& mesh, const OptixMotionOptions& motion = {}) const;
    Accel instances(const std::vector<OptixInstance>& instances,
                    const OptixMotionOptions& motion = {}) const;
    Accel boxes(const std::vector<float>& spheres, unsigned flags) const;

    std::vector<Seen> trace(const Pipeline& pipeline, std::vector<TestRay> rays,
                            OptixTraversableHandle handle) const;

private:
    OptixDeviceContext context_;
};

TestRay makeRay(const float origin[3], const float direction[3]);
// Rays from a cube of half the edge `spread` towards its middle, with intervals and masks of all
// kinds.
std::vector<TestRay> randomRays(size_t count, float spread, uint64_t seed);
OptixInstance makeInstance(OptixTraversableHandle child, uint64_t seed);
void randomMatrix(float matrix[12], uint64_t seed);

struct Case {
    const char* name;
    std::function<void(const Lab&, Answer&)> run;
};
const std::vector<Case>& allCases();

// The parts of the list of cases.
std::vector<Case> triangleCases();
std::vector<Case> instanceCases();
std::vector<Case> shapeCases();
std::vector<Case> motionCases();
std::vector<Case> programCases();
std::vector<Case> footprintCases();
std::vector<Case> misuseCases();

} // namespace differential
