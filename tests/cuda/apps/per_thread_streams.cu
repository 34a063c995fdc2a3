// SPDX-License-Identifier: Apache-2.0
// Built with one default stream per thread: while one thread's stream is blocked, that of another
// does not wait.
#include <cuda_runtime.h>

#include "check.h"

#include <future>
#include <thread>

__global__ void count(int* out, int value) {
    out[threadIdx.x] += value;
}

static void countAll(int* out) {
    for (int i = 0; i < 100; ++i)
        count<<<1, 32>>>(out, i);
    CHECK(cudaGetLastError());
}

struct Meeting {
    std::promise<void> isThere, isHeldUp, mayGoOn;
    cudaError_t heldUp, other;
};

static void waitForOther(void* meeting) {
    static_cast<Meeting*>(meeting)->mayGoOn.get_future().wait();
}

// Its stream waits until the other thread has queried its own stream.
static void workHeldUp(int* out, Meeting* meeting) {
    meeting->isThere.get_future().wait();
    CHECK(cudaLaunchHostFunc(0, waitForOther, meeting));
    countAll(out);
    meeting->heldUp = cudaStreamQuery(0);
    meeting->isHeldUp.set_value();
    CHECK(cudaStreamSynchronize(0));
}

static void work(int* out, Meeting* meeting) {
    // The first use of the stream and of the kernel may wait for all other work.
    count<<<1, 32>>>(out, 0);
    CHECK(cudaStreamSynchronize(0));
    meeting->isThere.set_value();
    meeting->isHeldUp.get_future().wait();
    meeting->other = cudaStreamQuery(0);
    meeting->mayGoOn.set_value();
    countAll(out);
    CHECK(cudaStreamSynchronize(0));
}

int main() {
    int* out[2];
    for (int*& memory : out) {
        CHECK(cudaMallocHost(&memory, 32 * sizeof(int)));
        for (int i = 0; i < 32; ++i)
            memory[i] = i;
    }
    Meeting meeting;
    std::thread first(workHeldUp, out[0], &meeting), second(work, out[1], &meeting);
    first.join();
    second.join();
    std::printf("one stream: %s, the other: %s, sums %d %d\n", cudaGetErrorName(meeting.heldUp),
                cudaGetErrorName(meeting.other), out[0][0], out[1][31]);
    unsigned flags = 1;
    CHECK(cudaStreamGetFlags(0, &flags));
    std::printf("flags of the default stream: %u\n", flags);
    return 0;
}
