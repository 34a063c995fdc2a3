// SPDX-License-Identifier: Apache-2.0
// Vectors of size_t, the indices of buffers. Vectors of int and unsigned int convert to them, so
// that a launch index is an index; they convert to vectors of unsigned int. Source: OptiX 6.0 API
// reference, section 8.24.
#ifndef SUNSTONE_OPTIX6_SIZET_H
#define SUNSTONE_OPTIX6_SIZET_H

#include "optix_declarations.h"
#include "optix_defines.h"

#ifndef __CUDACC_RTC__
#include <vector_types.h>
#endif

namespace optix {

typedef optix_size_t size_t1;

struct size_t2 {
    optix_size_t x, y;
    RT_HOSTDEVICE size_t2() {}
    RT_HOSTDEVICE size_t2(optix_size_t x_, optix_size_t y_) : x(x_), y(y_) {}
    RT_HOSTDEVICE size_t2(uint2 v) : x(v.x), y(v.y) {}
    RT_HOSTDEVICE size_t2(int2 v) : x(optix_size_t(v.x)), y(optix_size_t(v.y)) {}
    RT_HOSTDEVICE operator uint2() const {
        uint2 v = {(unsigned int)x, (unsigned int)y};
        return v;
    }
};

struct size_t3 {
    optix_size_t x, y, z;
    RT_HOSTDEVICE size_t3() {}
    RT_HOSTDEVICE size_t3(optix_size_t x_, optix_size_t y_, optix_size_t z_)
        : x(x_), y(y_), z(z_) {}
    RT_HOSTDEVICE size_t3(uint3 v) : x(v.x), y(v.y), z(v.z) {}
    RT_HOSTDEVICE size_t3(int3 v)
        : x(optix_size_t(v.x)), y(optix_size_t(v.y)), z(optix_size_t(v.z)) {}
    RT_HOSTDEVICE operator uint3() const {
        uint3 v = {(unsigned int)x, (unsigned int)y, (unsigned int)z};
        return v;
    }
};

struct size_t4 {
    optix_size_t x, y, z, w;
    RT_HOSTDEVICE size_t4() {}
    RT_HOSTDEVICE size_t4(optix_size_t x_, optix_size_t y_, optix_size_t z_, optix_size_t w_)
        : x(x_), y(y_), z(z_), w(w_) {}
    RT_HOSTDEVICE size_t4(uint4 v) : x(v.x), y(v.y), z(v.z), w(v.w) {}
    RT_HOSTDEVICE size_t4(int4 v)
        : x(optix_size_t(v.x)), y(optix_size_t(v.y)), z(optix_size_t(v.z)), w(optix_size_t(v.w)) {}
    RT_HOSTDEVICE operator uint4() const {
        uint4 v = {(unsigned int)x, (unsigned int)y, (unsigned int)z, (unsigned int)w};
        return v;
    }
};

RT_HOSTDEVICE inline size_t2 make_size_t2(optix_size_t x, optix_size_t y) {
    return size_t2(x, y);
}
RT_HOSTDEVICE inline size_t3 make_size_t3(optix_size_t x, optix_size_t y, optix_size_t z) {
    return size_t3(x, y, z);
}
RT_HOSTDEVICE inline size_t4 make_size_t4(optix_size_t x, optix_size_t y, optix_size_t z,
                                          optix_size_t w) {
    return size_t4(x, y, z, w);
}

} // namespace optix

#endif
