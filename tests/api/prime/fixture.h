// SPDX-License-Identifier: Apache-2.0
// Code that the tests of OptiX Prime share: contexts of both types, buffers in memory of the host
// or of the CUDA device, a mesh, rays, and a reference that tests every triangle in double
// precision.
#pragma once

#include "optix_prime/optix_prime.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <random>
#include <string>
#include <vector>

#define ASSERT_RTP(call) ASSERT_EQ(call, RTP_SUCCESS)
#define EXPECT_RTP(call) EXPECT_EQ(call, RTP_SUCCESS)

namespace prime_test {

// Which contexts and which memory a test uses.
struct Setup {
    RTPcontexttype context;
    RTPbuffertype memory;
    friend void PrintTo(const Setup& s, std::ostream* out) {
        *out << (s.context == RTP_CONTEXT_TYPE_CPU ? "cpu" : "cuda")
             << (s.memory == RTP_BUFFER_TYPE_HOST ? "_host" : "_device");
    }
};

// The setups of this program: with PRIME_TEST_CUDA those of CUDA.
std::vector<Setup> setups();
std::string nameOf(const testing::TestParamInfo<Setup>& info);

// Memory of the CUDA device, for programs with PRIME_TEST_CUDA.
void* deviceAlloc(size_t bytes);
void deviceFree(void* address);
void copyToDevice(void* to, const void* from, size_t bytes);
void copyFromDevice(void* to, const void* from, size_t bytes);

// An array, and a copy of it where the setup wants buffers.
template <class T>
class Buffer {
public:
    Buffer(RTPbuffertype type, std::vector<T> values) : type_(type), values_(std::move(values)) {
        if (type_ == RTP_BUFFER_TYPE_CUDA_LINEAR) {
            device_ = deviceAlloc(std::max<size_t>(bytes(), 1));
            upload();
        }
    }
    ~Buffer() {
        if (device_)
            deviceFree(device_);
    }
    Buffer(const Buffer&) = delete;
    void* address() { return device_ ? device_ : values_.data(); }
    size_t size() const { return values_.size(); }
    size_t bytes() const { return values_.size() * sizeof(T); }
    std::vector<T>& values() { return values_; }
    // Copies the values to the memory that queries access, or back.
    void upload() {
        if (device_)
            copyToDevice(device_, values_.data(), bytes());
    }
    const std::vector<T>& read() {
        if (device_)
            copyFromDevice(values_.data(), device_, bytes());
        return values_;
    }

private:
    RTPbuffertype type_;
    std::vector<T> values_;
    void* device_ = nullptr;
};

struct Float3 {
    float x, y, z;
};
struct Int3 {
    int x, y, z;
};
struct Int4 {
    int x, y, z, mask;
};
struct Ray { // RTP_BUFFER_FORMAT_RAY_ORIGIN_TMIN_DIRECTION_TMAX
    Float3 origin;
    float tmin;
    Float3 direction;
    float tmax;
};
struct Hit { // RTP_BUFFER_FORMAT_HIT_T_TRIID_INSTID_U_V
    float t;
    int triangle, instance;
    float u, v;
};

struct Mesh {
    std::vector<Float3> vertices;
    std::vector<Int3> triangles;
};
Mesh soup(int triangles, float size, unsigned seed);
std::vector<Ray> randomRays(size_t count, unsigned seed);

// The mesh after a transform of three rows.
Mesh moved(const Mesh& mesh, const float* rows);

// The number of hits that contradict a test of all triangles. For rays near edges, both results are
// allowed.
size_t wrongHits(const Mesh& mesh, const std::vector<Ray>& rays, const std::vector<Hit>& hits,
                 bool any = false);

// A descriptor that is destroyed with the object.
class Desc {
public:
    Desc(RTPcontext context, RTPbufferformat format, RTPbuffertype type, void* buffer,
         size_t count) {
        EXPECT_RTP(rtpBufferDescCreate(context, format, type, buffer, &desc_));
        EXPECT_RTP(rtpBufferDescSetRange(desc_, 0, count));
    }
    template <class T>
    Desc(RTPcontext context, RTPbufferformat format, RTPbuffertype type, Buffer<T>& buffer)
        : Desc(context, format, type, buffer.address(), buffer.size()) {}
    ~Desc() { rtpBufferDescDestroy(desc_); }
    Desc(const Desc&) = delete;
    operator RTPbufferdesc() const { return desc_; }

private:
    RTPbufferdesc desc_ = nullptr;
};

// A context of a type, its last message, and models.
class PrimeTest : public testing::Test {
protected:
    void open(RTPcontexttype type) { ASSERT_RTP(rtpContextCreate(type, &context)); }
    void TearDown() override {
        if (context)
            EXPECT_RTP(rtpContextDestroy(context));
    }
    std::string lastError() {
        const char* text = nullptr;
        EXPECT_RTP(rtpContextGetLastErrorString(context, &text));
        return text ? text : "";
    }
    // An updated model of the mesh. The buffers may be destroyed afterwards.
    RTPmodel makeModel(const Mesh& mesh, RTPbuffertype memory = RTP_BUFFER_TYPE_HOST);
    // The hits of all rays in the widest format.
    std::vector<Hit> trace(RTPmodel model, const std::vector<Ray>& rays,
                           RTPquerytype type = RTP_QUERY_TYPE_CLOSEST,
                           RTPbuffertype memory = RTP_BUFFER_TYPE_HOST,
                           unsigned hints = RTP_QUERY_HINT_NONE);

    RTPcontext context = nullptr;
};

class PrimeSetupTest : public PrimeTest, public testing::WithParamInterface<Setup> {
protected:
    void SetUp() override { open(GetParam().context); }
    RTPbuffertype memory() const { return GetParam().memory; }
};

} // namespace prime_test
