// SPDX-License-Identifier: Apache-2.0
// A conformance suite: payloads of 1 to 200 bytes, each with programs from templates and macros,
// on a ray type of its own. Rays then recurse without an end, and the context goes on rendering.
#include "common.h"

#include "device/payload_sizes.h"

#include <cstring>
#include <vector>

using namespace optix;

namespace {

constexpr int kIndices = 300;

template <int size>
int expected(int seed) {
    Bytes<size> bytes;
    fill(bytes, seed);
    bytes.bytes[size - 1] = (unsigned char)(bytes.bytes[size - 1] + 5);
    shuffle(bytes);
    return sum(bytes);
}

class Suite {
public:
    Suite() : context_(Context::create()) {
        context_->setRayTypeCount(kRayTypes);
        context_->setEntryPointCount(2);
        context_->setMaxTraceDepth(25);
        for (unsigned entry = 0; entry < 2; ++entry) {
            context_->setRayGenerationProgram(entry, program(entry ? "recursion" : "all_sizes"));
            context_->setExceptionProgram(entry, program("report"));
        }
        result_ = context_->createBuffer(RT_BUFFER_OUTPUT, RT_FORMAT_INT, kIndices);
        context_["result"]->set(result_);
        context_["endless"]->setInt(0);
        context_["scene"]->set(scene());
    }
    ~Suite() { context_->destroy(); }

    void checkSizes() {
        const std::vector<int> got = launch(0);
        for (int i = 0; i < kIndices; ++i) {
            unsigned total = 0;
#define EXPECTED(size) total = total * 17 + unsigned(expected<size>(i + size));
            SIZES(EXPECTED)
            require(got[size_t(i)] == int(total), "sizes at " + std::to_string(i));
        }
    }

    void checkRecursion(int endless) {
        context_["endless"]->setInt(endless);
        const std::vector<int> got = launch(1);
        for (int i = 0; i < kIndices; ++i) {
            const int value = got[size_t(i)];
            const bool ends = endless == 0 || i % endless != 0;
            require(ends ? value == 1 + i % 20
                         : value == -int(RT_EXCEPTION_STACK_OVERFLOW) ||
                               value == -int(RT_EXCEPTION_TRACE_DEPTH_EXCEEDED),
                    "recursion: " + std::to_string(value) + " at " + std::to_string(i) + " of " +
                        std::to_string(endless));
        }
    }
    void enableExceptions(bool enabled) {
        context_->setExceptionEnabled(RT_EXCEPTION_ALL, enabled);
    }

private:
    Program program(const std::string& name) {
        return context_->createProgramFromPTXString(device_ptx, name);
    }

    GeometryGroup scene() {
        Material material = context_->createMaterial();
        unsigned type = 0;
#define SET(size)                                                                                  \
    material->setClosestHitProgram(type, program("closest" #size));                                \
    material->setAnyHitProgram(type++, program("any" #size));
        SIZES(SET)
        material->setClosestHitProgram(kDepthType, program("deeper"));
        const float corners[9] = {-1, -1, 0, 3, -1, 0, -1, 3, 0};
        Buffer vertices = context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_FLOAT3, 3);
        std::memcpy(vertices->map(), corners, sizeof corners);
        vertices->unmap();
        GeometryTriangles triangles = context_->createGeometryTriangles();
        triangles->setPrimitiveCount(1);
        triangles->setVertices(3, vertices, 0, 12, RT_FORMAT_FLOAT3);
        // Otherwise the any-hit program may run twice.
        triangles->setFlagsPerMaterial(0, RT_GEOMETRY_FLAG_NO_SPLITTING);
        GeometryInstance instance = context_->createGeometryInstance();
        instance->setGeometryTriangles(triangles);
        instance->setMaterialCount(1);
        instance->setMaterial(0, material);
        GeometryGroup group = context_->createGeometryGroup();
        group->addChild(instance);
        group->setAcceleration(context_->createAcceleration("Trbvh"));
        return group;
    }

    std::vector<int> launch(unsigned entry) {
        context_->launch(entry, kIndices);
        std::vector<int> values(kIndices);
        std::memcpy(values.data(), result_->map(), values.size() * sizeof(int));
        result_->unmap();
        return values;
    }

    Context context_;
    Buffer result_;
};

} // namespace

int main() {
    return runProgram([] {
        Suite suite;
        suite.checkSizes();
        suite.enableExceptions(true);
        for (const int endless : {0, 50, 7, 0, 1, 0})
            suite.checkRecursion(endless);
        suite.checkSizes();
        suite.enableExceptions(false);
        suite.checkRecursion(0);
        suite.checkSizes();
    });
}
