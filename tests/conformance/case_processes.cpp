// SPDX-License-Identifier: Apache-2.0
#include "case_processes.h"

#include <atomic>
#include <cstring>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

namespace conformance {

namespace {

struct Shared {
    char device[200];
    std::atomic<size_t> next; // case
};

[[noreturn]] void work(const std::vector<std::string>& names, const std::string& only,
                       const CaseSetup& setup, Shared& shared, Status* status) {
    const Driver driver;
    std::strncpy(shared.device, driver.describe().c_str(), sizeof shared.device - 1);
    const std::function<bool(size_t)> run = setup(driver);
    for (size_t i = shared.next++; i < names.size(); i = shared.next++) {
        if (names[i].find(only) == std::string::npos)
            continue;
        status[i] = Status::kCrashed; // until it is known better
        status[i] = run(i) ? Status::kDone : Status::kRefused;
    }
    _exit(0);
}

} // namespace

void* shareMemory(size_t bytes) {
    void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED)
        quit(1, "no memory for results");
    return memory;
}

CaseOutcomes runCases(const std::vector<std::string>& names, const std::string& only,
                      unsigned workers, const char* what, const CaseSetup& setup) {
    auto* shared = share<Shared>(1);
    auto* status = share<Status>(names.size());
    while (shared->next < names.size()) {
        const size_t before = shared->next;
        std::vector<pid_t> children(workers);
        for (pid_t& child : children) {
            child = fork();
            if (child == 0)
                work(names, only, setup, *shared, status);
        }
        int state = 0;
        for (const pid_t child : children)
            waitpid(child, &state, 0);
        if (shared->next == before) // they could not start
            quit(WIFEXITED(state) ? WEXITSTATUS(state) : 1, std::string("no device for ") + what);
    }
    return {shared->device, std::vector<Status>(status, status + names.size())};
}

} // namespace conformance
