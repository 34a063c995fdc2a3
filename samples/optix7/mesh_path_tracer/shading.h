// SPDX-License-Identifier: Apache-2.0
// The path tracer's mathematics, for device and host: paths through a triangle mesh under a sky and
// rectangular lights, with a material of a diffuse base under a glossy coat.
//
// tracePath() is a template over the ray tracer, so that the same code runs as an OptiX program
// (path_tracer.cu) and as C++ over another ray tracer.
//
// Light on a path is weighted by multiple importance sampling between sampling the lights and
// sampling the material (Veach 1997, balance heuristic). The glossy lobe is GGX, sampled by visible
// normals (Heitz 2018). Read next: path_tracer.cu.
#pragma once

#include "camera.h"
#include "sampling.h"

// Meaning of a material's opacity times the alpha of vertices and texture.
enum AlphaMode : unsigned { kOpaque, kCutOut, kBlended };

struct Material {
    float3 color;
    float roughness; // 0 to 1
    float3 emission;
    float metallic; // 0 to 1
    float opacity;  // the last four may be left out: opaque, without a texture
    float cutoff;   // of kCutOut: less is a hole
    AlphaMode alpha;
    unsigned texture; // number plus one; 0: none
};

// Bytes red, green, blue (sRGB) and alpha in each texel, from the lowest; repeats.
struct Texture {
    const unsigned* texels;
    const float* linear; // the linear values of 256 bytes
    unsigned width, height;
};

// Indexed triangles; `normals` has one for each vertex, and so have `colors` and `texcoords`, which
// may be null.
struct Mesh {
    const float3* positions;
    const float3* normals;
    const uint3* triangles;
    const unsigned* materialOfTriangle;
    const Material* materials;
    const float4* colors; // factors: linear colour, alpha
    const float2* texcoords;
    const Texture* textures;
};

// A parallelogram that shines to the side of its normal. The camera does not see it.
struct RectangleLight {
    float3 corner, edge1, edge2;
    float3 normal; // unit length
    float area;
    float3 emission;
    float chance; // of being picked; the lights' add up to one
};

constexpr unsigned kMaxLights = 4;

struct Scene {
    Mesh mesh;
    RectangleLight lights[kMaxLights];
    unsigned lightCount;
    float3 skyZenith, skyHorizon, ground;
    float epsilon;        // distance by which rays leave a surface
    unsigned maxSegments; // closest-hit rays in a path, camera ray included
};

struct Hit {
    float t; // negative: the ray left the scene
    unsigned triangle;
    float u, v; // barycentric weights of the second and third vertex
};

// Random numbers of one path. The first eight (place in the pixel; light and direction at the first
// surface) matter most: over the samples of a pixel they follow the R2 sequence (Roberts 2018),
// which covers the unit square evenly, shifted by a random amount for each pixel. Each of the four
// pairs takes the samples in a different order, so that the pairs are independent. Later numbers
// come from PCG (O'Neill 2014).
struct Random {
    unsigned state;
    unsigned pixel;
    unsigned sample;
    unsigned drawn;
};

constexpr unsigned kEvenNumbers = 8;
constexpr unsigned kOrderMask = 63; // order changes within blocks of this many samples and one

SAMPLE_INLINE Random makeRandom(unsigned pixel, unsigned sample) {
    Random random;
    random.state = hashPcg(pixel + hashPcg(sample));
    random.pixel = hashPcg(pixel);
    random.sample = sample;
    random.drawn = 0;
    return random;
}
// In [0, 1).
SAMPLE_INLINE float nextFloat(Random& random) {
    unsigned bits;
    if (random.drawn < kEvenNumbers) {
        unsigned pair = random.drawn >> 1u, second = random.drawn & 1u;
        unsigned turn = hashPcg(random.pixel + random.drawn);
        unsigned order = hashPcg(random.pixel ^ (pair << 16u)) & kOrderMask;
        // 2^32 / g and 2^32 / g^2, where g^3 = g + 1; products wrap as the sequence does.
        unsigned step = second ? 2447445414u : 3242174889u;
        bits = turn + (random.sample ^ order) * step;
        ++random.drawn;
    } else {
        bits = hashPcg(random.state);
        random.state = random.state * 747796405u + 2891336453u;
    }
    return float(bits >> 8) * (1.0f / 16777216.0f);
}

// ---- Light sources ------------------------------------------------------------------------------

SAMPLE_INLINE float3 skyRadiance(const Scene& scene, float3 direction) {
    if (direction.y < 0.0f)
        return lerp(scene.skyHorizon, scene.ground, minOf(1.0f, -8.0f * direction.y));
    return lerp(scene.skyHorizon, scene.skyZenith, sqrtf(direction.y));
}

// Density by which sampleLight picks the direction to a point of `light`, per solid angle.
SAMPLE_INLINE float lightPdf(const RectangleLight& light, float distance, float cosine) {
    return light.chance * distance * distance / (cosine * light.area);
}

struct LightSample {
    float3 direction;
    float distance;
    float pdf; // 0: no light from there
    float3 emission;
};

SAMPLE_INLINE LightSample sampleLight(const Scene& scene, float3 point, Random& random) {
    LightSample sample;
    float u = nextFloat(random), v = nextFloat(random);
    float choice = nextFloat(random);
    unsigned index = 0;
    while (index + 1 < scene.lightCount && choice >= scene.lights[index].chance)
        choice -= scene.lights[index++].chance;
    const RectangleLight& light = scene.lights[index];
    float3 toLight = light.corner + light.edge1 * u + light.edge2 * v - point;
    sample.distance = length(toLight);
    sample.direction = toLight / sample.distance;
    float cosine = -dot(sample.direction, light.normal);
    sample.pdf = cosine > 1e-4f ? lightPdf(light, sample.distance, cosine) : 0.0f;
    sample.emission = light.emission;
    return sample;
}

// Light that arrives along a ray from the rectangles nearer than `limit`, each weighted against
// sampleLight; `materialPdf` is the density by which the ray's direction was picked.
SAMPLE_INLINE float3 lightAlongRay(const Scene& scene, float3 origin, float3 direction, float limit,
                                   float materialPdf) {
    float3 sum = vec(0.0f);
    for (unsigned i = 0; i < scene.lightCount; ++i) {
        const RectangleLight& light = scene.lights[i];
        float cosine = -dot(direction, light.normal);
        if (cosine <= 1e-4f)
            continue;
        float3 toCorner = light.corner - origin;
        float distance = -dot(toCorner, light.normal) / cosine;
        if (distance <= 0.0f || distance >= limit)
            continue;
        float3 onLight = direction * distance - toCorner;
        float u = dot(onLight, light.edge1) / dot(light.edge1, light.edge1);
        float v = dot(onLight, light.edge2) / dot(light.edge2, light.edge2);
        if (u < 0.0f || u > 1.0f || v < 0.0f || v > 1.0f)
            continue;
        float weight = materialPdf / (materialPdf + lightPdf(light, distance, cosine));
        sum += light.emission * weight;
    }
    return sum;
}

// ---- Material -----------------------------------------------------------------------------------

struct Tint {
    float3 color;
    float alpha;
};

SAMPLE_INLINE Tint texelOf(const Texture& texture, int x, int y) {
    int width = int(texture.width), height = int(texture.height);
    x = (x % width + width) % width;
    y = (y % height + height) % height;
    unsigned texel = texture.texels[unsigned(y) * texture.width + unsigned(x)];
    Tint tint;
    tint.color = vec(texture.linear[texel & 255u], texture.linear[texel >> 8u & 255u],
                     texture.linear[texel >> 16u & 255u]);
    tint.alpha = float(texel >> 24u) / 255.0f;
    return tint;
}

SAMPLE_INLINE Tint mix(const Tint& a, const Tint& b, float share) {
    Tint tint;
    tint.color = lerp(a.color, b.color, share);
    tint.alpha = a.alpha + (b.alpha - a.alpha) * share;
    return tint;
}

// Bilinear.
SAMPLE_INLINE Tint sampleTexture(const Texture& texture, float u, float v) {
    float x = (u - floorf(u)) * float(texture.width) - 0.5f;
    float y = (v - floorf(v)) * float(texture.height) - 0.5f;
    int column = int(floorf(x)), row = int(floorf(y));
    float shareX = x - floorf(x), shareY = y - floorf(y);
    return mix(
        mix(texelOf(texture, column, row), texelOf(texture, column + 1, row), shareX),
        mix(texelOf(texture, column, row + 1), texelOf(texture, column + 1, row + 1), shareX),
        shareY);
}

// The factors of vertices and texture for the material's colour and opacity.
SAMPLE_INLINE Tint tintAt(const Mesh& mesh, const Material& material, const Hit& hit) {
    uint3 corner = mesh.triangles[hit.triangle];
    float w = 1.0f - hit.u - hit.v;
    Tint tint;
    tint.color = vec(1.0f);
    tint.alpha = 1.0f;
    if (mesh.colors) {
        float4 a = mesh.colors[corner.x], b = mesh.colors[corner.y], c = mesh.colors[corner.z];
        tint.color =
            vec(a.x, a.y, a.z) * w + vec(b.x, b.y, b.z) * hit.u + vec(c.x, c.y, c.z) * hit.v;
        tint.alpha = a.w * w + b.w * hit.u + c.w * hit.v;
    }
    if (mesh.texcoords && material.texture != 0) {
        float2 a = mesh.texcoords[corner.x], b = mesh.texcoords[corner.y],
               c = mesh.texcoords[corner.z];
        Tint texture =
            sampleTexture(mesh.textures[material.texture - 1], a.x * w + b.x * hit.u + c.x * hit.v,
                          a.y * w + b.y * hit.u + c.y * hit.v);
        tint.color = tint.color * texture.color;
        tint.alpha *= texture.alpha;
    }
    return tint;
}

// Whether a ray passes through the surface at a hit. For blended surfaces this is random, with the
// hit's place as the seed.
SAMPLE_INLINE bool passesThrough(const Mesh& mesh, const Hit& hit) {
    const Material& material = mesh.materials[mesh.materialOfTriangle[hit.triangle]];
    if (material.alpha == kOpaque)
        return false;
    float alpha = material.opacity * tintAt(mesh, material, hit).alpha;
    if (material.alpha == kCutOut)
        return alpha < material.cutoff;
    unsigned bits = hashPcg(unsigned(hit.u * 16777216.0f) ^ hashPcg(unsigned(hit.v * 16777216.0f)));
    return float(bits >> 8) * (1.0f / 16777216.0f) >= alpha;
}

struct Surface {
    float3 point;
    float3 geometric; // unit normal of the triangle, on the side the ray came from
    float3 normal;    // interpolated, on the same side
    Material material;
};

SAMPLE_INLINE Surface surfaceAt(const Mesh& mesh, const Hit& hit, float3 direction) {
    uint3 corner = mesh.triangles[hit.triangle];
    float3 a = mesh.positions[corner.x], b = mesh.positions[corner.y], c = mesh.positions[corner.z];
    float w = 1.0f - hit.u - hit.v;
    Surface surface;
    surface.point = a * w + b * hit.u + c * hit.v;
    float3 geometric = cross(b - a, c - a);
    geometric = geometric * (1.0f / sqrtf(maxOf(dot(geometric, geometric), 1e-30f)));
    if (dot(geometric, direction) > 0.0f)
        geometric = -geometric;
    float3 normal = mesh.normals[corner.x] * w + mesh.normals[corner.y] * hit.u +
                    mesh.normals[corner.z] * hit.v;
    float square = dot(normal, normal);
    normal = square > 1e-20f ? normal * (1.0f / sqrtf(square)) : geometric;
    if (dot(normal, geometric) < 0.0f)
        normal = -normal;
    if (dot(normal, direction) > -1e-3f) // interpolated away from the viewer
        normal = geometric;
    surface.geometric = geometric;
    surface.normal = normal;
    surface.material = mesh.materials[mesh.materialOfTriangle[hit.triangle]];
    if (mesh.colors || mesh.texcoords)
        surface.material.color = surface.material.color * tintAt(mesh, surface.material, hit).color;
    return surface;
}

SAMPLE_INLINE float3 fresnel(float3 facing, float cosine) {
    float edge = 1.0f - clamp01(cosine);
    float square = edge * edge;
    return facing + (vec(1.0f) - facing) * (square * square * edge);
}

// The material at one point, seen from one direction.
struct Lobes {
    float3 diffuse;     // albedo of the base
    float3 facing;      // reflectance of the coat at normal incidence
    float alpha;        // GGX roughness
    float glossyChance; // probability of sampling the coat
};

SAMPLE_INLINE Lobes makeLobes(const Material& material, float viewCosine) {
    Lobes lobes;
    lobes.diffuse = material.color * (1.0f - material.metallic);
    lobes.facing = lerp(vec(0.04f), material.color, material.metallic);
    float roughness = maxOf(material.roughness, 0.08f);
    lobes.alpha = roughness * roughness;
    float glossy = maxComponent(fresnel(lobes.facing, viewCosine));
    float base = maxComponent(lobes.diffuse) * (1.0f - glossy);
    lobes.glossyChance = glossy / maxOf(glossy + base, 1e-6f);
    return lobes;
}

// Smith's masking term for GGX, one direction.
SAMPLE_INLINE float masking(float alpha, float cosine) {
    float square = alpha * alpha;
    return 2.0f * cosine / (cosine + sqrtf(square + (1.0f - square) * cosine * cosine));
}

struct Reflection {
    float3 value; // reflectance times cosine
    float pdf;
};

// `view` and `light` in the surface's basis, both above it.
SAMPLE_INLINE Reflection evaluate(const Lobes& lobes, float3 view, float3 light) {
    Reflection result;
    float3 half = normalize(view + light);
    float square = lobes.alpha * lobes.alpha;
    float denominator = half.z * half.z * (square - 1.0f) + 1.0f;
    float distribution = square / (kPi * denominator * denominator);
    float3 reflected = fresnel(lobes.facing, dot(view, half));
    float maskView = masking(lobes.alpha, view.z);
    float visibility = maskView * masking(lobes.alpha, light.z) / (4.0f * view.z * light.z);
    result.value = (lobes.diffuse * (vec(1.0f) - reflected) * (1.0f / kPi) +
                    reflected * (distribution * visibility)) *
                   light.z;
    float glossyPdf = distribution * maskView / (4.0f * view.z);
    result.pdf = lobes.glossyChance * glossyPdf + (1.0f - lobes.glossyChance) * light.z / kPi;
    return result;
}

// A direction to follow, in the surface's basis; may point below the surface (then it is lost).
SAMPLE_INLINE float3 sampleMaterial(const Lobes& lobes, float3 view, Random& random) {
    float choice = nextFloat(random);
    float radius = sqrtf(nextFloat(random));
    float2 circle = circlePoint(nextFloat(random));
    float x = radius * circle.x, y = radius * circle.y;
    if (choice >= lobes.glossyChance) // cosine-weighted
        return vec(x, y, sqrtf(maxOf(0.0f, 1.0f - x * x - y * y)));
    float3 stretched = normalize(vec(lobes.alpha * view.x, lobes.alpha * view.y, view.z));
    // Visible normals fill half a disc whose straight edge is in the surface, so `tangent` must be
    // in the surface, too.
    float planar = stretched.x * stretched.x + stretched.y * stretched.y;
    float3 tangent = vec(1.0f, 0.0f, 0.0f);
    if (planar > 1e-12f)
        tangent = vec(-stretched.y, stretched.x, 0.0f) * (1.0f / sqrtf(planar));
    float3 bitangent = cross(stretched, tangent);
    float share = 0.5f * (1.0f + stretched.z);
    y = (1.0f - share) * sqrtf(maxOf(0.0f, 1.0f - x * x)) + share * y;
    float3 normal =
        tangent * x + bitangent * y + stretched * sqrtf(maxOf(0.0f, 1.0f - x * x - y * y));
    normal = normalize(vec(lobes.alpha * normal.x, lobes.alpha * normal.y, maxOf(1e-6f, normal.z)));
    return -reflect(view, normal);
}

// ---- Paths --------------------------------------------------------------------------------------

// Light from the lights straight to the surface, reflected towards `view`.
template <class Rays>
SAMPLE_INLINE float3 directLight(const Scene& scene, const Rays& rays, const Surface& surface,
                                 const Lobes& lobes, float3 x, float3 y, float3 view,
                                 Random& random) {
    LightSample sample = sampleLight(scene, surface.point, random);
    float3 local = vec(dot(sample.direction, x), dot(sample.direction, y),
                       dot(sample.direction, surface.normal));
    if (sample.pdf <= 0.0f || local.z <= 1e-4f || dot(sample.direction, surface.geometric) <= 1e-4f)
        return vec(0.0f);
    if (!rays.visible(surface.point + surface.geometric * scene.epsilon, sample.direction,
                      sample.distance - 2.0f * scene.epsilon))
        return vec(0.0f);
    Reflection reflection = evaluate(lobes, view, local);
    return sample.emission * reflection.value * (1.0f / (sample.pdf + reflection.pdf));
}

// Light that reaches `origin` against `direction` along one random path. Rays must offer
//   Hit closest(float3 origin, float3 direction) const
//   bool visible(float3 origin, float3 direction, float distance) const
template <class Rays>
SAMPLE_INLINE float3 tracePath(const Scene& scene, const Rays& rays, float3 origin,
                               float3 direction, Random& random) {
    constexpr float kLimit =
        3.0f; // limit on the light of one bounce: keeps rare bright paths from speckling
    float3 radiance = vec(0.0f), throughput = vec(1.0f);
    float materialPdf = 0.0f;
    for (unsigned segment = 0; segment < scene.maxSegments; ++segment) {
        Hit hit = rays.closest(origin, direction);
        float3 arriving = vec(0.0f);
        if (segment > 0)
            arriving =
                lightAlongRay(scene, origin, direction, hit.t < 0.0f ? 1e30f : hit.t, materialPdf);
        if (hit.t < 0.0f) {
            radiance += throughput * (arriving + skyRadiance(scene, direction));
            break;
        }
        Surface surface = surfaceAt(scene.mesh, hit, direction);
        float3 x, y;
        makeBasis(surface.normal, x, y);
        float3 view = vec(-dot(direction, x), -dot(direction, y), -dot(direction, surface.normal));
        Lobes lobes = makeLobes(surface.material, view.z);
        arriving += surface.material.emission;
        if (scene.lightCount > 0)
            arriving += directLight(scene, rays, surface, lobes, x, y, view, random);
        float3 added = throughput * arriving;
        float brightest = maxComponent(added);
        radiance += segment > 0 && brightest > kLimit ? added * (kLimit / brightest) : added;

        float3 next = sampleMaterial(lobes, view, random);
        if (next.z <= 1e-4f)
            break;
        Reflection reflection = evaluate(lobes, view, next);
        direction = fromBasis(x, y, surface.normal, next);
        if (dot(direction, surface.geometric) <= 0.0f || !(reflection.pdf > 0.0f))
            break;
        throughput *= reflection.value / reflection.pdf;
        materialPdf = reflection.pdf;
        // Russian roulette: dim paths end early with a probability that the weight of the others
        // compensates.
        float survival = minOf(1.0f, maxComponent(throughput));
        if (segment > 0 && survival < 0.95f) {
            if (nextFloat(random) >= survival)
                break;
            throughput = throughput / survival;
        }
        origin = surface.point + surface.geometric * scene.epsilon;
    }
    return radiance;
}

// Direction of a sample of a pixel, at a random place in it: the first two numbers of the path.
SAMPLE_INLINE float3 sampleDirection(const Camera& camera, unsigned x, unsigned y, unsigned width,
                                     unsigned height, Random& random) {
    float u = (float(x) + nextFloat(random)) / float(width);
    float v = (float(y) + nextFloat(random)) / float(height);
    return cameraDirection(camera, u, v);
}

// One sample of a pixel.
template <class Rays>
SAMPLE_INLINE float3 samplePixel(const Scene& scene, const Rays& rays, const Camera& camera,
                                 unsigned x, unsigned y, unsigned width, unsigned height,
                                 unsigned sample, unsigned seed = 0) {
    Random random = makeRandom(y * width + x + seed * 7919u, sample);
    float3 direction = sampleDirection(camera, x, y, width, height, random);
    return tracePath(scene, rays, camera.eye, direction, random);
}

// ---- Guides for denoisers
// -------------------------------------------------------------------------

struct GuideSample {
    float3 albedo, normal; // 0 where there is no surface; the normal in the camera's directions
    float3 point;          // far away where there is no surface
};

// The guides at the first surface that samplePixel meets with the same numbers.
template <class Rays>
SAMPLE_INLINE GuideSample sampleGuides(const Scene& scene, const Rays& rays, const Camera& camera,
                                       unsigned x, unsigned y, unsigned width, unsigned height,
                                       unsigned sample, unsigned seed) {
    Random random = makeRandom(y * width + x + seed * 7919u, sample);
    float3 direction = sampleDirection(camera, x, y, width, height, random);
    GuideSample guides;
    Hit hit = rays.closest(camera.eye, direction);
    if (hit.t < 0.0f) {
        guides.albedo = guides.normal = vec(0.0f);
        guides.point = camera.eye + direction * 1e6f;
        return guides;
    }
    Surface surface = surfaceAt(scene.mesh, hit, direction);
    float3 reflected =
        fresnel(makeLobes(surface.material, 1.0f).facing, -dot(surface.normal, direction));
    float3 diffuse = surface.material.color * (1.0f - surface.material.metallic);
    guides.albedo = diffuse * (vec(1.0f) - reflected) + reflected;
    if (maxComponent(surface.material.emission) > 0.0f)
        guides.albedo = vec(0.0f); // its light is its own
    guides.normal =
        vec(dot(surface.normal, normalize(camera.right)), dot(surface.normal, normalize(camera.up)),
            -dot(surface.normal, camera.forward));
    guides.point = surface.point;
    return guides;
}

// Where the camera sees a point, in pixels.
SAMPLE_INLINE float2 pixelOf(const Camera& camera, float3 point, unsigned width, unsigned height) {
    float3 to = point - camera.eye;
    float depth = dot(to, camera.forward);
    float2 pixel;
    pixel.x =
        (dot(to, camera.right) / (dot(camera.right, camera.right) * depth) + 1.0f) * 0.5f * width;
    pixel.y = (1.0f - dot(to, camera.up) / (dot(camera.up, camera.up) * depth)) * 0.5f * height;
    return pixel;
}
