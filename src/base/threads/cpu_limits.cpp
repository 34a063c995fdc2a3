// SPDX-License-Identifier: Apache-2.0
// See cpu_limits.h. Sources: manual pages sched_getaffinity(2), proc(5), cgroups(7); the kernel's
// documentation of cpu.max, and of cpu.cfs_quota_us and cpu.cfs_period_us.
#include "base/threads/cpu_limits.h"

#include "base/config.h"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <vector>

namespace sunstone {

namespace {

// A hierarchy of control groups that may limit processor time, as mounted.
struct Hierarchy {
    bool isSecond = false; // version 2
    std::string root;      // of the mount, within the hierarchy
    std::string folder;    // of the mount
};

std::vector<std::string> split(const std::string& text, char separator) {
    std::vector<std::string> parts;
    std::istringstream stream(text);
    for (std::string part; std::getline(stream, part, separator);)
        parts.push_back(part);
    return parts;
}

bool contains(const std::vector<std::string>& list, const char* word) {
    return std::find(list.begin(), list.end(), word) != list.end();
}

// Lines of mountinfo: ... root folder options [optional...] - type source options
std::vector<Hierarchy> hierarchies(const std::string& root) {
    std::vector<Hierarchy> found;
    std::ifstream file(root + "/proc/self/mountinfo");
    for (std::string line; std::getline(file, line);) {
        const std::vector<std::string> words = split(line, ' ');
        const auto mark = std::find(words.begin(), words.end(), "-");
        if (words.size() < 6 || words.end() - mark < 4)
            continue;
        const bool isSecond = mark[1] == "cgroup2";
        if (isSecond || (mark[1] == "cgroup" && contains(split(mark[3], ','), "cpu")))
            found.push_back({isSecond, words[3], words[4]});
    }
    return found;
}

// The path of the process's group. Lines of cgroup: number:controllers:path
std::string groupOf(const Hierarchy& hierarchy, const std::string& root) {
    std::ifstream file(root + "/proc/self/cgroup");
    for (std::string line; std::getline(file, line);) {
        const size_t first = line.find(':'), second = line.find(':', first + 1);
        if (first == std::string::npos || second == std::string::npos)
            continue;
        const std::string controllers = line.substr(first + 1, second - first - 1);
        if (hierarchy.isSecond ? controllers.empty() : contains(split(controllers, ','), "cpu"))
            return line.substr(second + 1);
    }
    return "/";
}

std::optional<double> readNumber(const std::string& path) {
    std::ifstream file(path);
    double value = 0;
    return file >> value ? std::optional(value) : std::nullopt;
}

std::optional<double> quotaIn(const std::string& folder, bool isSecond) {
    std::optional<double> quota, period;
    if (isSecond) {
        std::ifstream file(folder + "/cpu.max");
        std::string first;
        double second = 0;
        if (!(file >> first >> second) || first == "max")
            return std::nullopt;
        quota = std::strtod(first.c_str(), nullptr);
        period = second;
    } else {
        quota = readNumber(folder + "/cpu.cfs_quota_us"); // -1: none
        period = readNumber(folder + "/cpu.cfs_period_us");
    }
    if (!quota || !period || !(*quota > 0) || !(*period > 0))
        return std::nullopt;
    return *quota / *period;
}

// The folders of the group and of its ancestors, as far as they are mounted.
std::vector<std::string> foldersOf(const Hierarchy& hierarchy, const std::string& root) {
    std::string path = groupOf(hierarchy, root);
    if (hierarchy.root != "/" && path.rfind(hierarchy.root, 0) == 0)
        path = path.substr(hierarchy.root.size());
    std::vector<std::string> folders = {root + hierarchy.folder};
    for (const std::string& part : split(path, '/'))
        if (!part.empty())
            folders.push_back(folders.back() + "/" + part);
    return folders;
}

unsigned affinity(unsigned all) {
    for (unsigned size = 1024; size <= 1u << 20; size *= 2) { // larger machines need larger sets
        cpu_set_t* const set = CPU_ALLOC(size);
        const size_t bytes = CPU_ALLOC_SIZE(size);
        const bool isRead = set && sched_getaffinity(0, bytes, set) == 0;
        const unsigned count = isRead ? unsigned(CPU_COUNT_S(bytes, set)) : 0;
        CPU_FREE(set);
        if (isRead)
            return std::max(1u, count);
    }
    return all;
}

} // namespace

std::optional<double> cpuQuota(const std::string& root) {
    std::optional<double> least;
    for (const Hierarchy& hierarchy : hierarchies(root))
        for (const std::string& folder : foldersOf(hierarchy, root))
            if (const auto quota = quotaIn(folder, hierarchy.isSecond))
                least = std::min(least.value_or(*quota), *quota);
    return least;
}

CpuLimit leastLimit(unsigned all, unsigned affinity, std::optional<double> quota) {
    const std::string of = " of " + std::to_string(all) + " processors";
    CpuLimit limit = {std::max(1u, all), "all processors"};
    if (affinity < limit.threads)
        limit = {std::max(1u, affinity), "affinity: " + std::to_string(affinity) + of};
    if (quota && std::ceil(*quota) < limit.threads) {
        char number[32];
        std::snprintf(number, sizeof number, "%.4g", *quota);
        limit = {std::max(1u, unsigned(std::ceil(*quota))),
                 std::string("quota of the control group: ") + number + of};
    }
    return limit;
}

const CpuLimit& cpuLimit() {
    static const auto& limit = *new CpuLimit([] {
        if (const unsigned wish = configNumber(Setting::kThreads, 0))
            return CpuLimit{wish, "SUNSTONE_THREADS"};
        const unsigned all = unsigned(std::max(1L, sysconf(_SC_NPROCESSORS_ONLN)));
        return leastLimit(all, affinity(all), cpuQuota());
    }());
    return limit;
}

} // namespace sunstone
