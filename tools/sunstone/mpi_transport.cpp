// SPDX-License-Identifier: Apache-2.0
// See transport.h.
#include "transport.h"

#include <mpi.h>

#include <algorithm>
#include <cstring>
#include <list>
#include <vector>

namespace {

constexpr int kTag = 1;

struct Sending {
    std::vector<char> bytes;
    MPI_Request request;
};
std::list<Sending>& sendings() {
    static auto* const list = new std::list<Sending>;
    return *list;
}

void dropSent() {
    sendings().remove_if([](Sending& sending) {
        int done = 0;
        return MPI_Test(&sending.request, &done, MPI_STATUS_IGNORE) != MPI_SUCCESS || done;
    });
}

bool send(int rank, const void* data, size_t size) {
    dropSent();
    Sending& sending = sendings().emplace_back();
    sending.bytes.assign(static_cast<const char*>(data), static_cast<const char*>(data) + size);
    if (MPI_Isend(sending.bytes.data(), int(size), MPI_BYTE, rank, kTag, MPI_COMM_WORLD,
                  &sending.request) == MPI_SUCCESS)
        return true;
    sendings().pop_back();
    return false;
}

bool receive(int* rank, const void** data, size_t* size) {
    static auto* const bytes = new std::vector<char>;
    int has = 0, count = 0;
    MPI_Status status;
    if (MPI_Iprobe(MPI_ANY_SOURCE, kTag, MPI_COMM_WORLD, &has, &status) != MPI_SUCCESS || !has ||
        MPI_Get_count(&status, MPI_BYTE, &count) != MPI_SUCCESS)
        return false;
    bytes->resize(size_t(std::max(count, 0)));
    if (MPI_Recv(bytes->data(), count, MPI_BYTE, status.MPI_SOURCE, kTag, MPI_COMM_WORLD,
                 MPI_STATUS_IGNORE) != MPI_SUCCESS)
        return false;
    *rank = status.MPI_SOURCE;
    *data = bytes->data();
    *size = bytes->size();
    return true;
}

size_t pending() {
    dropSent();
    size_t bytes = 0;
    for (const Sending& sending : sendings())
        bytes += sending.bytes.size();
    return bytes;
}

void close() {
    MPI_Finalize();
}

} // namespace

extern "C" __attribute__((visibility("default"))) const SunstoneTransport*
sunstone_open_transport() {
    static SunstoneTransport transport{0, 1, send, receive, pending, close};
    if (MPI_Init(nullptr, nullptr) != MPI_SUCCESS)
        return nullptr;
    MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
    MPI_Comm_rank(MPI_COMM_WORLD, &transport.rank);
    MPI_Comm_size(MPI_COMM_WORLD, &transport.size);
    return &transport;
}
