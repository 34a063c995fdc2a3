// SPDX-License-Identifier: Apache-2.0
// The floating-point mode of device code: rounds to nearest, keeps subnormal numbers, and has no
// traps. A program may have another mode in its own threads (fesetround, feenableexcept, programs
// linked with -ffast-math), which the threads that it starts inherit. Compiled code and traversal
// use SSE and AVX instructions alone, so the mode is that of MXCSR.
#pragma once

#include <immintrin.h>

namespace sunstone {

// For threads of the library: the mode of the thread from now on.
inline void setDeviceFloatMode() {
    _mm_setcsr(0x1F80); // the value at program start
}

// For threads of the program: the mode during the object's lifetime.
class DeviceFloatMode {
public:
    DeviceFloatMode() : saved_(_mm_getcsr()) { setDeviceFloatMode(); }
    ~DeviceFloatMode() { _mm_setcsr(saved_); }
    DeviceFloatMode(const DeviceFloatMode&) = delete;
    DeviceFloatMode& operator=(const DeviceFloatMode&) = delete;

private:
    unsigned saved_;
};

} // namespace sunstone
