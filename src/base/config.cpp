// SPDX-License-Identifier: Apache-2.0
// See config.h: the table of settings, and their values from the environment.
#include "base/config.h"

#include <algorithm>
#include <array>
#include <cstdlib>

namespace sunstone {
namespace {

constexpr size_t kCount = size_t(Setting::kCount);

constexpr std::array<SettingInfo, kCount> kSettings = {{
    {"SUNSTONE_LOG", "log levels: LEVEL or AREA:LEVEL,...; levels off fatal error warning info debug"},
    {"SUNSTONE_DUMP", "folder that receives programs after every compiler pass"},
    {"SUNSTONE_THREADS", "worker threads of the CPU device (default: all cores)"},
    {"SUNSTONE_ISA", "highest instruction set of traversal and of compiled device code: avx512, avx2, baseline"},
    {"OPTIX_CACHE_PATH", "folder of the disk cache, instead of any that a program names"},
    {"OPTIX_CACHE_MAXSIZE", "bytes the disk cache may grow to; 0 turns it off"},
    {"SUNSTONE_CHECK", "checks of device code, set by `sunstone run --check`: memory,leaks,host"},
    {"SUNSTONE_CHECK_REPORT", "file that the reports of these checks are added to, JSON lines"},
    {"SUNSTONE_GPU_BACK_END", "cpu-device: contexts of the CPU device use the back end for GPUs (for its tests)"},
    {"SUNSTONE_KERNELS", "how threads of CUDA kernels run: lockstep (default) or single"},
}};

} // namespace

const std::string& config(Setting setting) {
    static const auto& values = *[] {
        auto* read = new std::array<std::string, kCount>;
        for (size_t i = 0; i < kCount; ++i)
            if (const char* value = std::getenv(kSettings[i].variable))
                (*read)[i] = value;
        return read;
    }();
    return values[size_t(setting)];
}

std::string currentConfig(Setting setting) {
    const char* value = std::getenv(kSettings[size_t(setting)].variable);
    return value ? value : "";
}

unsigned configNumber(Setting setting, unsigned fallback) {
    const std::string& text = config(setting);
    char* end = nullptr;
    long value = std::strtol(text.c_str(), &end, 10);
    return (!text.empty() && *end == 0 && value > 0) ? unsigned(value) : fallback;
}

bool checks(std::string_view what) {
    const std::string_view list = config(Setting::kCheck);
    for (size_t begin = 0; begin < list.size();) {
        const size_t end = std::min(list.find(',', begin), list.size());
        if (list.substr(begin, end - begin) == what)
            return true;
        begin = end + 1;
    }
    return false;
}

const SettingInfo& settingInfo(Setting setting) {
    return kSettings[size_t(setting)];
}

} // namespace sunstone
