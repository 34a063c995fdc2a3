// SPDX-License-Identifier: Apache-2.0
// A small renderer whose scene is made of objects with virtual functions, which a kernel constructs
// on the device: rays call every object through its table, and materials return the light they
// reflect. Numbers are fixed point with sixteen fractional bits, so that host and device agree in
// every bit.
#include <cuda_runtime.h>

#include "check.h"
#include "clock.h"

#include <cstdint>
#include <vector>

using Fixed = int64_t; // 16.16
constexpr int kBits = 16;
constexpr Fixed kOne = 1 << kBits;

struct Vector {
    Fixed x, y, z;
};

__host__ __device__ inline Fixed dot(Vector a, Vector b) {
    return (a.x * b.x + a.y * b.y + a.z * b.z) >> kBits;
}
__host__ __device__ inline Vector along(Vector from, Vector direction, Fixed distance) {
    return {from.x + (direction.x * distance >> kBits), from.y + (direction.y * distance >> kBits),
            from.z + (direction.z * distance >> kBits)};
}
__host__ __device__ inline Fixed root(Fixed value) {
    uint64_t rest = uint64_t(value) << kBits, made = 0, bit = uint64_t(1) << 46;
    for (; bit != 0; bit >>= 2) {
        const bool fits = rest >= made + bit;
        rest -= fits ? made + bit : 0;
        made = (made >> 1) + (fits ? bit : 0);
    }
    return Fixed(made);
}

struct Material {
    __host__ __device__ virtual ~Material() {}
    // The reflected part of the light at this place, by the cosine of the light's angle.
    __host__ __device__ virtual Fixed shade(Vector place, Fixed cosine) const = 0;
};

struct Plain : Material {
    __host__ __device__ explicit Plain(Fixed albedo) : albedo(albedo) {}
    __host__ __device__ Fixed shade(Vector, Fixed cosine) const override {
        return cosine > 0 ? albedo * cosine >> kBits : 0;
    }
    Fixed albedo;
};

struct Checkered : Material {
    __host__ __device__ Checkered(Fixed size) : size(size) {}
    __host__ __device__ Fixed shade(Vector place, Fixed cosine) const override {
        const Fixed far = kOne * 4096; // divisions of positive numbers
        const bool odd = (((place.x + far) / size) ^ ((place.z + far) / size)) & 1;
        return cosine > 0 ? (odd ? cosine : cosine >> 2) : 0;
    }
    Fixed size;
};

struct Shape {
    __host__ __device__ explicit Shape(const Material* material) : material(material) {}
    __host__ __device__ virtual ~Shape() {}
    // The distance at which the ray meets it, below `most`, or `most`.
    __host__ __device__ virtual Fixed meet(Vector from, Vector direction, Fixed most) const = 0;
    __host__ __device__ virtual Vector normal(Vector place) const = 0;
    const Material* material;
};

struct Sphere : Shape {
    __host__ __device__ Sphere(Vector centre, Fixed radius, const Material* material)
        : Shape(material), centre(centre), radius(radius) {}
    __host__ __device__ Fixed meet(Vector from, Vector direction, Fixed most) const override {
        const Vector to = {centre.x - from.x, centre.y - from.y, centre.z - from.z};
        const Fixed middle = dot(to, direction);
        const Fixed square = (middle * middle >> kBits) - dot(to, to) + (radius * radius >> kBits);
        if (square < 0)
            return most;
        const Fixed distance = middle - root(square);
        return distance > kOne / 64 && distance < most ? distance : most;
    }
    __host__ __device__ Vector normal(Vector place) const override {
        return {(place.x - centre.x) * kOne / radius, (place.y - centre.y) * kOne / radius,
                (place.z - centre.z) * kOne / radius};
    }
    Vector centre;
    Fixed radius;
};

struct Floor : Shape {
    __host__ __device__ Floor(Fixed height, const Material* material)
        : Shape(material), height(height) {}
    __host__ __device__ Fixed meet(Vector from, Vector direction, Fixed most) const override {
        if (direction.y >= 0)
            return most;
        const Fixed distance = (height - from.y) * kOne / direction.y;
        return distance > kOne / 64 && distance < most ? distance : most;
    }
    __host__ __device__ Vector normal(Vector) const override { return {0, kOne, 0}; }
    Fixed height;
};

constexpr int kSpheres = 12, kShapes = kSpheres + 1, kMaterials = 4;

struct Scene {
    const Shape* shapes[kShapes];
    const Material* materials[kMaterials];
};

__host__ __device__ void fill(Scene& scene) {
    for (int i = 0; i < kMaterials - 1; ++i)
        scene.materials[i] = new Plain(kOne * (i + 2) / 4);
    scene.materials[kMaterials - 1] = new Checkered(kOne);
    unsigned state = 5;
    for (int i = 0; i < kSpheres; ++i) {
        Fixed numbers[3];
        for (Fixed& number : numbers) {
            state = state * 1664525u + 1013904223u;
            number = Fixed(state >> 16);
        }
        scene.shapes[i] =
            new Sphere({(numbers[0] - kOne / 2) * 8, numbers[1] * 2, 4 * kOne + numbers[2] * 6},
                       kOne / 2 + numbers[0] / 2, scene.materials[i % kMaterials]);
    }
    scene.shapes[kSpheres] = new Floor(-kOne, scene.materials[kMaterials - 1]);
}

__host__ __device__ void empty(Scene& scene) {
    for (const Shape* shape : scene.shapes)
        delete shape;
    for (const Material* material : scene.materials)
        delete material;
}

__host__ __device__ unsigned char render(const Scene& scene, int x, int y, int width, int height) {
    const Fixed far = 1000 * kOne;
    Vector direction = {(x - width / 2) * kOne * 2 / width, (height / 2 - y) * kOne * 2 / width,
                        kOne};
    const Fixed length = root(dot(direction, direction));
    direction = {direction.x * kOne / length, direction.y * kOne / length,
                 direction.z * kOne / length};
    const Vector light = {-26755, 53510, -26755}; // of length one, nearly
    Vector from = {0, kOne / 2, -kOne};
    Fixed sum = 0, weight = kOne;
    for (int bounce = 0; bounce < 3; ++bounce) {
        Fixed nearest = far;
        const Shape* met = nullptr;
        for (const Shape* shape : scene.shapes) {
            const Fixed distance = shape->meet(from, direction, nearest);
            if (distance < nearest) {
                nearest = distance;
                met = shape;
            }
        }
        if (!met) {
            sum += weight * (kOne / 2 + direction.y / 2) >> kBits;
            break;
        }
        from = along(from, direction, nearest);
        const Vector normal = met->normal(from);
        Fixed cosine = dot(normal, light);
        for (const Shape* shape : scene.shapes)
            if (shape->meet(from, light, far) < far)
                cosine = 0;
        sum += weight * met->material->shade(from, cosine) >> kBits;
        weight /= 3;
        direction = along(direction, normal, -2 * dot(direction, normal));
    }
    return (unsigned char)(sum * 200 >> kBits > 255 ? 255 : sum * 200 >> kBits);
}

__global__ void build(Scene* scene) {
    fill(*scene);
}
__global__ void drop(Scene* scene) {
    empty(*scene);
}
__global__ void draw(const Scene* scene, unsigned char* picture, int width, int height) {
    const int x = blockIdx.x * blockDim.x + threadIdx.x, y = blockIdx.y * blockDim.y + threadIdx.y;
    if (x < width && y < height)
        picture[y * width + x] = render(*scene, x, y, width, height);
}

int main(int argc, char** argv) {
    Clock clock(argc, argv);
    const int width = 160, height = 90 * clock.factor();
    Scene* scene;
    unsigned char* picture;
    CHECK(cudaMalloc(&scene, sizeof(Scene)));
    CHECK(cudaMalloc(&picture, width * height));
    build<<<1, 1>>>(scene);
    for (int round = 0; round < 2; ++round) { // the first one compiles
        clock.start();
        draw<<<dim3((width + 15) / 16, (height + 15) / 16), dim3(16, 16)>>>(scene, picture, width,
                                                                            height);
        CHECK(cudaDeviceSynchronize());
        clock.kernels();
    }
    drop<<<1, 1>>>(scene);
    std::vector<unsigned char> made(width * height), expected(width * height);
    CHECK(cudaMemcpy(made.data(), picture, made.size(), cudaMemcpyDeviceToHost));
    Scene host;
    fill(host);
    clock.start();
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            expected[y * width + x] = render(host, x, y, width, height);
    clock.host("objects");
    empty(host);
    unsigned wrong = 0, hash = 2166136261u;
    for (size_t i = 0; i < made.size(); ++i) {
        wrong += made[i] != expected[i];
        hash = (hash ^ made[i]) * 16777619u;
    }
    std::printf("%u of %zu pixels wrong, hash %08x\n", wrong, made.size(), hash);
    return 0;
}
