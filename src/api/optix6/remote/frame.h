// SPDX-License-Identifier: Apache-2.0
// Frames on the sockets between a program and the `sunstone run` of its rank: a header and that
// many bytes. tools/sunstone/ranks.cpp passes them on without a look at what is in them.
#pragma once

#include <cstdint>

namespace sunstone {

struct FrameHeader {
    uint32_t rank; // to which the frame goes, or from which it comes
    uint32_t size; // of the bytes that follow
    uint32_t isLast;
};
constexpr uint32_t kMostFrameBytes = 4 << 20;

} // namespace sunstone
