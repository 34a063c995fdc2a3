// SPDX-License-Identifier: Apache-2.0
// Object-oriented device code: a kernel makes objects with new, others call their virtual
// functions, also of several bases, and a last one deletes them. Functors and lambdas go through
// templates and through a small function object with a pointer to its call.
#include "device.h"

#include <cmath>
#include <new>
#include <vector>

__device__ int alive;

struct Named {
    __device__ virtual ~Named() {}
    __device__ virtual int code() const = 0;
};
struct Shape {
    __device__ Shape(float x, float y) : x(x), y(y) {}
    __device__ virtual ~Shape() { atomicAdd(&alive, -1); }
    __device__ virtual float area() const = 0;
    __device__ virtual bool contains(float px, float py) const = 0;
    __device__ virtual void grow(float by) { x += by; }
    float x, y;
};

struct Circle : Shape, Named {
    __device__ Circle(float x, float y, float r) : Shape(x, y), r(r) {}
    __device__ float area() const override { return 3.14159265f * r * r; }
    __device__ bool contains(float px, float py) const override {
        return (px - x) * (px - x) + (py - y) * (py - y) < r * r;
    }
    __device__ int code() const override { return 1; }
    float r;
};
struct Box : Named, Shape {
    __device__ Box(float x, float y, float w, float h) : Shape(x, y), w(w), h(h) {}
    __device__ float area() const override { return w * h; }
    __device__ bool contains(float px, float py) const override {
        return fabsf(px - x) < w / 2 && fabsf(py - y) < h / 2;
    }
    __device__ void grow(float by) override {
        Shape::grow(by);
        w += by;
    }
    __device__ int code() const override { return 2; }
    float w, h;
};
struct Square final : Box {
    __device__ Square(float x, float y, float side) : Box(x, y, side, side), trail(new float[4]) {
        for (int i = 0; i < 4; ++i)
            trail[i] = side + i;
    }
    __device__ ~Square() override { delete[] trail; }
    __device__ void grow(float by) override {
        Box::grow(by);
        h += by + trail[3] - w - 3 + by;
    }
    __device__ int code() const override { return 3 + Box::code(); }
    float* trail;
};

__device__ Named* nameOf(Shape* shape, int kind) {
    return kind == 0 ? static_cast<Named*>(static_cast<Circle*>(shape))
                     : static_cast<Named*>(static_cast<Box*>(shape));
}

__global__ void create(Shape** shapes, int n) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= n)
        return;
    const float x = float(i % 10), y = float(i / 10);
    if (i % 3 == 0)
        shapes[i] = new Circle(x, y, 0.5f + 0.01f * i);
    else if (i % 3 == 1)
        shapes[i] = new Box(x, y, 1 + 0.1f * (i % 7), 0.5f);
    else
        shapes[i] = new Square(x, y, 1 + 0.1f * (i % 5));
    atomicAdd(&alive, 1);
}

// Like std::function, for what fits in its bytes.
template <class Result, class... Args>
class Function {
public:
    template <class F>
    __device__ Function(F body)
        : call_([](const void* self, Args... args) -> Result {
              return (*static_cast<const F*>(self))(args...);
          }) {
        static_assert(sizeof(F) <= sizeof store_, "too large");
        new (store_) F(body);
    }
    __device__ Result operator()(Args... args) const { return call_(store_, args...); }

private:
    alignas(8) unsigned char store_[24];
    Result (*call_)(const void*, Args...);
};

template <class F>
__global__ void forEach(Shape** shapes, int n, float* out, F body) {
    for (int i = blockIdx.x * blockDim.x + threadIdx.x; i < n; i += gridDim.x * blockDim.x)
        out[i] = body(shapes[i], i);
}

__global__ void choose(Shape** shapes, int n, float* out) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= n)
        return;
    const float bonus = 0.125f * i;
    const Function<float, Shape*> byArea([bonus](Shape* s) { return s->area() + bonus; });
    const Function<float, Shape*> byCode(
        [i](Shape* s) { return 100.0f * nameOf(s, i % 3)->code(); });
    const Function<float, Shape*>* chosen[2] = {&byArea, &byCode};
    out[i] = (*chosen[(i / 2) % 2])(shapes[i]);
}

__global__ void destroy(Shape** shapes, int n) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < n)
        delete shapes[i];
}

int main() {
    constexpr int n = 150;
    CUDA(cudaDeviceSetLimit(cudaLimitMallocHeapSize, 1 << 20));
    Shape** shapes;
    float* out;
    CUDA(cudaMalloc(&shapes, n * sizeof(Shape*)));
    CUDA(cudaMallocManaged(&out, n * sizeof(float)));
    int wrong = 0;
    const auto w = [](int i) { return i % 3 == 1 ? 1 + 0.1f * (i % 7) : 1 + 0.1f * (i % 5); };
    for (int round = 0; round < 2; ++round) { // the second round needs the memory of the first
        create<<<2, 96>>>(shapes, n);
        choose<<<3, 64>>>(shapes, n, out);
        CUDA(cudaDeviceSynchronize());
        for (int i = 0; i < n; ++i) {
            const float r = 0.5f + 0.01f * i;
            const float area = i % 3 == 0   ? 3.14159265f * r * r
                               : i % 3 == 1 ? w(i) * 0.5f
                                            : w(i) * w(i);
            const float codes[] = {1, 2, 5};
            const float right = (i / 2) % 2 ? 100 * codes[i % 3] : area + 0.125f * i;
            wrong += std::fabs(out[i] - right) > 1e-3f;
        }
        const float px = 4.2f, py = 3.1f;
        forEach<<<1, 64>>>(shapes, n, out, [px, py] __device__(Shape * s, int) {
            return float(s->contains(px, py));
        });
        CUDA(cudaDeviceSynchronize());
        for (int i = 0; i < n; ++i) {
            const float x = float(i % 10), y = float(i / 10), r = 0.5f + 0.01f * i;
            const float h = i % 3 == 1 ? 0.5f : w(i);
            const bool inside = i % 3 == 0
                                    ? (px - x) * (px - x) + (py - y) * (py - y) < r * r
                                    : std::fabs(px - x) < w(i) / 2 && std::fabs(py - y) < h / 2;
            wrong += out[i] != float(inside);
        }
        forEach<<<2, 32>>>(shapes, n, out, [] __device__(Shape * s, int i) {
            s->grow(0.5f);
            return i % 3 ? s->area() : s->x;
        });
        CUDA(cudaDeviceSynchronize());
        for (int i = 0; i < n; ++i) {
            const float side = w(i) + 0.5f;
            // A square's height grows by 0.5 + side + 3 - (side + 0.5) - 3 + 0.5.
            const float right = i % 3 == 0   ? i % 10 + 0.5f
                                : i % 3 == 1 ? side * 0.5f
                                             : side * (w(i) + 0.5f);
            wrong += std::fabs(out[i] - right) > 1e-3f;
        }
        destroy<<<5, 32>>>(shapes, n);
        int left = -1;
        CUDA(cudaMemcpyFromSymbol(&left, alive, sizeof left));
        wrong += left != 0;
    }
    std::printf("%d wrong\n", wrong);
    return finish(wrong == 0);
}
