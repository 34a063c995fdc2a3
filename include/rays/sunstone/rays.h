/* SPDX-License-Identifier: Apache-2.0 */
/* Ray queries: triangles in, rays in, hits out. Link libsunstone_rays. C99; the C++ classes are at
   the end. docs/prime.md has the rules.

       SunstoneScene scene = NULL;
       sunstoneSceneCreate(&mesh, &scene);
       sunstoneClosestHits(scene, rays, count, hits);
       sunstoneSceneDestroy(scene);

   Arrays are in memory of the host, or of the CUDA device of the scene. A scene whose vertices are
   in device memory is on that device. All other scenes are on the CPU. Calls return when their
   work is done. All functions are thread-safe, and queries on one scene may run at once. */
#ifndef SUNSTONE_RAYS_H
#define SUNSTONE_RAYS_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    SUNSTONE_OK = 0,
    SUNSTONE_INVALID_VALUE = 1,
    SUNSTONE_INVALID_HANDLE = 2,
    SUNSTONE_OUT_OF_MEMORY = 3,
    SUNSTONE_NOT_SUPPORTED = 4,
    SUNSTONE_TOO_SMALL = 5, /* a buffer of results; the size needed is returned */
    SUNSTONE_FAILED = 6
} SunstoneResult;

typedef struct SunstoneScene_t* SunstoneScene;

typedef struct {
    const float* vertices; /* x, y, z of each vertex */
    size_t vertexCount;
    const int32_t* triangles; /* three vertices each; NULL: every three vertices are a triangle */
    size_t triangleCount;     /* ignored where triangles is NULL */
} SunstoneMesh;

/* An object of a scene of instances. */
typedef struct {
    SunstoneScene scene; /* of a mesh */
    float transform[12]; /* three rows of four: object to world */
} SunstoneInstance;

typedef struct {
    float origin[3];
    float tmin;
    float direction[3]; /* any length, the unit of distances */
    float tmax;
} SunstoneRay;

typedef struct {
    float t;          /* negative: no hit */
    int32_t triangle; /* -1: no hit */
    int32_t instance; /* index in the list; 0 in scenes of a mesh, -1: no hit */
    float u, v;       /* at the triangle's second and third vertex */
} SunstoneHit;

typedef struct {
    float distance; /* negative: no triangle within the largest distance */
    int32_t triangle, instance;
    float u, v;
    float point[3];
} SunstoneNearest;

SunstoneResult sunstoneSceneCreate(const SunstoneMesh* mesh, SunstoneScene* scene);
/* The instances may be destroyed afterwards. */
SunstoneResult sunstoneSceneCreateInstances(const SunstoneInstance* instances, size_t count,
                                            SunstoneScene* scene);
SunstoneResult sunstoneSceneDestroy(SunstoneScene scene);

/* The nearest hit of each ray. */
SunstoneResult sunstoneClosestHits(SunstoneScene scene, const SunstoneRay* rays, size_t count,
                                   SunstoneHit* hits);
/* Any hit of each ray: faster than the nearest one. */
SunstoneResult sunstoneAnyHits(SunstoneScene scene, const SunstoneRay* rays, size_t count,
                               SunstoneHit* hits);
/* All hits, ray after ray, the nearest first. Those of ray i are hits[offsets[i]] to
   hits[offsets[i + 1] - 1]; offsets has count + 1 elements. With less capacity than offsets[count]
   no hits are written, and the result is SUNSTONE_TOO_SMALL. Scenes and arrays of the CPU. */
SunstoneResult sunstoneAllHits(SunstoneScene scene, const SunstoneRay* rays, size_t count,
                               SunstoneHit* hits, size_t capacity, size_t* offsets);
/* For each point (x, y, z) the nearest point of all triangles, at most `farthest` away; triangles
   without area do not count. Scenes and arrays of the CPU. */
SunstoneResult sunstoneNearestPoints(SunstoneScene scene, const float* points, size_t count,
                                     float farthest, SunstoneNearest* nearest);

/* The cause of this thread's last failure; valid until its next call. */
const char* sunstoneLastError(void);

#ifdef __cplusplus
}

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace sunstone {
namespace rays {

typedef SunstoneRay Ray;
typedef SunstoneHit Hit;
typedef SunstoneNearest Nearest;

class Error : public std::runtime_error {
public:
    Error(SunstoneResult result, const std::string& text)
        : std::runtime_error(text), result_(result) {}
    SunstoneResult result() const { return result_; }

private:
    SunstoneResult result_;
};

inline void check(SunstoneResult result) {
    if (result != SUNSTONE_OK)
        throw Error(result, sunstoneLastError());
}

class Scene {
public:
    Scene() : scene_(NULL) {}
    explicit Scene(const SunstoneMesh& mesh) : scene_(NULL) {
        check(sunstoneSceneCreate(&mesh, &scene_));
    }
    // Without triangles the scene is empty. A SunstoneMesh may have vertices alone.
    Scene(const std::vector<float>& vertices, const std::vector<int32_t>& triangles)
        : scene_(NULL) {
        const int32_t none = 0; // data() of an empty vector may be NULL, which has a meaning
        const SunstoneMesh mesh = {vertices.data(), vertices.size() / 3,
                                   triangles.empty() ? &none : triangles.data(),
                                   triangles.size() / 3};
        check(sunstoneSceneCreate(&mesh, &scene_));
    }
    explicit Scene(const std::vector<SunstoneInstance>& instances) : scene_(NULL) {
        check(sunstoneSceneCreateInstances(instances.data(), instances.size(), &scene_));
    }
    Scene(Scene&& other) noexcept : scene_(other.scene_) { other.scene_ = NULL; }
    Scene& operator=(Scene&& other) noexcept {
        std::swap(scene_, other.scene_);
        return *this;
    }
    ~Scene() {
        if (scene_)
            sunstoneSceneDestroy(scene_);
    }

    std::vector<Hit> closest(const std::vector<Ray>& rays) const {
        std::vector<Hit> hits(rays.size());
        check(sunstoneClosestHits(scene_, rays.data(), rays.size(), hits.data()));
        return hits;
    }
    std::vector<Hit> any(const std::vector<Ray>& rays) const {
        std::vector<Hit> hits(rays.size());
        check(sunstoneAnyHits(scene_, rays.data(), rays.size(), hits.data()));
        return hits;
    }
    // The hits of ray i are hits[offsets[i]] to hits[offsets[i + 1] - 1].
    std::vector<Hit> all(const std::vector<Ray>& rays, std::vector<size_t>& offsets) const {
        offsets.assign(rays.size() + 1, 0);
        std::vector<Hit> hits(4 * rays.size());
        SunstoneResult result = SUNSTONE_TOO_SMALL;
        while (result == SUNSTONE_TOO_SMALL) {
            result = sunstoneAllHits(scene_, rays.data(), rays.size(), hits.data(), hits.size(),
                                     offsets.data());
            if (result == SUNSTONE_OK || result == SUNSTONE_TOO_SMALL)
                hits.resize(offsets.back());
        }
        check(result);
        return hits;
    }
    // points: x, y, z of each.
    std::vector<Nearest> nearest(const std::vector<float>& points, float farthest) const {
        std::vector<Nearest> found(points.size() / 3);
        check(sunstoneNearestPoints(scene_, points.data(), found.size(), farthest, found.data()));
        return found;
    }
    SunstoneScene handle() const { return scene_; }

private:
    Scene(const Scene&);
    Scene& operator=(const Scene&);
    SunstoneScene scene_;
};

} // namespace rays
} // namespace sunstone
#endif

#endif
