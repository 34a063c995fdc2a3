// SPDX-License-Identifier: Apache-2.0
// Inputs and results of the device program of footprints.cu.
#pragma once

namespace differential {

enum FootprintForm : unsigned { kPlain, kLod, kGrad };

struct FootprintCall {
    unsigned long long texture;
    unsigned info, form, coarse;
    float x, y, level, dx[2], dy[2]; // dx: how x and y change along the first axis of the picture
};

struct FootprintSeen {
    unsigned words[4], single;
};

struct FootprintParams {
    const FootprintCall* calls;
    FootprintSeen* seen;
};

} // namespace differential
