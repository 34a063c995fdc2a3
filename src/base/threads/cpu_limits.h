// SPDX-License-Identifier: Apache-2.0
// The number of processors that this process may use: its affinity (taskset, cpusets) and the quota
// of its control groups, of version 1 and 2 (docker --cpus, systemd's CPUQuota, Kubernetes limits).
#pragma once

#include <optional>
#include <string>

namespace sunstone {

struct CpuLimit {
    unsigned threads = 1; // at least 1
    std::string reason;   // text for users
};

// From SUNSTONE_THREADS, else the least of the limits. The first call decides.
const CpuLimit& cpuLimit();

// The smallest quota of the calling process's control group and its ancestors, in processors; none
// if there is no quota. `root` is a prefix of the paths of /proc.
std::optional<double> cpuQuota(const std::string& root = "");

// The smallest limit; `affinity` and `all` are numbers of processors.
CpuLimit leastLimit(unsigned all, unsigned affinity, std::optional<double> quota);

} // namespace sunstone
