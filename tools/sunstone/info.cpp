// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "base/config.h"
#include "base/threads/cpu_limits.h"
#include "bvh/walk/kernels.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace sunstone::tool {
namespace {

using Json = nlohmann::ordered_json;

std::string processorName() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.rfind("model name", 0) == 0 && line.find(": ") != std::string::npos)
            return line.substr(line.find(": ") + 2);
    return "unknown";
}

// The path of a program found through PATH, or empty.
std::string findProgram(const std::string& name) {
    const char* path = std::getenv("PATH");
    std::istringstream folders(std::string(path ? path : "") + ":/usr/local/cuda/bin");
    std::error_code error;
    for (std::string folder; std::getline(folders, folder, ':');) {
        std::filesystem::path candidate = std::filesystem::path(folder) / name;
        if (!folder.empty() && std::filesystem::is_regular_file(candidate, error))
            return candidate.string();
    }
    return "";
}

Json collect() {
    Folders folders = findFolders();
    Json info;
    info["version"] = SUNSTONE_VERSION;
    info["optix_versions"] = {"7.0", "7.1", "7.2", "7.3", "7.4", "7.5", "7.6"};
    info["optix_classic_versions"] = {"1", "2", "3", "4", "5", "6"};
    info["processor"] = processorName();
    info["instruction_set"] = bvh::isaName(bvh::chosenIsa());
    info["threads"] = cpuLimit().threads;
    info["threads_reason"] = cpuLimit().reason;
    info["libraries"] = {{"libnvoptix", folders.lib}, {"libcuda", folders.cuda}};
    info["compilers"] = {{"clang", findProgram("clang++-19")}, {"nvcc", findProgram("nvcc")}};
    info["settings"] = Json::array();
    for (size_t i = 0; i < size_t(Setting::kCount); ++i) {
        const SettingInfo& setting = settingInfo(Setting(i));
        info["settings"].push_back({{"variable", setting.variable},
                                    {"value", config(Setting(i))},
                                    {"meaning", setting.meaning}});
    }
    return info;
}

std::string shown(const Json& value, const char* missing) {
    std::string text = value.is_string() ? value.get<std::string>() : value.dump();
    return text.empty() ? missing : text;
}

void printRow(const std::string& name, const std::string& value) {
    std::printf("  %-20s %s\n", name.c_str(), value.c_str());
}

} // namespace

int info(bool json) {
    Json info = collect();
    if (json) {
        std::printf("%s\n", info.dump(2).c_str());
        return 0;
    }
    std::printf("Sunstone %s, OptiX 7.0 to 7.6, classic API (OptiX 1 to 6)\n", SUNSTONE_VERSION);
    printRow("processor", shown(info["processor"], ""));
    printRow("instruction set", shown(info["instruction_set"], ""));
    printRow("threads", shown(info["threads"], "") + " (" + cpuLimit().reason + ")");
    std::printf("libraries:\n");
    printRow("libnvoptix", shown(info["libraries"]["libnvoptix"], "not found"));
    printRow("libcuda, libcudart", shown(info["libraries"]["libcuda"], "not found"));
    std::printf("compilers:\n");
    printRow("clang++-19", shown(info["compilers"]["clang"], "not found"));
    printRow("nvcc", shown(info["compilers"]["nvcc"], "not found"));
    std::printf("settings (environment variables):\n");
    for (const Json& setting : info["settings"])
        std::printf("  %-20s %-10s %s\n", shown(setting["variable"], "").c_str(),
                    shown(setting["value"], "(unset)").c_str(),
                    shown(setting["meaning"], "").c_str());
    return 0;
}

} // namespace sunstone::tool
