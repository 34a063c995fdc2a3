// SPDX-License-Identifier: Apache-2.0
// The toolkit's libraries of algorithms: thrust and CUB.
#include <cub/device/device_select.cuh>
#include <thrust/device_vector.h>
#include <thrust/functional.h>
#include <thrust/host_vector.h>
#include <thrust/reduce.h>
#include <thrust/scan.h>
#include <thrust/sequence.h>
#include <thrust/sort.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "check.h"

struct IsOdd {
    __host__ __device__ bool operator()(int a) const { return a & 1; }
};

int main() {
    const int count = 20011;
    std::mt19937 random(1);
    thrust::host_vector<int> values(count);
    for (int& value : values)
        value = int(random() % 1000003);
    std::vector<int> sorted(values.begin(), values.end());
    std::sort(sorted.begin(), sorted.end());

    thrust::device_vector<int> numbers = values;
    thrust::sort(numbers.begin(), numbers.end());
    thrust::host_vector<int> back = numbers;
    std::printf("sort: %d\n", std::equal(back.begin(), back.end(), sorted.begin()));

    const long long sum = thrust::reduce(numbers.begin(), numbers.end(), 0ll);
    std::printf("reduce: %d\n", sum == std::accumulate(sorted.begin(), sorted.end(), 0ll));

    thrust::device_vector<int> sums(count);
    thrust::inclusive_scan(numbers.begin(), numbers.end(), sums.begin());
    back = sums;
    std::vector<int> expected(count);
    std::partial_sum(sorted.begin(), sorted.end(), expected.begin());
    std::printf("scan: %d\n", std::equal(back.begin(), back.end(), expected.begin()));

    thrust::device_vector<double> keys(count);
    thrust::device_vector<int> order(count);
    thrust::host_vector<double> hostKeys(count);
    for (double& key : hostKeys)
        key = double(random() % 5000) - 2500;
    keys = hostKeys;
    thrust::sequence(order.begin(), order.end());
    thrust::stable_sort_by_key(keys.begin(), keys.end(), order.begin(), thrust::greater<double>());
    back = order;
    std::vector<int> stable(count);
    std::iota(stable.begin(), stable.end(), 0);
    std::stable_sort(stable.begin(), stable.end(),
                     [&](int a, int b) { return hostKeys[a] > hostKeys[b]; });
    std::printf("sort_by_key: %d\n", std::equal(back.begin(), back.end(), stable.begin()));

    const int* in = thrust::raw_pointer_cast(numbers.data());
    int *out, *selected;
    CHECK(cudaMalloc(&out, count * sizeof(int)));
    CHECK(cudaMallocManaged(&selected, sizeof(int)));
    size_t bytes = 0;
    CHECK(cub::DeviceSelect::If(nullptr, bytes, in, out, selected, count, IsOdd()));
    void* scratch;
    CHECK(cudaMalloc(&scratch, bytes));
    CHECK(cub::DeviceSelect::If(scratch, bytes, in, out, selected, count, IsOdd()));
    CHECK(cudaDeviceSynchronize());
    std::printf("select: %d\n", *selected == std::count_if(sorted.begin(), sorted.end(), IsOdd()));
    return 0;
}
