// SPDX-License-Identifier: Apache-2.0
// Shared by run_test.cpp and its device programs.
#pragma once

struct TestRay {
    float origin[3], tmin;
    float direction[3], tmax;
};

struct TestHit {
    float t, u, v;
    unsigned int primitive; // ~0u: none
    unsigned int asked;     // how often the any-hit program ran
};

struct TestParams {
    const TestRay* rays;
    TestHit* hits;
    unsigned long long handle;
    unsigned int flags; // of the rays
};
