// SPDX-License-Identifier: Apache-2.0
// Module texts as files and embedders leave them: padded with zeros, with line ends of Windows,
// tabs and comments; loaded twice; the buffer reused at once; the first copy unloaded while the
// second runs.
#include "host.h"

#include <cstring>
#include <string>
#include <vector>

namespace {

const char kModule[] = "/* made by a tool */\r\n"
                       ".version 6.5\r\n"
                       ".target\tsm_60, texmode_unified // comment\r\n"
                       ".address_size 64\r\n"
                       "\r\n"
                       ".global .align 4 .u32 counter = 5;\r\n"
                       ".visible .entry bump(\r\n"
                       "\t.param .u64 bump_param_0\r\n"
                       ")\r\n"
                       "{\r\n"
                       "\t.reg .b32 \t%r<3>;\r\n"
                       "\t.reg .b64 \t%rd<3>;\r\n"
                       "\tld.param.u64 \t%rd1, [bump_param_0];\r\n"
                       "\tcvta.to.global.u64 \t%rd2, %rd1;\r\n"
                       "\tatom.global.add.u32 \t%r1, [counter], 1;\r\n"
                       "\tadd.s32 \t%r2, %r1, 100;\r\n"
                       "\tst.global.u32 \t[%rd2], %r2;\r\n"
                       "\tret;\r\n"
                       "}\r\n\r\n";

unsigned run(CUmodule module, CUdeviceptr out) {
    CUfunction function;
    CU(cuModuleGetFunction(&function, module, "bump"));
    void* arguments[] = {&out};
    CU(cuLaunchKernel(function, 1, 1, 1, 1, 1, 1, 0, nullptr, arguments, nullptr));
    unsigned value;
    CU(cuMemcpyDtoH(&value, out, sizeof(value)));
    return value;
}

} // namespace

int main() {
    CU(cuInit(0));
    CUcontext context;
    CU(cuDevicePrimaryCtxRetain(&context, 0));
    CU(cuCtxPushCurrent(context));
    CUdeviceptr out;
    CU(cuMemAlloc(&out, sizeof(unsigned)));
    std::vector<char> buffer(sizeof(kModule) + 4096, '\0');
    std::memcpy(buffer.data(), kModule, sizeof(kModule) - 1);
    CUmodule first, second, third;
    CU(cuModuleLoadData(&first, buffer.data()));
    CU(cuModuleLoadDataEx(&second, buffer.data(), 0, nullptr, nullptr));
    std::memset(buffer.data(), 0xCC, buffer.size());
    bool right = run(first, out) == 105 && run(first, out) == 106 && run(second, out) == 105;
    CU(cuModuleUnload(first));
    right = right && run(second, out) == 106;
    // By the linker: with and without the zeros in the size.
    for (const size_t size : {sizeof(kModule) - 1, sizeof(kModule), sizeof(kModule) + 100}) {
        std::vector<char> text(sizeof(kModule) + 100, '\0');
        std::memcpy(text.data(), kModule, sizeof(kModule) - 1);
        CUlinkState link;
        void* image;
        size_t bytes;
        CU(cuLinkCreate(0, nullptr, nullptr, &link));
        CU(cuLinkAddData(link, CU_JIT_INPUT_PTX, text.data(), size, "text", 0, nullptr, nullptr));
        CU(cuLinkComplete(link, &image, &bytes));
        CU(cuModuleLoadData(&third, image));
        CU(cuLinkDestroy(link));
        right = right && run(third, out) == 105;
        CU(cuModuleUnload(third));
    }
    CU(cuModuleUnload(second));
    CU(cuMemFree(out));
    CU(cuCtxPopCurrent(nullptr));
    CU(cuDevicePrimaryCtxRelease(0));
    return finish(right);
}
