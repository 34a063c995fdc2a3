// SPDX-License-Identifier: Apache-2.0
// See compiler.h.
#include "api/nvrtc/compiler.h"

#include "base/config.h"
#include "base/error.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace sunstone::nvrtc {

namespace {

namespace fs = std::filesystem;

constexpr int kLeastClang = 19;
// Compilations beyond these limits are stopped, so that calls end.
constexpr rlim_t kMostSeconds = 600, kMostBytes = rlim_t(16) << 30;

std::string findInPath(const std::string& name) {
    const char* path = std::getenv("PATH");
    std::string folders = path ? path : "/usr/local/bin:/usr/bin:/bin";
    folders += ":/usr/lib/llvm-19/bin";
    for (size_t begin = 0; begin <= folders.size();) {
        const size_t end = std::min(folders.find(':', begin), folders.size());
        const std::string candidate = folders.substr(begin, end - begin) + "/" + name;
        if (end > begin && access(candidate.c_str(), X_OK) == 0)
            return candidate;
        begin = end + 1;
    }
    return "";
}

int versionOf(const std::string& clang) {
    const TemporaryFolder folder;
    const ChildResult result = runChild({clang, "-dumpversion"}, folder.path());
    return result.started ? std::atoi(result.output.c_str()) : 0;
}

// Searches the installed library's folder, the build tree's, and that of the program nvcc.
std::string findHeaders() {
    Dl_info info;
    std::error_code error;
    if (!dladdr(reinterpret_cast<const void*>(&compiler), &info) || !info.dli_fname)
        return "";
    // The name of a program may be a result of the shell's search.
    fs::path file = info.dli_fname;
    if (!file.has_parent_path() || !fs::exists(file, error))
        file = "/proc/self/exe";
    const fs::path folder = fs::canonical(file, error).parent_path();
    for (const char* place : {"../../../include/sunstone/cuda", "include", "../include"})
        if (fs::exists(folder / place / "cuda_runtime.h", error))
            return fs::canonical(folder / place, error).string();
    return "";
}

Compiler findCompiler() {
    Compiler found;
    found.headers = findHeaders();
    if (found.headers.empty()) {
        found.fault = "Sunstone's CUDA headers are missing: install its component \"sdk\"";
        return found;
    }
    const std::string& chosen = config(Setting::kClang);
    const std::vector<std::string> names =
        chosen.empty()
            ? std::vector<std::string>{"clang++-19", "clang++-20", "clang++-21", "clang++"}
            : std::vector<std::string>{chosen};
    for (const std::string& name : names) {
        const std::string path = name.find('/') == std::string::npos ? findInPath(name) : name;
        if (!path.empty() && versionOf(path) >= kLeastClang) {
            found.path = path;
            return found;
        }
    }
    found.fault =
        chosen.empty()
            ? "no clang++ of version 19 or later is in PATH: install clang-19 or set "
              "SUNSTONE_CLANG to its path"
            : message("SUNSTONE_CLANG=\"", chosen, "\" is no clang++ of version 19 or later");
    return found;
}

// Without the libraries that `sunstone run` and sanitizers load into processes.
std::vector<char*> childEnvironment() {
    std::vector<char*> list;
    for (char** entry = environ; entry && *entry; ++entry) {
        const std::string text = *entry;
        bool isDropped = false;
        for (const char* name : {"LD_AUDIT=", "LD_PRELOAD=", "LD_LIBRARY_PATH=", "CPATH=",
                                 "CPLUS_INCLUDE_PATH=", "CCC_OVERRIDE_OPTIONS="})
            isDropped |= text.starts_with(name);
        if (!isDropped)
            list.push_back(*entry);
    }
    list.push_back(nullptr);
    return list;
}

void limit(pid_t child, rlim_t seconds, rlim_t bytes) {
    const rlimit time{seconds, seconds}, memory{bytes, bytes};
    prlimit(child, RLIMIT_CPU, &time, nullptr);
    prlimit(child, RLIMIT_AS, &memory, nullptr);
}

// -1 if another part of the process has reaped the child.
int waitFor(pid_t child) {
    int status = 0;
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR)
            return -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

} // namespace

ChildResult runChild(const std::vector<std::string>& command, const std::string& folder) {
    std::vector<char*> arguments;
    for (const std::string& word : command)
        arguments.push_back(const_cast<char*>(word.c_str())); // posix_spawn does not write
    arguments.push_back(nullptr);
    std::vector<char*> environment = childEnvironment();
    const std::string file = folder + "/output.txt";
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 1, file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_adddup2(&actions, 1, 2);
    // Signals that the application blocks or ignores have their usual effect.
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &all);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    pid_t child = 0;
    const int error = posix_spawn(&child, arguments[0], &actions, &attributes, arguments.data(),
                                  environment.data());
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    ChildResult result;
    if (error) {
        result.output = message("cannot start ", command[0], ": ", std::strerror(error), "\n");
        return result;
    }
    result.started = true;
    limit(child, kMostSeconds, kMostBytes);
    result.code = waitFor(child);
    std::ifstream in(file, std::ios::binary);
    result.output.assign(std::istreambuf_iterator<char>(in), {});
    return result;
}

TemporaryFolder::TemporaryFolder() {
    std::error_code error;
    fs::path base = fs::temp_directory_path(error);
    path_ = ((error ? fs::path("/tmp") : base) / "sunstone-nvrtc-XXXXXX").string();
    if (!mkdtemp(path_.data()))
        fail(Code::kFileError, "cannot make ", path_, ": ", std::strerror(errno));
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code error;
    fs::remove_all(path_, error);
}

const Compiler& compiler() {
    static const auto& found = *new Compiler(findCompiler());
    return found;
}

} // namespace sunstone::nvrtc
