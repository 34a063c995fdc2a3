// SPDX-License-Identifier: Apache-2.0
// A program for `mpirun -n N sunstone run`: renders pictures with all ranks and with this rank
// alone, and compares them.
//   ranks_client same RANKS        pictures after changes of every kind are the same
//   ranks_client death RANKS       the same, while a node is killed
//   ranks_client alone             without other ranks, everything runs on this one
//   ranks_client time SUBFRAMES    prints the seconds that a launch takes
#include <optix_world.h>

#include <dirent.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <thread>

namespace {

using namespace optix;

constexpr unsigned kWidth = 64, kHeight = 48;

[[noreturn]] void fail(const std::string& text) {
    std::fprintf(stderr, "ranks_client: %s\n", text.c_str());
    std::exit(1);
}
void require(bool holds, const char* what) {
    if (!holds)
        fail(std::string("not so: ") + what);
}

template <class T>
Buffer filled(Context context, unsigned type, RTformat format, const std::vector<T>& items,
              RTsize width, RTsize height = 0) {
    Buffer buffer = height ? context->createBuffer(type, format, width, height)
                           : context->createBuffer(type, format, width);
    std::memcpy(buffer->map(), items.data(), items.size() * sizeof(T));
    buffer->unmap();
    return buffer;
}

class Scene {
public:
    Scene(unsigned width, unsigned height, int work) : width_(width), height_(height) {
        std::ifstream file(RANKS_PTX);
        ptx_.assign(std::istreambuf_iterator<char>(file), {});
        context_ = Context::create();
        context_->setEntryPointCount(1);
        context_->setRayTypeCount(1);
        context_->setRayGenerationProgram(0, program("show"));
        context_->setMissProgram(0, program("missed"));
        source_ = context_->createBuffer(RT_BUFFER_OUTPUT, RT_FORMAT_FLOAT4, width, height);
        stream_ = context_->createBuffer(RT_BUFFER_PROGRESSIVE_STREAM, RT_FORMAT_UNSIGNED_BYTE4,
                                         width, height);
        stream_->bindProgressiveStream(source_);
        context_["picture"]->set(source_);
        context_["work"]->setInt(work);
        fillVariables();
        fillGraph();
    }
    ~Scene() { context_->destroy(); }

    // Renders the picture of so many subframes; calls `meanwhile` after the first subframes.
    template <class Body>
    std::vector<unsigned char> render(unsigned subframes, const Body& meanwhile) {
        context_->launchProgressive(0, width_, height_, subframes);
        bool isFirst = true;
        unsigned made = 0;
        const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(240);
        while (made < subframes) {
            require(std::chrono::steady_clock::now() < end, "subframes arrive");
            if (!stream_->getProgressiveUpdateReady(made)) {
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
                continue;
            }
            if (isFirst)
                meanwhile();
            isFirst = false;
        }
        const auto* bytes = static_cast<unsigned char*>(stream_->map(0, RT_BUFFER_MAP_READ));
        std::vector<unsigned char> picture(bytes, bytes + 4 * width_ * height_);
        stream_->unmap();
        return picture;
    }

    // Makes one change of each kind per call; false: there are no more.
    bool change(unsigned number) {
        switch (number) {
        case 0:
            return true; // as it is
        case 1:
            context_["scale"]->setFloat(0.7f);
            return true;
        case 2: {
            float* values = static_cast<float*>(weights_->map());
            values[1] = 0.2f;
            weights_->unmap();
            return true;
        }
        case 3: {
            const float matrix[16] = {1, 0, 0, 0.3f, 0, 1, 0, 0.5f, 0, 0, 1, 1, 0, 0, 0, 1};
            moved_->setMatrix(false, matrix, 0);
            top_->getAcceleration()->markDirty();
            return true;
        }
        case 4:
            instance_["color"]->setFloat(0.9f, 0.1f, 0.4f);
            return true;
        case 5:
            selector_["chosen"]->setInt(1);
            return true;
        case 6:
            sampler_->setFilteringModes(RT_FILTER_NEAREST, RT_FILTER_NEAREST, RT_FILTER_NONE);
            return true;
        case 7:
            top_->removeChild(moved_);
            top_->getAcceleration()->markDirty();
            moved_->destroy();
            return true;
        case 8: {
            Buffer other =
                filled<float>(context_, RT_BUFFER_INPUT, RT_FORMAT_FLOAT, {0.3f, 0.6f, 0.9f}, 3);
            context_["weights"]->set(other);
            return true;
        }
        default:
            return false;
        }
    }

    Context context_;

private:
    Program program(const char* name) { return context_->createProgramFromPTXString(ptx_, name); }
    TextureSampler sampler(float shift) {
        std::vector<float> texels;
        for (int i = 0; i < 4 * 16; ++i)
            texels.push_back(0.5f + 0.5f * std::sin(float(i) + shift));
        TextureSampler made = context_->createTextureSampler();
        made->setReadMode(RT_TEXTURE_READ_ELEMENT_TYPE);
        made->setBuffer(
            filled(context_, RT_BUFFER_INPUT, RT_FORMAT_FLOAT4, texels, RTsize(4), RTsize(4)));
        return made;
    }
    void fillVariables() {
        weights_ =
            filled<float>(context_, RT_BUFFER_INPUT, RT_FORMAT_FLOAT, {1.0f, 0.8f, 0.6f, 0.9f}, 4);
        context_["weights"]->set(weights_);
        context_["more_weights"]->setInt(
            filled<float>(context_, RT_BUFFER_INPUT_OUTPUT, RT_FORMAT_FLOAT, {0.7f}, 1)->getId());
        context_["shade"]->setInt(program("half_of")->getId());
        context_["bound_shade"]->set(program("scaled"));
        context_["scale"]->setFloat(1.6f);
        sampler_ = sampler(0.0f);
        context_["other_id"]->setInt(sampler_->getId());
        context_["by_id"]->setInt(sampler(1.0f)->getId());
    }
    GeometryGroup grouped(GeometryInstance instance) {
        GeometryGroup group = context_->createGeometryGroup();
        group->setAcceleration(context_->createAcceleration("Trbvh"));
        group->addChild(instance);
        return group;
    }
    GeometryGroup disc(float radius, float red) {
        Geometry geometry = context_->createGeometry();
        geometry->setPrimitiveCount(1);
        geometry->setBoundingBoxProgram(program("disc_bounds"));
        geometry->setIntersectionProgram(program("disc_hit"));
        geometry["radius"]->setFloat(radius);
        GeometryInstance made =
            context_->createGeometryInstance(geometry, &material_, &material_ + 1);
        made["color"]->setFloat(red, 0.5f, 0.5f);
        return grouped(made);
    }
    Transform moved(GeometryGroup child, float x, float y, float z) {
        const float matrix[16] = {1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z, 0, 0, 0, 1};
        Transform made = context_->createTransform();
        made->setMatrix(false, matrix, 0);
        made->setChild(child);
        return made;
    }
    void fillGraph() {
        material_ = context_->createMaterial();
        material_->setClosestHitProgram(0, program("hit"));
        material_->setAnyHitProgram(0, program("pass_left"));
        GeometryTriangles mesh = context_->createGeometryTriangles();
        mesh->setPrimitiveCount(1);
        mesh->setVertices(3,
                          filled<float>(context_, RT_BUFFER_INPUT, RT_FORMAT_FLOAT3,
                                        {0, 0, 0, 1, 0, 0, 0, 1, 0}, 3),
                          RT_FORMAT_FLOAT3);
        mesh->setAttributeProgram(program("corner_tone"));
        instance_ = context_->createGeometryInstance(mesh, material_);
        instance_["color"]->setFloat(0.6f, 0.7f, 0.8f);
        selector_ = context_->createSelector();
        selector_->setVisitProgram(program("visit"));
        selector_->addChild(moved(disc(0.2f, 0.9f), 0.7f, 0.7f, 0.5f));
        selector_->addChild(moved(disc(0.3f, 0.3f), 0.6f, 0.6f, 0.5f));
        selector_["chosen"]->setInt(0);
        moved_ = moved(disc(0.15f, 0.1f), 0.2f, 0.3f, 1.0f);
        top_ = context_->createGroup();
        top_->setAcceleration(context_->createAcceleration("Trbvh"));
        top_->addChild(grouped(instance_));
        top_->addChild(selector_);
        top_->addChild(moved_);
        context_["top_object"]->set(top_);
    }

    const unsigned width_, height_;
    std::string ptx_;
    Buffer source_, stream_, weights_;
    TextureSampler sampler_;
    Material material_;
    GeometryInstance instance_;
    Selector selector_;
    Transform moved_;
    Group top_;
};

// The largest difference of two bytes.
int difference(const std::vector<unsigned char>& a, const std::vector<unsigned char>& b) {
    int most = 0;
    for (size_t i = 0; i < a.size(); ++i)
        most = std::max(most, std::abs(int(a[i]) - int(b[i])));
    return most;
}

// The nodes of this machine that were started by the mpirun of this process.
std::vector<pid_t> nodes() {
    const auto read = [](const std::string& path) {
        std::ifstream file(path, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(file), {});
    };
    const char* run = std::getenv("PMIX_NAMESPACE");
    require(run, "PMIX_NAMESPACE is set");
    const std::string variable = std::string("PMIX_NAMESPACE=") + run;
    std::vector<pid_t> found;
    DIR* const folder = opendir("/proc");
    while (const dirent* entry = readdir(folder)) {
        const std::string path = std::string("/proc/") + entry->d_name;
        const std::string command = read(path + "/cmdline");
        if (std::string(command.c_str()) == "/proc/self/exe" &&
            std::string(command.c_str() + 15) == "node" &&
            read(path + "/environ").find(variable) != std::string::npos)
            found.push_back(pid_t(std::atoi(entry->d_name)));
    }
    closedir(folder);
    return found;
}

unsigned countOf(RemoteDevice device, RTremotedeviceattribute attribute) {
    unsigned value = 0;
    device->getAttribute(attribute, sizeof value, &value);
    return value;
}

void compare(unsigned ranks, bool kills) {
    const auto nothing = [] {};
    RemoteDevice own = RemoteDeviceObj::create("mpi:", "", "");
    require(countOf(own, RT_REMOTEDEVICE_ATTRIBUTE_NUM_TOTAL_NODES) == ranks, "all ranks count");
    own->reserve(1, 0); // rank 0
    require(countOf(own, RT_REMOTEDEVICE_ATTRIBUTE_NUM_FREE_NODES) == ranks - 1, "one is reserved");
    Scene all(kWidth, kHeight, 12), local(kWidth, kHeight, 12);
    local.context_->setRemoteDevice(own);
    const auto kill = [&] {
        const std::vector<pid_t> list = nodes();
        require(list.size() == ranks - 1, "every other rank has a node");
        ::kill(list[0], SIGKILL);
    };
    for (unsigned i = 0; all.change(i) && local.change(i); ++i) {
        const unsigned subframes = ranks > 1 ? 24 + 2 * i : 6;
        const auto one =
            kills && i == 1 ? all.render(subframes, kill) : all.render(subframes, nothing);
        const auto other = local.render(subframes, nothing);
        const int most = difference(one, other);
        std::printf("change %u: %u subframes, largest difference %d\n", i, subframes, most);
        require(most <= 1, "the pictures are the same");
    }
    if (kills)
        require(countOf(own, RT_REMOTEDEVICE_ATTRIBUTE_NUM_FREE_NODES) == ranks - 2, "one is dead");
    std::printf("all pictures are the same\n");
}

void time(unsigned subframes) {
    Scene scene(320, 240, 4);
    scene.render(20, [] {}); // compiles
    scene.change(1);
    const auto begin = std::chrono::steady_clock::now();
    scene.render(subframes, [] {});
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    std::printf("%u subframes in %.3f s\n", subframes, seconds.count());
}

} // namespace

int main(int argc, char** argv) {
    const std::string what = argc > 1 ? argv[1] : "";
    const unsigned number = argc > 2 ? unsigned(std::atoi(argv[2])) : 1;
    try {
        if (what == "same" || what == "death")
            compare(number, what == "death");
        else if (what == "alone")
            compare(1, false);
        else if (what == "time")
            time(number);
        else
            fail("what is to be done?");
    } catch (const std::exception& error) {
        fail(error.what());
    }
    return 0;
}
