// SPDX-License-Identifier: Apache-2.0
// OptiX 7 as a flavor of device code.
#include "compiler/optix7/lower.h"
#include "compiler/optix7/program_kind.h"

namespace sunstone::compiler {

namespace {

class Optix7Flavor final : public Flavor {
public:
    const char* name() const override { return "optix7"; }
    bool isIntrinsicName(std::string_view name) const override {
        return compiler::isIntrinsicName(name);
    }
    const Intrinsic* find(std::string_view name) const override { return findIntrinsic(name); }
    std::string launchIndex(char component) const override {
        return std::string("_optix_get_launch_index_") + component;
    }
    std::string launchDimension(char component) const override {
        return std::string("_optix_get_launch_dimension_") + component;
    }
    bool isProgramName(std::string_view name) const override {
        return programKind(name) != ProgramKind::kNone;
    }
    std::optional<size_t> parameterAt(ProgramKind, size_t, size_t) const override { return {}; }
    void lower(Unit& unit, const ProgramPayloads& payloads) const override {
        lowerIntrinsics(unit, payloads);
    }
};

} // namespace

const Flavor& optix7Flavor() {
    static const Optix7Flavor flavor;
    return flavor;
}

} // namespace sunstone::compiler
