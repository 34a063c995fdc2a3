// SPDX-License-Identifier: Apache-2.0
// Runs a program with unnamed files as its input and output: they never fill up as pipes do, so the
// program cannot block on them.
#include "api/optixu/process.h"

#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>

namespace sunstone::optixu {
namespace {

class MemoryFile {
public:
    explicit MemoryFile(const char* name) : file_(memfd_create(name, MFD_CLOEXEC)) {}
    ~MemoryFile() {
        if (file_ >= 0)
            close(file_);
    }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;

    int number() const { return file_; }

    bool write(const std::string& text) {
        for (size_t done = 0; done < text.size();) {
            const ssize_t count = ::write(file_, text.data() + done, text.size() - done);
            if (count < 0 && errno == EINTR)
                continue;
            if (count <= 0)
                return false;
            done += size_t(count);
        }
        return lseek(file_, 0, SEEK_SET) == 0;
    }

    std::string read() const {
        std::string text;
        char part[4096];
        for (off_t at = 0;; at = off_t(text.size())) {
            const ssize_t count = pread(file_, part, sizeof(part), at);
            if (count < 0 && errno == EINTR)
                continue;
            if (count <= 0)
                return text;
            text.append(part, size_t(count));
        }
    }

private:
    int file_;
};

int waitFor(pid_t process) {
    int status = 0;
    while (waitpid(process, &status, 0) < 0)
        if (errno != EINTR)
            return -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

} // namespace

Outcome runProcess(const std::vector<std::string>& arguments, const std::string& input) {
    Outcome outcome;
    MemoryFile in("input"), out("output"), errors("errors");
    if (in.number() < 0 || out.number() < 0 || errors.number() < 0 || !in.write(input))
        return outcome;
    std::vector<char*> list;
    for (const std::string& argument : arguments)
        list.push_back(const_cast<char*>(argument.c_str())); // posix_spawnp does not write
    list.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, in.number(), STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&files, out.number(), STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&files, errors.number(), STDERR_FILENO);
    pid_t process = 0;
    const int result = posix_spawnp(&process, list[0], &files, nullptr, list.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    if (result != 0)
        return outcome;
    outcome.started = true;
    outcome.status = waitFor(process);
    outcome.output = out.read();
    outcome.errors = errors.read();
    return outcome;
}

} // namespace sunstone::optixu
