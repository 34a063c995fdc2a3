// SPDX-License-Identifier: Apache-2.0
#pragma once

struct Params {
    unsigned int* image;
};
