// SPDX-License-Identifier: Apache-2.0
// A compiler for shaders that assembles programs from parts: a fixed library, generated functions
// and a kernel, each PTX text of its own, joined by the driver's linker with options and logs. A
// wrong part must be named by the log, and a fixed text must be usable in many links.
#include "host.h"

#include <cstring>
#include <string>
#include <vector>

namespace {

const char* const kHeader = ".version 7.0\n.target sm_60\n.address_size 64\n";

const char* const kLibrary = R"(
.visible .const .align 8 .f64 scale = 0d4000000000000000;
.visible .global .align 4 .u32 calls;
.visible .func (.param .b64 r) twice(.param .b64 a) {
    .reg .f64 %x, %s; .reg .u32 %old;
    ld.param.f64 %x, [a]; ld.const.f64 %s, [scale]; mul.f64 %x, %x, %s;
    atom.global.add.u32 %old, [calls], 1;
    st.param.f64 [r], %x; ret;
}
)";

// shade_k: ((x + k) * 2), applied again for larger k.
std::string generated(int k) {
    std::string text = ".extern .func (.param .b64 r) twice(.param .b64 a);\n"
                       ".visible .func (.param .b64 r) shade_" +
                       std::to_string(k) +
                       "(.param .b64 a) {\n.reg .f64 %x, %y; .reg .s32 %i;\nld.param.f64 %x, [a];\n"
                       "mov.s32 %i, " +
                       std::to_string(k) + "; cvt.rn.f64.s32 %y, %i; add.f64 %x, %x, %y;\n";
    for (int i = 0; i <= k % 3; ++i)
        text += "{ .param .b64 in, out; st.param.f64 [in], %x;\ncall.uni (out), twice, (in);\n"
                "ld.param.f64 %x, [out]; }\n";
    return text + "st.param.f64 [r], %x; ret;\n}\n";
}

std::string kernel(int functions) {
    std::string text, calls;
    for (int k = 0; k < functions; ++k) {
        const std::string name = "shade_" + std::to_string(k);
        text += ".extern .func (.param .b64 r) " + name + "(.param .b64 a);\n";
        calls += "{ .param .b64 in, out; st.param.f64 [in], %x;\ncall.uni (out), " + name +
                 ", (in);\nld.param.f64 %x, [out]; }\n";
    }
    return text +
           ".visible .entry run(.param .u64 values) {\n.reg .f64 %x; .reg .u64 %p; .reg .u32 %t;\n"
           "ld.param.u64 %p, [values]; mov.u32 %t, %tid.x;\nmad.wide.u32 %p, %t, 8, %p; "
           "ld.global.f64 %x, [%p];\n" +
           calls + "st.global.f64 [%p], %x;\nret;\n}\n";
}

double expected(double x, int functions) {
    for (int k = 0; k < functions; ++k) {
        x += k;
        for (int i = 0; i <= k % 3; ++i)
            x *= 2;
    }
    return x;
}

class Linker {
public:
    Linker() : info_(4096), errors_(4096) { CU(cuLinkCreate(7, options_, values_, &state_)); }
    ~Linker() { cuLinkDestroy(state_); }
    CUresult add(const std::string& body, const char* name) {
        std::string text = kHeader + body; // with its zero, as manuals ask for
        return cuLinkAddData(state_, CU_JIT_INPUT_PTX, text.data(), text.size() + 1, name, 0,
                             nullptr, nullptr);
    }
    CUresult complete(std::vector<char>* image) {
        void* data = nullptr;
        size_t size = 0;
        const CUresult result = cuLinkComplete(state_, &data, &size);
        if (result == CUDA_SUCCESS)
            image->assign(static_cast<char*>(data), static_cast<char*>(data) + size);
        return result;
    }
    std::string errors() const { return errors_.data(); }

private:
    std::vector<char> info_, errors_;
    // The driver writes to the values while the linker lives.
    CUjit_option options_[7] = {CU_JIT_INFO_LOG_BUFFER,  CU_JIT_INFO_LOG_BUFFER_SIZE_BYTES,
                                CU_JIT_ERROR_LOG_BUFFER, CU_JIT_ERROR_LOG_BUFFER_SIZE_BYTES,
                                CU_JIT_LOG_VERBOSE,      CU_JIT_OPTIMIZATION_LEVEL,
                                CU_JIT_WALL_TIME};
    void* values_[7] = {info_.data(),
                        reinterpret_cast<void*>(info_.size()),
                        errors_.data(),
                        reinterpret_cast<void*>(errors_.size()),
                        reinterpret_cast<void*>(1),
                        reinterpret_cast<void*>(3),
                        nullptr};
    CUlinkState state_ = nullptr;
};

int runImage(const std::vector<char>& image, int functions) {
    CUmodule module;
    CUfunction run;
    CUdeviceptr values, calls, scale;
    size_t bytes = 0;
    CU(cuModuleLoadData(&module, image.data()));
    CU(cuModuleGetFunction(&run, module, "run"));
    CU(cuModuleGetGlobal(&calls, &bytes, module, "calls"));
    CU(cuModuleGetGlobal(&scale, &bytes, module, "scale"));
    if (bytes != 8)
        return 1;
    std::vector<double> host(32);
    for (int i = 0; i < 32; ++i)
        host[i] = 0.5 * i;
    CU(cuMemAlloc(&values, host.size() * 8));
    CU(cuMemcpyHtoD(values, host.data(), host.size() * 8));
    void* arguments[] = {&values};
    CU(cuLaunchKernel(run, 1, 1, 1, 32, 1, 1, 0, nullptr, arguments, nullptr));
    CU(cuMemcpyDtoH(host.data(), values, host.size() * 8));
    unsigned counted = 0, right = 0;
    CU(cuMemcpyDtoH(&counted, calls, 4));
    for (int k = 0; k < functions; ++k)
        right += 32 * (k % 3 + 1);
    int wrong = counted != right;
    for (int i = 0; i < 32; ++i)
        wrong += host[i] != expected(0.5 * i, functions);
    CU(cuMemFree(values));
    CU(cuModuleUnload(module));
    return wrong;
}

} // namespace

int main() {
    CUdevice device;
    CUcontext context;
    CU(cuInit(0));
    CU(cuDeviceGet(&device, 0));
    CU(cuDevicePrimaryCtxRetain(&context, device));
    CU(cuCtxSetCurrent(context));
    int wrong = 0;
    std::vector<std::vector<char>> images;
    for (int functions = 1; functions <= 5; ++functions) {
        Linker linker;
        CU(linker.add(kernel(functions), "kernel.ptx"));
        for (int k = 0; k < functions; ++k)
            CU(linker.add(generated(k), ("shade_" + std::to_string(k)).c_str()));
        CU(linker.add(kLibrary, "library.ptx"));
        images.emplace_back();
        CU(linker.complete(&images.back()));
    } // images outlive their linkers
    for (size_t i = 0; i < images.size(); ++i)
        wrong += runImage(images[i], int(i) + 1);

    { // a function is missing
        Linker linker;
        std::vector<char> image;
        CU(linker.add(kernel(2), "kernel.ptx"));
        CU(linker.add(generated(0), "shade_0"));
        CU(linker.add(kLibrary, "library.ptx"));
        const CUresult result = linker.complete(&image);
        const bool isNamed = linker.errors().find("shade_1") != std::string::npos;
        wrong += result == CUDA_SUCCESS || !isNamed;
        std::printf("missing function: %s named\n", isNamed ? "is" : "is not");
    }
    { // a part is no PTX
        Linker linker;
        const CUresult result = linker.add(".visible .func f() { add.f64 %x; }", "broken.ptx");
        wrong += result == CUDA_SUCCESS || linker.errors().empty();
    }
    std::printf("%d wrong\n", wrong);
    return finish(wrong == 0);
}
