// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace sunstone::tool {

Folders findFolders() {
    std::error_code error;
    std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
    std::filesystem::path lib = self.parent_path().parent_path() / "lib";
    Folders folders;
    if (!error && std::filesystem::exists(lib / "libnvoptix.so.1", error))
        folders.lib = lib.string();
    // In a build tree, then as installed.
    for (const char* cuda : {"cuda", "sunstone/cuda"})
        if (folders.cuda.empty() && std::filesystem::exists(lib / cuda / "libcuda.so.1", error))
            folders.cuda = (lib / cuda).string();
    return folders;
}

namespace {

[[noreturn]] void start(const std::vector<std::string>& command) {
    std::vector<char*> arguments;
    for (const std::string& word : command)
        arguments.push_back(const_cast<char*>(word.c_str())); // execvp does not write
    arguments.push_back(nullptr);
    execvp(arguments[0], arguments.data());
    throw std::runtime_error("run: cannot start " + command[0] + ": " + std::strerror(errno));
}

// A file that exists while the command runs.
class ReportFile {
public:
    ReportFile() {
        path_ = (std::filesystem::temp_directory_path() / "sunstone-check-XXXXXX").string();
        const int file = mkstemp(path_.data());
        if (file < 0)
            throw std::runtime_error("run: cannot make " + path_ + ": " + std::strerror(errno));
        close(file);
    }
    ~ReportFile() { unlink(path_.c_str()); }
    ReportFile(const ReportFile&) = delete;
    ReportFile& operator=(const ReportFile&) = delete;
    const std::string& path() const { return path_; }
    std::string read() const {
        std::ifstream in(path_, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }

private:
    std::string path_;
};

volatile std::sig_atomic_t commandToEnd = 0; // process id

extern "C" void passOn(int signal) {
    kill(pid_t(commandToEnd), signal);
}

// Signals that end this process also end the command. They are blocked until the command exists.
class PassedSignals {
public:
    PassedSignals() {
        sigset_t set;
        sigemptyset(&set);
        for (const int signal : kSignals)
            sigaddset(&set, signal);
        sigprocmask(SIG_BLOCK, &set, &before_);
    }
    void unblock() const { sigprocmask(SIG_SETMASK, &before_, nullptr); }
    void passTo(pid_t command) const {
        commandToEnd = command;
        for (const int signal : kSignals) {
            struct sigaction action = {};
            if (sigaction(signal, nullptr, &action) == 0 && action.sa_handler != SIG_IGN)
                std::signal(signal, passOn);
        }
        unblock();
    }

private:
    static constexpr int kSignals[] = {SIGTERM, SIGHUP};
    sigset_t before_ = {};
};

int runChecked(const RunOptions& options) {
    const ReportFile report;
    std::string what = "memory";
    if (options.leakCheck)
        what += ",leaks";
    if (options.hostMemory)
        what += ",host";
    setenv("SUNSTONE_CHECK", what.c_str(), 1);
    setenv("SUNSTONE_CHECK_REPORT", report.path().c_str(), 1);
    const PassedSignals signals;
    const pid_t child = fork();
    if (child < 0)
        throw std::runtime_error(std::string("run: fork: ") + std::strerror(errno));
    if (child == 0) {
        signals.unblock();
        try {
            start(options.command);
        } catch (const std::exception& error) {
            std::fprintf(stderr, "sunstone: %s\n", error.what());
            _exit(127);
        }
    }
    signals.passTo(child);
    // A terminal sends these signals to both processes, and the command handles them.
    std::signal(SIGINT, SIG_IGN);
    std::signal(SIGQUIT, SIG_IGN);
    int status = 0;
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR)
            throw std::runtime_error(std::string("run: wait: ") + std::strerror(errno));
    if (summarize(report.read(), options))
        return 1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

// Puts a path in front of an environment variable's list.
void putFirst(const char* variable, std::string path) {
    const char* previous = std::getenv(variable);
    if (previous && *previous)
        path += std::string(":") + previous;
    setenv(variable, path.c_str(), 1);
}

} // namespace

int run(const RunOptions& options) {
    const std::vector<std::string>& command = options.command;
    if (command.empty())
        throw std::runtime_error("run: no program given (see sunstone run --help)");
    const char* needing = options.leakCheck      ? "--leak-check"
                          : options.hostMemory   ? "--host-memory"
                          : options.json.empty() ? nullptr
                                                 : "--json";
    if (needing && !options.check)
        throw std::runtime_error(std::string("run: ") + needing + " needs --check");
    Folders folders = findFolders();
    if (folders.lib.empty())
        throw std::runtime_error("run: libnvoptix.so.1 is not in ../lib beside this program");
    std::string path = folders.lib;
    if (!folders.cuda.empty())
        path += ":" + folders.cuda;
    putFirst("LD_LIBRARY_PATH", path);
    // Redirects static CUDA runtimes to libcudart (src/api/cuda/redirect).
    const std::string redirect = folders.cuda + "/libsunstone_redirect.so";
    if (!folders.cuda.empty() && std::filesystem::exists(redirect))
        putFirst("LD_AUDIT", redirect);

    if (options.check)
        return runChecked(options);
    if (runsOnRanks(command))
        return runOnRanks(folders, command);
    start(command);
}

} // namespace sunstone::tool
