// SPDX-License-Identifier: Apache-2.0
// The plug-in of `sunstone run` for MPI, libsunstone_mpi.so: the only code that includes MPI. MPI
// implementations have different binary interfaces, so the plug-in is built on the machine of the
// MPI that it uses, and is missing where there is none.
#pragma once

#include <cstddef>

extern "C" {
struct SunstoneTransport {
    int rank, size;
    // Queues a copy of the bytes. False: the other rank cannot be reached.
    bool (*send)(int rank, const void* data, size_t size);
    // A message that has come: its bytes, until the next call. False: there is none.
    bool (*receive)(int* rank, const void** data, size_t* size);
    size_t (*pending)(); // bytes that are queued and have not left
    void (*close)();     // waits for all ranks
};
// Null: MPI does not start.
const SunstoneTransport* sunstone_open_transport();
}
