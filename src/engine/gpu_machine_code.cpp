// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu_machine_code.h"

#include "base/error.h"
#include "device/cuda/driver.h"

namespace sunstone::engine {
namespace {

using namespace device::cuda;

// The driver's compiler at work on one text. What it makes lives as long as this.
class Compilation {
public:
    Compilation(const std::string& ptx, unsigned maxRegisters) {
        CUjit_option options[] = {CU_JIT_ERROR_LOG_BUFFER, CU_JIT_ERROR_LOG_BUFFER_SIZE_BYTES,
                                  CU_JIT_MAX_REGISTERS};
        void* values[] = {errors_.data(), reinterpret_cast<void*>(errors_.size()),
                          reinterpret_cast<void*>(uintptr_t(maxRegisters))};
        require(driver().linkCreate(unsigned(std::size(options)), options, values, &state_));
        // With the terminating zero.
        require(driver().linkAddData(state_, CU_JIT_INPUT_PTX, const_cast<char*>(ptx.c_str()),
                                     ptx.size() + 1, "pipeline", 0, nullptr, nullptr));
        void* image = nullptr;
        size_t size = 0;
        require(driver().linkComplete(state_, &image, &size));
        machineCode_.assign(static_cast<const char*>(image), size);
    }
    ~Compilation() {
        if (state_)
            driver().linkDestroy(state_);
    }
    Compilation(const Compilation&) = delete;

    std::string take() { return std::move(machineCode_); }

private:
    void require(CUresult result) {
        if (result == CUDA_SUCCESS)
            return;
        const char* name = nullptr;
        driver().getErrorName(result, &name);
        const std::string text =
            message("the driver cannot compile the pipeline: ", name ? name : "unknown error", ": ",
                    errors_.c_str());
        if (state_)
            driver().linkDestroy(state_);
        fail(result == CUDA_ERROR_OUT_OF_MEMORY ? Code::kOutOfMemory : Code::kLinkError, text);
    }

    std::string errors_ = std::string(8192, '\0');
    std::string machineCode_;
    CUlinkState state_ = nullptr;
};

} // namespace

std::string assembleForGpu(const std::string& ptx, unsigned maxRegisters) {
    return Compilation(ptx, maxRegisters).take();
}

} // namespace sunstone::engine
