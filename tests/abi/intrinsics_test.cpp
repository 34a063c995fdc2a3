// SPDX-License-Identifier: Apache-2.0
// The intrinsics that each release's headers compile to: every one, in a program that may use it,
// makes a module and a pipeline through that release's table. All tables accept the names of all
// releases.
#include "scene.h"

namespace tests::abi {
namespace {

// One intrinsic: letters of results and operands (r 32 bits, l 64 bits, f float), and a program
// that may use it (r raygen, i intersection, a any-hit, c closest-hit, m miss, e exception).
struct Intrinsic {
    std::string name, results, operands;
    char program;
    int first = 22, last = 1000; // releases whose headers compile to it
};

std::string times(char letter, int count) {
    return std::string(size_t(count), letter);
}

std::vector<Intrinsic> intrinsics() {
    std::vector<Intrinsic> all = {
        {"trace_typed_32", times('r', 32), "rl" + times('f', 9) + times('r', 38), 'r', 47},
        {"set_payload", "", "rr", 'c', 47},
        {"get_payload", "r", "r", 'c', 47},
        {"undef_value", "r", "", 'c'},
        {"get_ray_tmin", "f", "", 'm'},
        {"get_ray_tmax", "f", "", 'm'},
        {"get_ray_time", "f", "", 'm'},
        {"get_ray_flags", "r", "", 'm'},
        {"get_ray_visibility_mask", "r", "", 'm'},
        {"get_instance_traversable_from_ias", "l", "lr", 'c', 47},
        {"get_triangle_vertex_data", times('f', 9), "lrrf", 'c'},
        {"get_linear_curve_vertex_data", times('f', 8), "lrrf", 'c', 36},
        {"get_quadratic_bspline_vertex_data", times('f', 12), "lrrf", 'c', 36},
        {"get_cubic_bspline_vertex_data", times('f', 16), "lrrf", 'c', 36},
        {"get_catmullrom_vertex_data", times('f', 16), "lrrf", 'c', 55},
        {"get_sphere_data", times('f', 4), "lrrf", 'c', 60},
        {"get_gas_traversable_handle", "l", "", 'c'},
        {"get_gas_motion_time_begin", "f", "l", 'c'},
        {"get_gas_motion_time_end", "f", "l", 'c'},
        {"get_gas_motion_step_count", "r", "l", 'c'},
        {"get_transform_list_size", "r", "", 'c'},
        {"get_transform_list_handle", "l", "r", 'c'},
        {"get_transform_type_from_handle", "r", "l", 'c'},
        {"get_instance_id_from_handle", "r", "l", 'c'},
        {"get_static_transform_from_handle", "l", "l", 'c'},
        {"get_srt_motion_transform_from_handle", "l", "l", 'c'},
        {"get_matrix_motion_transform_from_handle", "l", "l", 'c'},
        {"get_instance_child_from_handle", "l", "l", 'c', 47},
        {"get_instance_transform_from_handle", "l", "l", 'c'},
        {"get_instance_inverse_transform_from_handle", "l", "l", 'c'},
        {"terminate_ray", "", "", 'a'},
        {"ignore_intersection", "", "", 'a'},
        {"read_primitive_idx", "r", "", 'c'},
        {"read_sbt_gas_idx", "r", "", 'c', 36},
        {"read_instance_id", "r", "", 'c'},
        {"read_instance_idx", "r", "", 'c'},
        {"get_hit_kind", "r", "", 'c'},
        {"get_primitive_type_from_hit_kind", "r", "r", 'c', 36},
        {"get_backface_from_hit_kind", "r", "r", 'c', 36},
        {"get_triangle_barycentrics", "ff", "", 'c'},
        {"get_sbt_data_ptr_64", "l", "", 'c'},
        {"get_exception_code", "r", "", 'e'},
        {"get_exception_invalid_sbt_offset", "r", "", 'e'},
        {"get_exception_invalid_traversable", "l", "", 'e'},
        {"get_exception_invalid_ray", times('f', 9), "", 'e', 36},
        {"get_exception_parameter_mismatch", "rrrl", "", 'e', 36},
        {"get_exception_line_info", "l", "", 'e', 36},
        {"call_direct_callable", "l", "r", 'r'},
        {"call_continuation_callable", "l", "r", 'r'},
        {"tex_footprint_2d_v2", "", "lrrrll", 'c', 47},
        {"tex_footprint_2d_lod_v2", "", "lrrrrrll", 'c', 47},
        {"tex_footprint_2d_grad_v2", "", "lrrrrrrrrll", 'c', 47},
    };
    for (char axis : {'x', 'y', 'z'}) {
        const std::string end = std::string("_") + axis;
        for (const char* name : {"get_world_ray_origin", "get_world_ray_direction"})
            all.push_back({name + end, "f", "", 'm'});
        for (const char* name : {"get_object_ray_origin", "get_object_ray_direction"})
            all.push_back({name + end, "f", "", 'a'});
        for (const char* name : {"get_launch_index", "get_launch_dimension"})
            all.push_back({name + end, "r", "", 'r'});
    }
    for (int k = 0; k <= 8; ++k) {
        const std::string number = "_" + std::to_string(k);
        all.push_back({"trace" + number, times('r', k),
                       "l" + times('f', 9) + times('r', 5) + times('r', k), 'r', 22, 41});
        all.push_back({"report_intersection" + number, "r", "fr" + times('r', k), 'i'});
        all.push_back({"throw_exception" + number, "", "r" + times('r', k), 'r'});
        if (k == 8)
            break;
        all.push_back({"set_payload" + number, "", "r", 'c', 22, 41});
        all.push_back({"get_payload" + number, "r", "", 'c', 22, 41});
        all.push_back({"get_attribute" + number, "r", "", 'c'});
        all.push_back({"get_exception_detail" + number, "r", "", 'e'});
    }
    return all;
}

const char* prefixOf(char program) {
    switch (program) {
    case 'r':
        return "__raygen__";
    case 'i':
        return "__intersection__";
    case 'a':
        return "__anyhit__";
    case 'c':
        return "__closesthit__";
    case 'm':
        return "__miss__";
    default:
        return "__exception__";
    }
}

// A program that calls the intrinsic with constants and stores each result.
std::string program(const Intrinsic& intrinsic, const std::string& name) {
    const auto list = [](const std::string& letters, const char* prefix) {
        std::string text;
        for (size_t i = 0; i < letters.size(); ++i)
            text += (i ? ", %" : "%") + (prefix + (letters[i] + std::to_string(i)));
        return text;
    };
    std::string text = ".visible .entry " + name + "() {\n";
    for (const char* prefix : {"o", "i"})
        text += std::string(" .reg .b32 %") + prefix + "r<64>;\n .reg .f32 %" + prefix +
                "f<64>;\n .reg .b64 %" + prefix + "l<64>;\n";
    text += " .reg .b64 %place;\n ld.const.u64 %place, [params];\n";
    for (size_t i = 0; i < intrinsic.operands.size(); ++i) {
        const std::string name = std::to_string(i);
        switch (intrinsic.operands[i]) {
        case 'r':
            text += " mov.u32 %ir" + name + ", 0;\n";
            break;
        case 'f':
            text += " mov.f32 %if" + name + ", 0f3F800000;\n";
            break;
        default:
            text += " mov.u64 %il" + name + ", %place;\n";
        }
    }
    text += " call " +
            (intrinsic.results.empty() ? "" : "(" + list(intrinsic.results, "o") + "), ") +
            "_optix_" + intrinsic.name + ", (" + list(intrinsic.operands, "i") + ");\n";
    for (size_t i = 0; i < intrinsic.results.size(); ++i) {
        const char letter = intrinsic.results[i];
        text += std::string(" st.global.") +
                (letter == 'l'   ? "u64"
                 : letter == 'f' ? "f32"
                                 : "u32") +
                " [%place+" + std::to_string(8 * i) + "], %o" + letter + std::to_string(i) + ";\n";
    }
    return text + " ret;\n}\n";
}

template <class R>
class IntrinsicsOf : public testing::Test {
protected:
    // Makes a module with one program and a pipeline with it; empty on success.
    std::string tryOne(const Intrinsic& intrinsic) {
        const std::string name = prefixOf(intrinsic.program) + intrinsic.name;
        const std::string ptx = ".version 6.5\n.target sm_60\n.address_size 64\n"
                                ".const .align 8 .b8 params[8];\n" +
                                program(intrinsic, name) +
                                ".visible .entry __raygen__nothing() "
                                "{\n ret;\n}\n";
        auto options = Client<R>::compileOptions();
        adjust(*options.get());
        void* module = nullptr;
        int result =
            client_.makeModule(ptx, &module, Client<R>::moduleOptions(), std::move(options));
        if (result != kSuccess)
            return "module " + std::to_string(result);
        Guarded<ProgramGroupDesc> descs(2);
        for (int i = 0; i < 2; ++i) {
            set(descs[i].kind, 0x2421);
            set(descs[i].flags, 0u);
            for (auto& program : descs[i].programs)
                program = {nullptr, nullptr};
            descs[i].programs[0] = {module, "__raygen__nothing"};
        }
        const bool inHitGroup =
            intrinsic.program == 'i' || intrinsic.program == 'a' || intrinsic.program == 'c';
        const std::string kinds = "rme";
        set(descs[1].kind, inHitGroup ? 0x2424 : 0x2421 + int(kinds.find(intrinsic.program)));
        descs[1].programs[0] = {};
        descs[1].programs[intrinsic.program == 'a'   ? 1
                          : intrinsic.program == 'i' ? 2
                                                     : 0] = {module, name.c_str()};
        void* groups[2] = {};
        if (client_.makeGroups(descs, 2, groups) != kSuccess)
            return "group";
        void* pipeline = nullptr;
        auto again = Client<R>::compileOptions();
        adjust(*again.get());
        result = client_.makePipeline(groups, 2, &pipeline, std::move(again));
        return result == kSuccess ? "" : "pipeline " + std::to_string(result);
    }

    Client<R> client_;

private:
    static void adjust(typename R::CompileOptions& options) {
        set(options.numAttributeValues, 8);
        set(options.numPayloadValues, 8);
        set(options.exceptionFlags, 1u | 2u | 4u);
    }
};
using Releases =
    testing::Types<Release70, Release71, Release72, Release73, Release74, Release75, Release76>;
TYPED_TEST_SUITE(IntrinsicsOf, Releases);

TYPED_TEST(IntrinsicsOf, EachMakesAPipeline) {
    int tried = 0;
    for (const Intrinsic& intrinsic : intrinsics()) {
        if (TypeParam::kAbi < intrinsic.first || TypeParam::kAbi > intrinsic.last)
            continue;
        ++tried;
        EXPECT_EQ("", this->tryOne(intrinsic)) << intrinsic.name;
    }
    EXPECT_GT(tried, 90);
}

// Clients of a release also send names that its headers lack.
TYPED_TEST(IntrinsicsOf, OtherReleasesAreAccepted) {
    for (const Intrinsic& intrinsic : intrinsics())
        if (TypeParam::kAbi < intrinsic.first || TypeParam::kAbi > intrinsic.last)
            EXPECT_EQ("", this->tryOne(intrinsic)) << intrinsic.name;
}

TYPED_TEST(IntrinsicsOf, UnknownNamesAreNamed) {
    EXPECT_EQ("module 7200", this->tryOne({"get_the_weather", "r", "", 'r'}));
    EXPECT_NE(std::string::npos, this->client_.log().find("_optix_get_the_weather"));
}

} // namespace
} // namespace tests::abi
