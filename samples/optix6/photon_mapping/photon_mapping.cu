// SPDX-License-Identifier: Apache-2.0
// Progressive photon mapping (Hachisuka, Ogaki, Jensen 2008) by three entry points: the places that
// the camera sees, the paths of photons, and the photons near each place, found in a tree that the
// host builds.
#include "photons.h"

#include "../device6.h"

using namespace optix;

enum RayType { kCameraRay, kPhotonRay };

struct CameraPath {
    float3 origin, direction;
    float3 weight, direct;
    float3 place, normal;
    int surface, done;
};
struct PhotonPath {
    float3 origin, direction;
    float3 power;
    unsigned seed, first; // where its photons are stored
    int stored, done;
};

rtDeclareVariable(rtObject, top_object, , );
rtDeclareVariable(float, scene_epsilon, , );
rtDeclareVariable(unsigned, pass, , );
rtDeclareVariable(unsigned, max_depth, , );
rtDeclareVariable(unsigned, photons_of_path, , "places for photons of one path");
rtBuffer<Seen, 2> seen;
rtBuffer<Photon> photons;
rtBuffer<float4, 2> picture;

rtDeclareVariable(Ray, ray, rtCurrentRay, );
rtDeclareVariable(float, hit_distance, rtIntersectionDistance, );
rtDeclareVariable(float3, normal, attribute normal, );
rtDeclareVariable(CameraPath, camera_path, rtRayPayload, );
rtDeclareVariable(PhotonPath, photon_path, rtRayPayload, );

// ---- Entry 0: what the camera sees --------------------------------------------------------------

rtDeclareVariable(float, first_radius, , );

RT_PROGRAM void see() {
    CameraPath path;
    path.origin = eye;
    path.direction = cameraDirection(0.5f, 0.5f);
    path.weight = make_float3(1.0f);
    path.direct = make_float3(0.0f);
    path.surface = path.done = 0;
    for (unsigned depth = 0; depth < max_depth && !path.done; ++depth) {
        const Ray next =
            make_Ray(path.origin, path.direction, kCameraRay, scene_epsilon, RT_DEFAULT_MAX);
        rtTrace(top_object, next, path);
    }
    Seen& here = seen[launch_index];
    here.place = path.place;
    here.normal = path.normal;
    here.weight = path.weight;
    here.direct = path.direct;
    here.surface = path.surface;
    here.radius2 = first_radius * first_radius;
    here.count = 0.0f;
    here.flux = make_float3(0.0f);
}
RT_PROGRAM void camera_miss() {
    camera_path.done = 1;
}

// ---- Entry 1: photons ---------------------------------------------------------------------------

rtDeclareVariable(float3, light_anchor, , );
rtDeclareVariable(float3, light_edge1, , );
rtDeclareVariable(float3, light_edge2, , );
rtDeclareVariable(float3, light_power, , );

RT_PROGRAM void shoot_photons() {
    PhotonPath path;
    const unsigned index = launch_index.x + launch_dim.x * launch_index.y;
    path.seed = hash(index + launch_dim.x * launch_dim.y * pass);
    path.first = index * photons_of_path;
    for (unsigned i = 0; i < photons_of_path; ++i)
        photons[path.first + i].normal = make_float3(0.0f);
    const float u = random(path.seed), v = random(path.seed);
    path.origin = light_anchor + u * light_edge1 + v * light_edge2;
    const float s = random(path.seed), t = random(path.seed);
    cosine_sample_hemisphere(s, t, path.direction);
    Onb(normalize(cross(light_edge1, light_edge2))).inverse_transform(path.direction);
    path.power = light_power;
    path.stored = path.done = 0;
    for (unsigned depth = 0; depth < max_depth && !path.done; ++depth) {
        const Ray next =
            make_Ray(path.origin, path.direction, kPhotonRay, scene_epsilon, RT_DEFAULT_MAX);
        rtTrace(top_object, next, path);
    }
}
RT_PROGRAM void photon_miss() {
    photon_path.done = 1;
}

// ---- Entry 2: photons near each place -----------------------------------------------------------

rtDeclareVariable(float, paths, , "paths of photons in all passes");
// The tree: the children of node i are 2 i + 1 and 2 i + 2.
rtBuffer<Photon> tree;
rtDeclareVariable(unsigned, nodes, , );

RT_PROGRAM void gather() {
    Seen& here = seen[launch_index];
    float3 light = here.direct;
    if (here.surface) {
        float3 arrived = make_float3(0.0f);
        unsigned count = 0;
        unsigned stack[24];
        int top = 0;
        if (nodes)
            stack[top++] = 0;
        while (top) {
            const unsigned node = stack[--top];
            const Photon& photon = tree[node];
            const float3 way = photon.place - here.place;
            if (dot(way, way) < here.radius2 && dot(photon.normal, here.normal) > 0.9f &&
                dot(photon.direction, here.normal) < 0.0f) {
                arrived += photon.power;
                ++count;
            }
            if (photon.axis == kLeafAxis)
                continue;
            const float side = -getByIndex(way, photon.axis);
            const unsigned low = 2 * node + 1;
            const unsigned near = side < 0.0f ? low : low + 1, far = side < 0.0f ? low + 1 : low;
            if (side * side < here.radius2 && far < nodes)
                stack[top++] = far;
            if (near < nodes)
                stack[top++] = near;
        }
        if (count) {
            // Counts a share of the new photons, and shrinks the disc so that their density stays
            // the same.
            const float kept = here.count + 0.7f * count;
            const float shrink = kept / (here.count + count);
            here.flux = (here.flux + arrived) * shrink;
            here.radius2 *= shrink;
            here.count = kept;
        }
        light += here.weight * here.flux / (M_PIf * here.radius2 * paths);
    }
    picture[launch_index] = make_float4(light, 1.0f);
}

RT_PROGRAM void show_exception() {
    rtPrintExceptionDetails();
    picture[launch_index] = make_float4(1.0f, 0.0f, 1.0f, 1.0f);
}

// ---- Materials ----------------------------------------------------------------------------------

rtDeclareVariable(float3, albedo, , );
rtDeclareVariable(float3, emission, , );

static __device__ __forceinline__ float3 facingNormal() {
    const float3 world = normalize(rtTransformNormal(RT_OBJECT_TO_WORLD, normal));
    return faceforward(world, -ray.direction, world);
}
RT_PROGRAM void see_diffuse() {
    camera_path.place = ray.origin + hit_distance * ray.direction;
    camera_path.normal = facingNormal();
    camera_path.weight *= albedo / M_PIf;
    camera_path.surface = camera_path.done = 1;
}
RT_PROGRAM void see_light() {
    camera_path.direct += camera_path.weight * emission;
    camera_path.done = 1;
}
RT_PROGRAM void store_photon() {
    const float3 place = ray.origin + hit_distance * ray.direction, n = facingNormal();
    PhotonPath& path = photon_path;
    Photon& photon = photons[path.first + path.stored];
    photon.place = place;
    photon.normal = n;
    photon.direction = ray.direction;
    photon.power = path.power;
    if (unsigned(++path.stored) == photons_of_path) {
        path.done = 1;
        return;
    }
    const float survival = fmaxf(albedo);
    if (random(path.seed) >= survival) {
        path.done = 1;
        return;
    }
    path.power *= albedo / survival;
    path.origin = place;
    const float u = random(path.seed), v = random(path.seed);
    cosine_sample_hemisphere(u, v, path.direction);
    Onb(n).inverse_transform(path.direction);
}
RT_PROGRAM void absorb_photon() {
    photon_path.done = 1;
}

rtDeclareVariable(float, index_of_refraction, , );

static __device__ __forceinline__ float3 refractRay(float choice) {
    const float3 n = normalize(rtTransformNormal(RT_OBJECT_TO_WORLD, normal));
    const float cosine = fabsf(dot(ray.direction, n));
    float3 refracted;
    if (!refract(refracted, ray.direction, n, index_of_refraction))
        return reflect(ray.direction, n);
    const float base = (index_of_refraction - 1.0f) / (index_of_refraction + 1.0f);
    return choice < fresnel_schlick(cosine, 5.0f, base * base, 1.0f) ? reflect(ray.direction, n)
                                                                     : normalize(refracted);
}
// Camera rays follow the refracted ray; photons also follow the reflected ray.
RT_PROGRAM void see_through() {
    camera_path.origin = ray.origin + hit_distance * ray.direction;
    camera_path.direction = refractRay(1.0f);
}
RT_PROGRAM void pass_photon() {
    photon_path.origin = ray.origin + hit_distance * ray.direction;
    photon_path.direction = refractRay(random(photon_path.seed));
}
