// SPDX-License-Identifier: Apache-2.0
// An object of each class, with the name that it has in recorded calls.
#pragma once

#include "calls.h"

#include <optix_math.h>
#include <optixu/optixpp_namespace.h>

#include <gtest/gtest.h>

class OptixPp : public ::testing::Test {
protected:
    OptixPp() {
        recorder = Recorder();
        name(acceleration, "acceleration");
        name(buffer, "buffer");
        name(list, "list");
        name(context, "context");
        name(geometryGroup, "geometryGroup");
        name(instance, "instance");
        name(geometry, "geometry");
        name(triangles, "triangles");
        name(group, "group");
        name(material, "material");
        name(stage, "stage");
        name(program, "program");
        name(selector, "selector");
        name(sampler, "sampler");
        name(transform, "transform");
        name(variable, "variable");
        recorder.names[memory] = "memory";
    }

    template <typename T>
    void name(optix::Handle<T>& handle, const char* text) {
        void* object = recorder.newObject();
        recorder.names[object] = text;
        handle = optix::Handle<T>::take(static_cast<RTobject>(object));
    }

    // A variable for a result; an array as an argument.
    template <typename T>
    static T& out() {
        static T values[32];
        return values[0];
    }
    template <typename T>
    static const T* input() {
        return &out<T>();
    }

    optix::Acceleration acceleration;
    optix::Buffer buffer;
    optix::CommandList list;
    optix::Context context;
    optix::GeometryGroup geometryGroup;
    optix::GeometryInstance instance;
    optix::Geometry geometry;
    optix::GeometryTriangles triangles;
    optix::Group group;
    optix::Material material;
    optix::PostprocessingStage stage;
    optix::Program program;
    optix::Selector selector;
    optix::TextureSampler sampler;
    optix::Transform transform;
    optix::Variable variable;
    char memory[64];
    void* pointer = nullptr;
};

class OptixPpMembers : public OptixPp {};

// Expects that the expression makes exactly these calls.
#define CALLS(expression, ...)                                                                     \
    do {                                                                                           \
        recorder.calls.clear();                                                                    \
        (void)(expression);                                                                        \
        EXPECT_EQ(recorder.calls, std::vector<std::string>({__VA_ARGS__})) << #expression;         \
    } while (0)
