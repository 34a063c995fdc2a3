// SPDX-License-Identifier: Apache-2.0
// Addresses reserved and memory mapped there (cuMemAddressReserve, cuMemCreate, cuMemMap).
#pragma once

#include "api/cuda/driver/shell.h"

namespace sunstone::api::cuda {

// The reserved range that holds an address; size 0: none.
struct AddressRange {
    uintptr_t base = 0;
    size_t size = 0;
};
AddressRange reservationOf(CUdeviceptr address);

} // namespace sunstone::api::cuda
