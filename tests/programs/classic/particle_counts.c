/* SPDX-License-Identifier: Apache-2.0 */
/* A simulation without pictures: particles cross slabs that absorb, and counters are kept in double
   precision by atomic operations of all launch indices. Two entry points and two ray types; sums
   stay on the GPU between launches. Particles that leave the valid numbers are exceptions, which an
   exception program counts and prints. */
#include <math.h>
#include <optix.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

extern const char device_ptx[];

static RTcontext context = 0;

static void check(RTresult result, int line) {
    const char* text = 0;
    if (result == RT_SUCCESS)
        return;
    rtContextGetErrorString(context, result, &text);
    fprintf(stderr, "line %d: %s\n", line, text);
    exit(2);
}
#define RT(call) check(call, __LINE__)

enum { PARTICLES = 20000, SLABS = 5, BAD = 7, LAUNCHES = 3 };

/* As the device has it. */
static double start_energy(unsigned i) {
    return 1.0 + (double)(i % 1000) * 0.001;
}

static RTprogram program(const char* name) {
    RTprogram p;
    RT(rtProgramCreateFromPTXString(context, device_ptx, name, &p));
    return p;
}

static RTbuffer doubles(unsigned kind, size_t count, const char* name) {
    RTbuffer buffer;
    RTvariable variable;
    RT(rtBufferCreate(context, kind, &buffer));
    RT(rtBufferSetFormat(buffer, RT_FORMAT_USER));
    RT(rtBufferSetElementSize(buffer, sizeof(double)));
    RT(rtBufferSetSize1D(buffer, count));
    RT(rtContextDeclareVariable(context, name, &variable));
    RT(rtVariableSetObject(variable, buffer));
    return buffer;
}

static void make_scene(void) {
    RTgeometry geometry;
    RTmaterial material;
    RTgeometryinstance instance;
    RTgeometrygroup group;
    RTacceleration acceleration;
    RTvariable top;
    RT(rtGeometryCreate(context, &geometry));
    RT(rtGeometrySetPrimitiveCount(geometry, SLABS));
    RT(rtGeometrySetBoundingBoxProgram(geometry, program("slab_bounds")));
    RT(rtGeometrySetIntersectionProgram(geometry, program("slab_intersect")));
    RT(rtGeometrySetFlags(geometry, RT_GEOMETRY_FLAG_NO_SPLITTING));
    RT(rtMaterialCreate(context, &material));
    RT(rtMaterialSetAnyHitProgram(material, 0, program("cross_slab")));
    RT(rtMaterialSetClosestHitProgram(material, 1, program("first_slab")));
    RT(rtGeometryInstanceCreate(context, &instance));
    RT(rtGeometryInstanceSetGeometry(instance, geometry));
    RT(rtGeometryInstanceSetMaterialCount(instance, 1));
    RT(rtGeometryInstanceSetMaterial(instance, 0, material));
    RT(rtGeometryGroupCreate(context, &group));
    RT(rtGeometryGroupSetChildCount(group, 1));
    RT(rtGeometryGroupSetChild(group, 0, instance));
    RT(rtAccelerationCreate(context, &acceleration));
    RT(rtAccelerationSetBuilder(acceleration, "Trbvh"));
    RT(rtGeometryGroupSetAcceleration(group, acceleration));
    RT(rtContextDeclareVariable(context, "slabs", &top));
    RT(rtVariableSetObject(top, group));
}

static void make_context(void) {
    RTvariable v;
    RT(rtContextCreate(&context));
    RT(rtContextSetEntryPointCount(context, 2));
    RT(rtContextSetRayTypeCount(context, 2));
    RT(rtContextSetRayGenerationProgram(context, 0, program("fly")));
    RT(rtContextSetRayGenerationProgram(context, 1, program("report")));
    RT(rtContextSetExceptionProgram(context, 0, program("lost")));
    RT(rtContextSetMissProgram(context, 1, program("no_slab")));
    RT(rtContextSetExceptionEnabled(context, RT_EXCEPTION_ALL, 1));
    RT(rtContextSetPrintEnabled(context, 1));
    RT(rtContextSetPrintBufferSize(context, 4096));
    RT(rtContextDeclareVariable(context, "bad_every", &v));
    RT(rtVariableSet1ui(v, PARTICLES / BAD));
    RT(rtContextDeclareVariable(context, "absorption", &v));
    RT(rtVariableSet1f(v, 0.25f));
    make_scene();
}

/* Runs the launches with standard output in a file; returns its text. */
static char* capture(void (*body)(void)) {
    static char text[1 << 16];
    char path[] = "/tmp/particle_counts_XXXXXX";
    const int file = mkstemp(path), before = dup(1);
    size_t length;
    FILE* stream;
    fflush(stdout);
    dup2(file, 1);
    body();
    fflush(stdout);
    dup2(before, 1);
    close(before);
    close(file);
    stream = fopen(path, "r");
    length = fread(text, 1, sizeof text - 1, stream);
    text[length] = 0;
    fclose(stream);
    unlink(path);
    return text;
}

static void fly(void) {
    RT(rtContextLaunch1D(context, 0, PARTICLES));
}
static void fly_on(void) {
    int i;
    for (i = 1; i < LAUNCHES; ++i)
        fly();
}

static int near(double a, double b) {
    return fabs(a - b) <= 1e-9 * (1 + fabs(b));
}

/* Sums over all particles and launches: what each slab takes, what is left, how many are lost. */
static int compare(const double* totals) {
    double wanted[SLABS + 2] = {0};
    unsigned i;
    int slab, wrong = 0;
    for (i = 0; i < PARTICLES; ++i) {
        double energy = start_energy(i);
        if (i % (PARTICLES / BAD) == PARTICLES / BAD - 1) {
            wanted[SLABS + 1] += 1;
            continue;
        }
        for (slab = 0; slab < SLABS; ++slab) {
            wanted[slab] += energy * 0.25;
            energy *= 0.75;
        }
        wanted[SLABS] += energy;
    }
    for (slab = 0; slab < SLABS + 2; ++slab)
        if (!near(totals[slab], wanted[slab] * LAUNCHES)) {
            printf("sum %d is %.12g, not %.12g\n", slab, totals[slab], wanted[slab] * LAUNCHES);
            ++wrong;
        }
    return wrong;
}

static int count_lines(const char* text, const char* start) {
    int count = 0;
    for (; *text; text = strchr(text, '\n') ? strchr(text, '\n') + 1 : text + strlen(text))
        count += strncmp(text, start, strlen(start)) == 0;
    return count;
}

int main(void) {
    RTbuffer sums, totals;
    void* data;
    const char* text;
    int wrong = 0, x, y, z;
    make_context();
    sums = doubles(RT_BUFFER_INPUT_OUTPUT | RT_BUFFER_GPU_LOCAL, SLABS + 2, "sums");
    RT(rtBufferMap(sums, &data));
    memset(data, 0, (SLABS + 2) * sizeof(double));
    RT(rtBufferUnmap(sums));
    totals = doubles(RT_BUFFER_OUTPUT, SLABS + 2, "totals");
    doubles(RT_BUFFER_INPUT_OUTPUT | RT_BUFFER_GPU_LOCAL, PARTICLES, "distances");
    text = capture(fly);
    if (count_lines(text, "lost particle ") != BAD) {
        printf("the program printed: %s", text);
        ++wrong;
    }
    /* From one launch index alone. */
    RT(rtContextSetPrintLaunchIndex(context, PARTICLES / BAD - 1, -1, -1));
    RT(rtContextGetPrintLaunchIndex(context, &x, &y, &z));
    text = capture(fly_on);
    if (x != PARTICLES / BAD - 1 || count_lines(text, "lost particle ") != LAUNCHES - 1) {
        printf("with one index it printed: %s", text);
        ++wrong;
    }
    RT(rtContextSetPrintEnabled(context, 0));
    RT(rtContextLaunch1D(context, 1, SLABS + 2));
    RT(rtBufferMap(totals, &data));
    wrong += compare((const double*)data);
    RT(rtBufferUnmap(totals));
    RT(rtContextDestroy(context));
    if (!wrong)
        printf("ok\n");
    return wrong;
}
