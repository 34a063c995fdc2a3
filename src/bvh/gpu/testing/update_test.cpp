// SPDX-License-Identifier: Apache-2.0
// Updates by the GPU's kernels, run on the CPU device: equal bytes if nothing moved, else the hits
// of a new build; boxes contain their children; refused updates.
#include "bvh/gpu/testing/device.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

namespace sunstone::bvh::gpu {
namespace {

using namespace bvh::testing;
using namespace gpu::testing;
using bvh::testing::Mesh;

BuildOptions updatable() {
    BuildOptions options;
    options.allowUpdate = options.allowCompaction = true;
    return options;
}

BuildInputs inputsOf(const TriangleInput& input) {
    BuildInputs inputs;
    inputs.triangles = {&input, 1};
    return inputs;
}
BuildInputs inputsOf(const CustomInput& input) {
    BuildInputs inputs;
    inputs.customs = {&input, 1};
    return inputs;
}
BuildInputs inputsOf(const InstanceInput& input) {
    BuildInputs inputs;
    inputs.instances = &input;
    return inputs;
}

void queueUpdate(const Buffer& structure, const BuildInputs& inputs, const BuildOptions& options,
                 const Buffer& temp) {
    Device::get().builder().update(nullptr, inputs, options, temp.address(), temp.size(),
                                   structure.address(), structure.size());
}

void update(const Buffer& structure, const BuildInputs& inputs,
            const BuildOptions& options = updatable()) {
    const Buffer temp(Builder::computeMemoryUsage(inputs, options).tempUpdate);
    queueUpdate(structure, inputs, options, temp);
    ASSERT_EQ(Device::get().driver().ctxSynchronize(), CUDA_SUCCESS);
    for (const std::string& failure : Device::get().builder().takeFailures())
        ADD_FAILURE() << failure;
}

const BlockHeader& headerOf(const Buffer& structure) {
    return *static_cast<const BlockHeader*>(structure.data());
}

// The relevant bytes of a compacted structure.
std::vector<uint8_t> bytesOf(const Buffer& structure) {
    const auto* const bytes = static_cast<const uint8_t*>(structure.data());
    return {bytes, bytes + structure.size()};
}

uint64_t handleOf(const Buffer& structure) {
    return structure.address() |
           (headerOf(structure).type == BlockType::kInstances ? devlib::kTagIas : devlib::kTagGas);
}

// Whether the planes of each node hold the boxes of the active primitives below.
struct BoxCheck {
    const BlockHeader& header;
    const uint8_t* bytes;
    std::vector<Box> boxes; // of instances, by index
    uint32_t active = 0;

    explicit BoxCheck(const Buffer& structure, std::vector<Box> instances = {})
        : header(headerOf(structure)), bytes(static_cast<const uint8_t*>(structure.data())),
          boxes(std::move(instances)) {
        if (header.wholeRoot != kNoNode)
            visit(0);
    }

    static Box nothing() {
        return {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    }
    static void add(Box& to, const Box& box) {
        for (int a = 0; a < 3; ++a) {
            to.lower[a] = std::min(to.lower[a], box.lower[a]);
            to.upper[a] = std::max(to.upper[a], box.upper[a]);
        }
    }

    Box recordBox(uint32_t place) {
        Box box = nothing();
        if (header.type == BlockType::kTriangles) {
            const auto& t =
                reinterpret_cast<const TriangleRecord*>(bytes + header.recordsOffset)[place];
            if (std::isnan(t.v0[0]))
                return box;
            for (const float* v : {t.v0, t.v1, t.v2})
                add(box, {{v[0], v[1], v[2]}, {v[0], v[1], v[2]}});
        } else if (header.type == BlockType::kCustom) {
            const auto& c =
                reinterpret_cast<const CustomLeaf*>(bytes + header.recordsOffset)[place];
            if (!(c.lower[0] <= c.upper[0]))
                return box;
            box = {{c.lower[0], c.lower[1], c.lower[2]}, {c.upper[0], c.upper[1], c.upper[2]}};
        } else {
            box = boxes.at(reinterpret_cast<const uint32_t*>(bytes + header.recordsOffset)[place]);
            if (!(box.lower.x <= box.upper.x))
                return box;
        }
        ++active;
        return box;
    }

    Box visit(uint32_t index) {
        const WideNode& node = reinterpret_cast<const WideNode*>(bytes + header.nodesOffset)[index];
        Box whole = nothing();
        uint32_t inner = 0;
        for (uint32_t s = 0; s < 8; ++s) {
            Box box = nothing();
            if (node.innerMask >> s & 1) {
                box = visit(node.childBase + inner++);
            } else if (node.meta[s] >> 5 == 0 && node.meta[s] != 0) {
                box = recordBox(node.primitiveBase + node.meta[s] - 1u);
                EXPECT_GT(box.lower.x, box.upper.x) << "active, but never entered";
            } else {
                const uint32_t count = uint32_t(__builtin_popcount(node.meta[s] >> 5));
                for (uint32_t k = 0; k < count; ++k)
                    add(box, recordBox(node.primitiveBase + (node.meta[s] & 31u) + k));
            }
            for (int a = 0; a < 3; ++a) {
                const double step = std::ldexp(1.0, node.exponents[a] - 127);
                const double low = node.origin[a] + node.planes[a][s] * step,
                             high = node.origin[a] + node.planes[3 + a][s] * step;
                if (box.lower.x <= box.upper.x) {
                    EXPECT_LE(low, double(box.lower[a])) << "node " << index << " slot " << s;
                    EXPECT_GE(high, double(box.upper[a])) << "node " << index << " slot " << s;
                    const float size =
                        std::max({box.upper.x - box.lower.x, box.upper.y - box.lower.y,
                                  box.upper.z - box.lower.z});
                    if (boxes.empty()) // tight but for a step and the padding of the box
                        EXPECT_GE(low + 2.1 * step + 1e-6 * double(size), double(box.lower[a]));
                } else if (node.meta[s]) {
                    EXPECT_GT(low, high);
                }
            }
            add(whole, box);
        }
        return whole;
    }
};

void expectHits(const BuildInputs& inputs, const Buffer& structure, uint32_t seed,
                uint32_t leastHits) {
    const Structure cpu = makeStructure(inputs);
    Random random(seed);
    uint32_t hits = 0;
    for (uint32_t i = 0; i < 3000; ++i) {
        const Vec3 o = random.point(3), d = random.point(1) - o;
        const QueryRay ray{{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 1e30f};
        QueryHit a{}, b{};
        const bool found = kernels(chosenIsa()).closest(cpu.block(), ray, a);
        ASSERT_EQ(found, nearest(handleOf(structure), ray, b)) << "ray " << i << " seed " << seed;
        hits += found;
        if (found) {
            ASSERT_EQ(a.t, b.t);
            ASSERT_EQ(a.primitive, b.primitive);
            ASSERT_EQ(a.sbt, b.sbt);
        }
    }
    EXPECT_GE(hits, leastHits);
    const BlockHeader& is = headerOf(structure);
    const BlockHeader& wanted = *bvh::headerOf(cpu.block());
    EXPECT_EQ(is.numActive, wanted.numActive);
    EXPECT_EQ(is.root == kNoNode, wanted.root == kNoNode);
    for (int a = 0; a < 3; ++a) {
        EXPECT_EQ(is.lower[a], wanted.lower[a]);
        EXPECT_EQ(is.upper[a], wanted.upper[a]);
    }
    EXPECT_EQ(BoxCheck(structure).active, is.numActive);
}

std::vector<Box> randomBoxes(uint32_t count, uint32_t seed) {
    Random random(seed);
    std::vector<Box> boxes(count);
    for (Box& b : boxes) {
        const Vec3 c = random.point(1);
        b = {c - Vec3{0.05f, 0.1f, 0.02f}, c + Vec3{0.05f, 0.1f, 0.02f}};
    }
    return boxes;
}

CustomInput customsOf(const std::vector<Box>& boxes) {
    CustomInput in;
    in.aabbs = boxes.data();
    in.numPrimitives = uint32_t(boxes.size());
    return in;
}

TEST(GpuUpdate, OfWhatHasNotMovedChangesNothing) {
    for (uint32_t count : {1u, 3u, 8u, 9u, 100u, 3000u}) {
        SCOPED_TRACE("triangles " + std::to_string(count));
        Mesh mesh = soup(count, 0.1f, count);
        if (count > 20)
            for (uint32_t i = 0; i < count; i += 9)
                mesh.vertices[3 * i].x = NAN; // some inactive from the start
        const TriangleInput in = mesh.input();
        const GpuStructure s = buildOnDevice(in, updatable());
        EXPECT_EQ(s.header().numLeaves, count);
        const std::vector<uint8_t> before = bytesOf(*s.memory);
        update(*s.memory, inputsOf(in));
        EXPECT_EQ(before, bytesOf(*s.memory));
    }
    std::vector<Box> boxes = randomBoxes(700, 1);
    for (uint32_t i = 0; i < 700; i += 5)
        boxes[i].upper.y = NAN;
    const CustomInput customs = customsOf(boxes);
    const GpuStructure s = buildOnDevice(inputsOf(customs), updatable());
    EXPECT_EQ(BoxCheck(*s.memory).active, 560u);
    const std::vector<uint8_t> before = bytesOf(*s.memory);
    update(*s.memory, inputsOf(customs));
    EXPECT_EQ(before, bytesOf(*s.memory));
}

TEST(GpuUpdate, TrianglesFollowTheirVertices) {
    for (bool compacted : {false, true}) {
        Mesh mesh = soup(2000, 0.12f, 1);
        const TriangleInput in = mesh.input();
        const GpuStructure s = buildOnDevice(in, updatable());
        const Buffer& structure = compacted ? *s.memory : *s.loose;
        expectHits(inputsOf(in), structure, 1, 500);
        const Mesh moved = soup(2000, 0.12f, 2);
        std::copy(moved.vertices.begin(), moved.vertices.end(), mesh.vertices.begin());
        update(structure, inputsOf(in));
        expectHits(inputsOf(in), structure, 2, 500);
        // Flat, far away and huge; then as small as a point may be.
        for (Vec3& v : mesh.vertices)
            v = {v.x, v.y, 0};
        update(structure, inputsOf(in));
        expectHits(inputsOf(in), structure, 3, 200);
        for (Vec3& v : mesh.vertices)
            v = v * 1e20f;
        update(structure, inputsOf(in));
        EXPECT_EQ(BoxCheck(structure).active, 2000u);
    }
}

TEST(GpuUpdate, OfSeveralInputsWithSbtIndices) {
    Mesh a = soup(300, 0.3f, 1), b = soup(100, 0.4f, 2), c = soup(57, 0.5f, 3);
    const uint32_t flags[3] = {1, 0, 2};
    std::vector<uint8_t> bytes(300);
    std::vector<uint32_t> words(2 * 57);
    for (size_t i = 0; i < bytes.size(); ++i)
        bytes[i] = uint8_t(i % 5); // some beyond the records
    for (size_t i = 0; i < words.size(); ++i)
        words[i] = uint32_t(i / 2 % 3);
    TriangleInput list[3] = {a.input(), b.input(), c.input()};
    list[0].sbt = {flags, 3, bytes.data(), 1, 0, 1000};
    list[2].sbt = {flags, 3, words.data(), 4, 8, 5};
    BuildInputs inputs;
    inputs.triangles = list;
    const GpuStructure s = buildOnDevice(inputs, updatable());
    for (Mesh* m : {&a, &b, &c})
        for (Vec3& v : m->vertices)
            v = {-v.y, v.x, v.z};
    for (uint8_t& x : bytes)
        x = uint8_t(x / 2);
    update(*s.memory, inputs);
    expectHits(inputs, *s.memory, 5, 500);
}

TEST(GpuUpdate, PrimitivesComeAndGo) {
    Mesh mesh = soup(500, 0.3f, 9);
    const std::vector<Vec3> good = mesh.vertices;
    BuildOptions options = updatable();
    options.allowRandomVertexAccess = true;
    const TriangleInput in = mesh.input();
    for (uint32_t i = 0; i < 500; i += 3)
        mesh.vertices[3 * i + i % 3].y = NAN;
    const GpuStructure s = buildOnDevice(in, options);
    expectHits(inputsOf(in), *s.memory, 1, 500);
    for (Vec3& v : mesh.vertices)
        v.z = INFINITY;
    update(*s.memory, inputsOf(in), options);
    EXPECT_EQ(s.header().root, kNoNode);
    EXPECT_EQ(s.header().numActive, 0u);
    expectHits(inputsOf(in), *s.memory, 2, 0);
    mesh.vertices = good;
    update(*s.memory, inputsOf(in), options);
    expectHits(inputsOf(in), *s.memory, 3, 500);
    EXPECT_EQ(s.header().numActive, 500u);
    const auto* bytes = static_cast<const uint8_t*>(s.memory->data());
    const auto* table = reinterpret_cast<const uint32_t*>(bytes + s.header().tableOffset);
    const auto* records = reinterpret_cast<const TriangleRecord*>(bytes + s.header().recordsOffset);
    for (uint32_t i = 0; i < 500; ++i) {
        ASSERT_LT(table[i], 500u);
        ASSERT_EQ(records[table[i]].primitive, i);
    }
    // An empty build.
    for (Vec3& v : mesh.vertices)
        v.x = NAN;
    const GpuStructure empty = buildOnDevice(in, options);
    EXPECT_EQ(empty.header().root, kNoNode);
    mesh.vertices = good;
    update(*empty.memory, inputsOf(in), options);
    expectHits(inputsOf(in), *empty.memory, 4, 500);
}

TEST(GpuUpdate, CustomPrimitives) {
    std::vector<Box> boxes = randomBoxes(700, 1);
    boxes[17].lower.x = boxes[17].upper.x + 1; // inverted
    const CustomInput in = customsOf(boxes);
    const GpuStructure s = buildOnDevice(inputsOf(in), updatable());
    EXPECT_EQ(BoxCheck(*s.memory).active, 699u);
    for (const Buffer* structure : {s.memory.get(), s.loose.get()}) {
        const std::vector<Box> moved = randomBoxes(700, 2);
        std::copy(moved.begin(), moved.end(), boxes.begin());
        boxes[5].upper.z = INFINITY;
        boxes[6].upper.z = NAN;
        update(*structure, inputsOf(in));
        EXPECT_EQ(headerOf(*structure).numActive, 698u);
        EXPECT_EQ(BoxCheck(*structure).active, 698u);
        Box all = BoxCheck::nothing();
        for (uint32_t i = 0; i < 700; ++i)
            if (i != 5 && i != 6)
                BoxCheck::add(all, boxes[i]);
        for (int a = 0; a < 3; ++a) {
            EXPECT_EQ(headerOf(*structure).lower[a], all.lower[a]);
            EXPECT_EQ(headerOf(*structure).upper[a], all.upper[a]);
        }
    }
}

TEST(GpuUpdate, Instances) {
    Mesh mesh = icosphere(1);
    const TriangleInput triangles = mesh.input();
    const GpuStructure sphere = buildOnDevice(triangles, updatable());
    Random random(3);
    std::vector<InstanceDesc> list(120);
    const auto place = [&](float size) {
        for (InstanceDesc& i : list) {
            i = {};
            const Vec3 p = random.point(1);
            for (int a = 0; a < 3; ++a) {
                i.transform[5 * a] = size;
                i.transform[4 * a + 3] = p[a];
            }
            i.visibilityMask = 255;
            i.traversableHandle = sphere.handle();
        }
    };
    place(0.05f);
    list[7].traversableHandle = 0;
    InstanceInput in;
    in.instances = list.data();
    in.numInstances = 120;
    const GpuStructure s = buildOnDevice(inputsOf(in), updatable());
    EXPECT_EQ(s.header().numActive, 119u);
    const std::vector<uint8_t> before = bytesOf(*s.memory);
    update(*s.memory, inputsOf(in));
    EXPECT_EQ(before, bytesOf(*s.memory));
    place(0.1f);
    list[9].visibilityMask = 0;
    list[10].transform[0] = NAN;
    for (Vec3& v : mesh.vertices) // the child grows first
        v = v * 1.5f;
    update(*sphere.memory, inputsOf(triangles));
    update(*s.memory, inputsOf(in));
    EXPECT_EQ(s.header().numActive, 118u);
    const GpuStructure fresh = buildOnDevice(inputsOf(in), updatable());
    for (int a = 0; a < 3; ++a)
        EXPECT_EQ(s.header().lower[a], fresh.header().lower[a]);
    std::vector<Box> boxes(120, BoxCheck::nothing());
    for (uint32_t i = 0; i < 120; ++i)
        for (int a = 0; a < 3 && i != 9 && i != 10; ++a) {
            boxes[i].lower[a] = list[i].transform[4 * a + 3] - 0.14f;
            boxes[i].upper[a] = list[i].transform[4 * a + 3] + 0.14f;
        }
    EXPECT_EQ(BoxCheck(*s.memory, boxes).active, 118u);
    uint32_t hits = 0;
    for (uint32_t i = 0; i < 2000; ++i) {
        const Vec3 o = random.point(3), d = random.point(1) - o;
        const QueryRay ray{{o.x, o.y, o.z}, 0, {d.x, d.y, d.z}, 1e30f};
        QueryHit a{}, b{};
        uint32_t instanceA = 0, instanceB = 0;
        const bool found = nearest(fresh.handle(), ray, a, &instanceA);
        ASSERT_EQ(found, nearest(s.handle(), ray, b, &instanceB));
        if (!found)
            continue;
        ++hits;
        ASSERT_EQ(a.t, b.t);
    }
    EXPECT_GT(hits, 300u);
}

template <class Call>
std::string errorOf(const Call& call) {
    try {
        call();
    } catch (const Error& error) {
        return error.what();
    }
    return "no error";
}

// Invalid updates: the call reports them if the stream is idle.
TEST(GpuUpdate, OtherShapesAreRefused) {
    const Mesh mesh = soup(40, 0.3f, 1);
    const TriangleInput in = mesh.input();
    const GpuStructure s = buildOnDevice(in, updatable()), fixed = buildOnDevice(in);
    const Buffer temp(1 << 20);
    const auto expectRefused = [&](const Buffer& structure, const BuildInputs& inputs,
                                   const BuildOptions& options, const char* mention) {
        const std::vector<uint8_t> before = bytesOf(structure);
        EXPECT_NE(errorOf([&] { queueUpdate(structure, inputs, options, temp); }).find(mention),
                  std::string::npos)
            << mention;
        EXPECT_EQ(before, bytesOf(structure));
    };
    BuildOptions other = updatable();
    other.allowUpdate = false;
    expectRefused(*s.memory, inputsOf(in), other, "ALLOW_UPDATE");
    expectRefused(*fixed.memory, inputsOf(in), updatable(), "ALLOW_UPDATE");
    other = updatable();
    other.preferFastBuild = true;
    expectRefused(*s.memory, inputsOf(in), other, "build flags");
    const Buffer nothing(s.memory->size());
    expectRefused(nothing, inputsOf(in), updatable(), "needs an acceleration structure");
    TriangleInput fewer = in;
    fewer.numTriangles = 39;
    expectRefused(*s.memory, inputsOf(fewer), updatable(), "primitives");
    fewer = in;
    fewer.numVertices -= 1;
    expectRefused(*s.memory, inputsOf(fewer), updatable(), "vertices");
    fewer = in;
    fewer.vertexFormat = VertexFormat::kFloat2;
    expectRefused(*s.memory, inputsOf(fewer), updatable(), "vertex format");
    const uint32_t flags = kGeometryDisableAnyHit;
    fewer = in;
    fewer.sbt.flags = &flags;
    expectRefused(*s.memory, inputsOf(fewer), updatable(), "geometry flags");
    const std::vector<Box> boxes = randomBoxes(40, 1);
    expectRefused(*s.memory, inputsOf(customsOf(boxes)), updatable(), "type");
    const auto& builder = Device::get().builder();
    EXPECT_NE(errorOf([&] {
                  builder.update(nullptr, inputsOf(in), updatable(), temp.address(), temp.size(),
                                 s.memory->address(), s.memory->size() - 1);
              }).find("output buffer"),
              std::string::npos);
    const size_t needed = Builder::computeMemoryUsage(inputsOf(in), updatable()).tempUpdate;
    EXPECT_NE(errorOf([&] {
                  builder.update(nullptr, inputsOf(in), updatable(), temp.address(), needed - 1,
                                 s.memory->address(), s.memory->size());
              }).find("temp buffer"),
              std::string::npos);
    EXPECT_EQ(Builder::computeMemoryUsage(inputsOf(in), {}).tempUpdate, 0u);
}

// While the stream is busy, the call does not read the structure; kernels detect the error.
TEST(GpuUpdate, OtherShapesBehindABusyStreamAreToldLater) {
    const auto& driver = Device::get().driver();
    const Mesh mesh = soup(40, 0.3f, 1);
    const TriangleInput in = mesh.input();
    TriangleInput fewer = in;
    fewer.numTriangles = 39;
    const GpuStructure s = buildOnDevice(in, updatable());
    const std::vector<uint8_t> before = bytesOf(*s.memory);
    const Buffer temp(1 << 20);
    CUstream stream = nullptr;
    ASSERT_EQ(driver.streamCreate(&stream, CU_STREAM_NON_BLOCKING), CUDA_SUCCESS);
    std::atomic<bool> go = false;
    const auto wait = [](void* flag) {
        while (!static_cast<std::atomic<bool>*>(flag)->load())
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    };
    ASSERT_EQ(driver.launchHostFunc(stream, wait, &go), CUDA_SUCCESS);
    // On the CPU device, copies from pageable memory wait for the stream. The stream continues
    // after the call has queried it.
    static std::atomic<bool> asked;
    static const auto ask = driver.streamQuery;
    asked = false;
    Device::get().driverForTests().streamQuery = [](CUstream queried) {
        const CUresult answer = ask(queried);
        asked = true;
        return answer;
    };
    std::thread release([&] {
        while (!asked)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        go = true;
    });
    EXPECT_NO_THROW(Device::get().builder().update(stream, inputsOf(fewer), updatable(),
                                                   temp.address(), temp.size(), s.memory->address(),
                                                   s.memory->size()));
    asked = true; // where it threw before
    release.join();
    Device::get().driverForTests().streamQuery = ask;
    ASSERT_EQ(driver.streamSynchronize(stream), CUDA_SUCCESS);
    driver.streamDestroy(stream);
    const std::vector<std::string> told = Device::get().builder().takeFailures();
    ASSERT_EQ(told.size(), 1u);
    EXPECT_NE(told[0].find("did nothing"), std::string::npos);
    EXPECT_TRUE(Device::get().builder().takeFailures().empty());
    EXPECT_EQ(before, bytesOf(*s.memory));
}

} // namespace
} // namespace sunstone::bvh::gpu
