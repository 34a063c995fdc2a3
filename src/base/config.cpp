// SPDX-License-Identifier: Apache-2.0
// See config.h: the table of settings, and their values from the environment.
#include "base/config.h"

#include "base/log.h"
#include "base/log_areas.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <initializer_list>
#include <span>
#include <string_view>
#include <unistd.h>

namespace sunstone {
namespace {

constexpr size_t kCount = size_t(Setting::kCount);

constexpr std::array<SettingInfo, kCount> kSettings = {{
    {"SUNSTONE_LOG",
     "log levels: LEVEL or AREA:LEVEL,...; levels off fatal error warning info debug"},
    {"SUNSTONE_DUMP", "folder that receives programs after every compiler pass"},
    {"SUNSTONE_THREADS", "worker threads of the CPU device (default: the processors it may use)"},
    {"SUNSTONE_ISA", "highest instruction set of traversal and of compiled device code: avx512, "
                     "avx2, baseline"},
    {"OPTIX_CACHE_PATH", "folder of the disk cache; overrides the application's setting"},
    {"OPTIX_CACHE_MAXSIZE", "bytes the disk cache may grow to; 0 turns it off"},
    {"SUNSTONE_CHECK", "checks of device code, set by `sunstone run --check`: memory,leaks,host"},
    {"SUNSTONE_CHECK_REPORT", "file that the reports of these checks are added to, JSON lines"},
    {"SUNSTONE_GPU_BACK_END",
     "cpu-device: contexts of the CPU device use the back end for GPUs (for its tests)"},
    {"SUNSTONE_GPU_CODE",
     "code of new pipelines on GPUs: whole (compiled at once), ready (linked with a kernel of the "
     "library, for tests), narrow (code for the traversables that exist is compiled at the first "
     "launch) or, by default, ready until the whole is compiled"},
    {"SUNSTONE_KERNELS", "how threads of CUDA kernels run: lockstep (default), single or runs"},
    {"SUNSTONE_RAYS",
     "how rays of OptiX launches are walked on the CPU: alone or batches (default: "
     "the faster way, measured)"},
    {"CUDA_VISIBLE_DEVICES", "CUDA devices that programs see: numbers or UUIDs; empty or -1: none"},
    {"SUNSTONE_CLANG", "clang++ of version 19 or later that run-time compilation uses"},
    {"SUNSTONE_RANKS", "socket to other ranks, set by `sunstone run` under mpirun"},
}};

constexpr unsigned long kMostThreads = 4096;

// Whether all items of the list between separators are among the words.
bool areAll(const std::string& list, std::initializer_list<std::string_view> words) {
    std::string_view rest = list;
    for (;;) {
        const size_t comma = rest.find(',');
        const std::string_view part = rest.substr(0, comma);
        if (!part.empty() && std::find(words.begin(), words.end(), part) == words.end())
            return false;
        if (comma == std::string_view::npos)
            return true;
        rest.remove_prefix(comma + 1);
    }
}

// Whether the text is a whole number of at most `most`.
bool isNumber(const std::string& text, unsigned long least, unsigned long most) {
    unsigned long value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() && value >= least &&
           value <= most;
}

constexpr std::string_view kLogLevels[] = {"off", "fatal", "error", "warning", "info", "debug"};

bool isOneOf(std::string_view word, std::span<const std::string_view> words) {
    return std::find(words.begin(), words.end(), word) != words.end();
}

std::string listOf(std::span<const std::string_view> words) {
    std::string list;
    for (const std::string_view word : words)
        list += (list.empty() ? "" : ", ") + std::string(word);
    return list;
}

// The rule that a list LEVEL or AREA:LEVEL,... breaks, or empty.
std::string logFault(std::string_view rest) {
    while (!rest.empty()) {
        const size_t comma = std::min(rest.find(','), rest.size());
        const std::string_view item = rest.substr(0, comma);
        rest.remove_prefix(std::min(comma + 1, rest.size()));
        const size_t colon = item.find(':');
        const std::string_view level =
            colon == std::string_view::npos ? item : item.substr(colon + 1);
        if (!item.empty() && !isOneOf(level, kLogLevels))
            return "it must be LEVEL or AREA:LEVEL,... with the levels " + listOf(kLogLevels);
        if (colon != std::string_view::npos && !isOneOf(item.substr(0, colon), kLogAreas))
            return "the area \"" + std::string(item.substr(0, colon)) + "\" must be one of " +
                   listOf(kLogAreas);
    }
    return {};
}

using Values = std::array<std::string, kCount>;

// Removes invalid values. Uses no log, because the log reads a setting.
void dropFaulty(Values& values) {
    for (size_t i = 0; i < kCount; ++i) {
        const std::string fault = settingFault(Setting(i), values[i]);
        if (fault.empty())
            continue;
        std::fprintf(stderr, "[sunstone base fatal] %s=\"%s\" is ignored: %s\n",
                     kSettings[i].variable, values[i].c_str(), fault.c_str());
        values[i].clear();
    }
}

} // namespace

std::string settingFault(Setting setting, const std::string& value) {
    if (value.empty())
        return {};
    const auto unless = [](bool good, const char* rule) -> std::string {
        return good ? "" : std::string("it must be ") + rule;
    };
    std::error_code error;
    switch (setting) {
    case Setting::kLog:
        return logFault(value);
    case Setting::kDump:
        return unless(std::filesystem::is_directory(value, error), "a folder that exists");
    case Setting::kThreads:
        return unless(isNumber(value, 1, kMostThreads), "a whole number from 1 to 4096");
    case Setting::kIsa:
        return unless(value == "avx512" || value == "avx2" || value == "baseline",
                      "avx512, avx2 or baseline");
    case Setting::kCacheMaxSize:
        return unless(isNumber(value, 0, ~0ul), "a number of bytes; 0 turns the cache off");
    case Setting::kCheck:
        return unless(areAll(value, {"memory", "leaks", "host"}), "a list of memory, leaks, host");
    case Setting::kRays:
        return unless(value == "alone" || value == "batches", "alone or batches");
    case Setting::kGpuBackEnd:
        return unless(value == "cpu-device", "cpu-device");
    case Setting::kGpuCode:
        return unless(value == "whole" || value == "ready" || value == "narrow",
                      "whole, ready or narrow");
    case Setting::kKernels:
        return unless(value == "lockstep" || value == "single" || value == "runs",
                      "lockstep, single or runs");
    case Setting::kClang:
        return unless(access(value.c_str(), X_OK) == 0, "the path of a program");
    default:
        return {};
    }
}

const std::string& config(Setting setting) {
    static const auto& values = *[] {
        auto* read = new Values;
        for (size_t i = 0; i < kCount; ++i)
            if (const char* value = std::getenv(kSettings[i].variable))
                (*read)[i] = value;
        dropFaulty(*read);
        return read;
    }();
    return values[size_t(setting)];
}

bool isSet(Setting setting) {
    return std::getenv(kSettings[size_t(setting)].variable) != nullptr;
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
