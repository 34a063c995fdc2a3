// SPDX-License-Identifier: Apache-2.0
// Copies and sets of the runtime API between all kinds of memory, in all directions, with all
// errors of their arguments.
#include "driver_cases.h"

#include <cuda_runtime.h>

namespace {

Cases cases;
cudaStream_t stream;

// Prints the result of each form, which is also the runtime's last error.
template <class Call>
void run(const std::string& name, const Place* changed, int forms, Call&& call) {
    cases.run(name, changed, forms, [&](int form) {
        const cudaError_t error = call(form);
        const cudaError_t last = cudaGetLastError();
        if (last != error)
            std::printf("(last %s) ", cudaGetErrorName(last));
        return CUresult(error);
    });
}

const char* const kKindNames[] = {"H2H", "H2D", "D2H", "D2D", "default", "kind 5"};
const cudaMemcpyKind kKinds[] = {cudaMemcpyHostToHost,   cudaMemcpyHostToDevice,
                                 cudaMemcpyDeviceToHost, cudaMemcpyDeviceToDevice,
                                 cudaMemcpyDefault,      cudaMemcpyKind(5)};

struct Shape2D {
    const char* name;
    size_t dstPitch, srcPitch, width, height;
    bool host; // also where host memory is
};
const Shape2D kShapes2D[] = {
    {"rows", 96, 64, 24, 5, true},
    {"width 0", 96, 64, 0, 5, true},
    {"height 0", 96, 64, 24, 0, true},
    {"width 0, pitches 0", 0, 0, 0, 5, true},
    {"height 0, pitches 8", 8, 8, 24, 0, true},
    {"source pitch 23", 96, 23, 24, 5, true},
    {"target pitch 23", 23, 64, 24, 5, true},
    {"target pitch 24", 24, 64, 24, 5, true},
    {"pitches 0", 0, 0, 24, 5, true},
    {"pitches 8, 1 row", 8, 8, 24, 1, true},
    {"pitches 65 and 97", 97, 65, 24, 5, true},
    {"source pitch 2^31", 96, size_t(1) << 31, 24, 1, true},
    {"pitches most, 1 row", SIZE_MAX, SIZE_MAX, 24, 1, true},
    {"over the end", 96, 64, 24, 100, false},
    {"height most", 96, 64, 24, SIZE_MAX, false},
    {"width most", SIZE_MAX, SIZE_MAX, SIZE_MAX, 1, false},
    {"width 2^40", size_t(1) << 40, size_t(1) << 40, size_t(1) << 40, 2, false}};

void copies2D(const Blocks& b) {
    const Place* places[] = {&b.pageable, &b.pinned, &b.device, &b.managed};
    for (const Place* dst : places)
        for (const Place* place : places) {
            const Place* src = place == dst ? &b.other : place;
            if (place == dst && dst != &b.device)
                continue;
            for (int kind = 0; kind < 6; ++kind) {
                const std::string name = src->name + " -> " + dst->name + " " + kKindNames[kind];
                run("linear " + name, dst, 2, [&](int form) {
                    src->fill(1);
                    return form ? cudaMemcpyAsync(dst->bytes + 3, src->bytes + 5, 100, kKinds[kind],
                                                  stream)
                                : cudaMemcpy(dst->bytes + 3, src->bytes + 5, 100, kKinds[kind]);
                });
                run("2D " + name, dst, 2, [&](int form) {
                    src->fill(1);
                    return form ? cudaMemcpy2DAsync(dst->bytes + 3, 96, src->bytes + 5, 64, 24, 5,
                                                    kKinds[kind], stream)
                                : cudaMemcpy2D(dst->bytes + 3, 96, src->bytes + 5, 64, 24, 5,
                                               kKinds[kind]);
                });
                run("3D " + name, dst, 2, [&](int form) {
                    src->fill(1);
                    cudaMemcpy3DParms copy = {};
                    copy.srcPtr = make_cudaPitchedPtr(src->bytes, 64, 48, 9);
                    copy.dstPtr = make_cudaPitchedPtr(dst->bytes, 96, 64, 7);
                    copy.srcPos = make_cudaPos(8, 2, 1);
                    copy.dstPos = make_cudaPos(16, 1, 2);
                    copy.extent = make_cudaExtent(24, 5, 3);
                    copy.kind = kKinds[kind];
                    return form ? cudaMemcpy3DAsync(&copy, stream) : cudaMemcpy3D(&copy);
                });
            }
        }
    struct Pair {
        const Place *src, *dst;
        cudaMemcpyKind kind;
    };
    for (const Pair& p : {Pair{&b.other, &b.device, cudaMemcpyDeviceToDevice},
                          Pair{&b.pageable, &b.device, cudaMemcpyHostToDevice},
                          Pair{&b.device, &b.pinned, cudaMemcpyDeviceToHost},
                          Pair{&b.device, &b.managed, cudaMemcpyDefault}})
        for (const Shape2D& s : kShapes2D) {
            if (!s.host && !(p.src->onDevice && p.dst->onDevice))
                continue;
            run("2D " + p.src->name + " -> " + p.dst->name + ", " + s.name, p.dst, 2,
                [&](int form) {
                    p.src->fill(1);
                    return form ? cudaMemcpy2DAsync(p.dst->bytes, s.dstPitch, p.src->bytes,
                                                    s.srcPitch, s.width, s.height, p.kind, stream)
                                : cudaMemcpy2D(p.dst->bytes, s.dstPitch, p.src->bytes, s.srcPitch,
                                               s.width, s.height, p.kind);
                });
        }
    for (bool source : {true, false})
        for (size_t width : {24, 0})
            run(std::string("2D ") + (source ? "from null, width " : "to null, width ") +
                    std::to_string(width),
                &b.device, 2, [&](int form) {
                    void* dst = source ? b.device.bytes : nullptr;
                    const void* src = source ? nullptr : b.other.bytes;
                    return form ? cudaMemcpy2DAsync(dst, 64, src, 64, width, 2, cudaMemcpyDefault,
                                                    stream)
                                : cudaMemcpy2D(dst, 64, src, 64, width, 2, cudaMemcpyDefault);
                });
}

// ---- three dimensions, with arrays
// ----------------------------------------------------------------
using P3 = cudaMemcpy3DParms;
struct Change {
    const char* name;
    bool anywhere; // else between blocks of the device alone
    void (*apply)(P3&);
};
const Change kChanges[] = {
    {"as it is", true, [](P3&) {}},
    {"width 0", true, [](P3& p) { p.extent.width = 0; }},
    {"height 0", true, [](P3& p) { p.extent.height = 0; }},
    {"depth 0", true, [](P3& p) { p.extent.depth = 0; }},
    {"source pitch 0", true, [](P3& p) { p.srcPtr.pitch = 0; }},
    {"source pitch 8", true, [](P3& p) { p.srcPtr.pitch = 8; }},
    {"target pitch 8", true, [](P3& p) { p.dstPtr.pitch = 8; }},
    {"source height 0", true, [](P3& p) { p.srcPtr.ysize = 0; }},
    {"source height 0, depth 1", true, [](P3& p) { p.srcPtr.ysize = 0, p.extent.depth = 1; }},
    {"source height 4", true, [](P3& p) { p.srcPtr.ysize = 4; }},
    {"source xsize 8", true, [](P3& p) { p.srcPtr.xsize = 8; }},
    {"source x 1", true, [](P3& p) { p.srcPos.x = 1; }},
    {"source x 1000", true, [](P3& p) { p.srcPos.x = 1000; }},
    {"source z 4", true, [](P3& p) { p.srcPos.z = 4; }},
    {"target z 5", true, [](P3& p) { p.dstPos.z = 5; }},
    {"target y 6", true, [](P3& p) { p.dstPos.y = 6; }},
    {"all zero", true, [](P3& p) { p = P3{}; }},
    {"both sources", true,
     [](P3& p) {
         p.srcPtr = p.srcPtr.ptr ? p.srcPtr : p.dstPtr;
         p.srcArray = p.srcArray ? p.srcArray : p.dstArray;
     }},
    {"no source", true, [](P3& p) { p.srcPtr = {}, p.srcArray = nullptr; }},
    {"no target", true, [](P3& p) { p.dstPtr = {}, p.dstArray = nullptr; }},
    {"kind 5", true, [](P3& p) { p.kind = cudaMemcpyKind(5); }},
    {"kind -1", true, [](P3& p) { p.kind = cudaMemcpyKind(-1); }},
    {"width most", false, [](P3& p) { p.extent.width = SIZE_MAX; }},
    {"height most", false, [](P3& p) { p.extent.height = SIZE_MAX; }},
    {"depth most", false, [](P3& p) { p.extent.depth = SIZE_MAX; }},
    {"target x most", false, [](P3& p) { p.dstPos.x = SIZE_MAX; }},
    {"source pitch most", false, [](P3& p) { p.srcPtr.pitch = SIZE_MAX; }},
};

P3 block3D(const Place& src, const Place& dst) {
    P3 copy = {};
    if (src.array)
        copy.srcArray = reinterpret_cast<cudaArray_t>(src.array);
    else
        copy.srcPtr = make_cudaPitchedPtr(src.bytes, 64, 64, 9);
    if (dst.array)
        copy.dstArray = reinterpret_cast<cudaArray_t>(dst.array);
    else
        copy.dstPtr = make_cudaPitchedPtr(dst.bytes, 96, 96, 7);
    copy.srcPos = make_cudaPos(2, 2, 1);
    copy.dstPos = make_cudaPos(4, 1, 2);
    copy.extent = make_cudaExtent(src.array || dst.array ? 6 : 24, 5, 3);
    copy.kind = cudaMemcpyDefault;
    return copy;
}

void copies3D(const Blocks& b, const Place& volume, const Place& solid, const Place& bytes) {
    using Pair = std::pair<const Place*, const Place*>;
    for (auto [src, dst] :
         {Pair{&b.other, &b.device}, Pair{&b.pageable, &b.device}, Pair{&volume, &b.device},
          Pair{&b.device, &volume}, Pair{&b.pinned, &volume}, Pair{&volume, &b.pageable},
          Pair{&volume, &solid}, Pair{&volume, &bytes}, Pair{&bytes, &volume}}) {
        const bool host = (!src->onDevice && !src->array) || (!dst->onDevice && !dst->array);
        for (const Change& change : kChanges) {
            if (!change.anywhere && (host || src->array || dst->array))
                continue;
            P3 copy = block3D(*src, *dst);
            change.apply(copy);
            run("3D " + src->name + " -> " + dst->name + ", " + change.name, dst, 2,
                [&, src = src](int form) {
                    src->fill(1);
                    return form ? cudaMemcpy3DAsync(&copy, stream) : cudaMemcpy3D(&copy);
                });
        }
        for (int kind = 0; kind < 5; ++kind) {
            P3 copy = block3D(*src, *dst);
            copy.kind = kKinds[kind];
            run("3D " + src->name + " -> " + dst->name + " " + kKindNames[kind], dst, 2,
                [&, src = src](int form) {
                    src->fill(1);
                    return form ? cudaMemcpy3DAsync(&copy, stream) : cudaMemcpy3D(&copy);
                });
        }
        for (int device : {0, 1, -1}) {
            const P3 plain = block3D(*src, *dst);
            cudaMemcpy3DPeerParms copy = {};
            copy.srcArray = plain.srcArray, copy.srcPos = plain.srcPos, copy.srcPtr = plain.srcPtr;
            copy.dstArray = plain.dstArray, copy.dstPos = plain.dstPos, copy.dstPtr = plain.dstPtr;
            copy.extent = plain.extent;
            copy.srcDevice = device;
            run("3D peer " + src->name + " -> " + dst->name + " from " + std::to_string(device),
                dst, 2, [&, src = src](int form) {
                    src->fill(1);
                    return form ? cudaMemcpy3DPeerAsync(&copy, stream) : cudaMemcpy3DPeer(&copy);
                });
        }
    }
    run("3D null", nullptr, 2, [&](int form) {
        return form ? cudaMemcpy3DAsync(nullptr, stream) : cudaMemcpy3D(nullptr);
    });
    run("3D peer null", nullptr, 2, [&](int form) {
        return form ? cudaMemcpy3DPeerAsync(nullptr, stream) : cudaMemcpy3DPeer(nullptr);
    });
    for (int device : {0, 1, -1})
        run("peer to " + std::to_string(device), &b.device, 2, [&](int form) {
            b.other.fill(1);
            return form ? cudaMemcpyPeerAsync(b.device.bytes, device, b.other.bytes, 0, 100, stream)
                        : cudaMemcpyPeer(b.device.bytes, device, b.other.bytes, 0, 100);
        });
}

// ---- to, from and between arrays
// ------------------------------------------------------------------
struct Window {
    const char* name;
    size_t x, y, pitch, width, height;
};
const Window kWindows[] = {{"rows", 8, 1, 64, 24, 5},           {"x 2", 2, 1, 64, 24, 5},
                           {"width 22", 8, 1, 64, 22, 5},       {"width 0", 8, 1, 64, 0, 5},
                           {"height 0", 8, 1, 64, 24, 0},       {"pitch 23", 8, 1, 23, 24, 5},
                           {"pitch 0", 8, 1, 0, 24, 5},         {"pitch 8, 1 row", 8, 1, 8, 24, 1},
                           {"to the end", 104, 11, 64, 24, 5},  {"over the row", 108, 1, 64, 24, 5},
                           {"over the rows", 8, 12, 64, 24, 5}, {"row 16", 8, 16, 64, 24, 1},
                           {"x most", SIZE_MAX, 0, 64, 24, 1},  {"y most", 0, SIZE_MAX, 64, 24, 1}};

void arrays(const Blocks& b, const Place& flat, const Place& other, const Place& volume) {
    const auto handle = [](const Place& place) {
        return reinterpret_cast<cudaArray_t>(place.array);
    };
    for (const Place* place : {&b.pageable, &b.pinned, &b.device, &b.managed})
        for (const Window& w : kWindows) {
            for (int kind = 0; kind < (&w == kWindows ? 6 : 1); ++kind) {
                const bool all = &w == kWindows;
                const cudaMemcpyKind to = all               ? kKinds[kind]
                                          : place->onDevice ? cudaMemcpyDeviceToDevice
                                                            : cudaMemcpyHostToDevice;
                const cudaMemcpyKind from = all               ? kKinds[kind]
                                            : place->onDevice ? cudaMemcpyDeviceToDevice
                                                              : cudaMemcpyDeviceToHost;
                const std::string name =
                    place->name + ", " + w.name + (all ? std::string(" ") + kKindNames[kind] : "");
                run("2DToArray " + name, &flat, 2, [&](int form) {
                    place->fill(1);
                    return form ? cudaMemcpy2DToArrayAsync(handle(flat), w.x, w.y, place->bytes,
                                                           w.pitch, w.width, w.height, to, stream)
                                : cudaMemcpy2DToArray(handle(flat), w.x, w.y, place->bytes, w.pitch,
                                                      w.width, w.height, to);
                });
                run("2DFromArray " + name, place, 2, [&](int form) {
                    flat.fill(1);
                    return form ? cudaMemcpy2DFromArrayAsync(place->bytes, w.pitch, handle(flat),
                                                             w.x, w.y, w.width, w.height, from,
                                                             stream)
                                : cudaMemcpy2DFromArray(place->bytes, w.pitch, handle(flat), w.x,
                                                        w.y, w.width, w.height, from);
                });
            }
        }
    for (const Window& w : kWindows)
        for (int kind = 0; kind < (&w == kWindows ? 6 : 1); ++kind) {
            const cudaMemcpyKind how = &w == kWindows ? kKinds[kind] : cudaMemcpyDeviceToDevice;
            const std::string name =
                std::string(w.name) + (&w == kWindows ? std::string(" ") + kKindNames[kind] : "");
            run("2DArrayToArray " + name, &flat, 1, [&](int) {
                other.fill(1);
                return cudaMemcpy2DArrayToArray(handle(flat), 16, 2, handle(other), w.x, w.y,
                                                w.width, w.height, how);
            });
        }
    // Bytes that run on from row to row.
    struct Run {
        const char* name;
        size_t x, y, bytes;
    };
    for (const Run& r :
         {Run{"in a row", 8, 1, 24}, Run{"a row", 0, 1, 128}, Run{"over a row's end", 120, 1, 24},
          Run{"two rows", 0, 1, 256}, Run{"a row and a half", 8, 1, 200}, Run{"nothing", 8, 1, 0},
          Run{"all", 0, 0, 2048}, Run{"x 2", 2, 0, 8}})
        for (const Place* place : {&b.pageable, &b.device}) {
            const cudaMemcpyKind to =
                place->onDevice ? cudaMemcpyDeviceToDevice : cudaMemcpyHostToDevice;
            const cudaMemcpyKind from =
                place->onDevice ? cudaMemcpyDeviceToDevice : cudaMemcpyDeviceToHost;
            run(std::string("ToArray ") + place->name + ", " + r.name, &flat, 2, [&](int form) {
                place->fill(1);
                return form ? cudaMemcpyToArrayAsync(handle(flat), r.x, r.y, place->bytes, r.bytes,
                                                     to, stream)
                            : cudaMemcpyToArray(handle(flat), r.x, r.y, place->bytes, r.bytes, to);
            });
            run(std::string("FromArray ") + place->name + ", " + r.name, place, 2, [&](int form) {
                flat.fill(1);
                return form ? cudaMemcpyFromArrayAsync(place->bytes, handle(flat), r.x, r.y,
                                                       r.bytes, from, stream)
                            : cudaMemcpyFromArray(place->bytes, handle(flat), r.x, r.y, r.bytes,
                                                  from);
            });
            if (place->onDevice && r.bytes < 2048)
                run(std::string("ArrayToArray ") + r.name, &flat, 1, [&](int) {
                    other.fill(1);
                    return cudaMemcpyArrayToArray(handle(flat), 8, 2, handle(other), r.x, r.y,
                                                  r.bytes, cudaMemcpyDeviceToDevice);
                });
        }
    run("2DToArray null array", nullptr, 1, [&](int) {
        return cudaMemcpy2DToArray(nullptr, 0, 0, b.device.bytes, 64, 24, 2,
                                   cudaMemcpyDeviceToDevice);
    });
    run("2DToArray from null", &flat, 1, [&](int) {
        return cudaMemcpy2DToArray(handle(flat), 0, 0, nullptr, 64, 24, 2,
                                   cudaMemcpyDeviceToDevice);
    });
    run("2DToArray volume", &volume, 1, [&](int) {
        b.device.fill(1);
        return cudaMemcpy2DToArray(handle(volume), 8, 1, b.device.bytes, 64, 24, 2,
                                   cudaMemcpyDeviceToDevice);
    });
    run("2DFromArray volume", &b.device, 1, [&](int) {
        volume.fill(1);
        return cudaMemcpy2DFromArray(b.device.bytes, 64, handle(volume), 8, 1, 24, 2,
                                     cudaMemcpyDeviceToDevice);
    });
}

// ---- sets
// -----------------------------------------------------------------------------------------
void sets(const Blocks& b) {
    for (const Shape2D& s : kShapes2D) {
        if (s.width == SIZE_MAX || s.height == SIZE_MAX) // drivers do not survive these
            continue;
        run(std::string("set 2D ") + s.name, &b.device, 2, [&](int form) {
            return form ? cudaMemset2DAsync(b.device.bytes, s.srcPitch, 0x123, s.width, s.height,
                                            stream)
                        : cudaMemset2D(b.device.bytes, s.srcPitch, 0x123, s.width, s.height);
        });
    }
    struct Set3D {
        const char* name;
        size_t pitch, xsize, ysize;
        cudaExtent extent;
    };
    const Set3D kSets[] = {{"box", 64, 48, 9, {24, 5, 3}},
                           {"depth 0", 64, 48, 9, {24, 5, 0}},
                           {"width 0", 64, 48, 9, {0, 5, 3}},
                           {"height 0", 64, 48, 9, {24, 0, 3}},
                           {"height over ysize", 64, 48, 4, {24, 5, 3}},
                           {"height over ysize, depth 1", 64, 48, 4, {24, 5, 1}},
                           {"width over xsize", 64, 16, 9, {24, 5, 3}},
                           {"pitch 23", 23, 16, 9, {24, 5, 3}},
                           {"pitch 0", 0, 16, 9, {24, 5, 3}},
                           {"pitch 0, 1 row", 0, 16, 9, {24, 1, 1}},
                           {"ysize 0", 64, 48, 0, {24, 5, 3}},
                           {"ysize 0, depth 1", 64, 48, 0, {24, 5, 1}},
                           {"width most", 64, 48, 9, {SIZE_MAX, 5, 3}},
                           {"height most", 64, 48, 9, {24, SIZE_MAX, 1}}};
    for (const Set3D& s : kSets)
        run(std::string("set 3D ") + s.name, &b.device, 2, [&](int form) {
            const cudaPitchedPtr ptr =
                make_cudaPitchedPtr(b.device.bytes, s.pitch, s.xsize, s.ysize);
            return form ? cudaMemset3DAsync(ptr, 0x77, s.extent, stream)
                        : cudaMemset3D(ptr, 0x77, s.extent);
        });
    for (const Place* place : {&b.pageable, &b.pinned, &b.managed})
        run("set of " + place->name, place, 2, [&](int form) {
            return form ? cudaMemsetAsync(place->bytes, 5, 99, stream)
                        : cudaMemset(place->bytes, 5, 99);
        });
    for (size_t bytes : {size_t(0), kBytes, kBytes + 1, size_t(4) << 20})
        run("set " + std::to_string(bytes), &b.device, 2, [&](int form) {
            return form ? cudaMemsetAsync(b.device.bytes, 5, bytes, stream)
                        : cudaMemset(b.device.bytes, 5, bytes);
        });
    for (size_t bytes : {0, 4})
        run("set of null " + std::to_string(bytes), nullptr, 2, [&](int form) {
            return form ? cudaMemsetAsync(nullptr, 5, bytes, stream)
                        : cudaMemset(nullptr, 5, bytes);
        });
}

} // namespace

int main() {
    cudaFree(nullptr);
    if (cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking) != cudaSuccess)
        return 1;
    const Blocks blocks;
    const Place flat = makeArray("array", 32, 16, 0);
    const Place other = makeArray("another", 32, 16, 0);
    const Place volume = makeArray("volume", 16, 8, 6);
    const Place solid = makeArray("solid", 16, 8, 6);
    const Place bytes = makeArray("bytes", 64, 8, 6, 0, CU_AD_FORMAT_UNSIGNED_INT8, 1, 1);
    copies2D(blocks);
    copies3D(blocks, volume, solid, bytes);
    arrays(blocks, flat, other, volume);
    sets(blocks);
    return 0;
}
