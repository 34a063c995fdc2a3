// SPDX-License-Identifier: Apache-2.0
// The areas of log lines (log.h), which SUNSTONE_LOG selects.
#pragma once

#include <string_view>

namespace sunstone {

// The areas of all lines. tests/rules/areas.cmake compares the list with the calls.
inline constexpr std::string_view kLogAreas[] = {"base",   "bvh",   "compiler", "cuda",   "device",
                                                 "engine", "nvrtc", "optix6",   "optix7", "optixu",
                                                 "prime",  "rays",  "texture"};

} // namespace sunstone
