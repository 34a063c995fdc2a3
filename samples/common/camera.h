// SPDX-License-Identifier: Apache-2.0
// A pinhole camera for host and device code.
#pragma once

#include "vec.h"

struct Camera {
    float3 eye;
    float3 forward; // to the middle of the picture
    float3 right;   // from the middle to its right edge
    float3 up;      // from the middle to its upper edge
};

// `verticalFov` in degrees, `aspect` = width / height; `worldUp` need not be perpendicular.
inline Camera makeCamera(float3 eye, float3 lookAt, float3 worldUp, float verticalFov,
                         float aspect) {
    Camera camera;
    camera.eye = eye;
    camera.forward = normalize(lookAt - eye);
    float3 right = cross(camera.forward, worldUp);
    // The camera looks along worldUp: any perpendicular direction works.
    if (dot(right, right) < 1e-12f)
        right = cross(camera.forward, vec(0.0f, 0.0f, 1.0f));
    if (dot(right, right) < 1e-12f)
        right = vec(1.0f, 0.0f, 0.0f);
    float halfHeight = tanf(verticalFov * 0.5f * 3.14159265f / 180.0f);
    right = normalize(right);
    camera.up = cross(right, camera.forward) * halfHeight;
    camera.right = right * (halfHeight * aspect);
    return camera;
}

// Direction through the point (x, y) of the picture, both from 0 to 1, y downwards.
SAMPLE_INLINE float3 cameraDirection(const Camera& camera, float x, float y) {
    return normalize(camera.forward + camera.right * (2.0f * x - 1.0f) +
                     camera.up * (1.0f - 2.0f * y));
}
