// SPDX-License-Identifier: Apache-2.0
// Runs each program in two processes: with empty caches of OptiX and of the driver, then with the
// caches that the first process has filled.
#include "run.h"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>

namespace bench {
namespace {

std::vector<std::string> commandFor(const char* program, const JobKind& kind,
                                    const RunSettings& settings, const std::string& phase) {
    const auto number = [](auto value) { return std::to_string(value); };
    // Frame times do not depend on caches, so one frame with empty caches suffices.
    const unsigned repeats = phase == "cold" ? 0 : settings.repeats;
    return {program,
            "--program",
            kind.name,
            "--label",
            settings.label,
            "--out",
            settings.out,
            "--phase",
            phase,
            "--scale",
            number(settings.job.scale),
            "--width",
            number(settings.job.width),
            "--height",
            number(settings.job.height),
            "--repeats",
            number(repeats),
            "--started",
            number(monotonicNow())};
}

// The child: output to a log, caches in a folder of their own.
[[noreturn]] void become(const std::vector<std::string>& command, const std::string& log,
                         const std::string& cache) {
    setenv("OPTIX_CACHE_PATH", (cache + "/optix").c_str(), 1);
    setenv("CUDA_CACHE_PATH", (cache + "/cuda").c_str(), 1);
    if (!std::freopen(log.c_str(), "w", stdout) || dup2(fileno(stdout), 2) < 0)
        _exit(126);
    std::vector<char*> arguments;
    for (const std::string& word : command)
        arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    execv(arguments[0], arguments.data());
    _exit(127);
}

// Empty if the process succeeded; else a description of its end.
std::string waitFor(pid_t child, unsigned seconds) {
    for (unsigned waited = 0;; waited += 5) {
        int status = 0;
        const pid_t ended = waitpid(child, &status, WNOHANG);
        if (ended < 0)
            return "waitpid failed";
        if (ended == child && WIFEXITED(status))
            return WEXITSTATUS(status) == 0 ? ""
                                            : "exit code " + std::to_string(WEXITSTATUS(status));
        if (ended == child)
            return "signal " + std::to_string(WTERMSIG(status));
        if (waited >= seconds * 1000) {
            kill(child, SIGKILL);
            waitpid(child, &status, 0);
            return "more than " + std::to_string(seconds) + " s";
        }
        usleep(5000);
    }
}

void printEnd(const std::string& log) {
    std::FILE* file = std::fopen(log.c_str(), "r");
    if (!file)
        return;
    std::vector<std::string> lines;
    char line[512];
    while (std::fgets(line, sizeof(line), file))
        lines.emplace_back(line);
    std::fclose(file);
    for (size_t i = lines.size() - std::min<size_t>(lines.size(), 5); i < lines.size(); ++i)
        std::printf("    %s", lines[i].c_str());
}

bool runOnce(const char* program, const JobKind& kind, const RunSettings& settings,
             const std::string& phase, const std::string& cache) {
    const std::string log = resultFile(settings.out, kind.name, settings.label, phase + ".log");
    std::filesystem::remove(resultFile(settings.out, kind.name, settings.label, phase + ".json"));
    const auto command = commandFor(program, kind, settings, phase);
    const pid_t child = fork();
    if (child < 0)
        throw std::runtime_error("fork failed");
    if (child == 0)
        become(command, log, cache);
    const std::string fault = waitFor(child, settings.limit);
    if (fault.empty())
        return true;
    std::printf("%s, %s, %s: %s\n", kind.name, settings.label.c_str(), phase.c_str(),
                fault.c_str());
    printEnd(log);
    std::fflush(stdout);
    return false;
}

} // namespace

int runAll(const char* program, const RunSettings& settings) {
    namespace fs = std::filesystem;
    fs::create_directories(settings.out);
    const long long end = monotonicNow() + settings.seconds * 1'000'000'000LL;
    int failures = 0;
    for (const JobKind& kind : jobKinds()) {
        const auto& names = settings.names;
        const bool isInSet = settings.set == "all" || settings.set == kind.set;
        if (names.empty() ? !isInSet
                          : std::find(names.begin(), names.end(), kind.name) == names.end())
            continue;
        if (monotonicNow() > end) {
            std::printf("%s: not run, the %u s are over\n", kind.name, settings.seconds);
            ++failures;
            continue;
        }
        const std::string cache =
            fs::absolute(resultFile(settings.out, kind.name, settings.label, "cache"));
        fs::remove_all(cache);
        fs::create_directories(cache + "/optix");
        fs::create_directories(cache + "/cuda");
        bool isRight = true;
        for (const char* phase : {"cold", "warm"})
            isRight = isRight && runOnce(program, kind, settings, phase, cache);
        failures += !isRight;
        fs::remove_all(cache);
    }
    return failures;
}

} // namespace bench
