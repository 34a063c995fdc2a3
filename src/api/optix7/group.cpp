// SPDX-License-Identifier: Apache-2.0
// Program groups and their SBT headers (OptiX 7.4, sections 3.8, 3.9.2.2 and 5.29 to 5.32).
#include "api/optix7/entry_points.h"
#include "api/optix7/options.h"
#include "compiler/optix7/program_kind.h"

#include <optional>
#include <vector>

namespace sunstone::optix7 {
namespace {

using compiler::ProgramKind;

// Collects the programs of one description into a group.
class GroupBuilder {
public:
    GroupBuilder(std::shared_ptr<DeviceContext> context, std::string where)
        : context_(std::move(context)), where_(std::move(where)) {
        object_ = std::make_shared<GroupObject>();
        object_->context = context_;
        object_->group = std::make_shared<engine::ProgramGroup>();
    }

    // Resolves one module/name pair. Both null means "no program", which is legal unless
    // `required`.
    engine::ProgramRef program(OptixModule module, const char* name, ProgramKind kind,
                               const char* field, bool required) {
        std::string place = where_ + field;
        if (!module && !name) {
            if (required)
                fail(Code::kInvalidValue, place, ": module and entry function name are null, but "
                     "this program is required");
            return {};
        }
        if (!module || !name)
            fail(Code::kInvalidValue, place, ": ", module ? "module given without an entry "
                 "function name" : "entry function name given without a module");
        std::shared_ptr<ModuleObject> owner = moduleOf(module, place.c_str());
        if (owner->context != context_)
            fail(Code::kInvalidValue, place, ": the module belongs to another device context");
        if (owner->builtinPrimitive)
            fail(Code::kInvalidValue, place, ": a module of optixBuiltinISModuleGet is for "
                 "intersection, with a null entry function name");
        if (compiler::programKind(name) != kind)
            fail(Code::kInvalidValue, place, ": '", name, "' does not begin with ",
                 compiler::prefixOf(kind));
        std::shared_ptr<const engine::Module> made = completedModule(*owner, place.c_str());
        if (!made->findProgram(name))
            fail(Code::kInvalidValue, place, ": the module has no program '", name, "'");
        object_->modules.push_back(owner);
        return {made, name, kind, -1};
    }

    // Whether the pair names a built-in intersection, which traversal performs itself.
    bool builtinIntersection(OptixModule module, const char* name) {
        if (!module || name)
            return false;
        const std::string place = where_ + ".hitgroup (intersection)";
        std::shared_ptr<ModuleObject> owner = moduleOf(module, place.c_str());
        if (!owner->builtinPrimitive)
            return false;
        if (owner->context != context_)
            fail(Code::kInvalidValue, place, ": the module belongs to another device context");
        object_->modules.push_back(owner);
        group().builtinPrimitive = owner->builtinPrimitive;
        return true;
    }

    GroupObject& object() { return *object_; }
    engine::ProgramGroup& group() { return *object_->group; }

    std::shared_ptr<GroupObject> finish(const compiler::PayloadType* payloadType) {
        try {
            engine::choosePayloadType(group(), payloadType);
        } catch (const Error& error) {
            fail(error.code(), where_, ": ", error.what());
        }
        group().number = context_->engine->nextGroup++;
        return object_;
    }

private:
    std::shared_ptr<DeviceContext> context_;
    std::string where_;
    std::shared_ptr<GroupObject> object_;
};

// Sizes come from machine code, so they are computed only on request.
OptixStackSizes stackSizesOf(const GroupObject& object) {
    OptixStackSizes sizes{};
    const engine::ProgramGroup& g = *object.group;
    const auto stackOf = [&](const engine::ProgramRef& ref) {
        return ref ? engine::stackSizeOf(ref) : 0;
    };
    switch (g.kind) {
    case devlib::kGroupRaygen: sizes.cssRG = stackOf(g.programs[devlib::kRoleMain]); break;
    case devlib::kGroupMiss: sizes.cssMS = stackOf(g.programs[devlib::kRoleMain]); break;
    default: break;
    case devlib::kGroupHit:
        sizes.cssCH = stackOf(g.programs[devlib::kRoleMain]);
        sizes.cssAH = stackOf(g.programs[devlib::kRoleAnyHit]);
        sizes.cssIS = stackOf(g.programs[devlib::kRoleIntersection]);
        break;
    case devlib::kGroupCallables:
        sizes.cssCC = stackOf(g.programs[devlib::kRoleContinuation]);
        sizes.dssDC = stackOf(g.programs[devlib::kRoleDirect]);
        break;
    }
    return sizes;
}

std::shared_ptr<GroupObject> buildGroup(const std::shared_ptr<DeviceContext>& context,
                                        const OptixProgramGroupDesc& desc, unsigned index,
                                        const compiler::PayloadType* payloadType) {
    GroupBuilder builder(context, message("programDescriptions[", index, "]"));
    engine::ProgramGroup& group = builder.group();
    if (desc.flags != OPTIX_PROGRAM_GROUP_FLAGS_NONE)
        tolerate({*context, "optixProgramGroupCreate"}, "they are ignored", "programDescriptions[",
                 index, "].flags = ", desc.flags, ", but no flag is defined");
    switch (desc.kind) {
    case OPTIX_PROGRAM_GROUP_KIND_RAYGEN:
        group.kind = devlib::kGroupRaygen;
        group.programs[devlib::kRoleMain] = builder.program(desc.raygen.module, desc.raygen.entryFunctionName,
                                     ProgramKind::kRaygen, ".raygen", true);
        break;
    case OPTIX_PROGRAM_GROUP_KIND_MISS:
        group.kind = devlib::kGroupMiss;
        group.programs[devlib::kRoleMain] = builder.program(desc.miss.module, desc.miss.entryFunctionName,
                                     ProgramKind::kMiss, ".miss", false);
        break;
    case OPTIX_PROGRAM_GROUP_KIND_EXCEPTION:
        group.kind = devlib::kGroupException;
        group.programs[devlib::kRoleMain] = builder.program(desc.exception.module, desc.exception.entryFunctionName,
                                     ProgramKind::kException, ".exception", true);
        break;
    case OPTIX_PROGRAM_GROUP_KIND_HITGROUP: {
        const OptixProgramGroupHitgroup& hit = desc.hitgroup;
        group.kind = devlib::kGroupHit;
        group.programs[devlib::kRoleMain] = builder.program(hit.moduleCH, hit.entryFunctionNameCH,
                                     ProgramKind::kClosestHit, ".hitgroup (closest-hit)", false);
        group.programs[devlib::kRoleAnyHit] = builder.program(hit.moduleAH, hit.entryFunctionNameAH,
                                       ProgramKind::kAnyHit, ".hitgroup (any-hit)", false);
        if (builder.builtinIntersection(hit.moduleIS, hit.entryFunctionNameIS))
            break;
        group.programs[devlib::kRoleIntersection] =
            builder.program(hit.moduleIS, hit.entryFunctionNameIS, ProgramKind::kIntersection,
                            ".hitgroup (intersection)", false);
        break;
    }
    case OPTIX_PROGRAM_GROUP_KIND_CALLABLES: {
        const OptixProgramGroupCallables& callables = desc.callables;
        group.kind = devlib::kGroupCallables;
        group.programs[devlib::kRoleDirect] =
            builder.program(callables.moduleDC, callables.entryFunctionNameDC,
                            ProgramKind::kDirectCallable, ".callables (direct)", false);
        group.programs[devlib::kRoleContinuation] =
            builder.program(callables.moduleCC, callables.entryFunctionNameCC,
                            ProgramKind::kContinuationCallable, ".callables (continuation)", false);
        if (!group.programs[devlib::kRoleDirect] && !group.programs[devlib::kRoleContinuation])
            fail(Code::kInvalidValue, "programDescriptions[", index, "].callables has neither a "
                 "direct nor a continuation callable");
        break;
    }
    default:
        fail(Code::kInvalidValue, "programDescriptions[", index, "].kind = ", unsigned(desc.kind),
             " is unknown");
    }
    return builder.finish(payloadType);
}

} // namespace

OptixResult programGroupCreate(OptixDeviceContext context, const OptixProgramGroupDesc* descs,
                               unsigned count, const OptixProgramGroupOptions* options,
                               char* logString, size_t* logStringSize, OptixProgramGroup* out) {
    std::string feedback;
    std::shared_ptr<DeviceContext> owner = peek(context);
    OptixResult result = guarded(owner, "optixProgramGroupCreate", [&] {
        contextOf(context);
        if (count == 0)
            fail(Code::kInvalidValue, "numProgramGroups is 0");
        requireNonNull(descs, "programDescriptions");
        requireNonNull(out, "programGroups");
        std::fill(out, out + count, nullptr);
        std::optional<compiler::PayloadType> payloadType;
        if (options && options->payloadType)
            payloadType = checkPayloadType(*options->payloadType, "*options->payloadType");
        std::vector<std::shared_ptr<GroupObject>> made;
        for (unsigned i = 0; i < count; ++i)
            made.push_back(buildGroup(owner, descs[i], i, payloadType ? &*payloadType : nullptr));
        for (unsigned i = 0; i < count; ++i)
            out[i] = static_cast<OptixProgramGroup>(groups().add(made[i]));
    }, &feedback);
    writeLogString(feedback, logString, logStringSize);
    return result;
}

OptixResult programGroupDestroy(OptixProgramGroup group) {
    std::shared_ptr<GroupObject> object = groups().find(group);
    return guarded(object ? object->context : nullptr, "optixProgramGroupDestroy", [&] {
        groupOf(group, "programGroup");
        groups().remove(group);
    });
}

OptixResult programGroupGetStackSize(OptixProgramGroup group, OptixStackSizes* sizes) {
    std::shared_ptr<GroupObject> object = groups().find(group);
    return guarded(object ? object->context : nullptr, "optixProgramGroupGetStackSize", [&] {
        groupOf(group, "programGroup");
        requireNonNull(sizes, "stackSizes");
        std::call_once(object->stackSizesKnown,
                       [&] { object->stackSizes = stackSizesOf(*object); });
        *sizes = object->stackSizes;
    });
}

OptixResult sbtRecordPackHeader(OptixProgramGroup group, void* header) {
    std::shared_ptr<GroupObject> object = groups().find(group);
    return guarded(object ? object->context : nullptr, "optixSbtRecordPackHeader", [&] {
        groupOf(group, "programGroup");
        requireNonNull(header, "sbtRecordHeaderHostPointer");
        engine::packSbtHeader(*object->group, header);
    });
}

} // namespace sunstone::optix7
