// SPDX-License-Identifier: Apache-2.0
// Device memory that frees itself.
#pragma once

#include "check.h"

#include <cstddef>
#include <utility>
#include <vector>

class DeviceBuffer {
public:
    DeviceBuffer() = default;
    explicit DeviceBuffer(size_t size) { allocate(size); }
    DeviceBuffer(const DeviceBuffer&) = delete;
    DeviceBuffer& operator=(const DeviceBuffer&) = delete;
    DeviceBuffer(DeviceBuffer&& other) noexcept { swap(other); }
    DeviceBuffer& operator=(DeviceBuffer&& other) noexcept {
        swap(other);
        return *this;
    }
    ~DeviceBuffer() { cudaFree(data_); }

    // Replaces the memory; its contents are undefined.
    void allocate(size_t size) {
        cudaFree(std::exchange(data_, nullptr));
        size_ = 0;
        if (size != 0)
            CUDA_CHECK(cudaMalloc(&data_, size));
        size_ = size;
    }
    void upload(const void* source, size_t size) {
        allocate(size);
        if (size != 0)
            CUDA_CHECK(cudaMemcpy(data_, source, size, cudaMemcpyHostToDevice));
    }
    template <class T>
    void upload(const std::vector<T>& source) {
        upload(source.data(), source.size() * sizeof(T));
    }
    template <class T>
    std::vector<T> download() const {
        std::vector<T> result(size_ / sizeof(T));
        CUDA_CHECK(
            cudaMemcpy(result.data(), data_, result.size() * sizeof(T), cudaMemcpyDeviceToHost));
        return result;
    }

    void* data() const { return data_; }
    template <class T>
    T* as() const {
        return static_cast<T*>(data_);
    }
    CUdeviceptr address() const { return reinterpret_cast<CUdeviceptr>(data_); }
    size_t size() const { return size_; }

private:
    void swap(DeviceBuffer& other) noexcept {
        std::swap(data_, other.data_);
        std::swap(size_, other.size_);
    }
    void* data_ = nullptr;
    size_t size_ = 0;
};
