// SPDX-License-Identifier: Apache-2.0
// The table behind findIntrinsic. Source of names and operands: the PTX that released headers emit.
// Source of the program kinds that may call a function: the device API's documentation of the
// function.
#include "compiler/optix7/intrinsics.h"

#include "devlib/abi.h"
#include "texture/device_functions.h"

#include <unordered_map>
#include <vector>

namespace sunstone::compiler {

namespace {

using devlib::ExceptionInfo;
using devlib::GasMotion;
using devlib::Hit;
using devlib::InstanceRecord;
using devlib::RayState;

constexpr uint32_t kRG = kindBit(ProgramKind::kRaygen);
constexpr uint32_t kIS = kindBit(ProgramKind::kIntersection);
constexpr uint32_t kAH = kindBit(ProgramKind::kAnyHit);
constexpr uint32_t kCH = kindBit(ProgramKind::kClosestHit);
constexpr uint32_t kMS = kindBit(ProgramKind::kMiss);
constexpr uint32_t kCC = kindBit(ProgramKind::kContinuationCallable);
constexpr uint32_t kDC = kindBit(ProgramKind::kDirectCallable);
constexpr uint32_t kEX = kindBit(ProgramKind::kException);
constexpr uint32_t kAny = ~0u;
constexpr uint32_t kHitPrograms = kIS | kAH | kCH;
constexpr uint32_t kRayPrograms = kHitPrograms | kMS;

std::string repeat(char letter, int count) {
    return std::string(size_t(count), letter);
}

class TableBuilder {
public:
    std::vector<Intrinsic> take() { return std::move(table_); }

    void build() {
        traces();
        payload();
        rays();
        hits();
        transforms();
        control();
        later();
    }

private:
    void add(std::string name, IntrinsicOp op, int number, std::string results,
             std::string operands, uint32_t kinds, bool reads = false) {
        table_.push_back({std::move(name), unsigned(op), number, std::move(results),
                          std::move(operands), kinds, reads});
        table_.back().namesLine = op == IntrinsicOp::kTrace || op == IntrinsicOp::kThrow;
        table_.back().isAvailable = op != IntrinsicOp::kLater;
    }
    void field(std::string name, size_t offset, char type, uint32_t kinds) {
        add(std::move(name), IntrinsicOp::kRayField, int(offset), repeat(type, 1), "", kinds, true);
    }
    void notYet(std::string name, bool anySignature = true) {
        add(std::move(name), IntrinsicOp::kLater, 0, "", "", kAny);
        table_.back().anySignature = anySignature;
    }

    void traces() {
        const uint32_t kinds = kRG | kCH | kMS | kCC;
        add("trace_typed_32", IntrinsicOp::kTrace, -1, repeat('r', 32),
            "rl" + repeat('f', 9) + repeat('r', 6) + repeat('r', 32), kinds);
        for (int k = 0; k <= 8; ++k)
            add("trace_" + std::to_string(k), IntrinsicOp::kTrace, k, repeat('r', k),
                "l" + repeat('f', 9) + repeat('r', 5) + repeat('r', k), kinds);
    }

    void payload() {
        add("set_payload", IntrinsicOp::kSetPayload, -1, "", "rr", kRayPrograms);
        add("get_payload", IntrinsicOp::kGetPayload, -1, "r", "r", kRayPrograms, true);
        for (int k = 0; k < 8; ++k) {
            add("set_payload_" + std::to_string(k), IntrinsicOp::kSetPayload, k, "", "r",
                kRayPrograms);
            add("get_payload_" + std::to_string(k), IntrinsicOp::kGetPayload, k, "r", "",
                kRayPrograms, true);
        }
        add("set_payload_types", IntrinsicOp::kSetPayloadTypes, 0, "", "r", kRayPrograms);
        add("undef_value", IntrinsicOp::kUndefined, 0, "r", "", kAny, true);
    }

    void rays() {
        const char axis[] = "xyz";
        for (unsigned i = 0; i < 3; ++i) {
            const std::string suffix = std::string("_") + axis[i];
            const size_t at = i * sizeof(float);
            field("get_world_ray_origin" + suffix, offsetof(RayState, worldOrigin) + at, 'f',
                  kRayPrograms);
            field("get_world_ray_direction" + suffix, offsetof(RayState, worldDirection) + at, 'f',
                  kRayPrograms);
            field("get_object_ray_origin" + suffix, offsetof(RayState, objectOrigin) + at, 'f',
                  kIS | kAH);
            field("get_object_ray_direction" + suffix, offsetof(RayState, objectDirection) + at,
                  'f', kIS | kAH);
            add("get_launch_index" + suffix, IntrinsicOp::kLaunchIndex, int(i), "r", "", kAny,
                true);
            add("get_launch_dimension" + suffix, IntrinsicOp::kLaunchDimension, int(i), "r", "",
                kAny, true);
        }
        field("get_ray_tmin", offsetof(RayState, tmin), 'f', kRayPrograms);
        field("get_ray_tmax", offsetof(RayState, tmax), 'f', kRayPrograms);
        field("get_ray_time", offsetof(RayState, time), 'f', kRayPrograms);
        field("get_ray_flags", offsetof(RayState, rayFlags), 'r', kRayPrograms);
        field("get_ray_visibility_mask", offsetof(RayState, visibilityMask), 'r', kRayPrograms);
    }

    void hits() {
        const size_t hit = offsetof(RayState, hit);
        field("read_primitive_idx", hit + offsetof(Hit, primitive), 'r', kHitPrograms);
        field("read_sbt_gas_idx", hit + offsetof(Hit, sbtGasIndex), 'r', kHitPrograms | kEX);
        field("read_instance_id", hit + offsetof(Hit, instanceId), 'r', kHitPrograms);
        field("read_instance_idx", hit + offsetof(Hit, instanceIndex), 'r', kHitPrograms);
        field("get_hit_kind", hit + offsetof(Hit, kind), 'r', kAH | kCH);
        field("get_gas_traversable_handle", hit + offsetof(Hit, gas), 'l', kHitPrograms);
        for (int k = 0; k < int(devlib::kMaxAttributeWords); ++k)
            field("get_attribute_" + std::to_string(k),
                  hit + offsetof(Hit, attributes) + size_t(k) * 4, 'r', kAH | kCH);
        add("get_triangle_barycentrics", IntrinsicOp::kBarycentrics, 0, "ff", "", kAH | kCH, true);
        add("get_primitive_type_from_hit_kind", IntrinsicOp::kPrimitiveTypeOfKind, 0, "r", "r",
            kAny, true);
        add("get_backface_from_hit_kind", IntrinsicOp::kBackfaceOfKind, 0, "r", "r", kAny, true);
        add("get_sbt_data_ptr_64", IntrinsicOp::kSbtData, 0, "l", "", kAny, true);
    }

    void transforms() {
        field("get_transform_list_size", offsetof(RayState, hit) + offsetof(Hit, transformCount),
              'r', kHitPrograms | kEX);
        add("get_transform_list_handle", IntrinsicOp::kTransformHandle, 0, "l", "r",
            kHitPrograms | kEX, true);
        add("get_transform_type_from_handle", IntrinsicOp::kTransformType, 0, "r", "l", kAny, true);
        add("get_static_transform_from_handle", IntrinsicOp::kTransformPointer, devlib::kTagStatic,
            "l", "l", kAny, true);
        add("get_matrix_motion_transform_from_handle", IntrinsicOp::kTransformPointer,
            devlib::kTagMatrixMotion, "l", "l", kAny, true);
        add("get_srt_motion_transform_from_handle", IntrinsicOp::kTransformPointer,
            devlib::kTagSrtMotion, "l", "l", kAny, true);
        add("get_instance_transform_from_handle", IntrinsicOp::kInstanceMatrix,
            offsetof(InstanceRecord, objectToWorld), "l", "l", kAny, true);
        add("get_instance_inverse_transform_from_handle", IntrinsicOp::kInstanceMatrix,
            offsetof(InstanceRecord, worldToObject), "l", "l", kAny, true);
        add("get_instance_id_from_handle", IntrinsicOp::kInstanceField,
            offsetof(InstanceRecord, instanceId), "r", "l", kAny, true);
        add("get_instance_child_from_handle", IntrinsicOp::kInstanceField,
            offsetof(InstanceRecord, child), "l", "l", kAny, true);
        add("get_triangle_vertex_data", IntrinsicOp::kTriangleVertices, 0, repeat('f', 9), "lrrf",
            kAny, true);
        add("get_linear_curve_vertex_data", IntrinsicOp::kShapePoints, devlib::kPrimitiveLinear,
            repeat('f', 8), "lrrf", kAny, true);
        add("get_quadratic_bspline_vertex_data", IntrinsicOp::kShapePoints, devlib::kPrimitiveQuadraticBSpline,
            repeat('f', 12), "lrrf", kAny, true);
        add("get_cubic_bspline_vertex_data", IntrinsicOp::kShapePoints, devlib::kPrimitiveCubicBSpline,
            repeat('f', 16), "lrrf", kAny, true);
        add("get_catmullrom_vertex_data", IntrinsicOp::kShapePoints, devlib::kPrimitiveCatmullRom,
            repeat('f', 16), "lrrf", kAny, true);
        add("get_sphere_data", IntrinsicOp::kShapePoints, devlib::kPrimitiveSphere, repeat('f', 4), "lrrf", kAny,
            true);
        add("get_instance_traversable_from_ias", IntrinsicOp::kInstanceHandle, 0, "l", "lr", kAny,
            true);
        add("get_gas_motion_time_begin", IntrinsicOp::kGasMotion, offsetof(GasMotion, begin), "f",
            "l", kAny, true);
        add("get_gas_motion_time_end", IntrinsicOp::kGasMotion, offsetof(GasMotion, end), "f", "l",
            kAny, true);
        add("get_gas_motion_step_count", IntrinsicOp::kGasMotion, offsetof(GasMotion, keys), "r",
            "l", kAny, true);
    }

    void control() {
        for (int k = 0; k <= 8; ++k) {
            add("report_intersection_" + std::to_string(k), IntrinsicOp::kReport, k, "r",
                "fr" + repeat('r', k), kIS);
            add("throw_exception_" + std::to_string(k), IntrinsicOp::kThrow, k, "",
                "r" + repeat('r', k), kAny & ~kEX);
        }
        add("terminate_ray", IntrinsicOp::kTerminate, 0, "", "", kAH);
        add("ignore_intersection", IntrinsicOp::kIgnore, 0, "", "", kAH);
        add("call_direct_callable", IntrinsicOp::kCallable, 0, "l", "r",
            kRG | kHitPrograms | kMS | kCC | kDC, true);
        add("call_continuation_callable", IntrinsicOp::kCallable, 1, "l", "r",
            kRG | kCH | kMS | kCC, true);
        add("tex_footprint_2d_v2", IntrinsicOp::kFootprint, texture::k2D, "", "lrrrll", kAny);
        add("tex_footprint_2d_lod_v2", IntrinsicOp::kFootprint, texture::k2D | texture::kWithLevel,
            "", "lrrrrrll", kAny);
        add("tex_footprint_2d_grad_v2", IntrinsicOp::kFootprint,
            texture::k2D | texture::kWithGradient, "", "lrrrrrrrrll", kAny);
        add("get_exception_code", IntrinsicOp::kExceptionCode, 0, "r", "", kEX, true);
        for (int k = 0; k < 8; ++k)
            add("get_exception_detail_" + std::to_string(k), IntrinsicOp::kExceptionDetail, k, "r",
                "", kEX, true);
        const auto info = [&](const char* name, size_t offset, std::string results) {
            add(std::string("get_exception_") + name, IntrinsicOp::kExceptionInfo, int(offset),
                std::move(results), "", kEX, true);
        };
        info("line_info", offsetof(ExceptionInfo, line), "l");
        info("invalid_traversable", offsetof(ExceptionInfo, traversable), "l");
        info("invalid_sbt_offset", offsetof(ExceptionInfo, sbtOffset), "r");
        info("invalid_ray", offsetof(ExceptionInfo, ray), repeat('f', 9));
        info("parameter_mismatch", offsetof(ExceptionInfo, expectedWords), "rrrl");
    }

    void later() {
        for (const char* name : {"tex_footprint_2d",
                                 "tex_footprint_2d_lod",
                                 "tex_footprint_2d_grad",
                                 "get_ribbon_normal",
                                 "get_ribbon_parameters",
                                 "get_curve_parameter",
                                 "get_microtriangle_vertex_data",
                                 "get_microtriangle_barycentrics_data",
                                 "get_micro_triangle_vertex_data",
                                 "get_micro_triangle_barycentrics_data",
                                 "get_gas_ptr_from_handle",
                                 "get_cluster_id",
                                 "get_remaining_trace_depth",
                                 "traverse",
                                 "reorder",
                                 "invoke"})
            notYet(name);
        for (const char* form :
             {"_from_handle", "_current_hit"})
            notYet(std::string("get_triangle_vertex_data") + form);
        for (const char* shape :
             {"linear_curve", "quadratic_bspline", "cubic_bspline", "catmullrom",
              "cubic_bezier", "ribbon", "sphere", "quadratic_bspline_rocaps",
              "cubic_bspline_rocaps", "catmullrom_rocaps", "cubic_bezier_rocaps"})
            for (const char* form : {"_vertex_data_from_handle", "_vertex_data_current_hit",
                                     "_data_from_handle", "_data_current_hit"})
                notYet(std::string("get_") + shape + form);
        for (const char* shape :
             {"cubic_bezier", "ribbon", "quadratic_bspline_rocaps", "cubic_bspline_rocaps",
              "catmullrom_rocaps", "cubic_bezier_rocaps"})
            notYet(std::string("get_") + shape + "_vertex_data");
        notYet("get_ribbon_normal_from_handle");
        notYet("get_ribbon_normal_current_hit");
    }

    std::vector<Intrinsic> table_;
};

// Families of later releases with many members, all of them unavailable.
const Intrinsic* findFamily(std::string_view name) {
    static const auto& later =
        *new Intrinsic{"", unsigned(IntrinsicOp::kLater), 0, "", "", kAny, false, true, false};
    for (std::string_view prefix :
         {"hitobject_", "vector_", "matvecmul_", "coop_vec_", "outer_product_", "reduce_sum_"})
        if (name.starts_with(prefix))
            return &later;
    return nullptr;
}

} // namespace

const Intrinsic* findIntrinsic(std::string_view fullName) {
    if (!isIntrinsicName(fullName))
        return nullptr;
    static const auto& table = *[] {
        TableBuilder builder;
        builder.build();
        return new std::vector<Intrinsic>(builder.take());
    }();
    static const auto& index = *[] {
        auto* map = new std::unordered_map<std::string_view, const Intrinsic*>;
        for (const Intrinsic& entry : table)
            map->emplace(entry.name, &entry);
        return map;
    }();
    const std::string_view name = fullName.substr(kIntrinsicPrefix.size());
    const auto found = index.find(name);
    return found != index.end() ? found->second : findFamily(name);
}

} // namespace sunstone::compiler
