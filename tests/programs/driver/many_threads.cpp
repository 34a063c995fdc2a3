// SPDX-License-Identifier: Apache-2.0
// A server: threads with streams of their own queue copies and kernels, wait by events of others,
// and count finished requests in host functions.
#include "host.h"

#include <atomic>
#include <thread>
#include <vector>

namespace {

const char kModule[] = R"(.version 6.0
.target sm_50
.address_size 64
.visible .entry step(.param .u64 a, .param .u64 b, .param .u32 n, .param .u32 k)
{
  .reg .pred %p<2>; .reg .b32 %r<9>; .reg .b64 %rd<9>;
  ld.param.u64 %rd1, [a]; ld.param.u64 %rd2, [b]; ld.param.u32 %r1, [n]; ld.param.u32 %r7, [k];
  mov.u32 %r2, %ctaid.x; mov.u32 %r3, %ntid.x; mov.u32 %r4, %tid.x;
  mad.lo.s32 %r5, %r2, %r3, %r4;
  setp.ge.u32 %p1, %r5, %r1;
  @%p1 bra END;
  mul.wide.u32 %rd3, %r5, 4; add.s64 %rd4, %rd1, %rd3; add.s64 %rd5, %rd2, %rd3;
  ld.global.u32 %r6, [%rd4]; mad.lo.u32 %r6, %r6, 3, %r7; st.global.u32 [%rd5], %r6;
END:
  ret;
}
)";
constexpr unsigned kThreads = 8, kRequests = 12, kSize = 3000;
std::atomic<unsigned> finished{0}, wrong{0};

void serve(CUcontext context, CUfunction function, unsigned number) {
    CU(cuCtxSetCurrent(context));
    CUstream streams[2];
    for (CUstream& stream : streams)
        CU(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING));
    CUdeviceptr a, b;
    CU(cuMemAlloc(&a, kSize * 4));
    CU(cuMemAlloc(&b, kSize * 4));
    unsigned* host;
    CU(cuMemAllocHost(reinterpret_cast<void**>(&host), kSize * 4));
    for (unsigned request = 0; request < kRequests; ++request) {
        for (unsigned i = 0; i < kSize; ++i)
            host[i] = i + number * request;
        CUevent ready;
        CU(cuEventCreate(&ready, CU_EVENT_DISABLE_TIMING));
        CU(cuMemcpyHtoDAsync(a, host, kSize * 4, streams[0]));
        unsigned size = kSize, k = number;
        void* forth[] = {&a, &b, &size, &k};
        void* back[] = {&b, &a, &size, &k};
        CU(cuLaunchKernel(function, (kSize + 127) / 128, 1, 1, 128, 1, 1, 0, streams[0], forth,
                          nullptr));
        CU(cuEventRecord(ready, streams[0]));
        CU(cuStreamWaitEvent(streams[1], ready, 0));
        CU(cuEventDestroy(ready)); // while it is waited for
        CU(cuLaunchKernel(function, (kSize + 127) / 128, 1, 1, 128, 1, 1, 0, streams[1], back,
                          nullptr));
        CU(cuMemcpyDtoHAsync(host, a, kSize * 4, streams[1]));
        CU(cuLaunchHostFunc(streams[1], [](void*) { ++finished; }, nullptr));
        while (cuStreamQuery(streams[1]) == CUDA_ERROR_NOT_READY)
            std::this_thread::yield();
        for (unsigned i = 0; i < kSize; ++i)
            wrong += host[i] != ((i + number * request) * 3 + number) * 3 + number;
    }
    for (CUstream stream : streams)
        CU(cuStreamDestroy(stream));
    CU(cuMemFree(a));
    CU(cuMemFree(b));
    CU(cuMemFreeHost(host));
}

} // namespace

int main() {
    CU(cuInit(0));
    CUcontext context;
    CU(cuDevicePrimaryCtxRetain(&context, 0));
    CU(cuCtxSetCurrent(context));
    CUmodule module;
    CUfunction function;
    CU(cuModuleLoadData(&module, kModule));
    CU(cuModuleGetFunction(&function, module, "step"));
    std::vector<std::thread> threads;
    for (unsigned i = 0; i < kThreads; ++i)
        threads.emplace_back(serve, context, function, i);
    for (std::thread& thread : threads)
        thread.join();
    std::printf("%u requests, %u values wrong\n", finished.load(), wrong.load());
    CU(cuModuleUnload(module));
    CU(cuDevicePrimaryCtxRelease(0));
    return finish(finished == kThreads * kRequests && wrong == 0);
}
