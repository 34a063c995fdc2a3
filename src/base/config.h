// SPDX-License-Identifier: Apache-2.0
// All environment variables that the engine reads, in one table; getenv is called only here.
// `sunstone info` prints the table.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace sunstone {

enum class Setting {
    kLog,     // SUNSTONE_LOG: levels by area, see log.h
    kDump,    // SUNSTONE_DUMP: folder that receives the program after every compiler pass
    kThreads, // SUNSTONE_THREADS: worker threads of the CPU device, default see
              // threads/cpu_limits.h
    kIsa,     // SUNSTONE_ISA: highest instruction set of traversal and compiled code (avx512, avx2,
              // baseline)
    kCachePath,      // OPTIX_CACHE_PATH: folder of the disk cache
    kCacheMaxSize,   // OPTIX_CACHE_MAXSIZE: bytes of the disk cache, 0 for none
    kCheck,          // SUNSTONE_CHECK: checks of `sunstone run --check`, see checks()
    kCheckReport,    // SUNSTONE_CHECK_REPORT: file that receives the checks' reports
    kGpuBackEnd,     // SUNSTONE_GPU_BACK_END=cpu-device: the GPU back end drives the CPU device's
                     // libcuda
    kGpuCode,        // SUNSTONE_GPU_CODE: which code pipelines on GPUs have before all of it is
                     // compiled, see engine/gpu/code/ready_code.h
    kKernels,        // SUNSTONE_KERNELS: how the threads of kernels run, see docs/cuda.md
    kRays,           // SUNSTONE_RAYS: whether rays of a launch wait for one another, see
                     // engine/cpu/in_flight.h
    kVisibleDevices, // CUDA_VISIBLE_DEVICES: devices of the CPU's libcuda
    kClang,          // SUNSTONE_CLANG: the clang++ that libnvrtc runs
    kRanks, // SUNSTONE_RANKS: the socket to other ranks, set by `sunstone run` under mpirun
    kCount,
};

struct SettingInfo {
    const char* variable;
    const char* meaning;
};

// The value of a setting at its first query; empty if the variable is unset. The first call lists
// all variables with invalid values on stderr, with the broken rule; they count as unset.
const std::string& config(Setting setting);

// The rule that a value breaks, or empty.
std::string settingFault(Setting setting, const std::string& value);

// Whether the variable is set, even to the empty string.
bool isSet(Setting setting);

// The current value, for settings that a process may change before it creates a context.
std::string currentConfig(Setting setting);

// The setting as a number; fallback if it is unset or not a positive number.
unsigned configNumber(Setting setting, unsigned fallback);

// Whether SUNSTONE_CHECK contains the word: "memory" (accesses of device code), "leaks", "host"
// (ordinary memory of the process may be accessed).
bool checks(std::string_view what);

const SettingInfo& settingInfo(Setting setting);

} // namespace sunstone
