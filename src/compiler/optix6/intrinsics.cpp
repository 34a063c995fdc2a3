// SPDX-License-Identifier: Apache-2.0
// The table behind find(). Source of the program kinds that may call each function: OptiX 6.0 API
// reference, section 5.24.
#include "compiler/optix6/intrinsics.h"

#include <unordered_map>
#include <vector>

namespace sunstone::compiler::optix6 {

namespace {

constexpr uint32_t kRG = kindBit(ProgramKind::kRaygen);
constexpr uint32_t kIS = kindBit(ProgramKind::kIntersection);
constexpr uint32_t kAH = kindBit(ProgramKind::kAnyHit);
constexpr uint32_t kCH = kindBit(ProgramKind::kClosestHit);
constexpr uint32_t kMS = kindBit(ProgramKind::kMiss);
constexpr uint32_t kCP = kindBit(ProgramKind::kDirectCallable);
constexpr uint32_t kEX = kindBit(ProgramKind::kException);
constexpr uint32_t kAT = kindBit(ProgramKind::kAttribute);
constexpr uint32_t kVS = kindBit(ProgramKind::kVisit);
constexpr uint32_t kAny = ~0u;

std::vector<Intrinsic> makeTable() {
    std::vector<Intrinsic> table;
    const auto add = [&](std::string name, Op op, int number, std::string results,
                         std::string operands, uint32_t kinds, bool reads = false) {
        table.push_back({std::move(name), unsigned(op), number, std::move(results),
                         std::move(operands), kinds, reads});
        table.back().namesLine = op == Op::kTrace || op == Op::kThrow;
        table.back().isAvailable = op != Op::kLater;
    };
    const std::string ray = "rffffffrff"; // node, origin, direction, ray type, interval
    const uint32_t traces = kRG | kCH | kMS | kCP;
    add("trace_64", Op::kTrace, 0, "", ray + "lr", traces);
    add("trace_mask_flags_64", Op::kTrace, kTraceMask, "", ray + "rrlr", traces);
    add("trace_with_time_64", Op::kTrace, kTraceTime, "", ray + "flr", traces);
    add("trace_with_time_mask_flags_64", Op::kTrace, kTraceTime | kTraceMask, "", ray + "frrlr",
        traces);
    add("buffer_get_64", Op::kBuffer, kBufferVariable, "l", "lrrllll", kAny);
    add("buffer_get_id_64", Op::kBuffer, kBufferId, "l", "rrrllll", kAny);
    add("buffer_get_size_64", Op::kBufferSize, kBufferVariable, "llll", "lrr", kAny);
    add("buffer_get_id_size_64", Op::kBufferSize, kBufferId, "llll", "rrr", kAny);
    add("buffer_get_size_id_64", Op::kBufferSize, kBufferId, "llll", "rrr", kAny);
    add("callable_program_from_id_64", Op::kCallable, 0, "l", "r", kAny);
    add("callable_program_from_id_v2_64", Op::kCallable, 0, "l", "rl", kAny);
    add("potential_intersection", Op::kPotential, 0, "r", "f", kIS);
    add("report_intersection", Op::kReport, 0, "r", "r", kIS);
    add("ignore_intersection", Op::kIgnore, 0, "", "", kAH);
    add("terminate_ray", Op::kTerminate, 0, "", "", kAH);
    add("intersect_child", Op::kChild, 0, "", "r", kVS);
    add("transform_tuple", Op::kTransform, 0, "ffff", "rffff", kAny);
    add("get_transform", Op::kMatrix, 0, "ffffffffffffffff", "r", kAny);
    add("get_primitive_index", Op::kPrimitive, 0, "r", "", kAH | kCH | kIS | kAT | kCP, true);
    add("is_triangle_hit", Op::kTriangleHit, kIsTriangle, "r", "", kAH | kCH | kAT | kCP);
    add("is_triangle_hit_back_face", Op::kTriangleHit, kIsBackFace, "r", "", kAH | kCH | kAT | kCP);
    add("is_triangle_hit_front_face", Op::kTriangleHit, kIsFrontFace, "r", "",
        kAH | kCH | kAT | kCP);
    add("get_triangle_barycentrics", Op::kBarycentrics, 0, "ff", "", kAT | kAH | kCH, true);
    add("throw", Op::kThrow, 0, "", "r", kAny & ~kEX);
    add("get_exception_code", Op::kExceptionCode, 0, "r", "", kEX);
    add("print_active", Op::kPrintActive, 0, "r", "", kAny);
    add("texture_handle", Op::kTextureHandle, 0, "l", "r", kAny);
    for (const char component : {'x', 'y', 'z'}) {
        add(std::string("launch_index_") + component, Op::kLaunchIndex, component - 'x', "r", "",
            kAny, true);
        add(std::string("launch_dim_") + component, Op::kLaunchDimension, component - 'x', "r", "",
            kAny, true);
    }
    add("undef_use", Op::kUndefined, 0, "", "r", kAny);
    add("undef_use64", Op::kUndefined, 0, "", "l", kAny);
    return table;
}

} // namespace

const Intrinsic* find(std::string_view fullName) {
    static const auto* const variable =
        new Intrinsic{"variable", unsigned(Op::kVariable), 0, "p", "", kAny, true};
    static const auto* const table = new std::vector<Intrinsic>(makeTable());
    static const auto* const index = [] {
        auto* map = new std::unordered_map<std::string_view, const Intrinsic*>;
        for (const Intrinsic& intrinsic : *table)
            (*map)[intrinsic.name] = &intrinsic;
        return map;
    }();
    if (fullName.starts_with(kVariablePrefix))
        return variable;
    if (!fullName.starts_with(kPrefix))
        return nullptr;
    const auto found = index->find(fullName.substr(kPrefix.size()));
    return found == index->end() ? nullptr : found->second;
}

} // namespace sunstone::compiler::optix6
