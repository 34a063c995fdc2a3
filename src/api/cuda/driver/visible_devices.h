// SPDX-License-Identifier: Apache-2.0
// CUDA_VISIBLE_DEVICES for the one device of this library. A GPU's driver reads the variable
// itself. Source: CUDA programming guide, environment variables.
#pragma once

#include <string_view>

namespace sunstone::api::cuda {

constexpr char kDeviceUuid[17] = "sunstone-cpu-000"; // 16 bytes

// Whether a program sees the device under this value of the variable: a list of device numbers and
// of "GPU-" with the first digits of a UUID. The list ends before the first entry that names no
// device.
bool showsDevice(std::string_view list);

} // namespace sunstone::api::cuda
