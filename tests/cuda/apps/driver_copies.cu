// SPDX-License-Identifier: Apache-2.0
// Copies and sets of the driver API between all kinds of memory and sorts of arrays, with all
// errors of their arguments.
#include "driver_cases.h"

namespace {

Cases cases;

// ---- one side of a copy -------------------------------------------------------------------------
struct End {
    std::string name;
    const Place* place;
    CUmemorytype type;
};
End endOf(const Place& place) {
    return {place.name, &place,
            place.array      ? CU_MEMORYTYPE_ARRAY
            : place.onDevice ? CU_MEMORYTYPE_DEVICE
                             : CU_MEMORYTYPE_HOST};
}

// Works on descriptions of two and three dimensions.
template <class Copy>
void setEnds(Copy& copy, const End& src, const End& dst) {
    copy.srcMemoryType = src.type;
    copy.srcHost = src.place->bytes;
    copy.srcDevice = src.place->address();
    copy.srcArray = src.place->array;
    copy.dstMemoryType = dst.type;
    copy.dstHost = dst.place->bytes;
    copy.dstDevice = dst.place->address();
    copy.dstArray = dst.place->array;
}

void run2D(const std::string& name, const CUDA_MEMCPY2D& copy, const Place& src, const Place& dst) {
    cases.run("2D " + name, &dst, 3, [&](int form) {
        if (&src != &dst)
            src.fill(1);
        return form == 0   ? cuMemcpy2D(&copy)
               : form == 1 ? cuMemcpy2DUnaligned(&copy)
                           : cuMemcpy2DAsync(&copy, cases.stream);
    });
}
void run3D(const std::string& name, const CUDA_MEMCPY3D& copy, const Place& src, const Place& dst) {
    cases.run("3D " + name, &dst, 2, [&](int form) {
        if (&src != &dst)
            src.fill(1);
        return form == 0 ? cuMemcpy3D(&copy) : cuMemcpy3DAsync(&copy, cases.stream);
    });
}

CUDA_MEMCPY2D block2D(const End& src, const End& dst) {
    CUDA_MEMCPY2D copy = {};
    setEnds(copy, src, dst);
    copy.srcXInBytes = 8, copy.srcY = 2, copy.srcPitch = 64;
    copy.dstXInBytes = 16, copy.dstY = 1, copy.dstPitch = 96;
    copy.WidthInBytes = 24, copy.Height = 5;
    return copy;
}
CUDA_MEMCPY3D block3D(const End& src, const End& dst) {
    CUDA_MEMCPY3D copy = {};
    setEnds(copy, src, dst);
    copy.srcXInBytes = 8, copy.srcY = 2, copy.srcZ = 1, copy.srcPitch = 64, copy.srcHeight = 9;
    copy.dstXInBytes = 16, copy.dstY = 1, copy.dstZ = 2, copy.dstPitch = 96, copy.dstHeight = 7;
    copy.WidthInBytes = 24, copy.Height = 5, copy.Depth = 3;
    return copy;
}

// ---- every kind of memory as every type
// -----------------------------------------------------------
void places(const Blocks& blocks, const Place& array) {
    std::vector<End> ends;
    for (const Place* place : {&blocks.pageable, &blocks.pinned, &blocks.device, &blocks.managed})
        for (auto [type, name] : {std::pair{CU_MEMORYTYPE_HOST, " as host"},
                                  std::pair{CU_MEMORYTYPE_DEVICE, " as device"},
                                  std::pair{CU_MEMORYTYPE_UNIFIED, " as unified"}})
            ends.push_back({place->name + name, place, type});
    ends.push_back(endOf(array));
    for (const End& src : ends)
        for (const End& dst : ends) {
            const Place& from =
                src.place == dst.place && !dst.place->array ? blocks.other : *src.place;
            if (&from == &blocks.other && src.place != &blocks.device)
                continue; // one block of each kind is enough
            End source = src;
            source.place = &from;
            if (src.place == dst.place)
                continue;
            run2D(src.name + " -> " + dst.name, block2D(source, dst), from, *dst.place);
        }
}

// ---- one thing changed at a time ---------------------------------------------------------------
// Targets of a change; some changes crash drivers on some targets.
enum Sides { kAny, kNoHost, kBlocks };
template <class Copy>
struct Change {
    const char* name;
    Sides sides;
    void (*apply)(Copy&);
};
using C2 = CUDA_MEMCPY2D;
const Change<C2> kChanges2D[] = {
    {"as it is", kAny, [](C2&) {}},
    {"width 0", kAny, [](C2& c) { c.WidthInBytes = 0; }},
    {"height 0", kAny, [](C2& c) { c.Height = 0; }},
    {"width 0, null addresses", kAny,
     [](C2& c) {
         c.WidthInBytes = 0;
         c.srcHost = c.dstHost = nullptr;
         c.srcDevice = c.dstDevice = 0;
         c.srcArray = c.dstArray = nullptr;
     }},
    {"width 0, type 9", kAny, [](C2& c) { c.WidthInBytes = 0, c.srcMemoryType = CUmemorytype(9); }},
    {"source pitch 0", kAny, [](C2& c) { c.srcPitch = 0; }},
    {"source pitch 0, x 0", kAny, [](C2& c) { c.srcPitch = c.srcXInBytes = 0; }},
    {"target pitch 0", kAny, [](C2& c) { c.dstPitch = 0; }},
    {"target pitch 0, x 0", kAny, [](C2& c) { c.dstPitch = c.dstXInBytes = 0; }},
    {"source pitch 23", kAny, [](C2& c) { c.srcPitch = 23; }},
    {"source pitch 24", kAny, [](C2& c) { c.srcPitch = 24; }},
    {"source pitch 31", kAny, [](C2& c) { c.srcPitch = 31; }},
    {"source pitch 32", kAny, [](C2& c) { c.srcPitch = 32; }},
    {"target pitch 39", kAny, [](C2& c) { c.dstPitch = 39; }},
    {"target pitch 40", kAny, [](C2& c) { c.dstPitch = 40; }},
    {"pitches 65 and 97", kAny, [](C2& c) { c.srcPitch = 65, c.dstPitch = 97; }},
    {"height 1, source pitch 8", kAny, [](C2& c) { c.Height = 1, c.srcPitch = 8; }},
    {"height 1, pitches 24", kAny, [](C2& c) { c.Height = 1, c.srcPitch = c.dstPitch = 24; }},
    {"source x 7", kAny, [](C2& c) { c.srcXInBytes = 7; }},
    {"target x 13", kAny, [](C2& c) { c.dstXInBytes = 13; }},
    {"width 23", kAny, [](C2& c) { c.WidthInBytes = 23; }},
    {"width 2", kAny, [](C2& c) { c.WidthInBytes = 2; }},
    {"source rows 11 to 15", kAny, [](C2& c) { c.srcY = 11; }},
    {"source rows 12 to 16", kAny, [](C2& c) { c.srcY = 12; }},
    {"target rows 11 to 15", kAny, [](C2& c) { c.dstY = 11; }},
    {"target rows 12 to 16", kAny, [](C2& c) { c.dstY = 12; }},
    {"source row 16 alone", kAny, [](C2& c) { c.srcY = 16, c.Height = 1; }},
    {"source x 104, pitch 128", kAny, [](C2& c) { c.srcXInBytes = 104, c.srcPitch = 128; }},
    {"source x 108, pitch 256", kAny, [](C2& c) { c.srcXInBytes = 108, c.srcPitch = 256; }},
    {"target x 104, pitch 128", kAny, [](C2& c) { c.dstXInBytes = 104, c.dstPitch = 128; }},
    {"target x 108, pitch 256", kAny, [](C2& c) { c.dstXInBytes = 108, c.dstPitch = 256; }},
    {"source up to its end", kNoHost, [](C2& c) { c.srcY = 123, c.srcXInBytes = 40; }},
    {"source 1 byte over its end", kNoHost,
     [](C2& c) { c.srcY = 123, c.srcXInBytes = 40, c.srcPitch = 64, c.srcDevice += 1; }},
    {"source 1 row over its end", kNoHost, [](C2& c) { c.srcY = 124; }},
    {"target 1 row over its end", kNoHost, [](C2& c) { c.dstY = 81; }},
    {"source far over its end", kNoHost, [](C2& c) { c.srcY = size_t(1) << 24; }},
    {"target far over its end", kNoHost, [](C2& c) { c.dstY = size_t(1) << 24; }},
    {"source type 0", kAny, [](C2& c) { c.srcMemoryType = CUmemorytype(0); }},
    {"source type 5", kAny, [](C2& c) { c.srcMemoryType = CUmemorytype(5); }},
    {"target type 0", kAny, [](C2& c) { c.dstMemoryType = CUmemorytype(0); }},
    {"target type 2147483647", kAny, [](C2& c) { c.dstMemoryType = CUmemorytype(0x7fffffff); }},
    {"source null", kAny,
     [](C2& c) { c.srcHost = nullptr, c.srcDevice = 0, c.srcArray = nullptr; }},
    {"target null", kAny,
     [](C2& c) { c.dstHost = nullptr, c.dstDevice = 0, c.dstArray = nullptr; }},
    {"source pitch 2147483647, height 1", kAny,
     [](C2& c) { c.srcPitch = 0x7fffffff, c.srcY = 0, c.Height = 1; }},
    {"source pitch 2147483648, height 1", kAny,
     [](C2& c) { c.srcPitch = 0x80000000u, c.srcY = 0, c.Height = 1; }},
    {"target pitch 2147483648, height 1", kAny,
     [](C2& c) { c.dstPitch = 0x80000000u, c.dstY = 0, c.Height = 1; }},
    {"source pitch most, height 1", kAny,
     [](C2& c) { c.srcPitch = SIZE_MAX, c.srcY = 0, c.Height = 1; }},
    {"width most", kBlocks, [](C2& c) { c.WidthInBytes = SIZE_MAX; }},
    {"width 2^40, pitches 2^40", kBlocks,
     [](C2& c) { c.WidthInBytes = c.srcPitch = c.dstPitch = size_t(1) << 40; }},
    {"width 2^31 - 32, pitches 2^31 - 1", kBlocks,
     [](C2& c) { c.WidthInBytes = (1u << 31) - 32, c.srcPitch = c.dstPitch = 0x7fffffff; }},
    {"height most", kBlocks, [](C2& c) { c.Height = SIZE_MAX; }},
    {"height 2^40", kBlocks, [](C2& c) { c.Height = size_t(1) << 40; }},
    {"source x most", kBlocks, [](C2& c) { c.srcXInBytes = SIZE_MAX; }},
    {"source y most", kBlocks, [](C2& c) { c.srcY = SIZE_MAX; }},
    {"target x most", kBlocks, [](C2& c) { c.dstXInBytes = SIZE_MAX; }},
    {"target y most", kBlocks, [](C2& c) { c.dstY = SIZE_MAX; }},
};

using C3 = CUDA_MEMCPY3D;
const Change<C3> kChanges3D[] = {
    {"as it is", kAny, [](C3&) {}},
    {"width 0", kAny, [](C3& c) { c.WidthInBytes = 0; }},
    {"height 0", kAny, [](C3& c) { c.Height = 0; }},
    {"depth 0", kAny, [](C3& c) { c.Depth = 0; }},
    {"source pitch 0", kAny, [](C3& c) { c.srcPitch = 0; }},
    {"source pitch 0, x 0", kAny, [](C3& c) { c.srcPitch = c.srcXInBytes = 0; }},
    {"source pitch 31", kAny, [](C3& c) { c.srcPitch = 31; }},
    {"target pitch 39", kAny, [](C3& c) { c.dstPitch = 39; }},
    {"source height 0", kAny, [](C3& c) { c.srcHeight = 0; }},
    {"target height 0", kAny, [](C3& c) { c.dstHeight = 0; }},
    {"source height 0, depth 1", kAny, [](C3& c) { c.srcHeight = 0, c.Depth = 1; }},
    {"heights 0, depth 1, z 0", kAny,
     [](C3& c) { c.srcHeight = c.dstHeight = c.srcZ = c.dstZ = 0, c.Depth = 1; }},
    {"source height 4", kAny, [](C3& c) { c.srcHeight = 4; }},
    {"source height 6", kAny, [](C3& c) { c.srcHeight = 6; }},
    {"source height 6, depth 1", kAny, [](C3& c) { c.srcHeight = 6, c.Depth = 1; }},
    {"target height 5", kAny, [](C3& c) { c.dstHeight = 5; }},
    {"source x 7", kAny, [](C3& c) { c.srcXInBytes = 7; }},
    {"target x 13", kAny, [](C3& c) { c.dstXInBytes = 13; }},
    {"width 23", kAny, [](C3& c) { c.WidthInBytes = 23; }},
    {"source slices 3 to 5", kAny, [](C3& c) { c.srcZ = 3; }},
    {"source slices 4 to 6", kAny, [](C3& c) { c.srcZ = 4; }},
    {"target slices 4 to 6", kAny, [](C3& c) { c.dstZ = 4; }},
    {"source rows 3 to 7", kAny, [](C3& c) { c.srcY = 3; }},
    {"source rows 4 to 8", kAny, [](C3& c) { c.srcY = 4; }},
    {"source level 1", kAny, [](C3& c) { c.srcLOD = 1; }},
    {"target level 1", kAny, [](C3& c) { c.dstLOD = 1; }},
    {"reserved not 0", kAny, [](C3& c) { c.reserved0 = c.reserved1 = &c; }},
    {"source type 0", kAny, [](C3& c) { c.srcMemoryType = CUmemorytype(0); }},
    {"target type 5", kAny, [](C3& c) { c.dstMemoryType = CUmemorytype(5); }},
    {"source null", kAny,
     [](C3& c) { c.srcHost = nullptr, c.srcDevice = 0, c.srcArray = nullptr; }},
    {"target null", kAny,
     [](C3& c) { c.dstHost = nullptr, c.dstDevice = 0, c.dstArray = nullptr; }},
    {"source far over its end", kNoHost, [](C3& c) { c.srcZ = size_t(1) << 20; }},
    {"target far over its end", kNoHost, [](C3& c) { c.dstZ = size_t(1) << 20; }},
    {"width most", kBlocks, [](C3& c) { c.WidthInBytes = SIZE_MAX; }},
    {"height most", kBlocks, [](C3& c) { c.Height = SIZE_MAX; }},
    {"depth most", kBlocks, [](C3& c) { c.Depth = SIZE_MAX; }},
    {"target y most", kBlocks, [](C3& c) { c.dstY = SIZE_MAX; }},
    {"source pitch 2147483648", kBlocks, [](C3& c) { c.srcPitch = 0x80000000u; }},
};

template <class Copy, size_t N, class Block, class Run>
void changes(const Change<Copy> (&table)[N],
             const std::vector<std::pair<const Place*, const Place*>>& pairs, Block&& block,
             Run&& run) {
    for (auto [src, dst] : pairs)
        for (const Change<Copy>& change : table) {
            const bool host = (!src->onDevice && !src->array) || (!dst->onDevice && !dst->array);
            if ((change.sides != kAny && host) ||
                (change.sides == kBlocks && (src->array || dst->array)))
                continue;
            Copy copy = block(endOf(*src), endOf(*dst));
            change.apply(copy);
            run(src->name + " -> " + dst->name + ", " + change.name, copy, *src, *dst);
        }
}

// ---- arrays of every sort
// -------------------------------------------------------------------------
void sorts(const Blocks& blocks) {
    const unsigned kLayered = CUDA_ARRAY3D_LAYERED, kCube = CUDA_ARRAY3D_CUBEMAP;
    const std::vector<Place> all = {
        makeArray("1D", 32, 0, 0),
        makeArray("2D", 32, 16, 0),
        makeArray("3D", 16, 8, 6),
        makeArray("1D layers", 32, 0, 4, kLayered),
        makeArray("2D layers", 16, 8, 4, kLayered),
        makeArray("cube", 8, 8, 6, kCube),
        makeArray("cubes", 8, 8, 12, kCube | kLayered),
        makeLevel("level of 2D", 32, 16, 0, 0, 1),
        makeLevel("level of 3D", 32, 16, 12, 0, 1),
        makeLevel("level of layers", 32, 16, 4, kLayered, 1),
        makeLevel("level of cubes", 16, 16, 12, kCube | kLayered, 1),
    };
    struct Box {
        const char* name;
        size_t x, y, z, rows, slices;
    };
    const Box kBoxes[] = {{"a row", 4, 0, 0, 1, 1},          {"rows", 4, 1, 0, 3, 1},
                          {"layer 1", 4, 0, 1, 1, 1},        {"rows of 2 slices", 4, 1, 1, 3, 2},
                          {"slices 5 and 6", 4, 0, 5, 1, 2}, {"row 8", 4, 8, 0, 1, 1},
                          {"over the row", 120, 0, 0, 1, 1}};
    for (const Place& array : all) {
        std::printf("%s: %zu x %zu x %zu, flags %u\n", array.name.c_str(), array.shape.Width,
                    array.shape.Height, array.shape.Depth, array.shape.Flags);
        for (const Box& box : kBoxes) {
            CUDA_MEMCPY3D copy = block3D(endOf(array), endOf(blocks.device));
            copy.srcXInBytes = box.x, copy.srcY = box.y, copy.srcZ = box.z;
            copy.WidthInBytes = 12, copy.Height = box.rows, copy.Depth = box.slices;
            run3D(array.name + " -> device, " + box.name, copy, array, blocks.device);
            copy = block3D(endOf(blocks.pageable), endOf(array));
            copy.dstXInBytes = box.x, copy.dstY = box.y, copy.dstZ = box.z;
            copy.WidthInBytes = 12, copy.Height = box.rows, copy.Depth = box.slices;
            run3D("pageable -> " + array.name + ", " + box.name, copy, blocks.pageable, array);
        }
        // The first row, also where there are others.
        for (size_t offset :
             {size_t(4), size_t(6), size_t(24), array.shape.Width * 4 - 4, array.shape.Width * 4}) {
            const std::string at = " at " + std::to_string(offset);
            cases.run("AtoH " + array.name + at, &blocks.pageable, 2, [&](int form) {
                array.fill(1);
                return form ? cuMemcpyAtoHAsync(blocks.pageable.bytes, array.array, offset, 8,
                                                cases.stream)
                            : cuMemcpyAtoH(blocks.pageable.bytes, array.array, offset, 8);
            });
            cases.run("HtoA " + array.name + at, &array, 2, [&](int form) {
                blocks.pageable.fill(1);
                return form ? cuMemcpyHtoAAsync(array.array, offset, blocks.pageable.bytes, 8,
                                                cases.stream)
                            : cuMemcpyHtoA(array.array, offset, blocks.pageable.bytes, 8);
            });
            cases.run("AtoD " + array.name + at, &blocks.device, 1, [&](int) {
                array.fill(1);
                return cuMemcpyAtoD(blocks.device.address(), array.array, offset, 8);
            });
            cases.run("DtoA " + array.name + at, &array, 1, [&](int) {
                blocks.device.fill(1);
                return cuMemcpyDtoA(array.array, offset, blocks.device.address(), 8);
            });
        }
        const Place flat = makeArray("flat", 32, 16, 0);
        cases.run("AtoA " + array.name, &flat, 1, [&](int) {
            array.fill(1);
            return cuMemcpyAtoA(flat.array, 4, array.array, 8, 12);
        });
        MUST(cuArrayDestroy(flat.array));
    }
    for (const Place& src : all)
        for (const Place& dst : all) {
            if (&src == &dst)
                continue;
            CUDA_MEMCPY3D copy = block3D(endOf(src), endOf(dst));
            copy.srcXInBytes = 4, copy.srcY = 0, copy.srcZ = 0;
            copy.dstXInBytes = 8, copy.dstY = 0, copy.dstZ = 0;
            copy.WidthInBytes = 16;
            copy.Height = std::min(src.rows(), dst.rows()) > 1 ? 3 : 1;
            copy.Depth = std::min(src.slices(), dst.slices()) > 1 ? 2 : 1;
            run3D(src.name + " -> " + dst.name, copy, src, dst);
        }
}

// ---- arrays of every size of elements
// -------------------------------------------------------------
void elements(const Blocks& blocks) {
    const std::vector<Place> all = {
        makeArray("bytes", 64, 8, 0, 0, CU_AD_FORMAT_UNSIGNED_INT8, 1, 1),
        makeArray("halves", 64, 8, 0, 0, CU_AD_FORMAT_HALF, 1, 2),
        makeArray("pairs of bytes", 64, 8, 0, 0, CU_AD_FORMAT_SIGNED_INT8, 2, 2),
        makeArray("floats", 32, 8, 0, 0, CU_AD_FORMAT_FLOAT, 1, 4),
        makeArray("words", 32, 8, 0, 0, CU_AD_FORMAT_UNSIGNED_INT32, 1, 4),
        makeArray("pairs", 16, 8, 0, 0, CU_AD_FORMAT_UNSIGNED_INT32, 2, 8),
        makeArray("quadruples", 8, 8, 0, 0, CU_AD_FORMAT_FLOAT, 4, 16),
    };
    for (const Place& src : all)
        for (const Place& dst : all)
            if (&src != &dst) {
                CUDA_MEMCPY2D copy = block2D(endOf(src), endOf(dst));
                copy.srcXInBytes = 16, copy.dstXInBytes = 0, copy.WidthInBytes = 32;
                run2D(src.name + " -> " + dst.name, copy, src, dst);
            }
    for (const Place& array : all)
        for (size_t x : {1, 2, 4, 8, 16})
            for (size_t width : {1, 2, 6, 8, 16}) {
                CUDA_MEMCPY2D copy = block2D(endOf(array), endOf(blocks.device));
                copy.srcXInBytes = x, copy.WidthInBytes = width;
                run2D(array.name + " from " + std::to_string(x) + ", " + std::to_string(width) +
                          " bytes",
                      copy, array, blocks.device);
            }
}

// ---- linear copies, peers, sets
// -------------------------------------------------------------------
void linear(const Blocks& b) {
    const Place* places[] = {&b.pageable, &b.pinned, &b.other, &b.managed};
    for (const Place* place : places) {
        cases.run("HtoD " + place->name, &b.device, 2, [&](int form) {
            place->fill(1);
            return form ? cuMemcpyHtoDAsync(b.device.address() + 3, place->bytes + 5, 100,
                                            cases.stream)
                        : cuMemcpyHtoD(b.device.address() + 3, place->bytes + 5, 100);
        });
        cases.run("DtoH " + place->name, place, 2, [&](int form) {
            b.device.fill(1);
            return form ? cuMemcpyDtoHAsync(place->bytes + 3, b.device.address() + 5, 100,
                                            cases.stream)
                        : cuMemcpyDtoH(place->bytes + 3, b.device.address() + 5, 100);
        });
        cases.run("DtoD from " + place->name, &b.device, 2, [&](int form) {
            place->fill(1);
            return form ? cuMemcpyDtoDAsync(b.device.address() + 3, place->address() + 5, 100,
                                            cases.stream)
                        : cuMemcpyDtoD(b.device.address() + 3, place->address() + 5, 100);
        });
        cases.run("DtoD to " + place->name, place, 2, [&](int form) {
            b.device.fill(1);
            return form ? cuMemcpyDtoDAsync(place->address() + 3, b.device.address() + 5, 100,
                                            cases.stream)
                        : cuMemcpyDtoD(place->address() + 3, b.device.address() + 5, 100);
        });
        for (const Place* dst : places)
            if (dst != place)
                cases.run("cuMemcpy " + place->name + " -> " + dst->name, dst, 2, [&](int form) {
                    place->fill(1);
                    return form ? cuMemcpyAsync(dst->address() + 3, place->address() + 5, 100,
                                                cases.stream)
                                : cuMemcpy(dst->address() + 3, place->address() + 5, 100);
                });
    }
    std::vector<unsigned char> host(size_t(16) << 20);
    struct Range {
        const char* name;
        size_t offset, bytes;
    };
    const Range kRanges[] = {{"nothing", 0, 0},
                             {"nothing at the end", kBytes, 0},
                             {"all", 0, kBytes},
                             {"1 byte more", 0, kBytes + 1},
                             {"the last and the next byte", kBytes - 1, 2},
                             {"512 bytes more", 0, kBytes + 512},
                             {"4 MiB", 0, size_t(4) << 20}};
    for (const Range& range : kRanges) {
        cases.run(std::string("HtoD, ") + range.name, &b.device, 2, [&](int form) {
            return form ? cuMemcpyHtoDAsync(b.device.address() + range.offset, host.data(),
                                            range.bytes, cases.stream)
                        : cuMemcpyHtoD(b.device.address() + range.offset, host.data(), range.bytes);
        });
        cases.run(std::string("DtoH, ") + range.name, nullptr, 2, [&](int form) {
            return form ? cuMemcpyDtoHAsync(host.data(), b.device.address() + range.offset,
                                            range.bytes, cases.stream)
                        : cuMemcpyDtoH(host.data(), b.device.address() + range.offset, range.bytes);
        });
        cases.run(std::string("set, ") + range.name, &b.device, 2, [&](int form) {
            return form ? cuMemsetD8Async(b.device.address() + range.offset, 7, range.bytes,
                                          cases.stream)
                        : cuMemsetD8(b.device.address() + range.offset, 7, range.bytes);
        });
    }
    const CUdeviceptr nowhere = 0;
    cases.run("HtoD to null", nullptr, 2, [&](int form) {
        return form ? cuMemcpyHtoDAsync(nowhere, host.data(), 4, cases.stream)
                    : cuMemcpyHtoD(nowhere, host.data(), 4);
    });
    cases.run("HtoD from null", &b.device, 2, [&](int form) {
        return form ? cuMemcpyHtoDAsync(b.device.address(), nullptr, 4, cases.stream)
                    : cuMemcpyHtoD(b.device.address(), nullptr, 4);
    });
    cases.run("DtoH to null", nullptr, 1,
              [&](int) { return cuMemcpyDtoH(nullptr, b.device.address(), 4); });
    cases.run("DtoD from null", &b.device, 1,
              [&](int) { return cuMemcpyDtoD(b.device.address(), 0, 4); });
    cases.run("null to null, nothing", nullptr, 1,
              [&](int) { return cuMemcpyHtoD(0, nullptr, 0); });
    cases.run("HtoD most", &b.device, 2, [&](int form) {
        return form ? cuMemcpyHtoDAsync(b.device.address(), host.data(), SIZE_MAX, cases.stream)
                    : cuMemcpyHtoD(b.device.address(), host.data(), SIZE_MAX);
    });
    cases.run("DtoD most", &b.device, 1,
              [&](int) { return cuMemcpyDtoD(b.device.address(), b.other.address(), SIZE_MAX); });
    for (int shift : {-16, 16, 0})
        cases.run("DtoD over itself by " + std::to_string(shift), shift ? nullptr : &b.device, 1,
                  [&](int) {
                      return cuMemcpyDtoD(b.device.address() + 64 + CUdeviceptr(shift),
                                          b.device.address() + 64, 1000);
                  });
}

void peers(const Blocks& b, const Place& array) {
    CUcontext context = nullptr;
    MUST(cuCtxGetCurrent(&context));
    struct {
        const char* name;
        CUcontext dst, src;
    } const kContexts[] = {{"", context, context},
                           {" to no context", nullptr, context},
                           {" from no context", context, nullptr}};
    for (const auto& c : kContexts) {
        cases.run(std::string("peer") + c.name, &b.device, 2, [&](int form) {
            b.other.fill(1);
            return form ? cuMemcpyPeerAsync(b.device.address(), c.dst, b.other.address(), c.src,
                                            100, cases.stream)
                        : cuMemcpyPeer(b.device.address(), c.dst, b.other.address(), c.src, 100);
        });
        for (const Place* src : {&b.other, &b.pageable, &b.pinned, &b.managed, &array}) {
            const CUDA_MEMCPY3D plain = block3D(endOf(*src), endOf(b.device));
            CUDA_MEMCPY3D_PEER copy = {};
            setEnds(copy, endOf(*src), endOf(b.device));
            copy.srcContext = c.src, copy.dstContext = c.dst;
            copy.srcXInBytes = plain.srcXInBytes, copy.srcY = plain.srcY, copy.srcZ = plain.srcZ;
            copy.srcPitch = plain.srcPitch, copy.srcHeight = plain.srcHeight;
            copy.dstXInBytes = plain.dstXInBytes, copy.dstY = plain.dstY, copy.dstZ = plain.dstZ;
            copy.dstPitch = plain.dstPitch, copy.dstHeight = plain.dstHeight;
            copy.WidthInBytes = plain.WidthInBytes, copy.Height = plain.Height,
            copy.Depth = plain.Depth;
            cases.run("3D peer from " + src->name + c.name, &b.device, 2, [&](int form) {
                src->fill(1);
                return form ? cuMemcpy3DPeerAsync(&copy, cases.stream) : cuMemcpy3DPeer(&copy);
            });
        }
    }
    cases.run("3D null", nullptr, 2, [&](int form) {
        return form ? cuMemcpy3DAsync(nullptr, cases.stream) : cuMemcpy3D(nullptr);
    });
    cases.run("2D null", nullptr, 2, [&](int form) {
        return form ? cuMemcpy2DAsync(nullptr, cases.stream) : cuMemcpy2D(nullptr);
    });
}

void sets(const Blocks& b) {
    struct Set {
        const char* name;
        size_t offset, pitch, width, height;
    };
    const Set kSets[] = {{"rows", 8, 64, 10, 3},
                         {"offset 1", 1, 64, 10, 3},
                         {"offset 2", 2, 64, 10, 3},
                         {"pitch 63", 8, 63, 10, 3},
                         {"pitch 62", 8, 62, 10, 3},
                         {"pitch 9", 8, 9, 10, 3},
                         {"pitch 10", 8, 10, 10, 3},
                         {"pitch 9, 1 row", 8, 9, 10, 1},
                         {"pitch 0, 1 row", 8, 0, 10, 1},
                         {"pitch 0", 8, 0, 10, 3},
                         {"pitch 0, width 0", 8, 0, 0, 3},
                         {"no width", 8, 64, 0, 3},
                         {"no height", 8, 64, 10, 0},
                         {"to the end", 0, 64, 16, kBytes / 64},
                         {"over the end", 0, 64, 16, kBytes / 64 + 1},
                         {"last row over the end", kBytes - 64 - 8, 64, 3, 2},
                         {"last row leaves", kBytes - 64 - 8, 64, 40, 2},
                         {"far", 0, 64, 10, size_t(1) << 24},
                         {"pitch most, 1 row", 0, SIZE_MAX, 10, 1}};
    for (const Set& s : kSets) {
        const CUdeviceptr at = b.device.address() + s.offset;
        const std::string name = s.name;
        cases.run("D2D8 " + name, &b.device, 2, [&](int form) {
            return form ? cuMemsetD2D8Async(at, s.pitch, 0x11, s.width, s.height, cases.stream)
                        : cuMemsetD2D8(at, s.pitch, 0x11, s.width, s.height);
        });
        cases.run("D2D16 " + name, &b.device, 2, [&](int form) {
            return form ? cuMemsetD2D16Async(at, s.pitch, 0x1122, s.width, s.height, cases.stream)
                        : cuMemsetD2D16(at, s.pitch, 0x1122, s.width, s.height);
        });
        cases.run("D2D32 " + name, &b.device, 2, [&](int form) {
            return form ? cuMemsetD2D32Async(at, s.pitch, 0x11223344, s.width, s.height,
                                             cases.stream)
                        : cuMemsetD2D32(at, s.pitch, 0x11223344, s.width, s.height);
        });
        if (s.pitch != 64)
            continue;
        cases.run("D8 " + name, &b.device, 2, [&](int form) {
            return form ? cuMemsetD8Async(at, 0x11, s.width, cases.stream)
                        : cuMemsetD8(at, 0x11, s.width);
        });
        cases.run("D16 " + name, &b.device, 2, [&](int form) {
            return form ? cuMemsetD16Async(at, 0x1122, s.width, cases.stream)
                        : cuMemsetD16(at, 0x1122, s.width);
        });
        cases.run("D32 " + name, &b.device, 2, [&](int form) {
            return form ? cuMemsetD32Async(at, 0x11223344, s.width, cases.stream)
                        : cuMemsetD32(at, 0x11223344, s.width);
        });
    }
    for (const Place* place : {&b.pageable, &b.pinned, &b.managed}) {
        cases.run("D8 of " + place->name, place, 2, [&](int form) {
            return form ? cuMemsetD8Async(place->address(), 1, 99, cases.stream)
                        : cuMemsetD8(place->address(), 1, 99);
        });
        cases.run("D2D16 of " + place->name, place, 2, [&](int form) {
            return form ? cuMemsetD2D16Async(place->address(), 64, 1, 9, 3, cases.stream)
                        : cuMemsetD2D16(place->address(), 64, 1, 9, 3);
        });
    }
    cases.run("D8 of null", nullptr, 2, [&](int form) {
        return form ? cuMemsetD8Async(0, 1, 9, cases.stream) : cuMemsetD8(0, 1, 9);
    });
    cases.run("D8 of null, nothing", nullptr, 2, [&](int form) {
        return form ? cuMemsetD8Async(0, 1, 0, cases.stream) : cuMemsetD8(0, 1, 0);
    });
    cases.run("D32 of null, 3 rows", nullptr, 1,
              [&](int) { return cuMemsetD2D32(0, 64, 1, 9, 3); });
}

} // namespace

int main() {
    CUcontext context = nullptr;
    MUST(cuInit(0));
    MUST(cuDevicePrimaryCtxRetain(&context, 0));
    MUST(cuCtxSetCurrent(context));
    MUST(cuStreamCreate(&cases.stream, CU_STREAM_NON_BLOCKING));
    const Blocks blocks;
    const Place array = makeArray("array", 32, 16, 0);
    const Place flat = makeArray("flat", 32, 16, 0);
    const Place volume = makeArray("volume", 16, 8, 6);
    const Place solid = makeArray("solid", 16, 8, 6);
    places(blocks, array);
    using Pairs = std::vector<std::pair<const Place*, const Place*>>;
    changes(kChanges2D,
            Pairs{{&blocks.other, &blocks.device},
                  {&blocks.pageable, &blocks.device},
                  {&blocks.device, &blocks.pinned},
                  {&array, &blocks.device},
                  {&blocks.device, &array},
                  {&blocks.pageable, &array},
                  {&flat, &array}},
            block2D, run2D);
    changes(kChanges3D,
            Pairs{{&blocks.other, &blocks.device},
                  {&blocks.pageable, &blocks.device},
                  {&volume, &blocks.device},
                  {&blocks.device, &volume},
                  {&blocks.pinned, &volume},
                  {&volume, &solid}},
            block3D, run3D);
    sorts(blocks);
    elements(blocks);
    linear(blocks);
    peers(blocks, volume);
    sets(blocks);
    return 0;
}
