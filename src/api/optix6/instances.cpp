// SPDX-License-Identifier: Apache-2.0
#include "api/optix6/instances.h"

#include "api/optix6/report.h"
#include "devlib/graph.h"
#include "engine/accel.h"
#include "math/matrix.h"

#include <algorithm>
#include <cstring>

namespace sunstone::optix6 {

namespace {

// If more than one child in so many has changed, a build costs little more than the updates.
constexpr size_t kMostChanged = 4;
// A ray through the updated tree costs at most this much more than through a new one.
constexpr double kMostDegraded = 1.5;

bvh::BuildOptions buildOptions() {
    bvh::BuildOptions options;
    options.preferFastTrace = true;
    options.allowUpdate = true;
    return options;
}

// Whether rays enter another traversable than the one that provides the bounds.
bool isSpecial(const Child& child) {
    return child.handle != child.instance.traversableHandle;
}

// Whether both have the same box.
bool coversSame(const Child& a, const Child& b) {
    return a.instance.traversableHandle == b.instance.traversableHandle && a.version == b.version &&
           (a.instance.visibilityMask == 0) == (b.instance.visibilityMask == 0) &&
           std::memcmp(a.instance.transform, b.instance.transform, sizeof a.instance.transform) ==
               0;
}

} // namespace

void InstanceStructure::show(const std::vector<Child>& children) {
    const size_t known = children_.size();
    if (known > children.size())
        std::erase_if(stale_, [&](uint32_t i) { return i >= children.size(); });
    for (size_t i = children.size(); i < known; ++i)
        special_ -= isSpecial(children_[i]);
    children_.resize(children.size());
    isStale_.resize(children.size());
    for (size_t i = 0; i < children.size(); ++i)
        showOne(i, children[i]);
    for (size_t i = children.size(); i < std::min(known, built_); ++i)
        write(i);
}

void InstanceStructure::show(size_t first, std::span<const Child> children) {
    for (size_t i = 0; i < children.size(); ++i)
        showOne(first + i, children[i]);
}

void InstanceStructure::showOne(size_t index, const Child& child) {
    Child& known = children_[index];
    if (!coversSame(known, child) && !isStale_[index]) {
        isStale_[index] = true;
        stale_.push_back(uint32_t(index));
    }
    special_ += size_t(isSpecial(child)) - size_t(isSpecial(known));
    const bool isSame = known.handle == child.handle &&
                        std::memcmp(&known.instance, &child.instance, sizeof child.instance) == 0;
    known = child;
    if (isSame)
        return;
    write(index);
    if (index < descriptions_.size()) // an update of all children writes their records, too
        descriptions_[index] = child.instance;
}

// Writes the record of a child in the structure; a missing child becomes a hidden record.
void InstanceStructure::write(size_t index) {
    if (handle_ == 0 || index >= built_)
        return;
    auto& record = reinterpret_cast<devlib::InstanceRecord*>(static_cast<uint8_t*>(memory_.get()) +
                                                             instancesOffset_)[index];
    if (index >= children_.size()) {
        record.visibilityMask = 0;
        return;
    }
    const Child& child = children_[index];
    record.child = child.handle;
    record.sbtOffset = child.instance.sbtOffset;
    record.visibilityMask = child.instance.visibilityMask;
    record.flags = child.instance.flags;
    std::copy_n(child.instance.transform, 12, record.objectToWorld);
    math::invert(record.objectToWorld, record.worldToObject);
}

// GPU builders read memory shared with the host, CPU builders the list itself.
bvh::InstanceInput InstanceStructure::input(const Context& context) const {
    bvh::InstanceInput in;
    in.numInstances = uint32_t(children_.size());
    in.instances = context.isOnGpu() ? static_cast<const void*>(descriptions_.data())
                                     : static_cast<const void*>(children_.data());
    static_assert(offsetof(Child, instance) == 0);
    in.stride = context.isOnGpu() ? sizeof(bvh::InstanceDesc) : sizeof(Child);
    return in;
}

void InstanceStructure::update(Context& context, bool refitsAll) {
    const bool isNew = handle_ == 0 || built_ != children_.size();
    if (!isNew && stale_.empty())
        return;
    const TimedReport timed(context);
    const bool isUpdate = !isNew && refit(context, refitsAll);
    if (!isUpdate)
        build(context);
    for (const uint32_t i : stale_)
        isStale_[i] = false;
    stale_.clear();
    version_ = ++context.lastVersion;
    // Builders write the handles of the descriptions; special children have others.
    for (size_t i = 0; special_ != 0 && i < children_.size(); ++i)
        if (isSpecial(children_[i]))
            write(i);
    timed.tell(isUpdate ? kReportLaunches : kReportStatistics, "ACCEL",
               isUpdate ? "an update of " : "a build of ", children_.size(), " instances and ",
               memory_.size(), " bytes");
}

bool InstanceStructure::refit(Context& context, bool refitsAll) {
    const bool isFew = stale_.size() <= children_.size() / kMostChanged;
    if (!isFew && !refitsAll)
        return false;
    moved_ += stale_.size();
    if (context.isOnGpu()) {
        if (!refitsAll && moved_ > children_.size())
            return false;
        refitAll(context);
        return true;
    }
    paths_.refit(memory_.get(), input(context), stale_);
    return refitsAll || paths_.degradation() <= kMostDegraded;
}

void InstanceStructure::refitAll(Context& context) {
    engine::AccelInputs inputs;
    inputs.instances = std::make_unique<bvh::InstanceInput>(input(context));
    engine::AccelBuild request;
    request.inputs = std::make_shared<const engine::AccelInputs>(std::move(inputs));
    request.options = buildOptions();
    const bvh::MemoryUsage usage =
        engine::accelMemory(*context.engine, *request.inputs, request.options);
    if (scratch_.size() < usage.tempUpdate)
        scratch_ = SharedMemory(context.engine->backend, usage.tempUpdate);
    request.temp = scratch_.get();
    request.tempSize = scratch_.size();
    request.output = memory_.get();
    request.outputSize = memory_.size();
    request.update = true;
    engine::buildAccel(context.engine, std::move(request));
    context.engine->device->synchronize(nullptr);
}

void InstanceStructure::build(Context& context) {
    if (context.isOnGpu()) {
        descriptions_.clear();
        for (const Child& child : children_)
            descriptions_.push_back(child.instance);
    }
    engine::AccelInputs inputs;
    inputs.instances = std::make_unique<bvh::InstanceInput>(input(context));
    engine::AccelBuild request;
    request.inputs = std::make_shared<const engine::AccelInputs>(std::move(inputs));
    request.options = buildOptions();
    const bvh::MemoryUsage usage =
        engine::accelMemory(*context.engine, *request.inputs, request.options);
    SharedMemory output(context.engine->backend, usage.output),
        temp(context.engine->backend, usage.temp);
    request.temp = temp.get();
    request.tempSize = temp.size();
    request.output = output.get();
    request.outputSize = output.size();
    handle_ = 0;
    const uint64_t handle = engine::buildAccel(context.engine, std::move(request));
    context.engine->device->synchronize(nullptr);
    memory_ = std::move(output);
    instancesOffset_ = static_cast<const bvh::BlockHeader*>(memory_.get())->instancesOffset;
    built_ = children_.size();
    moved_ = 0;
    if (!context.isOnGpu())
        paths_ = bvh::InstancePaths(memory_.get());
    handle_ = handle;
}

} // namespace sunstone::optix6
