// SPDX-License-Identifier: Apache-2.0
// Denoising on a GPU: asynchronous, in the caller's stream, inside the caller's buffers. The result
// has the bits of the CPU's, except in NaN. Addresses in frames are device addresses.
#pragma once

#include "denoise/call.h"
#include "denoise/filter.h"
#include "denoise/gpu/launch.h"
#include "device/cuda/kernel_set.h"

#include <mutex>
#include <string>
#include <vector>

namespace sunstone::denoise::gpu {

// The kernels, loaded at the first use into the context that is current then. Calls need the same
// context current; any thread may call.
class GpuDenoiser {
public:
    // `code`: source of machine code; null: the driver compiles.
    explicit GpuDenoiser(const device::cuda::Driver& driver,
                         device::cuda::MachineCodeSource* code = nullptr);
    ~GpuDenoiser();
    GpuDenoiser(const GpuDenoiser&) = delete;
    GpuDenoiser& operator=(const GpuDenoiser&) = delete;

    // Compiles and loads the kernels for frames with that many planes of guides; the driver may
    // wait for the GPU.
    void prepare(int guides);
    // The same for all numbers of guides.
    void prepareAll();
    // The context was destroyed: the destructor does not call the driver.
    void abandon();
    // Writes the caller's state memory.
    void setUp(CUstream stream, CUdeviceptr state, uint32_t width, uint32_t height);
    // Frame::scale comes from `inputs`. If the stream reaches a call with invalid inputs, outputs
    // stay unchanged and takeRefusals reports the call.
    void filter(CUstream stream, const Filter& filter, const Frame& frame, void* scratch,
                const CallInputs& inputs);
    // Write one and three floats, see denoise/statistics.h. The API defines the size of scratch.
    void intensity(CUstream stream, const Image& image, void* scratch, float* result);
    void averageColor(CUstream stream, const Image& image, void* scratch, float* result);

    // Calls that have been refused since the last query, each reported once. Never waits.
    struct Refusal {
        CUstream stream;
        std::string text;
    };
    std::vector<Refusal> takeRefusals();

private:
    friend class GpuSteps;
    void check(CUresult result, const char* what) const;
    void launch(CUstream stream, uint32_t kernel, uint32_t blocks, void** arguments);
    void addLogs(CUstream stream, uint32_t pixels, uint32_t blocks, const Image& image,
                 void* scratch, float* result);

    const device::cuda::Driver& driver_;
    std::mutex mutex_;
    device::cuda::KernelSet kernels_;
    Report* report_ = nullptr; // page-locked
    uint32_t refusalsTold_ = 0;
};

} // namespace sunstone::denoise::gpu
