// SPDX-License-Identifier: Apache-2.0
// The rules of settings. tests/tools checks the lines on stderr.
#include "base/config.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace sunstone {
namespace {

using Case = std::pair<Setting, const char*>;

TEST(Settings, GoodValues) {
    for (const auto& [setting, value] : std::vector<Case>{
             {Setting::kLog, ""},
             {Setting::kLog, "debug"},
             {Setting::kLog, "compiler:debug,bvh:info"},
             {Setting::kLog, "error,optix7:off,"},
             {Setting::kDump, "/"},
             {Setting::kThreads, "1"},
             {Setting::kThreads, "4096"},
             {Setting::kIsa, "avx2"},
             {Setting::kCachePath, "anything"},
             {Setting::kCacheMaxSize, "0"},
             {Setting::kCacheMaxSize, "10000000000"},
             {Setting::kCheck, "memory,leaks"},
             {Setting::kGpuBackEnd, "cpu-device"},
             {Setting::kGpuCode, "ready"},
             {Setting::kGpuCode, "whole"},
             {Setting::kGpuCode, "narrow"},
             {Setting::kKernels, "single"},
             {Setting::kVisibleDevices, "-1"},
         })
        EXPECT_EQ("", settingFault(setting, value)) << settingInfo(setting).variable << value;
}

TEST(Settings, BadValues) {
    for (const auto& [setting, value] : std::vector<Case>{
             {Setting::kLog, "verbose"},
             {Setting::kLog, "bvh:loud"},
             {Setting::kLog, "debug,bvh"},
             {Setting::kLog, "optx7:debug"},
             {Setting::kLog, "debug,:info"},
             {Setting::kDump, "/no/such/folder"},
             {Setting::kThreads, "0"},
             {Setting::kThreads, "-2"},
             {Setting::kThreads, "two"},
             {Setting::kThreads, "4x"},
             {Setting::kThreads, "4097"},
             {Setting::kThreads, "99999999999999999999"},
             {Setting::kIsa, "sse"},
             {Setting::kCacheMaxSize, "1G"},
             {Setting::kCacheMaxSize, "-1"},
             {Setting::kCheck, "memory,leak"},
             {Setting::kGpuBackEnd, "1"},
             {Setting::kGpuCode, "1"},
             {Setting::kKernels, "warp"},
         })
        EXPECT_NE(std::string::npos, settingFault(setting, value).find(" must be "))
            << settingInfo(setting).variable << "=" << value;
}

} // namespace
} // namespace sunstone
