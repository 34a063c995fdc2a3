// SPDX-License-Identifier: Apache-2.0
// Data that the host passes to the device program at each launch.
#pragma once

struct Params {
    float4* image; // width * height pixels, top row first
};
