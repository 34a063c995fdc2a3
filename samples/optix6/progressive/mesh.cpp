// SPDX-License-Identifier: Apache-2.0
#include "mesh.h"

#include "host_scene.h"

namespace {

PlainMesh plain(const HostScene& scene, float3 centre) {
    PlainMesh mesh;
    for (const float3& p : scene.positions)
        mesh.positions.push_back({p.x - centre.x, p.y - centre.y, p.z - centre.z});
    for (const float3& n : scene.normals)
        mesh.normals.push_back({n.x, n.y, n.z});
    for (const auto& t : scene.triangles)
        mesh.triangles.push_back({t.x, t.y, t.z});
    return mesh;
}

} // namespace

Model loadModel(const std::string& file) {
    const HostScene scene = file.empty() ? makeKnot(20000) : loadObj(file);
    const Bounds bounds = boundsOf(scene);
    HostScene ground;
    addGround(ground, bounds, bounds.low.y, Material{});
    return {plain(scene, bounds.center()), plain(ground, bounds.center()), bounds.radius()};
}
