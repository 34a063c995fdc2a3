// SPDX-License-Identifier: Apache-2.0
// The plug-in of `sunstone run` for MPI, libsunstone_mpi.so, is the only code that includes MPI.
// MPI implementations have different ABIs, so the plug-in is built on the machine of the MPI that
// it uses, and only if there is an MPI.
#pragma once

#include <cstddef>

extern "C" {
struct SunstoneTransport {
    int rank, size;
    // Queues a copy of the bytes. False: the other rank cannot be reached.
    bool (*send)(int rank, const void* data, size_t size);
    // Receives a message; its bytes are valid until the next call. False: there is none.
    bool (*receive)(int* rank, const void** data, size_t* size);
    size_t (*pending)(); // queued bytes that are not sent
    void (*close)();     // waits for all ranks
};
// Null if MPI cannot start.
const SunstoneTransport* sunstone_open_transport();
}
