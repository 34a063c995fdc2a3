// SPDX-License-Identifier: Apache-2.0
// Short forms for samples with the C++ wrapper: the shapes of shapes.cu, filled buffers, a camera.
#pragma once

#include "picture6.h"

#include <optixu/optixpp_namespace.h>

#include <cstring>

inline optix::Geometry makeShape(optix::Context context, const std::string& name) {
    const std::string ptx(shapes_ptx());
    optix::Geometry made = context->createGeometry();
    made->setPrimitiveCount(1);
    made->setIntersectionProgram(context->createProgramFromPTXString(ptx, "intersect_" + name));
    made->setBoundingBoxProgram(context->createProgramFromPTXString(ptx, "bound_" + name));
    return made;
}
inline optix::Geometry makeSphere(optix::Context context, optix::float3 centre, float radius) {
    optix::Geometry made = makeShape(context, "sphere");
    made["sphere"]->setFloat(optix::make_float4(centre, radius));
    return made;
}
inline optix::Geometry makeParallelogram(optix::Context context, optix::float3 anchor,
                                         optix::float3 edge1, optix::float3 edge2) {
    optix::Geometry made = makeShape(context, "parallelogram");
    made["anchor"]->setFloat(anchor);
    made["edge1"]->setFloat(edge1);
    made["edge2"]->setFloat(edge2);
    return made;
}

// A buffer of the elements, whose format has their size.
template <class T>
optix::Buffer makeBuffer(optix::Context context, RTformat format, const std::vector<T>& items) {
    optix::Buffer made = context->createBuffer(RT_BUFFER_INPUT, format);
    if (format == RT_FORMAT_USER)
        made->setElementSize(sizeof(T));
    made->setSize(items.size());
    std::memcpy(made->map(), items.data(), items.size() * sizeof(T));
    made->unmap();
    return made;
}

inline void setCamera(optix::Context context, const ClassicCamera& camera) {
    context["eye"]->setFloat(camera.eye);
    context["camera_right"]->setFloat(camera.right);
    context["camera_up"]->setFloat(camera.up);
    context["camera_forward"]->setFloat(camera.forward);
}
