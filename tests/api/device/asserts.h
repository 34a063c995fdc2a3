// SPDX-License-Identifier: Apache-2.0
// Launch parameters of asserts.cu.
#pragma once

struct AssertParams {
    unsigned* out;
    unsigned limit; // the first launch index whose assertion fails
};
