/* SPDX-License-Identifier: Apache-2.0 */
/* The loop of a window: the picture is resized, restarted and accumulated; a texture of all mip
   levels is filled level by level, and changes while frames go on. Entry points have one, two and
   three dimensions. Calls that the API keeps for old programs stand between the others, and
   launches come before the first rtContextValidate. */
#include <math.h>
#include <optix.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

extern const char device_ptx[];

static RTcontext context;

#define RT(call)                                                                                   \
    do {                                                                                           \
        RTresult code_ = call;                                                                     \
        if (code_ != RT_SUCCESS) {                                                                 \
            const char* text_;                                                                     \
            rtContextGetErrorString(context, code_, &text_);                                       \
            printf("failed: line %d: %s\n", __LINE__, text_);                                      \
            exit(1);                                                                               \
        }                                                                                          \
    } while (0)

static void require(int holds, const char* what, double seen, double wanted) {
    if (!holds) {
        printf("failed: %s: %g in place of %g\n", what, seen, wanted);
        exit(1);
    }
}

enum { DRAW, GRID, LINE, NOTHING, ENTRIES };
enum { LEVELS = 5, SIZE = 16 };

static RTbuffer output, accumulated, grid, line, codes, mips, bytes;

static RTvariable variable(const char* name) {
    RTvariable v;
    RT(rtContextQueryVariable(context, name, &v));
    if (!v)
        RT(rtContextDeclareVariable(context, name, &v));
    return v;
}
static RTbuffer make_buffer(unsigned kind, RTformat format, const char* name) {
    RTbuffer b;
    RT(rtBufferCreate(context, kind, &b));
    RT(rtBufferSetFormat(b, format));
    if (name)
        RT(rtVariableSetObject(variable(name), b));
    return b;
}
static RTprogram program(const char* name) {
    RTprogram p;
    RT(rtProgramCreateFromPTXString(context, device_ptx, name, &p));
    return p;
}

/* Each level has one colour: 10 times its number and the base. */
static void fill_level(unsigned level, float base) {
    RTsize width, height, i;
    float* texels;
    RT(rtBufferGetMipLevelSize2D(mips, level, &width, &height));
    require(width == SIZE >> level && height == SIZE >> level, "size of a level", (double)width,
            SIZE >> level);
    RT(rtBufferMapEx(mips, RT_BUFFER_MAP_WRITE_DISCARD, level, NULL, (void**)&texels));
    for (i = 0; i < width * height; ++i) {
        texels[4 * i] = base + 10.0f * (float)level;
        texels[4 * i + 1] = base;
        texels[4 * i + 2] = (float)level;
        texels[4 * i + 3] = 1;
    }
    RT(rtBufferUnmapEx(mips, level));
}

static RTtexturesampler make_sampler(RTbuffer buffer, RTfiltermode mip, RTtexturereadmode mode) {
    RTtexturesampler sampler;
    RT(rtTextureSamplerCreate(context, &sampler));
    RT(rtTextureSamplerSetWrapMode(sampler, 0, RT_WRAP_REPEAT));
    RT(rtTextureSamplerSetWrapMode(sampler, 1, RT_WRAP_CLAMP_TO_EDGE));
    RT(rtTextureSamplerSetIndexingMode(sampler, RT_TEXTURE_INDEX_NORMALIZED_COORDINATES));
    RT(rtTextureSamplerSetReadMode(sampler, mode));
    RT(rtTextureSamplerSetMaxAnisotropy(sampler, 1.0f));
    RT(rtTextureSamplerSetMipLevelCount(sampler, 1));
    RT(rtTextureSamplerSetArraySize(sampler, 1));
    RT(rtTextureSamplerSetFilteringModes(sampler, RT_FILTER_LINEAR, RT_FILTER_LINEAR, mip));
    RT(rtTextureSamplerSetBuffer(sampler, 0, 0, buffer));
    return sampler;
}

static void make_textures(void) {
    unsigned i, j;
    unsigned char* texels;
    mips = make_buffer(RT_BUFFER_INPUT, RT_FORMAT_FLOAT4, NULL);
    RT(rtBufferSetMipLevelCount(mips, LEVELS));
    RT(rtBufferSetSize2D(mips, SIZE, SIZE));
    for (i = 0; i < LEVELS; ++i)
        fill_level(i, 1);
    RT(rtVariableSetObject(variable("mip_texture"),
                           make_sampler(mips, RT_FILTER_LINEAR, RT_TEXTURE_READ_ELEMENT_TYPE)));
    bytes = make_buffer(RT_BUFFER_INPUT, RT_FORMAT_UNSIGNED_BYTE4, NULL);
    RT(rtBufferSetSize2D(bytes, 2, 1));
    RT(rtBufferMap(bytes, (void**)&texels));
    for (i = 0; i < 2; ++i)
        for (j = 0; j < 4; ++j)
            texels[4 * i + j] = 7; /* filtering changes nothing */
    RT(rtBufferUnmap(bytes));
    RT(rtVariableSetObject(variable("byte_texture"),
                           make_sampler(bytes, RT_FILTER_NONE, RT_TEXTURE_READ_NORMALIZED_FLOAT)));
}

static void resize(unsigned width, unsigned height) {
    RT(rtBufferSetSize2D(output, width, height));
    RT(rtBufferSetSize2D(accumulated, width, height));
}

static void expect_picture(unsigned width, unsigned height, double wanted) {
    RTsize w, h, i;
    unsigned dimensions;
    const unsigned char* pixels;
    RT(rtBufferGetSize2D(output, &w, &h));
    RT(rtBufferGetDimensionality(output, &dimensions));
    require(w == width && h == height && dimensions == 2, "size of the picture", (double)w, width);
    RT(rtBufferMap(output, (void**)&pixels));
    for (i = 0; i < w * h; ++i)
        require(fabs(pixels[4 * i] - wanted) <= 1, "pixel", pixels[4 * i], wanted);
    RT(rtBufferUnmap(output));
}

static void make_context(void) {
    static const char* const names[ENTRIES] = {"draw", "fill_grid", "fill_line",
                                               "look_into_nothing"};
    RTgroup nothing;
    RTacceleration acceleration;
    unsigned i;
    RT(rtContextCreate(&context));
    RT(rtContextSetRayTypeCount(context, 2));
    RT(rtContextSetEntryPointCount(context, ENTRIES));
    RT(rtContextSetStackSize(context, 1000));
    RT(rtContextSetPrintEnabled(context, 1));
    RT(rtContextSetPrintBufferSize(context, 1024));
    output = make_buffer(RT_BUFFER_OUTPUT, RT_FORMAT_UNSIGNED_BYTE4, "output_buffer");
    accumulated =
        make_buffer(RT_BUFFER_INPUT_OUTPUT | RT_BUFFER_GPU_LOCAL, RT_FORMAT_FLOAT4, "accum_buffer");
    grid = make_buffer(RT_BUFFER_INPUT_OUTPUT, RT_FORMAT_INT, "grid");
    line = make_buffer(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT, "line");
    codes = make_buffer(RT_BUFFER_INPUT_OUTPUT, RT_FORMAT_INT, "codes");
    RT(rtBufferSetSize3D(grid, 3, 4, 5));
    RT(rtBufferSetSize1D(line, 50));
    RT(rtBufferSetSize1D(codes, 3));
    resize(1, 1);
    /* Variables have their values before the programs that read them exist. */
    RT(rtVariableSet1ui(variable("frame"), 0));
    RT(rtVariableSet1f(variable("level"), 0));
    RT(rtVariableSet4f(variable("bad_color"), 1, 0, 1, 0));
    RT(rtGroupCreate(context, &nothing));
    RT(rtGroupSetChildCount(nothing, 0));
    RT(rtAccelerationCreate(context, &acceleration));
    RT(rtAccelerationSetBuilder(acceleration, "NoAccel"));
    RT(rtAccelerationSetTraverser(acceleration, "NoAccel"));
    RT(rtAccelerationSetProperty(acceleration, "no_such_property", "1"));
    RT(rtGroupSetAcceleration(nothing, acceleration));
    RT(rtVariableSetObject(variable("top_object"), nothing));
    make_textures();
    for (i = 0; i < ENTRIES; ++i) {
        RT(rtContextSetRayGenerationProgram(context, i, program(names[i])));
        RT(rtContextSetExceptionProgram(context, i,
                                        program(i == LINE ? "on_line_exception" : "on_exception")));
    }
}

static void draw_frames(void) {
    static const unsigned sizes[][2] = {{8, 8}, {31, 7}, {7, 31}, {64, 48}, {1, 1}, {16, 9}};
    unsigned step, frame;
    for (step = 0; step < sizeof sizes / sizeof *sizes; ++step) {
        const float level = 0.5f * (float)(step % 9);
        double sum = 0;
        resize(sizes[step][0], sizes[step][1]);
        RT(rtVariableSet1f(variable("level"), level));
        for (frame = 0; frame < 4; ++frame) {
            const float base = (float)(step + frame);
            unsigned i;
            for (i = 0; i < LEVELS; ++i)
                fill_level(i, base);
            RT(rtVariableSet1ui(variable("frame"), frame));
            RT(rtContextLaunch2D(context, DRAW, sizes[step][0], sizes[step][1]));
            sum += base + 10 * level + 7 + frame;
            expect_picture(sizes[step][0], sizes[step][1], sum / (frame + 1));
        }
    }
}

static void fill_others(void) {
    int* cells;
    const float* values;
    unsigned x, y, z, pass;
    RT(rtBufferMap(grid, (void**)&cells));
    memset(cells, 0, 60 * sizeof *cells);
    RT(rtBufferUnmap(grid));
    for (pass = 0; pass < 2; ++pass)
        RT(rtContextLaunch3D(context, GRID, 3, 4, 5));
    RT(rtContextLaunch3D(context, GRID, 1, 1, 5));
    RT(rtBufferMap(grid, (void**)&cells));
    for (z = 0; z < 5; ++z)
        for (y = 0; y < 4; ++y)
            for (x = 0; x < 3; ++x) {
                const int once = (int)(x + 10 * y + 100 * z);
                const int wanted = 2 * (once + 60000) + (x == 0 && y == 0 ? once + 5000 : 0);
                require(cells[12 * z + 3 * y + x] == wanted, "cell", cells[12 * z + 3 * y + x],
                        wanted);
            }
    RT(rtBufferUnmap(grid));
    RT(rtContextLaunch1D(context, LINE, 50));
    RT(rtBufferMap(line, (void**)&values));
    for (x = 0; x < 50; ++x)
        require(values[x] == 50 + x, "line", values[x], 50 + x);
    RT(rtBufferUnmap(line));
    RT(rtContextLaunch2D(context, NOTHING, 3, 1));
    RT(rtBufferMap(line, (void**)&values));
    require(values[2] == 5, "a ray into an empty group without a miss program", values[2], 5);
    RT(rtBufferUnmap(line));
}

static void raise_exceptions(void) {
    int* seen;
    const unsigned char* pixels;
    unsigned i;
    int enabled;
    RT(rtContextSetExceptionEnabled(context, RT_EXCEPTION_ALL, 1));
    RT(rtContextGetExceptionEnabled(context, RT_EXCEPTION_BUFFER_INDEX_OUT_OF_BOUNDS, &enabled));
    require(enabled == 1, "exceptions are on", enabled, 1);
    RT(rtVariableSet1i(variable("fail_at"), 5));
    RT(rtVariableSet1ui(variable("frame"), 0));
    resize(4, 4);
    RT(rtBufferMap(codes, (void**)&seen));
    seen[0] = seen[1] = seen[2] = 0;
    RT(rtBufferUnmap(codes));
    RT(rtContextLaunch2D(context, DRAW, 4, 4));
    RT(rtContextLaunch1D(context, LINE, 50));
    RT(rtBufferMap(output, (void**)&pixels));
    for (i = 0; i < 16; ++i)
        require((pixels[4 * i] == 255 && pixels[4 * i + 2] == 255) == (i == 5), "bad pixel", i, 5);
    RT(rtBufferUnmap(output));
    RT(rtBufferMap(codes, (void**)&seen));
    require(seen[0] == RT_EXCEPTION_USER + 77, "code", seen[0], RT_EXCEPTION_USER + 77);
    require(seen[1] == 50, "lines outside", seen[1], 50);
    require(seen[2] == RT_EXCEPTION_BUFFER_INDEX_OUT_OF_BOUNDS, "code outside", seen[2],
            RT_EXCEPTION_BUFFER_INDEX_OUT_OF_BOUNDS);
    RT(rtBufferUnmap(codes));
    RT(rtContextSetExceptionEnabled(context, RT_EXCEPTION_ALL, 0));
    RT(rtContextLaunch1D(context, LINE, 50)); /* writes outside are dropped */
    RT(rtBufferMap(codes, (void**)&seen));
    require(seen[1] == 50, "exceptions are off", seen[1], 50);
    RT(rtBufferUnmap(codes));
}

int main(void) {
    make_context();
    draw_frames();
    fill_others();
    RT(rtContextValidate(context));
    RT(rtContextCompile(context));
    raise_exceptions();
    RT(rtVariableSet1i(variable("fail_at"), -1));
    draw_frames();
    RT(rtContextDestroy(context));
    printf("ok\n");
    return 0;
}
