// SPDX-License-Identifier: Apache-2.0
// Every function of the headers with arguments that it must refuse: handles that are null, odd,
// destroyed or of another class, and null in place of each other pointer. functions.inc names the
// functions; the test creates arguments from their types. Other tests have the calls that must
// succeed.
#include "../main/forked_child.h"

#include "optix.h"
#include "optix_cuda_interop.h"
#include "optix_gl_interop.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <typeindex>
#include <vector>

namespace sunstone::api6 {
namespace {

struct World {
    RTcontext context = nullptr;
    std::map<std::type_index, void*> live, dead;
    std::vector<uint64_t> scratch = std::vector<uint64_t>(4096);

    World() {
        rtContextCreate(&context);
        makeAll(context, live);
        RTcontext second = nullptr;
        rtContextCreate(&second);
        makeAll(second, dead);
        rtContextDestroy(second);
    }
    ~World() { rtContextDestroy(context); }
    World(const World&) = delete;

    template <class Handle, class Create>
    static void make(std::map<std::type_index, void*>& list, const Create& create) {
        Handle made = nullptr;
        ASSERT_EQ(create(&made), RT_SUCCESS);
        list[typeid(Handle)] = made;
    }
    template <class Handle>
    static void make(std::map<std::type_index, void*>& list, RTcontext owner,
                     RTresult (*create)(RTcontext, Handle*)) {
        make<Handle>(list, [&](Handle* made) { return create(owner, made); });
    }
    static void makeAll(RTcontext owner, std::map<std::type_index, void*>& list) {
        list[typeid(RTcontext)] = owner;
        make<RTgeometry>(list, owner, rtGeometryCreate);
        make<RTgeometrytriangles>(list, owner, rtGeometryTrianglesCreate);
        make<RTmaterial>(list, owner, rtMaterialCreate);
        make<RTgeometryinstance>(list, owner, rtGeometryInstanceCreate);
        make<RTgeometrygroup>(list, owner, rtGeometryGroupCreate);
        make<RTgroup>(list, owner, rtGroupCreate);
        make<RTselector>(list, owner, rtSelectorCreate);
        make<RTtransform>(list, owner, rtTransformCreate);
        make<RTacceleration>(list, owner, rtAccelerationCreate);
        make<RTtexturesampler>(list, owner, rtTextureSamplerCreate);
        make<RTbuffer>(
            list, [&](RTbuffer* made) { return rtBufferCreate(owner, RT_BUFFER_INPUT, made); });
        make<RTvariable>(list, [&](RTvariable* made) {
            return rtContextDeclareVariable(owner, "number", made);
        });
        make<RTprogram>(list, [&](RTprogram* made) {
            return rtProgramCreateFromPTXString(
                owner,
                ".version 6.0\n.target sm_50\n.address_size 64\n.visible .entry p() { ret; }", "p",
                made);
        });
    }
};

template <class T>
constexpr bool isHandle = false;
template <class T>
constexpr bool isHandle<T*> = std::is_class_v<T> && !std::is_const_v<T>;

// A plausible argument of this type.
template <class T>
T good(World& w) {
    if constexpr (std::is_same_v<T, RTobject>)
        return w.live[typeid(RTgeometrygroup)];
    else if constexpr (std::is_same_v<T, const char*>)
        return "name";
    else if constexpr (isHandle<T>)
        return static_cast<T>(w.live[typeid(T)]);
    else if constexpr (std::is_pointer_v<T> && std::is_function_v<std::remove_pointer_t<T>>)
        return nullptr;
    else if constexpr (std::is_pointer_v<T>)
        return reinterpret_cast<T>(w.scratch.data());
    else
        return T{};
}

// A call with one argument replaced.
template <class... A, size_t... i>
RTresult callWith(World& w, RTresult (*function)(A...), size_t which, void* value,
                  std::index_sequence<i...>) {
    const auto pick = [&]<class T>(size_t index, T otherwise) -> T {
        if constexpr (std::is_pointer_v<T> && !std::is_function_v<std::remove_pointer_t<T>>)
            return index == which ? reinterpret_cast<T>(value) : otherwise;
        else
            return otherwise;
    };
    return function(pick.template operator()<A>(i, good<A>(w))...);
}

struct Function {
    const char* name;
    std::vector<bool> pointers; // which arguments are
    std::type_index first;      // type of the first argument, if it is a handle
    RTresult (*call)(World&, size_t which, void* value);
};

template <auto function>
struct Caller;
template <class... A, RTresult (*function)(A...)>
struct Caller<function> {
    static RTresult call(World& w, size_t which, void* value) {
        return callWith(w, function, which, value, std::index_sequence_for<A...>());
    }
    static std::type_index first() {
        if constexpr (sizeof...(A) > 0)
            if constexpr (isHandle<std::tuple_element_t<0, std::tuple<A...>>>)
                return typeid(std::tuple_element_t<0, std::tuple<A...>>);
        return typeid(void);
    }
    static std::vector<bool> pointers() {
        return {(std::is_pointer_v<A> && !std::is_function_v<std::remove_pointer_t<A>>)...};
    }
};
template <void (*function)(RTcontext, RTresult, const char**)> // rtContextGetErrorString
struct Caller<function> {
    static RTresult call(World&, size_t, void*) { return RT_SUCCESS; }
    static std::type_index first() { return typeid(void); }
    static std::vector<bool> pointers() { return {}; }
};

const std::vector<Function>& functions() {
#define API6_FUNCTION(f) {#f, Caller<f>::pointers(), Caller<f>::first(), Caller<f>::call},
    static const std::vector<Function> all = {
#include "functions.inc"
    };
    return all;
}

// The result for an invalid context. The manual lists RT_ERROR_INVALID_CONTEXT for functions that
// create objects and for launches.
RTresult resultOfBadContext(const std::string& name) {
    static const std::set<std::string> listed = {
        "rtContextGetDeviceCount",  "rtContextGetDevices",         "rtContextValidate",
        "rtContextLaunch1D",        "rtContextLaunch2D",           "rtContextLaunch3D",
        "rtContextStopProgressive", "rtContextLaunchProgressive2D", "rtContextSetRemoteDevice"};
    return listed.count(name) || name.find("Create") != std::string::npos ? RT_ERROR_INVALID_CONTEXT
                                                                          : RT_ERROR_INVALID_VALUE;
}

class Handles : public ::testing::Test {
protected:
    // Checks the result for an invalid first argument; unavailable functions return their own error
    // first.
    void expectRefused(const Function& f, void* handle, const char* what) {
        const bool isContext = f.first == std::type_index(typeid(RTcontext));
        const RTresult wanted =
            isContext ? resultOfBadContext(f.name) : RTresult(RT_ERROR_INVALID_VALUE);
        if (std::string(f.name) == "rtContextGetRunningState") // the manual names no result
            return;
        const RTresult result = f.call(world_, 0, handle);
        if (result != RT_ERROR_NOT_SUPPORTED) {
            EXPECT_EQ(result, wanted) << f.name << " with a handle that is " << what;
        }
    }
    World world_;
};

TEST_F(Handles, NullOddAndDestroyedOnesAreRefused) {
    size_t tried = 0;
    for (const Function& f : functions()) {
        if (f.first == std::type_index(typeid(void)))
            continue;
        expectRefused(f, nullptr, "null");
        expectRefused(f, world_.scratch.data(), "an address");
        expectRefused(f, reinterpret_cast<void*>(~uintptr_t(0)), "odd");
        if (void* dead = world_.dead[f.first])
            expectRefused(f, dead, "destroyed");
        // Of another class.
        void* other = f.first == std::type_index(typeid(RTmaterial))
                          ? world_.live[typeid(RTgeometry)]
                          : world_.live[typeid(RTmaterial)];
        expectRefused(f, other, "of another class");
        ++tried;
    }
    EXPECT_GT(tried, 400u);
    EXPECT_EQ(rtMaterialValidate(static_cast<RTmaterial>(world_.live[typeid(RTmaterial)])),
              RT_SUCCESS)
        << "nothing was destroyed";
}

TEST_F(Handles, NullInPlaceOfOtherPointersIsRefused) {
    // Arguments that the manual allows to be null, with their numbers.
    static const std::set<std::pair<std::string, size_t>> allowed = {
        {"rtContextGetPrintLaunchIndex", 1},
        {"rtContextGetPrintLaunchIndex", 2},
        {"rtContextGetPrintLaunchIndex", 3},
        {"rtTransformGetMatrix", 2},
        {"rtTransformGetMatrix", 3},
        {"rtVariableGetContext", 1},
        {"rtCommandListGetContext", 1},
        {"rtAccelerationSetTraverser", 1},
        {"rtContextSetRemoteDevice", 1},
        // The caller's own data; lists of no items; none of the optional parts.
        {"rtContextSetUsageReportCallback", 3},
        {"rtProgramCallsiteSetPotentialCallees", 2},
        {"rtGeometryTrianglesSetPreTransformMatrix", 2},
        {"rtGeometryTrianglesSetTriangleIndices", 1},
        {"rtGeometryTrianglesSetMaterialIndices", 1},
        // Ranks of mpirun have no users.
        {"rtRemoteDeviceCreate", 1},
        {"rtRemoteDeviceCreate", 2},
        // Another argument is checked first; attributes_test.cpp tests these.
        {"rtGlobalSetAttribute", 2},
        {"rtGlobalGetAttribute", 2},
        {"rtBufferSetDevicePointer", 2}};
    size_t tried = 0;
    for (const Function& f : functions())
        for (size_t i = f.first == std::type_index(typeid(void)) ? 0 : 1; i < f.pointers.size();
             ++i) {
            if (!f.pointers[i] || allowed.count({f.name, i}))
                continue;
            const RTresult result = f.call(world_, i, nullptr);
            if (result != RT_ERROR_NOT_SUPPORTED) {
                EXPECT_EQ(result, RT_ERROR_INVALID_VALUE) << f.name << ", argument " << i;
            }
            ++tried;
        }
    EXPECT_GT(tried, 300u);
}

// The context of a destroyed object is unknown, so the text is not that of an earlier failure.
TEST_F(Handles, TextsOfDeadObjects) {
    RTbuffer buffer = nullptr;
    ASSERT_EQ(rtBufferCreate(world_.context, RT_BUFFER_INPUT, &buffer), RT_SUCCESS);
    EXPECT_EQ(rtBufferSetSize2D(buffer, 0, 1), RT_ERROR_INVALID_VALUE);
    ASSERT_EQ(rtBufferDestroy(buffer), RT_SUCCESS);
    EXPECT_EQ(rtBufferUnmap(buffer), RT_ERROR_INVALID_VALUE);
    const auto text = [&] {
        const char* found = nullptr;
        rtContextGetErrorString(world_.context, RT_ERROR_INVALID_VALUE, &found);
        return std::string(found);
    };
    RTcontext none = nullptr; // which OptiXpp wants to know
    EXPECT_EQ(rtBufferGetContext(buffer, &none), RT_ERROR_INVALID_VALUE);
    EXPECT_NE(text().find("rtBufferUnmap"), std::string::npos) << text();
    EXPECT_EQ(rtContextSetMaxTraceDepth(world_.context, 99), RT_ERROR_INVALID_VALUE);
    EXPECT_NE(text().find("rtContextSetMaxTraceDepth"), std::string::npos) << text();
}

// A forked child lacks the threads of the parent's objects.
TEST_F(Handles, EveryFunctionFailsInAForkedChild) {
    const auto othersInChild = [&] {
        int others = 0;
        for (const Function& f : functions()) {
            if (std::string(f.name) == "rtContextGetErrorString")
                continue;
            const RTresult result = f.call(world_, ~size_t(0), nullptr);
            if (result == RT_ERROR_UNKNOWN)
                continue;
            std::fprintf(stderr, "%s: %d\n", f.name, int(result));
            ++others;
        }
        const char* text = "";
        rtContextGetErrorString(world_.context, RT_ERROR_UNKNOWN, &text);
        return std::string(text).find("fork") == std::string::npos ? others + 1 : others;
    };
    EXPECT_EQ(tests::inChild(othersInChild), 0);
    unsigned count = 0;
    EXPECT_EQ(rtContextGetRayTypeCount(world_.context, &count), RT_SUCCESS) << "the parent goes on";
}

} // namespace
} // namespace sunstone::api6
