// SPDX-License-Identifier: Apache-2.0
// `mpirun -n N sunstone run PROGRAM`, where PROGRAM uses the classic API. The `sunstone run` of
// each rank starts one process: on rank 0 the program, on other ranks a node, which renders
// subframes of the program's progressive launches (src/api/optix6/remote/node.cpp). `sunstone run`
// passes frames between this process's socket and MPI, so neither the program nor the library uses
// MPI. If a node dies, its rank lives on and reports the death; otherwise mpirun would end all
// ranks.
#include "api/optix6/remote/channel.h"
#include "api/optix6/remote/frame.h"
#include "commands.h"
#include "elf_needs.h"
#include "transport.h"

#include <dlfcn.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <utility>

namespace sunstone::tool {

namespace {

constexpr const char* kPlugin = "libsunstone_mpi.so";
// Values of FrameHeader::isLast in frames between the `sunstone run` of rank 0 and that of another
// rank: the program has ended; and the reply, which is the other rank's last frame.
constexpr uint32_t kQuit = 2, kGone = 3;
constexpr size_t kMostPending = 64 << 20; // bytes; a program that sends more waits
constexpr int kSecondsToEnd = 20;
constexpr int kIdleMilliseconds = 2;

volatile std::sig_atomic_t gSignal = 0;

int numberOf(const char* variable) {
    const char* const value = std::getenv(variable);
    return value && *value ? std::atoi(value) : -1;
}

// The rank and the number of ranks, from the environment of MPI launchers; size 1: no launcher.
struct Place {
    int rank = 0, size = 1, localRank = 0;
};
Place placeOfProcess() {
    static constexpr const char* kVariables[][3] = {
        {"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_LOCAL_RANK"},
        {"PMI_RANK", "PMI_SIZE", "MPI_LOCALRANKID"},
        {"MV2_COMM_WORLD_RANK", "MV2_COMM_WORLD_SIZE", "MV2_COMM_WORLD_LOCAL_RANK"}};
    for (const auto& [rank, size, local] : kVariables)
        if (numberOf(rank) >= 0 && numberOf(size) > 0)
            return {numberOf(rank), numberOf(size), std::max(0, numberOf(local))};
    return {};
}

// The child of a rank and the socket to it.
class Relay {
public:
    Relay(pid_t child, int socket, const SunstoneTransport& transport)
        : child_(child), socket_(socket), mpi_(transport) {}
    // Relays until the program has ended; returns its exit code.
    int run();

private:
    bool isApplication() const { return mpi_.rank == 0; }
    void sendFrame(uint32_t rank, uint32_t mark, const void* data, size_t size);
    bool readSocket();
    bool readTransport();
    void writeSocket();
    void reap();
    void finish();

    const pid_t child_;
    int socket_; // -1: closed
    const SunstoneTransport& mpi_;
    std::string in_, out_; // of the socket: incomplete frames, bytes not written yet
    size_t written_ = 0;
    bool hasEnded_ = false, isOver_ = false;
    int status_ = 0, gone_ = 0;
};

void Relay::sendFrame(uint32_t rank, uint32_t mark, const void* data, size_t size) {
    const FrameHeader header{rank, uint32_t(size), mark};
    std::string bytes(reinterpret_cast<const char*>(&header), sizeof header);
    bytes.append(static_cast<const char*>(data), size);
    mpi_.send(int(rank), bytes.data(), bytes.size());
}

// Returns whether there were bytes.
bool Relay::readSocket() {
    if (socket_ < 0 || mpi_.pending() > kMostPending)
        return false;
    char part[1 << 16];
    bool any = false;
    for (;;) {
        const ssize_t got = recv(socket_, part, sizeof part, MSG_DONTWAIT);
        if (got <= 0)
            break;
        any = true;
        in_.append(part, size_t(got));
        if (in_.size() > kMostFrameBytes)
            break; // on to MPI
    }
    size_t at = 0;
    FrameHeader header;
    while (in_.size() - at >= sizeof header) {
        std::memcpy(&header, in_.data() + at, sizeof header);
        if (in_.size() - at - sizeof header < header.size)
            break;
        if (header.rank < unsigned(mpi_.size) && header.rank != unsigned(mpi_.rank))
            sendFrame(header.rank, header.isLast, in_.data() + at + sizeof header, header.size);
        at += sizeof header + header.size;
    }
    in_.erase(0, at);
    return any;
}

bool Relay::readTransport() {
    int from = 0;
    const void* data = nullptr;
    size_t size = 0;
    if (!mpi_.receive(&from, &data, &size) || size < sizeof(FrameHeader))
        return false;
    FrameHeader header;
    std::memcpy(&header, data, sizeof header);
    if (header.isLast == kQuit || header.isLast == kGone) {
        isOver_ = true;
        ++gone_;
        return true;
    }
    if (socket_ < 0)
        return true; // for a node that has died
    header.rank = uint32_t(from);
    out_.append(reinterpret_cast<const char*>(&header), sizeof header);
    out_.append(static_cast<const char*>(data) + sizeof header, size - sizeof header);
    return true;
}

void Relay::writeSocket() {
    while (socket_ >= 0 && written_ < out_.size()) {
        const ssize_t sent = ::send(socket_, out_.data() + written_, out_.size() - written_,
                                    MSG_DONTWAIT | MSG_NOSIGNAL);
        if (sent <= 0)
            return;
        written_ += size_t(sent);
    }
    out_.clear();
    written_ = 0;
}

// Handles the end of the child.
void Relay::reap() {
    if (hasEnded_ || waitpid(child_, &status_, WNOHANG) != child_)
        return;
    while (readSocket()) {
    }
    hasEnded_ = true;
    close(socket_);
    socket_ = -1;
    out_.clear();
    written_ = 0;
    if (isApplication()) {
        isOver_ = true;
        return;
    }
    if (isOver_)
        return;
    const std::string cause = WIFSIGNALED(status_)
                                  ? std::string("signal ") + std::to_string(WTERMSIG(status_)) +
                                        ", " + strsignal(WTERMSIG(status_))
                                  : "exit code " + std::to_string(WEXITSTATUS(status_));
    std::fprintf(stderr, "sunstone: the node of rank %d has died: %s\n", mpi_.rank, cause.c_str());
    const std::string news = char(optix6::MessageKind::kDied) + cause;
    sendFrame(0, 1, news.data(), news.size());
}

// Ends the other ranks, or this rank's node. MPI may end only when no message is in flight.
void Relay::finish() {
    if (!isApplication() && !hasEnded_) {
        close(socket_);
        socket_ = -1;
        kill(child_, SIGKILL);
        waitpid(child_, &status_, 0);
    }
    gone_ = 0;
    const int others = isApplication() ? mpi_.size - 1 : 0;
    if (!isApplication())
        sendFrame(0, kGone, nullptr, 0);
    for (int rank = 1; rank <= others; ++rank)
        sendFrame(uint32_t(rank), kQuit, nullptr, 0);
    for (int waited = 0; waited < kSecondsToEnd * 1000 && (mpi_.pending() > 0 || gone_ < others);
         waited += kIdleMilliseconds) {
        while (readTransport()) {
        }
        usleep(kIdleMilliseconds * 1000);
    }
    mpi_.close();
}

int Relay::run() {
    while (!isOver_) {
        bool any = readSocket();
        while (readTransport())
            any = true;
        writeSocket();
        reap();
        if (gSignal != 0)
            kill(child_, std::exchange(gSignal, 0));
        if (any || isOver_)
            continue;
        pollfd waiting{socket_, short(POLLIN | (out_.empty() ? 0 : POLLOUT)), 0};
        poll(&waiting, socket_ < 0 ? 0 : 1, kIdleMilliseconds);
    }
    finish();
    if (!isApplication())
        return 0;
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
}

[[noreturn]] void startChild(int socket, pid_t parent, const Place& place,
                             const std::vector<std::string>& command) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    std::vector<std::string> words = command;
    if (place.rank == 0) {
        const std::string value = std::to_string(socket) + ":" + std::to_string(place.size) + ":" +
                                  std::to_string(parent);
        setenv("SUNSTONE_RANKS", value.c_str(), 1);
        // Processes that the program starts are not ranks.
        for (const char* variable : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MV2_COMM_WORLD_SIZE"})
            unsetenv(variable);
    } else {
        words = {"/proc/self/exe", "node", std::to_string(socket), std::to_string(place.localRank)};
    }
    std::vector<char*> arguments;
    for (const std::string& word : words)
        arguments.push_back(const_cast<char*>(word.c_str())); // execvp does not write
    arguments.push_back(nullptr);
    execvp(arguments[0], arguments.data());
    std::fprintf(stderr, "sunstone: run: cannot start %s: %s\n", words[0].c_str(),
                 std::strerror(errno));
    _exit(127);
}

bool startsWith(const std::string& text, const char* start) {
    return text.rfind(start, 0) == 0;
}

} // namespace

bool runsOnRanks(const std::vector<std::string>& command) {
    if (placeOfProcess().size < 2)
        return false;
    bool isClassic = false;
    for (const std::string& library : librariesOf(command[0])) {
        if (startsWith(library, "libmpi"))
            return false; // it has ranks of its own
        isClassic |= startsWith(library, "liboptix.so");
    }
    return isClassic;
}

int runOnRanks(const Folders& folders, const std::vector<std::string>& command) {
    int sockets[2];
    if (socketpair(AF_UNIX, SOCK_STREAM, 0, sockets) != 0)
        throw std::runtime_error(std::string("run: socketpair: ") + std::strerror(errno));
    const Place place = placeOfProcess();
    const pid_t parent = getpid();
    // The fork must precede MPI's threads.
    const pid_t child = fork();
    if (child < 0)
        throw std::runtime_error(std::string("run: fork: ") + std::strerror(errno));
    if (child == 0) {
        close(sockets[0]);
        startChild(sockets[1], parent, place, command);
    }
    close(sockets[1]);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2})
        std::signal(signal, [](int number) { gSignal = number; });
    const std::string file = folders.lib + "/" + kPlugin;
    void* const plugin = dlopen(file.c_str(), RTLD_NOW | RTLD_GLOBAL);
    const char* const fault = plugin ? nullptr : dlerror();
    const auto open = plugin ? reinterpret_cast<const SunstoneTransport* (*)()>(
                                   dlsym(plugin, "sunstone_open_transport"))
                             : nullptr;
    const SunstoneTransport* const transport = open ? open() : nullptr;
    if (!transport) {
        kill(child, SIGKILL);
        waitpid(child, nullptr, 0);
        throw std::runtime_error("run: rank " + std::to_string(place.rank) + " of " +
                                 std::to_string(place.size) +
                                 " has no MPI: " + (fault ? fault : file + " does not start it"));
    }
    return Relay(child, sockets[0], *transport).run();
}

int serveNode(int socket, unsigned device) {
    const Folders folders = findFolders();
    void* const library = dlopen((folders.lib + "/liboptix.so.6.0.0").c_str(), RTLD_NOW);
    const auto serve =
        library ? reinterpret_cast<void (*)(int, unsigned)>(dlsym(library, "sunstone_serve_node"))
                : nullptr;
    if (!serve)
        throw std::runtime_error(std::string("node: ") + (library ? "an old library" : dlerror()));
    serve(socket, device);
    return 0;
}

} // namespace sunstone::tool
