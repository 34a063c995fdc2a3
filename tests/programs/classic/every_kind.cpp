// SPDX-License-Identifier: Apache-2.0
// A test suite of a renderer: programs of each kind use callables, textures, ids, recursion, local
// arrays, double precision and switches, and throw; one function is a program of several kinds.
#include "common.h"

#include <cmath>
#include <cstring>
#include <vector>

using namespace optix;

namespace {

enum Kind {
    kRaygen,
    kMiss,
    kClosest,
    kAny,
    kIntersection,
    kBounds,
    kVisit,
    kHandler,
    kAttribute,
    kKinds
};
constexpr const char* kNames[kKinds] = {"start",  "miss",  "closest", "any",       "intersect",
                                        "bounds", "visit", "handle",  "attributes"};

float ownOf(int kind) {
    return 3.0f + kind;
}

// What a program of this kind computes.
float valueOf(int kind) {
    constexpr int primes[8] = {2, 3, 5, 7, 11, 13, 17, 19};
    float sum = ownOf(kind) + 2 + kind;
    sum += kind % 2 ? 5 * kind + 1 : 3 * kind;
    sum += 20 + 303 + 4 + 2; // texels, buffer
    sum += 13;               // the sequence 1, 2, 3, 5, 8, 13
    float polynomial = 0;
    for (int i = 0; i < 3 + kind % 4; ++i)
        polynomial = 2 * polynomial + float(primes[(i + kind) & 7]);
    sum += polynomial;
    sum = float(std::sqrt(double(sum) * sum + 3));
    const int label = kind + int(ownOf(kind));
    return sum + float(label == 3 ? 5 : label == 7 ? 9 : label == 13 ? 12 : 100);
}

class Suite {
public:
    Suite() {
        context_ = Context::create();
        context_->setRayTypeCount(1);
        context_->setEntryPointCount(2);
        for (int kind = 0; kind < kKinds; ++kind) {
            programs_[kind] = program(kNames[kind]);
            programs_[kind]["own"]->setFloat(ownOf(kind));
        }
        context_->setRayGenerationProgram(0, programs_[kRaygen]);
        context_->setRayGenerationProgram(1, program("start_alone"));
        context_->setExceptionProgram(0, programs_[kHandler]);
        context_["own"]->setFloat(0); // of programs with ids
        makeTables();
        makeWorld();
    }
    ~Suite() { context_->destroy(); }
    Suite(const Suite&) = delete;

    void setExceptions(RTexception exception) { context_->setExceptionEnabled(exception, true); }

    // Checks that all kinds of programs run; -1: none throws.
    void run(int thrower, const std::string& when) {
        context_->setMissProgram(0, programs_[kMiss]);
        material_->setClosestHitProgram(0, programs_[kClosest]);
        material_->setAnyHitProgram(0, programs_[kAny]);
        context_["thrower"]->setInt(thrower);
        launch(0);
        const float code = read<float>(notes_)[1];
        if (thrower >= 0) {
            require(code == float(RT_EXCEPTION_USER + thrower),
                    when + ": exception code " + std::to_string(code));
            return check(kHandler, when);
        }
        require(code == 0, when + ": an exception");
        for (int kind = 0; kind < kKinds; ++kind)
            if (kind != kHandler)
                check(kind, when);
        const float sum = 1 + 2 + 3 + 4.5f + 5 - 6 + 1 + 200 + 11 + 8 + 4 + 1 - 3;
        require(read<float>(notes_)[0] == sum, when + ": attributes");
    }

    // The same function as miss, closest-hit and any-hit program.
    void runShared() {
        Program shared[3];
        for (int i = 0; i < 3; ++i) {
            shared[i] = program("count");
            shared[i]["own"]->setFloat(float(10 + i));
        }
        context_->setMissProgram(0, shared[0]);
        material_->setClosestHitProgram(0, shared[1]);
        material_->setAnyHitProgram(0, shared[2]);
        launch(1);
        const std::vector<int> runs = read<int>(runs_);
        require(runs[10] == 1 && runs[11] == 1 && runs[12] == 1, "a function of several kinds");
    }

private:
    Program program(const char* name) {
        return context_->createProgramFromPTXString(device_ptx, name);
    }
    Buffer buffer(const char* variable, RTformat format, size_t count) {
        Buffer made = context_->createBuffer(RT_BUFFER_INPUT_OUTPUT, format, count);
        if (variable)
            context_[variable]->set(made);
        return made;
    }
    template <class T>
    static void write(Buffer to, const std::vector<T>& items) {
        std::memcpy(to->map(), items.data(), items.size() * sizeof(T));
        to->unmap();
    }
    template <class T>
    static std::vector<T> read(Buffer from) {
        RTsize count = 0;
        from->getSize(count);
        const T* const items = static_cast<const T*>(from->map());
        std::vector<T> all(items, items + count);
        from->unmap();
        return all;
    }

    void makeTables() {
        values_ = buffer("values", RT_FORMAT_FLOAT, kKinds);
        runs_ = buffer("runs", RT_FORMAT_INT, 16);
        notes_ = buffer("notes", RT_FORMAT_FLOAT, 2);
        Program thrice = program("thrice"), five = program("five_times");
        write<int>(buffer("by_id", RT_FORMAT_PROGRAM_ID, 2), {thrice->getId(), five->getId()});
        context_["bound"]->set(program("add_own"));
        Buffer pairs = buffer(nullptr, RT_FORMAT_FLOAT2, 2);
        write<float>(pairs, {1, 2, 3, 4});
        context_["pairs"]->setInt(pairs->getId());
        Buffer texels = context_->createBuffer(RT_BUFFER_INPUT, RT_FORMAT_FLOAT4, 2, 2);
        std::vector<float> colours(16);
        for (int i = 0; i < 16; ++i) // the second component is 20, the third 300; 3 more per texel
            colours[i] = float((i % 4 + 1) * (i % 4 == 1 ? 10 : 100) + i / 4 * 3);
        write(texels, colours);
        TextureSampler sampler = context_->createTextureSampler();
        sampler->setBuffer(texels);
        sampler->setFilteringModes(RT_FILTER_NEAREST, RT_FILTER_NEAREST, RT_FILTER_NONE);
        sampler->setReadMode(RT_TEXTURE_READ_ELEMENT_TYPE);
        context_["by_reference"]->set(sampler);
        context_["texture_id"]->setInt(sampler->getId());
    }

    GeometryGroup group(const GeometryInstance& instance) {
        GeometryGroup made = context_->createGeometryGroup();
        made->addChild(instance);
        made->setAcceleration(context_->createAcceleration("Trbvh"));
        return made;
    }
    void makeWorld() {
        material_ = context_->createMaterial();
        Geometry custom = context_->createGeometry();
        custom->setPrimitiveCount(1);
        custom->setIntersectionProgram(programs_[kIntersection]);
        custom->setBoundingBoxProgram(programs_[kBounds]);
        box_ = group(context_->createGeometryInstance(custom, &material_, &material_ + 1));
        Selector selector = context_->createSelector();
        selector->setVisitProgram(programs_[kVisit]);
        selector->addChild(box_);

        Buffer corners = buffer(nullptr, RT_FORMAT_FLOAT3, 3);
        write<float>(corners, {7, -3, 0, 11, -3, 0, 9, 5, 0});
        GeometryTriangles triangle = context_->createGeometryTriangles();
        triangle->setPrimitiveCount(1);
        triangle->setVertices(3, corners, RT_FORMAT_FLOAT3);
        triangle->setAttributeProgram(programs_[kAttribute]);

        top_ = context_->createGroup();
        top_->addChild(selector);
        top_->addChild(group(context_->createGeometryInstance(triangle, material_)));
        top_->setAcceleration(context_->createAcceleration("Trbvh"));
        context_["world"]->set(top_);
    }

    void launch(unsigned entryPoint) {
        write(values_, std::vector<float>(kKinds));
        write(runs_, std::vector<int>(16));
        write(notes_, std::vector<float>(2));
        box_->getAcceleration()->markDirty(); // bounds programs run again
        top_->getAcceleration()->markDirty();
        context_->launch(entryPoint, 1);
    }
    void check(int kind, const std::string& when) {
        const float value = read<float>(values_)[kind], wanted = valueOf(kind);
        require(read<int>(runs_)[kind] > 0, when + ": program " + kNames[kind] + " did not run");
        require(std::fabs(value - wanted) < 1e-4f * wanted,
                when + ": program " + kNames[kind] + " computes " + std::to_string(value) +
                    " in place of " + std::to_string(wanted));
    }

    Context context_;
    Program programs_[kKinds];
    Material material_;
    GeometryGroup box_;
    Group top_;
    Buffer values_, runs_, notes_;
};

} // namespace

int main() {
    return runProgram([] {
        Suite suite;
        suite.run(-1, "without exceptions");
        suite.setExceptions(RT_EXCEPTION_USER);
        for (const int thrower :
             {int(kRaygen), int(kMiss), int(kClosest), int(kAny), int(kIntersection), int(kVisit),
              int(kAttribute), 20 + kRaygen, 20 + kMiss, 20 + kClosest, 20 + kAny,
              20 + kIntersection, 20 + kVisit, 20 + kAttribute})
            suite.run(thrower, "thrown by " + std::to_string(thrower));
        suite.setExceptions(RT_EXCEPTION_ALL);
        suite.run(-1, "with all exceptions");
        suite.runShared();
    });
}
