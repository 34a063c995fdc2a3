// SPDX-License-Identifier: Apache-2.0
// Motion blur of every kind in the API. Vertices with motion keys: a twisting star. Boxes with
// motion keys: a bouncing ball. A matrix motion transform: a block that shoots past and shears. SRT
// motion transforms: a windmill's sails and spinning coins. A structure of instances with motion
// keys holds them all. Read instances first.
#include "picture.h"
#include "sampling.h"

#include <optix_function_table_definition.h>

#include <cmath>
#include <cstring>

#include "params.h"

std::string_view motion_blur_ptx(); // the PTX of motion_blur.cu, built into this program

namespace {

// The exposure: from time 0 to 1.
OptixMotionOptions exposure(unsigned keys) {
    OptixMotionOptions motion = {};
    motion.numKeys = (unsigned short)(keys);
    motion.flags = OPTIX_MOTION_FLAG_NONE;
    motion.timeBegin = 0.0f;
    motion.timeEnd = 1.0f;
    return motion;
}

// Triangles; several lists of corners are motion keys.
Accel buildMesh(OptixDeviceContext context, const std::vector<std::vector<float3>>& keys) {
    std::vector<DeviceBuffer> buffers(keys.size());
    std::vector<CUdeviceptr> addresses;
    for (size_t k = 0; k < keys.size(); ++k) {
        buffers[k].upload(keys[k]);
        addresses.push_back(buffers[k].address());
    }
    unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    input.triangleArray.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
    input.triangleArray.vertexStrideInBytes = sizeof(float3);
    input.triangleArray.numVertices = unsigned(keys[0].size());
    input.triangleArray.vertexBuffers = addresses.data();
    input.triangleArray.flags = &flags;
    input.triangleArray.numSbtRecords = 1;
    return buildAccel(context, input, exposure(unsigned(keys.size())),
                      OPTIX_BUILD_FLAG_ALLOW_RANDOM_VERTEX_ACCESS);
}

void addQuad(std::vector<float3>& corners, float3 a, float3 b, float3 c, float3 d) {
    corners.insert(corners.end(), {a, b, c, a, c, d});
}

std::vector<float3> box(float3 low, float3 high) {
    std::vector<float3> corners;
    auto corner = [&](int i) {
        return vec(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
    };
    const int sides[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                             {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (const int* s : sides)
        addQuad(corners, corner(s[0]), corner(s[1]), corner(s[2]), corner(s[3]));
    return corners;
}

// Turns a point about an axis through the origin: 0 x, 1 y, 2 z.
float3 turn(float3 p, int axis, float turns) {
    float2 c = circlePoint(turns - std::floor(turns));
    if (axis == 0)
        return vec(p.x, c.x * p.y - c.y * p.z, c.y * p.y + c.x * p.z);
    if (axis == 1)
        return vec(c.x * p.x + c.y * p.z, p.y, c.x * p.z - c.y * p.x);
    return vec(c.x * p.x - c.y * p.y, c.y * p.x + c.x * p.y, p.z);
}

// A star-shaped column whose rotation about its axis grows with the height, to `twist` at the top.
std::vector<float3> star(float twist) {
    constexpr int kCorners = 10, kSteps = 48;
    auto at = [&](int i, int step) {
        float height = float(step) / kSteps;
        float radius = (i % 2 ? 0.45f : 0.95f) * (1.0f - 0.55f * height);
        float3 p = turn(vec(radius, 0.0f, 0.0f), 1, float(i % kCorners) / kCorners);
        p.y = 2.6f * height;
        return turn(p, 1, twist * height * height);
    };
    std::vector<float3> corners;
    for (int step = 0; step < kSteps; ++step)
        for (int i = 0; i < kCorners; ++i)
            addQuad(corners, at(i, step), at(i, step + 1), at(i + 1, step + 1), at(i + 1, step));
    for (int i = 0; i < kCorners; ++i)
        corners.insert(corners.end(), {at(i, kSteps), vec(0.0f, 2.6f, 0.0f), at(i + 1, kSteps)});
    return corners;
}

// Five sails around the z axis, pitched like a propeller's.
std::vector<float3> sails() {
    std::vector<float3> corners;
    for (int i = 0; i < 5; ++i) {
        const float3 inner[2] = {vec(0.12f, -0.06f, 0.05f), vec(0.12f, 0.06f, -0.05f)};
        const float3 outer[2] = {vec(1.75f, -0.3f, 0.12f), vec(1.75f, 0.2f, -0.08f)};
        auto place = [&](float3 p) { return turn(p, 2, 0.2f * i); };
        addQuad(corners, place(inner[0]), place(outer[0]), place(outer[1]), place(inner[1]));
    }
    return corners;
}

std::vector<float3> coin() {
    constexpr int kSides = 40;
    std::vector<float3> corners;
    for (int i = 0; i < kSides; ++i) {
        float3 a = turn(vec(0.42f, 0.0f, 0.0f), 2, float(i) / kSides);
        float3 b = turn(vec(0.42f, 0.0f, 0.0f), 2, float(i + 1) / kSides);
        float3 out = vec(0.0f, 0.0f, 0.05f);
        corners.insert(corners.end(), {a + out, b + out, out});
        corners.insert(corners.end(), {b - out, a - out, -out});
        addQuad(corners, a - out, b - out, b + out, a + out);
    }
    return corners;
}

// The scene and the data that its structures refer to.
class Scene {
public:
    explicit Scene(OptixDeviceContext context) : context_(context) {
        addGround();
        addMill();
        addStar();
        addBall();
        addBlock();
        addCoins();
        whole_ = buildInstances(context_, instances_, exposure(4));
    }

    OptixTraversableHandle handle() const { return whole_.handle; }
    const std::vector<std::pair<Shape, HitData>>& looks() const { return looks_; }

private:
    // An instance at a place, with its own look.
    void add(Shape shape, OptixTraversableHandle child, float3 at, const HitData& look) {
        OptixInstance instance = {};
        const float matrix[12] = {1, 0, 0, at.x, 0, 1, 0, at.y, 0, 0, 1, at.z};
        std::memcpy(instance.transform, matrix, sizeof(matrix));
        instance.instanceId = unsigned(instances_.size());
        instance.sbtOffset = unsigned(looks_.size());
        instance.visibilityMask = 255;
        instance.traversableHandle = child;
        instances_.push_back(instance);
        looks_.push_back({shape, look});
    }
    void add(Shape shape, OptixTraversableHandle child, float3 at, float3 color) {
        HitData look = {};
        look.color = color;
        add(shape, child, at, look);
    }
    OptixTraversableHandle mesh(const std::vector<std::vector<float3>>& keys) {
        structures_.push_back(buildMesh(context_, keys));
        return structures_.back().handle;
    }
    // A transform with all its keys, in device memory.
    OptixTraversableHandle transform(const void* bytes, size_t size, OptixTraversableType type) {
        transforms_.emplace_back();
        transforms_.back().upload(bytes, size);
        OptixTraversableHandle handle = 0;
        OPTIX_CHECK(optixConvertPointerToTraversableHandle(context_, transforms_.back().address(),
                                                           type, &handle));
        return handle;
    }
    // Turns about an axis from `from` to `to` turns while it moves by `move`. Interpolated
    // quaternions keep the axis; two keys are good for up to half a turn.
    OptixTraversableHandle spin(OptixTraversableHandle child, float3 axis, float from, float to,
                                float3 move) {
        OptixSRTMotionTransform srt = {};
        srt.child = child;
        srt.motionOptions = exposure(2);
        for (int k = 0; k < 2; ++k) {
            float half = 0.5f * (k ? to : from);
            float2 c = circlePoint(half - std::floor(half));
            OptixSRTData& key = srt.srtData[k];
            key.sx = key.sy = key.sz = 1.0f;
            key.qx = axis.x * c.y;
            key.qy = axis.y * c.y;
            key.qz = axis.z * c.y;
            key.qw = c.x;
            key.tx = k * move.x;
            key.ty = k * move.y;
            key.tz = k * move.z;
        }
        return transform(&srt, sizeof(srt), OPTIX_TRAVERSABLE_TYPE_SRT_MOTION_TRANSFORM);
    }

    void addGround() {
        std::vector<float3> corners;
        addQuad(corners, vec(-60, 0, 60), vec(60, 0, 60), vec(60, 0, -60), vec(-60, 0, -60));
        add(kGround, mesh({corners}), vec(0.0f), vec(0.5f, 0.52f, 0.56f));
    }

    void addMill() {
        std::vector<float3> tower = box(vec(-0.25f, 0, -0.25f), vec(0.25f, 2.7f, 0.25f));
        add(kMesh, mesh({tower}), vec(-3.4f, 0, -0.6f), vec(0.75f, 0.72f, 0.68f));
        add(kMesh, spin(mesh({sails()}), vec(0, 0, 1), 0.02f, 0.12f, vec(0.0f)),
            vec(-3.4f, 2.45f, -0.25f), vec(0.85f, 0.2f, 0.12f));
    }

    void addStar() {
        std::vector<std::vector<float3>> keys;
        for (int k = 0; k < 5; ++k)
            keys.push_back(star(0.1f + 0.05f * k));
        add(kMesh, mesh(keys), vec(-0.7f, 0, -1.2f), vec(0.2f, 0.5f, 0.75f));
    }

    void addBall() {
        HitData look = {};
        look.color = vec(0.95f, 0.6f, 0.1f);
        look.radius = 0.45f;
        std::vector<OptixAabb> boxes;
        std::vector<CUdeviceptr> addresses;
        for (unsigned k = 0; k < kBallKeys; ++k) { // falls, touches the ground, rises
            float x = float(k) / (kBallKeys - 1), fall = 2 * x - 1;
            float3 c = vec(1.3f * x, look.radius + 0.8f * fall * fall, 0.0f);
            look.ball[k] = c;
            boxes.push_back({c.x - look.radius, c.y - look.radius, c.z - look.radius,
                             c.x + look.radius, c.y + look.radius, c.z + look.radius});
        }
        DeviceBuffer memory;
        memory.upload(boxes);
        for (unsigned k = 0; k < kBallKeys; ++k)
            addresses.push_back(memory.address() + k * sizeof(OptixAabb));
        unsigned flags = OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT;
        OptixBuildInput input = {};
        input.type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
        input.customPrimitiveArray.aabbBuffers = addresses.data();
        input.customPrimitiveArray.numPrimitives = 1;
        input.customPrimitiveArray.flags = &flags;
        input.customPrimitiveArray.numSbtRecords = 1;
        structures_.push_back(buildAccel(context_, input, exposure(kBallKeys)));
        add(kBall, structures_.back().handle, vec(-0.6f, 0, 1.7f), look);
    }

    void addBlock() {
        OptixMatrixMotionTransform matrix = {};
        matrix.child = mesh({box(vec(-0.5f, 0, -0.5f), vec(0.5f, 1, 0.5f))});
        matrix.motionOptions = exposure(2);
        const float keys[2][12] = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                                   {1, 0.35f, 0, 0.7f, 0, 0.9f, 0, 0, 0, 0, 1, 0}};
        std::memcpy(matrix.transform, keys, sizeof(keys));
        add(kMesh,
            transform(&matrix, sizeof(matrix), OPTIX_TRAVERSABLE_TYPE_MATRIX_MOTION_TRANSFORM),
            vec(2.5f, 0, -1.0f), vec(0.3f, 0.62f, 0.28f));
    }

    void addCoins() {
        const OptixTraversableHandle shape = mesh({coin()});
        for (int i = 0; i < 5; ++i) {
            float speed = 0.07f * i; // the first does not move
            add(kMesh, spin(shape, vec(0, 1, 0), 0.08f, 0.08f + speed, vec(0, 0, 0)),
                vec(-2.6f + 1.25f * i, 0.43f, 3.0f), vec(0.9f, 0.72f, 0.3f));
        }
    }

    OptixDeviceContext context_;
    std::vector<Accel> structures_;
    std::vector<DeviceBuffer> transforms_;
    std::vector<OptixInstance> instances_;
    std::vector<std::pair<Shape, HitData>> looks_;
    Accel whole_;
};

void render(OptixDeviceContext context, const Picture& picture, unsigned samples) {
    const Scene scene(context);
    Program program(context, motion_blur_ptx(), 5, 2,
                    OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE | OPTIX_PRIMITIVE_TYPE_FLAGS_CUSTOM,
                    "params", OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_ANY, false, true);
    auto raygenRecord = makeRecord(program.addRaygen("__raygen__camera"));
    std::vector<SbtRecord<NoData>> missRecords = {makeRecord(program.addMiss("__miss__sky")),
                                                  makeRecord(program.addMiss("__miss__shadow"))};
    OptixProgramGroup groups[kShapeCount];
    groups[kMesh] = program.addHitgroup("__closesthit__mesh", nullptr, nullptr);
    groups[kGround] = program.addHitgroup("__closesthit__ground", nullptr, nullptr);
    groups[kBall] = program.addHitgroup("__closesthit__ball", nullptr, "__intersection__ball");
    std::vector<SbtRecord<HitData>> hitRecords;
    for (const auto& [shape, look] : scene.looks())
        hitRecords.push_back(makeRecord(groups[shape], look));
    DeviceBuffer raygen, miss, hit;
    raygen.upload(&raygenRecord, sizeof(raygenRecord));
    miss.upload(missRecords);
    hit.upload(hitRecords);
    OptixShaderBindingTable sbt = {};
    sbt.raygenRecord = raygen.address();
    sbt.missRecordBase = miss.address();
    sbt.missRecordStrideInBytes = sizeof(missRecords[0]);
    sbt.missRecordCount = unsigned(missRecords.size());
    sbt.hitgroupRecordBase = hit.address();
    sbt.hitgroupRecordStrideInBytes = sizeof(hitRecords[0]);
    sbt.hitgroupRecordCount = unsigned(hitRecords.size());
    // Three bounces and a shadow ray; instances over a transform over geometry.
    OptixPipeline pipeline = program.link(4, 3);

    DeviceBuffer image(picture.pixels() * sizeof(float4));
    Params params = {};
    params.image = image.as<float4>();
    params.camera = makeCamera(vec(0.2f, 3.1f, 10.6f), vec(-0.35f, 1.55f, 0.0f), vec(0, 1, 0),
                               33.0f, picture.aspect());
    params.sunDirection = normalize(vec(0.55f, 0.9f, 0.6f));
    params.scene = scene.handle();
    params.samples = samples;
    params.epsilon = 1e-3f;
    launch(pipeline, sbt, params, picture);
    writePicture(picture, image);
}

} // namespace

int main(int argc, char** argv) {
    Picture picture = {"motion_blur.png", 960, 540};
    unsigned samples = 64;
    Arguments arguments("Renders moving, spinning and twisting things over an exposure.");
    addPictureOptions(arguments, picture);
    arguments.add("--spp", samples, 1, 65536, "paths for each pixel, each at its own time");
    return runSample("motion_blur", arguments, argc, argv,
                     [&](OptixDeviceContext context) { render(context, picture, samples); });
}
