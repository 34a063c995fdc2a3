// SPDX-License-Identifier: Apache-2.0
// The classic API as a flavor of device code. The place where the application binds a program
// determines its kind; names do not.
#include "compiler/optix6/intrinsics.h"
#include "compiler/optix6/lower.h"
#include "compiler/optix6/texture_calls.h"
#include "compiler/optix6/variables.h"

namespace sunstone::compiler {

namespace {

using devlib::Hit;
using devlib::RayState;

class Optix6Flavor final : public Flavor {
public:
    const char* name() const override { return "optix6"; }
    bool isIntrinsicName(std::string_view name) const override {
        // Texture lookups by id are functions of the module.
        if (name.starts_with(optix6::kTextureCallPrefix))
            return false;
        return name.starts_with(optix6::kPrefix) || name.starts_with(optix6::kVariablePrefix);
    }
    const Intrinsic* find(std::string_view name) const override { return optix6::find(name); }
    std::string launchIndex(char component) const override {
        return std::string("_rt_launch_index_") + component;
    }
    std::string launchDimension(char component) const override {
        return std::string("_rt_launch_dim_") + component;
    }
    // Modules do not link, because all source files declare the same variables: the current ray,
    // attributes, the launch index.
    bool linksModules() const override { return false; }
    bool isProgramName(std::string_view) const override { return false; }
    bool allowsRecursion() const override { return true; }

    // Intersection: primitive. Bounds: primitive, with motion the step, box.
    std::optional<size_t> parameterAt(ProgramKind kind, size_t index, size_t count) const override {
        constexpr size_t kPrimitive = offsetof(RayState, hit) + offsetof(Hit, primitive);
        constexpr size_t kStep = offsetof(RayState, hit) + offsetof(Hit, instanceIndex);
        if (kind == ProgramKind::kIntersection && count == 1)
            return kPrimitive;
        if (kind != ProgramKind::kBounds || count < 2 || count > 3)
            return {};
        if (index == 0)
            return kPrimitive;
        return index + 1 == count ? offsetof(RayState, payloadMemory) : kStep;
    }
    std::string variableIntrinsic(const ptx::Module& module,
                                  const ptx::Variable& variable) const override {
        if (optix6::describe(module, variable).use == optix6::VariableUse::kNone)
            return {};
        return std::string(optix6::kVariablePrefix) + std::string(variable.name);
    }
    bool hasGlobalsOnStack() const override { return true; } // payloads, attributes
    void lower(Unit& unit, const ProgramPayloads&) const override { optix6::lowerPrograms(unit); }
};

} // namespace

const Flavor& optix6Flavor() {
    static const auto* const flavor = new Optix6Flavor;
    return *flavor;
}

} // namespace sunstone::compiler
