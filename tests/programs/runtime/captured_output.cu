// SPDX-License-Identifier: Apache-2.0
// A test harness for kernels: what they print is caught through a pipe and compared, a failed
// assertion in a child process must give the error and the text on stderr, and a trap must, too.
#include "device.h"

#include <assert.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

struct Vector {
    float x, y;
};

__global__ void printAll(Vector v, const char* text, int n) {
    const int i = threadIdx.x;
    if (i < n)
        printf("%2d|%-6s|%+.3f|%5.1e|%08x|%c|%lld|%%|%5d|%s\n", i, text, v.x * i, double(v.y),
               0xbeefu + i, 'a' + i, -1234567890123ll * i, -i, i % 2 ? "odd" : "even");
}
__global__ void bounded(const int* values, int limit) {
    assert(values[threadIdx.x] < limit && "values are bounded");
}
__global__ void trapAt(int thread) {
    if (int(threadIdx.x) == thread)
        __trap();
}

// Runs the body in a new process of this program, and collects what it writes.
static std::string outputOf(const char* self, const char* what, int* status) {
    int ends[2];
    if (pipe(ends) != 0)
        std::exit(3);
    const pid_t child = fork(); // before any use of CUDA in this process
    if (child == 0) {
        dup2(ends[1], 1);
        dup2(ends[1], 2);
        close(ends[0]);
        close(ends[1]);
        execl(self, self, what, static_cast<char*>(nullptr));
        _exit(127);
    }
    close(ends[1]);
    std::string all;
    char buffer[512];
    for (ssize_t got; (got = read(ends[0], buffer, sizeof buffer)) > 0;)
        all.append(buffer, size_t(got));
    close(ends[0]);
    int code = 0;
    waitpid(child, &code, 0);
    *status = WIFEXITED(code) ? WEXITSTATUS(code) : -1;
    return all;
}

static int child(const std::string& what) {
    if (what == "print") {
        char* text;
        CUDA(cudaMallocManaged(&text, 8));
        std::strcpy(text, "text");
        printAll<<<1, 32>>>({0.25f, 12345.678f}, text, 20);
        CUDA(cudaDeviceSynchronize());
        return 0;
    }
    int* values;
    CUDA(cudaMallocManaged(&values, 64 * sizeof(int)));
    for (int i = 0; i < 64; ++i)
        values[i] = i;
    if (what == "assert")
        bounded<<<1, 64>>>(values, 60);
    else
        trapAt<<<1, 64>>>(13);
    const cudaError_t result = cudaDeviceSynchronize(), again = cudaFree(nullptr),
                      last = cudaGetLastError();
    std::fprintf(stderr, "%s %s %s\n", cudaGetErrorName(result), cudaGetErrorName(again),
                 cudaGetErrorName(last));
    return 7;
}

int main(int argc, char** argv) {
    if (argc > 1)
        return child(argv[1]);
    int status = 0, wrong = 0;
    const std::string printed = outputOf("/proc/self/exe", "print", &status);
    wrong += status != 0;
    std::vector<std::string> lines, right;
    for (size_t begin = 0, end; (end = printed.find('\n', begin)) != printed.npos; begin = end + 1)
        lines.push_back(printed.substr(begin, end - begin));
    for (int i = 0; i < 20; ++i) {
        char line[256];
        std::snprintf(line, sizeof line, "%2d|%-6s|%+.3f|%5.1e|%08x|%c|%lld|%%|%5d|%s", i, "text",
                      0.25f * i, double(12345.678f), 0xbeefu + i, 'a' + i, -1234567890123ll * i, -i,
                      i % 2 ? "odd" : "even");
        right.push_back(line);
    }
    std::sort(lines.begin(), lines.end());
    std::sort(right.begin(), right.end());
    wrong += lines != right;

    const std::string failed = outputOf("/proc/self/exe", "assert", &status);
    for (const char* part : {"values[threadIdx.x] < limit", "captured_output.cu", "bounded",
                             "cudaErrorAssert cudaErrorAssert cudaErrorAssert"})
        if (failed.find(part) == failed.npos) {
            std::printf("\"%s\" is missing in: %s\n", part, failed.c_str());
            ++wrong;
        }
    int threads = 0;
    for (size_t at = 0; (at = failed.find("thread: [", at)) != failed.npos; ++at)
        ++threads;
    wrong += threads < 1 || threads > 4 || status != 7;
    const std::string trapped = outputOf("/proc/self/exe", "trap", &status);
    wrong += trapped.find("cudaErrorLaunchFailure") == trapped.npos &&
             trapped.find("cudaErrorIllegalInstruction") == trapped.npos;
    std::printf("%d wrong\n", wrong);
    return finish(wrong == 0);
}
