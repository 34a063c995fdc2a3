// SPDX-License-Identifier: Apache-2.0
// The functions of NVRTC. Answers to wrong calls were observed with the toolkit's library (13.0).
#include <cuda.h>
#include <gtest/gtest.h>
#define NVRTC_GET_TYPE_NAME 1
#include <nvrtc.h>

#include <algorithm>
#include <csignal>
#include <dlfcn.h>
#include <string>
#include <thread>
#include <unistd.h>
#include <vector>

namespace {

using Words = std::vector<const char*>;

// A program that is destroyed at the end.
class Program {
public:
    explicit Program(const std::string& source, const char* name = nullptr, const Words& names = {},
                     const Words& texts = {}) {
        EXPECT_EQ(nvrtcCreateProgram(&handle_, source.c_str(), name, int(names.size()),
                                     texts.data(), names.data()),
                  NVRTC_SUCCESS);
    }
    ~Program() { EXPECT_EQ(nvrtcDestroyProgram(&handle_), NVRTC_SUCCESS); }
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    operator nvrtcProgram() const { return handle_; }
    nvrtcResult compile(const Words& options = {}) {
        return nvrtcCompileProgram(handle_, int(options.size()), options.data());
    }
    std::string log() { return text(nvrtcGetProgramLogSize, nvrtcGetProgramLog); }
    std::string ptx() { return text(nvrtcGetPTXSize, nvrtcGetPTX); }
    std::string image() { return text(nvrtcGetCUBINSize, nvrtcGetCUBIN); }

private:
    std::string text(nvrtcResult (*size)(nvrtcProgram, size_t*),
                     nvrtcResult (*get)(nvrtcProgram, char*)) {
        size_t bytes = 0;
        EXPECT_EQ(size(handle_, &bytes), NVRTC_SUCCESS);
        std::string result(bytes + 1, '#');
        EXPECT_EQ(get(handle_, result.data()), NVRTC_SUCCESS);
        EXPECT_EQ(result[bytes], '#'); // not more than it said
        result.resize(bytes ? bytes - 1 : 0);
        return result;
    }
    nvrtcProgram handle_ = nullptr;
};

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

constexpr char kKernel[] = "extern \"C\" __global__ void put(int* to) { *to = VALUE; }\n";

// The value that the kernel `put` of an image writes.
int valueOf(const std::string& image, const char* kernel = "put") {
    cuInit(0);
    CUcontext context;
    EXPECT_EQ(cuDevicePrimaryCtxRetain(&context, 0), CUDA_SUCCESS);
    EXPECT_EQ(cuCtxSetCurrent(context), CUDA_SUCCESS);
    CUmodule module = nullptr;
    CUfunction function = nullptr;
    EXPECT_EQ(cuModuleLoadData(&module, image.c_str()), CUDA_SUCCESS);
    EXPECT_EQ(cuModuleGetFunction(&function, module, kernel), CUDA_SUCCESS);
    CUdeviceptr memory = 0;
    EXPECT_EQ(cuMemAlloc(&memory, 4), CUDA_SUCCESS);
    void* arguments[] = {&memory};
    EXPECT_EQ(cuLaunchKernel(function, 1, 1, 1, 1, 1, 1, 0, nullptr, arguments, nullptr),
              CUDA_SUCCESS);
    int value = -1;
    EXPECT_EQ(cuMemcpyDtoH(&value, memory, 4), CUDA_SUCCESS);
    cuMemFree(memory);
    cuModuleUnload(module);
    return value;
}

TEST(Nvrtc, VersionArchitecturesAndErrorStrings) {
    int major = 0, minor = -1, count = 0;
    EXPECT_EQ(nvrtcVersion(&major, &minor), NVRTC_SUCCESS);
    EXPECT_EQ(major, 13);
    EXPECT_EQ(minor, 0);
    EXPECT_EQ(nvrtcVersion(nullptr, &minor), NVRTC_ERROR_INVALID_INPUT);
    ASSERT_EQ(nvrtcGetNumSupportedArchs(&count), NVRTC_SUCCESS);
    std::vector<int> list(size_t(count) + 1, 7);
    EXPECT_EQ(nvrtcGetSupportedArchs(list.data()), NVRTC_SUCCESS);
    EXPECT_EQ(list.back(), 7);
    EXPECT_TRUE(std::is_sorted(list.begin(), list.end() - 1));
    EXPECT_TRUE(std::count(list.begin(), list.end(), 75));
    EXPECT_EQ(nvrtcGetNumSupportedArchs(nullptr), NVRTC_ERROR_INVALID_INPUT);
    EXPECT_STREQ(nvrtcGetErrorString(NVRTC_ERROR_COMPILATION), "NVRTC_ERROR_COMPILATION");
    EXPECT_STREQ(nvrtcGetErrorString(nvrtcResult(17)), "NVRTC_ERROR_TIME_TRACE_FILE_WRITE_FAILED");
    EXPECT_STREQ(nvrtcGetErrorString(nvrtcResult(18)), "NVRTC_ERROR unknown");
    EXPECT_STREQ(nvrtcGetErrorString(nvrtcResult(-1)), "NVRTC_ERROR unknown");
}

// The library for programs of CUDA 12 beside that for 13.
TEST(Nvrtc, Library12) {
    void* library = dlopen(NVRTC12, RTLD_NOW | RTLD_LOCAL);
    ASSERT_TRUE(library) << dlerror();
    int major = 0, minor = 0;
    const auto version = reinterpret_cast<decltype(&nvrtcVersion)>(
        dlvsym(library, "nvrtcVersion", "libnvrtc.so.12"));
    ASSERT_TRUE(version);
    EXPECT_EQ(version(&major, &minor), NVRTC_SUCCESS);
    EXPECT_EQ(major, 12);
    EXPECT_TRUE(dlsym(library, "nvrtcGetNVVMSize")); // CUDA 13 has it no more
    EXPECT_FALSE(dlsym(RTLD_DEFAULT, "nvrtcGetNVVMSize"));
    dlclose(library);
}

TEST(Nvrtc, WrongCalls) {
    nvrtcProgram program = nullptr;
    const char* none = nullptr;
    EXPECT_EQ(nvrtcCreateProgram(&program, nullptr, nullptr, 0, nullptr, nullptr),
              NVRTC_ERROR_INVALID_INPUT);
    EXPECT_EQ(nvrtcCreateProgram(nullptr, "", nullptr, 0, nullptr, nullptr),
              NVRTC_ERROR_INVALID_PROGRAM);
    EXPECT_EQ(nvrtcCreateProgram(&program, "", nullptr, -1, nullptr, nullptr),
              NVRTC_ERROR_INVALID_INPUT);
    EXPECT_EQ(nvrtcCreateProgram(&program, "", nullptr, 1, nullptr, nullptr),
              NVRTC_ERROR_INVALID_INPUT);
    EXPECT_EQ(nvrtcCreateProgram(&program, "", nullptr, 1, &none, &none),
              NVRTC_ERROR_INVALID_INPUT);
    EXPECT_EQ(program, nullptr);
    size_t size = 0;
    char text[8];
    const char* name = nullptr;
    for (const nvrtcProgram bad : {nvrtcProgram(nullptr), reinterpret_cast<nvrtcProgram>(0x1234)}) {
        EXPECT_EQ(nvrtcCompileProgram(bad, 0, nullptr), NVRTC_ERROR_INVALID_PROGRAM);
        EXPECT_EQ(nvrtcGetPTXSize(bad, &size), NVRTC_ERROR_INVALID_PROGRAM);
        EXPECT_EQ(nvrtcGetPTX(bad, text), NVRTC_ERROR_INVALID_PROGRAM);
        EXPECT_EQ(nvrtcGetProgramLogSize(bad, &size), NVRTC_ERROR_INVALID_PROGRAM);
        EXPECT_EQ(nvrtcGetCUBINSize(bad, &size), NVRTC_ERROR_INVALID_PROGRAM);
        EXPECT_EQ(nvrtcGetLTOIR(bad, text), NVRTC_ERROR_INVALID_PROGRAM);
        EXPECT_EQ(nvrtcGetOptiXIRSize(bad, &size), NVRTC_ERROR_INVALID_PROGRAM);
        EXPECT_EQ(nvrtcAddNameExpression(bad, "x"), NVRTC_ERROR_INVALID_PROGRAM);
        EXPECT_EQ(nvrtcGetLoweredName(bad, "x", &name), NVRTC_ERROR_INVALID_PROGRAM);
        nvrtcProgram copy = bad;
        EXPECT_EQ(nvrtcDestroyProgram(&copy), NVRTC_ERROR_INVALID_PROGRAM);
    }
    EXPECT_EQ(nvrtcDestroyProgram(nullptr), NVRTC_ERROR_INVALID_PROGRAM);

    Program good("");
    EXPECT_EQ(nvrtcCompileProgram(good, -1, nullptr), NVRTC_ERROR_INVALID_INPUT);
    EXPECT_EQ(nvrtcCompileProgram(good, 2, nullptr), NVRTC_ERROR_INVALID_OPTION);
    EXPECT_EQ(nvrtcCompileProgram(good, 1, &none), NVRTC_ERROR_INVALID_OPTION);
    EXPECT_EQ(nvrtcGetPTXSize(good, nullptr), NVRTC_ERROR_INVALID_INPUT);
    EXPECT_EQ(nvrtcGetPTX(good, nullptr), NVRTC_ERROR_INVALID_INPUT);
    EXPECT_EQ(nvrtcAddNameExpression(good, nullptr), NVRTC_ERROR_INVALID_INPUT);
    EXPECT_EQ(nvrtcGetLoweredName(good, nullptr, &name), NVRTC_ERROR_INVALID_INPUT);
    EXPECT_EQ(nvrtcGetLoweredName(good, "x", nullptr), NVRTC_ERROR_INVALID_INPUT);
    EXPECT_EQ(nvrtcGetLoweredName(good, "x", &name),
              NVRTC_ERROR_NO_LOWERED_NAMES_BEFORE_COMPILATION);
    EXPECT_EQ(good.ptx(), "");
    EXPECT_EQ(good.log(), "");
    EXPECT_EQ(nvrtcGetCUBINSize(good, &size), NVRTC_SUCCESS);
    EXPECT_EQ(size, 0u);
}

TEST(Nvrtc, CompilesWhatTheDriverLoads) {
    Program program(kKernel);
    ASSERT_EQ(program.compile({"-arch=compute_75", "-DVALUE=41"}), NVRTC_SUCCESS) << program.log();
    EXPECT_EQ(program.log(), "");
    EXPECT_TRUE(has(program.ptx(), ".target sm_75"));
    EXPECT_EQ(program.image(), ""); // a virtual architecture has no image
    EXPECT_EQ(valueOf(program.ptx()), 41);
    // Again, for a real one.
    ASSERT_EQ(program.compile({"--gpu-architecture=sm_75", "--define-macro=VALUE=42"}),
              NVRTC_SUCCESS);
    EXPECT_EQ(valueOf(program.image()), 42);
    for (const auto size : {nvrtcGetLTOIRSize, nvrtcGetOptiXIRSize}) {
        size_t bytes = 7;
        EXPECT_EQ(size(program, &bytes), NVRTC_SUCCESS);
        EXPECT_EQ(bytes, 0u);
    }
}

// What a kernel `put` with this body writes.
int valueIn(const std::string& before, const std::string& body, const Words& options = {}) {
    Program program(before + "\nextern \"C\" __global__ void put(int* to) { " + body + " }\n");
    EXPECT_EQ(program.compile(options), NVRTC_SUCCESS) << before << program.log();
    return valueOf(program.ptx());
}

TEST(Nvrtc, PredefinedMacros) {
    EXPECT_EQ(valueIn("", "*to = CUDA_VERSION;"), 13000);
    EXPECT_EQ(valueIn("#include <cuda.h>", "*to = CUDA_VERSION;"), 13000);
    EXPECT_EQ(valueIn("", "*to = __CUDACC_VER_MAJOR__ * 100 + __CUDACC_VER_MINOR__;"), 1300);
    EXPECT_EQ(valueIn("", "*to = __CUDA_API_VER_MAJOR__ + __NVCC_DIAG_PRAGMA_SUPPORT__;"), 14);
    EXPECT_EQ(valueIn("", "*to = __CUDA_ARCH_LIST__;", {"-arch=compute_80"}), 800);
    EXPECT_EQ(valueIn("", "assert(to); *to = 4;"), 4);
    constexpr char kOnDemand[] = "int n = 0;\n#ifdef __CUDACC_RDC__\nn += 1;\n#endif\n"
                                 "#ifdef __CUDACC_RTC_INT128__\nn += 2;\n#endif\n*to = n;";
    EXPECT_EQ(valueIn("", kOnDemand), 0);
    EXPECT_EQ(valueIn("", kOnDemand, {"-rdc=true", "--device-int128"}), 3);
}

TEST(Nvrtc, ConditionsOfTargets) {
    EXPECT_EQ(valueIn("", "NV_IF_TARGET(NV_IS_DEVICE, (*to = 3;), (*to = 4;))"), 3);
    EXPECT_EQ(valueIn("", "*to = 1; NV_IF_TARGET(NV_IS_HOST, (*to = 3;))"), 1);
    EXPECT_EQ(valueIn("", "NV_IF_ELSE_TARGET(NV_PROVIDES_SM_80, (*to = 8;), (*to = 7;))"), 7);
    EXPECT_EQ(valueIn("", "NV_IF_ELSE_TARGET(NV_IS_EXACTLY_SM_75, *to = 8;, *to = 7;)"), 8);
    constexpr char kDispatch[] =
        "NV_DISPATCH_TARGET(NV_PROVIDES_SM_90, (*to = 9;), NV_PROVIDES_SM_80, (*to = 8;),"
        " NV_IS_DEVICE, (*to = max(6, 7);))";
    EXPECT_EQ(valueIn("", kDispatch), 7);
    EXPECT_EQ(valueIn("", kDispatch, {"-arch=compute_80"}), 8);
    EXPECT_EQ(valueIn("", kDispatch, {"-arch=compute_90"}), 9);
}

TEST(Nvrtc, ComplexNumbers) {
    EXPECT_EQ(valueIn("#include <cuComplex.h>",
                      "cuFloatComplex a = make_cuFloatComplex(5, 2); *to = (int)(cuCrealf(cuCmulf("
                      "a, a)) + cuCimagf(cuCsubf(a, cuConjf(a))));"),
              25);
    EXPECT_EQ(valueIn("#include <cuComplex.h>",
                      "cuDoubleComplex a = make_cuDoubleComplex(3, 4), b = cuCdiv(cuCmul(a, a), a);"
                      "*to = (int)(cuCabs(a) + 0.5) * 100 + (int)(b.x + 0.5) * 10 +"
                      "      (int)(cuCfma(a, a, b).y + 0.5);"),
              558);
}

// Headers of a toolkit, whose folder follows that of Sunstone's headers.
TEST(Nvrtc, LibrariesOfAToolkit) {
    const std::string folder = "/usr/local/cuda/include";
    if (access((folder + "/cccl/cuda/std/array").c_str(), R_OK) != 0)
        GTEST_SKIP() << "no toolkit";
    const std::string include = "-I" + folder, libraries = "-I" + folder + "/cccl";
    const Words options = {include.c_str(), libraries.c_str()};
    EXPECT_EQ(valueIn("#include <cuda/std/array>",
                      "cuda::std::array<int, 3> a{1, 2, 7}; *to = a[2];", options),
              7);
    EXPECT_EQ(valueIn("#include <cuda/atomic>",
                      "*to = 5; cuda::atomic_ref<int, cuda::thread_scope_device> r(*to);"
                      "r.fetch_add(1);",
                      options),
              6);
    EXPECT_EQ(valueIn("#include <cub/block/block_scan.cuh>",
                      "typedef cub::BlockScan<int, 1> Scan; __shared__ Scan::TempStorage s;"
                      "int sum; Scan(s).InclusiveSum(9, sum); *to = sum;",
                      options),
              9);
    EXPECT_EQ(valueIn("#include <cuda_fp16.h>\n#include <cuda_fp8.h>",
                      "*to = __nv_fp8_e4m3(1.0f).__x;", options),
              0x38);
}

TEST(Nvrtc, LogsHaveNameAndLine) {
    Program program("__device__ int a;\n\n__global__ void k() { missing(); }\n",
                    "folder/my \"kernels\".cu");
    EXPECT_EQ(program.compile(), NVRTC_ERROR_COMPILATION);
    EXPECT_TRUE(
        has(program.log(), "folder/my \"kernels\".cu(3): error: use of undeclared identifier"))
        << program.log();
    EXPECT_TRUE(has(program.log(), "1 error in the compilation of \"folder/my "));
    EXPECT_FALSE(has(program.log(), "sunstone-nvrtc-")); // no temporary files
    EXPECT_EQ(program.ptx(), "");
    // Warnings are in the log of a success, unless they are disabled.
    Program warned("__global__ void k(int* p) { p[0]; }");
    ASSERT_EQ(warned.compile(), NVRTC_SUCCESS);
    EXPECT_TRUE(has(warned.log(), "default_program(1): warning: ")) << warned.log();
    ASSERT_EQ(warned.compile({"-w"}), NVRTC_SUCCESS);
    EXPECT_EQ(warned.log(), "");
}

// Programs that add headers one by one read the name of the next one.
TEST(Nvrtc, LogsNameMissingHeaders) {
    Program program("#include \"a/b.h\"\n", "mine.cu", {"a/b.h"}, {"\n#include <next.cuh>\n"});
    EXPECT_EQ(program.compile(), NVRTC_ERROR_COMPILATION);
    EXPECT_TRUE(has(program.log(), "\na/b.h(2): catastrophic error: cannot open source file "
                                   "\"next.cuh\"\n"))
        << program.log();
}

TEST(Nvrtc, HeadersInMemory) {
    Program program(
        "#include \"value.h\"\n#include <deep/in/folders.h>\n#include \"../../above.h\"\n"
        "#include \"/absolute/place.h\"\n"
        "extern \"C\" __global__ void put(int* to) { *to = A + B + C + D; }",
        nullptr, {"value.h", "deep/in/folders.h", "../../above.h", "/absolute/place.h"},
        {"#define A 1", "#include \"value.h\"\nconst int B = A * 10;", "constexpr int C = 100;",
         "#define D 1000\n"});
    ASSERT_EQ(program.compile(), NVRTC_SUCCESS) << program.log();
    EXPECT_EQ(valueOf(program.ptx()), 1111);
    // A message about an error in a header has the header's name.
    Program bad("#include <first.h>\n", nullptr, {"first.h"}, {"\n\nint f(;\n"});
    EXPECT_EQ(bad.compile(), NVRTC_ERROR_COMPILATION);
    EXPECT_TRUE(has(bad.log(), "first.h(3): error:")) << bad.log();
    Program missing("#include <nowhere.h>\n");
    EXPECT_EQ(missing.compile(), NVRTC_ERROR_COMPILATION);
    EXPECT_TRUE(has(missing.log(), "default_program(1): ")) << missing.log();
    EXPECT_TRUE(has(missing.log(), "nowhere.h"));
}

TEST(Nvrtc, NameExpressions) {
    Program program("namespace n { struct V { int x; };\n"
                    "template <class T, int N> __global__ void fill(T* to) { *to = T{N}; }\n"
                    "__constant__ int limit = 5; __device__ float table[4];\n"
                    "static __global__ void own(int* to) { *to = limit; } }\n"
                    "extern \"C\" __global__ void put(int* to) { *to = 3; }\n");
    const std::pair<const char*, const char*> names[] = {
        {"n::fill<int, 9>", "_ZN1n4fillIiLi9EEEvPT_"},
        {"&n::fill<n::V, 2>", "_ZN1n4fillINS_1VELi2EEEvPT_"},
        {"&n::limit", "_ZN1n5limitE"},
        {" & n::table", "_ZN1n5tableE"},
        {"put", "put"},
        {"n::own", "_ZN1nL3ownEPi"},
    };
    for (const auto& [expression, lowered] : names)
        EXPECT_EQ(nvrtcAddNameExpression(program, expression), NVRTC_SUCCESS);
    ASSERT_EQ(program.compile(), NVRTC_SUCCESS) << program.log();
    const char* name = nullptr;
    for (const auto& [expression, lowered] : names) {
        ASSERT_EQ(nvrtcGetLoweredName(program, expression, &name), NVRTC_SUCCESS) << expression;
        EXPECT_STREQ(name, lowered);
        EXPECT_TRUE(has(program.ptx(), name));
    }
    EXPECT_FALSE(has(program.ptx(), "__sunstone_name"));
    EXPECT_EQ(valueOf(program.ptx(), "_ZN1n4fillIiLi9EEEvPT_"), 9);
    EXPECT_EQ(nvrtcGetLoweredName(program, "n::fill<int,9>", &name),
              NVRTC_ERROR_NAME_EXPRESSION_NOT_VALID);
    EXPECT_EQ(nvrtcAddNameExpression(program, "put"),
              NVRTC_ERROR_NO_NAME_EXPRESSIONS_AFTER_COMPILATION);

    Program bad(kKernel);
    EXPECT_EQ(nvrtcAddNameExpression(bad, "put"), NVRTC_SUCCESS);
    EXPECT_EQ(nvrtcAddNameExpression(bad, "absent<int>"), NVRTC_SUCCESS);
    EXPECT_EQ(bad.compile({"-DVALUE=1"}), NVRTC_ERROR_COMPILATION);
    EXPECT_TRUE(has(bad.log(), "name expressions(2): error: use of undeclared identifier 'absent'"))
        << bad.log();
}

struct Pair {};
TEST(Nvrtc, TypeNames) {
    std::string name;
    EXPECT_EQ(nvrtcGetTypeName<const int&>(&name), NVRTC_SUCCESS);
    EXPECT_EQ(name, "int const&");
    EXPECT_EQ(nvrtcGetTypeName(typeid(unsigned long), &name), NVRTC_SUCCESS);
    EXPECT_EQ(name, "unsigned long");
    EXPECT_EQ(nvrtcGetTypeName<Pair>(&name), NVRTC_SUCCESS);
    EXPECT_TRUE(has(name, "Pair"));
}

TEST(Nvrtc, OptionsChangeTheCode) {
    Program program("extern \"C\" __global__ void k(float* p, float a, float b) {\n"
                    "    p[0] = a * b + p[0]; p[1] = a / b; p[2] = sqrtf(a); p[3] = sinf(b);\n}\n");
    ASSERT_EQ(program.compile({"-arch", "compute_80"}), NVRTC_SUCCESS) << program.log();
    EXPECT_TRUE(has(program.ptx(), ".target sm_80"));
    EXPECT_TRUE(has(program.ptx(), "fma.rn.f32"));
    EXPECT_TRUE(has(program.ptx(), "div.rn.f32"));
    EXPECT_TRUE(has(program.ptx(), "sqrt.rn.f32"));
    ASSERT_EQ(program.compile({"--use_fast_math"}), NVRTC_SUCCESS);
    EXPECT_TRUE(has(program.ptx(), "div.approx.ftz.f32") || has(program.ptx(), "div.full.ftz.f32"));
    EXPECT_TRUE(has(program.ptx(), "sin.approx"));
    ASSERT_EQ(program.compile({"--fmad=false", "-lineinfo"}), NVRTC_SUCCESS);
    EXPECT_TRUE(has(program.ptx(), "mul.rn.f32"));
    EXPECT_TRUE(has(program.ptx(), ".loc"));
    EXPECT_TRUE(has(program.ptx(), "default_program"));
    ASSERT_EQ(program.compile({"-G"}), NVRTC_SUCCESS) << program.log();
    EXPECT_TRUE(has(program.ptx(), ".debug_info") || has(program.ptx(), ".section"));
}

// nvcc's dialect: what clang refuses or translates otherwise by default.
TEST(Nvrtc, RegistersWithOnePercent) {
    Program program("#define READ(x, name) asm(\"mov.u32 %0, %\" #name \";\" : \"=r\"(x))\n"
                    "extern \"C\" __global__ void put(int* to) {\n"
                    "    int lane, size;\n"
                    "    asm volatile(\"mov.u32 %0, %laneid;\" : \"=r\"(lane));\n"
                    "    READ(size, ntid.x);\n"
                    "    *to = 40 + lane + 2 * size;\n"
                    "}\n");
    ASSERT_EQ(program.compile(), NVRTC_SUCCESS) << program.log();
    EXPECT_EQ(valueOf(program.ptx()), 42);
    Program faulty("__device__ void f() { int x; asm(\"mov.u32 %0, %laneid;\" : \"=r\"(x)); }\n"
                   "fault\n",
                   "mine.cu");
    EXPECT_EQ(faulty.compile(), NVRTC_ERROR_COMPILATION);
    EXPECT_TRUE(has(faulty.log(), "mine.cu(2): error")) << faulty.log();
    EXPECT_FALSE(has(faulty.log(), "invalid % escape")) << faulty.log();
}

TEST(Nvrtc, DeclaredVariablesAreDefinedUnlessRelocatable) {
    const std::string source =
        "extern \"C\" __constant__ int five; extern __device__ int two[3];\n"
        "extern \"C\" __global__ void put(int* to) { *to = five + two[1]; }\n";
    Program whole(source);
    ASSERT_EQ(whole.compile(), NVRTC_SUCCESS) << whole.log();
    EXPECT_EQ(valueOf(whole.ptx()), 0);
    Program part(source);
    ASSERT_EQ(part.compile({"-rdc=true"}), NVRTC_SUCCESS) << part.log();
    EXPECT_TRUE(has(part.ptx(), ".extern .const")) << part.ptx();
}

TEST(Nvrtc, MemoryIsReadAsOtherTypes) {
    Program program("__device__ __noinline__ int both(float* f, unsigned short* half) {\n"
                    "    f[0] = 1.5f;\n"
                    "    half[1] = 0x4000;\n"
                    "    return f[0] == 2.0f;\n"
                    "}\n"
                    "extern \"C\" __global__ void put(int* to) {\n"
                    "    float f[2];\n"
                    "    *to = both(f, (unsigned short*)f);\n"
                    "}\n");
    ASSERT_EQ(program.compile(), NVRTC_SUCCESS) << program.log();
    EXPECT_EQ(valueOf(program.ptx()), 1);
}

TEST(Nvrtc, VariablesThatOnlyOneLaneSets) {
    Program program("template <class T> __device__ __noinline__ T first(T value) {\n"
                    "    return __shfl_sync(__activemask(), value, 0);\n"
                    "}\n"
                    "extern \"C\" __global__ void put(int* to) {\n"
                    "    int base;\n"
                    "    if (threadIdx.x == 0)\n"
                    "        base = atomicAdd(to, 7);\n"
                    "    base = first(base);\n"
                    "    atomicAdd(to, base * 0 + 1);\n"
                    "}\n");
    ASSERT_EQ(program.compile(), NVRTC_SUCCESS) << program.log();
    EXPECT_TRUE(has(program.ptx(), "bra")) << program.ptx(); // the first lane alone adds
}

TEST(Nvrtc, ReturnsThatAreMissing) {
    Program program("__device__ int count(int* to) { *to += 20; }\n"
                    "__device__ bool isEven(int x) { if (x % 2 == 0) return true; }\n"
                    "extern \"C\" __global__ void put(int* to) {\n"
                    "    *to = 1;\n"
                    "    count(to);\n"
                    "    isEven(*to);\n"
                    "    count(to);\n"
                    "}\n");
    ASSERT_EQ(program.compile(), NVRTC_SUCCESS) << program.log();
    EXPECT_EQ(valueOf(program.ptx()), 41);
}

// A channel that does not fit leaves the others alone.
TEST(Nvrtc, ColoursBeyondBytes) {
    Program program(
        "__device__ __noinline__ uchar4 pack(float4 c) {\n"
        "    return make_uchar4(c.x, c.y, c.z, c.w);\n"
        "}\n"
        "extern \"C\" __global__ void put(int* to) {\n"
        "    const uchar4 c = pack(make_float4(300.5f, 10.5f, -3.5f, 0.5f * blockDim.x));\n"
        "    *to = c.y | c.z << 8 | c.w << 16;\n"
        "}\n");
    ASSERT_EQ(program.compile(), NVRTC_SUCCESS) << program.log();
    EXPECT_EQ(valueOf(program.ptx()), 10);
}

TEST(Nvrtc, WordsOfTheDialect) {
    Program program("#include <cuda_pipeline.h>\n#include <sm_20_atomic_functions.h>\n"
                    "__managed__ int counter;\n"
                    "__device__ __inline_hint__ float sum(float3 v) { return v.x + v.y + v.z; }\n"
                    "extern \"C\" __global__ void put(int* to) {\n"
                    "    __shared__ int copy[4];\n"
                    "    *to = 7;\n"
                    "    __pipeline_memcpy_async(copy, to, 4);\n"
                    "    __pipeline_memcpy_async(copy + 1, to, 4, 3);\n"
                    "    __pipeline_commit();\n"
                    "    __pipeline_wait_prior(0);\n"
                    "    float3 narrow = {copy[0], copy[1], blockDim.x};\n"
                    "    *to = ++counter + (int)sum(narrow);\n"
                    "}\n");
    ASSERT_EQ(program.compile(), NVRTC_SUCCESS) << program.log();
    EXPECT_EQ(valueOf(program.ptx()), 16);
}

TEST(Nvrtc, FunctionsAreForTheDeviceIfAsked) {
    Program program("int twice(int x) { return 2 * x; }\n"
                    "extern \"C\" __global__ void put(int* to) { *to = twice(8); }\n");
    EXPECT_EQ(program.compile(), NVRTC_ERROR_COMPILATION);
    ASSERT_EQ(program.compile({"-default-device"}), NVRTC_SUCCESS) << program.log();
    EXPECT_EQ(valueOf(program.ptx()), 16);
}

TEST(Nvrtc, BadOptionsAreNamed) {
    Program program(kKernel);
    const std::pair<Words, const char*> cases[] = {
        {{"--nonsense"}, "nvrtc: error: unrecognized option --nonsense found"},
        {{"-O3"}, "unrecognized option -O3"},
        {{""}, "unrecognized option"},
        {{"file.cu"}, "unrecognized option file.cu"},
        {{"-arch=sm_9999"}, "invalid value \"sm_9999\" for --gpu-architecture (-arch)"},
        {{"-arch"}, "invalid value \"\" for --gpu-architecture"},
        {{"-ftz=maybe"}, "invalid value \"maybe\" for --ftz (-ftz): it is true or false"},
        {{"-std=c++98"}, "for --std (-std)"},
        {{"-maxrregcount=many"}, "for --maxrregcount"},
        {{"--optix-ir"}, "OptiX IR and LTO IR are not supported"},
    };
    for (const auto& [words, text] : cases) {
        EXPECT_EQ(program.compile(words), NVRTC_ERROR_INVALID_OPTION) << text;
        EXPECT_TRUE(has(program.log(), text)) << program.log();
    }
    // A GPU that clang does not know gets older PTX, and the log says so.
    ASSERT_EQ(program.compile({"-arch=sm_120", "-DVALUE=1"}), NVRTC_SUCCESS) << program.log();
    EXPECT_TRUE(has(program.log(), "clang does not know sm_120; the PTX is for compute_90"));
}

TEST(Nvrtc, DevicesAsHeaders) {
    // The compilation ends: neither device is read for ever.
    for (const char* device : {"/dev/zero", "/dev/stdin"}) {
        Program program("#include \"" + std::string(device) + "\"\n__global__ void k() {}\n");
        const nvrtcResult result = program.compile();
        EXPECT_TRUE(result == NVRTC_SUCCESS || result == NVRTC_ERROR_COMPILATION) << result;
    }
}

TEST(Nvrtc, SourcesThatClangRefuses) {
    std::string deep = "__global__ void k() { int x = ";
    deep += std::string(100000, '(') + "1" + std::string(100000, ')') + "; }";
    for (const std::string& source :
         {deep,
          std::string("template <int N> struct S { enum { v = S<N + 1>::v }; }; int x = S<0>::v;"),
          std::string("#include __FILE__\n"), std::string("\xff\xfe\x00\x01", 4),
          std::string("constexpr int f() { for (;;); return 1; } constexpr int x = f();"),
          std::string("#line 5 \"\n/* no end"), std::string("#error \x1b[31m%s%n\n")}) {
        Program program(source);
        EXPECT_EQ(program.compile(), NVRTC_ERROR_COMPILATION) << source.substr(0, 80);
        EXPECT_NE(program.log(), "");
    }
}

TEST(Nvrtc, ApplicationsThatReapAllChildren) {
    const auto previous = std::signal(SIGCHLD, SIG_IGN);
    Program good(kKernel), bad("x");
    EXPECT_EQ(good.compile({"-DVALUE=2"}), NVRTC_SUCCESS);
    EXPECT_EQ(bad.compile(), NVRTC_ERROR_COMPILATION);
    std::signal(SIGCHLD, previous);
    EXPECT_EQ(valueOf(good.ptx()), 2);
}

TEST(Nvrtc, ThreadsCompileAtOnce) {
    std::vector<std::string> results(4);
    std::vector<std::thread> threads;
    for (size_t i = 0; i < results.size(); ++i)
        threads.emplace_back([&results, i] {
            Program program(kKernel);
            const std::string value = "-DVALUE=" + std::to_string(i);
            if (program.compile({value.c_str()}) == NVRTC_SUCCESS)
                results[i] = program.ptx();
        });
    for (std::thread& thread : threads)
        thread.join();
    for (size_t i = 0; i < results.size(); ++i)
        EXPECT_EQ(valueOf(results[i]), int(i));
}

} // namespace
