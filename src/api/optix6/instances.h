// SPDX-License-Identifier: Apache-2.0
// An instance acceleration structure that follows its children. Instance records change at once;
// boxes wait for the next update. An update refits the children that have changed while they are
// few and the tree stays good; otherwise it rebuilds the structure.
#pragma once

#include "api/optix6/memory.h"
#include "bvh/refit/instance_paths.h"

#include <span>

namespace sunstone::optix6 {

class Context;

// A node in the structure of its parent. Rays enter `handle`. It equals the handle of the
// description except for selectors, whose description has the bounds of all their children.
struct Child {
    bvh::InstanceDesc instance;
    uint64_t handle;
    uint64_t version; // of the structure behind the handle: changes with its bounds
};

class InstanceStructure {
public:
    explicit InstanceStructure(const std::shared_ptr<engine::Backend>& backend)
        : descriptions_(SharedAllocator<bvh::InstanceDesc>(backend)) {}

    uint64_t handle() const { return handle_; } // 0: nothing was built
    uint64_t version() const { return version_; }

    // Sets all children. Those beyond the structure's size appear with the next update.
    void show(const std::vector<Child>& children);
    // Sets the existing children from number `first` on.
    void show(size_t first, std::span<const Child> children);
    // `refitsAll`: prefers an update of all children to a build.
    void update(Context& context, bool refitsAll);

private:
    void showOne(size_t index, const Child& child);
    void write(size_t index);
    void build(Context& context);
    bool refit(Context& context, bool refitsAll);
    void refitAll(Context& context);
    bvh::InstanceInput input(const Context& context) const;

    std::vector<Child> children_;
    std::vector<uint32_t> stale_; // children whose boxes are outdated
    std::vector<bool> isStale_;
    SharedVector<bvh::InstanceDesc> descriptions_; // of the children, if the host's are foreign
    SharedMemory memory_, scratch_;
    uint64_t handle_ = 0, version_ = 0, instancesOffset_ = 0;
    size_t built_ = 0;   // children of the structure
    size_t moved_ = 0;   // children updated since it was built
    size_t special_ = 0; // children whose handle differs from their description's
    bvh::InstancePaths paths_;
};

} // namespace sunstone::optix6
