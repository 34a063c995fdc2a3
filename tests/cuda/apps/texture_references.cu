// SPDX-License-Identifier: Apache-2.0
// Texture and surface references: variables of a module that the host binds to memory. Compilers no
// longer generate them, but PTX modules still contain them.
#include "driver_cases.h"

#pragma GCC diagnostic ignored "-Wdeprecated-declarations" // all that is tried here is

namespace {

Cases cases;

template <class Call>
void run(const std::string& name, Call&& call) {
    cases.run(name, nullptr, 1, [&](int) { return call(); });
}

const char* const kModule = R"(
.version 6.5
.target sm_70
.address_size 64
.global .texref flat;
.global .texref line;
.global .texref unused;
.global .surfref drawn;
.visible .global .u32 word;

.visible .entry sample(.param .u64 out, .param .f32 x, .param .f32 y)
{
    .reg .u64 %p;
    .reg .f32 %f<6>;
    ld.param.u64 %p, [out];
    ld.param.f32 %f0, [x];
    ld.param.f32 %f1, [y];
    tex.2d.v4.f32.f32 {%f2, %f3, %f4, %f5}, [flat, {%f0, %f1}];
    st.global.v4.f32 [%p], {%f2, %f3, %f4, %f5};
    ret;
}
.visible .entry sampleIntegers(.param .u64 out, .param .f32 x, .param .f32 y)
{
    .reg .u64 %p;
    .reg .f32 %f<2>;
    .reg .u32 %r<4>;
    ld.param.u64 %p, [out];
    ld.param.f32 %f0, [x];
    ld.param.f32 %f1, [y];
    tex.2d.v4.u32.f32 {%r0, %r1, %r2, %r3}, [flat, {%f0, %f1}];
    st.global.v4.u32 [%p], {%r0, %r1, %r2, %r3};
    ret;
}
.visible .entry fetch(.param .u64 out, .param .s32 x)
{
    .reg .u64 %p;
    .reg .s32 %r;
    .reg .f32 %f<4>;
    ld.param.u64 %p, [out];
    ld.param.s32 %r, [x];
    tex.1d.v4.f32.s32 {%f0, %f1, %f2, %f3}, [line, {%r}];
    st.global.v4.f32 [%p], {%f0, %f1, %f2, %f3};
    ret;
}
.visible .entry draw(.param .u32 x, .param .u32 y, .param .u32 value)
{
    .reg .u32 %r<4>;
    ld.param.u32 %r0, [x];
    ld.param.u32 %r1, [y];
    ld.param.u32 %r2, [value];
    shl.b32 %r3, %r0, 2;
    sust.b.2d.b32.trap [drawn, {%r3, %r1}], {%r2};
    ret;
}
)";

CUmodule module;
CUdeviceptr out;

CUfunction kernel(const char* name) {
    CUfunction function = nullptr;
    MUST(cuModuleGetFunction(&function, module, name));
    return function;
}
template <class... Arguments>
CUresult launch(const char* name, Arguments... arguments) {
    void* list[] = {&arguments...};
    const CUresult result =
        cuLaunchKernel(kernel(name), 1, 1, 1, 1, 1, 1, 0, nullptr, list, nullptr);
    return result ? result : cuCtxSynchronize();
}
void print(const char* name, bool integers, CUresult result) {
    float values[4] = {};
    unsigned words[4] = {};
    if (!result) {
        MUST(cuMemcpyDtoH(values, out, sizeof values));
        std::memcpy(words, values, sizeof words);
    }
    std::printf("%s: %s", name, nameOf(result).c_str());
    for (int i = 0; i < 4; ++i)
        integers ? std::printf(" %u", words[i]) : std::printf(" %.4g", values[i]);
    std::printf("\n");
    std::fflush(stdout);
}
void sample(const char* name, float x, float y) {
    MUST(cuMemsetD32(out, 0, 4));
    print(name, false, launch("sample", out, x, y));
}
void sampleIntegers(const char* name, float x, float y) {
    MUST(cuMemsetD32(out, 0, 4));
    print(name, true, launch("sampleIntegers", out, x, y));
}
void fetch(const char* name, int x) {
    MUST(cuMemsetD32(out, 0, 4));
    print(name, false, launch("fetch", out, x));
}

void state(const char* name, CUtexref reference) {
    CUdeviceptr address = 77;
    CUarray array = nullptr;
    CUaddress_mode modes[3] = {};
    CUfilter_mode filter = CUfilter_mode(77), levels = CUfilter_mode(77);
    CUarray_format format = CUarray_format(77);
    int channels = 77, anisotropy = 77;
    unsigned flags = 77;
    float bias = 77, least = 77, most = 77, border[4] = {77, 77, 77, 77};
    CUmipmappedArray mipmap = nullptr;
    std::printf("state of %s:", name);
    const auto say = [](CUresult result) {
        if (result)
            std::printf(" (%s)", nameOf(result).c_str());
    };
    say(cuTexRefGetAddress(&address, reference));
    std::printf(" %s address", address == 77 ? "no" : address ? "an" : "null");
    say(cuTexRefGetArray(&array, reference));
    std::printf(" %s array", array ? "an" : "no");
    say(cuTexRefGetMipmappedArray(&mipmap, reference));
    std::printf(" %s mipmap, modes", mipmap ? "a" : "no");
    for (int i = 0; i < 3; ++i) {
        say(cuTexRefGetAddressMode(&modes[i], reference, i));
        std::printf(" %d", modes[i]);
    }
    say(cuTexRefGetFilterMode(&filter, reference));
    say(cuTexRefGetFormat(&format, &channels, reference));
    say(cuTexRefGetFlags(&flags, reference));
    say(cuTexRefGetMipmapFilterMode(&levels, reference));
    say(cuTexRefGetMipmapLevelBias(&bias, reference));
    say(cuTexRefGetMipmapLevelClamp(&least, &most, reference));
    say(cuTexRefGetMaxAnisotropy(&anisotropy, reference));
    say(cuTexRefGetBorderColor(border, reference));
    std::printf(", filter %d, format %d x %d, flags %u, levels %d %g %g %g, anisotropy %d, border "
                "%g %g %g %g\n",
                filter, format, channels, flags, levels, bias, least, most, anisotropy, border[0],
                border[1], border[2], border[3]);
    std::fflush(stdout);
}

} // namespace

int main() {
    CUcontext context = nullptr;
    MUST(cuInit(0));
    MUST(cuDevicePrimaryCtxRetain(&context, 0));
    MUST(cuCtxSetCurrent(context));
    MUST(cuModuleLoadData(&module, kModule));
    MUST(cuMemAlloc(&out, 64));
    CUtexref flat = nullptr, line = nullptr, unused = nullptr, again = nullptr, own = nullptr;
    CUsurfref drawn = nullptr;
    run("get flat", [&] { return cuModuleGetTexRef(&flat, module, "flat"); });
    run("get line", [&] { return cuModuleGetTexRef(&line, module, "line"); });
    run("get unused", [&] { return cuModuleGetTexRef(&unused, module, "unused"); });
    run("get flat again", [&] { return cuModuleGetTexRef(&again, module, "flat"); });
    std::printf("%s\n", again == flat ? "the same" : "another");
    run("get nothing", [&] { return cuModuleGetTexRef(&again, module, "nothing"); });
    run("get a variable", [&] { return cuModuleGetTexRef(&again, module, "word"); });
    run("get a surface", [&] { return cuModuleGetTexRef(&again, module, "drawn"); });
    run("get null", [&] { return cuModuleGetTexRef(nullptr, module, "flat"); });
    run("get without a name", [&] { return cuModuleGetTexRef(&again, module, nullptr); });
    run("get of no module", [&] { return cuModuleGetTexRef(&again, nullptr, "flat"); });
    run("get surface", [&] { return cuModuleGetSurfRef(&drawn, module, "drawn"); });
    run("get surface flat", [&] {
        CUsurfref s;
        return cuModuleGetSurfRef(&s, module, "flat");
    });
    run("get surface nothing", [&] {
        CUsurfref s;
        return cuModuleGetSurfRef(&s, module, "nothing");
    });
    CUdeviceptr address = 0;
    size_t bytes = 0;
    run("global of a reference",
        [&] { return cuModuleGetGlobal(&address, &bytes, module, "flat"); });
    if (!flat)
        return 0;
    state("flat", flat);
    sample("unbound", 0.5f, 0.5f);

    const Place image = makeArray("image", 8, 4, 0);
    image.fill(1);
    run("bind an array without flags", [&] { return cuTexRefSetArray(flat, image.array, 0); });
    run("bind an array, flags 2", [&] { return cuTexRefSetArray(flat, image.array, 2); });
    run("bind an array",
        [&] { return cuTexRefSetArray(flat, image.array, CU_TRSA_OVERRIDE_FORMAT); });
    state("flat", flat);
    sample("texel", 1.5f, 1.5f);
    sample("beyond", 100.f, -3.f);
    run("linear", [&] { return cuTexRefSetFilterMode(flat, CU_TR_FILTER_MODE_LINEAR); });
    sample("between", 2.f, 2.f);
    run("border", [&] { return cuTexRefSetAddressMode(flat, 0, CU_TR_ADDRESS_MODE_BORDER); });
    float border[4] = {0.25f, 0.4f, 0.75f, 1};
    run("border color", [&] { return cuTexRefSetBorderColor(flat, border); });
    sample("beyond, border", 100.f, 1.5f);
    run("wrap", [&] { return cuTexRefSetAddressMode(flat, 0, CU_TR_ADDRESS_MODE_WRAP); });
    run("normalised", [&] { return cuTexRefSetFlags(flat, CU_TRSF_NORMALIZED_COORDINATES); });
    sample("wrapped", 1.2f, 0.5f);
    run("integers", [&] { return cuTexRefSetFlags(flat, CU_TRSF_READ_AS_INTEGER); });
    run("point", [&] { return cuTexRefSetFilterMode(flat, CU_TR_FILTER_MODE_POINT); });
    sampleIntegers("as integers", 1.5f, 1.5f);
    state("flat", flat);
    run("mode of dimension 3",
        [&] { return cuTexRefSetAddressMode(flat, 3, CU_TR_ADDRESS_MODE_CLAMP); });
    run("mode of dimension -1",
        [&] { return cuTexRefSetAddressMode(flat, -1, CU_TR_ADDRESS_MODE_CLAMP); });
    run("mode 9", [&] { return cuTexRefSetAddressMode(flat, 0, CUaddress_mode(9)); });
    run("filter 9", [&] { return cuTexRefSetFilterMode(flat, CUfilter_mode(9)); });
    run("flags 1024", [&] { return cuTexRefSetFlags(flat, 1024); });
    run("format 99", [&] { return cuTexRefSetFormat(flat, CUarray_format(99), 1); });
    run("3 channels", [&] { return cuTexRefSetFormat(flat, CU_AD_FORMAT_FLOAT, 3); });
    run("no array", [&] { return cuTexRefSetArray(flat, nullptr, CU_TRSA_OVERRIDE_FORMAT); });
    run("anisotropy", [&] { return cuTexRefSetMaxAnisotropy(flat, 7); });
    run("level filter",
        [&] { return cuTexRefSetMipmapFilterMode(flat, CU_TR_FILTER_MODE_LINEAR); });
    run("level bias", [&] { return cuTexRefSetMipmapLevelBias(flat, 0.5f); });
    run("level clamp", [&] { return cuTexRefSetMipmapLevelClamp(flat, 1, 2); });
    state("flat", flat);

    CUdeviceptr linear = 0;
    MUST(cuMemAlloc(&linear, kBytes));
    std::vector<float> numbers(kBytes / 4);
    for (size_t i = 0; i < numbers.size(); ++i)
        numbers[i] = float(i);
    MUST(cuMemcpyHtoD(linear, numbers.data(), kBytes));
    size_t offset = 77;
    run("format of line", [&] { return cuTexRefSetFormat(line, CU_AD_FORMAT_FLOAT, 1); });
    run("bind line", [&] { return cuTexRefSetAddress(&offset, line, linear, 400); });
    std::printf("offset %zu\n", offset);
    state("line", line);
    fetch("line at 5", 5);
    fetch("line at 100", 100);
    fetch("line at -1", -1);
    run("bind line off the grid",
        [&] { return cuTexRefSetAddress(&offset, line, linear + 64, 400); });
    std::printf("offset %zu\n", offset);
    fetch("line at 20", 20);
    run("bind line off the grid without offset",
        [&] { return cuTexRefSetAddress(nullptr, line, linear + 64, 400); });
    run("bind line without offset",
        [&] { return cuTexRefSetAddress(nullptr, line, linear + 512, 400); });
    fetch("line at 2", 2);
    run("four channels", [&] { return cuTexRefSetFormat(line, CU_AD_FORMAT_FLOAT, 4); });
    run("bind line again", [&] { return cuTexRefSetAddress(&offset, line, linear, 400); });
    fetch("line at 3", 3);
    run("bind line to null", [&] { return cuTexRefSetAddress(&offset, line, 0, 400); });
    run("bind line to host memory", [&] {
        return cuTexRefSetAddress(&offset, line, CUdeviceptr(numbers.data()) & ~CUdeviceptr(511),
                                  400);
    });
    run("bind too much",
        [&] { return cuTexRefSetAddress(&offset, line, linear, size_t(1) << 40); });

    CUDA_ARRAY_DESCRIPTOR shape = {10, 5, CU_AD_FORMAT_FLOAT, 1};
    run("bind pitched", [&] { return cuTexRefSetAddress2D(flat, &shape, linear, 512); });
    state("flat", flat);
    run("flags 0", [&] { return cuTexRefSetFlags(flat, 0); });
    sample("pitched", 3.5f, 2.5f);
    run("bind pitch 100", [&] { return cuTexRefSetAddress2D(flat, &shape, linear, 100); });
    run("bind pitch 32", [&] { return cuTexRefSetAddress2D(flat, &shape, linear, 32); });
    run("bind pitched off the grid",
        [&] { return cuTexRefSetAddress2D(flat, &shape, linear + 4, 512); });
    run("bind pitched null", [&] { return cuTexRefSetAddress2D(flat, nullptr, linear, 512); });

    const Place picture = makeArray("picture", 8, 4, 0, CUDA_ARRAY3D_SURFACE_LDST);
    picture.fill(1);
    if (drawn) {
        CUarray bound = nullptr;
        run("surface unbound", [&] { return cuSurfRefGetArray(&bound, drawn); });
        run("bind surface to an array not for it",
            [&] { return cuSurfRefSetArray(drawn, image.array, 0); });
        run("bind surface, flags 1", [&] { return cuSurfRefSetArray(drawn, picture.array, 1); });
        run("bind surface", [&] { return cuSurfRefSetArray(drawn, picture.array, 0); });
        run("surface bound", [&] { return cuSurfRefGetArray(&bound, drawn); });
        std::printf("%s\n", bound == picture.array ? "its array" : "another");
        run("draw", [&] { return launch("draw", 3u, 2u, 0xAABBCCDDu); });
        std::printf("picture %08x\n", unsigned(picture.sum()));
    }
    run("create", [&] { return cuTexRefCreate(&own); });
    if (own) {
        state("own", own);
        run("destroy", [&] { return cuTexRefDestroy(own); });
    }
    run("destroy a module's", [&] { return cuTexRefDestroy(unused); });
    run("parameter", [&] { return cuParamSetTexRef(kernel("sample"), CU_PARAM_TR_DEFAULT, flat); });
    // A driver need not survive these.
    run("null", [&] { return cuTexRefSetFlags(nullptr, 0); });
    run("null flags", [&] { return cuTexRefGetFlags(nullptr, flat); });
    run("null surface", [&] { return cuSurfRefSetArray(nullptr, picture.array, 0); });
    return 0;
}
