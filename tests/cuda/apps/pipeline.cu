// SPDX-License-Identifier: Apache-2.0
// A pipeline over streams: copy in, compute, copy out, piece by piece through page-locked memory,
// with events between streams and host functions at the ends.
#include <cuda_runtime.h>

#include "check.h"

#include <atomic>
#include <vector>

constexpr int kPieces = 8, kSize = 5000, kStreams = 3;

__global__ void transform(float* data, int n, float offset) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < n)
        data[i] = data[i] * 2 + offset;
}

struct Finished {
    std::atomic<int>* count;
    const float* data;
    int piece;
    double sum;
};

static void CUDART_CB add(void* user) {
    Finished& finished = *static_cast<Finished*>(user);
    for (int i = 0; i < kSize; ++i)
        finished.sum += finished.data[i];
    ++*finished.count;
}

static void CUDART_CB note(cudaStream_t, cudaError_t status, void* user) {
    *static_cast<cudaError_t*>(user) = status;
}

int main() {
    float *host, *device;
    CHECK(cudaMallocHost(&host, kPieces * kSize * sizeof(float)));
    CHECK(cudaMalloc(&device, kPieces * kSize * sizeof(float)));
    for (int i = 0; i < kPieces * kSize; ++i)
        host[i] = float(i % 1000);
    cudaStream_t streams[kStreams], checker;
    for (cudaStream_t& stream : streams)
        CHECK(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking));
    int least, greatest;
    CHECK(cudaDeviceGetStreamPriorityRange(&least, &greatest));
    CHECK(cudaStreamCreateWithPriority(&checker, cudaStreamNonBlocking, greatest));
    cudaEvent_t start, end, done[kPieces];
    CHECK(cudaEventCreate(&start));
    CHECK(cudaEventCreate(&end));
    for (cudaEvent_t& event : done)
        CHECK(cudaEventCreateWithFlags(&event, cudaEventDisableTiming));

    std::atomic<int> count(0);
    std::vector<Finished> finished(kPieces);
    CHECK(cudaEventRecord(start, streams[0]));
    for (int piece = 0; piece < kPieces; ++piece) {
        cudaStream_t stream = streams[piece % kStreams];
        float *from = host + piece * kSize, *to = device + piece * kSize;
        CHECK(cudaMemcpyAsync(to, from, kSize * 4, cudaMemcpyHostToDevice, stream));
        transform<<<(kSize + 255) / 256, 256, 0, stream>>>(to, kSize, float(piece));
        CHECK(cudaMemcpyAsync(from, to, kSize * 4, cudaMemcpyDeviceToHost, stream));
        CHECK(cudaEventRecord(done[piece], stream));
        finished[piece] = {&count, from, piece, 0};
        CHECK(cudaStreamWaitEvent(checker, done[piece], 0));
        CHECK(cudaLaunchHostFunc(checker, add, &finished[piece]));
    }
    cudaError_t status = cudaErrorUnknown;
    CHECK(cudaStreamAddCallback(checker, note, &status, 0));
    for (cudaStream_t stream : streams)
        CHECK(cudaStreamSynchronize(stream));
    CHECK(cudaEventRecord(end, streams[0]));
    CHECK(cudaStreamSynchronize(checker));
    CHECK(cudaEventSynchronize(end));
    float milliseconds = -1;
    CHECK(cudaEventElapsedTime(&milliseconds, start, end));
    std::printf("%d pieces finished, callback %s, time %s\n", count.load(),
                cudaGetErrorName(status), milliseconds > 0 ? "passed" : "stood still");
    for (const Finished& f : finished)
        std::printf("piece %d: %.0f\n", f.piece, f.sum);
    std::printf("%s, %s\n", cudaGetErrorName(cudaStreamQuery(checker)),
                cudaGetErrorName(cudaEventQuery(done[kPieces - 1])));
    CHECK(cudaFreeHost(host));
    return 0;
}
