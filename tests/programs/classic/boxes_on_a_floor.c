/* SPDX-License-Identifier: Apache-2.0 */
/* A program in C in the manner of the first releases: every object by the C functions, each call in
   a macro that prints the error and exits. Parallelogram, sphere and box have bounds and
   intersection programs; two ray types have payloads of their own. The picture is traced again by
   the host. */
#include <math.h>
#include <optix.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

extern const char device_ptx[];

static RTcontext context;

#define RT_CHECK_ERROR(func)                                                                       \
    do {                                                                                           \
        RTresult code = func;                                                                      \
        if (code != RT_SUCCESS) {                                                                  \
            const char* message;                                                                   \
            rtContextGetErrorString(context, code, &message);                                      \
            fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, message);                           \
            exit(1);                                                                               \
        }                                                                                          \
    } while (0)

enum { WIDTH = 160, HEIGHT = 120 };

typedef struct vec {
    double x, y, z;
} vec;
static vec make(double x, double y, double z) {
    vec v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}
static vec add(vec a, vec b) {
    return make(a.x + b.x, a.y + b.y, a.z + b.z);
}
static vec scale(vec a, double s) {
    return make(a.x * s, a.y * s, a.z * s);
}
static vec sub(vec a, vec b) {
    return add(a, scale(b, -1));
}
static double dot(vec a, vec b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static vec unit(vec a) {
    return scale(a, 1 / sqrt(dot(a, a)));
}

/* The scene, by numbers that both sides use. */
static const float sphere[4] = {-1.2f, 1.0f, 0.3f, 1.0f};
static const float boxmin[3] = {0.6f, 0.0f, -0.8f}, boxmax[3] = {2.0f, 1.4f, 0.9f};
static const float light_pos[3] = {3.0f, 6.0f, 4.0f};
static const float eye[3] = {0.5f, 2.5f, 7.0f};
static const float colors[3][3] = {{0.7f, 0.7f, 0.6f}, {0.9f, 0.3f, 0.2f}, {0.2f, 0.5f, 0.9f}};

/* ---- the host's picture ---- */

typedef struct hit {
    double t;
    vec normal;
    int object;
} hit;

static void hit_floor(vec o, vec d, double tmin, hit* best) {
    double t = -o.y / d.y;
    vec p = add(o, scale(d, t));
    if (t > tmin && t < best->t && fabs(p.x) < 6 && fabs(p.z) < 6) {
        best->t = t;
        best->normal = make(0, 1, 0);
        best->object = 0;
    }
}
static void hit_sphere(vec o, vec d, double tmin, hit* best) {
    vec c = make(sphere[0], sphere[1], sphere[2]), oc = sub(o, c);
    double b = dot(oc, d), q = b * b - dot(oc, oc) + sphere[3] * sphere[3];
    int i;
    if (q < 0)
        return;
    for (i = 0; i < 2; ++i) {
        double t = -b + (i ? 1 : -1) * sqrt(q);
        if (t > tmin && t < best->t) {
            best->t = t;
            best->normal = scale(sub(add(o, scale(d, t)), c), 1 / sphere[3]);
            best->object = 1;
            return;
        }
    }
}
static void hit_box(vec o, vec d, double tmin, hit* best) {
    const double origin[3] = {o.x, o.y, o.z}, way[3] = {d.x, d.y, d.z};
    double near_t = -1e30, far_t = 1e30, n[3] = {0, 0, 0};
    int i, axis = 0;
    for (i = 0; i < 3; ++i) {
        double a = (boxmin[i] - origin[i]) / way[i], b = (boxmax[i] - origin[i]) / way[i];
        if (fmin(a, b) > near_t) {
            near_t = fmin(a, b);
            axis = i;
        }
        far_t = fmin(far_t, fmax(a, b));
    }
    if (near_t > far_t || near_t <= tmin || near_t >= best->t)
        return;
    n[axis] = way[axis] > 0 ? -1 : 1;
    best->t = near_t;
    best->normal = make(n[0], n[1], n[2]);
    best->object = 2;
}
static hit trace(vec o, vec d, double tmin, double tmax) {
    hit best;
    best.t = tmax;
    best.normal = make(0, 0, 0);
    best.object = -1;
    hit_floor(o, d, tmin, &best);
    hit_sphere(o, d, tmin, &best);
    hit_box(o, d, tmin, &best);
    return best;
}
static vec shade(vec o, vec d, int depth) {
    hit h = trace(o, d, depth == 0 ? 0 : 1e-3, 1e30);
    vec p, to_light, color, n;
    double distance, cosine;
    if (h.object < 0)
        return add(scale(make(0.2, 0.3, 0.6), d.y > 0 ? d.y : 0), make(0.1, 0.1, 0.1));
    p = add(o, scale(d, h.t));
    n = dot(h.normal, d) > 0 ? scale(h.normal, -1) : h.normal;
    to_light = sub(make(light_pos[0], light_pos[1], light_pos[2]), p);
    distance = sqrt(dot(to_light, to_light));
    to_light = scale(to_light, 1 / distance);
    color = scale(make(colors[h.object][0], colors[h.object][1], colors[h.object][2]), 0.2);
    cosine = dot(n, to_light);
    if (cosine > 0 && trace(p, to_light, 1e-3, distance).object < 0)
        color =
            add(color, scale(make(colors[h.object][0], colors[h.object][1], colors[h.object][2]),
                             0.8 * cosine));
    if (h.object == 1 && depth < 3) /* the sphere is a mirror, too */
        color = add(scale(color, 0.7),
                    scale(shade(p, sub(d, scale(n, 2 * dot(n, d))), depth + 1), 0.3));
    return color;
}
static vec direction(int x, int y) {
    double u = (x + 0.5) / WIDTH * 2 - 1, v = (y + 0.5) / HEIGHT * 2 - 1;
    return unit(make(u * 0.8, v * 0.6 - 0.2, -1));
}

/* ---- the library's picture ---- */

static RTprogram program(const char* name) {
    RTprogram result;
    RT_CHECK_ERROR(rtProgramCreateFromPTXString(context, device_ptx, name, &result));
    return result;
}
static RTvariable variable(const char* name) {
    RTvariable result;
    RT_CHECK_ERROR(rtContextDeclareVariable(context, name, &result));
    return result;
}

static RTgeometryinstance create_instance(const char* shape, int object) {
    RTgeometry geometry;
    RTgeometryinstance instance;
    RTmaterial material;
    RTvariable v;
    char name[64];
    RT_CHECK_ERROR(rtGeometryCreate(context, &geometry));
    RT_CHECK_ERROR(rtGeometrySetPrimitiveCount(geometry, 1u));
    sprintf(name, "%s_bounds", shape);
    RT_CHECK_ERROR(rtGeometrySetBoundingBoxProgram(geometry, program(name)));
    sprintf(name, "%s_intersect", shape);
    RT_CHECK_ERROR(rtGeometrySetIntersectionProgram(geometry, program(name)));
    if (object == 1) {
        RT_CHECK_ERROR(rtGeometryDeclareVariable(geometry, "sphere", &v));
        RT_CHECK_ERROR(rtVariableSet4fv(v, sphere));
    } else if (object == 2) {
        RT_CHECK_ERROR(rtGeometryDeclareVariable(geometry, "boxmin", &v));
        RT_CHECK_ERROR(rtVariableSet3fv(v, boxmin));
        RT_CHECK_ERROR(rtGeometryDeclareVariable(geometry, "boxmax", &v));
        RT_CHECK_ERROR(rtVariableSet3fv(v, boxmax));
    } else {
        RT_CHECK_ERROR(rtGeometryDeclareVariable(geometry, "plane", &v));
        RT_CHECK_ERROR(rtVariableSet4f(v, 0, 1, 0, 0));
        RT_CHECK_ERROR(rtGeometryDeclareVariable(geometry, "anchor", &v));
        RT_CHECK_ERROR(rtVariableSet3f(v, -6, 0, -6));
        RT_CHECK_ERROR(rtGeometryDeclareVariable(geometry, "v1", &v));
        RT_CHECK_ERROR(rtVariableSet3f(v, 12, 0, 0));
        RT_CHECK_ERROR(rtGeometryDeclareVariable(geometry, "v2", &v));
        RT_CHECK_ERROR(rtVariableSet3f(v, 0, 0, 12));
    }
    RT_CHECK_ERROR(rtMaterialCreate(context, &material));
    RT_CHECK_ERROR(rtMaterialSetClosestHitProgram(
        material, 0, program(object == 1 ? "closest_hit_mirror" : "closest_hit_diffuse")));
    RT_CHECK_ERROR(rtMaterialSetAnyHitProgram(material, 1, program("any_hit_shadow")));
    RT_CHECK_ERROR(rtMaterialDeclareVariable(material, "Kd", &v));
    RT_CHECK_ERROR(rtVariableSet3fv(v, colors[object]));
    RT_CHECK_ERROR(rtGeometryInstanceCreate(context, &instance));
    RT_CHECK_ERROR(rtGeometryInstanceSetGeometry(instance, geometry));
    RT_CHECK_ERROR(rtGeometryInstanceSetMaterialCount(instance, 1));
    RT_CHECK_ERROR(rtGeometryInstanceSetMaterial(instance, 0, material));
    RT_CHECK_ERROR(rtGeometryInstanceValidate(instance));
    return instance;
}

static void create_scene(void) {
    RTgeometrygroup group;
    RTacceleration acceleration;
    RTvariable top_object, top_shadower;
    const char* const shapes[3] = {"parallelogram", "sphere", "box"};
    int i;
    RT_CHECK_ERROR(rtGeometryGroupCreate(context, &group));
    RT_CHECK_ERROR(rtGeometryGroupSetChildCount(group, 3));
    for (i = 0; i < 3; ++i)
        RT_CHECK_ERROR(rtGeometryGroupSetChild(group, i, create_instance(shapes[i], i)));
    RT_CHECK_ERROR(rtAccelerationCreate(context, &acceleration));
    RT_CHECK_ERROR(rtAccelerationSetBuilder(acceleration, "NoAccel"));
    RT_CHECK_ERROR(rtAccelerationSetTraverser(acceleration, "NoAccel"));
    RT_CHECK_ERROR(rtGeometryGroupSetAcceleration(group, acceleration));
    RT_CHECK_ERROR(rtAccelerationMarkDirty(acceleration));
    top_object = variable("top_object");
    RT_CHECK_ERROR(rtVariableSetObject(top_object, group));
    top_shadower = variable("top_shadower");
    RT_CHECK_ERROR(rtVariableSetObject(top_shadower, group));
}

static RTbuffer create_context(void) {
    RTbuffer buffer;
    RT_CHECK_ERROR(rtContextCreate(&context));
    RT_CHECK_ERROR(rtContextSetRayTypeCount(context, 2));
    RT_CHECK_ERROR(rtContextSetEntryPointCount(context, 1));
    RT_CHECK_ERROR(rtContextSetStackSize(context, 1800));
    RT_CHECK_ERROR(rtVariableSet1ui(variable("radiance_ray_type"), 0u));
    RT_CHECK_ERROR(rtVariableSet1ui(variable("shadow_ray_type"), 1u));
    RT_CHECK_ERROR(rtVariableSet1f(variable("scene_epsilon"), 1.e-3f));
    RT_CHECK_ERROR(rtVariableSet1i(variable("max_depth"), 3));
    RT_CHECK_ERROR(rtVariableSet3fv(variable("eye"), eye));
    RT_CHECK_ERROR(rtVariableSet3fv(variable("light_pos"), light_pos));
    RT_CHECK_ERROR(rtVariableSet3f(variable("bad_color"), 1.0f, 0.0f, 1.0f));
    RT_CHECK_ERROR(rtContextSetRayGenerationProgram(context, 0, program("pinhole_camera")));
    RT_CHECK_ERROR(rtContextSetExceptionProgram(context, 0, program("exception")));
    RT_CHECK_ERROR(rtContextSetMissProgram(context, 0, program("gradientbg")));
    RT_CHECK_ERROR(rtBufferCreate(context, RT_BUFFER_OUTPUT, &buffer));
    RT_CHECK_ERROR(rtBufferSetFormat(buffer, RT_FORMAT_UNSIGNED_BYTE4));
    RT_CHECK_ERROR(rtBufferSetSize2D(buffer, WIDTH, HEIGHT));
    RT_CHECK_ERROR(rtVariableSetObject(variable("output_buffer"), buffer));
    return buffer;
}

/* Pixels at edges may differ: the two sides round differently. */
static int compare(RTbuffer buffer) {
    void* data;
    const unsigned char* pixels;
    RTsize width, height;
    int x, y, different = 0;
    RT_CHECK_ERROR(rtBufferGetSize2D(buffer, &width, &height));
    RT_CHECK_ERROR(rtBufferMap(buffer, &data));
    pixels = (const unsigned char*)data;
    for (y = 0; y < (int)height; ++y)
        for (x = 0; x < (int)width; ++x) {
            vec c = shade(make(eye[0], eye[1], eye[2]), direction(x, y), 0);
            const double wanted[3] = {c.z, c.y, c.x}; /* blue comes first */
            int i, off = 0;
            for (i = 0; i < 3; ++i) {
                double value = fmin(fmax(wanted[i], 0), 1) * 255;
                off |= fabs(value - pixels[4 * (y * width + x) + i]) > 1.5;
            }
            different += off;
        }
    RT_CHECK_ERROR(rtBufferUnmap(buffer));
    return different;
}

int main(void) {
    const int most = WIDTH * HEIGHT / 500;
    int different;
    RTbuffer buffer = create_context();
    create_scene();
    RT_CHECK_ERROR(rtContextValidate(context));
    RT_CHECK_ERROR(rtContextCompile(context));
    RT_CHECK_ERROR(rtContextLaunch2D(context, 0, 0, 0)); /* compiles and builds */
    RT_CHECK_ERROR(rtContextLaunch2D(context, 0, WIDTH, HEIGHT));
    different = compare(buffer);
    RT_CHECK_ERROR(rtContextDestroy(context));
    if (different > most) {
        printf("%d pixels differ from the host's\n", different);
        return 1;
    }
    printf("ok\n");
    return 0;
}
