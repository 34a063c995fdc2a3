// SPDX-License-Identifier: Apache-2.0
// Entry points of groups, selectors and transforms (sections 5.4 to 5.7).
#include "api/optix6/call.h"
#include "api/optix6/scene.h"
#include "api/optix6/setters.h"
#include "bvh/motion/transforms.h"
#include "devlib/graph.h"
#include "math/matrix.h"

#include <algorithm>
#include <cstring>

using namespace sunstone;
using namespace sunstone::optix6;

namespace {

template <class T, class Handle>
RTresult createNode(const char* function, RTcontext context, const char* parameter, Handle* node) {
    const RTresult result = create<T>(function, context, parameter, node);
    if (result == RT_SUCCESS)
        std::static_pointer_cast<T>(objects().find(*node))->enlist();
    return result;
}

template <class T>
void setCount(Node& node, std::vector<T>& slots, unsigned count) {
    constexpr unsigned kMost = 1u << 28;
    if (count > kMost)
        refuse(RT_ERROR_INVALID_VALUE, "count = ", count, " is above ", kMost);
    slots.resize(count);
    node.noteSceneChange();
}

template <class T>
T& slotOf(std::vector<T>& slots, unsigned index) {
    if (index >= slots.size())
        refuse(RT_ERROR_INVALID_VALUE, "index = ", index, " of ", slots.size(), " children");
    return slots[index];
}

std::shared_ptr<Node> childOf(const Node& parent, RTobject handle) {
    requireNonNull(handle, "child");
    const std::shared_ptr<Object> object = objects().find(handle);
    if (!object)
        refuse(RT_ERROR_INVALID_VALUE, "child = ", handle, " is not a live object");
    if (!isNode(object->kind))
        refuse(RT_ERROR_INVALID_VALUE, "child is a ", nameOf(object->kind),
               ", which no node can have as a child");
    if (object->context() != parent.context())
        refuse(RT_ERROR_INVALID_VALUE, "child belongs to another context");
    return std::static_pointer_cast<Node>(object);
}

void childType(const Ref<Node>& slot, RTobjecttype* type) {
    requireNonNull(type, "type");
    *type = RT_OBJECTTYPE_UNKNOWN;
    const std::shared_ptr<Node> child = slot.lock();
    if (!child)
        refuse(RT_ERROR_INVALID_VALUE, "the child is not set");
    *type = typeOf(*child);
}

void requireMask(RTvisibilitymask mask) {
    if (mask > 0xFF)
        refuse(RT_ERROR_INVALID_VALUE, "mask = ", mask, " has more than 8 bits");
}

} // namespace

SUNSTONE_API RTresult rtGeometryGroupCreate(RTcontext context, RTgeometrygroup* geometrygroup) {
    return createNode<GeometryGroup>(__func__, context, "geometrygroup", geometrygroup);
}
SUNSTONE_API RTresult rtGeometryGroupDestroy(RTgeometrygroup geometrygroup) {
    return destroy<GeometryGroup>(__func__, geometrygroup, "geometrygroup");
}
SUNSTONE_API RTresult rtGeometryGroupValidate(RTgeometrygroup geometrygroup) {
    return call<GeometryGroup>(__func__, geometrygroup, "geometrygroup",
                               [](Node& object) { object.context()->scene->validate(object); });
}
SUNSTONE_API RTresult rtGeometryGroupGetContext(RTgeometrygroup geometrygroup, RTcontext* context) {
    return getContext<GeometryGroup>(__func__, geometrygroup, "geometrygroup", context);
}
SUNSTONE_API RTresult rtGeometryGroupSetAcceleration(RTgeometrygroup geometrygroup,
                                                     RTacceleration acceleration) {
    return call<GeometryGroup>(
        __func__, geometrygroup, "geometrygroup", [&](GeometryGroup& object) {
            object.acceleration =
                requireOf<Acceleration>(*object.context(), acceleration, "acceleration");
            object.noteSceneChange();
        });
}
SUNSTONE_API RTresult rtGeometryGroupGetAcceleration(RTgeometrygroup geometrygroup,
                                                     RTacceleration* acceleration) {
    return call<GeometryGroup>(
        __func__, geometrygroup, "geometrygroup", [&](GeometryGroup& object) {
            store(acceleration, "acceleration",
                  static_cast<RTacceleration>(handleOf(object.acceleration)));
        });
}
SUNSTONE_API RTresult rtGeometryGroupSetVisibilityMask(RTgeometrygroup geometrygroup,
                                                       RTvisibilitymask value) {
    return call<GeometryGroup>(__func__, geometrygroup, "geometrygroup",
                               [&](GeometryGroup& object) {
                                   requireMask(value);
                                   object.mask = value;
                                   object.noteMoved();
                               });
}
SUNSTONE_API RTresult rtGeometryGroupGetVisibilityMask(RTgeometrygroup geometrygroup,
                                                       RTvisibilitymask* value) {
    return call<GeometryGroup>(__func__, geometrygroup, "geometrygroup",
                               [&](GeometryGroup& object) { store(value, "mask", object.mask); });
}
SUNSTONE_API RTresult rtGeometryGroupSetFlags(RTgeometrygroup geometrygroup,
                                              RTinstanceflags value) {
    return call<GeometryGroup>(__func__, geometrygroup, "geometrygroup",
                               [&](GeometryGroup& object) {
                                   constexpr unsigned kBoth = RT_INSTANCE_FLAG_DISABLE_ANYHIT |
                                                              RT_INSTANCE_FLAG_ENFORCE_ANYHIT;
                                   if (unsigned(value) > 15 || (value & kBoth) == kBoth)
                                       refuse(RT_ERROR_INVALID_VALUE, "flags = ", unsigned(value),
                                              " has unknown bits or flags that exclude each other");
                                   object.flags = value;
                                   object.noteMoved();
                               });
}
SUNSTONE_API RTresult rtGeometryGroupGetFlags(RTgeometrygroup geometrygroup,
                                              RTinstanceflags* value) {
    return call<GeometryGroup>(__func__, geometrygroup, "geometrygroup",
                               [&](GeometryGroup& object) { store(value, "flags", object.flags); });
}
SUNSTONE_API RTresult rtGeometryGroupSetChildCount(RTgeometrygroup geometrygroup, unsigned count) {
    return call<GeometryGroup>(
        __func__, geometrygroup, "geometrygroup",
        [&](GeometryGroup& object) { setCount(object, object.instances, count); });
}
SUNSTONE_API RTresult rtGeometryGroupGetChildCount(RTgeometrygroup geometrygroup, unsigned* count) {
    return call<GeometryGroup>(
        __func__, geometrygroup, "geometrygroup",
        [&](GeometryGroup& object) { store(count, "count", unsigned(object.instances.size())); });
}
SUNSTONE_API RTresult rtGeometryGroupSetChild(RTgeometrygroup geometrygroup, unsigned index,
                                              RTgeometryinstance child) {
    return call<GeometryGroup>(
        __func__, geometrygroup, "geometrygroup", [&](GeometryGroup& object) {
            auto& slot = slotOf(object.instances, index);
            slot = requireOf<GeometryInstance>(*object.context(), child, "geometryinstance");
            object.noteSceneChange();
        });
}
SUNSTONE_API RTresult rtGeometryGroupGetChild(RTgeometrygroup geometrygroup, unsigned index,
                                              RTgeometryinstance* child) {
    return call<GeometryGroup>(
        __func__, geometrygroup, "geometrygroup", [&](GeometryGroup& object) {
            const auto& slot = slotOf(object.instances, index);
            store(child, "child", static_cast<RTgeometryinstance>(handleOf(slot)));
        });
}
SUNSTONE_API RTresult rtGroupCreate(RTcontext context, RTgroup* group) {
    return createNode<Group>(__func__, context, "group", group);
}
SUNSTONE_API RTresult rtGroupDestroy(RTgroup group) {
    return destroy<Group>(__func__, group, "group");
}
SUNSTONE_API RTresult rtGroupValidate(RTgroup group) {
    return call<Group>(__func__, group, "group",
                       [](Node& object) { object.context()->scene->validate(object); });
}
SUNSTONE_API RTresult rtGroupGetContext(RTgroup group, RTcontext* context) {
    return getContext<Group>(__func__, group, "group", context);
}
SUNSTONE_API RTresult rtGroupSetAcceleration(RTgroup group, RTacceleration acceleration) {
    return call<Group>(__func__, group, "group", [&](Group& object) {
        object.acceleration =
            requireOf<Acceleration>(*object.context(), acceleration, "acceleration");
        object.noteSceneChange();
    });
}
SUNSTONE_API RTresult rtGroupGetAcceleration(RTgroup group, RTacceleration* acceleration) {
    return call<Group>(__func__, group, "group", [&](Group& object) {
        store(acceleration, "acceleration",
              static_cast<RTacceleration>(handleOf(object.acceleration)));
    });
}
SUNSTONE_API RTresult rtGroupSetVisibilityMask(RTgroup group, RTvisibilitymask value) {
    return call<Group>(__func__, group, "group", [&](Group& object) {
        requireMask(value);
        const bool wasSeenByAll = object.mask == RT_VISIBILITY_ALL;
        object.mask = value;
        object.noteMoved();
        if (wasSeenByAll != (value == RT_VISIBILITY_ALL))
            object.noteSceneChange(); // pipelines for GPUs depend on the node at which rays start
    });
}
SUNSTONE_API RTresult rtGroupGetVisibilityMask(RTgroup group, RTvisibilitymask* value) {
    return call<Group>(__func__, group, "group",
                       [&](Group& object) { store(value, "mask", object.mask); });
}
SUNSTONE_API RTresult rtGroupSetChildCount(RTgroup group, unsigned count) {
    return call<Group>(__func__, group, "group",
                       [&](Group& object) { setCount(object, object.slots, count); });
}
SUNSTONE_API RTresult rtGroupGetChildCount(RTgroup group, unsigned* count) {
    return call<Group>(__func__, group, "group", [&](Group& object) {
        store(count, "count", unsigned(object.slots.size()));
    });
}
SUNSTONE_API RTresult rtGroupSetChild(RTgroup group, unsigned index, RTobject child) {
    return call<Group>(__func__, group, "group", [&](Group& object) {
        auto& slot = slotOf(object.slots, index);
        slot = childOf(object, child);
        object.noteSceneChange();
    });
}
SUNSTONE_API RTresult rtGroupGetChild(RTgroup group, unsigned index, RTobject* child) {
    return call<Group>(__func__, group, "group", [&](Group& object) {
        const auto& slot = slotOf(object.slots, index);
        store(child, "child", static_cast<RTobject>(handleOf(slot)));
    });
}
SUNSTONE_API RTresult rtGroupGetChildType(RTgroup group, unsigned index, RTobjecttype* type) {
    return call<Group>(__func__, group, "group",
                       [&](Group& object) { childType(slotOf(object.slots, index), type); });
}
SUNSTONE_API RTresult rtSelectorCreate(RTcontext context, RTselector* selector) {
    return createNode<Selector>(__func__, context, "selector", selector);
}
SUNSTONE_API RTresult rtSelectorDestroy(RTselector selector) {
    return destroy<Selector>(__func__, selector, "selector");
}
SUNSTONE_API RTresult rtSelectorValidate(RTselector selector) {
    return call<Selector>(__func__, selector, "selector",
                          [](Node& object) { object.context()->scene->validate(object); });
}
SUNSTONE_API RTresult rtSelectorGetContext(RTselector selector, RTcontext* context) {
    return getContext<Selector>(__func__, selector, "selector", context);
}
SUNSTONE_API RTresult rtSelectorSetVisitProgram(RTselector selector, RTprogram handle) {
    return call<Selector>(__func__, selector, "selector", [&](Selector& object) {
        setProgram(object, object.visit, handle, compiler::ProgramKind::kVisit);
    });
}
SUNSTONE_API RTresult rtSelectorGetVisitProgram(RTselector selector, RTprogram* program) {
    return call<Selector>(__func__, selector, "selector", [&](Selector& object) {
        store(program, "program", static_cast<RTprogram>(handleOf(object.visit)));
    });
}
SUNSTONE_API RTresult rtSelectorSetChildCount(RTselector selector, unsigned count) {
    return call<Selector>(__func__, selector, "selector",
                          [&](Selector& object) { setCount(object, object.slots, count); });
}
SUNSTONE_API RTresult rtSelectorGetChildCount(RTselector selector, unsigned* count) {
    return call<Selector>(__func__, selector, "selector", [&](Selector& object) {
        store(count, "count", unsigned(object.slots.size()));
    });
}
SUNSTONE_API RTresult rtSelectorSetChild(RTselector selector, unsigned index, RTobject child) {
    return call<Selector>(__func__, selector, "selector", [&](Selector& object) {
        auto& slot = slotOf(object.slots, index);
        slot = childOf(object, child);
        object.noteSceneChange();
    });
}
SUNSTONE_API RTresult rtSelectorGetChild(RTselector selector, unsigned index, RTobject* child) {
    return call<Selector>(__func__, selector, "selector", [&](Selector& object) {
        const auto& slot = slotOf(object.slots, index);
        store(child, "child", static_cast<RTobject>(handleOf(slot)));
    });
}
SUNSTONE_API RTresult rtSelectorGetChildType(RTselector selector, unsigned index,
                                             RTobjecttype* type) {
    return call<Selector>(__func__, selector, "selector",
                          [&](Selector& object) { childType(slotOf(object.slots, index), type); });
}
SUNSTONE_API RTresult rtTransformCreate(RTcontext context, RTtransform* transform) {
    return createNode<Transform>(__func__, context, "transform", transform);
}
SUNSTONE_API RTresult rtTransformDestroy(RTtransform transform) {
    return destroy<Transform>(__func__, transform, "transform");
}
SUNSTONE_API RTresult rtTransformValidate(RTtransform transform) {
    return call<Transform>(__func__, transform, "transform",
                           [](Node& object) { object.context()->scene->validate(object); });
}
SUNSTONE_API RTresult rtTransformGetContext(RTtransform transform, RTcontext* context) {
    return getContext<Transform>(__func__, transform, "transform", context);
}
SUNSTONE_API RTresult rtTransformSetMotionRange(RTtransform transform, float begin, float end) {
    return call<Transform>(__func__, transform, "transform", [&](Transform& object) {
        setMotionRange(object.motion, begin, end);
        object.noteMoved();
    });
}
SUNSTONE_API RTresult rtTransformGetMotionRange(RTtransform transform, float* begin, float* end) {
    return call<Transform>(__func__, transform, "transform", [&](auto& object) {
        requireNonNull(begin, "timeBegin");
        store(end, "timeEnd", object.motion.end);
        *begin = object.motion.begin;
    });
}
SUNSTONE_API RTresult rtTransformSetMotionBorderMode(RTtransform transform,
                                                     RTmotionbordermode begin,
                                                     RTmotionbordermode end) {
    return call<Transform>(__func__, transform, "transform", [&](Transform& object) {
        setMotionBorders(object.motion, begin, end);
        object.noteMoved();
    });
}
SUNSTONE_API RTresult rtTransformGetMotionBorderMode(RTtransform transform,
                                                     RTmotionbordermode* begin,
                                                     RTmotionbordermode* end) {
    return call<Transform>(__func__, transform, "transform", [&](auto& object) {
        requireNonNull(begin, "beginMode");
        store(end, "endMode", object.motion.endMode);
        *begin = object.motion.beginMode;
    });
}

SUNSTONE_API RTresult rtTransformSetChild(RTtransform transform, RTobject child) {
    return call<Transform>(__func__, transform, "transform", [&](Transform& object) {
        object.child = childOf(object, child);
        object.noteSceneChange();
    });
}
SUNSTONE_API RTresult rtTransformGetChild(RTtransform transform, RTobject* child) {
    return call<Transform>(__func__, transform, "transform", [&](Transform& object) {
        store(child, "child", handleOf(object.child));
    });
}
SUNSTONE_API RTresult rtTransformGetChildType(RTtransform transform, RTobjecttype* type) {
    return call<Transform>(__func__, transform, "transform",
                           [&](Transform& object) { childType(object.child, type); });
}

namespace {

// The affine inverse of a 4x4 matrix with the last row 0 0 0 1.
void invert(const std::array<float, 16>& matrix, std::array<float, 16>& inverse,
            const char* parameter) {
    if (!math::invert(matrix.data(), inverse.data()))
        refuse(RT_ERROR_INVALID_VALUE, parameter, " has no inverse");
}

void setLastRow(std::array<float, 16>& matrix) {
    matrix[12] = matrix[13] = matrix[14] = 0;
    matrix[15] = 1;
}

// A transform that gains or loses motion changes the graph.
void setKeys(Transform& object, std::vector<float> keys, RTmotionkeytype type, unsigned steps) {
    if (keys.empty() != object.keys.empty())
        object.noteSceneChange();
    object.keys = std::move(keys);
    object.keyType = type;
    object.motion.steps = steps;
    object.noteMoved();
}

// The 3x4 matrix of one key with scale, rotation and translation.
void matrixOfSrt(const float* key, float* matrix) {
    alignas(64) bvh::SrtMotionTransform transform{};
    transform.motion.keys = 2;
    for (bvh::SrtKey& each : transform.keys)
        std::memcpy(&each, key, sizeof each);
    bvh::transformAt(devlib::makeHandle(&transform, devlib::kTagSrtMotion), {0, 0}, matrix);
}

} // namespace

SUNSTONE_API RTresult rtTransformSetMatrix(RTtransform transform, int transpose,
                                           const float* matrix, const float* inverse) {
    return call<Transform>(__func__, transform, "transform", [&](Transform& object) {
        if (!matrix && !inverse)
            refuse(RT_ERROR_INVALID_VALUE, "matrix and inverse_matrix are both null");
        std::array<float, 16> to = object.matrix, from = object.inverse;
        if (matrix)
            readMatrix(matrix, transpose != 0, 4, to.data());
        if (inverse)
            readMatrix(inverse, transpose != 0, 4, from.data());
        if (!inverse)
            invert(to, from, "matrix");
        if (!matrix)
            invert(from, to, "inverse_matrix");
        setLastRow(to);
        setLastRow(from);
        object.matrix = to;
        object.inverse = from;
        setKeys(object, {}, RT_MOTIONKEYTYPE_NONE, 1);
    });
}
SUNSTONE_API RTresult rtTransformGetMatrix(RTtransform transform, int transpose, float* matrix,
                                           float* inverse) {
    return call<Transform>(__func__, transform, "transform", [&](Transform& object) {
        if (matrix)
            writeMatrix(object.matrix.data(), transpose != 0, 4, matrix);
        if (inverse)
            writeMatrix(object.inverse.data(), transpose != 0, 4, inverse);
    });
}

SUNSTONE_API RTresult rtTransformSetMotionKeys(RTtransform transform, unsigned n,
                                               RTmotionkeytype type, const float* keys) {
    return call<Transform>(__func__, transform, "transform", [&](Transform& object) {
        requireNonNull(keys, "keys");
        if (n == 0 || n > kMostMotionSteps)
            refuse(RT_ERROR_INVALID_VALUE, "n = ", n, " is outside 1..", kMostMotionSteps);
        if (type != RT_MOTIONKEYTYPE_MATRIX_FLOAT12 && type != RT_MOTIONKEYTYPE_SRT_FLOAT16)
            refuse(RT_ERROR_INVALID_VALUE, "type = ", unsigned(type), " is not a type of keys");
        std::vector<float> copies;
        if (n == 1) {
            std::array<float, 16> matrix{}, inverse{};
            if (type == RT_MOTIONKEYTYPE_SRT_FLOAT16)
                matrixOfSrt(keys, matrix.data());
            else
                std::copy_n(keys, 12, matrix.begin());
            invert(matrix, inverse, "keys");
            setLastRow(matrix);
            setLastRow(inverse);
            object.matrix = matrix;
            object.inverse = inverse;
        } else {
            copies.assign(keys,
                          keys + size_t(n) * (type == RT_MOTIONKEYTYPE_SRT_FLOAT16 ? 16 : 12));
        }
        setKeys(object, std::move(copies), n == 1 ? RT_MOTIONKEYTYPE_NONE : type, n);
    });
}
SUNSTONE_API RTresult rtTransformGetMotionKeyType(RTtransform transform, RTmotionkeytype* type) {
    return call<Transform>(__func__, transform, "transform",
                           [&](Transform& object) { store(type, "type", object.keyType); });
}
SUNSTONE_API RTresult rtTransformGetMotionKeyCount(RTtransform transform, unsigned* n) {
    return call<Transform>(__func__, transform, "transform",
                           [&](Transform& object) { store(n, "n", object.motion.steps); });
}
SUNSTONE_API RTresult rtTransformGetMotionKeys(RTtransform transform, float* keys) {
    return call<Transform>(__func__, transform, "transform", [&](Transform& object) {
        requireNonNull(keys, "keys");
        if (object.keys.empty())
            std::copy_n(object.matrix.begin(), 12, keys);
        else
            std::copy(object.keys.begin(), object.keys.end(), keys);
    });
}
