// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
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

int run(const std::vector<std::string>& command) {
    if (command.empty())
        throw std::runtime_error("run: no program given (see sunstone run --help)");
    Folders folders = findFolders();
    if (folders.lib.empty())
        throw std::runtime_error("run: libnvoptix.so.1 is not in ../lib beside this program");
    std::string path = folders.lib;
    if (!folders.cuda.empty())
        path += ":" + folders.cuda;
    const char* previous = std::getenv("LD_LIBRARY_PATH");
    if (previous && *previous)
        path += std::string(":") + previous;
    setenv("LD_LIBRARY_PATH", path.c_str(), 1);

    std::vector<char*> arguments;
    for (const std::string& word : command)
        arguments.push_back(const_cast<char*>(word.c_str())); // execvp does not write
    arguments.push_back(nullptr);
    execvp(arguments[0], arguments.data());
    throw std::runtime_error("run: cannot start " + command[0] + ": " + std::strerror(errno));
}

} // namespace sunstone::tool
