// SPDX-License-Identifier: Apache-2.0
// Remote devices: a remote device reserves some of the run's ranks. This process is rank 0; it
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
    std::vector<uint32_t> nodes; // reserved; may include rank 0
};

// Throws RT_ERROR_CLUSTER_NOT_RUNNING if the device is destroyed or has no reserved node.
std::vector<uint32_t> reservedNodes(const Ref<RemoteDevice>& device);

} // namespace sunstone::optix6
