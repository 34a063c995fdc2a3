// SPDX-License-Identifier: Apache-2.0
// Scenes that are hard on denoisers in different ways, with their lights and cameras.
#pragma once

#include "host_scene.h"

struct View {
    const char* name;
    HostScene scene;
    Scene lights; // all but the mesh
    Camera camera;
};

// 0 knot: coated tube, two softboxes. 1 textures: fine patterns under a sky. 2 relief: bumps lit by
// one small lamp. 3 glossy: metals on a polished floor. 4 lantern: a glowing sphere in the dark,
// which paths find only by chance.
constexpr unsigned kViewCount = 5;

// `turn` moves the camera around the scene, in degrees.
View makeView(unsigned number, float aspect, float turn = 0.0f);
