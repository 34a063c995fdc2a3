// SPDX-License-Identifier: Apache-2.0
// See client_structs.h.
#include "api/optix7/client_structs.h"

namespace sunstone::optix7 {

bool BuildInputs::hasType(OptixBuildInputType type) const {
    switch (type) {
    case OPTIX_BUILD_INPUT_TYPE_TRIANGLES:
    case OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES:
    case OPTIX_BUILD_INPUT_TYPE_INSTANCES:
    case OPTIX_BUILD_INPUT_TYPE_INSTANCE_POINTERS:
        return true;
    case OPTIX_BUILD_INPUT_TYPE_CURVES:
        return abi_ >= kAbi71;
    case OPTIX_BUILD_INPUT_TYPE_SPHERES:
        return abi_ >= kAbi75;
    }
    return false;
}

OptixBuildInput BuildInputs::operator[](unsigned index) const {
    // An input has the same size in all ABIs, because its union has reserved space.
    const OptixBuildInput& given = array_[index];
    OptixBuildInput out;
    out.type = given.type;
    const void* member = &given.triangleArray;
    switch (hasType(given.type) ? int(given.type) : 0) {
    case OPTIX_BUILD_INPUT_TYPE_TRIANGLES:
        out.triangleArray = fromClient<OptixBuildInputTriangleArray>(member, abi_);
        if (abi_ < kAbi71 && out.triangleArray.preTransform != 0)
            out.triangleArray.transformFormat = OPTIX_TRANSFORM_FORMAT_MATRIX_FLOAT12;
        break;
    case OPTIX_BUILD_INPUT_TYPE_CURVES:
        out.curveArray = fromClient<OptixBuildInputCurveArray>(member, abi_);
        break;
    case OPTIX_BUILD_INPUT_TYPE_SPHERES:
        out.sphereArray = given.sphereArray;
        break;
    case OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES:
        out.customPrimitiveArray = given.customPrimitiveArray;
        break;
    case OPTIX_BUILD_INPUT_TYPE_INSTANCES:
    case OPTIX_BUILD_INPUT_TYPE_INSTANCE_POINTERS:
        out.instanceArray = fromClient<OptixBuildInputInstanceArray>(member, abi_);
        break;
    default:
        break;
    }
    return out;
}

} // namespace sunstone::optix7
