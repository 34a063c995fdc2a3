// SPDX-License-Identifier: Apache-2.0
// Shared by the host and the device side of launch.cu.
#pragma once

struct LaunchSeen {
    unsigned runs;
    unsigned index[3];
    unsigned size[3];
    unsigned record;
    unsigned tail;
};

struct LaunchParams {
    LaunchSeen* seen;
    unsigned long long handle;
    unsigned missIndex;
    unsigned hitIndex;
    unsigned tail[4];
};
