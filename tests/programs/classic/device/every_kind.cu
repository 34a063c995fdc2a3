// SPDX-License-Identifier: Apache-2.0
#include <optix_world.h>

using namespace optix;

enum Kind { kRaygen, kMiss, kClosest, kAny, kIntersection, kBounds, kVisit, kHandler, kAttribute };

struct Payload {
    float unused;
};
// Several types with paddings between them.
struct Surface {
    float3 normal;
    double exact;
    short parts[3];
    bool front;
    unsigned char code;
    rtCallableProgramId<float(float)> shade;
    long long key;
};

rtDeclareVariable(rtObject, world, , );
rtDeclareVariable(Payload, payload, rtPayload, );
rtDeclareVariable(Surface, surface, attribute surface, );
rtDeclareVariable(Matrix3x3, frame, attribute frame, );
rtDeclareVariable(bool, inside, attribute inside, );
rtDeclareVariable(char, side, attribute side, );

rtBuffer<float> values; // by kind of program
rtBuffer<int> runs;
rtBuffer<float> notes; // sum of the attributes, exception code
rtBuffer<rtCallableProgramId<float(float)>> by_id;
rtDeclareVariable(rtCallableProgramX<float(float, int)>, bound, , );
rtTextureSampler<float4, 2> by_reference;
rtDeclareVariable(int, texture_id, , );
rtDeclareVariable(rtBufferId<float2>, pairs, , );
rtDeclareVariable(int, thrower, , ); // the kind that throws; 20 + kind: in its bound callable
rtDeclareVariable(float, own, , );   // of each program

static __constant__ int primes[8] = {2, 3, 5, 7, 11, 13, 17, 19};

static __device__ __noinline__ int count_up(int n) {
    return n < 2 ? n + int(pairs[0].x) : count_up(n - 1) + count_up(n - 2);
}

static __device__ __noinline__ float horner(const float* list, int count, float x) {
    float sum = 0;
    for (int i = 0; i < count; ++i)
        sum = sum * x + list[i];
    return sum;
}

template <int kKind>
static __device__ __forceinline__ void use_everything() {
    float sum = bound(2.0f, kKind);
    sum += by_id[kKind % 2](float(kKind));
    sum += tex2D(by_reference, 0.25f, 0.25f).y;
    sum += rtTex2D<float4>(texture_id, 0.75f, 0.25f).z;
    sum += pairs[1].y + pairs.size();
    sum += count_up(5);
    float list[10];
    for (int i = 0; i < 10; ++i)
        list[i] = primes[(i + kKind) & 7];
    sum += horner(list, 3 + kKind % 4, 2.0f);
    double length = sum;
    for (int i = 0; i < 3; ++i)
        length = sqrt(length * length + 1.0);
    sum = float(length);
    switch (kKind + int(own)) {
    case 3:
        sum += 5;
        break;
    case 7:
        sum += 9;
        break;
    case 13:
        sum += 12;
        break;
    default:
        sum += 100;
    }
    values[kKind] = sum;
    atomicAdd(&runs[kKind], 1);
}

template <int kKind>
static __device__ __forceinline__ void use_and_throw() {
    use_everything<kKind>();
    if (thrower == kKind)
        rtThrow(RT_EXCEPTION_USER + kKind);
}

RT_CALLABLE_PROGRAM float thrice(float x) {
    return x * 3;
}
RT_CALLABLE_PROGRAM float five_times(float x) {
    return x * 5 + pairs[0].x;
}
RT_CALLABLE_PROGRAM float add_own(float x, int kind) {
    if (thrower == 20 + kind)
        rtThrow(RT_EXCEPTION_USER + 20 + kind);
    return own + x + kind;
}

static __device__ void look(float x) {
    Payload p;
    rtTrace(world, make_Ray(make_float3(x, 0, 5), make_float3(0, 0, -1), 0, 0, RT_DEFAULT_MAX), p);
}
RT_PROGRAM void start() {
    use_and_throw<kRaygen>();
    look(0);  // a custom primitive
    look(9);  // a triangle
    look(30); // nothing
}
RT_PROGRAM void miss() {
    use_and_throw<kMiss>();
}
RT_PROGRAM void closest() {
    use_and_throw<kClosest>();
    if (surface.normal.x == 0)
        return; // the triangle
    notes[0] = surface.normal.x + surface.normal.y + surface.normal.z + float(surface.exact) +
               surface.parts[0] + surface.parts[2] + surface.front + surface.code +
               surface.shade(2) + float(surface.key >> 40) + frame[4] + inside + side;
}
RT_PROGRAM void any() {
    use_and_throw<kAny>();
}
RT_PROGRAM void intersect(int) {
    use_and_throw<kIntersection>();
    if (!rtPotentialIntersection(5))
        return;
    Surface made;
    made.normal = make_float3(1, 2, 3);
    made.exact = 4.5;
    made.parts[0] = 5;
    made.parts[1] = 100;
    made.parts[2] = -6;
    made.front = true;
    made.code = 200;
    made.shade = by_id[1];
    made.key = 8ll << 40;
    surface = made;
    Matrix3x3 rows;
    for (int i = 0; i < 9; ++i)
        rows[i] = i;
    frame = rows;
    inside = true;
    side = -3;
    rtReportIntersection(0);
}
RT_PROGRAM void bounds(int, float box[6]) {
    use_everything<kBounds>();
    box[0] = box[1] = box[2] = -1;
    box[3] = box[4] = box[5] = 1;
}
RT_PROGRAM void visit() {
    use_and_throw<kVisit>();
    rtIntersectChild(0);
}
RT_PROGRAM void handle() {
    use_everything<kHandler>();
    notes[1] = rtGetExceptionCode();
}
RT_PROGRAM void attributes() {
    use_and_throw<kAttribute>();
    surface.normal = make_float3(0);
}

// A function that is a program of several kinds.
RT_PROGRAM void count() {
    atomicAdd(&runs[int(own)], 1);
}
RT_PROGRAM void start_alone() {
    look(0);
    look(30);
}
