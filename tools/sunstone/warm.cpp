// SPDX-License-Identifier: Apache-2.0
// `sunstone warm`, for installers: stores the machine code of the library's own kernels in the disk
// cache for later processes (OPTIX_CACHE_PATH, or the default of the user who runs it).
#include "commands.h"

#include "device/cuda/driver.h"
#include "engine/gpu/gpus.h"

#include <dlfcn.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <vector>

namespace sunstone::tool {
namespace {

// The run path of this program leads to the CPU device's libcuda. Loading the libcuda of a GPU's
// driver by its path first makes all later requests for the name return it.
void loadDriver() {
    std::vector<std::string> folders;
    if (const char* path = std::getenv("LD_LIBRARY_PATH")) {
        std::istringstream list(path);
        for (std::string folder; std::getline(list, folder, ':');)
            folders.push_back(folder);
    }
    for (const char* folder : {"/usr/lib/x86_64-linux-gnu", "/usr/lib64", "/usr/local/nvidia/lib64",
                               "/usr/local/nvidia/lib", "/usr/lib/wsl/lib"})
        folders.push_back(folder);
    const std::string cpuDevice = findFolders().cuda;
    std::error_code error;
    for (const std::string& folder : folders)
        if (!std::filesystem::equivalent(folder, cpuDevice, error) &&
            dlopen((folder + "/libcuda.so.1").c_str(), RTLD_NOW | RTLD_LOCAL))
            return;
}

} // namespace

int warm() {
    if (device::cuda::loadedDriver() == device::cuda::LoadedDriver::kNone)
        loadDriver();
    const std::vector<engine::Gpu>& gpus = engine::gpus();
    if (gpus.empty()) {
        std::puts("no CUDA GPU here: nothing to do");
        return 0;
    }
    const auto log = [](LogLevel level, const std::string& text) {
        if (level <= LogLevel::kWarning)
            std::fprintf(stderr, "sunstone: %s\n", text.c_str());
    };
    for (const engine::Gpu& gpu : gpus) {
        const auto start = std::chrono::steady_clock::now();
        engine::warm(gpu, log);
        const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
        std::printf("%s (compute capability %d.%d): ready after %.2f s\n", gpu.name.c_str(),
                    gpu.capability[0], gpu.capability[1], took.count());
    }
    return 0;
}

} // namespace sunstone::tool
