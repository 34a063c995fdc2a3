// SPDX-License-Identifier: Apache-2.0
// Virtual memory management: reserving addresses and mapping memory (cuMemAddressReserve,
// cuMemCreate, cuMemMap).
#pragma once

#include "api/cuda/driver/shell.h"

namespace sunstone::api::cuda {

// The reserved range that contains an address; size 0: none.
struct AddressRange {
    uintptr_t base = 0;
    size_t size = 0;
};
AddressRange reservationOf(CUdeviceptr address);

} // namespace sunstone::api::cuda
