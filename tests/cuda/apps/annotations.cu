// SPDX-License-Identifier: Apache-2.0
// A program full of annotations for a profiler: the interface in C and the one in C++.
#include <cstdio>
#include <nvToolsExt.h>
#include <nvToolsExtCuda.h>
#include <nvtx3/nvToolsExtCudaRt.h>
#include <nvtx3/nvtx3.hpp>

static_assert(sizeof(nvtxEventAttributes_t) == 48 && sizeof(nvtxResourceAttributes_t) == 32, "");

struct Renderer {
    static constexpr char const* name = "renderer";
};
struct Loading {
    static constexpr uint32_t id = 3;
    static constexpr char const* name = "loading";
};
struct Frame {
    static constexpr char const* message = "frame";
};

__global__ void count(int* sum) {
    atomicAdd(sum, 1);
}

static int frame(cudaStream_t stream, int* sum) {
    NVTX3_FUNC_RANGE();
    nvtx3::scoped_range_in<Renderer> range{"frame", nvtx3::rgb{10, 200, 30}, nvtx3::payload{7},
                                           nvtx3::category{2}};
    nvtx3::scoped_range other{nvtx3::event_attributes{"inner", nvtx3::argb{255, 1, 2, 3}}};
    const auto handle = nvtx3::start_range("copy");
    count<<<2, 64, 0, stream>>>(sum);
    nvtx3::end_range(handle);
    nvtx3::mark("launched", nvtx3::named_category::get<Loading>());
    nvtx3::unique_range moved{nvtx3::registered_string::get<Frame>()};
    nvtx3::unique_range kept = std::move(moved);
    (void)kept;
    cudaStreamSynchronize(stream);
    return *sum;
}

int main() {
    int* sum;
    cudaMallocManaged(&sum, sizeof(int));
    *sum = 0;
    cudaStream_t stream;
    cudaStreamCreate(&stream);
    nvtxNameCudaStream(stream, "work");
    nvtxNameCudaDevice(0, "device");
    nvtxNameOsThread(1, "main");
    nvtxNameCategory(1, "setup");
    nvtxEventAttributes_t attributes = {};
    attributes.version = NVTX_VERSION;
    attributes.size = NVTX_EVENT_ATTRIB_STRUCT_SIZE;
    attributes.colorType = NVTX_COLOR_ARGB;
    attributes.color = 0xff00ff00;
    attributes.messageType = NVTX_MESSAGE_TYPE_ASCII;
    attributes.message.ascii = "everything";
    const int pushed = nvtxRangePushEx(&attributes);
    const nvtxRangeId_t id = nvtxRangeStartA("range");
    nvtxDomainHandle_t domain = nvtxDomainCreateA("domain");
    const int level = nvtxDomainRangePushEx(domain, &attributes);
    std::printf("%d threads\n", frame(stream, sum));
    nvtxRangeEnd(id);
    const int popped = nvtxDomainRangePop(domain);
    std::printf("without a tool: %d %d %d %d\n", pushed, level, popped, nvtxRangePop());
    nvtxDomainDestroy(domain);
    cudaStreamDestroy(stream);
    return 0;
}
