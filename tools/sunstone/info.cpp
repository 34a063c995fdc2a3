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
    info["optix"] = "7.4";
    info["processor"] = processorName();
    info["instruction set"] = bvh::isaName(bvh::chosenIsa());
    info["threads"] = cpuLimit().threads;
    info["threads because of"] = cpuLimit().reason;
    info["libraries"] = {{"libnvoptix", folders.lib}, {"libcuda, libcudart", folders.cuda}};
    info["compilers"] = {{"clang++-19", findProgram("clang++-19")}, {"nvcc", findProgram("nvcc")}};
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
    std::printf("Sunstone %s, OptiX API %s\n", SUNSTONE_VERSION, "7.4");
    for (const char* key : {"processor", "instruction set"})
        printRow(key, shown(info[key], ""));
    printRow("threads", shown(info["threads"], "") + " (" + cpuLimit().reason + ")");
    for (const char* group : {"libraries", "compilers"}) {
        std::printf("%s:\n", group);
        for (const auto& [name, value] : info[group].items())
            printRow(name, shown(value, "not found"));
    }
    std::printf("settings (environment variables):\n");
    for (const Json& setting : info["settings"])
        std::printf("  %-20s %-10s %s\n", shown(setting["variable"], "").c_str(),
                    shown(setting["value"], "(unset)").c_str(),
                    shown(setting["meaning"], "").c_str());
    return 0;
}

} // namespace sunstone::tool
