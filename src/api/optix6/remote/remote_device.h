// SPDX-License-Identifier: Apache-2.0
// Remote devices: the ranks of the run, of which a device reserves some. This process is rank 0; it
// takes part in every launch.
#pragma once

#include "api/optix6/object.h"

#include <vector>

namespace sunstone::optix6 {

class RemoteDevice : public Object {
public:
    static constexpr Kind kKind = Kind::kRemoteDevice;
    explicit RemoteDevice(std::string url_) : Object(kKind, nullptr), url(std::move(url_)) {}
    const std::string url;
    std::vector<uint32_t> nodes; // that are reserved; rank 0 may be one
};

// Throws RT_ERROR_CLUSTER_NOT_RUNNING: the device is destroyed or has reserved none.
std::vector<uint32_t> reservedNodes(const Ref<RemoteDevice>& device);

} // namespace sunstone::optix6
