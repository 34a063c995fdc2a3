// SPDX-License-Identifier: Apache-2.0
// Processor limits: artificial control group folders, and the affinity of this process.
#include "base/threads/cpu_limits.h"

#include "base/error.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include <unistd.h>

namespace sunstone {
namespace {

namespace fs = std::filesystem;

// A folder with the files that the kernel would have.
class FakeSystem {
public:
    FakeSystem() : root_(fs::path(testing::TempDir()) / message("sunstone_cpu_limits_", getpid())) {
        fs::remove_all(root_);
    }
    ~FakeSystem() { fs::remove_all(root_); }
    void write(const std::string& path, const std::string& text) {
        const fs::path file = root_ / path;
        fs::create_directories(file.parent_path());
        std::ofstream(file) << text;
    }
    std::optional<double> quota() const { return cpuQuota(root_.string()); }

private:
    fs::path root_;
};

constexpr const char* kSecond =
    "25 1 0:22 / /proc rw - proc proc rw\n"
    "30 25 0:26 / /sys/fs/cgroup rw,nosuid shared:4 - cgroup2 cgroup2 rw,nsdelegate\n";
constexpr const char* kFirst =
    "31 25 0:27 /docker/1f /sys/fs/cgroup/cpu,cpuacct ro - cgroup cgroup rw,cpu,cpuacct\n"
    "32 25 0:28 /docker/1f /sys/fs/cgroup/memory ro - cgroup cgroup rw,memory\n";

TEST(CpuQuota, OfVersion2) {
    FakeSystem system;
    EXPECT_FALSE(system.quota()) << "no /proc";
    system.write("proc/self/mountinfo", kSecond);
    system.write("proc/self/cgroup", "0::/user.slice/job.scope\n");
    EXPECT_FALSE(system.quota()) << "no cpu.max";
    system.write("sys/fs/cgroup/user.slice/job.scope/cpu.max", "max 100000\n");
    EXPECT_FALSE(system.quota());
    system.write("sys/fs/cgroup/user.slice/job.scope/cpu.max", "250000 100000\n");
    EXPECT_EQ(2.5, system.quota());
    system.write("sys/fs/cgroup/user.slice/cpu.max", "150000 100000\n");
    EXPECT_EQ(1.5, system.quota()) << "the group around it has less";
    system.write("sys/fs/cgroup/user.slice/cpu.max", "rubbish\n");
    EXPECT_EQ(2.5, system.quota());
}

// In a container with its own view the group is the root.
TEST(CpuQuota, OfAContainer) {
    FakeSystem system;
    system.write("proc/self/mountinfo", kSecond);
    system.write("proc/self/cgroup", "0::/\n");
    system.write("sys/fs/cgroup/cpu.max", "50000 100000\n");
    EXPECT_EQ(0.5, system.quota());
}

TEST(CpuQuota, OfVersion1) {
    FakeSystem system;
    system.write("proc/self/mountinfo", kFirst);
    system.write("proc/self/cgroup", "4:memory:/docker/1f\n3:cpu,cpuacct:/docker/1f/inner\n");
    const std::string folder = "sys/fs/cgroup/cpu,cpuacct/";
    system.write(folder + "cpu.cfs_period_us", "100000\n");
    system.write(folder + "cpu.cfs_quota_us", "-1\n");
    EXPECT_FALSE(system.quota());
    system.write(folder + "cpu.cfs_quota_us", "400000\n");
    EXPECT_EQ(4.0, system.quota());
    system.write(folder + "inner/cpu.cfs_period_us", "50000\n");
    system.write(folder + "inner/cpu.cfs_quota_us", "100000\n");
    EXPECT_EQ(2.0, system.quota());
}

TEST(CpuLimit, TheLeastCounts) {
    const auto text = [](unsigned all, unsigned affinity, std::optional<double> quota) {
        const CpuLimit limit = leastLimit(all, affinity, quota);
        return std::to_string(limit.threads) + " " + limit.reason;
    };
    EXPECT_EQ("16 all processors", text(16, 16, {}));
    EXPECT_EQ("3 affinity: 3 of 16 processors", text(16, 3, {}));
    EXPECT_EQ("3 affinity: 3 of 16 processors", text(16, 3, 8.0));
    EXPECT_EQ("2 quota of the control group: 1.5 of 16 processors", text(16, 3, 1.5));
    EXPECT_EQ("1 quota of the control group: 0.05 of 16 processors", text(16, 16, 0.05));
    EXPECT_EQ("16 all processors", text(16, 16, 64.0));
}

} // namespace
} // namespace sunstone
