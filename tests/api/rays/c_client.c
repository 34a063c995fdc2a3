/* SPDX-License-Identifier: Apache-2.0 */
/* sunstone/rays.h from C. */
#include "sunstone/rays.h"

#include <stdio.h>

int main(void) {
    const float vertices[9] = {0, 0, 1, 2, 0, 1, 0, 2, 1};
    const SunstoneMesh mesh = {vertices, 3, NULL, 0};
    const SunstoneRay ray = {{0.5f, 0.25f, 0}, 0, {0, 0, 1}, 10};
    SunstoneScene scene = NULL;
    SunstoneHit hit;
    if (sunstoneSceneCreate(&mesh, &scene) != SUNSTONE_OK ||
        sunstoneClosestHits(scene, &ray, 1, &hit) != SUNSTONE_OK ||
        sunstoneSceneDestroy(scene) != SUNSTONE_OK) {
        fprintf(stderr, "%s\n", sunstoneLastError());
        return 1;
    }
    printf("t %g, triangle %d, u %g, v %g\n", hit.t, hit.triangle, hit.u, hit.v);
    return !(hit.t == 1 && hit.triangle == 0 && hit.u == 0.25f && hit.v == 0.125f);
}
