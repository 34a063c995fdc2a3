// SPDX-License-Identifier: Apache-2.0
// A library that keeps a context of its own: each of its functions pushes it, works and pops it;
// its user has another context current, or none, and destroys objects from another thread.
#include "host.h"

#include <cstring>
#include <thread>
#include <vector>

namespace {

const char kModule[] = R"(.version 6.0
.target sm_50
.address_size 64
.visible .entry twice(.param .u64 p, .param .u32 n)
{
  .reg .pred %p<2>; .reg .b32 %r<6>; .reg .b64 %rd<5>;
  ld.param.u64 %rd1, [p]; ld.param.u32 %r1, [n];
  mov.u32 %r2, %ctaid.x; mov.u32 %r3, %ntid.x; mov.u32 %r4, %tid.x;
  mad.lo.s32 %r5, %r2, %r3, %r4;
  setp.ge.u32 %p1, %r5, %r1;
  @%p1 ret;
  mul.wide.u32 %rd2, %r5, 4; add.s64 %rd3, %rd1, %rd2;
  ld.global.u32 %r2, [%rd3]; shl.b32 %r2, %r2, 1; st.global.u32 [%rd3], %r2;
  ret;
}
)";

class Worker {
public:
    Worker() {
        CU(cuCtxCreate_v2(&context_, CU_CTX_SCHED_AUTO, 0));
        CU(cuModuleLoadData(&module_, kModule));
        CU(cuModuleGetFunction(&function_, module_, "twice"));
        CU(cuStreamCreate(&stream_, CU_STREAM_NON_BLOCKING));
        CU(cuCtxPopCurrent(nullptr));
    }
    void run(std::vector<unsigned>& data) {
        CU(cuCtxPushCurrent(context_));
        CUdeviceptr memory;
        const size_t bytes = data.size() * sizeof(unsigned);
        CU(cuMemAlloc(&memory, bytes));
        CU(cuMemcpyHtoDAsync(memory, data.data(), bytes, stream_));
        unsigned count = unsigned(data.size());
        void* arguments[] = {&memory, &count};
        CU(cuLaunchKernel(function_, (count + 63) / 64, 1, 1, 64, 1, 1, 0, stream_, arguments,
                          nullptr));
        CU(cuMemcpyDtoHAsync(data.data(), memory, bytes, stream_));
        CUcontext popped;
        CU(cuCtxPopCurrent(&popped));
        if (popped != context_)
            std::exit(2);
        CU(cuStreamSynchronize(stream_)); // with whatever is current
        CU(cuMemFree(memory));
    }
    void close() {
        CU(cuStreamDestroy(stream_));
        CU(cuCtxDestroy(context_));
    }

private:
    CUcontext context_;
    CUmodule module_;
    CUfunction function_;
    CUstream stream_;
};

CUcontext current() {
    CUcontext context;
    CU(cuCtxGetCurrent(&context));
    return context;
}

} // namespace

int main() {
    CU(cuInit(0));
    bool right = current() == nullptr;
    Worker one, two;
    right = right && current() == nullptr;
    CUcontext mine;
    CU(cuDevicePrimaryCtxRetain(&mine, 0));
    std::vector<unsigned> data(1000);
    for (unsigned i = 0; i < data.size(); ++i)
        data[i] = i;
    one.run(data);
    CU(cuCtxSetCurrent(mine));
    two.run(data);
    right = right && current() == mine;
    std::thread([&] { one.run(data); }).join();
    for (int depth = 0; depth < 50; ++depth)
        CU(cuCtxPushCurrent(mine));
    two.run(data);
    for (int depth = 0; depth < 50; ++depth)
        CU(cuCtxPopCurrent(nullptr));
    for (unsigned i = 0; i < data.size(); ++i)
        right = right && data[i] == 16 * i;
    std::thread([&] { one.close(); }).join();
    two.close();
    right = right && current() == mine;
    CU(cuDevicePrimaryCtxRelease(0));
    return finish(right);
}
