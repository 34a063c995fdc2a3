// SPDX-License-Identifier: Apache-2.0
// Entry points of acceleration structures (section 5.8).
#include "api/optix6/call.h"

#include <cstring>

using namespace sunstone;
using namespace sunstone::optix6;

SUNSTONE_API RTresult rtAccelerationCreate(RTcontext context, RTacceleration* acceleration) {
    return create<Acceleration>(__func__, context, "acceleration", acceleration);
}
SUNSTONE_API RTresult rtAccelerationDestroy(RTacceleration acceleration) {
    return destroy<Acceleration>(__func__, acceleration, "acceleration");
}
SUNSTONE_API RTresult rtAccelerationValidate(RTacceleration acceleration) {
    return call<Acceleration>(__func__, acceleration, "acceleration", [](Acceleration& object) {
        if (object.builder.empty())
            refuse(RT_ERROR_INVALID_VALUE, "the acceleration has no builder");
    });
}
SUNSTONE_API RTresult rtAccelerationGetContext(RTacceleration acceleration, RTcontext* context) {
    return getContext<Acceleration>(__func__, acceleration, "acceleration", context);
}

SUNSTONE_API RTresult rtAccelerationSetBuilder(RTacceleration acceleration, const char* builder) {
    return call<Acceleration>(__func__, acceleration, "acceleration", [&](Acceleration& object) {
        requireNonNull(builder, "builder");
        static constexpr const char* kNames[] = {"NoAccel", "Bvh", "Sbvh", "Trbvh"};
        static constexpr const char* kReplaced[] = {"MedianBvh", "Lbvh", "TriangleKdTree"};
        const char* chosen = nullptr;
        for (const char* name : kNames)
            if (std::strcmp(builder, name) == 0)
                chosen = name;
        for (const char* name : kReplaced)
            if (std::strcmp(builder, name) == 0)
                chosen = "Trbvh";
        if (!chosen)
            refuse(RT_ERROR_INVALID_VALUE, "builder = \"", builder,
                   "\" is not the name of a builder");
        object.builder = chosen;
        object.drop();
    });
}
SUNSTONE_API RTresult rtAccelerationGetBuilder(RTacceleration acceleration, const char** builder) {
    return call<Acceleration>(__func__, acceleration, "acceleration", [&](Acceleration& object) {
        requireNonNull(builder, "stringReturn");
        *builder = object.context()->keep(object.builder);
    });
}
SUNSTONE_API RTresult rtAccelerationSetProperty(RTacceleration acceleration, const char* name,
                                                const char* value) {
    return call<Acceleration>(__func__, acceleration, "acceleration", [&](Acceleration& object) {
        requireNonNull(name, "name");
        requireNonNull(value, "value");
        object.properties[name] = value;
    });
}
SUNSTONE_API RTresult rtAccelerationGetProperty(RTacceleration acceleration, const char* name,
                                                const char** value) {
    return call<Acceleration>(__func__, acceleration, "acceleration", [&](Acceleration& object) {
        requireNonNull(name, "name");
        requireNonNull(value, "stringReturn");
        static constexpr std::pair<const char*, const char*> kDefaults[] = {
            {"refit", "0"},
            {"vertex_buffer_name", "vertex_buffer"},
            {"vertex_buffer_stride", "0"},
            {"index_buffer_name", "index_buffer"},
            {"index_buffer_stride", "0"},
            {"chunk_size", "0"},
            {"motion_steps", "2"}};
        const auto set = object.properties.find(name);
        std::string text = set == object.properties.end() ? std::string() : set->second;
        for (const auto& [known, given] : kDefaults)
            if (set == object.properties.end() && std::strcmp(known, name) == 0)
                text = given;
        *value = object.context()->keep(std::move(text));
    });
}
SUNSTONE_API RTresult rtAccelerationMarkDirty(RTacceleration acceleration) {
    return call<Acceleration>(__func__, acceleration, "acceleration",
                              [](Acceleration& object) { object.markDirty(); });
}
SUNSTONE_API RTresult rtAccelerationIsDirty(RTacceleration acceleration, int* dirty) {
    return call<Acceleration>(__func__, acceleration, "acceleration", [&](Acceleration& object) {
        store(dirty, "dirty", int(object.dirty));
    });
}

// Without effect: the manual says so of the last two; the first three "should not be called".
SUNSTONE_API RTresult rtAccelerationGetDataSize(RTacceleration acceleration, RTsize*) {
    return call<Acceleration>(__func__, acceleration, "acceleration", [](Acceleration&) {
        refuse(RT_ERROR_NOT_SUPPORTED, "data of acceleration structures is not available");
    });
}
SUNSTONE_API RTresult rtAccelerationGetData(RTacceleration acceleration, void*) {
    return call<Acceleration>(__func__, acceleration, "acceleration", [](Acceleration&) {
        refuse(RT_ERROR_NOT_SUPPORTED, "data of acceleration structures is not available");
    });
}
SUNSTONE_API RTresult rtAccelerationSetData(RTacceleration acceleration, const void*, RTsize) {
    return call<Acceleration>(__func__, acceleration, "acceleration", [](Acceleration&) {
        refuse(RT_ERROR_NOT_SUPPORTED, "data of acceleration structures is not available");
    });
}
SUNSTONE_API RTresult rtAccelerationSetTraverser(RTacceleration acceleration, const char*) {
    return call<Acceleration>(__func__, acceleration, "acceleration", [](Acceleration&) {});
}
SUNSTONE_API RTresult rtAccelerationGetTraverser(RTacceleration acceleration, const char** text) {
    return call<Acceleration>(__func__, acceleration, "acceleration", [&](Acceleration&) {
        store(text, "stringReturn", static_cast<const char*>(""));
    });
}
