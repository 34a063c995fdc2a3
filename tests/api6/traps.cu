// SPDX-License-Identifier: Apache-2.0
// Programs of traps_test.cpp.
#include <optix_world.h>

using namespace optix;

struct Notes {
    float closest, any, miss, shape;
    float tag;
    float world_to_object[16], object_to_world[16];
    float ray_of_any, ray_of_shape, ray_of_closest, ray_of_attributes;
    int depth;
};

rtDeclareVariable(rtObject, top_object, , );
rtDeclareVariable(Ray, ray, rtCurrentRay, );
rtDeclareVariable(Notes, notes, rtRayPayload, );
rtBuffer<float, 1> result;

// Of each program kind what it finds under one name.
rtDeclareVariable(float, number, , ) = 0.5f;
rtDeclareVariable(int, throws, , "which kind of program throws");
rtDeclareVariable(float, tag, attribute tag, );
rtDeclareVariable(float, shape_ray, attribute shape_ray, );

static __device__ __noinline__ void throwIf(int kind) {
    if (throws == kind)
        rtThrow(RT_EXCEPTION_USER + kind);
}

RT_PROGRAM void note_all() {
    Notes n;
    n.closest = n.any = n.miss = n.shape = n.tag = -1;
    n.ray_of_any = n.ray_of_shape = n.ray_of_closest = n.ray_of_attributes = -1;
    n.depth = 0;
    throwIf(1);
    rtTrace(top_object,
            make_Ray(make_float3(0.25f, 0.25f, 10), make_float3(0, 0, -1), 0, 0.0f, 100.0f), n);
    result[0] = number;
    result[1] = n.closest;
    result[2] = n.any;
    result[3] = n.miss;
    result[4] = n.shape;
    result[5] = n.tag;
    result[6] = n.ray_of_any;
    result[7] = n.ray_of_shape;
    result[8] = n.ray_of_closest;
    result[9] = n.ray_of_attributes;
    for (int i = 0; i < 16; ++i) {
        result[16 + i] = n.world_to_object[i];
        result[32 + i] = n.object_to_world[i];
    }
}
RT_PROGRAM void note_miss() {
    notes.miss = number;
    throwIf(2);
}
RT_PROGRAM void note_thrown() {
    result[60] = rtGetExceptionCode() - RT_EXCEPTION_USER;
    result[61] = number;
}
RT_PROGRAM void note_any() {
    notes.any = number;
    notes.ray_of_any = ray.origin.x;
    throwIf(3);
}
RT_PROGRAM void note_any_and_ignore() {
    notes.any = number;
    rtIgnoreIntersection();
}
RT_CALLABLE_PROGRAM float throw_in_callable(float x) {
    throwIf(5);
    return x;
}
rtDeclareVariable(rtCallableProgramX<float(float)>, callee, , );
RT_PROGRAM void note_closest() {
    notes.closest = number;
    notes.tag = tag;
    notes.shape = shape_ray >= 1000 ? shape_ray - 1000 : notes.shape;
    notes.ray_of_closest = ray.origin.x;
    notes.ray_of_shape = shape_ray;
    throwIf(4);
    notes.closest = callee(notes.closest);
    if (throws == 6 && notes.depth < 3) { // from the third level
        Notes inner = notes;
        inner.depth++;
        if (inner.depth == 3)
            rtThrow(RT_EXCEPTION_USER + 6);
        rtTrace(top_object, ray, inner);
    }
}
rtDeclareVariable(Notes, old_notes, rtPayload, );
RT_PROGRAM void note_by_old_name() {
    old_notes.closest = 77;
}
RT_PROGRAM void note_transforms() {
    rtGetTransform(RT_WORLD_TO_OBJECT, notes.world_to_object);
    rtGetTransform(RT_OBJECT_TO_WORLD, notes.object_to_world);
    notes.ray_of_closest = ray.origin.x;
    notes.ray_of_attributes = tag;
}

// A square of side 1 at z = 5, and a nearer one at z = 6 with another tag.
RT_PROGRAM void two_squares(int primitive) {
    const float z = 5.0f + primitive, t = (z - ray.origin.z) / ray.direction.z;
    const float3 p = ray.origin + t * ray.direction;
    throwIf(7);
    if (p.x >= 0 && p.x <= 1 && p.y >= 0 && p.y <= 1 && rtPotentialIntersection(t)) {
        tag = number + 10.0f * primitive;
        shape_ray = ray.origin.x;
        rtReportIntersection(primitive);
    }
}
RT_PROGRAM void two_bounds(int primitive, float box[6]) {
    box[0] = 0, box[1] = 0, box[2] = 4.99f + primitive;
    box[3] = 1, box[4] = 1, box[5] = 5.01f + primitive;
}
// Bounds that follow the number.
RT_PROGRAM void numbered_bounds(int, float box[6]) {
    box[0] = number, box[1] = 0, box[2] = 4.99f;
    box[3] = number + 1, box[4] = 1, box[5] = 5.01f;
}
RT_PROGRAM void note_attributes() {
    tag = number + 100 * ray.origin.x;
    shape_ray = -1;
    throwIf(8);
}
RT_PROGRAM void visit_all() {
    throwIf(9);
    rtIntersectChild(0);
}

// A ray 50 levels deep.
RT_PROGRAM void deeper() {
    notes.depth++;
    notes.closest = float(notes.depth);
    if (notes.depth < 50)
        rtTrace(top_object, ray, notes);
}

// Bounds that programs compute: half the size of a square around (0.5, 0.5, 5).
rtDeclareVariable(rtCallableProgramX<float(float)>, size_bound, , );
rtDeclareVariable(rtCallableProgramId<float(float)>, size_id, , );
RT_CALLABLE_PROGRAM float half_of(float x) {
    return 0.5f * x;
}
static __device__ void boundsOfSize(float half, float box[6]) {
    box[0] = box[1] = 0.5f - half, box[2] = 4.99f;
    box[3] = box[4] = 0.5f + half, box[5] = 5.01f;
}
RT_PROGRAM void bounds_by_bound(int, float box[6]) {
    boundsOfSize(size_bound(1.0f), box);
}
RT_PROGRAM void bounds_by_id(int, float box[6]) {
    boundsOfSize(size_id(1.0f), box);
}

// Reads texture `id`.
rtDeclareVariable(int, texture_id, , );
RT_PROGRAM void read_texture_id() {
    result[1] = 1;
    result[0] = rtTex2D<float>(texture_id, 1.5f, 1.5f);
    result[1] = 2;
}
RT_PROGRAM void note_code() {
    result[2] = float(rtGetExceptionCode());
}

// A payload, an attribute and the launch, reached by numbers that the compiler does not know.
struct Steps {
    float taken[8];
    int count;
};
rtDeclareVariable(Steps, steps, rtRayPayload, );
rtDeclareVariable(Steps, marks, attribute marks, );
rtDeclareVariable(uint2, launch_size, rtLaunchDim, );
rtDeclareVariable(uint2, launch_place, rtLaunchIndex, );
RT_PROGRAM void take_steps() {
    const int unknown = int(result[1]), width = int((&launch_size.x)[unknown]);
    if ((&launch_place.x)[unknown] != 0)
        return; // the memory checker has seen what other threads read
    Steps mine;
    for (int i = 0; i < 8; ++i)
        mine.taken[i] = 0;
    mine.count = int(result[0]) + width - 50000;
    rtTrace(top_object,
            make_Ray(make_float3(0.25f, 0.25f, 10), make_float3(0, 0, -1), 0, 0.0f, 100.0f), mine);
    result[0] = mine.taken[mine.count];
}
RT_PROGRAM void marked_square(int primitive) {
    if (!rtPotentialIntersection(1))
        return;
    for (int i = 0; i < 8; ++i)
        marks.taken[(i + steps.count) % 8] = float(i);
    marks.count = 3 + primitive;
    rtReportIntersection(0);
}
RT_PROGRAM void step_closest() {
    steps.taken[steps.count] += marks.taken[(steps.count + marks.count) % 8];
}

// A function that no text defines.
extern "C" __device__ float missing_function(float);
RT_PROGRAM void calls_missing() {
    result[0] = missing_function(1);
}
