// SPDX-License-Identifier: Apache-2.0
// CUDA and OptiX for programs that record a library's behaviour. The library is the one that the
// process finds: Sunstone's or a GPU driver's.
#pragma once

#include <optix.h>

#include <cstdint>
#include <string>
#include <vector>

namespace reference {

// Prints the text and ends the process with this code; ctest counts 77 as skipped.
[[noreturn]] void quit(int code, const std::string& text);

// Ends the process with the name of the result unless it is OPTIX_SUCCESS.
void check(OptixResult result, const char* call);
#define CHECK(call) ::reference::check(call, #call)

// The few functions of the CUDA driver in use, found at run time.
class Cuda {
public:
    Cuda();
    CUdeviceptr allocate(size_t size) const; // contents undefined; lives as long as the process
    template <class T>
    CUdeviceptr upload(const std::vector<T>& data) const {
        const CUdeviceptr address = allocate(data.size() * sizeof(T));
        copyIn(address, data.data(), data.size() * sizeof(T));
        return address;
    }
    void copyIn(CUdeviceptr to, const void* from, size_t size) const;
    void copyOut(void* to, CUdeviceptr from, size_t size) const;
    void wait() const;

private:
    template <class Signature>
    Signature* function(const char* name) const;
    void* library_;
};

struct World {
    Cuda cuda;
    OptixDeviceContext context = nullptr;

    World(); // ends the process with 77 where there is no library
    OptixTraversableHandle build(const OptixBuildInput& input, unsigned int flags,
                                 CUdeviceptr* output = nullptr) const;
    // A pipeline of ray generation, miss, closest-hit and any-hit programs, and records for it.
    OptixPipeline pipeline(const std::string& ptx, const OptixPipelineCompileOptions& options,
                           const char* const names[4], OptixShaderBindingTable& sbt) const;
};

std::string fileText(const char* path);

} // namespace reference
