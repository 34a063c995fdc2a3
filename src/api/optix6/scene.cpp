// SPDX-License-Identifier: Apache-2.0
// The preparation and the run of a launch. See scene.h.
#include "api/optix6/scene.h"

#include "api/optix6/report.h"
#include "base/log.h"
#include "compiler/flavor.h"
#include "devlib/flags.h"

#include <algorithm>
#include <cstring>

namespace sunstone::optix6 {

using compiler::ProgramKind;
using devlib::ClassicRecord;

namespace {

// The trace depth on GPUs, whose stack has a fixed depth, for programs that set none. Before
// release 6 the API had only stack sizes.
constexpr unsigned kDepthOfOldPrograms = 16;
// Bytes of stack on GPUs for functions that call themselves: the application's value, clamped to
// these limits.
constexpr RTsize kLeastRecursion = 8 << 10, kMostRecursion = 64 << 10;

std::string describe(const Object& object) {
    return message(nameOf(object.kind), " ", object.handle());
}

void validateGroup(const GeometryGroup& group) {
    const std::shared_ptr<Acceleration> acceleration = group.acceleration.lock();
    if (!acceleration)
        refuse(RT_ERROR_INVALID_VALUE, describe(group), " has no acceleration");
    if (acceleration->builder.empty())
        refuse(RT_ERROR_INVALID_VALUE, describe(group), " has an acceleration without a builder");
    for (size_t i = 0; i < group.instances.size(); ++i) {
        const std::shared_ptr<GeometryInstance> instance = group.instances[i].lock();
        if (!instance)
            refuse(RT_ERROR_INVALID_VALUE, "child ", i, " of ", describe(group), " is not set");
        instance->validate();
    }
}

void validateNode(const Node& node) {
    if (node.kind == Kind::kGeometryGroup)
        return validateGroup(static_cast<const GeometryGroup&>(node));
    if (node.kind == Kind::kTransform) {
        if (static_cast<const Transform&>(node).child.expired())
            refuse(RT_ERROR_INVALID_VALUE, describe(node), " has no child");
        return;
    }
    const auto& parent = static_cast<const ParentNode&>(node);
    for (size_t i = 0; i < parent.slots.size(); ++i)
        if (parent.slots[i].expired())
            refuse(RT_ERROR_INVALID_VALUE, "child ", i, " of ", describe(node), " is not set");
    if (node.kind == Kind::kSelector) {
        if (static_cast<const Selector&>(node).visit.expired())
            refuse(RT_ERROR_INVALID_VALUE, describe(node), " has no visit program");
        return;
    }
    const std::shared_ptr<Acceleration> acceleration =
        static_cast<const Group&>(node).acceleration.lock();
    if (!acceleration)
        refuse(RT_ERROR_INVALID_VALUE, describe(node), " has no acceleration");
    if (acceleration->builder.empty())
        refuse(RT_ERROR_INVALID_VALUE, describe(node), " has an acceleration without a builder");
}

} // namespace

Scene::Scene(Context& context)
    : context_(context), rayGeneration_(allocator<ClassicRecord>()),
      exception_(allocator<ClassicRecord>()), misses_(allocator<ClassicRecord>()),
      hits_(allocator<ClassicRecord>()), callables_(allocator<ClassicRecord>()),
      bounds_(allocator<ClassicRecord>()), visits_(allocator<ClassicRecord>()),
      nodes_(allocator<uint64_t>()), textures_(allocator<uint64_t>()),
      views_(allocator<const devlib::BufferView*>()),
      shared_(context.engine->backend, sizeof(Tables)) {}

void Scene::validate(Node& node) {
    seen_.clear();
    order_.clear();
    context_.noteStructure(); // the lists are filled again
    std::vector<const Node*> path;
    visitNode(std::static_pointer_cast<Node>(node.shared_from_this()), path);
}

void GeometryInstance::validate() const {
    const std::shared_ptr<Geometry> custom = geometry.lock();
    const std::shared_ptr<GeometryTriangles> mesh = triangles.lock();
    if (!custom && !mesh)
        refuse(RT_ERROR_INVALID_VALUE, describe(*this), " has no geometry");
    for (size_t i = 0; i < materials.size(); ++i)
        if (materials[i].expired())
            refuse(RT_ERROR_INVALID_VALUE, "material ", i, " of ", describe(*this), " is not set");
    if (custom)
        return custom->validate();
    mesh->validate();
    if (mesh->materialFlags.size() != std::max<size_t>(1, materials.size()))
        refuse(RT_ERROR_INVALID_VALUE, describe(*this), " has ", materials.size(),
               " materials, but its ", describe(*mesh), " has ", mesh->materialFlags.size());
    if (mesh->materialFlags.size() > 1 && !mesh->hasMaterialIndices)
        refuse(RT_ERROR_INVALID_CONTEXT, describe(*mesh), " has ", mesh->materialFlags.size(),
               " materials and no material indices");
}

void Geometry::validate() const {
    if (bounds.expired())
        refuse(RT_ERROR_INVALID_VALUE, describe(*this), " has no bounding box program");
    if (intersection.expired())
        refuse(RT_ERROR_INVALID_VALUE, describe(*this), " has no intersection program");
    if (motion.steps > 1 && bounds.lock()->code->parameters != 3)
        refuse(RT_ERROR_INVALID_VALUE, describe(*this), " has ", motion.steps,
               " motion steps, but its bounding box program takes none");
}

void GeometryTriangles::validate() const {
    if (vertices.empty())
        refuse(RT_ERROR_INVALID_VALUE, describe(*this), " has no vertices");
    if (vertices.size() > 1 && vertices.size() != motion.steps)
        refuse(RT_ERROR_INVALID_VALUE, describe(*this), " has ", vertices.size(),
               " vertex buffers and ", motion.steps, " motion steps");
    if (!hasIndices && uint64_t(primitives) * 3 != vertexCount)
        refuse(RT_ERROR_INVALID_VALUE, describe(*this), " has ", primitives,
               " triangles without indices, but ", vertexCount, " vertices");
}

// ---- the graph --------------------------------------------------------------------------------

void Scene::visitNode(const std::shared_ptr<Node>& node, std::vector<const Node*>& path) {
    if (std::find(path.begin(), path.end(), node.get()) != path.end())
        refuse(RT_ERROR_INVALID_VALUE, describe(*node), " is below itself in the graph");
    if (seen_.count(node.get()))
        return;
    validateNode(*node);
    path.push_back(node.get());
    for (const std::shared_ptr<Object>& child : node->children())
        if (isNode(child->kind))
            visitNode(std::static_pointer_cast<Node>(child), path);
    path.pop_back();
    seen_.insert(node.get());
    node->isInScene = true;
    order_.push_back(node);
}

// Collects the nodes that programs can reach: those of variables that a program reads, and
// everything below them.
void Scene::collectNodes() {
    order_.clear();
    seen_.clear();
    for (const Ref<Variable>& ref : context_.variables) {
        const std::shared_ptr<Variable> variable = ref.lock();
        const std::shared_ptr<Object> object = variable ? variable->object.lock() : nullptr;
        std::vector<const Node*> path;
        if (object && isNode(object->kind) && variable->isRead())
            visitNode(std::static_pointer_cast<Node>(object), path);
    }
}

// Stores the position of each node in the graph, for launches after small changes.
void Scene::linkNodes() {
    for (const std::shared_ptr<Node>& node : order_) {
        node->parents.clear();
        if (Acceleration* const acceleration = accelerationOf(*node))
            acceleration->owners.clear();
    }
    for (uint32_t i = 0; i < order_.size(); ++i) {
        Node& node = *order_[i];
        node.place = i;
        if (Acceleration* const acceleration = accelerationOf(node)) {
            acceleration->owners.push_back(i);
            acceleration->isInScene = true;
        }
        uint32_t slot = 0;
        for (const std::shared_ptr<Object>& child : node.children()) {
            if (isNode(child->kind))
                static_cast<Node&>(*child).parents.emplace_back(&node, slot);
            ++slot;
        }
    }
    checkDepth();
    hasMotion_ = hasMotion();
    hasOneLevel_ = hasOneLevel();
}

// Whether rays may enter the structure of the group instead of an instance of it.
static bool isPlainGroup(const Node& node) {
    return node.kind == Kind::kGroup && static_cast<const Group&>(node).mask == RT_VISIBILITY_ALL;
}

// Rays carry a list of the instances and transforms that they have entered. This counts the entries
// below each node as structures.cpp makes them, in two cases: for a node in the structure of its
// parent, and for a node at which rays start, which may need no entry of its own.
void Scene::checkDepth() const {
    constexpr unsigned kMost = devlib::kMaxGraphDepth - 1; // the last entry has a child
    for (const std::shared_ptr<Node>& node : order_) {     // children before parents
        const bool isTransform = node->kind == Kind::kTransform;
        const bool moves = isTransform && !static_cast<const Transform&>(*node).keys.empty();
        const bool isSelector = node->kind == Kind::kSelector;
        unsigned below = 0;
        for (const std::shared_ptr<Object>& object : node->children())
            if (isNode(object->kind)) {
                const auto& child = static_cast<const Node&>(*object);
                const bool starts = isSelector || (moves && isPlainGroup(child));
                below = std::max(below, starts ? child.levelsAtStart : child.levels);
            }
        node->levels = below + (moves ? 2 : isTransform ? 0 : 1);
        node->levelsAtStart = node->levels - (moves || isSelector || isPlainGroup(*node) ? 1 : 0);
        if (node->levelsAtStart > kMost)
            refuse(RT_ERROR_INVALID_VALUE, "the graph below ", describe(*node), " has ",
                   node->levelsAtStart, " levels, but the limit is ", kMost);
    }
}

// ---- programs and records ---------------------------------------------------------------------

compiler::PipelineRules Scene::rules() const {
    compiler::PipelineRules rules;
    rules.motionBlur = true;
    if (context_.isOnGpu()) {
        rules.motionBlur = hasMotion_;
        if (!rules.motionBlur && hasOneLevel_)
            rules.traversableGraphFlags = devlib::kAllowSingleLevelInstancing;
    }
    rules.optix6.attributeBytes = context_.attributeBytes();
    const auto flag = [&](RTexception exception, unsigned bit) {
        return isEnabled(context_, exception) ? bit : 0u;
    };
    // GPUs have a stack for the full depth, and checks of it exclude the fast kernels.
    const bool checksStack = !context_.isOnGpu() || context_.wantsStackChecks;
    rules.exceptionFlags =
        (checksStack ? flag(RT_EXCEPTION_STACK_OVERFLOW, devlib::kFlagStackOverflow) : 0u) |
        flag(RT_EXCEPTION_TRACE_DEPTH_EXCEEDED, devlib::kFlagTraceDepth) |
        flag(RT_EXCEPTION_USER, devlib::kFlagUser);
    rules.optix6.exceptions =
        flag(RT_EXCEPTION_BUFFER_INDEX_OUT_OF_BOUNDS, devlib::kClassicBufferIndex) |
        flag(RT_EXCEPTION_BUFFER_ID_INVALID, devlib::kClassicBufferId) |
        flag(RT_EXCEPTION_TEXTURE_ID_INVALID, devlib::kClassicTextureId) |
        flag(RT_EXCEPTION_PROGRAM_ID_INVALID, devlib::kClassicProgramId) |
        flag(RT_EXCEPTION_INDEX_OUT_OF_BOUNDS, devlib::kClassicIndex) |
        flag(RT_EXCEPTION_INVALID_RAY, devlib::kClassicInvalidRay) |
        flag(RT_EXCEPTION_PAYLOAD_ACCESS_OUT_OF_BOUNDS, devlib::kClassicPayload) |
        flag(RT_EXCEPTION_USER_EXCEPTION_CODE_OUT_OF_BOUNDS, devlib::kClassicUserCode);
    if (context_.isCallableDepthSet && isEnabled(context_, RT_EXCEPTION_STACK_OVERFLOW) &&
        context_.maxCallableDepth != ~0u)
        rules.optix6.maxCallableDepth = context_.maxCallableDepth + 1;
    return rules;
}

void Scene::bindEntries() {
    // Callable programs by their ids; programs bound to variables follow.
    callables_.assign(context_.programs.size(), ClassicRecord{});
    const Scope& context = context_.scope;
    const auto bindOne = [&](const Program* program, devlib::GroupKind kind,
                             ProgramKind programKind) {
        ClassicRecord made = record(kind, {{devlib::kRoleMain, program, programKind}});
        if (program)
            made.blocks[devlib::kBlockMain] = block(*program, {&context});
        return made;
    };
    rayGeneration_.clear();
    exception_.clear();
    misses_.clear();
    for (const EntryPoint& entry : context_.entryPoints) {
        const auto program = entry.rayGeneration.lock(), handler = entry.exception.lock();
        rayGeneration_.push_back(
            program ? bindOne(program.get(), devlib::kGroupRaygen, ProgramKind::kRaygen)
                    : ClassicRecord{});
        exception_.push_back(
            handler ? bindOne(handler.get(), devlib::kGroupException, ProgramKind::kException)
                    : ClassicRecord{});
    }
    for (const Ref<Program>& ref : context_.misses)
        misses_.push_back(bindOne(ref.lock().get(), devlib::kGroupMiss, ProgramKind::kMiss));
    for (size_t id = 1; id < context_.programs.size(); ++id)
        if (const std::shared_ptr<Program> program = context_.programs[id].lock();
            program && !program->code->isEntry) {
            ClassicRecord made =
                record(devlib::kGroupCallables,
                       {{devlib::kRoleDirect, program.get(), ProgramKind::kDirectCallable}});
            made.blocks[devlib::kBlockMain] = block(*program, {&context});
            callables_[id] = made;
        }
}

// Whether the program, or one that it calls, may read attributes.
static bool mayRead(const Program* program) {
    return program &&
           (program->code->variables.readsAttributes() || program->code->variables.callsPrograms);
}

// Geometry of one kind with the same motion keys shares a structure.
static std::vector<GeometrySet> setsOf(const GeometryGroup& group) {
    std::vector<GeometrySet> sets;
    for (const bool isMesh : {true, false})
        for (size_t child = 0; child < group.instances.size(); ++child) {
            const GeometryInstance& instance = *group.instances[child].lock();
            const auto mesh = instance.triangles.lock();
            const auto geometry = instance.geometry.lock();
            if (bool(mesh) != isMesh)
                continue;
            const bvh::MotionOptions motion = optionsOf(mesh ? mesh->motion : geometry->motion);
            auto found = std::find_if(sets.begin(), sets.end(), [&](const GeometrySet& set) {
                return set.isMesh == isMesh && sameMotion(set.motion, motion);
            });
            if (found == sets.end())
                found = sets.insert(sets.end(), {isMesh, motion, {}, 0});
            found->instances.push_back(child);
        }
    return sets;
}

void Scene::bindHits(GeometryGroup& group) {
    const size_t rayTypes = context_.misses.size();
    group.sets = setsOf(group);
    for (GeometrySet& set : group.sets) {
        set.firstEntry = uint32_t(rayTypes ? hits_.size() / rayTypes : 0);
        for (const size_t child : set.instances)
            bindInstance(*group.instances[child].lock(), child);
    }
}

// The records of the geometry instance with this number in its group.
void Scene::bindInstance(const GeometryInstance& instance, size_t number) {
    const auto mesh = instance.triangles.lock();
    const auto geometry = instance.geometry.lock();
    const Scoped& shaped = mesh ? static_cast<const Scoped&>(*mesh) : *geometry;
    const Scope& shape = shaped.scope;
    instance.isInScene = shaped.isInScene = true;
    for (const Ref<Material>& material : instance.materials)
        material.lock()->isInScene = true;
    const size_t count = std::max<size_t>(1, instance.materials.size());
    for (size_t m = 0; m < count; ++m)
        for (unsigned rayType = 0; rayType < context_.misses.size(); ++rayType) {
            const auto material =
                m < instance.materials.size() ? instance.materials[m].lock() : nullptr;
            hits_.push_back(hitRecord(instance, shape, material.get(), rayType));
            hits_.back().header.pad[devlib::kWordChild] = uint32_t(number);
            hits_.back().header.pad[devlib::kWordMaterials] = uint32_t(count);
        }
    if (!geometry)
        return;
    const auto bounds = geometry->bounds.lock();
    ClassicRecord made =
        record(devlib::kGroupBounds, {{devlib::kRoleMain, bounds.get(), ProgramKind::kBounds}});
    made.blocks[devlib::kBlockMain] = block(*bounds, {&instance.scope, &shape, &context_.scope});
    boundsOf_[&instance] = bounds_.size();
    bounds_.push_back(made);
}

// Reports the attributes that a hit program reads and no program sets. `setter`: the intersection
// program, or the attribute program of triangles, if they have one.
void Scene::remarkOnAttributes(const Program& reader, const Program* setter) {
    using compiler::optix6::DeviceVariable, compiler::optix6::VariableUse;
    // Thousands of records have the same programs.
    if (!remarked_.insert({reader.code.get(), setter ? setter->code.get() : nullptr}).second)
        return;
    if (setter && setter->code->variables.callsPrograms)
        return; // which may set them
    for (const DeviceVariable& read : reader.code->variables.list) {
        const bool isBuiltIn =
            !context_.attributePlaces.contains({read.attribute, read.bytes}); // of triangles
        if (read.use != VariableUse::kAttribute || isBuiltIn)
            continue;
        std::string cause = "but the triangles have no attribute program";
        if (setter) {
            const auto& list = setter->code->variables.list;
            const auto set = std::ranges::find_if(list, [&](const DeviceVariable& variable) {
                return variable.use == VariableUse::kAttribute &&
                       variable.attribute == read.attribute;
            });
            if (set != list.end() && set->bytes == read.bytes)
                continue;
            cause = message("which program \"", setter->code->name,
                            set == list.end() ? "\" does not set"
                                              : message("\" has with ", set->bytes, " bytes"));
        }
        const std::string line =
            message("program \"", reader.code->name, "\" reads attribute \"", read.attribute,
                    "\" with ", read.bytes, " bytes, ", cause, "; its value is undefined");
        context_.report(kReportErrors, "SCENE", line);
        log(LogLevel::kWarning, "optix6", line);
    }
}

ClassicRecord Scene::hitRecord(const GeometryInstance& instance, const Scope& shape,
                               const Material* material, unsigned rayType) {
    const auto mesh = instance.triangles.lock();
    const auto geometry = instance.geometry.lock();
    const auto intersection = geometry ? geometry->intersection.lock() : nullptr;
    const auto attributes = mesh ? mesh->attributes.lock() : nullptr;
    const auto find = [&](const std::map<unsigned, Ref<Program>>& list) {
        const auto found = list.find(rayType);
        return found == list.end() ? nullptr : found->second.lock();
    };
    const auto closest = material ? find(material->closestHit) : nullptr;
    const auto any = material ? find(material->anyHit) : nullptr;
    ClassicRecord made =
        record(devlib::kGroupHit,
               {{devlib::kRoleMain, closest.get(), ProgramKind::kClosestHit},
                {devlib::kRoleAnyHit, any.get(), ProgramKind::kAnyHit},
                {devlib::kRoleIntersection, intersection.get(), ProgramKind::kIntersection},
                {devlib::kRoleAttribute, attributes.get(), ProgramKind::kAttribute}});
    const Scopes hit = {&instance.scope, material ? &material->scope : &instance.scope,
                        &context_.scope};
    const Scopes shapes = {&instance.scope, &shape, &context_.scope};
    const Scopes ofAttributes = {&shape, &instance.scope, &context_.scope};
    if (closest)
        made.blocks[devlib::kBlockMain] = block(*closest, hit);
    if (any)
        made.blocks[devlib::kBlockAnyHit] = block(*any, hit);
    if (intersection)
        made.blocks[devlib::kBlockIntersection] = block(*intersection, shapes);
    if (attributes)
        made.blocks[devlib::kBlockAttribute] = block(*attributes, ofAttributes);
    const Program* const setter = mesh ? attributes.get() : intersection.get();
    for (const Program* reader : {closest.get(), any.get()})
        if (reader && (setter || mesh))
            remarkOnAttributes(*reader, setter);
    made.header.pad[devlib::kWordReaders] =
        (mayRead(any.get()) ? devlib::kAnyHitReads : 0u) |
        (mayRead(closest.get()) ? devlib::kClosestHitReads : 0u);
    return made;
}

void Scene::bindVisit(const Selector& selector) {
    const std::shared_ptr<Program> program = selector.visit.lock();
    ClassicRecord made =
        record(devlib::kGroupVisit, {{devlib::kRoleMain, program.get(), ProgramKind::kVisit}});
    made.blocks[devlib::kBlockMain] = block(*program, {&selector.scope, &context_.scope});
    visitOf_[&selector] = visits_.size();
    visits_.push_back(made);
}

// Updates everything that depends on the structure of the graph, the scopes and the programs.
void Scene::bind() {
    for (const auto& [key, entry] : blocks_)
        for (const std::shared_ptr<Variable>& variable : entry->found)
            if (variable)
                variable->users.clear();
    blocks_.clear();
    blockMemory_.clear();
    boundCallables_.clear();
    bindsCycle_ = false;
    boundDepth_ = 0; // a refusal may have left it
    ++bind_;
    hits_.clear();
    bounds_.clear();
    boundsOf_.clear();
    visits_.clear();
    visitOf_.clear();
    collectSamplers();
    bindEntries();
    for (const std::shared_ptr<Node>& node : order_) {
        if (node->kind == Kind::kGeometryGroup)
            bindHits(static_cast<GeometryGroup&>(*node));
        if (node->kind == Kind::kSelector)
            bindVisit(static_cast<Selector&>(*node));
    }
}

// Whether any object in the graph has motion.
bool Scene::hasMotion() const {
    const auto moves = [](const Ref<GeometryInstance>& ref) {
        const auto instance = ref.lock();
        const auto mesh = instance->triangles.lock();
        const auto geometry = instance->geometry.lock();
        return (mesh && mesh->motion.steps > 1) || (geometry && geometry->motion.steps > 1);
    };
    return std::any_of(order_.begin(), order_.end(), [&](const std::shared_ptr<Node>& node) {
        if (node->kind == Kind::kTransform)
            return !static_cast<const Transform&>(*node).keys.empty();
        if (node->kind != Kind::kGeometryGroup)
            return false;
        const auto& instances = static_cast<const GeometryGroup&>(*node).instances;
        return std::any_of(instances.begin(), instances.end(), moves);
    });
}

// Whether no structure of instances is below another one or below an instance, and there is no
// selector.
bool Scene::hasOneLevel() const {
    std::set<const Node*> groups; // and the nodes above them
    for (const std::shared_ptr<Node>& node : order_) {
        if (node->kind == Kind::kGeometryGroup)
            continue;
        if (node->kind == Kind::kSelector)
            return false;
        for (const std::shared_ptr<Object>& child : node->children())
            if (groups.count(dynamic_cast<const Node*>(child.get())))
                return false;
        // A transform of a geometry group is a matrix; one of several children has a structure.
        if (node->kind == Kind::kGroup) {
            if (static_cast<const Group&>(*node).mask != 0xFF)
                return false; // rays enter an instance, which has the mask
            groups.insert(node.get());
        }
    }
    return true;
}

void Scene::makePipeline() {
    compiler::PipelineRules wanted = rules();
    engine::PipelineLimits limits;
    if (context_.isTraceDepthSet)
        limits.maxTraceDepth = context_.maxTraceDepth;
    else // on CPUs the stack limits recursion
        limits.maxTraceDepth = context_.isOnGpu() ? kDepthOfOldPrograms : ~0u;
    const bool same = pipeline_ && wanted.optix6 == rules_.optix6 &&
                      wanted.motionBlur == rules_.motionBlur &&
                      wanted.traversableGraphFlags == rules_.traversableGraphFlags &&
                      wanted.exceptionFlags == rules_.exceptionFlags &&
                      pipeline_->limits.get().maxTraceDepth == limits.maxTraceDepth;
    if (same && !needsPipeline_)
        return reserveStack();
    // Programs that alternate are kept, except after a failure, which they may have caused.
    constexpr uint32_t kKeptPipelines = 8;
    std::erase_if(groups_, [&](const auto& entry) {
        const BoundGroup& group = entry.second;
        return group.bind != bind_ && (isBroken_ || pipelines_ - group.pipeline >= kKeptPipelines);
    });
    const TimedReport timed(context_);
    isBroken_ = true;
    ++pipelines_;
    std::vector<std::shared_ptr<engine::ProgramGroup>> groups;
    for (const auto& [key, bound] : groups_)
        groups.push_back(bound.group);
    // Addresses order the map. Numbers give equal scenes equal code in the caches.
    std::ranges::sort(groups, {}, [](const auto& group) { return group->number; });
    pipeline_ =
        engine::createPipeline(*context_.engine, groups, wanted, limits, &compiler::optix6Flavor());
    pipeline_->launchParamsSize = sizeof(devlib::ClassicLaunch);
    if (!pipeline_->feedback.empty())
        context_.engine->log(LogLevel::kInfo, "PIPELINE", pipeline_->feedback);
    rules_ = std::move(wanted);
    needsPipeline_ = isBroken_ = false;
    reserveStack();
    timed.tell(kReportStatistics, "PIPELINE", "a pipeline of ", groups.size(),
               " groups of programs");
}

// On GPUs the frames of programs are known, but not the depth of functions that call themselves,
// directly or through variables.
void Scene::reserveStack() {
    const auto recurses = [](const auto& group) {
        return std::any_of(
            group.first.second.begin(), group.first.second.end(),
            [](const ProgramCode* code) { return code && code->variables.recurses; });
    };
    if (!context_.isOnGpu() ||
        (!bindsCycle_ && std::none_of(groups_.begin(), groups_.end(), recurses)))
        return;
    const auto bytes = unsigned(std::clamp(context_.stackSize, kLeastRecursion, kMostRecursion));
    if (pipeline_->limits.get().continuationStack == bytes)
        return;
    pipeline_->limits.update(
        [&](engine::PipelineLimits& limits) { limits.continuationStack = bytes; });
    context_.engine->backend->setStackSizes(*context_.engine, *pipeline_);
}

void Scene::collectSamplers() {
    samplers_.clear();
    for (const Ref<Variable>& ref : context_.variables) {
        const std::shared_ptr<Variable> variable = ref.lock();
        const std::shared_ptr<Object> object = variable ? variable->object.lock() : nullptr;
        if (!object || object->kind != Kind::kTextureSampler || !variable->isRead())
            continue;
        object->isInScene = true;
        samplers_.emplace_back(variable, std::static_pointer_cast<TextureSampler>(object));
    }
}

// Updates textures of samplers that programs can reach: those of variables, and those with ids.
void Scene::updateTextures() {
    const auto update = [this](TextureSampler& sampler, const std::string* variable) {
        if (!sampler.update(variable))
            return;
        newTextures_.insert(&sampler);
        sampler.noteIds();
    };
    for (const auto& [variable, ref] : samplers_)
        if (const std::shared_ptr<TextureSampler> sampler = ref.lock())
            update(*sampler, &variable->name);
    for (const Ref<TextureSampler>& ref : context_.samplers)
        if (const std::shared_ptr<TextureSampler> sampler = ref.lock())
            update(*sampler, nullptr);
    for (const auto& [variable, ref] : samplers_)
        if (newTextures_.count(ref.lock().get()))
            variable->writeUsers();
    newTextures_.clear();
}

namespace {

// Host accesses to shared memory may move pages between host and GPU. Tables are therefore compared
// with copies and written only after changes.
template <class T>
void write(SharedVector<T>& shared, std::vector<T>& copy, std::vector<T> now) {
    if (copy == now)
        return;
    copy = std::move(now);
    shared.assign(copy.begin(), copy.end());
}

} // namespace

void Scene::fillNodes() {
    std::vector<uint64_t> nodes(context_.nodes.size());
    for (const std::shared_ptr<Node>& node : order_)
        nodes[node->id] = node->nodeHandle;
    write(nodes_, nodesCopy_, std::move(nodes));
}

void Scene::fillIds() {
    if (!context_.idsChanged.exchange(false))
        return;
    std::vector<uint64_t> textures(context_.samplers.size());
    std::vector<const devlib::BufferView*> views(context_.buffers.size(), &tables().emptyView);
    for (size_t id = 1; id < views.size(); ++id)
        if (const std::shared_ptr<Buffer> buffer = context_.buffers[id].lock()) {
            buffer->requireRegistered();
            views[id] = &buffer->view();
        }
    for (size_t id = 1; id < textures.size(); ++id)
        if (const std::shared_ptr<TextureSampler> sampler = context_.samplers[id].lock())
            textures[id] = sampler->texture;
    write(views_, viewsCopy_, std::move(views));
    write(textures_, texturesCopy_, std::move(textures));
}

void Scene::fillTables() {
    fillIds();
    devlib::ClassicLaunch launch{};
    launch.nodes = nodes_.data();
    launch.nodeCount = uint32_t(nodes_.size());
    launch.buffers = views_.data();
    launch.bufferCount = uint32_t(views_.size());
    launch.textures = textures_.data();
    launch.textureCount = uint32_t(textures_.size());
    launch.rayTypes = uint32_t(context_.misses.size());
    launch.exceptions = rules_.optix6.exceptions;
    launch.printEnabled = context_.printEnabled;
    std::copy_n(context_.printIndex, 3, launch.printIndex);
    devlib::bindClassic(launch);
    if (std::memcmp(&launch, &launchCopy_, sizeof launch) != 0) {
        launchCopy_ = launch;
        tables().launch = launch;
    }
}

void Scene::update() {
    const bool changed = context_.structureChanged;
    context_.structureChanged = true; // until all updates have succeeded
    if (changed) {
        context_.idsChanged = true;
        const TimedReport timed(context_);
        collectNodes();
        linkNodes();
        bind();
        timed.tell(kReportStatistics, "SCENE STAT", order_.size(), " nodes, ", hits_.size(),
                   " hit records and ", blocks_.size(), " blocks of variables");
    }
    makePipeline();
    updateTextures();
    fillTables(); // for bounds programs
    if (changed) {
        buildStructures();
        fillNodes();
        fillTables();
    } else {
        followChanges();
    }
    clearChanges();
    context_.structureChanged = false;
}

// All records but those of the entry point.
devlib::SbtView Scene::table() const {
    devlib::SbtView table{};
    table.missBase = uint64_t(misses_.data());
    table.hitBase = uint64_t(hits_.data());
    table.callableBase = uint64_t(callables_.data());
    table.missStride = table.hitStride = table.callableStride = sizeof(ClassicRecord);
    table.missCount = uint32_t(misses_.size());
    table.hitCount = uint32_t(hits_.size());
    table.callableCount = uint32_t(callables_.size());
    return table;
}

engine::LaunchRequest Scene::request(unsigned entryPoint, uint32_t width, uint32_t height,
                                     uint32_t depth) const {
    const EntryPoint& entry = context_.entryPoints[entryPoint];
    if (entry.rayGeneration.expired())
        refuse(RT_ERROR_INVALID_CONTEXT, "entry point ", entryPoint,
               " has no ray generation program");
    engine::LaunchRequest request;
    request.pipeline = pipeline_;
    request.limits = pipeline_->limits.get();
    if (!context_.isOnGpu())
        request.limits.continuationStack = ~0u; // that of the thread
    request.sbt = table();
    request.sbt.entryRecord = uint64_t(&rayGeneration_[entryPoint]);
    if (!entry.exception.expired())
        request.sbt.exceptionRecord = uint64_t(&exception_[entryPoint]);
    request.params = &tables().launch;
    request.paramsSize = sizeof(devlib::ClassicLaunch);
    request.waits = true;
    request.width = width;
    request.height = height;
    request.depth = depth;
    return request;
}

void Scene::run(const engine::LaunchRequest& request, uint32_t subframe) {
    if (request.width == 0 || request.height == 0 || request.depth == 0)
        return;
    if (launchCopy_.subframe != subframe)
        launchCopy_.subframe = tables().launch.subframe = subframe;
    engine::launch(context_.engine, request);
    context_.engine->device->synchronize(nullptr);
}

void Scene::launch(unsigned entryPoint, uint32_t width, uint32_t height, uint32_t depth) {
    update();
    const TimedReport timed(context_);
    run(request(entryPoint, width, height, depth), 0);
    timed.tell(kReportLaunches, "LAUNCH", "entry point ", entryPoint, " with ", width, " by ",
               height, " by ", depth, " launch indices");
}

} // namespace sunstone::optix6
