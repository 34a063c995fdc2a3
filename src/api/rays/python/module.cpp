// SPDX-License-Identifier: Apache-2.0
// The Python module `sunstone`: sunstone/rays.h for NumPy arrays and arrays that offer DLPack,
// such as tensors of PyTorch on the CPU or a CUDA device. The functions read and write arrays in
// place. They refuse arrays of another type or layout.
#include "sunstone/rays.h"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace py = pybind11;

namespace {

// The parts of DLPack's ABI that are read here (version 0, capsules named "dltensor").
struct DlTensor {
    void* data;
    int32_t deviceType, deviceId;
    int32_t dimensions;
    uint8_t typeCode, typeBits;
    uint16_t lanes;
    int64_t* shape;
    int64_t* strides; // in elements, null: contiguous
    uint64_t byteOffset;
};
enum DlDevice : int32_t { kDlCpu = 1, kDlCuda = 2, kDlCudaHost = 3, kDlCudaManaged = 13 };
enum DlType : uint8_t { kDlInt = 0, kDlUint = 1, kDlFloat = 2 };

// An array of 4-byte numbers in rows, contiguous. Keeps its owner alive.
struct Array {
    py::object owner;
    void* data = nullptr;
    size_t rows = 0, columns = 0;
    bool onDevice = false;
};

[[noreturn]] void refuse(const char* name, const std::string& rule) {
    throw py::value_error(std::string(name) + " " + rule);
}

void checkShape(Array& array, const char* name, const std::vector<int64_t>& shape, size_t columns) {
    if (shape.size() != 2 || size_t(shape[1]) != columns)
        refuse(name, "must have shape (n, " + std::to_string(columns) + ")");
    array.rows = size_t(shape[0]);
    array.columns = columns;
}

Array fromNumpy(const py::array& given, const char* name, size_t columns, bool isFloat,
                bool written) {
    Array array;
    array.owner = given;
    const char kind = given.dtype().kind();
    if (given.itemsize() != 4 || (isFloat ? kind != 'f' : kind != 'i' && kind != 'u'))
        refuse(name, isFloat ? "must be float32" : "must be int32");
    if (!given.dtype().attr("isnative").cast<bool>())
        refuse(name, "must have the machine's byte order");
    if (!(given.flags() & py::array::c_style))
        refuse(name, "must be contiguous");
    if (written && !given.writeable())
        refuse(name, "must be writeable");
    checkShape(array, name, {given.shape(), given.shape() + given.ndim()}, columns);
    array.data = const_cast<void*>(given.data());
    return array;
}

Array fromDlpack(const py::object& given, const char* name, size_t columns, bool isFloat) {
    Array array;
    py::capsule capsule = given.attr("__dlpack__")();
    const auto* const tensor = static_cast<const DlTensor*>(capsule.get_pointer());
    const bool type = tensor->typeBits == 32 && tensor->lanes == 1 &&
                      (isFloat ? tensor->typeCode == kDlFloat
                               : tensor->typeCode == kDlInt || tensor->typeCode == kDlUint);
    if (!type)
        refuse(name, isFloat ? "must be float32" : "must be int32");
    checkShape(array, name, {tensor->shape, tensor->shape + tensor->dimensions}, columns);
    if (tensor->strides && array.rows > 1 &&
        (tensor->strides[1] != 1 || tensor->strides[0] != int64_t(columns)))
        refuse(name, "must be contiguous");
    switch (tensor->deviceType) {
    case kDlCpu:
    case kDlCudaHost:
        break;
    case kDlCuda:
    case kDlCudaManaged:
        array.onDevice = true;
        break;
    default:
        refuse(name, "is on a device other than the CPU and CUDA");
    }
    array.data = static_cast<uint8_t*>(tensor->data) + tensor->byteOffset;
    array.owner = std::move(capsule); // its destructor releases the tensor
    return array;
}

Array arrayOf(const py::object& given, const char* name, size_t columns, bool isFloat = true,
              bool written = false) {
    if (py::isinstance<py::array>(given))
        return fromNumpy(py::array(given), name, columns, isFloat, written);
    if (py::hasattr(given, "__dlpack__"))
        return fromDlpack(given, name, columns, isFloat);
    refuse(name, "is neither a NumPy array nor offers DLPack");
}

void check(SunstoneResult result) {
    if (result == SUNSTONE_OK)
        return;
    const std::string text = sunstoneLastError();
    if (result == SUNSTONE_INVALID_VALUE || result == SUNSTONE_INVALID_HANDLE)
        throw py::value_error(text);
    if (result == SUNSTONE_OUT_OF_MEMORY)
        throw std::bad_alloc();
    throw std::runtime_error(text);
}

template <class Call>
void run(const Call& call) {
    SunstoneResult result;
    {
        py::gil_scoped_release released;
        result = call();
    }
    check(result);
}

// A scene of a mesh, or of instances of such scenes.
class Scene {
public:
    Scene(const py::object& vertices, const py::object& triangles) {
        const Array points = arrayOf(vertices, "vertices", 3);
        std::optional<Array> indices;
        if (!triangles.is_none())
            indices = arrayOf(triangles, "triangles", 3, false);
        const SunstoneMesh mesh = {static_cast<const float*>(points.data), points.rows,
                                   indices ? static_cast<const int32_t*>(indices->data) : nullptr,
                                   indices ? indices->rows : 0};
        run([&] { return sunstoneSceneCreate(&mesh, &scene_); });
    }
    explicit Scene(const std::vector<std::pair<py::object, py::object>>& instances) {
        std::vector<SunstoneInstance> list;
        for (const auto& [scene, matrix] : instances) {
            if (!py::isinstance<Scene>(scene))
                refuse("an instance", "must have a scene");
            const auto rows = py::array_t < float,
                       py::array::c_style | py::array::forcecast > ::ensure(matrix);
            if (!rows || rows.ndim() != 2 || rows.shape(0) < 3 || rows.shape(1) != 4)
                refuse("a transform", "must have shape (3, 4) or (4, 4)");
            SunstoneInstance instance;
            instance.scene = scene.cast<const Scene&>().scene_;
            std::copy_n(rows.data(), 12, instance.transform);
            list.push_back(instance);
        }
        run([&] { return sunstoneSceneCreateInstances(list.data(), list.size(), &scene_); });
    }
    ~Scene() {
        if (scene_)
            sunstoneSceneDestroy(scene_);
    }
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;

    py::object trace(const py::object& rays, const py::object& out, bool any) const {
        const Array in = arrayOf(rays, "rays", 8);
        const auto ask = any ? sunstoneAnyHits : sunstoneClosestHits;
        const auto* const from = static_cast<const SunstoneRay*>(in.data);
        if (!out.is_none()) {
            const Array to = arrayOf(out, "out", 5, true, true);
            if (to.rows != in.rows)
                refuse("out", "must have a row for each ray");
            run([&] { return ask(scene_, from, in.rows, static_cast<SunstoneHit*>(to.data)); });
            return out;
        }
        if (in.onDevice)
            refuse("rays", "are on a device: out must be an array there");
        py::array_t<SunstoneHit> hits(static_cast<py::ssize_t>(in.rows));
        SunstoneHit* const to = hits.mutable_data();
        run([&] { return ask(scene_, from, in.rows, to); });
        return hits;
    }

    py::tuple all(const py::object& rays) const {
        const Array in = arrayOf(rays, "rays", 8);
        py::array_t<size_t> offsets(static_cast<py::ssize_t>(in.rows + 1));
        size_t capacity = 4 * in.rows + 16;
        for (;;) {
            py::array_t<SunstoneHit> hits(static_cast<py::ssize_t>(capacity));
            SunstoneHit* const to = hits.mutable_data();
            size_t* const counts = offsets.mutable_data();
            SunstoneResult result;
            {
                py::gil_scoped_release released;
                result = sunstoneAllHits(scene_, static_cast<const SunstoneRay*>(in.data), in.rows,
                                         to, capacity, counts);
            }
            if (result == SUNSTONE_TOO_SMALL) {
                capacity = counts[in.rows];
                continue;
            }
            check(result);
            hits.resize({static_cast<py::ssize_t>(counts[in.rows])}, false);
            return py::make_tuple(hits, offsets);
        }
    }

    py::array_t<SunstoneNearest> nearest(const py::object& points, float farthest) const {
        const Array in = arrayOf(points, "points", 3);
        py::array_t<SunstoneNearest> found(static_cast<py::ssize_t>(in.rows));
        SunstoneNearest* const to = found.mutable_data();
        run([&] {
            return sunstoneNearestPoints(scene_, static_cast<const float*>(in.data), in.rows,
                                         farthest, to);
        });
        return found;
    }

private:
    SunstoneScene scene_ = nullptr;
};

// Rays in the format of queries, from arrays of origins and directions.
py::array_t<float> makeRays(const py::array_t<float>& origins, const py::array_t<float>& directions,
                            float tmin, float tmax) {
    if (origins.ndim() != 2 || origins.shape(1) != 3 || directions.ndim() != 2 ||
        directions.shape(1) != 3 ||
        (origins.shape(0) != directions.shape(0) && origins.shape(0) != 1))
        throw py::value_error("origins must have shape (n, 3) or (1, 3), directions (n, 3)");
    const py::ssize_t count = directions.shape(0);
    py::array_t<float> rays({count, py::ssize_t(8)});
    auto to = rays.mutable_unchecked<2>();
    const auto o = origins.unchecked<2>(), d = directions.unchecked<2>();
    for (py::ssize_t i = 0; i < count; ++i) {
        for (py::ssize_t k = 0; k < 3; ++k) {
            to(i, k) = o(origins.shape(0) == 1 ? 0 : i, k);
            to(i, 4 + k) = d(i, k);
        }
        to(i, 3) = tmin;
        to(i, 7) = tmax;
    }
    return rays;
}

} // namespace

PYBIND11_MODULE(sunstone, module) {
    PYBIND11_NUMPY_DTYPE(SunstoneHit, t, triangle, instance, u, v);
    PYBIND11_NUMPY_DTYPE(SunstoneNearest, distance, triangle, instance, u, v, point);
    module.doc() = "Rays against triangles, on CPUs and CUDA GPUs.";
    const float infinity = std::numeric_limits<float>::infinity();
    module.def("rays", &makeRays, py::arg("origins"), py::arg("directions"), py::arg("tmin") = 0.0f,
               py::arg("tmax") = infinity,
               "Rays as an array (n, 8): origin, tmin, direction, tmax. One origin serves all.");
    constexpr const char* kMesh =
        "A mesh: vertices (n, 3) float32, triangles (m, 3) int32; without triangles every three "
        "vertices are one. Arrays in memory of a CUDA device make a scene there.";
    py::class_<Scene>(module, "Scene")
        // Before the list of pairs, because pybind11 takes an array of two columns for one.
        .def(py::init<const py::array&, const py::object&>(), py::arg("vertices").noconvert(),
             py::arg("triangles") = py::none(), kMesh)
        .def(py::init<const std::vector<std::pair<py::object, py::object>>&>(),
             py::arg("instances"), "A list of (scene, matrix): 3 x 4 or 4 x 4, object to world.")
        .def(py::init<const py::object&, const py::object&>(), py::arg("vertices"),
             py::arg("triangles") = py::none(), kMesh)
        .def(
            "closest",
            [](const Scene& s, const py::object& rays, const py::object& out) {
                return s.trace(rays, out, false);
            },
            py::arg("rays"), py::arg("out") = py::none(),
            "The nearest hit of each ray, with fields t (negative: none), triangle, instance, u "
            "and v; or these as rows of five in `out`.")
        .def(
            "any",
            [](const Scene& s, const py::object& rays, const py::object& out) {
                return s.trace(rays, out, true);
            },
            py::arg("rays"), py::arg("out") = py::none(), "As closest(), but any hit.")
        .def("all", &Scene::all, py::arg("rays"),
             "All hits and offsets: those of ray i are hits[offsets[i]:offsets[i + 1]].")
        .def("nearest", &Scene::nearest, py::arg("points"), py::arg("farthest") = infinity,
             "The nearest point of the triangles to each point (n, 3), with fields distance "
             "(negative: none), triangle, instance, u, v and point.");
}
