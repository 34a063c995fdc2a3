// SPDX-License-Identifier: Apache-2.0
// Frames on the sockets between a program and the `sunstone run` of its rank: a header, then the
// number of bytes that it states. tools/sunstone/ranks.cpp forwards them unread.
#pragma once

#include <cstdint>

namespace sunstone {

struct FrameHeader {
    uint32_t rank; // destination or source of the frame
    uint32_t size; // of the bytes that follow
    uint32_t isLast;
};
constexpr uint32_t kMostFrameBytes = 4 << 20;

} // namespace sunstone
