// SPDX-License-Identifier: Apache-2.0
#include "bvh/walk/kernels.h"

#include "base/config.h"
#include "bvh/shapes/shapes.h"

namespace sunstone::bvh {

const char* isaName(Isa isa) {
    switch (isa) {
    case Isa::kAvx512:
        return "avx512";
    case Isa::kAvx2:
        return "avx2";
    default:
        return "baseline";
    }
}

bool isaSupported(Isa isa) {
    __builtin_cpu_init();
    const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                      __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") &&
                      __builtin_cpu_supports("popcnt");
    switch (isa) {
    case Isa::kAvx512:
        return avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
               __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw");
    case Isa::kAvx2:
        return avx2;
    case Isa::kBaseline:
        return true;
    }
    return false;
}

Isa chosenIsa() {
    static const Isa chosen = [] {
        const std::string& wish = config(Setting::kIsa);
        Isa limit = Isa::kAvx512;
        if (wish == isaName(Isa::kBaseline))
            limit = Isa::kBaseline;
        else if (wish == isaName(Isa::kAvx2))
            limit = Isa::kAvx2;
        while (!isaSupported(limit))
            limit = Isa(uint32_t(limit) - 1);
        return limit;
    }();
    return chosen;
}

const Kernels& kernels(Isa isa) {
    switch (isa) {
    case Isa::kAvx512:
        return kKernelsAvx512;
    case Isa::kAvx2:
        return kKernelsAvx2;
    default:
        return kKernelsBaseline;
    }
}

const ShapeKernels& shapeKernels(Isa isa) {
    switch (isa) {
    case Isa::kAvx512:
        return avx512::kShapes;
    case Isa::kAvx2:
        return avx2::kShapes;
    default:
        return baseline::kShapes;
    }
}

} // namespace sunstone::bvh
